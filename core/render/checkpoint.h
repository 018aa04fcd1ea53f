// What a render has found so far, as a file: to go on later, or to be joined with renders of the same frame from
// elsewhere.
//
// Passes are means over samples, so two renders of one frame with different seeds are one render, weighed by their
// samples; each is an unbiased (or consistent) estimate by itself, and so is their mean. A resumed render goes on with
// a seed of its own. A file is written beside its final name and then moved there: what is interrupted leaves the one
// before.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace ajar {

struct Checkpoint {
  std::array<int, 2> frame{0, 0};         ///< pixels of the full frame
  std::array<int, 4> region{0, 0, 0, 0};  ///< x0, y0, x1, y1 of what is rendered
  float exposure = 1.0f;
  uint64_t scene = 0;           ///< fingerprint (archive.h) of what was rendered; 0: not known
  std::vector<uint32_t> seeds;  ///< of every render that went in
  std::vector<std::string> integrators;
  double samples = 0.0, seconds = 0.0;  ///< samples per pixel, mean
  uint64_t rays = 0, refused = 0;
  double relmse = -1.0;                              ///< estimated; negative: not known
  std::map<std::string, std::vector<float>> passes;  ///< rows from the bottom up, as Film::resolve gives them
};

/// Throws SceneError that names the file.
void save_checkpoint(const Checkpoint& checkpoint, const std::string& path);
Checkpoint load_checkpoint(const std::string& path);

/// Why the two cannot be one picture, in words; empty when they can.
std::string reason_against_merging(const Checkpoint& a, const Checkpoint& b);
/// Both as one. Passes that one of them lacks are left out. Throws SceneError with the reason.
Checkpoint merge(const Checkpoint& a, const Checkpoint& b);
/// One pass of two renders with so many samples.
std::vector<float> merge_pass(const std::string& pass, const std::vector<float>& a, double samples_a,
                              const std::vector<float>& b, double samples_b);

}  // namespace ajar
