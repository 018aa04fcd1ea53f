// How a path tracer trains and uses a guide: which samples are recorded, when the guide is trained, and whether it is
// used.
//
// The guide is trained after 1, 2, 4, 8 ... samples of each pixel, from the second half of these samples, and is
// constant in between. Every sample is unbiased given the past, and all have equal weight, so their mean is unbiased.
// (No sample is discarded; the first few, which are not guided, have more noise.) Training ends when an iteration had
// as many paths as cells need and 16 samples of each pixel were used for training. In large images only some of the
// paths are recorded: about 2.5 million vertices per iteration, which take 320 MB during training. A cell takes about
// half a KB.
//
// `Auto` measures first: samples 0 to 3 of each pixel use the BSDF alone, later samples are guided. Guided samples give
// both variances: that of themselves, and by importance sampling that of unguided samples (GuidedPath::Outcome), so that
// both variances contain the same rare bright paths. Their quotient, times that of the costs, is the gain. It is
// measured in samples 4 to 7 and, when the guide is better trained, in samples 12 to 15. The guide is abandoned unless
// it is clearly better. Variances are summed over blocks of 16 by 16 pixels. The logarithms of the sums are
// compared block by block, because otherwise a few fireflies would dominate. Cost is counted in rays, so that the
// decision, and with it the image, does not depend on the clock. Cells where the BSDF alone samples the light well do
// not use the guide in any case.
//
// A frame of an animation starts with the guide of the previous frame and uses it from its first sample. It needs fewer
// training steps: after 16, 32 ... samples, and a last one at its end with all remaining samples. The decision of
// `Auto` is valid for eight frames without a new measurement.
#pragma once

#include <cmath>
#include <memory>

#include "transport/guiding/guide_tree.h"
#include "transport/guiding/guided_bsdf.h"
#include "transport/guiding/guided_phase.h"

namespace ajar {

/// Directions by the BSDF alone. The loop of the path tracer is compiled without any code of the guide.
struct Unguided {
  static constexpr bool kGuided = false;
  struct Outcome {};
};
/// Directions by BSDF and guide. If there is a list, the samples of the path are recorded in it.
struct Guided {
  static constexpr bool kGuided = true;
  /// What a guided walk says about an unguided one. For both, the second moment is an expectation over guided walks:
  /// E[guided^2], and E[share * unguided^2].
  struct Outcome {
    float unguided = 0.0f;  ///< luminance of an unguided sample that takes the same directions
    float share = 1.0f;     ///< density of these directions without the guide over their density with it, at most 4
  };
  const GuideTree* tree = nullptr;
  std::vector<GuideSample>* samples = nullptr;
  uint32_t pixel = 0, index = 0;  ///< of the path
  Outcome* outcome = nullptr;     ///< receives the result at the end of the path; null: not measured
};
/// A vertex whose incident light is not complete yet.
struct OpenVertex {
  GuideSample sample;
  Color before;  ///< radiance found by the path before this vertex
  float beta;    ///< luminance of the throughput at this vertex
};
constexpr int kMaxOpenVertices = 24;

/// The state of an unguided path.
struct NoGuidedPath {};
/// The state of a guided path.
struct GuidedPath {
  GuidedBsdf bsdf;
  float plain = kPlainShareOfPaths;  ///< probability that the BSDF alone chose the directions, given the directions
  float unguided_beta = 1.0f;        ///< the throughput in that case
  float last_ratio = 1.0f;           ///< density without the guide over that with it, of the last direction
  float hit_weight = 0.0f;           ///< MIS weight of the light that is added next; 0: it is sampled, not hit
  float unguided_light = 0.0f;       ///< Guided::Outcome::unguided so far
  static constexpr float kNever = 1e-16f;  ///< directions with a smaller `plain` do not occur without the guide
  OpenVertex open[kMaxOpenVertices];
  int open_count = 0;
  /// The direction of the last vertex has reached `place`.
  void note_arrival(Vec3 place) {
    if (open_count == 0 || open[open_count - 1].sample.inverse_distance > 0.0f) return;
    GuideSample& last = open[open_count - 1].sample;
    last.inverse_distance = 1.0f / glm::length(place - last.position);
  }
  /// A direction whose density was `pdf`, and `pdf_bsdf` without the guide.
  void note_direction(float pdf_bsdf, float pdf) {
    last_ratio = pdf_bsdf / pdf;
    plain *= last_ratio;
  }
  /// A medium scatters the path towards `sample`, at `place`. `before`: its radiance so far, `beta`:
  /// luminance of its throughput.
  void note_scattering(const Guided& guide, Vec3 place, const PhaseSample& sample, Color before, float beta) {
    if (guide.samples && open_count < kMaxOpenVertices)
      open[open_count++] = {
          {place, Vec3(0.0f), sample.wi, 0.0f, 0.0f, sample.pdf_phase, GuideKind::Volume, guide.pixel, guide.index},
          before,
          beta};
    note_direction(sample.pdf_phase, sample.pdf);
    unguided_beta *= max_component(sample.value) / sample.pdf_phase;
  }
  /// No direction was found. The guide's directions below the surface are not those of the BSDF.
  void note_failure(float u_guide, float u_lobe) {
    plain *= bsdf.draws_from_guide(u_guide, u_lobe) ? 0.0f : 1.0f / (1.0f - bsdf.share());
  }
  /// Adds light. The MIS weight of sampled light is that of the guided walk, which is slightly too large or too small.
  void note_light(float y) {
    if (!(plain > kNever)) return;
    float times = kPlainShareOfPaths / plain;
    if (hit_weight > 0.0f) times *= last_ratio / (hit_weight * last_ratio + (1.0f - hit_weight));
    unguided_light += times * y;
    hit_weight = 0.0f;
  }
  Guided::Outcome outcome() const { return {unguided_light, plain > kNever ? plain / kPlainShareOfPaths : 0.0f}; }
  /// Hands in what the path has found. The light along a direction is all light that was found after it was chosen.
  void end(const Guided& guide, Color radiance) {
    for (int i = 0; guide.samples && i < open_count; ++i) {
      OpenVertex& o = open[i];
      o.sample.weight = luminance(radiance - o.before) / o.beta;
      if (o.sample.weight > 0.0f && std::isfinite(o.sample.weight)) guide.samples->push_back(o.sample);
    }
    if (guide.outcome) *guide.outcome = outcome();
  }
};

class PathGuide {
 public:
  enum class Mode : uint8_t { On, Auto };
  /// While it measures, all pixels must have the same sample count, which is this number.
  static constexpr uint32_t kEqualSamples = 16;
  /// The data with which the next frame can start.
  struct Past {
    GuideTree tree;
    double vertices_per_path;
    bool pays;     ///< result of the measurement, if there was one
    uint32_t age;  ///< number of frames that relied on it
  };
  static constexpr uint32_t kMaxAge = 8;

