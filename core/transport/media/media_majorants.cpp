// The grids of majorants of media that vary, and their mean extinction.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <utility>

#include <tbb/parallel_for.h>

#include "transport/media/media.h"

namespace ajar {

namespace {

constexpr int kSamplesPerCell = 16;
/// kMargin: majorant over the largest sample around it. kLargest: maximum majorant per metre.
constexpr float kMargin = 1.1f, kLargest = 1e13f;
/// The minimum majorant finds peaks between the samples: this share of the largest one, but at most so many collisions
/// along the longest axis. Densities that differ by powers of ten would otherwise be thin where nearly all collisions are
/// null.
constexpr float kMinShare = 0.02f, kMostIdle = 4.0f;
/// An axis along which the extinction varies less than this share of the most varying axis has fewer cells.
constexpr float kEvenAxis = 0.1f;
constexpr int kCellsOfEvenAxis = 4;
/// A cell is divided if a ray that crosses it would have at least so many null collisions, unless nearly no ray crosses it:
/// its smallest extinction has at least kOpaque of optical depth.
constexpr float kIdle = 2.0f, kOpaque = 20.0f;
/// Voxels of grids that are looked at; of larger grids, every second voxel along each axis, or every fourth.
constexpr size_t kMaxVoxels = size_t(1) << 22;

/// The sum of the differences between neighbouring cells along an axis.
double variation(const std::vector<float>& seen, const std::array<int, 3>& cells, int axis) {
  const auto [nx, ny, nz] = cells;
  const int step = axis == 0 ? 1 : axis == 1 ? nx : nx * ny;
  double sum = 0.0;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        if ((axis == 0 ? x + 1 == nx : axis == 1 ? y + 1 == ny : z + 1 == nz)) continue;
        const int at = (z * ny + y) * nx + x;
        sum += std::abs(double(seen[size_t(at + step)]) - double(seen[size_t(at)]));
      }
  return sum;
}

/// Gives the cells of axes along which nothing varies to the others. Returns false if there are none.
bool divide_anew(const std::vector<float>& seen, std::array<int, 3>& cells) {
  std::array<double, 3> varies;
  for (int axis = 0; axis < 3; ++axis) varies[size_t(axis)] = variation(seen, cells, axis);
  const double most = *std::max_element(varies.begin(), varies.end());
  if (!(most > 0.0) || !std::isfinite(most)) return false;
  int uneven = 0, spare = 1;
  std::array<int, 3> divided = cells;
  for (size_t axis = 0; axis < 3; ++axis) {
    if (varies[axis] >= double(kEvenAxis) * most) {
      ++uneven;
    } else if (cells[axis] > kCellsOfEvenAxis) {
      spare *= cells[axis] / kCellsOfEvenAxis;
      divided[axis] = kCellsOfEvenAxis;
    }
  }
  if (spare <= 1) return false;
  const int factor = uneven == 1 ? spare : int(std::sqrt(float(spare)));
  for (size_t axis = 0; axis < 3; ++axis)
    if (varies[axis] >= double(kEvenAxis) * most) divided[axis] *= factor;
  cells = divided;
  return true;
}

}  // namespace

/// What the samples of a grid found.
struct Media::Samples {
  std::vector<float> seen;      ///< largest extinction in each cell
  std::vector<float> compared;  ///< the same of points at the same places of all cells
  std::vector<float> mean;      ///< mean extinction in each cell
  std::vector<float> smallest;  ///< smallest extinction in each cell
  Color extinction{0.0f};       ///< mean, where light is
  bool scatters = false, emits = false;
};

