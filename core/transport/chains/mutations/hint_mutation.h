// User path proposals [Fan 2006, section 4.4]: rebuild an artist's hint from the light inside its cones, and join its
// end to what the eye sees: to the first vertex of the current path that is not specular, with the way from there to
// the lens kept, or to the lens itself (a departure from the thesis: without it no hint can propose a caustic that is
// looked at).
//
// A path that a hint proposes is hardly ever near the path it replaces, so no hint could propose the way back. Hints
// and bidirectional mutation are therefore one kernel: either proposes, and both densities count in both directions
// [eq. 4.7]. A bidirectional mutation seldom forgets just what a hint replaced and grows just as many vertices as there
// were, and ways back that are rare keep hints from being accepted. So some proposals of the kernel regrow all that a
// hint would replace, by any number of vertices.
#pragma once

#include "transport/chains/mutations/bidirectional_mutation.h"
#include "transport/hints/hint_shares.h"

namespace ajar {

class HintMutation final : public Mutation {
 public:
  /// `hint_probability`: of a proposal to come from a hint; `regrow_probability`: to regrow what hints replace. The
  /// hints must outlive the mutation.
  HintMutation(const PathSpace& space, const Hints& hints, float hint_probability, float regrow_probability)
      : space_(space),
        hints_(hints),
        bidirectional_(space),
        hint_probability_(hint_probability),
        regrow_probability_(regrow_probability) {}
  const char* name() const override { return "user_path"; }
  bool suits(const Path&) const override { return true; }
  bool sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const override;
  double pdf(const Path& from, const Path& to) const override;

 private:
  bool sample_hint(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const;
  double pdf_of_hints(const Path& from, const Path& to) const;
  bool regrow(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const;
  double pdf_of_regrowth(const Path& from, const Path& to) const;
  /// Fewest and most vertices that may grow in place of a hint's, `kept` being kept.
  int fewest() const { return space_.without_direct ? 2 : 1; }
  int most(int kept) const { return space_.max_vertices - kept; }
  /// Probability that this hint's end is joined to the lens, for a path with or without a vertex it could be joined to
  /// instead.
  float lens_probability(const Hints::Hint& hint, bool has_joinable) const;

  const PathSpace& space_;
  const Hints& hints_;
  BidirectionalMutation bidirectional_;
  float hint_probability_, regrow_probability_;
};

}  // namespace ajar
