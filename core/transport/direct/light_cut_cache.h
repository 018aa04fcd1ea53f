// Learned choice of lights by position, over cuts of the light tree: the shares of PMC-HI for one sample per vertex.
//
// A cell is a small cube of space, a rounded normal and a material. Its cut (light_set.h) divides the tree finely where
// it expects much light at the cell and coarsely elsewhere. Each branch of the cut has a share. A sample chooses a
// branch by these shares, and then a light of the branch by the tree, for the point itself [adaptive cuts with learned
// visibility: Vevoda, Kondapaneni and Krivanek 2018, "Bayesian online regression for adaptive direct illumination
// sampling"]. The shares follow the second moments of the contributions of the branches,
//   alpha_k proportional to sqrt(E[(f / p_k)^2]),
// which is the optimum for components that do not overlap. A prior of a few samples with the expectation of the tree,
// and floors, keep a positive probability for every light that the tree can reach. One random number is inverted
// through shares and tree, so stratified numbers stay stratified.
//
// In the first iteration, vertices claim the slots of a table. The smallest key gets the slot, for any order of
// the threads; vertices with other keys choose by the tree alone. Then cuts are made, and the shares are learned for up
// to `kLearningIterations` from sums of integers. After that, nothing changes. The estimates are unbiased in all
// iterations. Another frame of an animation continues from there with one iteration: new positions claim free slots,
// known cells learn, and older sums count half.
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
  /// Memory of a cell without its slot: number, prior, share and sum of each branch, and the sums of the cell.
  static constexpr size_t kBytesPerCell = kBranches * (sizeof(uint32_t) + 2 * sizeof(float) + sizeof(uint64_t)) +
                                          sizeof(uint8_t) + 2 * sizeof(uint64_t);

  /// The size of a cell is `angle` times its distance from the eye. `scale` is a typical luminance of the contribution
  /// of a sample.
  LightCutCache(const LightSet& lights, Vec3 eye, float angle, float scale);

  /// Continues from the cache of an earlier frame, whose lights had the same fingerprint.
  LightCutCache(const LightCutCache& before, const LightSet& lights);
  /// Whether the cells of this cache can be used for this eye and this `angle`. `reach` is the typical distance of
  /// visible surfaces.
  bool suits(Vec3 eye, float angle, float reach) const;

  /// The number of calls of `publish` until learning ends. The first call ends the claims.
  static int iterations(const LightSet& lights);
  bool learning() const { return iterations_left_ > 0; }
  /// Updates the shares from all recorded samples.
  void publish();

  /// The key of a cell. `jitter` shifts the borders of cells, which blends neighbouring cells. Samples with the same
  /// jitter have the same borders.
  uint64_t key(Vec3 p, Vec3 n, uint32_t material, uint32_t jitter) const;
  uint32_t cell(uint64_t key) const;

  struct Choice {
    LightSet::Choice choice;  ///< its pmf is that of branch and light
    uint32_t branch;
    float share;
  };
  Choice choose(uint32_t cell, Vec3 p, Vec3 n, float u) const;
  float pmf(uint32_t cell, Vec3 p, Vec3 n, uint32_t light) const;
  /// Records a sample of a learned cell whose contribution has the luminance y.
  void record(uint32_t cell, const Choice& choice, float y) const;

  size_t cells() const { return samples_.size(); }
  /// floor: the minimum share of a branch. share: its present share.
  float floor(uint32_t cell, int branch) const;
  float share(uint32_t cell, int branch) const;
  int branches(uint32_t cell) const { return counts_[cell]; }
  /// The sum of the shares of the branches whose ids are in [first, end).
  float share_between(uint32_t cell, uint32_t first, uint32_t end) const;

 private:
  void make_cuts();
  void place_of_key(uint64_t key, Vec3& center, float& size, Vec3& normal) const;

  const LightSet* lights_;
  Vec3 eye_;
  float angle_, inverse_scale_squared_;
  int iterations_left_;
  bool claiming_ = true;
  std::unique_ptr<std::atomic<uint64_t>[]> claims_;  // the key of each slot
  std::vector<uint32_t> cell_of_slot_;               // kNone: not yet a cell
  // By cell and branch:
  std::vector<uint32_t> ids_;
  std::vector<float> priors_, cumulative_;
  std::vector<uint8_t> counts_;
  mutable std::vector<std::atomic<uint64_t>> samples_, squares_, moments_;
};

}  // namespace ajar
