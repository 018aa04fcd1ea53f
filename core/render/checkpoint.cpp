#include "render/checkpoint.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "film/film.h"
#include "scene/scene.h"

namespace ajar {

namespace {

constexpr char kMagic[8] = {'A', 'J', 'A', 'R', 'C', 'H', 'P', '1'};
constexpr uint64_t kLongestHeader = 1 << 20;

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw SceneError("The checkpoint \"" + path + "\" " + why + ".");
}

size_t pixels_of(const Checkpoint& c) { return size_t(c.region[2] - c.region[0]) * size_t(c.region[3] - c.region[1]); }

double merged_relmse(const Checkpoint& a, const Checkpoint& b) {
  if (a.relmse < 0.0 || b.relmse < 0.0) return std::max(a.relmse, b.relmse);
  const double total = a.samples + b.samples, wa = a.samples / total, wb = b.samples / total;
  return wa * wa * a.relmse + wb * wb * b.relmse;
}

}  // namespace

void save_checkpoint(const Checkpoint& c, const std::string& path) {
  nlohmann::json header{{"frame", c.frame},
                        {"region", c.region},
                        {"exposure", c.exposure},
                        {"scene", c.scene},
                        {"seeds", c.seeds},
                        {"integrators", c.integrators},
                        {"samples", c.samples},
                        {"seconds", c.seconds},
                        {"rays", c.rays},
                        {"refused", c.refused},
                        {"relmse", c.relmse},
                        {"version", AJAR_VERSION},
                        {"passes", nlohmann::json::array()}};
  for (const auto& [name, values] : c.passes) header["passes"].push_back(name);
  const std::string text = header.dump();
  const uint64_t length = text.size();
  const std::string unfinished = path + ".part";
  std::ofstream file(unfinished, std::ios::binary);
  file.write(kMagic, sizeof kMagic);
  file.write(reinterpret_cast<const char*>(&length), sizeof length);
  file.write(text.data(), std::streamsize(length));
  for (const auto& [name, values] : c.passes)
    file.write(reinterpret_cast<const char*>(values.data()), std::streamsize(values.size() * sizeof(float)));
  file.close();
  if (!file) fail(path, "could not be written");
  std::error_code error;
  std::filesystem::rename(unfinished, path, error);
  if (error) fail(path, "could not be written: " + error.message());
}

Checkpoint load_checkpoint(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "cannot be read");
  char magic[sizeof kMagic];
  uint64_t length = 0;
  file.read(magic, sizeof magic);
  file.read(reinterpret_cast<char*>(&length), sizeof length);
  if (!file || std::memcmp(magic, kMagic, sizeof kMagic) != 0 || length > kLongestHeader)
    fail(path, "is not an Ajar checkpoint");
  std::string text(length, '\0');
  file.read(text.data(), std::streamsize(length));
  Checkpoint c;
  try {
    const auto header = nlohmann::json::parse(text);
    header.at("frame").get_to(c.frame);
    header.at("region").get_to(c.region);
    header.at("exposure").get_to(c.exposure);
    header.at("scene").get_to(c.scene);
    header.at("seeds").get_to(c.seeds);
    header.at("integrators").get_to(c.integrators);
    header.at("samples").get_to(c.samples);
    header.at("seconds").get_to(c.seconds);
    header.at("rays").get_to(c.rays);
    header.at("refused").get_to(c.refused);
    header.at("relmse").get_to(c.relmse);
    const auto& r = c.region;
    if (!(r[0] >= 0 && r[1] >= 0 && r[2] > r[0] && r[3] > r[1] && r[2] <= c.frame[0] && r[3] <= c.frame[1] &&
          c.samples > 0.0))
      fail(path, "is damaged");
    // Sizes are compared with the file before anything is allocated.
    const std::streamoff here = file.tellg();
    const auto left = std::filesystem::file_size(path) - uint64_t(here);
    uint64_t wanted = 0;
    for (const std::string name : header.at("passes")) {
      if (channels_of_pass(name) == 0) fail(path, "holds an unknown pass \"" + name + "\"");
      wanted += uint64_t(channels_of_pass(name)) * pixels_of(c) * sizeof(float);
    }
    if (wanted != left) fail(path, "is damaged");
    for (const std::string name : header.at("passes")) {
      std::vector<float>& values = c.passes[name];
      values.resize(size_t(channels_of_pass(name)) * pixels_of(c));
      file.read(reinterpret_cast<char*>(values.data()), std::streamsize(values.size() * sizeof(float)));
    }
  } catch (const nlohmann::json::exception&) {
    fail(path, "is damaged");
  }
  if (!file) fail(path, "is damaged");
  return c;
}

