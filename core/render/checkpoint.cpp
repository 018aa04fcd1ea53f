#include "render/checkpoint.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>

#include <nlohmann/json.hpp>

#include "film/film.h"
#include "platform/atomic_file.h"
#include "platform/platform.h"
#include "scene/scene.h"

namespace ajar {

namespace {

constexpr uint64_t kMostPlanes = 64;  // of a table
constexpr char kMagic[8] = {'A', 'J', 'A', 'R', 'C', 'H', 'P', '3'};
constexpr uint64_t kLongestHeader = 1 << 20;
#ifdef AJAR_FUZZING
constexpr bool kChecked = false;  // so that a fuzzer gets beyond the checksums
#else
constexpr bool kChecked = true;
#endif

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw SceneError("The checkpoint \"" + path + "\" " + why + ".");
}

size_t pixels_of(const Checkpoint& c) { return size_t(c.region[2] - c.region[0]) * size_t(c.region[3] - c.region[1]); }

double merged_relmse(const Checkpoint& a, const Checkpoint& b) {
  if (a.relmse < 0.0 || b.relmse < 0.0) return std::max(a.relmse, b.relmse);
  const double total = a.samples + b.samples, wa = a.samples / total, wb = b.samples / total;
  return wa * wa * a.relmse + wb * wb * b.relmse;
}

/// The blocks of a file after its header. `Bytes` is const for writing.
template <class Bytes, class Value>
std::span<Bytes> bytes_of(Value& values) {
  return {reinterpret_cast<Bytes*>(values.data()), values.size() * sizeof(values[0])};
}

/// The low parts of sums that are not zero, and their numbers. Few are, except those of squares.
struct Rests {
  std::vector<uint64_t> numbers;
  std::vector<double> values;
};

Rests rests_of(const FilmSums::Table& table) {
  Rests rests;
  for (size_t i = 0; i < table.low.size(); ++i)
    if (table.low[i] != 0.0) rests.numbers.push_back(i), rests.values.push_back(table.low[i]);
  return rests;
}

nlohmann::json header_of(const Checkpoint& c, const std::array<Rests, FilmSums::kWidths.size()>& rests) {
  nlohmann::json header{{"frame", c.frame},
                        {"region", c.region},
                        {"exposure", c.exposure},
                        {"view_exposure", c.view_exposure},
                        {"scene", c.scene},
                        {"view", c.view},
                        {"seeds", c.seeds},
                        {"integrators", c.integrators},
                        {"samples", c.samples},
                        {"seconds", c.seconds},
                        {"rays", c.rays},
                        {"refused", c.refused},
                        {"relmse", c.relmse},
                        {"version", c.version},
                        {"ranges", nlohmann::json::array()},
                        {"passes", nlohmann::json::array()}};
  for (const SampleRange& range : c.ranges) header["ranges"].push_back({range.seed, range.first, range.end});
  for (const auto& [name, values] : c.passes) header["passes"].push_back(name);
  if (c.sums.pixels == 0) return header;
  nlohmann::json& sums = header["sums"] = {{"firsts", !c.sums.firsts.empty()}, {"tables", nlohmann::json::array()}};
  for (size_t k = 0; k < rests.size(); ++k)
    sums["tables"].push_back(
        {c.sums.tables[k].high.size() / (FilmSums::kWidths[k] * c.sums.pixels), rests[k].numbers.size()});
  return header;
}

std::vector<std::span<const char>> blocks_of(const Checkpoint& c,
                                             const std::array<Rests, FilmSums::kWidths.size()>& rests) {
  std::vector<std::span<const char>> blocks;
  for (const auto& [name, values] : c.passes) blocks.push_back(bytes_of<const char>(values));
  if (c.sums.pixels == 0) return blocks;
  blocks.push_back(bytes_of<const char>(c.sums.counts));
  blocks.push_back(bytes_of<const char>(c.sums.firsts));
  for (size_t k = 0; k < rests.size(); ++k) {
    blocks.push_back(bytes_of<const char>(c.sums.tables[k].high));
    blocks.push_back(bytes_of<const char>(rests[k].numbers));
    blocks.push_back(bytes_of<const char>(rests[k].values));
  }
  return blocks;
}

/// A checkpoint while it is read.
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path), file_(platform::file_path(path), std::ios::binary) {
    if (!file_) fail(path_, "cannot be read");
    std::error_code error;
    left_ = std::filesystem::file_size(platform::file_path(path), error);
    if (error) fail(path_, "cannot be read");
  }

  Checkpoint read() {
    char magic[sizeof kMagic];
    uint64_t length = 0, checksum = 0;
    raw(magic, sizeof magic);
    if (!file_ || std::memcmp(magic, kMagic, sizeof kMagic - 1) != 0) fail(path_, "is not an Ajar checkpoint");
    if (magic[7] != kMagic[7]) fail(path_, "is of another version of Ajar");
    raw(&length, sizeof length);
    raw(&checksum, sizeof checksum);
    if (!file_ || length > kLongestHeader || length > left_) fail(path_, "is damaged: its header is incomplete");
    std::string text(length, '\0');
    raw(text.data(), length);
    Checksum of_header;
    of_header.add(text.data(), text.size());
    if (!file_ || (kChecked && of_header.value() != checksum))
      fail(path_, "is damaged: the checksum of its header is wrong");
    try {
      header(nlohmann::json::parse(text));
    } catch (const nlohmann::json::exception&) {
      fail(path_, "is damaged");
    }
    return std::move(c_);
  }

 private:
  void raw(void* to, uint64_t count) {
    if (count > left_) {
      file_.setstate(std::ios::failbit);
      return;
    }
    file_.read(static_cast<char*>(to), std::streamsize(count));
    left_ -= count;
  }

  /// Sizes are compared with the file before anything is allocated.
  template <class T>
  void block(std::vector<T>& values, uint64_t count) {
    if (count > left_ / sizeof(T)) fail(path_, "is damaged: it is too short");
    values.resize(count);
    raw(values.data(), count * sizeof(T));
    checksum_.add(values.data(), count * sizeof(T));
  }

  void header(const nlohmann::json& h) {
    h.at("frame").get_to(c_.frame);
    h.at("region").get_to(c_.region);
    h.at("exposure").get_to(c_.exposure);
    c_.view_exposure = h.value("view_exposure", 1.0f);
    h.at("scene").get_to(c_.scene);
    h.at("view").get_to(c_.view);
    h.at("seeds").get_to(c_.seeds);
    h.at("integrators").get_to(c_.integrators);
    h.at("samples").get_to(c_.samples);
    h.at("seconds").get_to(c_.seconds);
    h.at("rays").get_to(c_.rays);
    h.at("refused").get_to(c_.refused);
    h.at("relmse").get_to(c_.relmse);
    h.at("version").get_to(c_.version);
    for (const auto& range : h.at("ranges"))
      c_.ranges.push_back({range.at(0).get<uint32_t>(), range.at(1).get<uint32_t>(), range.at(2).get<uint32_t>()});
    const auto& r = c_.region;
    if (!(r[0] >= 0 && r[1] >= 0 && r[2] > r[0] && r[3] > r[1] && r[2] <= c_.frame[0] && r[3] <= c_.frame[1] &&
          c_.samples > 0.0 && std::isfinite(c_.samples)))
      fail(path_, "is damaged");
    if (pixels_of(c_) > left_) fail(path_, "is damaged: it is too short");
    for (const std::string name : h.at("passes")) {
      if (channels_of_pass(name) == 0) fail(path_, "holds an unknown pass \"" + name + "\"");
      block(c_.passes[name], uint64_t(channels_of_pass(name)) * pixels_of(c_));
    }
    if (h.contains("sums")) sums(h.at("sums"));
    if (left_ != sizeof(uint64_t)) fail(path_, "is damaged: it is too long");
    uint64_t stored = 0;
    raw(&stored, sizeof stored);
    if (!file_ || (kChecked && stored != checksum_.value())) fail(path_, "is damaged: its checksum is wrong");
  }

  void sums(const nlohmann::json& h) {
    FilmSums& s = c_.sums;
    const uint64_t pixels = pixels_of(c_);
    block(s.counts, 2 * pixels);
    block(s.firsts, h.at("firsts").get<bool>() ? FilmSums::kFirsts * pixels : 0);
    for (size_t k = 0; k < s.tables.size(); ++k) {
      const nlohmann::json& of_table = h.at("tables").at(k);
      FilmSums::Table& table = s.tables[k];
      table.width = FilmSums::kWidths[k];
      // A film has a table of splats for each pass that separates light.
      const auto planes = of_table.at(0).get<uint64_t>();
      if (planes > kMostPlanes) fail(path_, "is damaged");
      block(table.high, planes * table.width * pixels);
      Rests rests;
      block(rests.numbers, of_table.at(1).get<uint64_t>());
      block(rests.values, of_table.at(1).get<uint64_t>());
      table.low.resize(table.high.size());
      for (size_t i = 0; i < rests.numbers.size(); ++i) {
        if (rests.numbers[i] >= table.low.size()) fail(path_, "is damaged");
        table.low[rests.numbers[i]] = rests.values[i];
      }
    }
    s.pixels = pixels;
  }

  std::string path_;
  std::ifstream file_;
  uint64_t left_ = 0;
  Checksum checksum_;
  Checkpoint c_;
};

