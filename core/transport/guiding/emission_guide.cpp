#include "transport/guiding/emission_guide.h"

#include <algorithm>
#include <cmath>

#include "lights/sources/lamp.h"
#include "math/frame.h"
#include "math/random.h"
#include "math/warps.h"
#include "transport/paths/path_vertex.h"

namespace ajar {

namespace {

// The grid over the directions of the world: cosines and angles, of equal solid angle.
constexpr int kCosines = 8, kAngles = 16;
constexpr double kEqually = 0.2;         // part of the starts that is shared equally by the sources
constexpr float kToOtherCells = 0.3f;    // part of the value of a start of the world
constexpr float kAlmostParallel = 0.1f;  // cosine with the axis of a cell below which no place is learned

/// The inverse of warp::square_to_sphere.
Vec2 sphere_to_square(Vec3 d) {
  float turn = std::atan2(d.y, d.x) * (0.5f * kInvPi);
  if (turn < 0.0f) turn += 1.0f;
  return glm::clamp(Vec2(0.5f * (1.0f - d.z), turn), Vec2(0.0f), Vec2(kOneMinusEpsilon));
}

/// A number that has chosen [begin, begin + size) of [0, 1) becomes one of [0, 1).
float rescaled(double u, double begin, double size) {
  return std::clamp(float((u - begin) / size), 0.0f, kOneMinusEpsilon);
}

}  // namespace

EmissionMap::EmissionMap(const LightSet& lights, const Extent& extent, const std::vector<LightStart>& starts)
    : extent_(extent), half_width_(extent.radius + glm::length(extent.focus - extent.center)) {
  std::vector<const LightStart*> sorted;
  for (const LightStart& start : starts)
    if (start.value > 0.0f && std::isfinite(start.value) && !lights.moves(start.light)) sorted.push_back(&start);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const LightStart* a, const LightStart* b) { return a->light < b->light; });
  double all = 0.0;
  auto next = sorted.begin();
  for (const LightSet::SourceRange& range : lights.sources()) {
    next = std::find_if(next, sorted.end(), [&](const LightStart* s) { return s->light >= range.first; });
    const auto end = std::find_if(next, sorted.end(),
                                  [&](const LightStart* s) { return s->light >= range.first + range.count; });
    if (next == end) continue;
    Source source{range.first, range.count, range.distant, int(range.first) == lights.environment_index(), 0.0, 0.0, {},
                  {},          {}};
    learn(source, lights, {next, end});
    next = end;
    if (!(source.probability > 0.0) || !(source.power > 0.0) || (!source.distant && source.directions.empty()))
      continue;
    all += source.probability;
    sources_.push_back(std::move(source));
  }
  for (Source& source : sources_)
    source.probability = (1.0 - kEqually) * source.probability / all + kEqually / double(sources_.size());
}

/// `probability` becomes the sum of the values.
void EmissionMap::learn(Source& source, const LightSet& lights, const std::vector<const LightStart*>& starts) {
  for (uint32_t i = 0; i < source.count; ++i) {
    source.power += double(lights.power_pmf(source.first + i));
    if (source.count > 1) source.power_sums.push_back(float(source.power));
  }
  Vec3 mean(0.0f);
  for (const LightStart* start : starts) {
    source.probability += double(start->value);
    mean += start->value * start->direction;
  }
  std::vector<std::vector<AdaptiveSquare::Point>> points(1);
  if (source.distant) {
    if (source.world) {
      for (int i = 0; i < kCosines * kAngles; ++i) {
        const Vec2 middle(float(i / kAngles) + 0.5f, float(i % kAngles) + 0.5f);
        source.cells.push_back(
            {Frame(warp::square_to_sphere(middle / Vec2(float(kCosines), float(kAngles)))), 0.0, {}});
      }
    } else {
      source.cells.push_back({Frame(glm::normalize(mean)), 0.0, {}});
    }
    points.resize(source.cells.size());
  }
  Pcg32 rng(0, 0x63656c6cU);
  for (const LightStart* start : starts) {
    if (!source.distant) {
      points[0].push_back({sphere_to_square(start->direction), start->value});
      continue;
    }
    const auto add = [&](Vec3 direction, float value) {
      const size_t cell = cell_of(source, direction);
      points[cell].push_back({on_plane(source.cells[cell], start->origin, direction), value});
      source.cells[cell].probability += double(value) / source.probability;
    };
    if (!source.world) {
      add(start->direction, start->value);
      continue;
    }
    add(start->direction, (1.0f - kToOtherCells) * start->value);
    const Vec3 other = warp::square_to_sphere(Vec2(rng.next_float(), rng.next_float()));
    const float mixed = rng.next_float();
    add(glm::normalize(other + mixed * mixed * 8.0f * start->direction), kToOtherCells * start->value);
  }
  if (!source.distant) source.directions = AdaptiveSquare(std::move(points[0]));
  for (size_t i = 0; i < source.cells.size(); ++i) source.cells[i].places = AdaptiveSquare(std::move(points[i]));
}

