#include "transport/media/phase_function.h"

namespace ajar {

float henyey_greenstein(float cosine, float g) {
  const float denominator = 1.0f + g * (g - 2.0f * cosine);
  return 0.25f * kInvPi * (1.0f - g * g) / (denominator * std::sqrt(denominator));
}

float sample_henyey_greenstein(float g, float u) {
  if (std::abs(g) < 1e-3f) return 1.0f - 2.0f * u;
  const float k = (1.0f - g * g) / (1.0f - g + 2.0f * g * u);
  return std::clamp((1.0f + g * g - k * k) / (2.0f * g), -1.0f, 1.0f);
}

}  // namespace ajar