/// The passes of the sums.
void resolve_sums(Checkpoint& c) {
  std::vector<std::string> names;
  for (const auto& [name, values] : c.passes) names.push_back(name);
  Film film(c.region[0], c.region[1], c.region[2], c.region[3], names);
  try {
    film.set_sums(c.sums);
  } catch (const std::invalid_argument& error) {
    throw SceneError(std::string("The sums of a checkpoint do not fit its passes: ") + error.what() + ".");
  }
  film.set_shown_exposure(double(c.exposure * c.view_exposure));
  for (auto& [name, values] : c.passes) values = film.resolve(name, c.exposure);
  c.samples = film.sample_counts().mean;
  c.relmse = film.estimated_relmse();
}

/// Ranges in order; neighbours become one.
std::vector<SampleRange> joined(std::vector<SampleRange> ranges) {
  std::sort(ranges.begin(), ranges.end(), [](const SampleRange& a, const SampleRange& b) {
    return std::pair(a.seed, a.first) < std::pair(b.seed, b.first);
  });
  std::vector<SampleRange> result;
  for (const SampleRange& range : ranges)
    if (!result.empty() && result.back().seed == range.seed && result.back().end == range.first)
      result.back().end = range.end;
    else
      result.push_back(range);
  return result;
}

/// Whether a seed is in a render by ranges alone.
bool has_ranges(const Checkpoint& c, uint32_t seed) {
  return std::any_of(c.ranges.begin(), c.ranges.end(), [&](const SampleRange& r) { return r.seed == seed; });
}

