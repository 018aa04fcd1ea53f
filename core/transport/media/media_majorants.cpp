// The grids of majorants of media that vary, and their mean extinction.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <utility>

#include <tbb/parallel_for.h>

#include "math/warps.h"
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

Media::Samples Media::sample_cells(const Medium& medium) const {
  const MajorantGrid& grid = medium.grid;
  Samples all;
  all.seen.resize(grid.count());
  all.compared.resize(all.seen.size());
  all.mean.resize(all.seen.size());
  all.smallest.resize(all.seen.size());
  struct Sum {
    Color extinction{0.0f};
    bool scatters = false, emits = false;
  };
  std::vector<Sum> sums(all.seen.size());
  const BuiltInstance* instance = medium.instance == kNone ? nullptr : &scene_.instances()[medium.instance];
  const bool moves = instance && (instance->motion || scene_.meshes()[instance->mesh].velocity >= 0);
  tbb::parallel_for(size_t(0), all.seen.size(), [&](size_t index) {
    Pcg32 own(index, 0x6d656469U), shared(0, 0x6d656469U), directions(index, 0x64697265U);
    const Vec3 corner = grid.lower(grid.cell(index)), size = grid.size(grid.cell(index));
    ShadingPoint path;
    MediaStack none;
    Ray ray;
    ShadingPoint inside = inside_of({none, ray, 0.0f, path, kRayCamera});
    MediaCounters ignored;
    float &seen = all.seen[index], smallest = kInfinity;
    for (int k = 0; k < kSamplesPerCell; ++k) {
      // Points at the same places of all cells show which axes the extinction varies along.
      Pcg32& rng = k < kSamplesPerCell / 2 ? shared : own;
      inside.position = corner + size * Vec3(rng.next_float(), rng.next_float(), rng.next_float());
      inside.time = moves ? rng.next_float() : 0.0f;  // in a mesh that deforms, the media stay
      // Materials can depend on the direction of view.
      inside.wo = inside.ng = inside.ns = warp::square_to_sphere(
          Vec2(directions.next_float(), directions.next_float()));
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
      if (!is_black(point.emission)) seen = std::max(seen, 1.0f / glm::length(size));
    }
    all.smallest[index] = smallest;
  });
  // Nearly no light is in cells that are opaque everywhere. They count only if there are no others with extinction.
  // The far cells of an endless medium are where no vertices of paths are.
  Color seen_by_light(0.0f);
  size_t lit = 0;
  for (size_t cell = 0; cell < sums.size(); ++cell) {
    const Sum& sum = sums[cell];
    all.extinction += sum.extinction / float(kSamplesPerCell * sums.size());
    all.scatters |= sum.scatters;
    all.emits |= sum.emits;
    if (all.smallest[cell] * grid.side(grid.cell(cell)) >= kOpaque || !grid.is_even(grid.cell(cell))) continue;
    seen_by_light += sum.extinction / float(kSamplesPerCell);
    ++lit;
  }
  if (max_component(seen_by_light) > 0.0f) all.extinction = seen_by_light / float(lit);
  return all;
}

/// Looks at the voxels of grids too. Between voxels, grids are interpolated, so that their largest value is at a voxel.
/// Returns how far the volume flows while the shutter is open.
Vec3 Media::sample_voxels(const Medium& medium, Samples& all) const {
  if (medium.instance == kNone) return Vec3(0.0f);
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
      if (mesh.velocity >= 0) inside.time = mesh.flow_frame;
      MediaCounters ignored;
      grid.for_each_voxel(brick, stride, [&](Vec3 center) {
        inside.position = transform_point(instance.world_from_object, center);
        std::array<int, 3> cell;
        for (int axis = 0; axis < 3; ++axis) {
          const int count = medium.grid.cells()[size_t(axis)];
          const float place = medium.grid.place(axis, inside.position[axis]);
          if (!(place >= 0.0f && place < float(count))) return;
          cell[size_t(axis)] = std::min(int(place), count - 1);
        }
        MediumPoint point;
        add(medium, inside, point, ignored);
        const float extinction = max_component(point.extinction);
        std::atomic_ref<float> seen(all.seen[medium.grid.index(cell)]);
        for (float known = seen.load(); known < extinction && !seen.compare_exchange_weak(known, extinction);) {
        }
      });
    });
  }
  return farthest_flow(mesh, instance);
}

/// Of the far cells of an endless medium, a quarter of a collision across each.
float Media::least_majorant(const Medium& medium, const std::array<int, 3>& cell) const {
  return medium.grid.is_even(cell) ? medium.least : std::min(medium.least, 0.25f / glm::length(medium.grid.size(cell)));
}

