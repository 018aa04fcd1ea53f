#include "lights/light_set.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <tbb/parallel_for.h>

#include "lights/environment.h"
#include "lights/lamp.h"
#include "lights/light_tree.h"
#include "lights/triangle_light.h"
#include "math/distribution.h"
#include "math/random.h"
#include "math/warps.h"

namespace ajar {

namespace {

/// Triangles with varying emission also get this fraction of the mean of their instance.
constexpr float kTriangleFloor = 0.05f;
/// Minimum and maximum probability of all distant lights together if there are other lights: occlusion is not known.
constexpr float kMinDistant = 0.1f, kMaxDistant = 0.8f;
/// Minimum cosine at the receiver of a sun: shading normals differ from geometric ones.
constexpr float kMinSunCosine = 0.02f;
/// Share of uniform choices in scenes with media that have at most this many lights.
constexpr float kEvenShare = 0.5f;
constexpr size_t kMaxLightsForEven = 8;
/// Share of the probability of distant lights that is divided equally among them: a sky matters where the sun is
/// hidden.
constexpr float kEqualDistant = 0.25f;

struct SlotEmission {
  const ShaderProgram* program = nullptr;  // null: no emission
  bool constant = true;
  Color radiance{0.0f};  // if constant
};

/// All triangles of one emissive instance: lights first .. first + count - 1.
struct TriangleBlock {
  uint32_t instance = 0, first = 0, count = 0;
  std::vector<SlotEmission> slots;
};

/// A lamp, an emissive instance or the environment, for the tables of choice.
struct Source {
  uint32_t first, count;
  double power;         // 0: may emit although the estimate found nothing
  double chosen = 1.0;  // fraction of the power that counts for the choice
};

/// A sun or the environment, for the choice.
struct DistantLight {
  uint32_t light;
  float irradiance;          // on a surface that faces it; for the environment, of the radiance above its mean
  Vec3 direction;            // towards it; 0: all directions
  float cos_size, sin_size;  // of its disk
  float importance(Vec3 n) const {
    if (n == Vec3(0.0f) || direction == Vec3(0.0f)) return irradiance;
    const float cosine = glm::dot(n, direction), sine = safe_sqrt(1.0f - cosine * cosine);
    return irradiance * (cosine >= cos_size ? 1.0f : std::max(cosine * cos_size + sine * sin_size, kMinSunCosine));
  }
};

double luminous(Color c) { return luminance(glm::abs(c)); }

}  // namespace

struct LightSet::Data {
  const ObjectDescription* objects = nullptr;
  const BuiltMesh* meshes = nullptr;
  const BuiltInstance* instances = nullptr;
  const ShaderProgram* lamp_programs = nullptr;
  std::vector<Light> lamps;
  std::vector<TriangleBlock> blocks;  // by `first`
  Environment environment;
  uint32_t environment_visibility = 0;
  bool any_partial = false, took_environment_over = false;
  int environment_index = -1;
  std::vector<uint32_t> distant_disks;
  Vec3 scene_center{0.0f};
  float scene_radius = 1.0f;
  DiscreteDistribution by_power;
  LightTree tree;  // of all local lights
  std::vector<DistantLight> distant;
  // lights with an additional uniform probability; empty without media or with many lights
  std::vector<uint32_t> even;
  uint32_t size = 0;

