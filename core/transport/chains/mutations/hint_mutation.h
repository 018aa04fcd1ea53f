// User path proposals [Fan 2006, section 4.4]: build a path from the light inside the cones of an artist's hint, and
// connect its end to the eye's part of the current path: either to the first vertex from the eye that is not specular,
// with the vertices from there to the lens kept, or to the lens itself. The thesis does not connect to the lens.
// Without this, no hint could propose a caustic that the eye sees directly.
//
// A path that a hint proposes is usually far from the path that it replaces, so no hint could propose the reverse move.
// Hints and bidirectional mutation are therefore one kernel: either one draws the proposal, and both densities count in
// both directions [eq. 4.7]. A bidirectional mutation rarely removes exactly the vertices that a hint replaced and
// grows exactly as many as there were before. If reverse moves are rare, hints are rarely accepted. Therefore some
// proposals of the kernel regrow everything that a hint would replace, with any number of vertices.
#pragma once

#include "transport/chains/mutations/bidirectional_mutation.h"
#include "transport/hints/hint_shares.h"

namespace ajar {

class HintMutation final : public Mutation {
 public:
  /// `hint_probability`: of a proposal by a hint. `regrow_probability`: of a proposal that regrows what hints replace.
  /// The hints must outlive the mutation.
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
  /// Minimum and maximum number of vertices that may grow in place of a hint's, with `kept` vertices kept.
  int min_grown() const { return space_.without_direct ? 2 : 1; }
  int max_grown(int kept) const { return space_.max_vertices - kept; }
  /// Probability that this hint's end is connected to the lens. `has_joinable`: the path has a vertex to which it could
  /// be connected instead.
  float lens_probability(const Hints::Hint& hint, bool has_joinable) const;

  const PathSpace& space_;
  const Hints& hints_;
  BidirectionalMutation bidirectional_;
  float hint_probability_, regrow_probability_;
};

}  // namespace ajar
