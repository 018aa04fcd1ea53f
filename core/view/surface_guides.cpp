#include "view/surface_guides.h"

#include "film/tile_loop.h"
#include "integrators/path_walk.h"
#include "sampling/sampler.h"

namespace ajar {

namespace {

using D = PathDimensions;
constexpr int kMaxSurfaces = 64;  ///< on a path, those that only enclose a volume included

/// Continues through a mirror, glass or a transparent surface. Returns false at the end of the path.
bool go_on(EyeWalk& walk, Sampler& sampler, int vertex) {
  const uint32_t base = D::kCamera + D::kVertex * uint32_t(vertex);
  sampler.set_dimension(base + D::kLobe);
  const Vec3 u = sampler.get_3d();
  const auto sample = walk.shading.bsdf.sample(walk.point.wo, u.z, Vec2(u));
  if (!sample || !(sample->pdf_solid_angle > 0.0f)) return false;
  if (sample->flags & kTransparent) return walk.pass_portal(*sample);
  count_bounce(*sample, walk.point, walk.point);
  walk.leave_along(sample->wi);
  return true;
}

SampleAux guides_along(const Scene& scene, const Ray& ray, Sampler& sampler, uint64_t& rays) {
  SampleAux found;
  SampleAux* needed = &found;
  EyeWalk walk(scene, ray, rays);
  for (int vertex = 0; vertex < kMaxSurfaces && needed; ++vertex) {
    walk.trace();
    if (!walk.found() || !walk.arrive()) break;
    const ShaderProgram& program = scene.material(walk.hit);
    if (program.only_encloses()) {
      walk.pass_uncounted();
      continue;
    }
    walk.shade();
    record_vertex(scene, walk.point, walk.shading.bsdf, Color(1.0f), needed);
    if (needed && !go_on(walk, sampler, vertex)) break;
  }
  return found;
}

}  // namespace

SurfaceGuides trace_surface_guides(const Scene& scene, const CameraDescription& view, const RenderSettings& settings,
                                   const std::atomic<bool>& stop) {
  const Camera camera(view, settings.width, settings.height);
  const auto& r = settings.region;
  const Film frame(r[0], r[1], r[2], r[3], {"Combined"});  // has the places of the pixels
  SurfaceGuides guides;
  guides.albedo.resize(size_t(frame.width()) * size_t(frame.height()) * 3);
  guides.normal.resize(guides.albedo.size());
  struct Tile {
    Sampler sampler;
    uint64_t rays;
  };
  for_each_sample(
      frame, 1, stop,
      [&] {
        return Tile{Sampler(Sampler::Kind::Sobol, settings.seed), 0};
      },
      [&](Tile& tile, int px, int py, uint32_t index) {
        tile.sampler.start(uint32_t(py) * uint32_t(settings.width) + uint32_t(px), index);
        tile.sampler.get_2d();  // of the pixel filter
        const Vec2 on_film(float(px) + 0.5f, float(py) + 0.5f);
        const Ray ray = camera.generate_ray(on_film, camera.has_lens() ? tile.sampler.get_2d() : Vec2(0.5f), 0.0f);
        if (sees_nothing(ray)) return;
        const SampleAux found = guides_along(scene, ray, tile.sampler, tile.rays);
        const size_t place = 3 * (size_t(py - frame.y0()) * size_t(frame.width()) + size_t(px - frame.x0()));
        for (size_t c = 0; c < 3; ++c) {
          guides.albedo[place + c] = found.guide_albedo[int(c)];
          guides.normal[place + c] = found.guide_normal[int(c)];
        }
      });
  return guides;
}

}  // namespace ajar
