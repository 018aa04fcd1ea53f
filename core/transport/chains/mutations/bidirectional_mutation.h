// Bidirectional mutation [Veach 1997, section 11.4.2]: forget some vertices in a row and grow new ones from
// both sides of the gap, not always as many. Reaches every path from every other.
//
// The part forgotten is short more often than long; how many new vertices grow from the light's side is chosen evenly
// among what is possible. Proposals that grow again what they forgot are none. A new light end is found by hitting
// emission, by light sampling, or by a walk from a light.
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

  /// `light`, `eye`: vertices kept at either end.
  struct Gap {
    int light, eye;
  };
  /// Only the growing: a given number of new vertices into a given gap. False, too, when the path then shares more than
  /// was kept.
  bool grow_into(const Path& from, Gap gap, int grown, Sampler& sampler, Path& to, uint64_t& rays) const;
  /// Its density, whatever the two paths share.
  double pdf_of_growth(const Path& from, const Path& to, Gap gap) const;

 private:
  int min_eye() const { return space_.scene.camera().has_lens() ? 0 : 1; }
  int places_of_gap(int removed, int count) const;
  double probability_of_gap(int removed, int count) const;
  /// Probabilities of growing 0 .. removed + 2 vertices (index: new count - removed + 2), given what is kept.
  std::array<double, 5> probabilities_of_growth(int removed, int kept) const;
  /// Can `s` of `grown` new vertices be found from the light's side?
  bool possible(const Path& path, Gap gap, int grown, int s) const;
  double pdf_given_gap(const Path& from, const Path& to, Gap gap) const;

  const PathSpace& space_;
};

}  // namespace ajar
