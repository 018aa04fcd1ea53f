#include "transport/paths/path_vertex.h"

#include <algorithm>
#include <cmath>

#include "film/filter.h"
#include "lights/sources/lamp.h"
#include "sampling/power_heuristic.h"
#include "shading/bsdf/closures.h"
#include "transport/paths/light_walk_guide.h"
#include "transport/paths/ray_events.h"

namespace ajar {

PathEdge join(const PathVertex& light_end, const PathVertex& eye_end) {
  PathEdge edge;
  if (light_end.distant) {
    edge.to_eye = light_end.point.ng;
  } else if (eye_end.distant) {
    edge.to_eye = -eye_end.point.ng;
  } else {
    const Vec3 between = eye_end.position() - light_end.position();
    const float square = length_squared(between);
    edge.inverse_square = square > 0.0f ? 1.0f / square : 0.0f;
    edge.to_eye = between * std::sqrt(edge.inverse_square);
  }
  const bool point_light = light_end.kind == VertexKind::Light && light_end.delta;
  if (!light_end.distant && !point_light && light_end.kind != VertexKind::Medium)
    edge.cos_light_end = abs_dot(light_end.point.ng, edge.to_eye);
  if (eye_end.kind == VertexKind::Surface) edge.cos_eye_end = abs_dot(eye_end.point.ng, edge.to_eye);
  edge.stop_light_end = light_end.stop_probability(edge.to_eye);
  edge.stop_eye_end = eye_end.stop_probability_from_light(-edge.to_eye);
  return edge;
}

ShadingPoint turned_towards(const ShadingPoint& point, Vec3 wo) {
  ShadingPoint p = point;
  p.wo = wo;
  if (glm::dot(p.ng, wo) < 0.0f) {
    p.ng = -p.ng;
    p.ns = -p.ns;
    p.backfacing = !p.backfacing;
  }
  return p;
}

bool bends_normal(const ShadingPoint& point, Vec3 wo) {
  const float side = glm::dot(point.ng, wo) < 0.0f ? -1.0f : 1.0f;
  const Vec3 ns = side * point.ns;
  return closures::safe_shading_normal(side * point.ng, wo, ns) != ns;
}

bool depends_on_view(const ShaderProgram& program, const ShadingPoint& point, const Bsdf& bsdf, Vec3 wo) {
  return program.view_dependence() != ShaderProgram::ViewDependence::None ||
         (point.ns != point.ng && (bends_normal(point, wo) || bsdf.n != point.ns));
}

bool turns_to(const ShaderProgram& program, const ShadingPoint& point, const Bsdf& bsdf, Vec3 wo) {
  return program.view_dependence() != ShaderProgram::ViewDependence::Direction && !on_strand_or_point(point) &&
         bsdf.can_turn_to(wo);
}

namespace {

/// The lobes of the vertex, made for the direction `wo`.
class BsdfFor {
 public:
  BsdfFor(const PathVertex& vertex, Vec3 wo, bool depends_on_view) : bsdf_(&vertex.shading.bsdf) {
    if (!depends_on_view || wo == vertex.point.wo) return;
    bsdf_ = &shading_.bsdf;
    if (turns_to(*vertex.program, vertex.point, vertex.shading.bsdf, wo)) {
      shading_.bsdf = vertex.shading.bsdf;
      shading_.bsdf.turn_to(wo);
      return;
    }
    const ShadingPoint point = turned_towards(vertex.point, wo);
    vertex.program->evaluate_surface(point, shading_);
    shading_.bsdf.remove_transparency(wo);
  }
  const Bsdf* operator->() const { return bsdf_; }
  const Bsdf& operator*() const { return *bsdf_; }