  const TriangleBlock& block_of(uint32_t index) const {
    return *(std::upper_bound(blocks.begin(), blocks.end(), index,
                              [](uint32_t i, const TriangleBlock& b) { return i < b.first; }) -
             1);
  }
  const SlotEmission& emission_of(const TriangleBlock& block, uint32_t primitive) const {
    const BuiltMesh& mesh = meshes[instances[block.instance].mesh];
    const size_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[primitive];
    return block.slots[std::min(slot, block.slots.size() - 1)];  // removed slots use the last one
  }
  bool can_choose(uint32_t index) const {
    return tree.contains(index) ||
           std::any_of(distant.begin(), distant.end(), [&](const DistantLight& l) { return l.light == index; });
  }
  /// Sum of the importances of distant lights.
  float distant_importance(Vec3 n) const {
    float sum = 0.0f;
    for (const DistantLight& l : distant) sum += l.importance(n);
    return sum;
  }
  /// Share of the distant lights in the choice for p.
  float distant_share(Vec3 p, Vec3 n, float importance_of_distant) const {
    if (distant.empty()) return 0.0f;
    const float near = tree.importance(p, n);
    if (!(near > 0.0f)) return 1.0f;
    return std::clamp(importance_of_distant / (importance_of_distant + near), kMinDistant, kMaxDistant);
  }
  Choice choose_distant(Vec3 n, float u) const {
    const float sum = distant_importance(n);
    const DistantLight* chosen = &distant.back();
    float pmf = 1.0f;
    for (const DistantLight& l : distant) {
      pmf = l.importance(n) / sum;
      if (u < pmf || &l == chosen) {
        chosen = &l;
        break;
      }
      u -= pmf;
    }
    return {chosen->light, pmf, std::min(u / pmf, kOneMinusEpsilon)};
  }
  [[gnu::always_inline]] Choice choose_by_estimate(Vec3 p, Vec3 n, float u) const {
    float share = 0.0f;
    if (!distant.empty()) {
      const float sum = distant_importance(n);
      share = distant_share(p, n, sum);
      if (u < share) {
        Choice choice = choose_distant(n, std::min(u / share, kOneMinusEpsilon));
        choice.pmf *= share;
        return choice;
      }
      u = std::min((u - share) / (1.0f - share), kOneMinusEpsilon);
    }
    if (tree.empty()) return {0, 0.0f, u};
    const LightTree::Choice choice = tree.choose(p, n, u);
    return {choice.light, (1.0f - share) * choice.pmf, choice.u_remapped};
  }
  float pmf_by_estimate(Vec3 p, Vec3 n, uint32_t light) const {
    if (distant.empty()) return tree.pmf(p, n, light);
    const float sum = distant_importance(n), share = distant_share(p, n, sum);
    for (const DistantLight& l : distant)
      if (l.light == light) return share * (l.importance(n) / sum);
    return (1.0f - share) * tree.pmf(p, n, light);
  }
  bool is_lamp(uint32_t index) const { return index < lamps.size(); }
  bool is_environment(uint32_t index) const { return int(index) == environment_index; }

  void add_lamps(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources);
  void add_triangles(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources,
                     std::vector<double>& weights);
  void add_environment(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources,
                       std::vector<double>& weights);
  void make_tables(const std::vector<Source>& sources, const std::vector<double>& inside, bool has_media);