Media::Samples Media::sample_cells(Medium& medium, Vec3 extent) const {
  for (int axis = 0; axis < 3; ++axis) {
    medium.size[axis] = extent[axis] / float(medium.cells[size_t(axis)]);
    medium.inverse_size[axis] = 1.0f / medium.size[axis];
  }
  const auto [nx, ny, nz] = medium.cells;
  Samples all;
  all.seen.resize(size_t(nx) * size_t(ny) * size_t(nz));
  all.compared.resize(all.seen.size());
  all.mean.resize(all.seen.size());
  all.smallest.resize(all.seen.size());
  struct Sum {
    Color extinction{0.0f};
    bool scatters = false, emits = false;
  };
  std::vector<Sum> sums(all.seen.size());
  const BuiltInstance& instance = scene_.instances()[medium.instance];
  tbb::parallel_for(size_t(0), all.seen.size(), [&](size_t index) {
    Pcg32 own(index, 0x6d656469U), shared(0, 0x6d656469U);
    const Vec3 corner = medium.lower + medium.size * Vec3(float(index % size_t(nx)),
                                                          float(index / size_t(nx) % size_t(ny)),
                                                          float(index / (size_t(nx) * size_t(ny))));
    ShadingPoint path;
    MediaStack none;
    Ray ray;
    ShadingPoint inside = inside_of({none, ray, 0.0f, path, kRayCamera});
    MediaCounters ignored;
    float &seen = all.seen[index], smallest = kInfinity;
    for (int k = 0; k < kSamplesPerCell; ++k) {
      // Points at the same places of all cells show which axes the extinction varies along.
      Pcg32& rng = k < kSamplesPerCell / 2 ? shared : own;
      inside.position = corner + medium.size * Vec3(rng.next_float(), rng.next_float(), rng.next_float());
      inside.time = instance.motion ? rng.next_float() : 0.0f;  // in a mesh that deforms, the media stay
      inside.ray_kind = k % 4 == 3 ? uint32_t(kRayShadow) : uint32_t(kRayCamera);
      MediumPoint point;
      add(medium, inside, point, ignored);
      seen = std::max(seen, max_component(point.extinction));
      if (k < kSamplesPerCell / 2) all.compared[index] = std::max(all.compared[index], max_component(point.extinction));
      smallest = std::min(smallest, max_component(point.extinction));
      all.mean[index] += max_component(point.extinction) / float(kSamplesPerCell);
      sums[index].extinction += point.extinction;
      sums[index].scatters |= point.scatters();
      sums[index].emits |= !is_black(point.emission);
      // Emission is found at collisions, so the majorant must not be zero.
      if (!is_black(point.emission)) seen = std::max(seen, 1.0f / glm::length(medium.size));
    }
    all.smallest[index] = smallest;
  });
  // Nearly no light is in cells that are opaque everywhere. They count only if there are no others with extinction.
  const float side = glm::length(medium.size) / std::sqrt(3.0f);
  Color seen_by_light(0.0f);
  size_t lit = 0;
  for (size_t cell = 0; cell < sums.size(); ++cell) {
    const Sum& sum = sums[cell];
    all.extinction += sum.extinction / float(kSamplesPerCell * sums.size());
    all.scatters |= sum.scatters;
    all.emits |= sum.emits;
    if (all.smallest[cell] * side >= kOpaque) continue;
    seen_by_light += sum.extinction / float(kSamplesPerCell);
    ++lit;
  }
  if (max_component(seen_by_light) > 0.0f) all.extinction = seen_by_light / float(lit);
  return all;
}

/// Looks at the voxels of grids too. Between voxels, grids are interpolated, so that their largest value is at a voxel.
void Media::sample_voxels(const Medium& medium, Samples& all) const {
  const BuiltInstance& instance = scene_.instances()[medium.instance];
  const BuiltMesh& mesh = scene_.meshes()[instance.mesh];
  for (const VoxelGrid& grid : mesh.grids) {
    const size_t voxels = grid.brick_count() * VolumeGrid::kVoxels;
    const int stride = voxels <= kMaxVoxels ? 1 : voxels <= 8 * kMaxVoxels ? 2 : 4;
    tbb::parallel_for(size_t(0), grid.brick_count(), [&](size_t brick) {
      ShadingPoint path;
      MediaStack none;
      Ray ray;
      ShadingPoint inside = inside_of({none, ray, 0.0f, path, kRayCamera});
      MediaCounters ignored;
      grid.for_each_voxel(brick, stride, [&](Vec3 center) {
        inside.position = transform_point(instance.world_from_object, center);
        const Vec3 place = (inside.position - medium.lower) * medium.inverse_size;
        std::array<int, 3> cell;
        for (int axis = 0; axis < 3; ++axis) {
          const int count = medium.cells[size_t(axis)];
          if (!(place[axis] >= 0.0f && place[axis] < float(count))) return;
          cell[size_t(axis)] = std::min(int(place[axis]), count - 1);
        }
        MediumPoint point;
        add(medium, inside, point, ignored);
        const float extinction = max_component(point.extinction);
        std::atomic_ref<float> seen(
            all.seen[size_t((cell[2] * medium.cells[1] + cell[1]) * medium.cells[0] + cell[0])]);
        for (float known = seen.load(); known < extinction && !seen.compare_exchange_weak(known, extinction);) {
        }
      });
    });
  }
}

