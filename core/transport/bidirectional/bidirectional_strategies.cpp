// The strategies of bidirectional path tracing: how a walk from the eye and one from a light become paths, and their
// weights.
#include <algorithm>
#include <cmath>

#include "transport/bidirectional/bidirectional.h"
#include "transport/paths/eye_history.h"
#include "transport/paths/light_walk_guide.h"
#include "transport/paths/shadow_terminator.h"

namespace ajar {

namespace {

/// Replaces a density of zero in divisions, for lights at which no walk starts.
constexpr float kNever = 1e-30f;

}  // namespace

/// Densities of the vertices of a complete path from both sides, in path order. Weights follow the power heuristic with
/// exponent 2 over all strategies [Veach, section 10.2].
struct BidirectionalWalks::Densities {
  int count, last;  ///< last: the strategy with most vertices from the light
  double from_light[kMaxPathVertices], from_eye[kMaxPathVertices];
  bool joinable[kMaxPathVertices];  ///< not specular in this path
  double sampled = 0.0;             ///< density of vertex 0 by light sampling

  double weight(int s, double light_walks) const {
    if (count == 2) return 1.0;  // emission that is seen directly is found only by hitting it
    // Factors of a strategy's density besides those of its vertices: light sampling, the number of light walks, and
    // zero for a connection at a specular vertex.
    const auto factor = [&](int k) {
      if (k == 0) return 1.0;
      if (k == 1) return joinable[1] ? sampled / from_light[0] : 0.0;
      if (!joinable[k - 1] || !joinable[k]) return 0.0;
      return k == count - 1 ? light_walks : 1.0;
    };
    const double own = factor(s);
    if (!(own > 0.0)) return 0.0;
    double sum = 1.0, ratio = 1.0;
    for (int k = s + 1; k <= last; ++k) {
      ratio *= from_light[k - 1] / from_eye[k - 1];
      const double relative = ratio * factor(k) / own;
      sum += relative * relative;
    }
    ratio = 1.0;
    for (int k = s - 1; k >= 0; --k) {
      ratio *= from_eye[k] / from_light[k];
      const double relative = ratio * factor(k) / own;
      sum += relative * relative;
    }
    return std::isfinite(sum) ? 1.0 / sum : 0.0;
  }
};

float BidirectionalWalks::limits_factor(int s, int t, const PathEdge& edge) const {
  const BounceLimits& limits = scene_.settings().bounces;
  const int count = s + t + (s == 0);  // for s = 0 the light is an additional vertex
  if (!BounceCount::matters(limits, count - 3, media != nullptr)) return 1.0f;
  BounceCount bounces(limits);
  // The vertex next to the light does not count. The two vertices of the connection are not specular.
  for (int j = 2; j <= s - 1; ++j) {
    const PathVertex& v = light_[size_t(j)].vertex;
    const bool joint = j == s - 1;
    bounces.add(v, joint ? edge.to_eye : light_[size_t(j) + 1].edge.to_eye, v.point.wo, v.specular && !joint);
  }
  for (int k = s >= 2 ? t - 1 : t - 2; k >= 1; --k) {
    const PathVertex& v = eye_[size_t(k)].vertex;
    const bool joint = k == t - 1;
    bounces.add(v, v.point.wo, joint ? -edge.to_eye : -eye_[size_t(k) + 1].edge.to_eye, v.specular && !joint);
  }
  return bounces.factor();
}

/// As history_of in path.cpp. The walk from the eye has chosen one history up to its end.
Color BidirectionalWalks::history_factor(int s, int t, const PathEdge& edge) const {
  const BounceLimits& limits = scene_.settings().bounces;
  const bool limited = BounceCount::matters(limits, s + t + (s == 0) - 3, media != nullptr);
  const auto enterable = [](const WalkVertex& v) { return can_enter(v.vertex); };
  if (!limited && (s < 2 || std::none_of(light_.begin() + 1, light_.begin() + s, enterable))) return Color(1.0f);
  EyeHistory history(limited ? &limits : nullptr);
  if (t >= 2) {
    const PathVertex& end = scattering_end(t);
    history.start(end.point, eye_[size_t(t - 1)].collisions);
    if (s >= 2) history.add(end, end.point.wo, -edge.to_eye, false);
  }
  for (int j = s - 1; j >= 1; --j) {
    const PathVertex& v = light_[size_t(j)].vertex;
    const bool joint = j == s - 1;
    const Vec3 to_eye = joint ? edge.to_eye : light_[size_t(j) + 1].edge.to_eye;
    if (j > 1)
      history.add(v, to_eye, v.point.wo, v.specular && !joint);
    else
      history.end(scene_, light_[0].vertex, v, to_eye, v.point.wo, v.specular && !joint);
  }
  return history.factor();
}

Color BidirectionalWalks::with_history(float weight, int s, int t, const PathEdge& edge) const {
  if (knows_history()) [[unlikely]]
    return weight * history_factor(s, t, edge);
  return Color(weight * limits_factor(s, t, edge));
}

void BidirectionalWalks::found(const FoundPath& path, const PathEdge& edge) {
  if (is_black(path.contribution)) return;
  if (!is_finite(path.contribution)) [[unlikely]] {
    ++refused_;
    return;
  }
  connections_.push_back(edge);
  found_.push_back(path);
}

bool BidirectionalWalks::leaves_out(int t, bool joined) const {
  if (!leaves_unconnectable || eye_[size_t(t - 1)].exit >= 0) return false;
  for (int k = 1; k < t; ++k)
    if (eye_[size_t(k)].vertex.excludes_photons()) return false;
  const auto specular = [&](int k) { return eye_[size_t(k)].vertex.specular && !(joined && k == t - 1); };
  if (!is_unconnectable(t + 1, [&](int i) { return specular(t - i); })) return false;
  for (int k = 1; k < t; ++k)
    if (eye_[size_t(k)].vertex.kind == VertexKind::Medium) return false;
  int k = 1;
  while (k < t - 1 && specular(k)) ++k;
  return eye_[size_t(k)].vertex.stores_photons();
}

void BidirectionalWalks::find_by_hit(int index) {
  const LightHit& hit = hits_[size_t(index)];
  if (only_strategy > 0) return;
  const int t = hit.t;
  if (leaves_class(t, hit.edge)) return;
  if (!hit.edge.by_ray_kind && leaves_out(t, false) && sends_photons(scene_, hit.light)) return;
  const WalkVertex& end = eye_[size_t(t - 1)];
  Densities d;
  d.count = t + 1;
  d.last = last_strategy(d.count, t);
  double weight = 1.0;
  if (t >= 2) {
    const LightEnd light = light_end(scene_, hit.light, end.vertex, hit.edge, guide);
    d.from_eye[0] = light.can_be_hit_from(end.vertex) ? double(hit.pdf) : 0.0;
    d.from_light[0] = std::max(light.pdf_origin, kNever);
    d.from_light[1] = double(light.pdf_direction) * hit.edge.to_eye_area() * hit.edge.pass * hit.edge.stop_eye_end;
    d.sampled = light.pdf_sampled;
    d.joinable[0] = true;
    for (int k = t - 1; k >= 0; --k) {
      const int j = t - k;
      d.from_eye[j] = k == 0 ? 1.0 : double(eye_[size_t(k)].fwd);
      if (j >= 2) d.from_light[j] = k == 0 ? 0.0 : double(eye_[size_t(k)].rev);
      d.joinable[j] = k == 0 || !eye_[size_t(k)].vertex.specular;
    }
    weight = hit.edge.by_ray_kind || is_limited(hit.light, t - 2)
                 ? double(weight_past_bounces(light, end.vertex, hit.edge, end.scattering.pdf_to_light))
                 : d.weight(0, light_walks_);
    // Walks from the eye must not hit lights whose multiple importance sampling is off. The other strategies count such
    // lights fully.
    if (!(d.from_eye[0] > 0.0) || !is_linked(scene_, hit.light, end.vertex)) weight = 0.0;
  }
  found({0, t, hit.contribution * with_history(float(weight), 0, t, hit.edge), film_, index}, hit.edge);
}

void BidirectionalWalks::find_by_light_sample(int t, Sampler& sampler) {
  const WalkVertex& end = eye_[size_t(t - 1)];
  const PathVertex& b = end.vertex;
  if (!b.connectable()) return;
  if ((only_strategy >= 0 && only_strategy != 1) || (!any_by_ray_kind_ && leaves_class(t, {}))) return;
  sampler.set_dimension(kConnectionDimensions + 4 * uint32_t(t));
  const Vec3 u = sampler.get_3d();
  PathVertex& light = sampled_lights_[size_t(t)];
  if (!sample_light(scene_, b, u.z, Vec2(u), light)) return;
  if (is_limited(light, t - 2)) return;
  const bool left_out = leaves_out(t, true) && sends_photons(scene_, light);
  if (left_out && !any_by_ray_kind_) return;
  PathEdge edge = join(light, b);
  if (sampled == SampledLights::BeyondTerminator && !grazes_terminator(b.point, -edge.to_eye)) return;
  const LightEnd light_side = light_end(scene_, light, b, edge, guide);
  if (!(light_side.pdf_sampled > 0.0f)) return;
  Scattering at_b = scatter(b, b.point.wo, -edge.to_eye, false, guide);
  const PathVertex& scattering = scattering_end(t);
  if (end.stays) at_b.f = scattering.shading.bsdf.evaluate(b.point.wo, -edge.to_eye).f_cos;
  at_b.f = visible_part(scene_, light, scattering, b.point.wo, -edge.to_eye, false, at_b.f);
  Color contribution = end.beta * at_b.f * light_side.radiance * (edge.to_light_area() / light_side.pdf_sampled);
  // Light beyond the terminator is that which shadow rays do not find.
  const bool follows = follows_ray_kinds() || sampled == SampledLights::BeyondTerminator;
  const RayKindSurfaces by_kind = follows ? RayKindSurfaces::Follow : RayKindSurfaces::End;
  if (is_black(contribution) || !look_along({scene_, media}, light, b, edge, rays_, by_kind)) {
    edge.by_ray_kind = false;
    if (sampled == SampledLights::BeforeTerminator || left_out || leaves_class(t, edge)) return;
    contribution = end.beta *
                   light_beyond_terminator({scene_, media}, light, scattering, edge, light_side, at_b.f, rays_) /
                   light_side.pdf_sampled;
    if (is_black(contribution)) return;
    found({1, t, contribution * with_history(1.0f, 1, t, edge), film_}, edge);
    return;
  }
  if (sampled == SampledLights::BeyondTerminator || leaves_class(t, edge)) return;
  if (left_out && !edge.by_ray_kind) return;
  if (edge.by_ray_kind) contribution *= weight_past_ray_kinds(light_side, edge, at_b.pdf_to_light);

  Densities d;
  d.count = t + 1;
  d.last = last_strategy(d.count, t);
  d.sampled = light_side.pdf_sampled;
  d.from_light[0] = std::max(light_side.pdf_origin, kNever);
  d.from_light[1] = double(light_side.pdf_direction) * edge.to_eye_area() * edge.pass * edge.stop_eye_end;
  d.from_eye[0] = light_side.can_be_hit && !light_side.partial && !edge.by_ray_kind
                      ? double(at_b.pdf_to_light) * edge.to_light_area() * edge.surface_pass * (1.0f - light.pass)
                      : 0.0;
  d.joinable[0] = true;
  for (int k = t - 1; k >= 0; --k) {
    const int j = t - k;
    d.from_eye[j] = k == 0 ? 1.0 : double(eye_[size_t(k)].fwd);
    if (j == 2)
      d.from_light[j] = k == 0 ? 0.0
                               : double(at_b.pdf_walk_to_eye) * end.edge.to_eye_area() * end.edge.pass *
                                     end.edge.stop_eye_end;
    if (j > 2) d.from_light[j] = k == 0 ? 0.0 : double(eye_[size_t(k)].rev);
    d.joinable[j] = k == 0 || j == 1 || !eye_[size_t(k)].vertex.specular;
  }
  contribution *= edge.transmittance * with_history(float(d.weight(1, light_walks_)), 1, t, edge);
  found({1, t, contribution, film_}, edge);
}

/// The weight of the first edge of the walk from the light if it passes surfaces that depend on the kind of the ray.
/// `at_end`: the scattering at its vertex s - 1, which is connected.
float BidirectionalWalks::weight_of_first_edge(int s, const Scattering& at_end) const {
  const WalkVertex& first = light_[1];
  if (!first.edge.by_ray_kind) [[likely]]
    return 1.0f;
  return weight_past_ray_kinds(light_end_, first.edge, (s == 2 ? at_end : first.scattering).pdf_to_light);
}

void BidirectionalWalks::find_by_connection(int s, int t) {
  const WalkVertex &from = light_[size_t(s - 1)], &to = eye_[size_t(t - 1)];
  const PathVertex &a = from.vertex, &b = to.vertex;
  if (!a.connectable() || !b.connectable()) return;
  if ((only_strategy >= 0 && only_strategy != s) || leaves_class(t, light_[1].edge)) return;
  if (is_limited(light_[0].vertex, s + t - 3)) return;
  PathEdge edge = join(a, b);
  if (!(edge.inverse_square > 0.0f) || !may_scatter_to(b, -edge.to_eye) || !may_scatter_to(a, edge.to_eye)) return;
  // A ray takes less time than the lobes of both ends. A walk through volumes takes more.
  if (!media && !look_along({scene_, media}, a, b, edge, rays_)) return;
  Scattering at_b = scatter(b, b.point.wo, -edge.to_eye, false, guide);
  if (to.stays) at_b.f = staying_[size_t(t - 1)].shading.bsdf.evaluate(b.point.wo, -edge.to_eye).f_cos;
  if (is_black(at_b.f)) return;
  Scattering at_a = scatter(a, edge.to_eye, a.point.wo, false, guide);
  if (s == 2) at_a.f = visible_part(scene_, light_[0].vertex, a, edge.to_eye, a.point.wo, false, at_a.f);
  Color contribution = from.beta * at_a.f * at_b.f * to.beta * edge.to_light_area();
  if (is_black(contribution) || (media && !look_along({scene_, media}, a, b, edge, rays_))) return;
  contribution *= weight_of_first_edge(s, at_a);

  Densities d;
  d.count = s + t;
  d.last = last_strategy(d.count, t);
  d.sampled = light_end_.pdf_sampled;
  for (int j = 0; j < s; ++j) {
    d.from_light[j] = light_[size_t(j)].fwd;
    d.joinable[j] = j == 0 || j == s - 1 || !light_[size_t(j)].vertex.specular;
    if (j < s - 2) d.from_eye[j] = light_[size_t(j)].rev;
  }
  d.from_eye[s - 1] = double(at_b.pdf_to_light) * edge.to_light_area() * edge.pass * edge.stop_light_end;
  d.from_eye[s - 2] = s == 2 && (!light_end_.can_be_hit || light_end_.partial || from.edge.by_ray_kind)
                          ? 0.0
                          : double(at_a.pdf_to_light) * from.edge.to_light_area() *
                                (s == 2 ? from.edge.surface_pass : from.edge.pass) * from.edge.stop_light_end;
  for (int k = t - 1; k >= 0; --k) {
    const int j = d.count - 1 - k;
    d.from_eye[j] = k == 0 ? 1.0 : double(eye_[size_t(k)].fwd);
    d.joinable[j] = k == 0 || k == t - 1 || !eye_[size_t(k)].vertex.specular;
    if (k < t - 2) d.from_light[j] = k == 0 ? 0.0 : double(eye_[size_t(k)].rev);
  }
  d.from_light[s] = double(at_a.pdf_walk_to_eye) * edge.to_eye_area() * edge.pass * edge.stop_eye_end;
  d.from_light[s + 1] = t == 2 ? 0.0
                               : double(at_b.pdf_walk_to_eye) * to.edge.to_eye_area() * to.edge.pass *
                                     to.edge.stop_eye_end;
  contribution *= edge.transmittance * with_history(float(d.weight(s, light_walks_)), s, t, edge);
  found({s, t, contribution, film_}, edge);
}

void BidirectionalWalks::find_by_lens(int s) {
  const WalkVertex& from = light_[size_t(s - 1)];
  const PathVertex& a = from.vertex;
  if (!a.connectable()) return;
  if (only_strategy >= 0 && only_strategy != s) return;
  if (!shows_on_film(a.point)) return;
  if (is_limited(light_[0].vertex, s - 2)) return;
  const auto film = scene_.camera().film_of(lens_.point.barycentric, a.position(), time_);
  if (!film || film->x < -margin_ || film->y < -margin_ || film->x > float(scene_.camera().width()) + margin_ ||
      film->y > float(scene_.camera().height()) + margin_)
    return;
  PathEdge edge = join(a, lens_);
  if (!(edge.inverse_square > 0.0f)) return;
  const float density = lens_density(scene_, edge, time_);
  Scattering at_a = scatter(a, edge.to_eye, a.point.wo, false, guide);
  if (s == 2) at_a.f = visible_part(scene_, light_[0].vertex, a, edge.to_eye, a.point.wo, false, at_a.f);
  Color contribution = from.beta * at_a.f * (edge.to_light_area() * density);
  if (is_black(contribution) || !look_along({scene_, media}, a, lens_, edge, rays_)) return;
  contribution *= weight_of_first_edge(s, at_a);

  Densities d;
  d.count = s + 1;
  d.last = s;
  d.sampled = light_end_.pdf_sampled;
  for (int j = 0; j < s; ++j) {
    d.from_light[j] = light_[size_t(j)].fwd;
    d.joinable[j] = j == 0 || j == s - 1 || !light_[size_t(j)].vertex.specular;
    if (j < s - 2) d.from_eye[j] = light_[size_t(j)].rev;
  }
  d.from_eye[s - 1] = double(density) * edge.to_light_area() * edge.pass * edge.stop_light_end;
  d.from_eye[s - 2] = s == 2 && (!light_end_.can_be_hit || light_end_.partial || from.edge.by_ray_kind)
                          ? 0.0
                          : double(at_a.pdf_to_light) * from.edge.to_light_area() *
                                (s == 2 ? from.edge.surface_pass : from.edge.pass) * from.edge.stop_light_end;
  d.from_eye[s] = 1.0;
  d.from_light[s] = 0.0;
  d.joinable[s] = true;
  contribution *= edge.transmittance * with_history(float(d.weight(s, light_walks_)), s, 1, edge);
  found({s, 1, contribution, *film}, edge);
}

}  // namespace ajar
