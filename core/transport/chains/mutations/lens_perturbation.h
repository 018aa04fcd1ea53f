// Lens and multi-chain perturbation [Veach 1997, sections 11.4.3.1 and 11.4.3.3]: moves the point on the film by a
// small step, follows the same kinds of specular bounces to the first vertex that is not specular, and connects it to
// the rest of the path. If the next vertex is specular again, the direction at this vertex is perturbed as well and the
// next chain is followed, until two consecutive vertices can be connected or the chain ends on a light. Bounces that
// are sharp but not specular (Path::rough) are drawn again from the BSDF, because a connection there would hardly ever
// contribute.
//
// One kernel is enough for both perturbations, because the configuration of a path determines the vertex that is
// connected.
#pragma once

#include "transport/chains/mutations/mutation.h"
#include "transport/chains/mutations/regrow.h"

namespace ajar {

class LensPerturbation final : public Mutation {
 public:
  explicit LensPerturbation(const PathSpace& space);
  /// `film_step`: steps on the film, in pixels.
  LensPerturbation(const PathSpace& space, const char* name, LogarithmicStep film_step);
  const char* name() const override { return name_; }
  bool suits(const Path& from) const override;
  bool sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const override;
  double pdf(const Path& from, const Path& to) const override;

 private:
  /// First vertex (from the light) that changes; 0 when the light end is also found again.
  static int first_changed(const Path& path);

  const PathSpace& space_;
  const char* name_;
  LogarithmicStep film_step_;   ///< pixels
  LogarithmicStep angle_step_;  ///< radians, at later vertices
};

}  // namespace ajar