  Color lamp_radiance(const Light& light, Vec3 position, Vec3 wo, float time, float distance, uint32_t ray_kind) const {
    const Color radiance = light.radiance * lamp_profile(light, wo);
    return light.shader < 0 || is_black(radiance)
               ? radiance
               : radiance * shader_factor(light, position, wo, time, distance, ray_kind);
  }
  std::optional<LightSample> sample_lamp(const Light& lamp, Vec3 p, Vec2 u, float time, uint32_t ray_kind) const {
    std::optional<LightSample> sample = sample_lamp_li(lamp, p, u);
    if (sample) sample->position_error = lamp_position_error(sample->position);
    if (sample && lamp.shader >= 0)
      sample->radiance *= shader_factor(lamp, sample->position, -sample->wi, time, sample->distance, ray_kind);
    return sample;
  }
  Color shader_factor(const Light& light, Vec3 position, Vec3 wo, float time, float distance, uint32_t ray_kind) const {
    ShadingPoint point;
    // The inputs that nodes of lamps have in Cycles: the position of a sun is the direction of its light, and the
    // normal of all lamps but area lamps is that direction.
    point.position = is_distant(light.type) ? wo : position;
    point.wo = wo;
    point.ng = point.ns = light.type == LightType::Rectangle || light.type == LightType::Ellipse ? light.frame.n : wo;
    point.time = time;
    point.ray_kind = ray_kind;
    point.ray_length = is_distant(light.type) ? 0.0f : distance;
    return lamp_programs[light.shader].evaluate_emission(point);
  }
};

// ---- Building -------------------------------------------------------------------------

void LightSet::Data::add_lamps(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources) {
  for (size_t i = 0; i < in.description.lights.size(); ++i) {
    const LightDescription& description = in.description.lights[i];
    Light light = make_lamp(description);
    bool may_emit = true;
    double factor = 1.0;
    if (!description.graph.empty()) {
      const ShaderProgram& program = in.lamp_programs[i];
      may_emit = program.emits();
      if (may_emit && program.emission_is_constant()) {
        light.radiance *= program.evaluate_emission(ShadingPoint());
      } else if (may_emit) {
        light.shader = int(i);
        // Mean of the shader over directions, at the centre.
        factor = 0.0;
        for (int k = 0; k < 64; ++k) {
          const Vec3 wo = warp::square_to_sphere({(float(k % 8) + 0.5f) / 8.0f, (float(k / 8) + 0.5f) / 8.0f});
          factor += luminous(shader_factor(light, light.position, wo, 0.0f, kUsualDistance, 0)) / 64.0;
        }
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
      sources.push_back({uint32_t(i), 1, power * factor});
    }
    if (light.type == LightType::DistantDisk && !is_black(light.radiance) && light.mis)
      distant_disks.push_back(uint32_t(i));
    any_partial |= !is_black(light.radiance) && LightFlags{light.type, light.visibility}.partial();
    lamps.push_back(light);
  }
}

void LightSet::Data::add_triangles(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources,
                                   std::vector<double>& weights) {
  for (size_t i = 0; i < in.instances.size(); ++i) {
    BuiltInstance& instance = in.instances[i];
    const BuiltMesh& mesh = in.meshes[instance.mesh];
    const uint32_t count = uint32_t(mesh.triangles.size());
    TriangleBlock block;
    block.instance = uint32_t(i);
    block.first = uint32_t(weights.size());
    block.count = count;
    bool emits = false, constant = true;
    for (uint32_t slot = 0; slot < std::max(1u, instance.material_count); ++slot) {
      SlotEmission emission;
      const ShaderProgram& program = in.programs[in.material_table[instance.first_material + slot]];
      if (program.emits()) {
        emission.program = &program;
        emission.constant = program.emission_is_constant();
        if (emission.constant) emission.radiance = program.evaluate_emission(ShadingPoint());
        if (!is_finite(emission.radiance)) {
          report_once(diagnostics,
                      {Diagnostic::Severity::Error, in.objects[instance.object].name,
                       "The emission of a material is not a finite number; the object is not used as a light."});
          emission.program = nullptr;
        }
        emits |= emission.program && (!emission.constant || !is_black(emission.radiance));
        constant &= emission.constant;
      }
      block.slots.push_back(emission);
    }
    if (emits && mesh.strands)
      report_once(diagnostics, {Diagnostic::Severity::Warning, in.objects[instance.object].name,
                                "The object's hair emits light, which only random rays find: expect noise."});
    // Only a ray at its time finds the positions of the triangles of a moving object.
    if (!emits || count == 0 || instance.motion) continue;
    if (uint64_t(block.first) + count > 0x7fffffffu) {
      report_once(diagnostics, {Diagnostic::Severity::Error, in.objects[instance.object].name,
                                "Too many emissive triangles; the object is not used as a light."});
      continue;
    }

    // Watts of every triangle, both sides. Where the emission varies, a fraction of the mean is added.
    weights.resize(block.first + size_t(count), 0.0);
    double* const power = weights.data() + block.first;
    std::vector<float> areas(constant ? 0 : count, 0.0f);
    tbb::parallel_for(tbb::blocked_range<uint32_t>(0, count, 4096), [&](const tbb::blocked_range<uint32_t>& range) {
      for (uint32_t t = range.begin(); t != range.end(); ++t) {
        const SlotEmission& emission = emission_of(block, t);
        if (!emission.program) continue;
        const WorldTriangle triangle = world_triangle(mesh, instance, t);
        const Color radiance = emission.constant ? emission.radiance
                                                 : mean_emission(*emission.program, in.objects[instance.object], mesh,
                                                                 instance, t, triangle);
        const double watts = 2.0 * M_PI * double(triangle.area) * luminous(radiance);
        power[t] = std::isfinite(watts) ? watts : 0.0;
        if (!constant && !emission.constant && std::isfinite(triangle.area)) areas[t] = triangle.area;
      }
    });
    double total = 0.0, area = 0.0;
    for (uint32_t t = 0; t < count; ++t) total += power[t];
    for (float a : areas) area += a;
    if (area > 0.0) {
      const double floor = total > 0.0 ? kTriangleFloor * total / area : 1.0;
      for (uint32_t t = 0; t < count; ++t) power[t] += floor * areas[t];
    }
    if (!(total > 0.0) && !(area > 0.0)) {
      weights.resize(block.first);
      continue;
    }
    instance.first_light = block.first;
    any_partial |= LightFlags{LightType::Triangle, instance.visibility}.partial();
    sources.push_back({block.first, count, total});
    blocks.push_back(std::move(block));
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
  environment_index = int(weights.size());
  // Radiance integrated over the sphere, times the area of the scene's disk.
  const double power = 4.0 * M_PI * double(environment.mean_luminance()) * M_PI * double(scene_radius) *
                       double(scene_radius);
  const bool partial = LightFlags{LightType::Environment, environment_visibility}.partial();
  any_partial |= partial;
  const double chosen = partial ? 1.0 : double(environment.excess_luminance()) / double(environment.mean_luminance());
  sources.push_back({uint32_t(environment_index), 1, power, chosen});
  weights.push_back(1.0);
}

/// `inside`: power of each light relative to the others of its source.
void LightSet::Data::make_tables(const std::vector<Source>& sources, const std::vector<double>& inside,
                                 bool has_media) {
  double total = 0.0;
  for (const Source& s : sources) total += s.power;
  std::vector<double> watts(inside.size(), 0.0);
  std::vector<LightTree::Entry> entries;
  for (const Source& s : sources) {
    // A source of unknown power must also be chosen and emit rays.
    const double power = s.power > 0.0 ? s.power : std::max(total, 1.0) * 0.01 / double(sources.size());
    double sum = 0.0;
    for (uint32_t i = s.first; i < s.first + s.count; ++i) sum += inside[i];
    for (uint32_t i = s.first; i < s.first + s.count; ++i) watts[i] = power * inside[i] / sum;
    if (!(s.chosen > 0.0)) continue;
    if (is_environment(s.first)) {
      const double disk = M_PI * double(scene_radius) * double(scene_radius);
      distant.push_back({s.first, float(s.chosen * power / disk / 4.0), Vec3(0.0f), 1.0f, 0.0f});
    } else if (is_lamp(s.first) && is_distant(lamps[s.first].type)) {
      const Light& sun = lamps[s.first];
      const float cosine = 1.0f / std::sqrt(1.0f + sqr(sun.radius));
      distant.push_back({s.first, float(power / (M_PI * double(scene_radius) * double(scene_radius))), -sun.frame.n,
                         cosine, sun.radius * cosine});
    } else if (is_lamp(s.first)) {
      entries.push_back({s.first, lamp_bounds(lamps[s.first], float(power))});
    } else {
      const TriangleBlock& block = block_of(s.first);
      const BuiltInstance& instance = instances[block.instance];
      const size_t start = entries.size();
      entries.resize(start + s.count);
      tbb::parallel_for(tbb::blocked_range<uint32_t>(0, s.count, 4096), [&](const tbb::blocked_range<uint32_t>& range) {
        for (uint32_t t = range.begin(); t != range.end(); ++t)
          entries[start + t] = {s.first + t, triangle_bounds(world_triangle(meshes[instance.mesh], instance, t),
                                                             float(watts[s.first + t]))};
      });
    }
  }
  float all_distant = 0.0f;
  for (const DistantLight& l : distant) all_distant += l.irradiance;
  for (DistantLight& l : distant)
    l.irradiance = (1.0f - kEqualDistant) * l.irradiance + kEqualDistant * all_distant / float(distant.size());
  // Lights that are too weak for floats cannot be compared with others.
  std::erase_if(entries, [](const LightTree::Entry& e) {
    return !(e.bounds.intensity > 0.0f && std::isfinite(e.bounds.intensity) && is_finite(e.bounds.lower) &&
             is_finite(e.bounds.upper));
  });
  const size_t count = entries.size() + distant.size();
  if (has_media && count > 1 && count <= kMaxLightsForEven) {
    for (const LightTree::Entry& e : entries) even.push_back(e.light);
    for (const DistantLight& l : distant) even.push_back(l.light);
  }
  tree = LightTree(std::move(entries), uint32_t(inside.size()));
  by_power = DiscreteDistribution(watts);
}

LightSet::LightSet() : data_(std::make_unique<Data>()) {}
LightSet::LightSet(LightSet&&) noexcept = default;
LightSet& LightSet::operator=(LightSet&&) noexcept = default;
LightSet::~LightSet() = default;

LightSet::LightSet(const LightBuildInput& in, Diagnostics& diagnostics) : LightSet() {
  Data& d = *data_;
  d.objects = in.objects.data();
  d.meshes = in.meshes.data();
  d.instances = in.instances.data();
  d.lamp_programs = in.lamp_programs.data();
  d.scene_center = in.scene_center;
  d.scene_radius = in.scene_radius;
  for (BuiltInstance& instance : in.instances) instance.first_light = ~0u;
  std::vector<Source> sources;
  d.add_lamps(in, diagnostics, sources);
  std::vector<double> weights(d.lamps.size(), 1.0);
  d.add_triangles(in, diagnostics, sources, weights);
  d.add_environment(in, diagnostics, sources, weights);
  if (sources.empty()) {
    *data_ = Data();
    return;
  }
  d.size = uint32_t(weights.size());
  d.make_tables(sources, weights, in.has_media);
}

// ---- Queries --------------------------------------------------------------------------

size_t LightSet::size() const { return data_->size; }
uint32_t LightSet::lamp_count() const { return uint32_t(data_->lamps.size()); }
int LightSet::environment_index() const { return data_->environment_index; }
const std::vector<uint32_t>& LightSet::distant_disks() const { return data_->distant_disks; }
size_t LightSet::tree_bytes() const { return data_->tree.memory_bytes(); }
size_t LightSet::environment_bytes() const { return data_->environment.table_bytes(); }
double LightSet::total_power() const { return data_->by_power.total(); }

Light LightSet::light(uint32_t index) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) return d.lamps[index];
  Light light;
  light.visibility = flags(index).visibility;
  light.power = float(d.by_power.pmf(index) * d.by_power.total());
  if (d.is_environment(index)) {
    light.type = LightType::Environment;
    return light;
  }
  const TriangleBlock& block = d.block_of(index);
  const BuiltInstance& instance = d.instances[block.instance];
  light.type = LightType::Triangle;
  light.instance = block.instance;
  light.primitive = index - block.first;
  const WorldTriangle triangle = world_triangle(d.meshes[instance.mesh], instance, light.primitive);
  light.position = triangle.p0;
  light.edge1 = triangle.e1;
  light.edge2 = triangle.e2;
  light.frame = Frame(triangle.normal);
  light.area = triangle.area;
  light.radiance = d.emission_of(block, light.primitive).radiance;
  return light;
}

LightFlags LightSet::flags(uint32_t index) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) {
    const Light& lamp = d.lamps[index];
    return {lamp.type, lamp.visibility, lamp.cast_shadow, lamp.mis};
  }
  if (d.is_environment(index)) return {LightType::Environment, d.environment_visibility, true, true};
  return {LightType::Triangle, d.instances[d.block_of(index).instance].visibility, true, true};
}

