// How a path tracer learns and follows a guide: what is written down, when it is learned, and whether it is followed at
// all.
//
// Learns after 1, 2, 4, 8 ... samples of each pixel, from the latter half of them, and stands still in between: every
// sample is unbiased given the past, and all count alike, so their mean is unbiased. (No light is thrown away; the
// first few samples, not yet guided, are noisier.) Learning ends when an iteration had as many paths as cells need, and
// 16 samples of each pixel were learned from. Of large pictures only some paths are written down: about 2.5 million
// vertices in an iteration, 320 MB while it is learned from; a cell takes about half a KB.
//
// `Auto` measures first: samples 0 to 3 of each pixel by the BSDF alone, then guided ones. It compares variance times
// cost of 0 to 3 with 4 to 7 and, when the guide has learned more, with 12 to 15, and gives the guide up where it does
// not clearly pay. Variances are summed over blocks of 16 by 16 pixels and compared block by block as logarithms, since
// a few fireflies would outweigh all else; cost is counted in rays, so that the decision, and with it the picture, does
// not depend on the clock. Cells where the BSDF finds the light by itself ask no guide in any case.
//
// A frame of an animation begins with the guide of the frame before and follows it from its first sample. It needs
// fewer lessons: after 16, 32 ... samples, and by all that is left when it ends. What `Auto` found holds for eight
// frames without being measured.
#pragma once

#include <memory>

#include "transport/guiding/guide_tree.h"

namespace ajar {

/// Directions by the BSDF alone: nothing of the guide is left in the path tracer's copy of the loop.
struct Unguided {
  static constexpr bool kGuided = false;
};
/// Directions by BSDF and guide. Where there is a list, what the path finds is written down for it.
struct Guided {
  static constexpr bool kGuided = true;
  /// Of whole paths that the BSDF alone chooses: none is drawn with less than this share of its density
  /// (guided_bsdf.h).
  static constexpr float kPlainShare = 0.25f;
  const GuideTree* tree = nullptr;
  std::vector<GuideSample>* samples = nullptr;
  uint32_t pixel = 0, index = 0;  ///< of the sample
};
/// A vertex whose light is still to come.
struct OpenVertex {
  GuideSample sample;
  Color before;  ///< found by the path until here
  float beta;    ///< luminance of the throughput that arrived
};
constexpr int kMaxOpenVertices = 24;

class PathGuide {
 public:
  enum class Mode : uint8_t { On, Auto };
  /// While it measures, all pixels must have the same number of samples: this many.
  static constexpr uint32_t kEqualSamples = 16;
  /// What another frame may begin with.
  struct Past {
    GuideTree tree;
    double vertices_per_path;
    bool pays;     ///< if that has been measured
    uint32_t age;  ///< frames that relied on it
  };
  static constexpr uint32_t kMaxAge = 8;

  /// For a film of this size, rendered in square tiles: what a tile's samples found is written down by one thread.
  PathGuide(Mode mode, int width, int height, int tile, const Past* past = nullptr);
  /// When the frame is done. Null when too few samples were rendered to know anything.
  std::shared_ptr<const Past> past();

  /// Before sample `done` of each pixel: learn and decide if it is time. Returns how many of the `wanted` samples may
  /// follow before this is called again. `rays` were traced so far.
  int begin(uint32_t done, int wanted, uint64_t rays);
  bool learning() const { return learning_; }
  bool follows() const { return follows_; }
  /// Whether anything is left to do for it.
  bool active() const { return learning_ || follows_; }
  /// For sample `index` of the film's pixel (x, y), whose number in the frame is `pixel`.
  Guided of_sample(int x, int y, uint32_t pixel, uint32_t index) {
    return {follows_ ? &tree_ : nullptr,
            learning_ && records(pixel, index)
                ? &tile_samples_[size_t(y / tile_) * size_t(columns_) + size_t(x / tile_)]
                : nullptr,
            pixel, index};
  }
  /// What the sample brought, exposed.
  void measure(int x, int y, Color radiance) {
    if (phase_ >= 0) moments_[size_t(phase_)][size_t(y) * size_t(width_) + size_t(x)].add(luminance(radiance));
  }
  const GuideTree& tree() const { return tree_; }
  /// The most it has taken: while it learned.
  size_t max_bytes() const { return max_bytes_; }
  /// About what it takes at most for a render of so many samples of each pixel.
  static uint64_t estimated_bytes(uint64_t pixels, uint64_t samples);
  /// How many times variance times cost was lower with the guide, when last measured; 0 before.
  double measured_gain() const { return gain_; }

 private:
  struct Moments {
    float sum = 0.0f, square = 0.0f;
    void add(float y) {
      sum += y;
      square += y * y;
    }
  };
  void learn(float past_share);
  /// Whether a path shall be written down: one in so many, where all would be too many.
  bool records(uint32_t pixel, uint32_t index) const;
  double gain(uint64_t rays_guided) const;

  bool measures_, measured_ = false;  ///< whether following pays; else it is known
  int width_, pixels_, tile_, columns_;
  bool learning_ = true, follows_ = false, starts_warm_ = false;
  uint32_t age_ = 0, first_training_ = 1;  ///< frames; samples
  uint32_t keep_ = ~0u;                    ///< hashes up to this are written down
  uint64_t paths_ = 0;                     ///< of the iteration under way
  double vertices_per_path_ = 4.0;         ///< written down, of the iteration before
  int phase_ = -1;                         ///< 0: without, 1: with the guide
  uint64_t rays_at_start_ = 0, rays_without_ = 0;
  double gain_ = 0.0;
  size_t max_bytes_ = 0;
  GuideTree tree_;
  std::vector<std::vector<GuideSample>> tile_samples_;
  std::vector<Moments> moments_[2];
};

}  // namespace ajar