std::string reason_against_merging(const Checkpoint& a, const Checkpoint& b) {
  const auto size = [](const Checkpoint& c) {
    return std::to_string(c.region[2] - c.region[0]) + " x " + std::to_string(c.region[3] - c.region[1]) +
           " pixels of a frame of " + std::to_string(c.frame[0]) + " x " + std::to_string(c.frame[1]);
  };
  if (a.frame != b.frame || a.region != b.region) return "one has " + size(a) + ", the other " + size(b);
  if (a.exposure != b.exposure) return "their exposures differ";
  if (a.scene != 0 && b.scene != 0 && a.scene != b.scene) return "they are of different scenes or frames";
  for (uint32_t seed : a.seeds)
    if (std::find(b.seeds.begin(), b.seeds.end(), seed) != b.seeds.end())
      return "both contain the samples of seed " + std::to_string(seed);
  return "";
}

std::vector<float> merge_pass(const std::string& pass, const std::vector<float>& a, double samples_a,
                              const std::vector<float>& b, double samples_b) {
  if (a.size() != b.size()) throw SceneError("The sizes of the pass \"" + pass + "\" differ.");
  // Values of the first sample of a pixel stay those of the first render.
  if (pass == "Depth" || pass == "Position" || pass == "IndexOB" || pass == "IndexMA") return a;
  double wa = samples_a / (samples_a + samples_b), wb = 1.0 - wa;
  if (pass == "Sample Count") wa = wb = 1.0;
  if (pass == "Variance") wa *= wa, wb *= wb;  // variance of the mean of independent estimates
  std::vector<float> merged(a.size());
  for (size_t i = 0; i < a.size(); ++i) merged[i] = float(wa * double(a[i]) + wb * double(b[i]));
  return merged;
}

std::vector<float> merge_matte(const std::string& pass, const Checkpoint& a, const Checkpoint& b) {
  const MattePass matte = *matte_pass(pass);
  std::vector<const std::vector<float>*> of_a, of_b;
  size_t at = 0;
  for (const auto& [name, values] : a.passes) {
    const auto other = matte_pass(name), found = other && other->kind == matte.kind ? other : std::nullopt;
    if (!found || !b.passes.contains(name)) continue;
    if (name == pass) at = of_a.size();
    of_a.push_back(&values);
    of_b.push_back(&b.passes.at(name));
  }
  const double wa = a.samples / (a.samples + b.samples);
  return merge_mattes(of_a, wa, of_b, 1.0 - wa).at(at);
}

Checkpoint merge(const Checkpoint& a, const Checkpoint& b) {
  if (const std::string why = reason_against_merging(a, b); !why.empty())
    throw SceneError("These renders cannot be merged: " + why + ".");
  Checkpoint c = a;
  c.passes.clear();
  for (const auto& [name, values] : a.passes)
    if (const auto other = b.passes.find(name); other != b.passes.end())
      c.passes[name] = matte_pass(name) ? std::vector<float>()
                                        : merge_pass(name, values, a.samples, other->second, b.samples);
  for (auto& [name, values] : c.passes)
    if (matte_pass(name)) values = merge_matte(name, a, b);
  c.seeds.insert(c.seeds.end(), b.seeds.begin(), b.seeds.end());
  for (const std::string& integrator : b.integrators)
    if (std::find(c.integrators.begin(), c.integrators.end(), integrator) == c.integrators.end())
      c.integrators.push_back(integrator);
  if (c.scene == 0) c.scene = b.scene;
  c.samples += b.samples;
  c.seconds += b.seconds;
  c.rays += b.rays;
  c.refused += b.refused;
  c.relmse = merged_relmse(a, b);
  return c;
}

}  // namespace ajar