bool LightSet::any_partial() const { return data_->any_partial; }
bool LightSet::took_environment_over() const { return data_->took_environment_over; }
bool LightSet::can_choose() const { return !data_->tree.empty() || !data_->distant.empty(); }

uint64_t LightSet::fingerprint() const {
  uint64_t hash = hash64(data_->tree.fingerprint() ^ data_->size);
  const auto add = [&](float x) { hash = hash64(hash ^ std::bit_cast<uint32_t>(x)); };
  for (const DistantLight& l : data_->distant) {
    hash = hash64(hash ^ l.light);
    for (const float x : {l.irradiance, l.direction.x, l.direction.y, l.direction.z, l.cos_size}) add(x);
  }
  return hash;
}

LightSet::Choice LightSet::choose(Vec3 p, Vec3 n, float u) const {
  const Data& d = *data_;
  if (d.even.empty()) return d.choose_by_estimate(p, n, u);
  if (u < kEvenShare) {
    const float place = u / kEvenShare * float(d.even.size());
    const size_t i = std::min(size_t(place), d.even.size() - 1);
    return {d.even[i], choice_pmf(p, n, d.even[i]), std::min(place - float(i), kOneMinusEpsilon)};
  }
  Choice choice = d.choose_by_estimate(p, n, std::min((u - kEvenShare) / (1.0f - kEvenShare), kOneMinusEpsilon));
  if (choice.pmf > 0.0f) choice.pmf = kEvenShare / float(d.even.size()) + (1.0f - kEvenShare) * choice.pmf;
  return choice;
}

