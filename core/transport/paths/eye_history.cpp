#include "transport/paths/eye_history.h"

#include <algorithm>
#include <utility>

#include "transport/paths/ray_events.h"

namespace ajar {

namespace {

/// The lobes of a vertex for light that travels to the eye, and those that remain if light enters the others.
struct Lobes {
  Bsdf all, staying;

  Lobes(const PathVertex& vertex, Vec3 to_eye) : all(lobes_towards(vertex, to_eye)), staying(all) {
    staying.remove_subsurface(to_eye);
  }
  /// The share of the light that the remaining lobes scatter. `visibility`: of the light.
  Color share(Vec3 to_eye, Vec3 to_light, uint32_t visibility) const {
    Color share(0.0f);
    if (staying.empty()) return share;
    const bool partial = visibility != kVisibleAll;
    const Color of = partial ? visible_to(visibility, all, to_eye, to_light) : all.evaluate(to_eye, to_light).f_cos,
                part = partial ? visible_to(visibility, staying, to_eye, to_light)
                               : staying.evaluate(to_eye, to_light).f_cos;
    for (int c = 0; c < 3; ++c)
      if (of[c] > 0.0f) share[c] = part[c] / of[c];
    return share;
  }
};

}  // namespace

void EyeHistory::start(const ShadingPoint& point, int collisions) {
  collisions_ = collisions;
  states_.clear();
  extend(states_,
         {point.diffuse_depth, point.glossy_depth, point.transmission_depth, point.after_diffuse, Color(1.0f)});
}

void EyeHistory::extend(std::vector<State>& next, State state) const {
  if (is_black(state.factor)) return;
  if (limits_ && (state.diffuse > limits_->diffuse || state.glossy > limits_->glossy ||
                  state.transmission > limits_->transmission))
    return;
  if (!limits_) state.diffuse = state.glossy = state.transmission = 0;
  for (State& s : next) {
    if (s.diffuse != state.diffuse || s.glossy != state.glossy || s.transmission != state.transmission ||
        s.after_diffuse != state.after_diffuse)
      continue;
    s.factor += state.factor;
    return;
  }
  next.push_back(state);
}

void EyeHistory::add(const PathVertex& vertex, Vec3 to_eye, Vec3 to_light, bool specular) {
  if (vertex.kind == VertexKind::Medium) {
    if (limits_ && ++collisions_ > limits_->volume) states_.clear();
    return;
  }
  const bool divides = !specular && can_enter(vertex);
  const auto by_diffuse = [](const State& s) { return s.after_diffuse; };
  if (!limits_ && (specular || (std::all_of(states_.begin(), states_.end(), by_diffuse) &&
                                !(divides && vertex.shading.medium.after_diffuse))))
    return;
  const auto extend_by = [&](std::vector<State>& next, const State& from, Color factor,
                             const Bsdf::KindShares& shares) {
    const auto& [d, g, t, after_diffuse, factor_of_from] = from;
    extend(next, {d + 1, g, t, true, factor * shares.diffuse});
    extend(next, {d, g + 1, t, after_diffuse, factor * shares.glossy});
    extend(next, {d, g, t + 1, after_diffuse, factor * shares.transmission});
    extend(next, {d, g, t + 1, true, factor * shares.diffuse_transmission});
  };
  std::vector<State> next;
  const Lobes lobes(vertex, to_eye);
  const Bsdf::KindShares of_all = lobes.all.kind_shares(to_eye, to_light, specular);
  if (!divides) {
    for (const State& s : states_) extend_by(next, s, s.factor, of_all);
  } else {
    const Bsdf::KindShares of_staying = lobes.staying.kind_shares(to_eye, to_light, false);
    const Color share = lobes.share(to_eye, to_light, kVisibleAll);
    for (const State& s : states_) {
      if (enters(vertex, s.after_diffuse))
        extend_by(next, s, s.factor * share, of_staying);
      else
        extend_by(next, s, s.factor, of_all);
    }
  }
  states_ = std::move(next);
}

void EyeHistory::end(const Scene& scene, const PathVertex& light, const PathVertex& vertex, Vec3 to_eye, Vec3 to_light,
                     bool specular) {
  if (specular || !can_enter(vertex)) return;
  const uint32_t visibility = light.light >= 0 ? scene.lights().flags(uint32_t(light.light)).visibility
                                               : uint32_t(kVisibleAll);
  const Color share = Lobes(vertex, to_eye).share(to_eye, to_light, visibility);
  for (State& s : states_)
    if (enters(vertex, s.after_diffuse)) s.factor *= share;
}

Color EyeHistory::factor() const {
  Color sum(0.0f);
  for (const State& s : states_) sum += s.factor;
  return sum;
}

}  // namespace ajar
