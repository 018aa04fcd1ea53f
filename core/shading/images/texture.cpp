#include "shading/images/texture.h"

#include <algorithm>
#include <cmath>

#include "math/srgb.h"
#include "shading/images/interpolation.h"
#include "shading/images/tile_cache.h"

namespace ajar {

namespace {

// ---- sRGB -----------------------------------------------------------------------------

/// The curve at 1025 points. The error of linear interpolation between them is less than 4e-7.
struct SrgbTable {
  float values[1026];
  SrgbTable() {
    for (int i = 0; i < 1026; ++i) values[i] = linear_from_srgb(i / 1024.0f);
  }
  float operator()(float x) const {
    if (!(x > 0.0f)) return 0.0f;
    if (x > 1.0f) return linear_from_srgb(x);
    const float position = x * 1024.0f;
    const int i = int(position);
    return values[i] + (position - i) * (values[i + 1] - values[i]);
  }
};
const SrgbTable kSrgb;

/// The finest two levels of a lookup are mixed over this part of the way from one level to the next.
constexpr float kMixed = 0.25f;

}  // namespace

template <typename Texel>
Vec4 Texture::interpolate(Vec2 uv, Interpolation interpolation, Extension extension) const {
  const uint8_t* stored = texels_.data();
  return texels::interpolate(width_, height_, uv, interpolation, extension,
                             [&](int x, int y) { return texels::fetch<Texel>(stored, int64_t(y) * width_ + x); });
}

/// The tile at `uv`, which becomes relative to it. As in Cycles, coordinates above -1 belong to the first tiles.
const Texture& Texture::tile(Vec2& uv) const {
  const size_t missing = tiles_.size() - 1;
  if (!(uv.x > -1.0f && uv.x < 10.0f && uv.y > -1.0f && uv.y < float(missing))) return *tiles_[missing];
  const int x = int(uv.x), y = int(uv.y);
  uv -= Vec2(float(x), float(y));
  return *tiles_[std::min(size_t(x + 10 * y), missing)];
}

const Texture* Texture::tile_at(Vec2& uv) const {
  if (tiles_.empty()) return nullptr;
  const Texture& part = tile(uv);
  return &part == tiles_.back() ? nullptr : &part;
}

Vec4 Texture::sample_tile(Vec2 uv, Interpolation interpolation, Extension extension, bool unassociate) const {
  const Texture* part = tile_at(uv);
  return part ? part->sample(uv, interpolation, extension, unassociate) : Vec4(1.0f, 0.0f, 1.0f, 1.0f);
}

Vec4 Texture::decoded(Vec4 value, bool unassociate) const {
  if (unassociate && has_alpha_ && value.w != 0.0f && value.w != 1.0f) value = Vec4(Vec3(value) / value.w, value.w);
  if (srgb_) value = Vec4(kSrgb(value.x), kSrgb(value.y), kSrgb(value.z), value.w);
  return value;
}

Vec4 Texture::sample(Vec2 uv, Interpolation interpolation, Extension extension, bool unassociate) const {
  Vec4 value;
  switch (storage_) {
    case Storage::Byte: value = interpolate<uint8_t>(uv, interpolation, extension); break;
    case Storage::Short: value = interpolate<uint16_t>(uv, interpolation, extension); break;
    case Storage::Half: value = interpolate<Half>(uv, interpolation, extension); break;
    case Storage::Float: value = interpolate<float>(uv, interpolation, extension); break;
    case Storage::Tiles: return sample_tile(uv, interpolation, extension, unassociate);
    case Storage::Cached: return sample_finest(uv, interpolation, extension, unassociate);
  }
  return decoded(value, unassociate);
}

// ---- Levels -----------------------------------------------------------------------------

Vec4 Texture::sample_finest(Vec2 uv, Interpolation interpolation, Extension extension, bool unassociate) const {
  return decoded(cached_->interpolate(0, uv, interpolation, extension), unassociate);
}

bool Texture::has_levels() const {
  return storage_ == Storage::Cached || std::any_of(tiles_.begin(), tiles_.end(), [](const Texture* part) {
           return part->storage_ == Storage::Cached;
         });
}

Vec4 Texture::sample_over(Vec2 uv, const UvFootprint& footprint, Interpolation interpolation, Extension extension,
                          bool unassociate) const {
  if (storage_ == Storage::Tiles) {
    const Texture* part = tile_at(uv);
    return part ? part->sample_over(uv, footprint, interpolation, extension, unassociate)
                : Vec4(1.0f, 0.0f, 1.0f, 1.0f);
  }
  // Without its division by alpha, a colour in sRGB is decoded after it was multiplied, which the mean is not made for.
  if (storage_ != Storage::Cached || (srgb_ && has_alpha_ && !unassociate))
    return sample(uv, interpolation, extension, unassociate);
  const float wanted = cached_->level_of(footprint);
  const int level = std::min(int(wanted), cached_->levels() - 1);
  const Vec4 value = decoded(cached_->interpolate(level, uv, interpolation, extension), unassociate);
  const float way = (wanted - float(level)) / kMixed;
  if (level == 0 || way >= 1.0f) return value;
  const Vec4 finer = decoded(cached_->interpolate(level - 1, uv, interpolation, extension), unassociate);
  if (!has_alpha_ || !unassociate) return glm::mix(finer, value, way);
  // Of colours that are not multiplied by alpha, the mean is weighted by it.
  const float alpha = glm::mix(finer.w, value.w, way);
  if (!(alpha > 0.0f)) return value;
  return Vec4(glm::mix(finer.w * Vec3(finer), value.w * Vec3(value), way) / alpha, alpha);
}

}  // namespace ajar