size_t EmissionMap::memory_bytes() const {
  size_t bytes = 0;
  for (const Source& source : sources_) {
    bytes += sizeof(Source) + source.power_sums.size() * sizeof(float) + source.directions.memory_bytes() +
             source.cells.size() * sizeof(Cell);
    for (const Cell& cell : source.cells) bytes += cell.places.memory_bytes();
  }
  return bytes;
}

const EmissionMap::Source* EmissionMap::source_of(uint32_t light) const {
  const auto after = std::upper_bound(sources_.begin(), sources_.end(), light,
                                      [](uint32_t at, const Source& source) { return at < source.first; });
  if (after == sources_.begin()) return nullptr;
  const Source& source = *(after - 1);
  return light - source.first < source.count ? &source : nullptr;
}

size_t EmissionMap::cell_of(const Source& source, Vec3 direction) {
  if (!source.world) return 0;
  const Vec2 at = sphere_to_square(direction);
  return size_t(at.x * float(kCosines)) * size_t(kAngles) + size_t(at.y * float(kAngles));
}

Vec2 EmissionMap::on_plane(const Cell& cell, Vec3 position, Vec3 direction) const {
  const Vec3 from_focus = position - extent_.focus;
  const float cosine = glm::dot(direction, cell.plane.n);
  if (!(cosine > kAlmostParallel)) return Vec2(-1.0f);
  const Vec3 there = from_focus - direction * (glm::dot(from_focus, cell.plane.n) / cosine);
  return Vec2(glm::dot(there, cell.plane.s), glm::dot(there, cell.plane.t)) / (2.0f * half_width_) + 0.5f;
}

float EmissionMap::direction_pdf(const Source& source, Vec3 direction, float pdf_without) const {
  if (!source.world) return pdf_without;
  const auto probability = float(source.cells[cell_of(source, direction)].probability);
  return 0.5f * (pdf_without + probability * float(kCosines * kAngles) * warp::sphere_pdf_solid_angle());
}

float EmissionMap::place_pdf(const Source& source, Vec3 position, Vec3 direction) const {
  const Cell& cell = source.cells[cell_of(source, direction)];
  if (cell.places.empty()) return kInvPi / sqr(extent_.radius);
  const Vec2 at = on_plane(cell, position, direction);
  const float density = cell.places.density(at);
  return density > 0.0f ? density / (sqr(2.0f * half_width_) * glm::dot(direction, cell.plane.n)) : 0.0f;
}

LightWalkGuide::Start EmissionMap::sample(const LightSet& lights, float u_choice, Vec2 u_position,
                                          Vec2 u_direction) const {
  double left = double(u_choice);
  size_t k = 0;
  while (k + 1 < sources_.size() && left >= sources_[k].probability) left -= sources_[k++].probability;
  const Source& source = sources_[k];
  const float u = rescaled(left, 0.0, source.probability);
  if (source.distant) return sample_distant(lights, source, u, u_position, u_direction);
  LightWalkGuide::Start start;
  start.light = source.first;
  if (source.count > 1) {
    const auto chosen = std::upper_bound(source.power_sums.begin(), source.power_sums.end(),
                                         u * source.power_sums.back());
    start.light += uint32_t(std::min(chosen, source.power_sums.end() - 1) - source.power_sums.begin());
  }
  const Light light = lights.light(start.light);
  sample_place(light, u_position, start.position, start.normal);
  start.direction = warp::square_to_sphere(source.directions.sample(u_direction));
  if (is_sphere(light.type)) {
    // A place on the other side of the sphere becomes its mirror image on the side to which the direction points.
    const float cosine = glm::dot(start.normal, start.direction);
    if (cosine < 0.0f) start.normal -= 2.0f * cosine * start.direction;
    start.position = light.position + (light.soft ? -light.radius : light.radius) * start.normal;
  }
  return start;
}