float LightSet::choice_pmf(Vec3 p, Vec3 n, uint32_t light) const {
  const Data& d = *data_;
  const float pmf = d.pmf_by_estimate(p, n, light);
  if (d.even.empty()) return pmf;
  const bool is_even = std::find(d.even.begin(), d.even.end(), light) != d.even.end();
  return (is_even ? kEvenShare / float(d.even.size()) : 0.0f) + (1.0f - kEvenShare) * pmf;
}

// Ids of branches: nodes of the tree, then one id per distant light, or a single one if there are many.
constexpr uint32_t kDistantBranch = 0x80000000u;
constexpr size_t kMaxDistantBranches = 8;

void LightSet::cut(Vec3 p, float radius, Vec3 n, int max_branches, std::vector<Branch>& branches) const {
  const Data& d = *data_;
  branches.clear();
  const size_t distant = d.distant.size() <= kMaxDistantBranches ? d.distant.size() : 1;
  std::vector<LightTree::CutNode> nodes;
  d.tree.cut(p, radius, n, std::max(1, max_branches - int(distant)), nodes);
  const float sum = d.distant_importance(n), share = d.distant_share(p, n, sum);
  for (const LightTree::CutNode& node : nodes) branches.push_back({node.node, (1.0f - share) * node.share});
  for (size_t i = 0; i < distant; ++i)
    branches.push_back(
        {kDistantBranch | uint32_t(i), distant == d.distant.size() ? share * d.distant[i].importance(n) / sum : share});
}

