#include "transport/photons/photon_discs.h"

#include <algorithm>
#include <cmath>

#include "math/frame.h"
#include "math/random.h"
#include "scene/scene.h"
#include "shading/bsdf/shading_point.h"

namespace ajar {

namespace {

constexpr int kSectors = 8;
/// The byte of a sector. The low bits store the distance that light can reach in it, in 1/127 of the radius. The high
/// bit stores whether surface was found.
constexpr uint32_t kSteps = 127, kSurface = 128;
constexpr uint64_t kUnknown = 0;  // every known sector reaches at least one step
/// The ray sees everything that any kind of ray can see, because photons lie there too.
constexpr uint32_t kAnyRay = kRayCamera | kRayDiffuse | kRayGlossy | kRayTransmission | kRayShadow | kRayVolumeScatter;
/// Squared distance of the tested point in each sector over the squared radius. Each eighth of the disc's area has one
/// point.
constexpr float kPlace[kSectors] = {0.5f / 8, 4.5f / 8, 2.5f / 8, 6.5f / 8, 1.5f / 8, 5.5f / 8, 3.5f / 8, 7.5f / 8};

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
  known_ = std::make_unique<std::atomic<uint64_t>[]>(photons);
}

float PhotonDiscs::inverse_share(uint32_t photon, const SurfacePoint& at, Vec3 position, float radius2) const {
  uint64_t known = known_[photon].load(std::memory_order_relaxed);
  if (known == kUnknown) known_[photon].store(known = look_around(photon, at), std::memory_order_relaxed);
  const Frame frame(unpack_direction(at.packed_normal));
  const Vec3 offset = position - at.position;
  const float x = glm::dot(offset, frame.s), y = glm::dot(offset, frame.t);
  const float full2 = radius_ * radius_, step2 = full2 / float(kSteps * kSteps);
  const uint32_t reach = uint32_t(known >> (8 * sector_of(x, y))) & kSteps;
  if (reach < kSteps && x * x + y * y > float(reach * reach) * step2) return 0.0f;
  float found = 1.0f;
  for (int i = 0; i < kSectors; ++i) {
    const uint32_t sector = uint32_t(known >> (8 * i)) & 255u, steps = sector & kSteps;
    if (steps < kSteps)
      found += std::min(1.0f, float(steps * steps) * step2 / radius2);
    else if (sector & kSurface || kPlace[i] * full2 > radius2)
      found += 1.0f;  // the tested point is outside this disc, so it says nothing about the disc
  }
  return float(kSectors + 1) / found;
}

uint64_t PhotonDiscs::look_around(uint32_t photon, const SurfacePoint& at) const {
  const Vec3 n = unpack_direction(at.packed_normal);
  const Frame frame(n);
  const float turn = float(hash_combine(seed_, photon) >> 8) * 0x1p-24f;
  // Height above the photon. A surface within it counts as the photon's surface.
  const float height = radius_ / PointTree::kFlatness;
  uint64_t known = 0;
  ShadingPoint point;
  for (int i = 0; i < kSectors; ++i) {
    const float angle = (float(i) + turn) * (2.0f * kPi / kSectors), distance = std::sqrt(kPlace[i]) * radius_;
    const float length = std::sqrt(distance * distance + height * height);
    Ray ray;
    ray.origin = at.position + n * height;
    ray.direction = ((frame.s * std::cos(angle) + frame.t * std::sin(angle)) * distance - n * height) / length;
    ray.t_max = 1.5f * length;
    ray.time = time_;
    const Hit hit = scene_->intersect(ray, kAnyRay);
    uint32_t sector = kSteps;
    if (hit.found()) {
      scene_->shading_point(ray, hit, point);
      if (std::abs(glm::dot(point.ng, n)) >= PointTree::kMinNormalCosine)
        sector |= kSurface;
      else
        sector = std::clamp(uint32_t(hit.t / length * distance / radius_ * float(kSteps) + 0.5f), 1u, kSteps);
    }
    known |= uint64_t(sector) << (8 * i);
  }
  return known;
}

}  // namespace ajar
