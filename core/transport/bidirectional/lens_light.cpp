#include "transport/bidirectional/lens_light.h"

#include <algorithm>
#include <bitset>
#include <cmath>

#include <tbb/parallel_for.h>

#include "transport/paths/eye_walk.h"
#include "transport/paths/path_vertex.h"
#include "transport/paths/walk.h"

namespace ajar {

namespace {

constexpr uint32_t kTrialSeed = 0x7472696cu;
constexpr int kBranches = 256;            // at most, into which the light tree is cut
constexpr uint32_t kTries = 64;           // light samples of each branch in the trial
constexpr int kMajority = 2;              // of three probes decides
constexpr int kRoundsOfTrial = 3;         // of probes, none of which may find light
constexpr int kCells = 64;                // of the film, on each axis, in which the trial counts where light falls
constexpr float kLeastRare = 0.25f;       // of the samples of a branch that are seen; else camera rays find it well
constexpr size_t kLeastCells = 6;         // with such light; else it is not worth it
constexpr float kSamplesPerPixel = 4.0f;  // that show such light, for each sample of a pixel
constexpr float kLeastShare = 1.0f / 16.0f;
constexpr float kComparable = 0.5f;  // of the luminance: what a probe must find

}  // namespace

const char* LensLight::reason_against(const Scene& scene) {
  if (!scene.camera().has_lens()) return "the camera has no aperture";
  if (scene.camera().is_orthographic()) return "the camera is orthographic";
  if (!joins_lens(scene)) return "lights cannot be joined to the lens of this camera";
  if (scene.moves() && scene.camera().has_rolling_shutter()) return "the camera has a rolling shutter";
  if (!scene.lights().can_choose()) return "no light can be sampled";
  if (scene.catchers()) return "there are shadow catchers";
  if (scene.settings().clamp_direct > 0.0f) return "direct light is clamped";
  return "";
}

LensLight::LensLight(const Scene& scene)
    : scene_(&scene), filter_(scene.settings().filter, scene.settings().filter_width) {
  const RenderSettings& s = scene.settings();
  pixels_ = float(s.region[2] - s.region[0]) * float(s.region[3] - s.region[1]);
  margin_ = 0.5f * PixelFilter::full_width(s.filter, s.filter_width);
  const Camera& camera = scene.camera();
  std::vector<LightSet::Branch> cut;
  scene.lights().cut(camera.position(), 0.0f, camera.forward(), kBranches, cut);
  std::sort(cut.begin(), cut.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  struct Outcome {
    double light = 0.0;  // luminance of the splats of rare light
    uint64_t rays = 0;
    int found = 0, rare = 0;
    std::bitset<size_t(kCells) * kCells> cells;
  };
  std::vector<Outcome> outcomes(cut.size());
  tbb::parallel_for(size_t(0), cut.size(), [&](size_t i) {
    Outcome& outcome = outcomes[i];
    Sampler sampler(Sampler::Kind::Sobol, hash_combine(kTrialSeed, uint32_t(i)));
    for (uint32_t k = 0; k < kTries; ++k) {
      sampler.start(0, k);
      const auto found = find(cut[i].id, sampler, outcome.rays);
      if (!found) continue;
      ++outcome.found;
      bool rare = true;
      for (int round = 0; round < kRoundsOfTrial && rare; ++round)
        rare = !probes_find(found->film, found->ray.time, found->met.radiance, sampler, outcome.rays);
      const float ratio = density_ratio({cut[i].id}, found->ray, found->met);
      if (!rare || !(ratio > 0.0f)) continue;
      ++outcome.rare;
      outcome.light += double(luminance(glm::abs(found->met.radiance)) / ratio);
      const int x = std::clamp(int(found->film.x / float(s.width) * kCells), 0, kCells - 1),
                y = std::clamp(int(found->film.y / float(s.height) * kCells), 0, kCells - 1);
      outcome.cells.set(size_t(y) * kCells + size_t(x));
    }
  });
  std::bitset<size_t(kCells) * kCells> cells;
  double sum = 0.0;
  for (Outcome& outcome : outcomes) {
    trial_rays_ += outcome.rays;
    if (float(outcome.rare) < kLeastRare * float(outcome.found)) outcome.light = 0.0, outcome.cells.reset();
    cells |= outcome.cells;
    sum += std::sqrt(outcome.light);
  }
  if (cells.count() < kLeastCells || !(sum > 0.0) || !std::isfinite(sum)) return;
  // The root, so that weak lights get samples too.
  float cumulative = 0.0f;
  for (size_t i = 0; i < cut.size(); ++i) {
    const float pmf = float(std::sqrt(outcomes[i].light) / sum);
    ids_.push_back(cut[i].id);
    in_use_.push_back(pmf > 0.0f ? int(branches_.size()) : -1);
    if (pmf > 0.0f) branches_.push_back({cut[i].id, pmf, cumulative += pmf});
  }
  branches_.back().cumulative = 1.0f;
  const float covered = float(cells.count()) / float(kCells * kCells);
  share_ = std::clamp(kSamplesPerPixel * covered, kLeastShare, 1.0f);
}

template <class Visit>
void LensLight::meet_along(const Ray& ray, uint64_t& rays, Visit&& visit) const {
  EyeWalk walk(*scene_, ray, rays);
  walk.trace();
  walk.meet_lamps([&](const LightMet& met) { visit(met, nullptr); });
  if (!walk.found()) {
    walk.meet_distant([&](const LightMet& met) { visit(met, nullptr); });
    return;
  }
  const int light = scene_->light_of(walk.hit);
  if (light < 0 || !walk.arrive()) return;
  walk.shade();
  if (!is_black(walk.shading.emission))
    visit(LightMet{uint32_t(light), walk.shading.emission, walk.point.position, walk.point.ng}, walk.point.object);
}

std::optional<LensLight::Found> LensLight::find(uint32_t branch, Sampler& sampler, uint64_t& rays) const {
  const Scene& scene = *scene_;
  const Camera& camera = scene.camera();
  const float u_light = sampler.get_1d(), time = sample_time(scene, sampler);
  const Vec2 u_position = sampler.get_2d();
  PathVertex lens;
  make_lens_vertex(scene, sampler.get_2d(), time, lens);
  const LightSet::Choice choice = scene.lights().choose_in(branch, lens.position(), camera.forward(), u_light);
  if (!(choice.pmf > 0.0f)) return {};
  const auto light = scene.lights().sample_li(choice.light, lens.position(), u_position, time);
  if (!light || light->delta || !std::isfinite(light->distance)) return {};
  const Vec3 place = lens.position() + light->distance * light->wi;
  const auto film = camera.film_of(lens.point.barycentric, place, time);
  if (!film || !(film->x >= -margin_ && film->y >= -margin_ && film->x <= float(camera.width()) + margin_ &&
                 film->y <= float(camera.height()) + margin_))
    return {};
  Found found{leave_lens(scene, *film, lens), *film, {}, nullptr};
  if (sees_nothing(found.ray)) return {};
  bool meets = false;
  meet_along(found.ray, rays, [&](const LightMet& met, const ObjectDescription* object) {
    if (met.light != choice.light) return;
    meets = true;
    found.met = met;
    found.object = object;
  });
  return meets ? std::optional(found) : std::nullopt;
}

bool LensLight::probes_find(Vec2 film, float time, Color radiance, Sampler& sampler, uint64_t& rays) const {
  const float least = kComparable * luminance(glm::abs(radiance));
  int found = 0, missed = 0;
  while (found < kMajority && missed < kMajority) {
    const Vec2 at = film + filter_.sample(sampler.get_2d());
    const Ray ray = scene_->camera().generate_ray(at, sampler.get_2d(), time);
    bool finds = false;
    if (!sees_nothing(ray))
      meet_along(ray, rays,
                 [&](const LightMet& met, const auto&) { finds |= luminance(glm::abs(met.radiance)) >= least; });
    ++(finds ? found : missed);
  }
  return found >= kMajority;
}

float LensLight::density_ratio(const Branch& branch, const Ray& ray, const LightMet& met) const {
  const LightSet& lights = scene_->lights();
  const Camera& camera = scene_->camera();
  const float distance = glm::dot(met.position - ray.origin, ray.direction);
  if (!(distance > 0.0f) || !std::isfinite(distance)) return 0.0f;
  const float density = branch.pmf * lights.pmf_in(branch.id, ray.origin, camera.forward(), met.light) *
                        lights.pdf_li(met.light, ray.origin, ray.direction, distance, met.normal, ray.time);
  return share_ * pixels_ * density / camera.film_density(ray.direction, ray.time);
}

const LensLight::Branch* LensLight::branch_of(uint32_t light) const {
  const auto above = std::upper_bound(ids_.begin(), ids_.end(), scene_->lights().place_of(light));
  if (above == ids_.begin()) return nullptr;
  const int index = in_use_[size_t(above - ids_.begin()) - 1];
  return index >= 0 ? &branches_[size_t(index)] : nullptr;
}

std::optional<LensLight::Splat> LensLight::sample(Sampler& sampler, uint64_t& rays) const {
  const auto branch = std::upper_bound(branches_.begin(), branches_.end() - 1, sampler.get_1d(),
                                       [](float u, const Branch& b) { return u < b.cumulative; });
  const auto found = find(branch->id, sampler, rays);
  if (!found || probes_find(found->film, found->ray.time, found->met.radiance, sampler, rays)) return {};
  const float ratio = density_ratio(*branch, found->ray, found->met);
  if (!(ratio > 0.0f)) return {};
  return Splat{found->film, found->met.radiance * (weight_of_sample(ratio) / ratio), found->ray, found->met,
               found->object};
}

float LensLight::weight_of_hit(Vec2 film, const Ray& ray, const LightMet& met, Sampler& sampler, uint64_t& rays) const {
  const Branch* branch = branch_of(met.light);
  if (!branch) return 1.0f;
  const float ratio = density_ratio(*branch, ray, met);
  if (!(ratio > 0.0f)) return 1.0f;
  sampler.set_dimension(kProbeDimension);
  if (probes_find(film, ray.time, met.radiance, sampler, rays)) return 1.0f;
  return 1.0f - weight_of_sample(ratio);
}

}  // namespace ajar