LightSet::Choice LightSet::choose_in(uint32_t branch, Vec3 p, Vec3 n, float u) const {
  const Data& d = *data_;
  if (branch < kDistantBranch) {
    const LightTree::Choice choice = d.tree.choose_below(branch, p, n, u);
    return {choice.light, choice.pmf, choice.u_remapped};
  }
  return d.distant.size() <= kMaxDistantBranches ? Choice{d.distant[branch - kDistantBranch].light, 1.0f, u}
                                                 : d.choose_distant(n, u);
}

float LightSet::pmf_in(uint32_t branch, Vec3 p, Vec3 n, uint32_t light) const {
  const Data& d = *data_;
  if (branch < kDistantBranch) return d.tree.pmf_below(branch, p, n, light);
  const size_t i = size_t(
      std::find_if(d.distant.begin(), d.distant.end(), [&](const DistantLight& l) { return l.light == light; }) -
      d.distant.begin());
  if (i == d.distant.size()) return 0.0f;
  if (d.distant.size() <= kMaxDistantBranches) return branch - kDistantBranch == i ? 1.0f : 0.0f;
  return d.distant[i].importance(n) / d.distant_importance(n);
}

uint32_t LightSet::place_of(uint32_t light) const {
  const Data& d = *data_;
  if (d.tree.contains(light)) return d.tree.leaf_of(light);
  for (size_t i = 0; i < d.distant.size(); ++i)
    if (d.distant[i].light == light) return kDistantBranch | uint32_t(i);
  return ~0u;
}