void Media::find_majorants(Medium& medium, int cells_along, size_t max_divided) {
  const Vec3 extent = glm::max(medium.size, Vec3(1e-6f * max_component(medium.size) + 1e-30f));
  const float cell = max_component(extent) / float(cells_along);
  for (int axis = 0; axis < 3; ++axis)
    medium.cells[size_t(axis)] = std::clamp(int(std::ceil(extent[axis] / cell)), 1, cells_along);
  medium.most = kMaxOpticalDepthPerCell /
                glm::length(extent / Vec3(float(medium.cells[0]), float(medium.cells[1]), float(medium.cells[2])));
  Samples all = sample_cells(medium, extent);
  if (divide_anew(all.compared, medium.cells)) all = sample_cells(medium, extent);
  sample_voxels(medium, all);
  medium.emits |= all.emits;
  if (all.scatters && is_finite(all.extinction)) medium.mean_extinction = all.extinction;
  const float largest = *std::max_element(all.seen.begin(), all.seen.end());
  const float least = medium.least = std::min(
      std::max(std::min(kMinShare * largest, kMostIdle / max_component(extent)), 0.25f / glm::length(extent)),
      kLargest);
  medium.first_majorant = majorants_.size();
  const auto [nx, ny, nz] = medium.cells;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        // The neighbouring cells are included for peaks between the samples.
        float most = least;
        for (int w = std::max(z - 1, 0); w <= std::min(z + 1, nz - 1); ++w)
          for (int v = std::max(y - 1, 0); v <= std::min(y + 1, ny - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, nx - 1); ++u)
              most = std::max(most, std::min(kMargin * all.seen[size_t((w * ny + v) * nx + u)], kLargest));
        majorants_.push_back(most);
      }
  divide_cells(medium, all, max_divided);
}

void Media::divide_cells(Medium& medium, const Samples& all, size_t max_divided) {
  // The voxels of grids are looked at one by one, so that their majorants are tight. Media that move have no fixed cells.
  const BuiltInstance& instance = scene_.instances()[medium.instance];
  if (instance.motion || !scene_.meshes()[instance.mesh].grids.empty()) return;
  const float side = glm::length(medium.size) / std::sqrt(3.0f);
  std::vector<std::pair<float, size_t>> idle;  // null collisions of a ray, and the cell
  for (size_t cell = 0; cell < all.seen.size(); ++cell) {
    const float null = (majorants_[medium.first_majorant + cell] - all.mean[cell]) * side;
    if (null >= kIdle && all.smallest[cell] * side < kOpaque) idle.emplace_back(null, cell);
  }
  if (idle.size() > max_divided) {
    std::sort(idle.begin(), idle.end(), std::greater<>());
    idle.resize(max_divided);
  }
  std::vector<size_t> divided;
  for (const auto& [null, cell] : idle) divided.push_back(cell);
  medium.fine = FineMajorants(all.seen.size(), divided);
}

