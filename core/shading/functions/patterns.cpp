#include "shading/functions/patterns.h"

#include <algorithm>
#include <cmath>

#include "math/observer.h"
#include "shading/functions/noise.h"

namespace ajar::nodes {

float wave(const WaveParameters& w, Vec3 p) {
  p = (p + 0.000001f) * 0.999999f;  // faces at integer coordinates stay in one band
  const Vec3 place = p;
  float phase;
  if (w.rings) {
    if (w.axis != WaveAxis::All) p[int(w.axis)] = 0.0f;
    phase = 20.0f * glm::length(p);
  } else {
    phase = w.axis == WaveAxis::All ? 10.0f * (p.x + p.y + p.z) : 20.0f * p[int(w.axis)];
  }
  phase += w.phase;
  if (w.distortion != 0.0f) {
    phase += w.distortion *
             (2.0f * normalized_fbm(place * w.detail_scale, w.detail + 1.0f, saturate(w.detail_roughness)) - 1.0f);
  }
  const float turns = phase / (2.0f * kPi);
  switch (w.profile) {
    case WaveProfile::Sine: return 0.5f + 0.5f * std::sin(phase - 0.5f * kPi);
    case WaveProfile::Saw: return turns - std::floor(turns);
    case WaveProfile::Triangle: return 2.0f * std::abs(turns - std::floor(turns + 0.5f));
  }
  return 0.0f;
}

Color magic(Vec3 p, float scale, int depth, float distortion) {
  for (int i = 0; i < 3; ++i) p[i] = std::fmod(p[i], 2.0f * kPi);
  Vec3 v(std::sin((p.x + p.y + p.z) * 5.0f * scale), std::cos((-p.x + p.y - p.z) * 5.0f * scale),
         -std::cos((-p.x - p.y + p.z) * 5.0f * scale));
  // Each step replaces one component by the sine or cosine of a signed sum of all three components.
  struct Step {
    int target;
    float (*function)(float);
    float sign;
    Vec3 signs;
  };
  constexpr auto sine = [](float x) { return std::sin(x); };
  constexpr auto cosine = [](float x) { return std::cos(x); };
  static const Step kSteps[] = {{1, cosine, -1, {1, -1, 1}},  {0, cosine, 1, {1, -1, -1}}, {2, sine, 1, {-1, -1, -1}},
                                {0, cosine, -1, {-1, 1, -1}}, {1, sine, -1, {-1, 1, 1}},   {1, cosine, -1, {-1, 1, 1}},
                                {0, cosine, 1, {1, 1, 1}},    {2, sine, 1, {1, 1, -1}},    {0, cosine, -1, {-1, -1, 1}},
                                {1, sine, -1, {1, -1, 1}}};
  if (depth > 0) v *= distortion;
  for (int i = 0; i < std::min(depth, 10); ++i)
    v[kSteps[i].target] = distortion * kSteps[i].sign * kSteps[i].function(glm::dot(kSteps[i].signs, v));
  if (distortion != 0.0f) v /= 2.0f * distortion;
  return 0.5f - v;
}

namespace {

/// A hash of an integer to [0, 1], the one of Blender's Brick Texture.
float brick_noise(uint32_t n) {
  n = (n + 1013u) & 0x7fffffffu;
  n ^= n >> 13;
  n = (n * (n * n * 60493u + 19990303u) + 1376312589u) & 0x7fffffffu;
  return 0.5f * (float(n) / 1073741824.0f);
}

int whole(float x) { return x == x ? int(std::clamp(std::floor(x), -2e9f, 2e9f)) : 0; }

}  // namespace

Vec2 brick(const BrickParameters& b, Vec3 p) {
  const int row = whole(p.y / b.row_height);
  float width = b.width, shift = 0.0f;
  if (b.offset_frequency != 0 && b.squash_frequency != 0) {
    if (row % b.squash_frequency == 0) width *= b.squash;
    if (row % b.offset_frequency == 0) shift = width * b.offset;
  }
  const int column = whole((p.x + shift) / width);
  const float x = p.x + shift - width * float(column), y = p.y - b.row_height * float(row);
  const float tint = saturate(brick_noise((uint32_t(row) << 16) + (uint32_t(column) & 0xffffu)) + b.bias);
  const float to_edge = std::min(std::min(x, y), std::min(width - x, b.row_height - y));
  if (to_edge >= b.mortar_size) return {tint, 0.0f};
  if (b.mortar_smooth == 0.0f) return {tint, 1.0f};
  const float depth = 1.0f - to_edge / b.mortar_size;
  const float t = saturate(depth / b.mortar_smooth);
  return {tint, depth < b.mortar_smooth ? t * t * (3.0f - 2.0f * t) : 1.0f};
}

Color wavelength(float nanometres, bool clip) {
  const Color c = xyz_to_rgb(observer::xyz(nanometres)) / 2.52f;  // this scale keeps all components below 1
  return clip ? glm::max(c, 0.0f) : c;
}

}  // namespace ajar::nodes
