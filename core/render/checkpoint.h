// The result of a render so far, as a file: to continue it later, or to merge it with other renders of the same frame.
//
// Passes are means over samples. Two renders of one frame with different seeds are therefore one render, weighted by
// their samples. Each is an unbiased (or consistent) estimate by itself, and so is their mean. A resumed render
// continues with its own seed.
//
// A render of a range of samples (Session::begin_at) keeps the sums of its film as well. Ranges of one seed are merged by
// adding sums without a rounding error (film/film_sums.h), so the image is that of one render with all samples, bit for
// bit, and a render that is continued is the one that was not interrupted.
//
// A file has checksums of its header and of its data, and appears under its name only when it is complete.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "film/film_sums.h"

namespace ajar {

/// Samples [first, end) of each pixel with a seed. If a time limit has ended the render, some pixels have one sample less.
struct SampleRange {
  uint32_t seed = 0, first = 0, end = 0;
  bool operator==(const SampleRange&) const = default;
};

struct Checkpoint {
  std::array<int, 2> frame{0, 0};         ///< pixels of the full frame
  std::array<int, 4> region{0, 0, 0, 0};  ///< x0, y0, x1, y1 of the rendered region
  float exposure = 1.0f, view_exposure = 1.0f;
  uint64_t scene = 0;  ///< fingerprint (archive.h) of the rendered scene; 0: unknown
  uint64_t view = 0;   ///< fingerprint of the camera and of the settings that define the image; 0: unknown
  std::string version = AJAR_VERSION;
  std::vector<uint32_t> seeds;      ///< of all renders that are included
  std::vector<SampleRange> ranges;  ///< of renders of a range of samples; other renders have all samples of their seed
  std::vector<std::string> integrators;
  double samples = 0.0, seconds = 0.0;  ///< samples per pixel, mean
  uint64_t rays = 0, refused = 0;
  double relmse = -1.0;                              ///< estimated; negative: unknown
  std::map<std::string, std::vector<float>> passes;  ///< rows from the bottom up, as in Film::resolve
  FilmSums sums;                                     ///< of a render of ranges of samples; without pixels: unknown
};

/// Throws SceneError with the name of the file.
void save_checkpoint(const Checkpoint& checkpoint, const std::string& path);
Checkpoint load_checkpoint(const std::string& path);

/// Why two renders cannot be merged by their sums, as text; empty if they can.
std::string reason_against_adding(const Checkpoint& a, const Checkpoint& b);
/// Adds renders one after another, in the memory of two of them.
class CheckpointMerger {
 public:
  /// Throws SceneError, and changes nothing, if the render cannot be merged with those before it.
  void add(Checkpoint more);
  bool empty() const { return count_ == 0; }
  /// Why the merged image is the mean of images and not that of added sums; empty: it is the latter.
  const std::string& why_not_exact() const { return why_not_exact_; }
  Checkpoint finish();

 private:
  Checkpoint all_;
  size_t count_ = 0;
  bool stale_ = false;  ///< the passes are not those of the sums
  std::string why_not_exact_;
};

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
