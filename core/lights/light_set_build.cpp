#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <tbb/parallel_for.h>

#include "lights/light_set_data.h"

namespace ajar {

namespace {

/// With media and at most so many lights, half of the choices are uniform.
constexpr size_t kMaxLightsForEven = 8;
/// Share of the probability of distant lights that is divided equally among them: a sky matters where the sun is
/// hidden.
constexpr float kEqualDistant = 0.25f;
/// The power of sources of which the estimate found nothing, as a part of all power, divided among all sources; for meshes
/// with more than kFewDark triangles it falls with their number.
constexpr double kUnknown = 0.01;
constexpr uint32_t kFewDark = 64;

}  // namespace

/// Mean of a lamp's shader over directions, at the centre.
double LightSet::Data::mean_factor(const Light& lamp, float distance) const {
  double sum = 0.0;
  for (int k = 0; k < 64; ++k) {
    const Vec3 wo = warp::square_to_sphere({(float(k % 8) + 0.5f) / 8.0f, (float(k / 8) + 0.5f) / 8.0f});
    sum += luminous(shader_factor(lamp, lamp.position, wo, 0.0f, distance, 0)) / 64.0;
  }
  return sum;
}

void LightSet::Data::add_lamps(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources) {
  for (size_t i = 0; i < in.description.lights.size(); ++i) {
    const LightDescription& description = in.description.lights[i];
    Light light = make_lamp(description);
    bool may_emit = true;
    double factor = 1.0;
    int growth = 0;
    if (!description.graph.empty()) {
      const ShaderProgram& program = in.lamp_programs[i];
      may_emit = program.emits();
      if (may_emit && program.emission_is_constant()) {
        light.radiance *= program.evaluate_emission(ShadingPoint());
      } else if (may_emit) {
        light.shader = int(i);
        const bool grows = program.emission_depends_on_distance() && !is_distant(light.type);
        factor = mean_factor(light, grows ? kFar * scene_radius : kUsualDistance);
        if (grows) growth = growth_between(mean_factor(light, kNear * scene_radius), factor);
        if (!std::isfinite(factor)) factor = 0.0;
      }
    }
    if (!may_emit) light.radiance = Color(0.0f);
    const double power = luminous(lamp_flux(light, scene_radius));
    if (!is_finite(light.radiance) || !std::isfinite(power)) {
      report_once(diagnostics, {Diagnostic::Severity::Error, description.name,
                                "The strength or size of the light is not a usable number; the light does not emit."});
      light.radiance = Color(0.0f);
    } else if (power > 0.0) {
      light.power = float(power * factor);
      sources.push_back({uint32_t(i), uint32_t(i), 1, power * factor, 1.0, growth});
    }
    if (light.type == LightType::DistantDisk && !is_black(light.radiance) && light.mis)
      distant_disks.push_back(uint32_t(i));
    light.receivers = description.links.receivers;
    light.blockers = blockers_of(description.links);
    light.max_bounces = description.max_bounces;
    any_linked |= light.receivers != kAllReceivers;
    any_limited |= light.max_bounces < in.description.settings.bounces.total;
    any_partial |= !is_black(light.radiance) &&
                   (LightFlags{light.type, light.visibility}.partial() || light.blockers != kVisibleShadow);
    any_without_walks |= !light.cast_shadow || light.blockers != kVisibleShadow;
    lamps.push_back(light);
  }
}

void LightSet::Data::add_environment(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources,
                                     std::vector<double>& weights) {
  took_environment_over = in.same_world && in.same_world->data_->environment.has_map();
  environment = took_environment_over ? Environment(std::move(in.same_world->data_->environment), in.world_program,
                                                    in.description.world.visibility)
                                      : Environment(in.world_program, in.description.world.visibility);
  if (environment.black()) return;
  if (!std::isfinite(environment.mean_luminance())) {
    report_once(diagnostics, {Diagnostic::Severity::Error, in.description.world.name,
                              "The strength of the world is not a finite number; the world does not emit."});
    environment = Environment();
    return;
  }
  environment_visibility = in.description.world.visibility;
  environment_bounces = in.description.world.max_bounces;
  any_limited |= environment_bounces < in.description.settings.bounces.total;
  environment_index = int(size++);
  // Radiance integrated over the sphere, times the area of the scene's disk.
  const double power = 4.0 * M_PI * double(environment.mean_luminance()) * M_PI * double(scene_radius) *
                       double(scene_radius);
  const bool partial = LightFlags{LightType::Environment, environment_visibility}.partial();
  any_partial |= partial;
  const double chosen = partial ? 1.0 : double(environment.excess_luminance()) / double(environment.mean_luminance());
  sources.push_back({uint32_t(environment_index), uint32_t(weights.size()), 1, power, chosen});
  weights.push_back(1.0);
}

namespace {

/// Bounds of a triangle that emits `watts`, over the shutter interval. They decide how often a light is chosen, so that a
/// few times are enough.
LightBounds bounds_in_motion(const BuiltMesh& mesh, const BuiltInstance& instance, uint32_t primitive, float watts) {
  constexpr size_t kMaxTimes = 8;
  const auto at = [&](float time, float share) {
    return triangle_bounds(world_triangle(mesh, instance, primitive, time), share * watts);
  };
  if (!moves(mesh, instance)) return at(kMidShutter, 1.0f);
  const size_t keys = std::max<size_t>(instance.motion_count, mesh.deformation ? mesh.deformation->keys.size() : 0),
               times = std::clamp<size_t>(keys, 2, kMaxTimes);
  LightBounds all = at(0.0f, 1.0f / float(times));
  for (size_t k = 1; k < times; ++k) all = join(all, at(float(k) / float(times - 1), 1.0f / float(times)));
  return all;
}

}  // namespace

/// Of the lights of these sources, with the watts of each entry.
LightChooser LightSet::Data::make_chooser(const std::vector<Source>& sources, const std::vector<double>& watts,
                                          bool has_media) const {
  LightChooser chooser;
  chooser.max_distant = LightChooser::kMaxBesideDark;
  std::vector<LightTree::Entry> entries;
  const double disk = M_PI * double(scene_radius) * double(scene_radius);
  for (const Source& s : sources) {
    if (!(s.chosen > 0.0)) continue;
    if (is_environment(s.light)) {
      chooser.distant.push_back({s.light, float(s.chosen * watts[s.first] / disk / 4.0), Vec3(0.0f), 1.0f, 0.0f});
      continue;
    }
    if (is_lamp(s.light) && is_distant(lamps[s.light].type)) {
      const Light& sun = lamps[s.light];
      const float cosine = 1.0f / std::sqrt(1.0f + sqr(sun.radius));
      chooser.distant.push_back({s.light, float(watts[s.first] / disk), -sun.frame.n, cosine, sun.radius * cosine});
      continue;
    }
    if (s.power > 0.0) chooser.max_distant = LightChooser::kMaxDistant;
    if (is_lamp(s.light)) {
      entries.push_back({s.first, lamp_bounds(lamps[s.light], float(watts[s.first]))});
      let_grow(entries.back().bounds, s.growth, kFar * scene_radius);
    } else if (s.shared >= 0) {
      const BuiltInstance& instance = instances[block_of(s.light).instance];
      entries.push_back({s.first, clusters.bounds_of(s.shared, instance, float(watts[s.first]))});
    } else {
      const BuiltInstance& instance = instances[block_of(s.light).instance];
      const size_t start = entries.size();
      entries.resize(start + s.count);
      tbb::parallel_for(tbb::blocked_range<uint32_t>(0, s.count, 4096), [&](const tbb::blocked_range<uint32_t>& range) {
        for (uint32_t t = range.begin(); t != range.end(); ++t) {
          entries[start + t] = {s.first + t,
                                bounds_in_motion(meshes[instance.mesh], instance, t, float(watts[s.first + t]))};
          let_grow(entries[start + t].bounds, s.growth, kFar * scene_radius);
        }
      });
    }
  }
  float all_distant = 0.0f;
  for (const LightChooser::DistantLight& l : chooser.distant) all_distant += l.irradiance;
  for (LightChooser::DistantLight& l : chooser.distant)
    l.irradiance = (1.0f - kEqualDistant) * l.irradiance + kEqualDistant * all_distant / float(chooser.distant.size());
  // Lights that are too weak for floats cannot be compared with others.
  std::erase_if(entries, [](const LightTree::Entry& e) {
    return !(e.bounds.intensity > 0.0f && std::isfinite(e.bounds.intensity) && is_finite(e.bounds.lower) &&
             is_finite(e.bounds.upper));
  });
  const size_t count = entries.size() + chooser.distant.size();
  if (has_media && count > 1 && count <= kMaxLightsForEven && clusters.empty()) {
    for (const LightTree::Entry& e : entries) chooser.even.push_back(e.light);
    for (const LightChooser::DistantLight& l : chooser.distant) chooser.even.push_back(l.light);
  }
  chooser.tree = LightTree(std::move(entries), uint32_t(watts.size()));
  if (!clusters.empty()) chooser.clusters = &clusters;
  return chooser;
}

/// `inside`: power of each entry relative to the others of its source.
void LightSet::Data::make_tables(const std::vector<Source>& sources, const std::vector<double>& inside,
                                 bool has_media) {
  double total = 0.0;
  for (const Source& s : sources) total += s.power;
  std::vector<double> watts(inside.size(), 0.0);
  for (const Source& s : sources) {
    // A source of unknown power must also be chosen and emit rays. The more triangles were found dark, the less.
    const double unknown = std::max(total, 1.0) * kUnknown / double(sources.size()) *
                           std::min(1.0, double(kFewDark) / double(s.count));
    const double power = s.power > 0.0 ? s.power : unknown;
    double sum = 0.0;
    for (uint32_t i = s.first; i < s.first + s.count; ++i) sum += inside[i];
    for (uint32_t i = s.first; i < s.first + s.count; ++i) watts[i] = power * inside[i] / sum;
  }
  all = make_chooser(sources, watts, has_media);
  by_power = DiscreteDistribution(watts);
  if (!any_linked) return;
  // Receiver sets that have the same lights share a chooser.
  std::map<std::vector<bool>, uint8_t> known;
  for (uint32_t set = 0; set < kEveryLight; ++set) {
    std::vector<bool> lit;
    std::vector<Source> of_set;
    for (const Source& s : sources) {
      lit.push_back(lights_set(receivers_of(s.light), set));
      if (lit.back()) of_set.push_back(s);
    }
    const auto [found, is_new] = known.emplace(std::move(lit), uint8_t(linked.size()));
    if (is_new) linked.push_back(make_chooser(of_set, watts, has_media));
    linked_of.push_back(found->second);
  }
}

LightSet::LightSet(const LightBuildInput& in, Diagnostics& diagnostics) : LightSet() {
  Data& d = *data_;
  d.objects = in.objects.data();
  d.meshes = in.meshes.data();
  d.instances = in.instances.data();
  d.lamp_programs = in.lamp_programs.data();
  d.scene_center = in.scene_center;
  d.scene_radius = in.scene_radius;
  for (BuiltInstance& instance : in.instances) instance.first_light = ~0u;
  std::vector<Data::Source> sources;
  d.add_lamps(in, diagnostics, sources);
  std::vector<double> weights(d.lamps.size(), 1.0);
  d.size = uint32_t(d.lamps.size());
  d.add_triangles(in, diagnostics, sources, weights);
  d.add_environment(in, diagnostics, sources, weights);
  if (sources.empty()) {
    *data_ = Data();
    return;
  }
  d.make_tables(sources, weights, in.has_media);
  any_ = {d.any_partial, d.any_linked, d.any_limited};
}

}  // namespace ajar
