#include "transport/photons/irradiance_records.h"

#include <algorithm>
#include <cmath>

#include "math/random.h"

namespace ajar {

namespace {

constexpr float kMinNormalCosine = 0.94f;  ///< 20 degrees
/// Relative to the radius. Points further behind a record see surfaces that it does not see.
constexpr float kFarthestBehind = 0.05f;
constexpr float kMinCoverage = 0.1f;  ///< sum of weights from which records are interpolated

}  // namespace

// ---- One record ----------------------------------------------------------------------------

float IrradianceRecord::weight(Vec3 p, Vec3 n) const {
  const Vec3 away = p - position;
  const float distance2 = length_squared(away), cosine = glm::dot(n, normal);
  if (!(distance2 < radius * radius) || !(cosine > kMinNormalCosine)) return 0.0f;
  if (glm::dot(away, n + normal) < -2.0f * kFarthestBehind * radius) return 0.0f;
  return 1.0f - std::max(std::sqrt(distance2) / radius, safe_sqrt((1.0f - cosine) / (1.0f - kMinNormalCosine)));
}

Color IrradianceRecord::at(Vec3 p, Vec3 n) const {
  const Color change = glm::cross(normal, n) * by_rotation + (p - position) * by_translation;
  return irradiance + glm::clamp(change, -irradiance, irradiance);
}

// ---- Records from samples of the hemisphere -------------------------------------------------

HemisphereGrid::HemisphereGrid(int strata)
    : rows_(std::max(2, int(std::lround(std::sqrt(float(strata) * kInvPi))))),
      columns_(std::max(4, int(std::lround(float(rows_) * kPi)))) {}

Vec3 HemisphereGrid::direction(int i, Vec2 u) const {
  const float sin2 = (float(i / columns_) + u.x) / float(rows_),
              phi = 2.0f * kPi * (float(i % columns_) + u.y) / float(columns_);
  const float sine = std::sqrt(sin2);
  return {sine * std::cos(phi), sine * std::sin(phi), safe_sqrt(1.0f - sin2)};
}

IrradianceRecord HemisphereGrid::record(Vec3 position, const Frame& frame, std::span<const Color> radiance,
                                        std::span<const float> inverse_distance) const {
  IrradianceRecord r;
  r.position = position;
  r.normal = frame.n;
  const int m = rows_, n = columns_;
  const auto index = [&](int j, int k) { return size_t(j * n + (k + n) % n); };
  const auto add_outer = [](Mat3& gradient, Color amount, Vec3 direction) {
    for (int c = 0; c < 3; ++c) gradient[c] += amount[c] * direction;
  };
  float inverse_sum = 0.0f;
  for (int i = 0; i < strata(); ++i) {
    r.irradiance += radiance[size_t(i)];
    inverse_sum += inverse_distance[size_t(i)];
  }
  const float projected = kPi / float(strata());  // projected solid angle of a stratum
  r.irradiance *= projected;
  r.radius = inverse_sum > 0.0f ? float(strata()) / inverse_sum : kInfinity;

  const auto sine_of = [&](int j) { return std::sqrt(float(j) / float(m)); };
  // Integral of the tangent over the projected solid angle up to sin^2 = s. The tangent weights radiance when the
  // normal turns. The analytic integral has no variance, unlike sampled tangents.
  const auto tangents = [](float s) { return std::asin(std::sqrt(s)) - std::sqrt(s * (1.0f - s)); };
  for (int k = 0; k < n; ++k) {
    const float at = 2.0f * kPi * (float(k) + 0.5f) / float(n), edge = 2.0f * kPi * float(k) / float(n);
    const Vec3 u = std::cos(at) * frame.s + std::sin(at) * frame.t,
               across = std::cos(at) * frame.t - std::sin(at) * frame.s;
    const Vec3 across_edge = std::cos(edge) * frame.t - std::sin(edge) * frame.s;
    for (int j = 0; j < m; ++j) {
      const size_t here = index(j, k), beside = index(j, k - 1);
      const float tangent = float(m) * (tangents(float(j + 1) / float(m)) - tangents(float(j) / float(m)));
      add_outer(r.by_rotation, projected * tangent * radiance[here], across);
      // The border between two strata moves with the nearer of their surfaces [Ward and Heckbert 1992, eq. 9].
      const float nearest = std::max(inverse_distance[here], inverse_distance[beside]);
      add_outer(r.by_translation, (sine_of(j + 1) - sine_of(j)) * nearest * (radiance[here] - radiance[beside]),
                across_edge);
      if (j == 0) continue;
      const size_t inner = index(j - 1, k);
      const float sin_edge = sine_of(j), cos2 = 1.0f - float(j) / float(m);
      add_outer(r.by_translation,
                2.0f * kPi / float(n) * sin_edge * cos2 * std::max(inverse_distance[here], inverse_distance[inner]) *
                    (radiance[here] - radiance[inner]),
                u);
    }
  }
  return r;
}

// ---- Set of records ------------------------------------------------------------------------------

void IrradianceRecords::clear() {
  records_.clear();
  levels_.clear();
}

size_t IrradianceRecords::memory_bytes() const {
  size_t bytes = records_.capacity() * sizeof(IrradianceRecord);
  for (const Level& level : levels_)
    for (const auto& cell : level.cells)
      bytes += sizeof(cell) + 2 * sizeof(void*) +
               cell.second.capacity() * sizeof(uint32_t);  // with the entry in the hash table
  return bytes;
}

uint64_t IrradianceRecords::cell_key(const Level& level, Vec3 p) {
  const Vec3 cell = glm::floor(p / level.cell_size);
  uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) key = hash64(key ^ uint64_t(int64_t(glm::clamp(cell[axis], -9e18f, 9e18f))));
  return key;
}