 private:
  const Bsdf* bsdf_;
  SurfaceShading shading_;
};

/// Whether the lobes can differ if they are made for `wo`.
bool depends_on_view(const PathVertex& vertex, Vec3 wo) {
  return !vertex.exit && depends_on_view(*vertex.program, vertex.point, vertex.shading.bsdf, wo);
}

/// The scattering at a surface vertex by lobes that are not delta. `differ`: they differ for the two directions.
Bsdf::PairEvaluation evaluate_pair(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool differ) {
  const Bsdf& bsdf = vertex.shading.bsdf;
  const auto follow = [&](Vec3 wo) {
    return wo == vertex.point.wo || turns_to(*vertex.program, vertex.point, bsdf, wo);
  };
  if (!differ || (follow(to_eye) && follow(to_light))) return bsdf.evaluate_pair(to_eye, to_light, differ);
  const BsdfFor from_eye(vertex, to_eye, differ), from_light(vertex, to_light, differ);
  const Bsdf::Evaluation forward = from_eye->evaluate(to_eye, to_light);
  return {forward.f_cos, forward.pdf_solid_angle, from_light->evaluate(to_light, to_eye).pdf_solid_angle};
}

/// d(to_light) / d(to_eye) of a refraction with the relative index eta from the eye's side to the light's: n^2 cos dw
/// is equal on both sides. 1 for reflection.
float refraction_jacobian(Vec3 to_eye, Vec3 to_light, float eta) {
  if (eta == 1.0f) return 1.0f;
  const Vec3 m = to_eye + eta * to_light;  // parallel to the normal [Walter et al. 2007, eq. 16]
  const float cos_light = abs_dot(m, to_light);
  return cos_light > 0.0f ? abs_dot(m, to_eye) / (eta * eta * cos_light) : 0.0f;
}

}  // namespace

Bsdf lobes_towards(const PathVertex& vertex, Vec3 wo) { return *BsdfFor(vertex, wo, depends_on_view(vertex, wo)); }

std::optional<BsdfSample> sample_direction(const PathVertex& vertex, Vec3 wo, float u_lobe, Vec2 u) {
  if (vertex.kind == VertexKind::Medium) {
    const MediumPoint& medium = vertex.media.at;
    if (!medium.scatters()) return {};
    const PhaseFunction phase(medium);
    const Vec3 wi = phase.sample(-wo, u_lobe, u);
    const float cosine = glm::dot(-wo, wi);
    return BsdfSample{wi, medium.scattering * phase.evaluate(cosine), phase.pdf_solid_angle(cosine), 0, false};
  }
  return BsdfFor(vertex, wo, depends_on_view(vertex, wo))->sample(wo, u_lobe, u);
}

std::optional<BsdfSample> follow_direction(const PathVertex& vertex, Vec3 wo, bool transmitted, float u_lobe) {
  return BsdfFor(vertex, wo, depends_on_view(vertex, wo))->follow_specular(wo, transmitted, u_lobe);
}

Scattering scatter(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool specular, const LightWalkGuide* guide) {
  if (vertex.kind == VertexKind::Medium) {
    Scattering s;
    const MediumPoint& medium = vertex.media.at;
    if (!medium.scatters()) return s;
    const PhaseFunction phase(medium);
    const float cosine = glm::dot(-to_eye, to_light);
    s.f = medium.scattering * phase.evaluate(cosine);
    s.pdf_to_light = s.pdf_to_eye = s.pdf_walk_to_eye = phase.pdf_solid_angle(cosine);
    return s;
  }
  if (vertex.leaves_sphere_inwards(to_eye)) [[unlikely]]
    return {};
  const bool differ = depends_on_view(vertex, to_eye) || depends_on_view(vertex, to_light);
  const float free = guide && vertex.connectable() ? 1.0f - guide->share_at(vertex.position()) : 1.0f;
  Scattering s;
  if (!specular) {
    const Bsdf::PairEvaluation pair = evaluate_pair(vertex, to_eye, to_light, differ);
    s.f = pair.f_cos;
    s.pdf_to_light = pair.pdf_to_light;
    s.pdf_to_eye = pair.pdf_to_eye;
    s.pdf_walk_to_eye = free < 1.0f ? free * s.pdf_to_eye + guide->pdf_at(vertex.position(), to_eye) : s.pdf_to_eye;
    return s;
  }
  const BsdfFor from_eye(vertex, to_eye, differ), from_light(vertex, to_light, differ);
  const Bsdf::SpecularEvaluation forward = from_eye->evaluate_specular(to_eye, to_light);
  const Bsdf::SpecularEvaluation back = from_light->evaluate_specular(to_light, to_eye);
  const float jacobian = refraction_jacobian(to_eye, to_light, forward.eta);
  s.f = forward.weight;
  s.pdf_to_light = forward.probability;
  s.pdf_to_eye = back.probability * jacobian;
  s.pdf_walk_to_eye = free * s.pdf_to_eye;
  s.follow_to_light = forward.follow_probability;
  s.follow_to_eye = back.follow_probability * jacobian;
  return s;
}

bool is_linked(const Scene& scene, const PathVertex& light, const PathVertex& vertex) {
  const LightSet& lights = scene.lights();
  return light.light < 0 || !lights.any_linked() || vertex.kind == VertexKind::Lens ||
         lights.flags(uint32_t(light.light)).lights(receiver_set(vertex));
}

Color visible_part(const Scene& scene, const PathVertex& light, const PathVertex& vertex, Vec3 to_eye, Vec3 to_light,
                   bool specular, Color f) {
  const LightSet& lights = scene.lights();
  if (!is_linked(scene, light, vertex)) return Color(0.0f);
  if (light.light < 0 || (!lights.any_partial() && vertex.kind != VertexKind::Medium)) return f;
  const LightFlags flags = lights.flags(uint32_t(light.light));
  if (vertex.kind == VertexKind::Medium) return flags.visibility & kVisibleVolumeScatter ? f : Color(0.0f);
  if (!flags.partial() || vertex.kind != VertexKind::Surface) return f;
  if (specular) {
    const bool transmits = glm::dot(vertex.point.ng, to_eye) * glm::dot(vertex.point.ng, to_light) < 0.0f;
    return flags.visibility & (transmits ? kVisibleTransmission : kVisibleGlossy) ? f : Color(0.0f);
  }
  const Color all = visible_to(kVisibleAll, vertex.shading.bsdf, to_eye, to_light),
              visible = visible_to(flags.visibility, vertex.shading.bsdf, to_eye, to_light);
  for (int c = 0; c < 3; ++c) f[c] *= all[c] != 0.0f ? visible[c] / all[c] : 0.0f;
  return f;
}

float pass_probability(const ShaderProgram& program, Color transparency) {
  const float y = luminance(transparency);
  if (!(y > 0.0f)) return 0.0f;
  // If the surface scatters or emits, some walks must stop at it.
  return program.scatters() || program.emits() ? std::min(y, 0.9f) : 1.0f;
}

Vec3 receiving_normal(const PathVertex& vertex) {
  return vertex.kind == VertexKind::Surface ? vertex.shading.bsdf.receiving_normal() : Vec3(0.0f);
}

MediaStack stack_towards(const Scene& scene, const PathMedia& media, const PathVertex& from, Vec3 direction) {
  if (from.kind == VertexKind::Surface) return media.beyond(scene, from.point, from.media.stack, direction);
  if (from.kind == VertexKind::Medium) return from.media.stack;
  Vec3 start = from.position();
  if (from.program) start = scene.spawn_ray(from.point, direction).origin;
  if (from.kind == VertexKind::Lens) start += direction * scene.camera().clip_distance(direction, from.point.time);
  return media.around(start, from.point.time);
}

/// Whether a vertex is inside the sphere of a lamp. Lamps do not block light, so it sees the sphere from inside.
static bool is_within(const Light& lamp, const PathVertex& vertex) {
  return !vertex.distant && length_squared(vertex.position() - lamp.position) <= lamp.radius * lamp.radius;
}

bool is_past_bounces(const Scene& scene, const PathVertex& light, int bounces) {
  const LightSet& lights = scene.lights();
  return lights.any_limited() && light.light >= 0 && bounces > lights.flags(uint32_t(light.light)).max_bounces;
}

bool sends_photons(const Scene& scene, const PathVertex& light) {
  const LightSet& lights = scene.lights();
  if (light.light < 0) return false;
  const uint32_t index = uint32_t(light.light);
  if (!(lights.power_pmf(index) > 0.0f)) return false;
  if (lights.any_without_walks() && !lights.flags(index).starts_walks()) return false;
  if (lights.any_limited() && lights.flags(index).max_bounces < scene.settings().bounces.total) return false;
  if (!light.distant || light.delta) return true;
  const Vec3 direction = light.point.ng;
  return lights.pdf_le(index, direction, direction, light.point.time).pdf_solid_angle >= kLeastDensityOfPhotons;
}

float weight_past_bounces(const LightEnd& light, const PathVertex& next, const PathEdge& edge, float pdf_to_light) {
  if (!light.can_be_hit_from(next)) return 0.0f;
  return next.specular ? 1.0f : power_heuristic(pdf_to_light * edge.to_light_area(), light.pdf_sampled);
}

float weight_past_ray_kinds(const LightEnd& light, const PathEdge& edge, float pdf_to_light) {
  if (!light.can_be_hit || light.partial) return 1.0f;
  return power_heuristic(light.pdf_sampled, pdf_to_light * edge.to_light_area());
}

int light_group_of(const Scene& scene, const PathVertex& light) {
  if (light.light >= 0) return scene.light_group(uint32_t(light.light));
  return light.point.object ? scene.light_group_of(*light.point.object) : -1;
}

LightEnd light_end(const Scene& scene, const PathVertex& light, const PathVertex& next, const PathEdge& edge,
                   const LightWalkGuide* guide) {
  const LightSet& lights = scene.lights();
  LightEnd end;
  if (light.program) {
    const bool grows = light.program->emission_depends_on_distance();
    if (light.program->emission_is_constant() || (light.point.wo == edge.to_eye && !grows)) {
      end.radiance = light.shading.emission;
    } else {
      ShadingPoint point = turned_towards(light.point, edge.to_eye);
      if (grows) point.ray_length = next.distant ? kInfinity : 1.0f / std::sqrt(edge.inverse_square);
      end.radiance = light.program->evaluate_emission(point);
    }
    end.can_be_hit = true;
  } else if (light.light == lights.environment_index()) {
    end.radiance = lights.environment_radiance(-edge.to_eye, 0);
    end.can_be_hit = true;
  } else {
    const LightFlags flags = lights.flags(uint32_t(light.light));
    std::optional<float> distance = light.distant ? 0.0f : 1.0f / std::sqrt(edge.inverse_square);
    if (flags.soft && !next.distant)
      distance = soft_lamp_distance(lights.light(uint32_t(light.light)), next.position(), -edge.to_eye);
    // The far side of a sphere emits away from the vertex, so the sphere itself blocks it, unless the vertex is inside.
    const bool turned_away = is_sphere(flags.type) && !(glm::dot(light.point.ng, edge.to_eye) > 0.0f) &&
                             !is_within(lights.light(uint32_t(light.light)), next);
    if (distance && !turned_away)
      end.radiance = lights.lamp_radiance(uint32_t(light.light), light.position(), edge.to_eye, light.point.time,
                                          *distance);
    end.can_be_hit = !light.delta && flags.mis;
  }
  if (light.light < 0) return end;  // it emits but is not in the list of lights
  const uint32_t index = uint32_t(light.light);
  end.partial = lights.any_partial() && lights.flags(index).partial();
  const LightSet::LePdf le = lights.pdf_le(index, light.point.ng, edge.to_eye, light.point.time);
  const float probability = lights.power_pmf(index);
  const bool parallel = light.delta && light.distant;
  end.pdf_origin = probability * (light.distant ? (parallel ? 1.0f : le.pdf_solid_angle) : le.pdf_area);
  end.pdf_by_power = end.pdf_origin;
  end.pdf_direction = light.distant ? le.pdf_area : le.pdf_solid_angle;
  if (guide)
    guide->mix(lights, index, light.distant ? next.position() : light.position(), light.point.ng, edge.to_eye, end);
  if (lights.any_without_walks() && !lights.flags(index).starts_walks())
    end.pdf_origin = end.pdf_by_power = 0.0f;  // no walk starts here, see start_at_light
  if (next.kind == VertexKind::Surface || next.kind == VertexKind::Medium) {
    const float choice = lights.choice_pmf(next.position(), receiving_normal(next), index, receiver_set(next));
    if (light.delta) {
      end.pdf_sampled = choice;
    } else {
      const float distance = light.distant ? kInfinity : 1.0f / std::sqrt(edge.inverse_square);
      end.pdf_sampled = choice *
                        lights.pdf_li(index, next.position(), -edge.to_eye, distance, light.point.ng,
                                      light.point.time) *
                        edge.to_light_area();
    }
  }
  return end;
}

bool joins_lens(const Scene& scene) {
  const RenderSettings& s = scene.settings();
  return scene.camera().finds_film(PixelFilter(s.filter, s.filter_width).half_width());
}

void BounceCount::add(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool specular) {
  if (vertex.kind == VertexKind::Medium) {
    if (++volume_ > limits_.volume) states_.clear();
    return;
  }
  const Bsdf::KindShares shares = vertex.shading.bsdf.kind_shares(to_eye, to_light, specular);
  std::vector<State> next;
  const auto extend = [&](const State& from, float share, int diffuse, int glossy, int transmission) {
    if (!(share > 0.0f)) return;
    const State state{from.diffuse + diffuse, from.glossy + glossy, from.transmission + transmission,
                      from.probability * share};
    if (state.diffuse > limits_.diffuse || state.glossy > limits_.glossy || state.transmission > limits_.transmission)
      return;
    for (State& s : next) {
      if (s.diffuse != state.diffuse || s.glossy != state.glossy || s.transmission != state.transmission) continue;
      s.probability += state.probability;
      return;
    }
    next.push_back(state);
  };
  for (const State& s : states_) {
    extend(s, shares.diffuse, 1, 0, 0);
    extend(s, shares.glossy, 0, 1, 0);
    extend(s, shares.transmission, 0, 0, 1);
    extend(s, shares.diffuse_transmission, 0, 0, 1);
  }
  states_ = std::move(next);
}

float BounceCount::factor() const {
  float sum = 0.0f;
  for (const State& s : states_) sum += s.probability;
  return sum;
}

}  // namespace ajar