  /// For a film of this size, rendered in square tiles. The samples of a tile are recorded by one thread.
  PathGuide(Mode mode, int width, int height, int tile, const Past* past = nullptr);
  /// Call it at the end of the frame. Returns null if there were too few samples to learn from.
  std::shared_ptr<const Past> past();

  /// Call it before sample `done` of each pixel: trains and decides if it is time. Returns how many of the `wanted`
  /// samples can follow before the next call. `rays` is the number of rays so far.
  int begin(uint32_t done, int wanted, uint64_t rays);
  bool learning() const { return learning_; }
  bool follows() const { return follows_; }
  /// Whether the guide is trained or used.
  bool active() const { return learning_ || follows_; }
  /// The guide for sample `index` of the film's pixel (x, y), whose number in the frame is `pixel`.
  Guided of_sample(int x, int y, uint32_t pixel, uint32_t index) {
    return {follows_ ? &tree_ : nullptr,
            learning_ && records(pixel, index)
                ? &tile_samples_[size_t(y / tile_) * size_t(columns_) + size_t(x / tile_)]
                : nullptr,
            pixel, index, nullptr};
  }
  /// Whether the samples are to be passed to `measure`.
  bool measuring() const { return measuring_; }
  /// Records the luminance of a guided sample, with exposure, for the measurement.
  void measure(int x, int y, float guided, const Guided::Outcome& outcome) {
    moments_[size_t(y) * size_t(width_) + size_t(x)].add(guided, outcome);
  }
  const GuideTree& tree() const { return tree_; }
  /// The maximum memory so far, which is reached during training.
  size_t max_bytes() const { return max_bytes_; }
  /// An estimate of the maximum memory for a render with this number of samples per pixel.
  static uint64_t estimated_bytes(uint64_t pixels, uint64_t samples);
  /// Variance times cost without the guide over that with it, from the last measurement; 0 before the first.
  double measured_gain() const { return gain_; }

 private:
  struct Moments {
    float sum = 0.0f, square = 0.0f, unguided_square = 0.0f;
    void add(float y, const Guided::Outcome& outcome) {
      sum += y;
      square += y * y;
      unguided_square += outcome.share * outcome.unguided * outcome.unguided;
    }
  };
  /// A measurement of the gain, in samples `begin` to `end` - 1 of each pixel.
  struct Measurement {
    uint32_t begin, end;
    double least;  ///< the guide is abandoned if the gain is smaller
  };
  static const Measurement kMeasurements[2];
  /// Starts and ends measurements before sample `done`. Returns false if the guide is abandoned.
  bool measure_before(uint32_t done, uint64_t rays);
  void learn(float past_share);
  /// Whether a path is recorded. If there are too many, only a fraction of them is.
  bool records(uint32_t pixel, uint32_t index) const;
  double gain(uint32_t samples, uint64_t rays_guided) const;

  bool measures_, measured_ = false,
                  measuring_ = false;  ///< measures_: whether to measure if the guide pays; otherwise it is known
  int width_, pixels_, tile_, columns_;
  bool learning_ = true, follows_ = false, starts_warm_ = false;
  uint32_t age_ = 0, first_training_ = 1;  ///< age in frames; sample count before the first training step
  uint32_t keep_ = ~0u;                    ///< paths with larger hashes are not recorded
  uint64_t paths_ = 0;                     ///< paths of the present iteration
  double vertices_per_path_ = 4.0;         ///< recorded vertices per path of the previous iteration
  uint64_t rays_at_start_ = 0;             ///< of the present measurement
  double rays_without_ = 0.0;              ///< per sample of all pixels, without the guide
  double gain_ = 0.0;
  size_t max_bytes_ = 0;
  GuideTree tree_;
  std::vector<std::vector<GuideSample>> tile_samples_;
  std::vector<Moments> moments_;
};

}  // namespace ajar
