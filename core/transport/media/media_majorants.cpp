// The grids of majorants of media that vary, and their mean extinction.
#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>

#include "transport/media/media.h"

namespace ajar {

namespace {

constexpr int kSamplesPerCell = 16;
/// kMargin: majorant over the largest sample around it. kMinShare: minimum majorant over the largest one. kLargest:
/// maximum majorant per metre.
constexpr float kMargin = 1.1f, kMinShare = 0.02f, kLargest = 1e13f;

}  // namespace

void Media::find_majorants(Medium& medium, int cells_along) {
  const Vec3 extent = glm::max(medium.size, Vec3(1e-6f * max_component(medium.size) + 1e-30f));
  const float cell = max_component(extent) / float(cells_along);
  for (int axis = 0; axis < 3; ++axis) {
    medium.cells[size_t(axis)] = std::clamp(int(std::ceil(extent[axis] / cell)), 1, cells_along);
    medium.size[axis] = extent[axis] / float(medium.cells[size_t(axis)]);
    medium.inverse_size[axis] = 1.0f / medium.size[axis];
  }
  medium.most = kMaxOpticalDepthPerCell / glm::length(medium.size);
  medium.first_majorant = majorants_.size();
  const auto [nx, ny, nz] = medium.cells;
  std::vector<float> seen(size_t(nx) * size_t(ny) * size_t(nz));
  struct Sum {
    Color extinction{0.0f};
    bool scatters = false, emits = false;
  };
  std::vector<Sum> sums(seen.size());
  const BuiltInstance& instance = scene_.instances()[medium.instance];
  tbb::parallel_for(size_t(0), seen.size(), [&](size_t index) {
    Pcg32 rng(index, 0x6d656469U);
    const Vec3 corner = medium.lower + medium.size * Vec3(float(index % size_t(nx)),
                                                          float(index / size_t(nx) % size_t(ny)),
                                                          float(index / (size_t(nx) * size_t(ny))));
    ShadingPoint path;
    MediaStack none;
    Ray ray;
    ShadingPoint inside = inside_of({none, ray, 0.0f, path, kRayCamera});
    MediaCounters ignored;
    for (int k = 0; k < kSamplesPerCell; ++k) {
      inside.position = corner + medium.size * Vec3(rng.next_float(), rng.next_float(), rng.next_float());
      inside.time = instance.motion ? rng.next_float() : 0.0f;
      inside.ray_kind = k % 4 == 3 ? uint32_t(kRayShadow) : uint32_t(kRayCamera);
      MediumPoint point;
      add(medium, inside, point, ignored);
      seen[index] = std::max(seen[index], max_component(point.extinction));
      sums[index].extinction += point.extinction;
      sums[index].scatters |= point.scatters();
      sums[index].emits |= !is_black(point.emission);
      // Emission is found at collisions, so the majorant must not be zero.
      if (!is_black(point.emission)) seen[index] = std::max(seen[index], 1.0f / glm::length(medium.size));
    }
  });
  Sum all;
  for (const Sum& sum : sums) {
    all.extinction += sum.extinction / float(kSamplesPerCell * sums.size());
    all.scatters |= sum.scatters;
    medium.emits |= sum.emits;
  }
  if (all.scatters && is_finite(all.extinction)) medium.mean_extinction = all.extinction;
  const float largest = *std::max_element(seen.begin(), seen.end());
  const float least = std::min(std::max(kMinShare * largest, 0.25f / glm::length(extent)), kLargest);
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        // The neighbouring cells are included for peaks between the samples.
        float most = least;
        for (int w = std::max(z - 1, 0); w <= std::min(z + 1, nz - 1); ++w)
          for (int v = std::max(y - 1, 0); v <= std::min(y + 1, ny - 1); ++v)
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, nx - 1); ++u)
              most = std::max(most, std::min(kMargin * seen[size_t((w * ny + v) * nx + u)], kLargest));
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
