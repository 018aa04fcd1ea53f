#include "transport/photons/photon_discs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "math/frame.h"
#include "math/random.h"
#include "scene/scene.h"
#include "shading/bsdf/shading_point.h"

namespace ajar {

namespace {

constexpr int kSectors = 8;
/// A sector: the distance to the line in which a wall meets the disc, in 1/61 of the radius, or one of these values.
constexpr uint32_t kSteps = 61, kNothing = 62, kSurface = 63;
constexpr int kSectorBits = 6, kFurtherShift = kSectors * kSectorBits, kJitterShift = kFurtherShift + 5,
              kTurnShift = kJitterShift + 3, kSizeShift = kTurnShift + 3;
constexpr uint64_t kKnown = uint64_t(1) << 63, kLonely = uint64_t(1) << 62;  // lonely: no sector found surface
/// The number of failures is stored as half of it.
constexpr uint32_t kMaxFurther = 62, kFurtherMask = kMaxFurther / 2;
/// Makes the expectation of (tested + kPrior) / (found + kPrior) right within 1 % at straight edges and in corners, and
/// within 10 % on strips.
constexpr float kPrior = 0.35f;
/// Where the ray that measures the free height starts, in radii.
constexpr float kOffSurface = 1e-4f;
/// The ray sees everything that any kind of ray can see, because photons lie there too.
constexpr uint32_t kAnyRay = kRayCamera | kRayDiffuse | kRayGlossy | kRayTransmission | kRayShadow | kRayVolumeScatter;
/// The ring in which each sector has its tested point. Each ring has an eighth of the disc's area.
constexpr uint32_t kRing[kSectors] = {0, 4, 2, 6, 1, 5, 3, 7};

constexpr float kAngleStep = 2.0f * kPi / 256.0f;
const std::array<Vec2, 256> kDirections = [] {
  std::array<Vec2, 256> directions;
  for (int i = 0; i < 256; ++i)
    directions[size_t(i)] = Vec2(std::cos(float(i) * kAngleStep), std::sin(float(i) * kAngleStep));
  return directions;
}();

/// Height above a photon from which its disc is tested.
float height_of(float radius) { return radius / PointTree::kFlatness; }
/// The same, or half of the free distance above the photon if that is less. A ray that starts behind the next surface
/// would find nothing.
float free_height(const Scene& scene, const SurfacePoint& at, Vec3 normal, float radius, float time) {
  const float height = height_of(radius), start = kOffSurface * radius;
  Ray ray;
  ray.origin = at.position + normal * start;
  ray.direction = normal;
  ray.t_max = 2.0f * height;
  ray.time = time;
  const Hit hit = scene.intersect(ray, kAnyRay);
  return hit.found() && hit.t > start ? 0.5f * (start + hit.t) : height;
}
/// Surface that is higher or lower than the photon by at most this belongs to its disc.
float thickness_of(float radius) { return 0.5f * height_of(radius); }

/// Where the ray of a sector goes, as a squared distance over the squared radius. Each photon turns the list of rings, so
/// that the result does not depend on the direction of a strip, and has its own place in all rings, so that it does not
/// depend on the radius of a round object.
float place(uint64_t known, int i) {
  const uint32_t ring = kRing[(uint32_t(known >> kTurnShift) + uint32_t(i)) & 7u], in_ring = known >> kJitterShift & 7u;
  return (float(ring) + (float(in_ring) + 0.5f) / 8.0f) / float(kSectors);
}

/// Radii of discs relative to the largest, in steps of the square root of 1/2.
constexpr std::array<float, 8> kSizes{1.0f, 0.70710678f, 0.5f, 0.35355339f, 0.25f, 0.17677670f, 0.125f, 0.08838835f};
uint32_t size_for(float reach, float radius) {
  uint32_t size = 0;
  while (size + 1 < kSizes.size() && kSizes[size + 1] * radius >= reach) ++size;
  return size;
}
float size_of(uint64_t known) { return kSizes[uint32_t(known >> kSizeShift) & 7u]; }

uint32_t sector(uint64_t known, int i) { return uint32_t(known >> (kSectorBits * i)) & 63u; }

/// Sector of a direction in the plane: 0 to 7, counterclockwise from the x axis.
int sector_of(float x, float y) {
  const int quadrant = y < 0.0f ? (x < 0.0f ? 2 : 3) : (x < 0.0f ? 1 : 0);
  const float ax = std::abs(x), ay = std::abs(y);
  return 2 * quadrant + int(quadrant & 1 ? ax > ay : ay > ax);
}

}  // namespace

void PhotonDiscs::start(const Scene& scene, size_t photons, float radius, float time, uint32_t seed) {
  scene_ = &scene;
  photons_ = photons;
  radius_ = radius;
  time_ = time;
  seed_ = seed;
  around_ = std::make_unique<Around[]>(photons);
}

float PhotonDiscs::inverse_share(uint64_t known, const Around& around, const SurfacePoint& at, Vec3 position,
                                 float radius2) const {
  const float radius = radius_ * size_of(known);
  const Frame frame(unpack_direction(at.packed_normal));
  const Vec3 offset = position - at.position;
  if (std::abs(glm::dot(offset, frame.n)) > thickness_of(radius)) return 0.0f;
  const float x = glm::dot(offset, frame.s), y = glm::dot(offset, frame.t);
  const int own = sector_of(x, y);
  const uint32_t wall = sector(known, own);
  if (wall <= kSteps) {
    const uint32_t angle = uint32_t(around.walls.load(std::memory_order_relaxed) >> (8 * own)) & 255u;
    const float to_wall = x * kDirections[angle].x + y * kDirections[angle].y;
    if (to_wall > float(wall) * radius / float(kSteps)) return 0.0f;
  }
  const float full2 = radius * radius;
  if (known & kLonely) {
    if (!sees(at, frame.n, position, free_height(*scene_, at, frame.n, radius, time_))) return 0.0f;
    // The surface is taken for a strip, whose share of a smaller disc is larger.
    const float of_whole = float(kSectors + 1) + 2.0f * float(uint32_t(known >> kFurtherShift) & kFurtherMask) + 0.5f;
    return std::max(1.0f, of_whole * std::sqrt(radius2 / full2));
  }
  int found = 0, tested = 0;
  for (int i = 0; i < kSectors; ++i) {
    if (place(known, i) * full2 > radius2)
      continue;  // the tested point is outside this disc, so it says nothing about it
    ++tested;
    if (sector(known, i) == kSurface) ++found;
  }
  return found > 0 ? (float(tested) + kPrior) / (float(found) + kPrior) : float(tested + 1);
}

/// Whether the point above the photon, from which its disc was tested, sees `position`.
bool PhotonDiscs::sees(const SurfacePoint& at, Vec3 normal, Vec3 position, float height) const {
  Ray ray;
  ray.origin = at.position + normal * height;
  ray.direction = position - ray.origin;
  ray.t_max = 0.99f;
  ray.time = time_;
  return !scene_->intersect(ray, kAnyRay).found();
}

/// Rays from above a photon to points of its disc.
struct PhotonDiscs::Look {
  const PhotonDiscs& discs;
  const SurfacePoint& at;
  Frame frame;
  float radius, height;  ///< of the disc, and of the origin of rays
  ShadingPoint point;
  uint32_t wall_direction;  ///< of the last wall that was found

