// Interprets arbitrary bytes as a checkpoint. The file is refused with a message, or it is merged with another one of the same form and written again. Checksums are
// not compared in this build, because they would stop nearly all inputs.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "film/film.h"
#include "render/checkpoint.h"
#include "scene/scene.h"

using namespace ajar;

namespace {

const std::string& folder() {
  static const std::string path = [] {
    const std::filesystem::path shared = "/dev/shm";
    const auto made = (std::filesystem::exists(shared) ? shared : std::filesystem::temp_directory_path()) /
                      ("ajar_fuzz_" + std::to_string(::getpid()));
    std::filesystem::create_directories(made);
    return made.string();
  }();
  return path;
}

void write(const std::string& path, const uint8_t* data, size_t size) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (file == nullptr || std::fwrite(data, 1, size, file) != size) std::abort();
  std::fclose(file);
}

/// A valid file of 2 x 2 pixels, from which the fuzzer starts.
void write_seed(const std::string& path, bool with_sums) {
  const std::vector<std::string> passes{"Combined", "Depth", "Sample Count", "Variance"};
  Film film(0, 0, 2, 2, passes);
  if (with_sums) film.keep_exact_sums();
  SampleAux aux;
  for (int k = 0; k < 12; ++k) film.add_sample(k & 1, k >> 1 & 1, Color(0.1f * float(k)), 1.0f, &aux);
  Checkpoint c;
  c.frame = {2, 2};
  c.region = {0, 0, 2, 2};
  c.seeds = {3};
  c.integrators = {"path"};
  c.samples = 3.0;
  if (with_sums) c.ranges = {{3, 0, 3}};
  for (const std::string& pass : passes) c.passes[pass] = film.resolve(pass, 1.0f);
  c.sums = film.sums();
  save_checkpoint(c, path);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  for (int k = 1; k < *count; ++k)
    if ((*arguments)[k][0] != '-' && std::filesystem::is_directory((*arguments)[k]))
      for (const bool with_sums : {false, true})
        write_seed(std::string((*arguments)[k]) + (with_sums ? "/range" : "/image"), with_sums);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string path = folder() + "/input", copy = folder() + "/copy";
  write(path, data, size);
  try {
    const Checkpoint c = load_checkpoint(path);
    save_checkpoint(c, copy);
    if (load_checkpoint(copy).passes.size() != c.passes.size()) std::abort();
    Checkpoint other = c;
    for (uint32_t& seed : other.seeds) seed ^= 0x80000000u;
    for (SampleRange& range : other.ranges) range.seed ^= 0x80000000u;
    CheckpointMerger merger;
    merger.add(c);
    merger.add(other);
    save_checkpoint(merger.finish(), copy);
  } catch (const SceneError&) {
  }
  return 0;
}