/// `corner`: the lower one of the cell. The extinction at the corners of the small cells, and at one point in each. If the
/// largest of them are always at corners, the extinction changes slowly, and the largest one in a small cell is taken.
/// Otherwise there can be peaks between the points, and the neighbours are included.
void Media::find_fine_majorants(const Medium& medium, size_t cell, Vec3 corner, FineMajorants::Cells& found) const {
  constexpr int kCells = FineMajorants::kAlong, kCorners = kCells + 1;
  ShadingPoint path;
  MediaStack none;
  Ray ray;
  ShadingPoint inside = inside_of({none, ray, 0.0f, path, kRayCamera});
  MediaCounters ignored;
  Pcg32 rng(cell, 0x66696e65U);
  const Vec3 size = medium.size / float(kCells);
  const auto largest_at = [&](Vec3 place) {
    inside.position = corner + size * place;
    float largest = 0.0f;
    for (const uint32_t kind : {uint32_t(kRayCamera), uint32_t(kRayShadow)}) {
      inside.ray_kind = kind;
      MediumPoint point;
      add(medium, inside, point, ignored);
      largest = std::max(largest, max_component(point.extinction));
      if (!is_black(point.emission)) largest = std::max(largest, 1.0f / glm::length(medium.size));
    }
    return largest;
  };
  std::vector<float> at_corners(size_t(kCorners) * kCorners * kCorners);
  for (int i = 0; i < int(at_corners.size()); ++i)
    at_corners[size_t(i)] = largest_at(
        Vec3(float(i % kCorners), float(i / kCorners % kCorners), float(i / (kCorners * kCorners))));
  std::array<float, std::tuple_size_v<FineMajorants::Cells>> largest;
  bool has_peaks = false;
  for (int i = 0; i < int(largest.size()); ++i) {
    const int x = i % kCells, y = i / kCells % kCells, z = i / (kCells * kCells);
    float most = 0.0f;
    for (int k = 0; k < 8; ++k)
      most = std::max(most,
                      at_corners[size_t(((z + (k >> 2)) * kCorners + y + (k >> 1 & 1)) * kCorners + x + (k & 1))]);
    const float between = largest_at(Vec3(x, y, z) + Vec3(rng.next_float(), rng.next_float(), rng.next_float()));
    has_peaks |= between > most;
    largest[size_t(i)] = std::max(most, between);
  }
  const int reach = has_peaks ? 1 : 0;
  for (int i = 0; i < int(found.size()); ++i) {
    const std::array<int, 3> at{i % kCells, i / kCells % kCells, i / (kCells * kCells)};
    float most = 0.0f;
    for (int z = std::max(at[2] - reach, 0); z <= std::min(at[2] + reach, kCells - 1); ++z)
      for (int y = std::max(at[1] - reach, 0); y <= std::min(at[1] + reach, kCells - 1); ++y)
        for (int x = std::max(at[0] - reach, 0); x <= std::min(at[0] + reach, kCells - 1); ++x)
          most = std::max(most, largest[size_t((z * kCells + y) * kCells + x)]);
    found[size_t(i)] = FineMajorants::code_of(std::max(kMargin * most, medium.least) /
                                              majorants_[medium.first_majorant + cell]);
  }
}

/// As `majorant`, in a cell that is divided.
float Media::fine_majorant(const Medium& medium, const std::array<int, 3>& cell, Vec3 position, Vec3 direction,
                           float& reach) const {
  const size_t index = size_t((cell[2] * medium.cells[1] + cell[1]) * medium.cells[0] + cell[0]);
  const Vec3 corner = medium.lower + medium.size * Vec3(cell[0], cell[1], cell[2]);
  const FineMajorants::Cells& fine = medium.fine.in(
      index, [&](FineMajorants::Cells& found) { find_fine_majorants(medium, index, corner, found); });
  constexpr int kCells = FineMajorants::kAlong;
  size_t small = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const float size = medium.size[axis] / float(kCells), d = direction[axis];
    const int at = std::clamp(int((position[axis] - corner[axis]) / size), 0, kCells - 1);
    small = small * size_t(kCells) + size_t(at);
    if (d == 0.0f) continue;
    const float border = corner[axis] + size * float(at + (d > 0.0f ? 1 : 0));
    reach = std::min(reach, std::max((border - position[axis]) / d, 1e-3f * size));
  }
  return FineMajorants::share_of(fine[small]) * majorants_[medium.first_majorant + index];
}

}  // namespace ajar