  /// Looks in the direction `angle`, to the squared distance `place` of the squared radius.
  uint32_t operator()(float angle, float place) {
    const float distance = std::sqrt(place) * radius;
    const Vec3 above = frame.n * height, aside = (frame.s * std::cos(angle) + frame.t * std::sin(angle)) * distance;
    const float length = std::sqrt(distance * distance + height * height);
    const bool found = hits(at.position + above, (aside - above) / length, 1.5f * length);
    const float level = found ? glm::dot(point.position - at.position, frame.n) : 0.0f;
    if (found && std::abs(level) <= kLevel * height && is_surface(level)) return kSurface;
    // The ray meets curved surface elsewhere than above the tested point. A perpendicular ray finds what is there.
    if (!found || level < 0.0f || is_surface(level)) return surface_at(aside, above);
    const Vec3 behind = glm::dot(point.ng, point.wo) > 0.0f ? -point.ng : point.ng;
    const float x = glm::dot(behind, frame.s), y = glm::dot(behind, frame.t);
    const float to_wall = std::max(0.0f, glm::dot(point.position - at.position, behind) / std::sqrt(x * x + y * y));
    if (to_wall > radius) return kNothing;
    wall_direction = uint32_t(std::lround(std::atan2(y, x) / kAngleStep)) & 255u;
    return uint32_t(to_wall / radius * float(kSteps) + 0.5f);
  }