LightSet::Choice LightSet::choose_by_power(float u) const {
  const auto choice = data_->by_power.sample(u);
  return {choice.index, choice.pmf, choice.u_remapped};
}
std::vector<LightSet::SourceRange> LightSet::sources() const {
  const Data& d = *data_;
  std::vector<SourceRange> sources;
  for (uint32_t i = 0; i < d.lamps.size(); ++i) {
    if (!d.can_choose(i)) continue;
    const bool distant = is_distant(d.lamps[i].type);
    sources.push_back({i, 1, distant ? d.scene_center : d.lamps[i].position, distant});
  }
  for (const TriangleBlock& block : d.blocks) {
    // A few triangles spread over the mesh approximate its centre.
    Vec3 center(0.0f);
    const uint32_t step = std::max(1u, block.count / 64);
    uint32_t counted = 0;
    for (uint32_t t = 0; t < block.count; t += step, ++counted) {
      const WorldTriangle triangle = world_triangle(d.meshes[d.instances[block.instance].mesh],
                                                    d.instances[block.instance], t);
      center += triangle.p0 + (triangle.e1 + triangle.e2) / 3.0f;
    }
    sources.push_back({block.first, block.count, center / float(counted), false});
  }
  if (d.environment_index >= 0 && d.can_choose(uint32_t(d.environment_index)))
    sources.push_back({uint32_t(d.environment_index), 1, d.scene_center, true});
  return sources;
}

float LightSet::power_pmf(uint32_t light) const { return data_->by_power.pmf(light); }

std::optional<LightSample> LightSet::sample_li(uint32_t index, Vec3 p, Vec2 u, float time, uint32_t ray_kind) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) return d.sample_lamp(d.lamps[index], p, u, time, ray_kind);
  LightSample s;
  s.delta = false;
  if (d.is_environment(index)) {
    s.wi = d.environment.sample(u, s.pdf_solid_angle);
    s.distance = kInfinity;
    s.radiance = d.environment.radiance(s.wi, ray_kind);
    s.position = Vec3(0.0f);
    s.normal = -s.wi;
    return s;
  }
  const TriangleBlock& block = d.block_of(index);
  const uint32_t primitive = index - block.first;
  const BuiltInstance& instance = d.instances[block.instance];
  const BuiltMesh& mesh = d.meshes[instance.mesh];
  const WorldTriangle triangle = world_triangle(mesh, instance, primitive);
  const TriangleSample on_triangle = sample_triangle_li(triangle, p, u);
  if (!(on_triangle.pdf_solid_angle > 0.0f)) return std::nullopt;
  s.wi = on_triangle.wi;
  s.distance = on_triangle.distance;
  s.pdf_solid_angle = on_triangle.pdf_solid_angle;
  s.position = p + s.wi * s.distance;
  s.normal = triangle.normal;
  s.position_error = triangle_position_error(mesh, instance, primitive);
  const SlotEmission& emission = d.emission_of(block, primitive);
  if (emission.constant) {
    s.radiance = emission.radiance;
  } else {
    ShadingPoint point = triangle_point(d.objects[instance.object], mesh, instance, primitive, triangle,
                                        on_triangle.barycentric, -s.wi);
    point.time = time;
    point.ray_kind = ray_kind;
    point.ray_length = s.distance;
    s.radiance = emission.program->evaluate_emission(point);
  }
  return s;
}

float LightSet::pdf_li(uint32_t index, Vec3 p, Vec3 wi, float distance, Vec3 light_normal) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) {
    const Light& lamp = d.lamps[index];
    if (lamp.type == LightType::DistantDisk && !distant_disk_contains(index, wi)) return 0.0f;
    return pdf_lamp_li(lamp, p, wi, distance, light_normal);
  }
  if (d.is_environment(index)) return d.environment.pdf_solid_angle(wi);
  const TriangleBlock& block = d.block_of(index);
  const BuiltInstance& instance = d.instances[block.instance];
  const WorldTriangle triangle = world_triangle(d.meshes[instance.mesh], instance, index - block.first);
  return pdf_triangle_li(triangle, p, wi, distance);
}

Color LightSet::lamp_radiance(uint32_t index, Vec3 position, Vec3 wo, float time, float distance,
                              uint32_t ray_kind) const {
  return data_->lamp_radiance(data_->lamps[index], position, wo, time, distance, ray_kind);
}

Color LightSet::environment_radiance(Vec3 wi, uint32_t ray_kind) const {
  return data_->environment.radiance(wi, ray_kind);
}

