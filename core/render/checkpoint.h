// The result of a render so far, as a file: to continue it later, or to merge it with other renders of the same frame.
//
// Passes are means over samples. Two renders of one frame with different seeds are therefore one render, weighted by
// their samples. Each is an unbiased (or consistent) estimate by itself, and so is their mean. A resumed render
// continues with its own seed. A file is written beside its final name and then renamed, so that an interruption leaves
// the previous file.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace ajar {

struct Checkpoint {
  std::array<int, 2> frame{0, 0};         ///< pixels of the full frame
  std::array<int, 4> region{0, 0, 0, 0};  ///< x0, y0, x1, y1 of the rendered region
  float exposure = 1.0f;
  uint64_t scene = 0;           ///< fingerprint (archive.h) of the rendered scene; 0: unknown
  std::vector<uint32_t> seeds;  ///< of all renders that are included
  std::vector<std::string> integrators;
  double samples = 0.0, seconds = 0.0;  ///< samples per pixel, mean
  uint64_t rays = 0, refused = 0;
  double relmse = -1.0;                              ///< estimated; negative: unknown
  std::map<std::string, std::vector<float>> passes;  ///< rows from the bottom up, as in Film::resolve
};

/// Throws SceneError with the name of the file.
void save_checkpoint(const Checkpoint& checkpoint, const std::string& path);
Checkpoint load_checkpoint(const std::string& path);

/// The reason why two renders cannot be merged, as text; empty if they can.
std::string reason_against_merging(const Checkpoint& a, const Checkpoint& b);
/// Both renders as one. Passes that one of them lacks are left out. Throws SceneError if they cannot be merged.
Checkpoint merge(const Checkpoint& a, const Checkpoint& b);
/// A pass of Cryptomatte that both renders have, merged by the ids of mattes.
std::vector<float> merge_matte(const std::string& pass, const Checkpoint& a, const Checkpoint& b);
/// Another pass of two renders, merged by their numbers of samples.
std::vector<float> merge_pass(const std::string& pass, const std::vector<float>& a, double samples_a,
                              const std::vector<float>& b, double samples_b);

}  // namespace ajar