void IrradianceRecords::insert(uint32_t index) {
  const IrradianceRecord& record = records_[index];
  const float size = std::exp2(std::ceil(std::log2(2.0f * record.radius)));
  auto level = std::find_if(levels_.begin(), levels_.end(), [&](const Level& l) { return l.cell_size == size; });
  if (level == levels_.end()) level = levels_.insert(levels_.end(), {size, {}});
  uint64_t keys[8];
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 sign(corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f);
    keys[corner] = cell_key(*level, record.position + record.radius * sign);
    if (std::find(keys, keys + corner, keys[corner]) == keys + corner) level->cells[keys[corner]].push_back(index);
  }
}

template <class Visit>
void IrradianceRecords::for_each_near(Vec3 p, Visit&& visit) const {
  for (const Level& level : levels_) {
    const auto cell = level.cells.find(cell_key(level, p));
    if (cell == level.cells.end()) continue;
    for (uint32_t index : cell->second) visit(index);
  }
}

void IrradianceRecords::add(std::span<const IrradianceRecord> records) {
  for (const IrradianceRecord& record : records) {
    if (!(record.radius > 0.0f)) continue;
    records_.push_back(record);
    insert(uint32_t(records_.size() - 1));
  }
}

void IrradianceRecords::limit_by_neighbours() {
  // A record that is valid at the position of another one sees no surface that is much closer than the surfaces seen
  // there: its radius exceeds the other radius by at most kRadiusShare of the distance between the two records.
  std::vector<float> radii(records_.size());
  for (size_t i = 0; i < records_.size(); ++i) radii[i] = records_[i].radius;
  for (const IrradianceRecord& other : records_) {
    for_each_near(other.position, [&](uint32_t index) {
      const float distance = glm::length(records_[index].position - other.position);
      if (distance < records_[index].radius)
        radii[index] = std::min(radii[index], other.radius + kRadiusShare * distance);
    });
  }
  for (size_t i = 0; i < records_.size(); ++i) records_[i].radius = radii[i];
}

float IrradianceRecords::coverage(Vec3 p, Vec3 n) const {
  float sum = 0.0f;
  for_each_near(p, [&](uint32_t index) { sum += records_[index].weight(p, n); });
  return sum;
}

bool IrradianceRecords::find(Vec3 p, Vec3 n, Color& irradiance) const {
  float sum = 0.0f;
  irradiance = Color(0.0f);
  for_each_near(p, [&](uint32_t index) {
    const float weight = records_[index].weight(p, n);
    if (!(weight > 0.0f)) return;
    sum += weight;
    irradiance += weight * records_[index].at(p, n);
  });
  if (!(sum > kMinCoverage)) return false;
  irradiance /= sum;
  return true;
}

}  // namespace ajar