 private:
  static constexpr float kLevel = 0.02f;  // relative to the height of the origin of rays

  bool hits(Vec3 origin, Vec3 direction, float t_max) {
    Ray ray;
    ray.origin = origin;
    ray.direction = direction;
    ray.t_max = t_max;
    ray.time = discs.time_;
    const Hit hit = discs.scene_->intersect(ray, kAnyRay);
    if (!hit.found()) return false;
    discs.scene_->shading_point(ray, hit, point);
    return true;
  }
  /// Whether the last hit, at this height, is surface of the disc.
  bool is_surface(float level) const {
    return std::abs(glm::dot(point.ng, frame.n)) >= PointTree::kMinNormalCosine &&
           std::abs(level) <= thickness_of(radius);
  }
  /// kSurface, if there is surface below or above the point `aside` that the point `above` the photon sees; or kNothing.
  uint32_t surface_at(Vec3 aside, Vec3 above) {
    if (!hits(at.position + aside + above, -frame.n, height + thickness_of(radius))) return kNothing;
    if (!is_surface(glm::dot(point.position - at.position, frame.n))) return kNothing;
    return discs.sees(at, frame.n, point.position, height) ? kSurface : kNothing;
  }
};

uint64_t PhotonDiscs::look_around(uint32_t photon, const SurfacePoint& at, float reach) const {
  Around& around = around_[photon];
  const uint32_t size = size_for(reach, radius_);
  const Frame frame(unpack_direction(at.packed_normal));
  const float radius = radius_ * kSizes[size];
  Look look{*this, at, frame, radius, free_height(*scene_, at, frame.n, radius, time_), {}, 0};
  Pcg32 random(hash_combine(seed_, photon), photon);
  const uint32_t numbers = random.next();
  uint64_t known = kKnown | kLonely | uint64_t(numbers & 7u) << kTurnShift |
                   uint64_t(numbers >> 3 & 7u) << kJitterShift | uint64_t(size) << kSizeShift,
           walls = 0;
  for (int i = 0; i < kSectors; ++i) {
    const float angle = (float(i) + random.next_float()) * (2.0f * kPi / kSectors);
    const uint32_t found = look(angle, place(known, i));
    known |= uint64_t(found) << (kSectorBits * i);
    walls |= uint64_t(look.wall_direction) << (8 * i);
    if (found == kSurface) known &= ~kLonely;
  }
  if (known & kLonely) {
    uint32_t failures = 0;
    for (; failures < kMaxFurther; ++failures) {
      const float angle = 2.0f * kPi * random.next_float();
      if (look(angle, random.next_float()) == kSurface) break;
    }
    known |= uint64_t(failures / 2) << kFurtherShift;
  }
  around.walls.store(walls, std::memory_order_relaxed);
  around.sectors.store(known, std::memory_order_release);
  return known;
}

}  // namespace ajar
