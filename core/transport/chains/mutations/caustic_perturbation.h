// Caustic perturbation [Veach 1997, section 11.4.3.2]: the vertex the eye sees is rough (Path::rough); from the last
// vertex before it that is rough too (or the light), turn the direction a little, follow the same kinds of specular
// bounces, draw sharp ones anew, and join what is reached to the lens. Rays of a distant light are shifted instead of
// turned.
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
  /// The vertex whose direction is turned.
  static int turned(const Path& path);
  /// Radians (metres for distant lights) that move what is seen by about a pixel.
  float per_pixel(const Path& path, int vertex) const;

  const PathSpace& space_;
  LogarithmicStep pixels_;
};

}  // namespace ajar
