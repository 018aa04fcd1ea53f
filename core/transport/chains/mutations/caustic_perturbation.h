// Caustic perturbation [Veach 1997, section 11.4.3.2] of a path whose vertex next to the eye is rough (Path::rough).
// The perturbation starts at the last rough vertex before it, or at the light. It turns the direction there by a small
// angle, follows the same kinds of specular bounces, draws sharp bounces again, and connects the vertex that it reaches
// to the lens. Rays of a distant light are shifted instead of turned.
#pragma once

#include "transport/chains/mutations/mutation.h"
#include "transport/chains/mutations/regrow.h"

namespace ajar {

class CausticPerturbation final : public Mutation {
 public:
  explicit CausticPerturbation(const PathSpace& space);
  const char* name() const override { return "caustic"; }
  bool suits(const Path& from) const override;
  bool sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const override;
  double pdf(const Path& from, const Path& to) const override;

 private:
  /// The vertex at which the direction is turned.
  static int turned(const Path& path);
  /// Step in radians (metres for distant lights) that moves the path by about one pixel on the film.
  float per_pixel(const Path& path, int vertex) const;

  const PathSpace& space_;
  LogarithmicStep pixels_;
};

}  // namespace ajar
