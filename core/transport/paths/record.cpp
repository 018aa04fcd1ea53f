#include "transport/paths/record.h"

#include <algorithm>
#include <cmath>

#include "math/frame.h"
#include "math/warps.h"
#include "sampling/sampler.h"

namespace ajar {

namespace {

float average(Color c) { return (c.x + c.y + c.z) * (1.0f / 3.0f); }

/// A throughput as a part of the one before.
Color part_of(Color throughput, Color before) {
  Color part(0.0f);
  for (int c = 0; c < 3; ++c)
    if (before[c] > 0.0f) part[c] = std::clamp(throughput[c] / before[c], 0.0f, 4.0f);
  return part;
}

/// The mean of the normals of the lobes, by their weights, so that bumps and normal maps are in it, as in Cycles.
Vec3 mean_normal(const Bsdf& bsdf) {
  Vec3 sum(0.0f);
  for (int i = 0; i < bsdf.lobe_count(); ++i) {
    const Lobe& lobe = bsdf.lobe(i);
    if (lobe.kind != LobeKind::Transparent && !is_fiber(lobe.kind))
      sum += std::abs(average(lobe.weight)) * lobe.frame.n;
  }
  const float square = length_squared(sum);
  return square > 0.0f && square < kInfinity ? sum / std::sqrt(square) : bsdf.n;
}

void record_first_hit(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, SampleAux& aux) {
  const Camera& camera = scene.camera();
  const MistDescription& mist = scene.settings().mist;
  const float distance = camera.is_orthographic() ? camera.depth_of(point.position)
                                                  : glm::length(point.position - camera.position());
  const float beyond = mist.depth > 0.0f       ? saturate((distance - mist.start) / mist.depth)
                       : distance > mist.start ? 1.0f
                                               : 0.0f;
  aux.mist = std::pow(beyond, mist.exponent);
  aux.object_index = float(point.object ? point.object->pass_index : 0);
  aux.material_index = float(scene.material_pass_indices()[size_t(scene.material_index(point))]);
  aux.depth = camera.depth_of(point.position);
  aux.normal = mean_normal(bsdf);
  aux.position = point.position;
  aux.albedo = bsdf.albedo();
  if (point.mesh->active_uv >= 0) {
    const Attribute& uv = point.mesh->attributes[size_t(point.mesh->active_uv)];
    aux.uv = Vec3(Vec2(point.mesh->interpolate(uv, point.primitive, point.barycentric)), 1.0f);
  }
  aux.has_first = true;
}

/// The guides of a denoiser at a vertex of a path from the eye. Returns whether they are found.
bool record_guides(const ShadingPoint& point, const Bsdf& bsdf, SampleAux& aux) {
  constexpr float kMinRough = 0.25f;  // share of the albedo
  constexpr int kMaxMirrors = 8;
  const Color albedo = bsdf.albedo(), sharp = bsdf.albedo_of_sharp();
  if (luminance(albedo - sharp) < kMinRough * luminance(albedo) && point.ray_depth < kMaxMirrors) {
    aux.guide_throughput *= glm::min(sharp, Color(1.0f));
    return false;
  }
  aux.guide_albedo += aux.guide_throughput * glm::min(albedo, Color(1.0f));
  aux.guide_normal += aux.guide_share * mean_normal(bsdf);
  return true;
}

/// Adds the values of AOV Output nodes to the passes of their names.
void record_aovs(const ShaderProgram& program, const ShadingPoint& point, float weight, SampleExtras& extras) {
  if (!program.has_aovs()) return;
  program.evaluate_aovs(point, [&](const ShaderProgram::Aov& aov) {
    for (size_t i = 0; i < extras.aov_passes->size(); ++i) {
      const AovPass& pass = (*extras.aov_passes)[i];
      if (pass.name == aov.name) extras.aovs[i] += weight * (pass.is_color ? Vec4(aov.color, 1.0f) : Vec4(aov.value));
    }
  });
}

/// The share of the light from a hemisphere that no surface near the point blocks, by one ray.
float openness(const Scene& scene, const ShadingPoint& point, Vec3 normal, const SampleExtras& extras) {
  constexpr uint32_t kStream = 0x616fU, kDimension = 0;
  Sampler sampler(Sampler::Kind::Sobol, hash_combine(scene.settings().seed, kStream));
  sampler.start(extras.pixel, extras.index);
  sampler.set_dimension(kDimension);
  const Vec3 direction = Frame(normal).to_world(warp::square_to_cosine_hemisphere(sampler.get_2d()));
  if (!(glm::dot(direction, point.ng) > 0.0f)) return 0.0f;
  Ray ray = scene.spawn_ray(point, direction);
  ray.t_max = scene.settings().ao_distance;
  return average(scene.transmittance(ray, scene.settings().bounces.transparent));
}

/// The roughness of a lobe, as Cycles defines it for the pass: 0 for plain diffuse lobes, 1 for those without a roughness.
float roughness_of(const Lobe& lobe) {
  switch (lobe.kind) {
    case LobeKind::Diffuse:
    case LobeKind::PrincipledDiffuse: return lobe.roughness;
    case LobeKind::Translucent:
    case LobeKind::Sheen:
    case LobeKind::MicrofiberSheen:
    case LobeKind::ToonDiffuse:
    case LobeKind::PrincipledRetro: return 0.0f;
    case LobeKind::MicrofacetReflection:
    case LobeKind::MicrofacetRefraction:
    case LobeKind::MicrofacetGlass:
    case LobeKind::MicrofacetThin: return lobe.is_delta() ? 0.0f : std::sqrt(std::sqrt(lobe.alpha_x * lobe.alpha_y));
    default: return 1.0f;
  }
}

/// The mean roughness of the lobes by their weights.
float mean_roughness(const Bsdf& bsdf) {
  float sum = 0.0f, weights = average(bsdf.transparency());
  for (int i = 0; i < bsdf.lobe_count(); ++i) {
    const float weight = std::abs(average(bsdf.lobe(i).weight));
    sum += weight * roughness_of(bsdf.lobe(i));
    weights += weight;
  }
  return weights > 0.0f ? sum / weights : 0.0f;
}

/// The place of the surface point one frame before or after.
Vec3 place_at_frame(const Scene& scene, const ShadingPoint& point, int frame) {
  const BuiltInstance& instance = *point.instance;
  const BuiltMesh& mesh = *point.mesh;
  const int moved = mesh.strands ? -1 : mesh.find_attribute(frame < 0 ? kPositionBefore : kPositionAfter);
  const bool moves = instance.first_frame != ~0u;
  if (!moves && moved < 0) return point.position;
  const Mat4& now = instance.world_from_object;
  const Mat4& then = moves ? scene.frames()[instance.first_frame + (frame < 0 ? 0 : 1)] : now;
  const Vec3 local = moved >= 0
                         ? Vec3(mesh.interpolate(mesh.attributes[size_t(moved)], point.primitive, point.barycentric))
                         : transform_point(instance.object_from_world, point.position);
  return transform_point(then, local);
}

/// How far the point moves on the film, in pixels: from its place one frame before to now, and from now to one frame
/// after.
void record_motion(const Scene& scene, const ShadingPoint& point, SampleExtras& extras) {
  const Camera& camera = scene.camera();
  const auto now = camera.film_at_frame(point.position, 0),
             before = camera.film_at_frame(place_at_frame(scene, point, -1), -1),
             after = camera.film_at_frame(place_at_frame(scene, point, 1), 1);
  extras.has_motion = true;
  if (now && before && after) extras.motion = Vec4(*before - *now, *now - *after);
}

/// The alpha from which a surface is the first hit. Others are seen through.
bool is_first_hit(const Scene& scene, float alpha, BehindFirst behind) {
  return behind == BehindFirst::NotFound || alpha == 1.0f || alpha >= scene.settings().pass_alpha_threshold;
}

}  // namespace

SampleAux* record_surface(const Scene& scene, const ShadingPoint& point, const Bsdf& bsdf, Color beta,
                          BehindFirst behind, SampleAux*& aux) {
  SampleAux& now = *aux;
  const bool seen = point.ray_depth == 0;
  const float alpha = seen ? 1.0f - average(bsdf.transparency()) : 1.0f;
  const bool before_first = seen && !now.has_first,
             first = before_first && now.shows_first && is_first_hit(scene, alpha, behind);
  if (first) record_first_hit(scene, point, bsdf, now);
  SampleExtras* const extras = seen ? now.extras : nullptr;
  if (extras) {
    const ShaderProgram& program = scene.programs()[size_t(scene.material_index(point))];
    // Walks that have decided to stop have removed the transparency from the BSDF.
    const float covered = average(beta) * (behind == BehindFirst::Found || !program.may_be_transparent()
                                               ? alpha
                                               : 1.0f - average(program.evaluate_transparency(point)));
    if (extras->wants_mattes) extras->mattes.push_back({scene.matte_ids(point), covered});
    if (extras->aov_passes && before_first) record_aovs(program, point, average(beta), *extras);
    if (extras->wants_motion && first) record_motion(scene, point, *extras);
    if (extras->wants_roughness && first) extras->roughness = mean_roughness(bsdf);
    if (extras->wants_occlusion) extras->occlusion += covered * openness(scene, point, bsdf.n, *extras);
  }
  if (!now.has_guides) now.has_guides = record_guides(point, bsdf, now);
  if (now.has_guides && !(seen && (now.extras || !now.has_first))) aux = nullptr;
  return first ? &now : nullptr;
}

void record_medium(Vec3 direction, Color before, Color after, bool scatters, SampleAux* aux) {
  if (!aux || aux->has_guides) return;
  aux->guide_throughput *= part_of(after, before);  // the albedo of the medium, or the part of the light that passes
  if (!scatters) return;
  aux->guide_albedo += aux->guide_throughput;
  aux->guide_normal -= aux->guide_share * direction;
  aux->has_guides = true;
}

void record_split(Vec3 direction, Color before, Color scattered, Color passing, float u, SampleAux* aux) {
  if (!aux) return;
  const Color part = part_of(passing, before);
  const float passes = average(part);
  if (!(u < passes)) aux->shows_first = false;
  if (aux->has_guides) return;
  aux->guide_albedo += aux->guide_throughput * part_of(scattered, before);
  aux->guide_normal -= aux->guide_share * std::max(0.0f, 1.0f - passes) * direction;
  aux->guide_throughput *= part;
  aux->guide_share *= passes;
}

void record_world(const Scene& scene, Vec3 direction, Color beta, SampleAux& aux) {
  if (aux.has_first) return;
  ShadingPoint point;
  point.position = direction;
  point.wo = point.ng = point.ns = -direction;
  record_aovs(scene.world_program(), point, average(beta), *aux.extras);
}

}  // namespace ajar
