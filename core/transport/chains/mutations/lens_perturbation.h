// Lens and multi-chain perturbation [Veach 1997, sections 11.4.3.1 and 11.4.3.3]: move the point on the film a
// little, follow the same kinds of specular bounces to the first vertex that is not specular, and join it to the
// rest of the path. Where what comes next is specular again, the direction there is perturbed too and the next
// chain followed, until two vertices in a row can be joined or the chain ends on a light. Bounces that are not specular
// but sharp (Path::rough) are drawn anew from the BSDF, for joining there would hardly ever carry light.
//
// One kernel for both: a path has only one such way to the vertex it is joined to.
#pragma once

#include "transport/chains/mutations/mutation.h"
#include "transport/chains/mutations/regrow.h"

namespace ajar {

class LensPerturbation final : public Mutation {
 public:
  explicit LensPerturbation(const PathSpace& space);
  /// Steps on the film of smallest to largest pixels.
  LensPerturbation(const PathSpace& space, const char* name, LogarithmicStep film_step);
  const char* name() const override { return name_; }
  bool suits(const Path& from) const override;
  bool sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const override;
  double pdf(const Path& from, const Path& to) const override;

 private:
  /// First vertex (from the light) that changes; 0 when the light end itself is found anew.
  static int first_changed(const Path& path);

  const PathSpace& space_;
  const char* name_;
  LogarithmicStep film_step_;   ///< pixels
  LogarithmicStep angle_step_;  ///< radians, at later vertices
};

}  // namespace ajar