std::string overlap(const Checkpoint& a, const Checkpoint& b) {
  for (const uint32_t seed : a.seeds)
    if (std::find(b.seeds.begin(), b.seeds.end(), seed) != b.seeds.end() &&
        !(has_ranges(a, seed) && has_ranges(b, seed)))
      return "both contain the samples of seed " + std::to_string(seed);
  for (const SampleRange& r : a.ranges)
    for (const SampleRange& q : b.ranges)
      if (r.seed == q.seed && r.first < q.end && q.first < r.end)
        return "both contain sample " + std::to_string(std::max(r.first, q.first)) + " of seed " +
               std::to_string(r.seed);
  return "";
}

/// Everything of `b` but its image.
void add_description(Checkpoint& c, const Checkpoint& b) {
  for (const uint32_t seed : b.seeds)
    if (std::find(c.seeds.begin(), c.seeds.end(), seed) == c.seeds.end()) c.seeds.push_back(seed);
  c.ranges.insert(c.ranges.end(), b.ranges.begin(), b.ranges.end());
  c.ranges = joined(std::move(c.ranges));
  for (const std::string& integrator : b.integrators)
    if (std::find(c.integrators.begin(), c.integrators.end(), integrator) == c.integrators.end())
      c.integrators.push_back(integrator);
  if (c.scene == 0) c.scene = b.scene;
  if (c.view == 0) c.view = b.view;
  c.samples += b.samples;
  c.seconds += b.seconds;
  c.rays += b.rays;
  c.refused += b.refused;
}

}  // namespace

