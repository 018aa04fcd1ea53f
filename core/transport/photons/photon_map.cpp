#include "transport/photons/photon_map.h"

#include <algorithm>
#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "transport/paths/path_vertex.h"

namespace ajar {

bool transmits(const Bsdf& bsdf) {
  for (int i = 0; i < bsdf.lobe_count(); ++i)
    if (transmits(bsdf.lobe(i).kind)) return true;
  return false;
}

SeenFrom seen_from(const Bsdf& rough, Vec3 ng) {
  if (!transmits(rough)) return {ng, 0};
  for (int i = 0; i < rough.lobe_count(); ++i)
    if (reflects(rough.lobe(i).kind)) return {ng, Photon::kTransmits};
  return {-ng, 0};
}

bool seen_by_bent_lobes(const ShadingPoint& point, const Bsdf& sharp, Vec3 to_eye) {
  if (!bends_normal(point, to_eye)) return false;
  bool reflects_light = false;
  for (int i = 0; i < sharp.lobe_count(); ++i) {
    const Lobe& lobe = sharp.lobe(i);
    if (lobe.kind == LobeKind::Transparent) continue;
    if (lobe.is_delta() || transmits(lobe.kind)) return false;
    reflects_light = true;
  }
  return reflects_light;
}

void PhotonMap::build(std::vector<Photon> photons, std::vector<uint32_t>& order) {
  std::vector<SurfacePoint> points(photons.size());
  for (size_t i = 0; i < photons.size(); ++i) points[i] = photons[i].point;
  discs_ = {};
  tree_.build(std::move(points), order);
  lights_.resize(photons.size());
  for (size_t i = 0; i < photons.size(); ++i)
    lights_[i] = {{photons[order[i]].flux_over_cosine, photons[order[i]].left}, photons[order[i]].packed_direction};
}

void PhotonMap::find(Vec3 position, Vec3 normal, const Lookup& lookup, PointTree::Neighbours& found,
                     uint32_t not_side) const {
  const float pixel = lookup.enough > 0 ? lookup.pixel.at(position) : lookup.radius;
  tree_.nearest(position, normal, lookup.neighbours, std::min(pixel, lookup.radius), found, not_side);
  if (lookup.enough > 1 && found.count < lookup.enough && pixel < lookup.radius)
    tree_.nearest(position, normal, lookup.enough, lookup.radius, found, not_side);
}

float PhotonMap::radius2_at(const SurfacePoint& point) const {
  PointTree::Neighbours found;
  find(point.position, unpack_direction(point.packed_normal), around_, found);
  return found.radius2;
}

float PhotonMap::share_within(PackedBounces left, const BounceCounts& before, const Bsdf& bsdf, Vec3 to_eye,
                              Vec3 to_light) {
  const Bsdf::KindShares shares = bsdf.kind_shares(to_eye, to_light, false);
  const auto after = [&](float share, int diffuse, int glossy, int transmission) {
    BounceCounts counts = before;
    counts.diffuse += diffuse, counts.glossy += glossy, counts.transmission += transmission;
    return PackedBounces(counts).within(left) ? share : 0.0f;
  };
  return after(shares.diffuse, 1, 0, 0) + after(shares.glossy, 0, 1, 0) + after(shares.transmission, 0, 0, 1) +
         after(shares.diffuse_transmission, 0, 0, 1);
}

Color PhotonMap::irradiance(Vec3 position, Vec3 ng, Vec3 ns, const Lookup& lookup, BouncesOfIrradiance* limit) const {
  PointTree::Neighbours found;
  find(position, ng, lookup, found);
  BounceCounts counts = lookup.bounces;
  ++counts.diffuse;
  const PackedBounces bounces(counts);
  BouncesOfIrradiance used;
  Color sum(0.0f);
  for (int i = 0; i < found.count; ++i) {
    const Light& light = lights_[found.index[i]];
    const float inverse_share = inverse_share_of(found, i, position);
    const PackedBounces left = light.over_cosine.left();
    if (!bounces.within(left)) {
      used.all = false;
      continue;
    }
    used.left = min(used.left, left);
    sum += std::max(glm::dot(unpack_direction_short(light.packed_direction), ns), 0.0f) * inverse_share *
           light.over_cosine.flux();
  }
  if (limit) *limit = used;
  return found.count > 0 ? sum / (kPi * found.radius2) : sum;
}

float PhotonMap::reach(const SurfacePoint& point, int k, float max_distance) const {
  if (empty()) return max_distance;
  PointTree::Neighbours found;
  tree_.nearest(point.position, unpack_direction(point.packed_normal), k, max_distance, found);
  return std::sqrt(found.radius2);
}

void PhotonMap::add_to(PhotonPoints& points, uint64_t stride, uint32_t flags) const {
  const uint64_t before = points.stored;
  for (size_t i = 0; i < size(); ++i) {
    const Light& light = lights_[i];
    if ((light.packed_direction & flags) != flags) continue;
    const uint64_t number = points.stored++ - before;
    if (stride == 0 || number % stride != 0) continue;
    const SurfacePoint& at = tree_[uint32_t(i)];
    const float cosine = std::abs(
        glm::dot(unpack_direction_short(light.packed_direction), unpack_direction(at.packed_normal)));
    points.positions.push_back(at.position);
    points.powers.push_back(light.over_cosine.flux() * cosine);
  }
}

size_t PhotonMap::count(uint32_t flags) const {
  return size_t(std::count_if(lights_.begin(), lights_.end(),
                              [&](const Light& light) { return (light.packed_direction & flags) == flags; }));
}

void IrradianceMap::build(const std::vector<IrradianceSite>& sites, const PhotonMap& photons,
                          const PhotonMap::Lookup& lookup) {
  std::vector<SurfacePoint> points(sites.size());
  for (size_t i = 0; i < sites.size(); ++i) points[i] = sites[i].point;
  std::vector<uint32_t> order;
  tree_.build(std::move(points), order);
  entries_.resize(sites.size());
  PhotonMap::Lookup with_bounces = lookup;
  with_bounces.bounces = kAfter;
  tbb::parallel_for(tbb::blocked_range<size_t>(0, sites.size(), 256), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      const SurfacePoint& point = tree_[uint32_t(i)];
      PhotonMap::BouncesOfIrradiance limit;
      const Color irradiance = photons.irradiance(point.position, unpack_direction(point.packed_normal),
                                                  sites[order[i]].shading_normal, with_bounces, &limit);
      entries_[i] = {irradiance, limit.left, limit.all};
    }
  });
}

double radius2_factor(uint32_t pass) {
  double factor = 1.0;
  for (uint32_t i = 1; i <= pass; ++i) factor *= (i + 2.0 / 3.0) / (i + 1.0);
  return factor;
}

}  // namespace ajar
