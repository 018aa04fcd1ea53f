// The grids of majorants of media that vary, and their mean extinction.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

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
  Color extinction{0.0f};       ///< mean
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
    float& seen = all.seen[index];
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
      sums[index].extinction += point.extinction;
      sums[index].scatters |= point.scatters();
      sums[index].emits |= !is_black(point.emission);
      // Emission is found at collisions, so the majorant must not be zero.
      if (!is_black(point.emission)) seen = std::max(seen, 1.0f / glm::length(medium.size));
    }
  });
  for (const Sum& sum : sums) {
    all.extinction += sum.extinction / float(kSamplesPerCell * sums.size());
    all.scatters |= sum.scatters;
    all.emits |= sum.emits;
  }
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

void Media::find_majorants(Medium& medium, int cells_along) {
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
  const float least = std::min(
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
}

/// Of uniform media.
void Media::find_emission() {
  MediaStack none;
  Ray ray;
  ShadingPoint path;
  MediaCounters ignored;
  for (Medium& medium : media_) {
    if (medium.varies) continue;
    ShadingPoint inside = inside_of({none, ray, 0.0f, path, kRayCamera});
    MediumPoint point;
    add(medium, inside, point, ignored);
    medium.emits = !is_black(point.emission);
  }
}

}  // namespace ajar
