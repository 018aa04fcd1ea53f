// Bidirectional mutation [Veach 1997, section 11.4.2]: removes consecutive vertices and grows new ones, not always the
// same number, from both sides of the gap. It can reach every path from every other one.
//
// The removed part is usually short. The number of new vertices that grow from the light's side is uniform among the
// possible numbers. A proposal that regrows a removed vertex is rejected as empty, because it belongs to a smaller gap.
// A new light end is found by hitting emission, by light sampling, or by a walk from a light.
#pragma once

#include "transport/chains/mutations/mutation.h"

namespace ajar {

class BidirectionalMutation final : public Mutation {
 public:
  explicit BidirectionalMutation(const PathSpace& space) : space_(space) {}
  const char* name() const override { return "bidirectional"; }
  bool suits(const Path&) const override { return true; }
  bool sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const override;
  double pdf(const Path& from, const Path& to) const override;

  /// `light`, `eye`: number of vertices that are kept at either end.
  struct Gap {
    int light, eye;
  };
  /// Only the second part of the mutation: grows a given number of new vertices into a given gap. Also returns false
  /// when the path then shares more vertices than were kept.
  bool grow_into(const Path& from, Gap gap, int grown, Sampler& sampler, Path& to, uint64_t& rays) const;
  /// The density of grow_into, whichever vertices the two paths share.
  double pdf_of_growth(const Path& from, const Path& to, Gap gap) const;

 private:
  /// A pinhole of a still scene stays; another lens gets a new point, and another path a new time.
  int min_eye() const { return space_.scene.camera().has_lens() || space_.scene.moves() ? 0 : 1; }
  int places_of_gap(int removed, int count) const;
  double probability_of_gap(int removed, int count) const;
  /// Probabilities of growing removed - 2 to removed + 2 vertices (index: grown - removed + 2), given the kept ones.
  std::array<double, 5> probabilities_of_growth(int removed, int kept) const;
  /// Whether `s` of `grown` new vertices can be found from the light's side.
  bool possible(const Path& path, Gap gap, int grown, int s) const;
  void keep_ends(const Path& from, Gap gap, int count, Path& to) const;
  bool grow_from_eye(Gap gap, int s, int t, float time, Sampler& sampler, Path& to, uint64_t& rays) const;
  bool grow_from_light(Gap gap, int s, float time, Sampler& sampler, Path& to, uint64_t& rays) const;
  double pdf_given_gap(const Path& from, const Path& to, Gap gap) const;

  const PathSpace& space_;
};

}  // namespace ajar
