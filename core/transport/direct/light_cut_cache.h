// Which lights to sample, learned per place over cuts of the light tree: PMC-HI's shares for one sample a vertex.
//
// A cell is a small cube of space, a rounded normal and a material. Its cut (light_set.h) splits the tree finely where
// it promises much to this place and coarsely elsewhere; each branch has a share, from which one branch is drawn and
// then, by the tree, a light for the point itself [adaptive cuts with learned visibility: Vevoda, Kondapaneni and
// Krivanek 2018, "Bayesian online regression for adaptive direct illumination sampling"]. Shares follow the second
// moments of what branches brought,
//   alpha_k proportional to sqrt(E[(f / p_k)^2]), the optimum for parts that do not overlap,
// with a prior of a few samples that behave as the tree expects, and floors: every light that the tree can reach keeps
// a probability. One random number is inverted through shares and tree alike, so that stratified numbers stay so.
//
// First iteration: vertices claim slots of a table (the smaller key wins, in any order of threads; losers choose by the
// plain tree). Then cuts are made and shares learned for up to `kLearningIterations`, from integer sums. After them
// nothing changes. Unbiased at every stage. Another frame of an animation goes on from there: one iteration, in which
// places not seen before claim slots that are free, and the others learn; what is older counts half.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "lights/light_set.h"

namespace ajar {

class LightCutCache {
 public:
  static constexpr uint32_t kNone = ~0u;
  static constexpr int kBranches = 64, kLearningIterations = 2;
  /// Numbers, priors, shares and sums of each branch, and the cell's own; without its slot.
  static constexpr size_t kBytesPerCell = kBranches * (sizeof(uint32_t) + 2 * sizeof(float) + sizeof(uint64_t)) +
                                          sizeof(uint8_t) + 2 * sizeof(uint64_t);

  /// Cells are `angle` times as large as their distance from the eye. `scale` is a typical luminance of what samples
  /// bring.
  LightCutCache(const LightSet& lights, Vec3 eye, float angle, float scale);

  /// Go on from the cache of an earlier frame, whose lights had the same fingerprint.
  LightCutCache(const LightCutCache& before, const LightSet& lights);
  /// Whether cells of that size, seen from there, are much like this cache's; the eye looks at things at `reach`.
  bool suits(Vec3 eye, float angle, float reach) const;

  /// Calls of `publish` until it has learned; the first ends the claims.
  static int iterations(const LightSet& lights);
  bool learning() const { return iterations_left_ > 0; }
  /// Everything recorded becomes the past.
  void publish();

  /// `jitter` blends neighbours: samples with the same one agree about the borders of cells.
  uint64_t key(Vec3 p, Vec3 n, uint32_t material, uint32_t jitter) const;
  uint32_t cell(uint64_t key) const;

  struct Choice {
    LightSet::Choice choice;  ///< pmf of light and branch
    uint32_t branch;
    float share;
  };
  Choice choose(uint32_t cell, Vec3 p, Vec3 n, float u) const;
  float pmf(uint32_t cell, Vec3 p, Vec3 n, uint32_t light) const;
  /// A sample of a learned cell brought y.
  void record(uint32_t cell, const Choice& choice, float y) const;

  size_t cells() const { return samples_.size(); }
  /// Least share that a branch keeps, and the one it has.
  float floor(uint32_t cell, int branch) const;
  float share(uint32_t cell, int branch) const;
  int branches(uint32_t cell) const { return counts_[cell]; }
  /// Sum of the shares of branches whose ids are in [first, end).
  float share_between(uint32_t cell, uint32_t first, uint32_t end) const;

 private:
  void make_cuts();
  void place_of_key(uint64_t key, Vec3& center, float& size, Vec3& normal) const;

  const LightSet* lights_;
  Vec3 eye_;
  float angle_, inverse_scale_squared_;
  int iterations_left_;
  bool claiming_ = true;
  std::unique_ptr<std::atomic<uint64_t>[]> claims_;  // key per slot
  std::vector<uint32_t> cell_of_slot_;               // kNone: not yet
  // Per cell and branch:
  std::vector<uint32_t> ids_;
  std::vector<float> priors_, cumulative_;
  std::vector<uint8_t> counts_;
  mutable std::vector<std::atomic<uint64_t>> samples_, squares_, moments_;
};

}  // namespace ajar