bool LightSet::distant_disk_contains(uint32_t index, Vec3 wi) const {
  const Light& sun = data_->lamps[index];
  // Compare tangents: cosines do not resolve half a degree.
  const Vec3 local = sun.frame.to_local(-wi);
  return local.z > 0.0f && local.x * local.x + local.y * local.y <= sqr(sun.radius * local.z);
}

std::optional<LightRay> LightSet::sample_le(uint32_t index, Vec2 u_position, Vec2 u_direction, float time) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) {
    const Light& lamp = d.lamps[index];
    auto r = sample_lamp_le(lamp, u_position, u_direction, d.scene_center, d.scene_radius);
    if (!r) return r;
    r->ray.time = time;
    if (lamp.shader >= 0)
      r->radiance *= d.shader_factor(lamp, r->ray.origin, r->ray.direction, time, kUsualDistance, 0);
    return r;
  }
  LightRay r;
  r.ray.time = time;
  if (d.is_environment(index)) {
    const Vec3 wi = d.environment.sample(u_direction, r.pdf_solid_angle);
    r.radiance = d.environment.radiance(wi, 0);
    r.ray.direction = r.normal = -wi;
    const Vec2 on_disk = d.scene_radius * warp::square_to_disk(u_position);
    const Frame frame(r.ray.direction);
    r.ray.origin = d.scene_center - d.scene_radius * r.ray.direction + on_disk.x * frame.s + on_disk.y * frame.t;
    r.pdf_area = kInvPi / sqr(d.scene_radius);
    return r;
  }
  const TriangleBlock& block = d.block_of(index);
  const uint32_t primitive = index - block.first;
  const BuiltInstance& instance = d.instances[block.instance];
  const BuiltMesh& mesh = d.meshes[instance.mesh];
  const WorldTriangle triangle = world_triangle(mesh, instance, primitive);
  if (!(triangle.area > 0.0f)) return std::nullopt;
  const Vec2 barycentric = warp::square_to_triangle(u_position);
  // Half of the random numbers for each side.
  const bool front = u_direction.x < 0.5f;
  u_direction.x = front ? 2.0f * u_direction.x : 2.0f * u_direction.x - 1.0f;
  const Vec3 side = front ? triangle.normal : -triangle.normal;
  const Vec3 local = warp::square_to_cosine_hemisphere(u_direction);
  r.ray.origin = triangle.p0 + barycentric.x * triangle.e1 + barycentric.y * triangle.e2;
  r.ray.direction = Frame(side).to_world(local);
  r.normal = triangle.normal;
  r.pdf_area = 1.0f / triangle.area;
  r.pdf_solid_angle = 0.5f * warp::cosine_hemisphere_pdf_solid_angle(local.z);
  if (!(r.pdf_solid_angle > 0.0f)) return std::nullopt;
  const SlotEmission& emission = d.emission_of(block, primitive);
  if (!emission.program) return std::nullopt;
  r.radiance = emission.constant ? emission.radiance
                                 : emission.program->evaluate_emission(triangle_point(d.objects[instance.object], mesh,
                                                                                      instance, primitive, triangle,
                                                                                      barycentric, r.ray.direction));
  return r;
}

LightSet::LePdf LightSet::pdf_le(uint32_t index, Vec3, Vec3 normal, Vec3 direction) const {
  const Data& d = *data_;
  LePdf pdf{0.0f, 0.0f};
  if (d.is_lamp(index)) {
    const Light& lamp = d.lamps[index];
    pdf_lamp_le(lamp, normal, direction, d.scene_radius, pdf.pdf_area, pdf.pdf_solid_angle);
    if (lamp.type == LightType::DistantDisk && !distant_disk_contains(index, -direction)) pdf.pdf_solid_angle = 0.0f;
    return pdf;
  }
  if (d.is_environment(index)) return {kInvPi / sqr(d.scene_radius), d.environment.pdf_solid_angle(-direction)};
  const TriangleBlock& block = d.block_of(index);
  const BuiltInstance& instance = d.instances[block.instance];
  const WorldTriangle triangle = world_triangle(d.meshes[instance.mesh], instance, index - block.first);
  if (!(triangle.area > 0.0f)) return pdf;
  return {1.0f / triangle.area, 0.5f * kInvPi * abs_dot(triangle.normal, direction)};
}

}  // namespace ajar