LightWalkGuide::Start EmissionMap::sample_distant(const LightSet& lights, const Source& source, float u_choice,
                                                  Vec2 u_position, Vec2 u_direction) const {
  LightWalkGuide::Start start;
  start.light = source.first;
  const bool by_cell = source.world && u_choice < 0.5f;
  if (by_cell) {
    double left = 2.0 * double(u_choice);
    size_t cell = 0;
    while (cell + 1 < source.cells.size() && left >= source.cells[cell].probability)
      left -= source.cells[cell++].probability;
    const Vec2 corner(float(cell / size_t(kAngles)), float(cell % size_t(kAngles)));
    start.direction = warp::square_to_sphere((corner + u_direction) / Vec2(float(kCosines), float(kAngles)));
  } else {
    const auto without = lights.sample_le(source.first, u_position, u_direction, kMidShutter);
    start.direction = without ? without->ray.direction : source.cells[0].plane.n;
  }
  start.normal = start.direction;
  const Cell& cell = source.cells[cell_of(source, start.direction)];
  Vec3 on_ray = extent_.focus;
  if (cell.places.empty()) {
    const Frame across(start.direction);
    const Vec2 at = extent_.radius * warp::square_to_disk(u_position);
    on_ray = extent_.center + at.x * across.s + at.y * across.t;
  } else {
    const Vec2 at = 2.0f * half_width_ * (cell.places.sample(u_position) - 0.5f);
    on_ray = extent_.focus + at.x * cell.plane.s + at.y * cell.plane.t;
  }
  // Outside the scene.
  start.position = on_ray - start.direction * (extent_.radius + glm::dot(on_ray - extent_.center, start.direction));
  return start;
}

EmissionMap::Densities EmissionMap::densities(const LightSet& lights, uint32_t light, Vec3 position, Vec3 direction,
                                              float origin_without) const {
  Densities d;
  const Source* source = source_of(light);
  if (!source) return d;
  if (source->distant) {
    const float without = origin_without / lights.power_pmf(light);
    d.origin = source->probability * double(direction_pdf(*source, direction, without));
    d.joint = d.origin * double(place_pdf(*source, position, direction));
  } else {
    d.origin = source->probability / source->power * double(origin_without);
    // On a sphere, all places are on the side to which the direction points.
    const double denser = is_sphere(lights.flags(light).type) ? 2.0 : 1.0;
    d.joint = d.origin * denser *
              double(source->directions.density(sphere_to_square(direction)) * warp::sphere_pdf_solid_angle());
  }
  return d;
}

bool EmissionGuide::sets_out(float& u_choice) const {
  if (u_choice < share_) return true;  // start() takes numbers below the share for the map
  u_choice = rescaled(double(u_choice), double(share_), 1.0 - double(share_));
  if (!inner_ || !inner_->sets_out(u_choice)) return false;
  u_choice = std::min(share_ + (1.0f - share_) * u_choice, kOneMinusEpsilon);
  return true;
}

LightWalkGuide::Start EmissionGuide::start(const LightSet& lights, float u_choice, Vec2 u_position,
                                           Vec2 u_direction) const {
  if (u_choice < share_) return map_->sample(lights, u_choice / share_, u_position, u_direction);
  return inner_->start(lights, rescaled(double(u_choice), double(share_), 1.0 - double(share_)), u_position,
                       u_direction);
}

void EmissionGuide::mix(const LightSet& lights, uint32_t light, Vec3 position, Vec3 normal, Vec3 direction,
                        LightEnd& end) const {
  const EmissionMap::Densities learned = map_->densities(lights, light, position, direction, end.pdf_origin);
  if (inner_) inner_->mix(lights, light, position, normal, direction, end);
  const double free = 1.0 - double(share_);
  const double origin = free * double(end.pdf_origin) + double(share_) * learned.origin;
  const double joint = free * double(end.pdf_origin) * double(end.pdf_direction) + double(share_) * learned.joint;
  end.pdf_origin = float(origin);
  end.pdf_direction = origin > 0.0 ? float(joint / origin) : 0.0f;
}

}  // namespace ajar
