#include "transport/paths/light_shares.h"

namespace ajar {

PathShares shares_of(const Bsdf& bsdf, const PathShares& scattered) {
  PathShares shares;
  const PathShares albedo = bsdf.albedo_of_kinds();
  for (int c = 0; c < 3; ++c) {
    const PathShares& of = scattered[0][c] + scattered[1][c] + scattered[2][c] > 0.0f ? scattered : albedo;
    const float sum = of[0][c] + of[1][c] + of[2][c];
    for (size_t k = 0; k < 3; ++k) shares[k][c] = sum > 0.0f ? of[k][c] / sum : k == 0 ? 1.0f : 0.0f;
  }
  return shares;
}

}  // namespace ajar