void Media::find_majorants(Medium& medium, int cells_along, size_t max_divided) {
  MajorantGrid& grid = medium.grid;
  const Vec3 extent = grid.extent();
  const float cell = max_component(extent) / float(cells_along);
  std::array<int, 3> cells;
  for (int axis = 0; axis < 3; ++axis)
    cells[size_t(axis)] = std::clamp(int(std::ceil(extent[axis] / cell)), 1, cells_along);
  grid.divide(cells);
  medium.most = kMaxOpticalDepthPerCell / glm::length(grid.size({cells[0] / 2, cells[1] / 2, cells[2] / 2}));
  Samples all = sample_cells(medium);
  if (divide_anew(all.compared, cells)) {
    grid.divide(cells);
    all = sample_cells(medium);
  }
  const Vec3 flow = sample_voxels(medium, all);
  std::array<int, 3> around;  // the neighbouring cells are included for peaks between the samples
  for (int axis = 0; axis < 3; ++axis) {
    const float cells_passed = std::ceil(flow[axis] / grid.size(axis, 0));
    around[size_t(axis)] = cells_passed < float(cells[size_t(axis)]) ? std::max(int(cells_passed), 1)
                                                                     : cells[size_t(axis)];
  }
  medium.emits |= all.emits;
  if (all.scatters && is_finite(all.extinction)) medium.mean_extinction = all.extinction;
  const float largest = *std::max_element(all.seen.begin(), all.seen.end());
  medium.least = std::min(
      std::max(std::min(kMinShare * largest, kMostIdle / max_component(extent)), 0.25f / glm::length(extent)),
      kLargest);
  medium.first_majorant = majorants_.size();
  for (size_t index = 0; index < grid.count(); ++index) {
    const std::array<int, 3> at = grid.cell(index);
    const auto [x, y, z] = at;
    float most = least_majorant(medium, at);
    for (int w = std::max(z - around[2], 0); w <= std::min(z + around[2], cells[2] - 1); ++w)
      for (int v = std::max(y - around[1], 0); v <= std::min(y + around[1], cells[1] - 1); ++v)
        for (int u = std::max(x - around[0], 0); u <= std::min(x + around[0], cells[0] - 1); ++u)
          // Far cells are too large for the peaks of others.
          if (grid.is_even({u, v, w}) == grid.is_even(at))
            most = std::max(most, std::min(kMargin * all.seen[grid.index({u, v, w})], kLargest));
    majorants_.push_back(most);
  }
  divide_cells(medium, all, max_divided);
}

void Media::divide_cells(Medium& medium, const Samples& all, size_t max_divided) {
  // The voxels of grids are looked at one by one, so that their majorants are tight. Media that move have no fixed cells.
  if (medium.instance != kNone) {
    const BuiltInstance& instance = scene_.instances()[medium.instance];
    if (instance.motion || !scene_.meshes()[instance.mesh].grids.empty()) return;
  }
  std::vector<std::pair<float, size_t>> idle;  // null collisions of a ray, and the cell
  for (size_t cell = 0; cell < all.seen.size(); ++cell) {
    const float side = medium.grid.side(medium.grid.cell(cell));
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

/// The extinction at the corners of the small cells, and at one point in each. If the
/// largest of them are always at corners, the extinction changes slowly, and the largest one in a small cell is taken.
/// Otherwise there can be peaks between the points, and the neighbours are included.
void Media::find_fine_majorants(const Medium& medium, size_t cell, FineMajorants::Cells& found) const {
  constexpr int kCells = FineMajorants::kAlong, kCorners = kCells + 1;
  ShadingPoint path;
  MediaStack none;
  Ray ray;
  ShadingPoint inside = inside_of({none, ray, 0.0f, path, kRayCamera});
  MediaCounters ignored;
  Pcg32 rng(cell, 0x66696e65U);
  const std::array<int, 3> place = medium.grid.cell(cell);
  const Vec3 corner = medium.grid.lower(place), whole = medium.grid.size(place), size = whole / float(kCells);
  const auto largest_at = [&](Vec3 at) {
    inside.position = corner + size * at;
    float largest = 0.0f;
    for (const uint32_t kind : {uint32_t(kRayCamera), uint32_t(kRayShadow)}) {
      inside.ray_kind = kind;
      MediumPoint point;
      add(medium, inside, point, ignored);
      largest = std::max(largest, max_component(point.extinction));
      if (!is_black(point.emission)) largest = std::max(largest, 1.0f / glm::length(whole));
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
    found[size_t(i)] = FineMajorants::code_of(std::max(kMargin * most, least_majorant(medium, place)) /
                                              majorants_[medium.first_majorant + cell]);
  }
}

/// As `majorant`, in a cell that is divided.
float Media::fine_majorant(const Medium& medium, const std::array<int, 3>& cell, Vec3 position, Vec3 direction,
                           float& reach) const {
  const size_t index = medium.grid.index(cell);
  const Vec3 corner = medium.grid.lower(cell), whole = medium.grid.size(cell);
  const FineMajorants::Cells& fine = medium.fine.in(
      index, [&](FineMajorants::Cells& found) { find_fine_majorants(medium, index, found); });
  constexpr int kCells = FineMajorants::kAlong;
  size_t small = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const float size = whole[axis] / float(kCells), d = direction[axis];
    const int at = std::clamp(int((position[axis] - corner[axis]) / size), 0, kCells - 1);
    small = small * size_t(kCells) + size_t(at);
    if (d == 0.0f) continue;
    const float border = corner[axis] + size * float(at + (d > 0.0f ? 1 : 0));
    reach = std::min(reach, std::max((border - position[axis]) / d, 1e-3f * size));
  }
  return FineMajorants::share_of(fine[small]) * majorants_[medium.first_majorant + index];
}

}  // namespace ajar