void save_checkpoint(const Checkpoint& c, const std::string& path) {
  std::array<Rests, FilmSums::kWidths.size()> rests;
  for (size_t k = 0; k < rests.size(); ++k) rests[k] = rests_of(c.sums.tables[k]);
  const std::string text = header_of(c, rests).dump();
  const uint64_t length = text.size();
  Checksum of_header, of_data;
  of_header.add(text.data(), text.size());
  const uint64_t header_sum = of_header.value();
  AtomicFile file(path);
  file.write(kMagic, sizeof kMagic);
  file.write(&length, sizeof length);
  file.write(&header_sum, sizeof header_sum);
  file.write(text.data(), text.size());
  for (const auto& block : blocks_of(c, rests)) {
    file.write(block.data(), block.size());
    of_data.add(block.data(), block.size());
  }
  const uint64_t data_sum = of_data.value();
  file.write(&data_sum, sizeof data_sum);
  if (const std::string why = file.commit(); !why.empty()) fail(path, "could not be written: " + why);
}

Checkpoint load_checkpoint(const std::string& path) { return Reader(path).read(); }

std::string reason_against_merging(const Checkpoint& a, const Checkpoint& b) {
  const auto size = [](const Checkpoint& c) {
    return std::to_string(c.region[2] - c.region[0]) + " x " + std::to_string(c.region[3] - c.region[1]) +
           " pixels of a frame of " + std::to_string(c.frame[0]) + " x " + std::to_string(c.frame[1]);
  };
  if (a.frame != b.frame || a.region != b.region) return "one has " + size(a) + ", the other " + size(b);
  if (a.exposure != b.exposure) return "their exposures differ";
  if (a.scene != 0 && b.scene != 0 && a.scene != b.scene) return "they are of different scenes or frames";
  if (a.version != b.version) return "one is of version " + a.version + " of Ajar, the other of " + b.version;
  if (a.view != 0 && b.view != 0 && a.view != b.view) return "their cameras or settings differ";
  return overlap(a, b);
}

std::string reason_against_adding(const Checkpoint& a, const Checkpoint& b) {
  if (a.sums.pixels == 0 || b.sums.pixels == 0) return "a render has no sums";
  if (a.integrators != b.integrators) return "the renders used different techniques";
  if (!a.sums.has_same_form(b.sums)) return "the renders have different passes";
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

/// The means of both images, by their samples.
static void merge_means(Checkpoint& c, const Checkpoint& b) {
  const Checkpoint a = std::move(c);
  c = Checkpoint();
  c.frame = a.frame, c.region = a.region, c.exposure = a.exposure, c.view_exposure = a.view_exposure,
  c.version = a.version;
  c.passes.clear();
  for (const auto& [name, values] : a.passes)
    if (const auto other = b.passes.find(name); other != b.passes.end())
      c.passes[name] = matte_pass(name) ? std::vector<float>()
                                        : merge_pass(name, values, a.samples, other->second, b.samples);
  for (auto& [name, values] : c.passes)
    if (matte_pass(name)) values = merge_matte(name, a, b);
  add_description(c, a);
  add_description(c, b);
  c.relmse = merged_relmse(a, b);
}

void CheckpointMerger::add(Checkpoint more) {
  if (count_ == 0) {
    all_ = std::move(more);
    if (all_.sums.pixels == 0) why_not_exact_ = "a render has no sums";
    ++count_;
    return;
  }
  if (const std::string why = reason_against_merging(all_, more); !why.empty())
    throw SceneError("These renders cannot be merged: " + why + ".");
  const std::string why_not_exact = reason_against_adding(all_, more);
  if (why_not_exact.empty()) {
    // Values of the first sample are those of the lowest number.
    if (!all_.ranges.empty() && !more.ranges.empty() && more.ranges[0].first < all_.ranges[0].first)
      std::swap(all_.sums.firsts, more.sums.firsts);
    all_.sums.add(more.sums);
    add_description(all_, more);
    stale_ = true;
  } else {
    if (why_not_exact_.empty()) why_not_exact_ = why_not_exact;
    if (stale_) resolve_sums(all_);
    stale_ = false;
    merge_means(all_, more);
  }
  ++count_;
}

Checkpoint CheckpointMerger::finish() {
  if (stale_) resolve_sums(all_);
  stale_ = false;
  return std::move(all_);
}

Checkpoint merge(const Checkpoint& a, const Checkpoint& b) {
  CheckpointMerger merger;
  merger.add(a);
  merger.add(b);
  return merger.finish();
}

}  // namespace ajar
