#include "transport/direct/direct_mixture.h"

#include <bit>
#include <cmath>

#include "lights/lamp.h"
#include "math/warps.h"
#include "sampling/mixture.h"
#include "transport/paths/ray_events.h"

namespace ajar {

namespace {

constexpr float kFloor = 0.04f;                    ///< of components that alone may cover part of the integrand
constexpr float kPriorCount = 16.0f;                ///< pseudo-samples of the prior of shares
constexpr float kCellPixels = 16.0f;                ///< edge of a cell as the camera sees it
constexpr uint32_t kCellsLog2 = 16;
constexpr int kMostPilotSamples = 4;               ///< of an estimate while it learns
constexpr int kRisCandidates = 8;
constexpr int kLeastEstimateSamples = 8;           ///< methods that learn within one estimate need as many
constexpr size_t kMostControlledLights = 32;
constexpr int kShownBranches = 16;                 ///< of the light tree, to show its halves where nothing was learned
constexpr float kConeShare = 0.2f;                 ///< thesis, section 5.4.2
constexpr uint32_t kBranchDimension = 4096, kStreamStride = 64;

float luminance_of(Color c) { return std::max(0.0f, luminance(c)); }

/// Lights visible along a ray until something opaque: visit(light, radiance, normal, distance).
template <class Visit>
void for_each_light_along(const Scene& scene, const ShadingPoint& from, Vec3 wi, uint32_t ray_kind, uint64_t& rays, Visit&& visit) {
  Ray ray = scene.spawn_ray(from, wi);
  Color through(1.0f);
  ShadingPoint point;
  for (int crossed = 0;; ++crossed) {
    const Hit hit = scene.intersect(ray, ray_kind);
    ++rays;
    const auto visit_met = [&](const LightMet& met) {
      visit(met.light, through * met.radiance, met.normal, is_finite(met.position) ? glm::length(met.position - from.position) : kInfinity);
    };
    if (scene.has_lamp_shapes()) for_each_lamp_crossed(scene, ray, hit.t, ray_kind, visit_met);
    if (!hit.found()) {
      for_each_distant_light(scene, ray, ray_kind, true, visit_met);
      return;
    }
    const ShaderProgram& program = scene.material(hit);
    const int light = scene.light_of(hit);
    const bool transparent = program.may_be_transparent();
    if (light < 0 && !transparent) return;
    scene.shading_point(ray, hit, point);
    point.ray_kind = ray_kind;
    if (light >= 0)
      visit(uint32_t(light), through * program.evaluate_emission(point), point.ng, glm::length(point.position - from.position));
    if (!transparent || crossed >= scene.settings().bounces.transparent) return;
    through *= program.evaluate_transparency(point);
    if (!(max_component(through) > 0.0f)) return;
    const float left = ray.t_max - hit.t;
    ray = scene.spawn_ray(point, wi);
    ray.t_max = left;
  }
}

}  // namespace

const std::vector<DirectMethodInfo>& direct_method_list() {
  using enum DirectMethod;
  static const std::vector<DirectMethodInfo> list{
      {Mis, "mis", "Multiple Importance", false, "Samples both lights and surfaces. The right choice for nearly every scene."},
      {PmcHi, "pmc_hi", "Adaptive Mixture", false, "Learns, for each region of the scene, which lights and lobes to sample."},
      {OcvProgressive, "ocv_progressive", "Progressive Control Variates", false, "Corrects each estimate by what earlier ones found nearby."},
      {Ocv, "ocv", "Control Variates", false, "Corrects one half of the samples by the other half. Use 16 or more direct samples."},
      {PmcHiPaper, "pmc_hi_paper", "Adaptive Mixture (per estimate)", false, "Learns within each estimate. Use 16 or more direct samples. For comparison."},
      {OcvPaper, "ocv_paper", "Control Variates (as published)", true, "Darkens the picture. For comparison."},
      {Correlated, "correlated", "Single Control Variate", false, "One control variate for all lights. For comparison."},
      {Ris, "ris", "Resampled Importance", false, "Sends shadow rays to the brightest of several candidates. For comparison."},
      {MisBalance, "mis_balance", "Multiple Importance (balance)", false, "Multiple importance sampling with the balance heuristic."},
      {Light, "light", "Lights Only", false, "Samples only lights. For comparison."},
      {Bsdf, "bsdf", "Surfaces Only", false, "Samples only surfaces. For comparison."}};
  return list;
}

const DirectMethodInfo& find_direct_method(const std::string& name) {
  std::string names;
  for (const DirectMethodInfo& info : direct_method_list()) {
    if (info.name == name) return info;
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  throw SceneError("Unknown direct light method '" + name + "'. Valid names: " + names + ".");
}

/// Coefficients per block of pixels, from earlier iterations; the block's thread alone touches them within an iteration.
struct DirectMixture::Regressions {
  static constexpr int kBlock = 8, kSlots = 4;
  struct Slot {
    NormalEquations past;
    ControlCoefficients coefficients;
  };
  int x0 = 0, y0 = 0, columns = 0;         // of the region that is rendered: its tiles are whole blocks
  std::vector<Slot> slots;
  std::vector<Light> lights;               // those of the groups, for intersection
  std::vector<uint32_t> light_indices;
  int groups = 0;                          // of lights that are a component each; one for `correlated`

  Slot& slot(const DirectLightContext& c) {
    const uint32_t block = uint32_t((c.pixel_y - y0) / kBlock) * uint32_t(columns) + uint32_t((c.pixel_x - x0) / kBlock);
    return slots[size_t(block) * kSlots + hash32(c.material) % kSlots];
  }
};

namespace {

/// Whether every light that LightSet would choose belongs to a group.
bool groups_cover(const LightSet& lights, const LightGroups& groups, Vec3 center) {
  for (const LightSet::SourceRange& source : lights.sources()) {
    for (uint32_t light = source.first; light < source.first + source.count; ++light) {
      if (groups.group_of(light) < 0 && lights.choice_pmf(center, Vec3(0.0f), light) > 0.0f) return false;
    }
  }
  return true;
}

/// Ids of branches where the two halves of the light tree begin and where the second ends; empty when it has but one light.
std::vector<uint32_t> halves_of(const LightSet& lights, Vec3 center) {
  std::vector<LightSet::Branch> branches;
  lights.cut(center, 0.0f, Vec3(0.0f), 1, branches);
  // The tree is one branch there, before the distant lights.
  const size_t split = branches.size() + 1;
  lights.cut(center, 0.0f, Vec3(0.0f), int(split), branches);
  if (branches.size() != split) return {};
  return {branches[0].id, branches[1].id, split > 2 ? branches[2].id : ~0u};
}

}  // namespace

// ---- Preparing ---------------------------------------------------------------------------

DirectMixture::DirectMixture(const Scene& scene, DirectMethod method, int samples, int deepest, Lobes lobes)
    : scene_(scene), method_(method), samples_(std::max(1, samples)), deepest_(deepest) {
  using enum DirectMethod;
  lobes_apart_ = lobes == Lobes::Apart && (method == PmcHi || method == PmcHiPaper || method == Ocv || method == OcvPaper || method == OcvProgressive);
  const bool within_estimate = method == PmcHiPaper || method == Ocv || method == OcvPaper || method == Correlated;
  if (within_estimate) samples_ = std::max(samples_, kLeastEstimateSamples);
  const LightSet& lights = scene.lights();
  if (!lights.can_choose() || (method != PmcHi && !within_estimate && method != OcvProgressive)) return;
  if (method == PmcHi) {
    // Among one light there is nothing to choose.
    size_t choices = 0;
    for (const LightSet::SourceRange& source : lights.sources()) {
      choices += source.count;
      if (shown_lights_.size() < 2) shown_lights_.push_back(source.first);
    }
    if (choices < 2 && samples_ == 1) return;
    if (choices > 2) {
      shown_lights_.clear();
      shown_branches_ = halves_of(lights, scene.center());
    }
    const Camera& camera = scene.camera();
    const Vec2 middle(0.5f * float(camera.width()), 0.5f * float(camera.height()));
    const Ray a = camera.generate_ray(middle, Vec2(0.5f), 0.0f), b = camera.generate_ray(middle + Vec2(1, 0), Vec2(0.5f), 0.0f);
    angle_ = kCellPixels * std::max(glm::length(a.direction - b.direction), 1e-5f);
    // A pilot of a few camera rays tells the scale of what will be recorded.
    double sum = 0.0;
    int counted = 0, hits = 0;
    uint64_t rays = 0;
    for (uint32_t i = 0; i < 1024; ++i) {
      Sampler sampler(Sampler::Kind::Sobol, 0x9107u);
      sampler.start(0, i);
      Ray ray = camera.generate_ray(sampler.get_2d() * Vec2(float(camera.width()), float(camera.height())), Vec2(0.5f), 0.0f);
      const Hit hit = scene.intersect(ray, kRayCamera);
      if (!hit.found()) continue;
      reach_ += (hit.t - reach_) / float(++hits);
      ShadingPoint point;
      SurfaceShading shading;
      scene.shading_point(ray, hit, point);
      scene.material(hit).evaluate_surface(point, shading);
      if (!shading.bsdf.has_non_delta()) continue;
      DirectVertex vertex;
      const float y = luminance_of(MisDirectLight().estimate({scene, point, shading.bsdf, 0, 0, 0}, sampler, 6, vertex, nullptr, rays));
      if (!(y > 0.0f) || !std::isfinite(y)) continue;
      sum += double(y);
      ++counted;
    }
    const float scale = counted > 0 ? float(sum / counted) : 1.0f;
    cuts_ = std::make_shared<LightCutCache>(lights, camera.position(), angle_, scale);
    if (samples_ > 1) many_ = ShareCache(kCellsLog2, kFirstGroup, kPriorCount, scale);
    return;
  }
  groups_ = LightGroups(lights, kMostGroups, scene.center());

  if (method == Ocv || method == OcvPaper || method == OcvProgressive || method == Correlated) {
    regressions_ = std::make_unique<Regressions>();
    Regressions& r = *regressions_;
    r.groups = method == Correlated ? 1 : groups_.size();
    size_t total = 0;
    for (int g = 0; g < groups_.size(); ++g) total += groups_.lights(g).size();
    controls_possible_ = total > 0 && total <= kMostControlledLights && groups_cover(lights, groups_, scene.center());
    if (controls_possible_) {
      for (int g = 0; g < groups_.size(); ++g) {
        for (uint32_t light : groups_.lights(g)) {
          r.light_indices.push_back(light);
          r.lights.push_back(lights.light(light));
        }
      }
    }
    if (method == OcvProgressive) {
      r.x0 = scene.settings().region[0];
      r.y0 = scene.settings().region[1];
      r.columns = (scene.settings().width + Regressions::kBlock - 1) / Regressions::kBlock;
      const int rows = (scene.settings().height + Regressions::kBlock - 1) / Regressions::kBlock;
      r.slots.resize(size_t(r.columns) * size_t(rows) * Regressions::kSlots, {NormalEquations(kMostLobes + r.groups), {}});
    }
  }
}

DirectMixture::~DirectMixture() = default;

std::shared_ptr<const DirectMixture::Past> DirectMixture::past() const {
  if (!cuts_ || cuts_->learning()) return nullptr;
  return std::make_shared<const Past>(Past{cuts_, many_.copied(0), scene_.lights().fingerprint()});
}

std::string DirectMixture::begin_with(const Past& past) {
  if (!cuts_) return "there are no lights to choose among";
  if (past.lights != scene_.lights().fingerprint()) return "the lights have changed";
  if (past.many.components() != many_.components()) return "direct light takes another number of samples";
  if (!past.cuts->suits(scene_.camera().position(), angle_, reach_)) return "the camera has moved far since it was begun";
  cuts_ = std::make_shared<LightCutCache>(*past.cuts, scene_.lights());
  many_ = past.many.copied(1);
  return {};
}

void DirectMixture::learn() {
  if (cuts_) cuts_->publish();
  if (many_.components() > 0) many_.publish();
  if (regressions_) {   // none where there is no light to choose
    for (Regressions::Slot& slot : regressions_->slots) slot.coefficients = slot.past.fit(kRidgeMany, 4 * (1 + regressions_->groups));
  }
}

DirectMixture::Kernel DirectMixture::fixed_kernel(const LobeComponents& lobes) const {
  using enum DirectMethod;
  Kernel k{lobes};
  k.count = kFirstGroup + groups_.size();
  k.alpha.fill(0.0f);
  const float bsdf = method_ == Light ? 0.0f : (method_ == Bsdf ? 1.0f : 0.5f), lights = 1.0f - bsdf;
  for (int i = 0; i < lobes.count(); ++i) k.alpha[size_t(i)] = bsdf * lobes.prior(i);
  const bool by_group = groups_.size() > 0 && method_ != Correlated && (method_ == PmcHiPaper || controls_possible_);
  if (!by_group && !(method_ == Correlated && controls_possible_)) {
    k.alpha[kAny] = lights;
  } else if (method_ == Correlated) {
    for (int g = 0; g < groups_.size(); ++g) k.alpha[size_t(kFirstGroup + g)] = lights * groups_.prior(g);
  } else {
    for (int g = 0; g < groups_.size(); ++g) k.alpha[size_t(kFirstGroup + g)] = lights / float(groups_.size());
  }
  return k;
}

/// Floors of the lobes sum to what one BSDF would have: dividing it among them leaves no part of it less covered than by half.
DirectMixture::Kernel DirectMixture::learned_kernel(const LobeComponents& lobes, uint32_t cell) const {
  Kernel k{lobes};
  k.count = kFirstGroup;
  std::array<float, kFirstGroup> prior{}, floors{};
  for (int i = 0; i < lobes.count(); ++i) {
    prior[size_t(i)] = 0.5f * lobes.prior(i);
    floors[size_t(i)] = kFloor * lobes.prior(i);
  }
  prior[kAny] = 0.5f;
  floors[kAny] = kFloor;
  many_.shares(cell, prior, floors, {k.alpha.data(), kFirstGroup});
  return k;
}

/// Places are jittered by half a cell, which blends neighbours: the same way for all samples of a pixel at what the camera sees, for
/// samples that choose by different shares are no longer stratified together, and that can cost more than learning gains.
uint64_t DirectMixture::cell_key(const DirectLightContext& c) const {
  const Vec3 p = c.point.position;
  const uint32_t jitter = c.point.ray_depth == 0
                              ? hash_combine(uint32_t(c.pixel_x), uint32_t(c.pixel_y))
                              : hash32(std::bit_cast<uint32_t>(p.x) ^ hash32(std::bit_cast<uint32_t>(p.y) ^ hash32(std::bit_cast<uint32_t>(p.z))));
  return cuts_->key(p, c.bsdf.receiving_normal(), c.material, jitter);
}

// ---- Samples of the mixture ----------------------------------------------------------------

DirectMixture::Densities DirectMixture::densities(const DirectLightContext& c, const Kernel& k, uint32_t light, Vec3 wi,
                                                  const std::array<float, kMostLobes>& pdf_lobes, float pdf_light, bool mis, float known_pmf) const {
  Densities d{{}, 0.0f, 0.0f, 0.0f, 0.0f, -1};
  if (mis) {
    for (int i = 0; i < k.lobes.count(); ++i) d.bsdf += d.lobes[size_t(i)] = k.alpha[size_t(i)] * pdf_lobes[size_t(i)];
    if (k.alpha[kCone] > 0.0f && 1.0f - glm::dot(k.cone.n, wi) <= k.one_minus_cos) d.cone = k.alpha[kCone] * warp::cone_pdf_solid_angle(k.one_minus_cos);
  }
  if (k.alpha[kAny] > 0.0f)
    d.any = k.alpha[kAny] * (known_pmf >= 0.0f ? known_pmf : choice_pmf(k.cell, c.point.position, c.bsdf.receiving_normal(), light)) * pdf_light;
  d.group_index = groups_.size() > 0 ? groups_.group_of(light) : -1;
  if (d.group_index >= 0) d.group = k.alpha[size_t(kFirstGroup + d.group_index)] * groups_.pmf_in_group(light) * pdf_light;
  return d;
}

/// Add light f found at a point of densities d. By the power heuristic BSDF and lights are told apart.
void DirectMixture::add_found(const Densities& d, Color f, bool power, bool from_bsdf, Draw& out) const {
  const float total = d.total();
  if (!(total > 0.0f)) return;
  if (power) {
    // w / a with w = a^2 / (a^2 + b^2), of the technique that drew it.
    const float lights = d.any + d.group, a = from_bsdf ? d.bsdf : lights, b = from_bsdf ? lights : d.bsdf;
    out.y += f * (power_heuristic(a, b) / a);
    return;
  }
  const Color y = f / total;
  out.y += y;
  const float luminous = luminance_of(y) / total;
  for (int i = 0; i < kMostLobes; ++i) out.responsible[size_t(i)] += luminous * d.lobes[size_t(i)];
  out.responsible[kCone] += luminous * d.cone;
  out.responsible[kAny] += luminous * d.any;
  if (d.group_index >= 0) out.responsible[size_t(kFirstGroup + d.group_index)] += luminous * d.group;
}

void DirectMixture::draw_light(const DirectLightContext& c, const Kernel& k, int component, float u_choice, Vec2 u, bool power, Draw& out,
                               uint64_t& rays) const {
  const LightSet& lights = scene_.lights();
  uint32_t index;
  float known_pmf = -1.0f;
  if (component == kAny) {
    out.choice = choose_light(k.cell, c, u_choice);
    const LightSet::Choice& choice = out.choice.choice;
    if (!(choice.pmf > 0.0f)) return;
    index = choice.light;
    known_pmf = choice.pmf;
    if (lights.size() < kFewLights) u.x = choice.u_remapped;
  } else {
    index = groups_.choose(component - kFirstGroup, u_choice);
  }
  const auto sample = lights.sample_li(index, c.point.position, u, c.point.time);
  if (!sample) return;
  const LightFlags light = lights.flags(index);
  const bool mis = !sample->delta && light.mis;
  if (mis) out.wi = sample->wi;
  const LobeComponents::Evaluation scattered = k.lobes.evaluate(c.point.wo, sample->wi);
  out.pdf_lobes = scattered.pdf;
  Color f = scattered.f_cos * sample->radiance;
  if (is_black(f)) return;
  if (light.cast_shadow) {
    ++rays;
    f *= scene_.transmittance(scene_.spawn_segment(c.point, *sample), scene_.settings().bounces.transparent);
    if (is_black(f)) return;
  }
  add_found(densities(c, k, index, sample->wi, scattered.pdf, sample->pdf_solid_angle, mis, known_pmf), f, power, false, out);
}

void DirectMixture::draw_direction(const DirectLightContext& c, const Kernel& k, int component, float u_choice, Vec2 u, bool power, Draw& out,
                                   uint64_t& rays) const {
  Vec3 wi;
  Color f_cos;
  uint32_t kind;
  if (component < kMostLobes) {
    const auto sample = k.lobes.sample(component, c.point.wo, u_choice, u);
    // Mirrors and transparency are left to the path.
    if (!sample) return;
    wi = sample->wi;
    f_cos = sample->value.f_cos;
    out.pdf_lobes = sample->value.pdf;
    kind = ray_kind_after(sample->flags);
  } else {
    wi = k.cone.to_world(warp::square_to_cone(u, k.one_minus_cos));
    const LobeComponents::Evaluation scattered = k.lobes.evaluate(c.point.wo, wi);
    f_cos = scattered.f_cos;
    out.pdf_lobes = scattered.pdf;
    kind = kRayReflection | kRayDiffuse;
  }
  out.wi = wi;
  if (is_black(f_cos)) return;
  const LightSet& lights = scene_.lights();
  for_each_light_along(scene_, c.point, wi, kind, rays, [&](uint32_t light, Color radiance, Vec3 normal, float distance) {
    if (is_black(radiance)) return;
    const float pdf_light = lights.pdf_li(light, c.point.position, wi, distance, normal);
    add_found(densities(c, k, light, wi, out.pdf_lobes, pdf_light, true), f_cos * radiance, power, true, out);
  });
}

/// n samples with deterministic shares: visit(component, draw).
template <class Visit>
void DirectMixture::for_each_draw(const DirectLightContext& c, const Kernel& k, int n, int stream, Sampler& sampler, bool power, uint64_t& rays,
                                  Visit&& visit) const {
  int counts[kMostComponents];
  const uint32_t base = kBranchDimension + kStreamStride * uint32_t(stream);
  sampler.set_dimension(base);
  deterministic_counts({k.alpha.data(), size_t(k.count)}, n, sampler.get_1d(), {counts, size_t(k.count)});
  Draw out;
  const bool few = scene_.lights().size() < kFewLights;
  for (int component = 0; component < k.count; ++component) {
    sampler.set_dimension(base + 1 + uint32_t(component));
    // Successive estimates of a pixel continue each component's own sequence.
    const uint32_t block = uint32_t(std::ceil(float(n) * k.alpha[size_t(component)] - 1e-4f));
    for (int i = 0; i < counts[component]; ++i) {
      Sampler numbers = sampler.branch(uint32_t(i), block);
      const Vec2 u = numbers.get_2d();
      const float u_choice = few && component == kAny ? u.x : numbers.get_1d();
      out.y = Color(0.0f);
      out.wi = Vec3(0.0f);
      out.pdf_lobes.fill(0.0f);
      out.choice.share = 0.0f;
      std::fill_n(out.responsible.begin(), k.count, 0.0f);
      if (component <= kCone) {
        draw_direction(c, k, component, u_choice, u, power, out, rays);
      } else {
        draw_light(c, k, component, u_choice, u, power, out, rays);
      }
      visit(component, out);
    }
  }
}

// ---- Estimates -------------------------------------------------------------------------------

Color DirectMixture::estimate(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, SampleAux* aux, uint64_t& rays) const {
  if (samples_ > 1 && c.point.ray_depth <= deepest_) return many_samples(c, sampler, vertex, aux, rays);
  if (method_ == DirectMethod::Ris) return one_sample_ris(c, sampler, first, rays);
  const Color estimate = one_sample(c, sampler, first, vertex, rays);
  if (cuts_) record_light_shares(c, vertex.cell, 1.0f, aux);
  return estimate;
}

LightCutCache::Choice DirectMixture::choose_light(uint32_t cell, const DirectLightContext& c, float u) const {
  const Vec3 p = c.point.position, n = c.bsdf.receiving_normal();
  return cell == LightCutCache::kNone ? LightCutCache::Choice{scene_.lights().choose(p, n, u), 0, 0.0f} : cuts_->choose(cell, p, n, u);
}

Color DirectMixture::one_sample(const DirectLightContext& c, Sampler& sampler, uint32_t first, DirectVertex& vertex, uint64_t& rays) const {
  using enum DirectMethod;
  const LightSet& lights = scene_.lights();
  sampler.set_dimension(first + 1);
  const Vec2 u = sampler.get_2d();
  float u_choice = u.x;
  const bool few = lights.size() < kFewLights;
  if (!few) {
    sampler.set_dimension(first);
    u_choice = sampler.get_1d();
  }
  if (cuts_) vertex.cell = cuts_->cell(cell_key(c));
  const LightCutCache::Choice learned = choose_light(vertex.cell, c, u_choice);
  const LightSet::Choice& chosen = learned.choice;
  if (!(chosen.pmf > 0.0f)) return Color(0.0f);

  const LightFlags light = lights.flags(chosen.light);
  if (method_ == Bsdf && light.mis && !is_delta(light.type)) return Color(0.0f);
  Color contribution(0.0f);
  const auto sample = lights.sample_li(chosen.light, c.point.position, few ? Vec2(chosen.u_remapped, u.y) : u, c.point.time);
  if (sample && !is_black(sample->radiance)) contribution = weigh_sample(c, chosen, light, *sample, rays);
  if (cuts_) cuts_->record(vertex.cell, learned, luminance_of(contribution));
  return contribution;
}

/// The light's part of multiple importance sampling.
Color DirectMixture::weigh_sample(const DirectLightContext& c, const LightSet::Choice& chosen, LightFlags light, const LightSample& sample, uint64_t& rays) const {
  using enum DirectMethod;
  const Bsdf::Evaluation scattered = c.evaluate(sample.wi);
  if (is_black(scattered.f_cos)) return Color(0.0f);
  const float pdf = chosen.pmf * sample.pdf_solid_angle;
  float weight = 1.0f / pdf;
  if (!sample.delta && light.mis && method_ != Light)
    weight *= method_ == MisBalance ? pdf / (pdf + scattered.pdf_solid_angle) : power_heuristic(pdf, scattered.pdf_solid_angle);
  Color contribution = scattered.f_cos * sample.radiance * weight;
  if (light.cast_shadow) {
    ++rays;
    contribution *= scene_.transmittance(scene_.spawn_segment(c.point, sample), scene_.settings().bounces.transparent);
  }
  return contribution;
}

/// Of a light with the shares of a cell.
float DirectMixture::choice_pmf(uint32_t cell, Vec3 position, Vec3 normal, uint32_t light) const {
  return cell == LightCutCache::kNone ? scene_.lights().choice_pmf(position, normal, light) : cuts_->pmf(cell, position, normal, light);
}

float DirectMixture::weight_of_hit(const Scene& scene, const DirectVertex& v, uint32_t light, Vec3 wi, Vec3 position, Vec3 normal) const {
  using enum DirectMethod;
  if (v.bsdf_pdf == 0.0f) return 1.0f;
  if (v.complete) return 0.0f;
  if (method_ == Bsdf) return 1.0f;
  const LightSet& lights = scene.lights();
  const float distance = is_finite(position) ? glm::length(position - v.position) : kInfinity;
  const float light_pdf = choice_pmf(v.cell, v.position, v.normal, light) * lights.pdf_li(light, v.position, wi, distance, normal);
  if (method_ == Light) return light_pdf > 0.0f ? 0.0f : 1.0f;
  return method_ == MisBalance ? v.bsdf_pdf / (v.bsdf_pdf + light_pdf) : power_heuristic(v.bsdf_pdf, light_pdf);
}

/// Resampled importance sampling of the light's part of multiple importance sampling [Talbot et al. 2005]: the target is
/// that part without visibility, and the shadow ray goes to the one candidate that is kept.
Color DirectMixture::one_sample_ris(const DirectLightContext& c, Sampler& sampler, uint32_t first, uint64_t& rays) const {
  const LightSet& lights = scene_.lights();
  sampler.set_dimension(first);
  float u_keep = sampler.get_1d();
  sampler.set_dimension(first + 1);
  float sum = 0.0f, kept_target = 0.0f;
  Color kept(0.0f);
  LightSample kept_sample{};
  bool kept_shadow = true;
  for (int i = 0; i < kRisCandidates; ++i) {
    Sampler numbers = sampler.branch(uint32_t(i), kRisCandidates);
    const auto choice = lights.choose(c.point.position, c.bsdf.receiving_normal(), numbers.get_1d());
    if (!(choice.pmf > 0.0f)) continue;
    const auto sample = lights.sample_li(choice.light, c.point.position, numbers.get_2d(), c.point.time);
    if (!sample || is_black(sample->radiance)) continue;
    const Bsdf::Evaluation scattered = c.evaluate(sample->wi);
    const LightFlags light = lights.flags(choice.light);
    const float pdf = choice.pmf * sample->pdf_solid_angle;
    float weight = 1.0f / pdf;
    if (!sample->delta && light.mis) weight *= power_heuristic(pdf, scattered.pdf_solid_angle);
    const Color value = scattered.f_cos * sample->radiance * weight;
    const float target = luminance_of(value);
    if (!(target > 0.0f)) continue;
    sum += target;
    // Keep this one with probability target / sum; one random number serves all, rescaled each time.
    const float keep = target / sum;
    if (u_keep < keep) {
      u_keep /= keep;
      kept = value;
      kept_target = target;
      kept_sample = *sample;
      kept_shadow = light.cast_shadow;
    } else {
      u_keep = (u_keep - keep) / (1.0f - keep);
    }
    u_keep = std::min(u_keep, kOneMinusEpsilon);
  }
  if (!(sum > 0.0f)) return Color(0.0f);
  Color estimate = kept * (sum / (kept_target * float(kRisCandidates)));
  if (kept_shadow) {
    ++rays;
    estimate *= scene_.transmittance(scene_.spawn_segment(c.point, kept_sample), scene_.settings().bounces.transparent);
  }
  return estimate;
}

Color DirectMixture::many_samples(const DirectLightContext& c, Sampler& sampler, DirectVertex& vertex, SampleAux* aux, uint64_t& rays) const {
  using enum DirectMethod;
  if (method_ == Ris) {
    Color sum(0.0f);
    sampler.set_dimension(kBranchDimension);
    for (int i = 0; i < samples_; ++i) {
      Sampler numbers = sampler.branch(uint32_t(i), std::bit_ceil(uint32_t(samples_)));
      sum += one_sample_ris(c, numbers, 0, rays);
    }
    return sum / float(samples_);
  }
  // Lights alone leave to the path what LightSet leaves to the BSDF.
  vertex.complete = method_ != Light;
  const LobeComponents lobes(c.bsdf, c.point.wo, lobes_apart_);
  if (method_ == PmcHiPaper) return adapt_here(c, lobes, sampler, aux, rays);
  if (regressions_) return control_variates(c, lobes, sampler, aux, rays);

  const bool learned = many_.components() > 0;
  const uint64_t key = learned ? cell_key(c) : 0;
  const uint32_t cell = many_.cell(hash64(key + lobes.signature()));
  Kernel k = learned ? learned_kernel(lobes, cell) : fixed_kernel(lobes);
  if (cuts_) vertex.cell = k.cell = cuts_->cell(key);
  const bool learning = wants_pilot();
  const int n = learning ? std::min(samples_, kMostPilotSamples) : samples_;
  Color sum(0.0f);
  for_each_draw(c, k, n, 0, sampler, method_ == Mis, rays, [&](int component, const Draw& draw) {
    sum += draw.y;
    if (!learning) return;
    const float y = luminance_of(draw.y);
    if (component == kAny && draw.choice.share > 0.0f) cuts_->record(k.cell, draw.choice, y);
    many_.count(cell);
    many_.add_square(cell, y * y);
    for (int i = 0; y > 0.0f && i < k.count; ++i) many_.add_moment(cell, i, k.alpha[size_t(i)] * draw.responsible[size_t(i)] * y);
  });
  if (learned) {
    record_shares(k, aux);
    record_light_shares(c, k.cell, k.alpha[kAny], aux);
  }
  Color estimate = sum / float(n);
  if (method_ == Bsdf) estimate += unreachable_lights(c, sampler, rays);
  return estimate;
}

/// Lights that BSDF sampling cannot find, by one sample.
Color DirectMixture::unreachable_lights(const DirectLightContext& c, Sampler& sampler, uint64_t& rays) const {
  DirectVertex unused;
  return one_sample(c, sampler, kBranchDimension, unused, rays);
}

/// PMC-HI as in the thesis, section 5.4, with floors, shrinkage and all components' densities used at every sample.
Color DirectMixture::adapt_here(const DirectLightContext& c, const LobeComponents& lobes, Sampler& sampler, SampleAux* aux, uint64_t& rays) const {
  Kernel k = fixed_kernel(lobes);
  // Any light is a component where lights have no groups.
  const auto used = [&](int i) { return i < lobes.count() || (groups_.size() > 0 ? i >= kFirstGroup : i == kAny); };
  const int m = lobes.count() + std::max(1, groups_.size());
  for (int i = 0; i < k.count; ++i) k.alpha[size_t(i)] = used(i) ? 1.0f / float(m) : 0.0f;
  const int iterations = std::clamp(samples_ / (2 * m), 2, 4);
  Color sum(0.0f);
  int done = 0;
  struct Past {
    Vec3 wi;
    float w;
  };
  std::vector<Past> past;
  past.reserve(size_t(samples_));
  std::array<double, kMostComponents> sums{};
  for (int t = 0; t < iterations; ++t) {
    const int n = (samples_ * (t + 1)) / iterations - done;
    for_each_draw(c, k, n, t, sampler, false, rays, [&](int, const Draw& draw) {
      sum += draw.y;
      const float w = luminance_of(draw.y);
      if (w > 0.0f && draw.wi != Vec3(0.0f)) past.push_back({draw.wi, w});
      for (int i = 0; i < k.count; ++i) sums[size_t(i)] += double(draw.responsible[size_t(i)]);
    });
    done += n;
    if (t + 1 == iterations) break;

    // The cone: weighted mean direction and weighted angular deviation from it.
    Vec3 axis(0.0f);
    float total = 0.0f, spread = 0.0f;
    for (const Past& p : past) axis += p.w * p.wi, total += p.w;
    const float length = glm::length(axis);
    const bool cone = past.size() >= 2 && length > 1e-6f * total;
    if (cone) {
      axis /= length;
      for (const Past& p : past) spread += p.w * sqr(std::acos(glm::clamp(glm::dot(axis, p.wi), -1.0f, 1.0f)));
      k.cone = Frame(axis);
      k.one_minus_cos = warp::one_minus_cos(glm::clamp(std::sqrt(spread / total), 0.02f, 0.5f * kPi));
    }
    // Shares of the others after their weights, drawn towards equal ones; the cone appears with a fifth.
    double others = 0.0;
    for (int i = 0; i < k.count; ++i) others += i == kCone ? 0.0 : sums[size_t(i)];
    const float kept = others > 0.0 ? float(done) / (float(done) + float(m)) : 0.0f;
    const double with_cone = sums[kCone] + others;
    float cone_share = !cone ? 0.0f : (sums[kCone] > 0.0 ? std::max(kFloor, float(sums[kCone] / with_cone)) : kConeShare);
    cone_share = std::min(cone_share, 0.5f);
    float sum_alpha = 0.0f;
    for (int i = 0; i < k.count; ++i) {
      float& alpha = k.alpha[size_t(i)];
      alpha = used(i) ? kFloor + (others > 0.0 ? kept * float(sums[size_t(i)] / others) : 0.0f) + (1.0f - kept) / float(m) : 0.0f;
      sum_alpha += alpha;
    }
    for (int i = 0; i < k.count; ++i) k.alpha[size_t(i)] *= (1.0f - cone_share) / sum_alpha;
    k.alpha[kCone] = cone_share;
  }
  record_shares(k, aux);
  return sum / float(samples_);
}

// ---- Control variates ---------------------------------------------------------------------------

/// Ratios of densities over directions (the sum of all lights crossed, hidden or not: their integrals are 1). Samples
/// that are no direction, and those of delta lights, are atoms of their own component. Columns: lobes, those that the surface does not have
/// with the ratio 1, which corrects nothing; then lights.
void DirectMixture::control_sample(const DirectLightContext& c, const Kernel& k, int component, const Draw& draw, ControlSample& sample) const {
  const Regressions& r = *regressions_;
  const bool lump = method_ == DirectMethod::Correlated;
  const int lobes = k.lobes.count(), columns = lobe_columns(k);
  std::fill_n(sample.z, kMaxControls, 0.0f);
  std::fill(sample.z + lobes, sample.z + columns, 1.0f);
  sample.y = draw.y;
  if (draw.wi == Vec3(0.0f)) {
    const bool lobe = component < kMostLobes;
    sample.z[lobe ? component : columns + (lump ? 0 : component - kFirstGroup)] = 1.0f / (lump && !lobe ? 1.0f - k.bsdf_share() : k.alpha[size_t(component)]);
    return;
  }
  const LightSet& lights = scene_.lights();
  float mixture = 0.0f;
  for (int i = 0; i < lobes; ++i) {
    sample.z[i] = draw.pdf_lobes[size_t(i)];
    mixture += k.alpha[size_t(i)] * draw.pdf_lobes[size_t(i)];
  }
  Ray ray;
  ray.origin = c.point.position;
  ray.direction = draw.wi;
  for (size_t i = 0; i < r.lights.size(); ++i) {
    const Light& light = r.lights[i];
    if (is_delta(light.type) || !light.mis) continue;
    float distance = kInfinity;
    Vec3 normal = -draw.wi;
    if (light.type == LightType::Triangle) {
      // Möller and Trumbore 1997.
      const Vec3 p = glm::cross(draw.wi, light.edge2);
      const float determinant = glm::dot(light.edge1, p);
      if (determinant == 0.0f) continue;
      const Vec3 s = ray.origin - light.position, q = glm::cross(s, light.edge1);
      const float b1 = glm::dot(s, p) / determinant, b2 = glm::dot(draw.wi, q) / determinant;
      distance = glm::dot(light.edge2, q) / determinant;
      if (b1 < 0.0f || b2 < 0.0f || b1 + b2 > 1.0f || !(distance > 0.0f)) continue;
      normal = glm::normalize(glm::cross(light.edge1, light.edge2));
    } else if (!is_distant(light.type)) {
      const auto crossing = intersect_lamp_shape(light, ray);
      if (!crossing) continue;
      const bool flat = light.type == LightType::Rectangle || light.type == LightType::Ellipse;
      if (flat && !(glm::dot(crossing->normal, draw.wi) < 0.0f)) continue;
      distance = crossing->t;
      normal = crossing->normal;
    }
    const int g = groups_.group_of(r.light_indices[i]);
    const float pdf = groups_.pmf_in_group(r.light_indices[i]) * lights.pdf_li(r.light_indices[i], c.point.position, draw.wi, distance, normal);
    if (!(pdf > 0.0f)) continue;
    const float alpha = k.alpha[size_t(kFirstGroup + g)];
    mixture += alpha * pdf;
    // The lump of all lights is a mixture of the groups by their shares.
    sample.z[lump ? columns : columns + g] += lump ? pdf * alpha / (1.0f - k.bsdf_share()) : pdf;
  }
  if (!(mixture > 0.0f)) return;
  for (int j = 0; j < columns + r.groups; ++j)
    if (j < lobes || j >= columns) sample.z[j] /= mixture;
}

/// Coefficients that outlive an estimate are for any surface, so each has all columns.
int DirectMixture::lobe_columns(const Kernel& k) const { return method_ == DirectMethod::OcvProgressive ? kMostLobes : k.lobes.count(); }

Color DirectMixture::control_variates(const DirectLightContext& c, const LobeComponents& lobes, Sampler& sampler, SampleAux* aux, uint64_t& rays) const {
  using enum DirectMethod;
  const Kernel k = fixed_kernel(lobes);
  record_shares(k, aux);
  Regressions& r = *regressions_;
  constexpr int kMostSamples = 256;
  static thread_local std::vector<ControlSample> samples;
  const int n = std::min(samples_, kMostSamples);
  samples.resize(size_t(n));
  // Two folds, each with the same shares.
  const int folds = method_ == Ocv || method_ == Correlated ? 2 : 1;
  int filled = 0, first_fold = 0;
  for (int fold = 0; fold < folds; ++fold) {
    const int count = fold == 0 ? n / folds : n - n / folds;
    for_each_draw(c, k, count, fold, sampler, false, rays, [&](int component, const Draw& draw) {
      ControlSample& sample = samples[size_t(filled++)];
      if (controls_possible_) control_sample(c, k, component, draw, sample);
      else sample.y = draw.y;
    });
    if (fold == 0) first_fold = filled;
  }
  const std::span<const ControlSample> all(samples.data(), size_t(filled));
  if (!controls_possible_) return control_estimate(all, {});
  const int components = lobe_columns(k) + r.groups;
  if (method_ == OcvPaper) return ocv_paper(all, components);
  if (method_ == OcvProgressive) {
    Regressions::Slot& slot = r.slot(c);
    const Color estimate = control_estimate(all, slot.coefficients);
    for (const ControlSample& sample : all) slot.past.add(sample);
    return estimate;
  }
  return ocv_cross_fitted(all.subspan(0, size_t(first_fold)), all.subspan(size_t(first_fold)), components);
}

/// `share` as it is split between the two lights, or the two halves of the light tree.
void DirectMixture::record_light_shares(const DirectLightContext& c, uint32_t cell, float share, SampleAux* aux) const {
  if (!aux) return;
  const Vec3 p = c.point.position, n = c.bsdf.receiving_normal();
  for (size_t i = 0; i < shown_lights_.size(); ++i) aux->shares[1 + i] = share * choice_pmf(cell, p, n, shown_lights_[i]);
  if (shown_branches_.empty()) return;
  if (cell != LightCutCache::kNone) {
    for (size_t i = 0; i < 2; ++i) aux->shares[1 + i] = share * cuts_->share_between(cell, shown_branches_[i], shown_branches_[i + 1]);
    return;
  }
  std::vector<LightSet::Branch> branches;
  scene_.lights().cut(p, 0.0f, n, kShownBranches, branches);
  for (const LightSet::Branch& branch : branches) {
    for (size_t i = 0; i < 2; ++i)
      if (branch.id >= shown_branches_[i] && branch.id < shown_branches_[i + 1]) aux->shares[1 + i] += share * branch.share;
  }
}

void DirectMixture::record_shares(const Kernel& k, SampleAux* aux) const {
  if (!aux) return;
  aux->shares[0] = k.bsdf_share();
  for (int i = 0; i < k.lobes.count(); ++i) aux->shares[size_t(4 + i)] = k.alpha[size_t(i)];
  for (int g = 0; g < std::min(2, groups_.size()); ++g) aux->shares[size_t(1 + g)] = k.alpha[size_t(kFirstGroup + g)];
  aux->shares[3] = k.alpha[kCone];
}

}  // namespace ajar
