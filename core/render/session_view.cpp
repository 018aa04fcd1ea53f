// The part of a session's thread that makes the pictures of a 3D view (view/view_pictures.h).
#include <algorithm>

#include "choice/technique_choice.h"
#include "render/session_worker.h"
#include "view/surface_detail.h"
#include "view/surface_guides.h"

namespace ajar {

namespace {

/// In a view with `auto`, how long and with how many samples per pixel path tracing renders before the pilot.
constexpr double kStillSeconds = 1.5;
constexpr uint64_t kStillSamples = 4;
/// Until the new technique has rendered for this share of the time of path tracing, its picture can be the worse one.
constexpr double kHeldShare = 0.5;

constexpr const char* kGuides[] = {"Denoising Albedo", "Denoising Normal"};

double area_of(const std::array<int, 4>& region) {
  return double(region[2] - region[0]) * double(region[3] - region[1]);
}

RenderSettings at_level(const RenderSettings& full, ViewLevel level) {
  RenderSettings settings = full;
  if (level.divider == 1) return settings;
  const ViewSize size = divided(full.width, full.height, full.region, level.divider);
  settings.width = size.width;
  settings.height = size.height;
  settings.region = size.region;
  settings.samples = 1;
  return settings;
}

}  // namespace

/// Renders coarse images of one sample, then the one of the settings. With `auto`, these are path traced, and when the
/// view has been still for a while, the technique that a pilot chooses renders a new image.
void SessionWorker::render_view(const CameraDescription& camera, Clock::time_point start) {
  view_camera_ = camera;
  view_settings_ = state_.lock()->scene->settings();
  auto& passes = view_settings_.passes;
  const bool guided = !OpenImageDenoise::version().empty();
  for (const char* guide : kGuides)
    if (guided && std::find(passes.begin(), passes.end(), guide) == passes.end()) passes.emplace_back(guide);
  const double pixels = area_of(view_settings_.region);
  for (level_ = schedule_.first(pixels);; level_ = schedule_.finer(level_, pixels, guided)) {
    begin_view(at_level(view_settings_, level_));
    prepare(make_integrator(view_settings_.integrator), start);
    awaits_choice_ = level_.divider == 1 && find_integrator(view_settings_.integrator).automatic;
    render_all();
    if (level_.divider == 1 || stop_.load()) return;
    start = Clock::now();
  }
}

/// Starts an image of the view with these settings.
void SessionWorker::begin_view(const RenderSettings& settings) {
  const auto state = state_.lock();
  state->settings = settings;
  state->begin_film();
  state->scene->change_view(view_camera_, settings);
  next_picture_ = 1;
  pictures_from_ = {};
}

/// Whether a path traced view should be rendered by another technique from now on. Finds it by a pilot, once for a scene
/// and a place of the camera. `done`: samples per pixel, `seconds`: of their rendering.
bool SessionWorker::changes_technique(uint64_t done, double seconds) {
  if (!awaits_choice_ || done < kStillSamples || seconds < kStillSeconds || stop_.load()) return false;
  awaits_choice_ = false;
  const auto [scene, hints] = [this] {
    const auto state = state_.lock();
    return std::pair(state->scene, state->hints);
  }();
  const Learned::Choice here = place_of(scene->camera());
  if (!view_choice_ || !view_choice_->place.is_near(here, scene->radius())) {
    RenderSettings denoised = view_settings_;
    denoised.denoised = true;
    scene->change_view(view_camera_, denoised);
    TechniqueChoice made = choose_technique(scene, view_camera_, stop_, hints);
    scene->change_view(view_camera_, view_settings_);
    if (stop_.load()) return false;
    view_choice_ = ViewChoice{made.settings.integrator, made.plan(), here};
  }
  return view_choice_->integrator != "path";
}

/// Renders the view by the technique that was chosen. Its pictures are shown when they are probably the better ones.
void SessionWorker::render_by_choice() {
  const auto start = Clock::now();
  const double before = state_.lock()->progress.render_seconds;
  RenderSettings settings = view_settings_;
  settings.integrator = view_choice_->integrator;
  begin_view(settings);
  {
    const auto state = state_.lock();
    state->integrator_name = view_choice_->integrator;
    state->technique_steps = view_choice_->steps;
  }
  prepare(make_integrator(settings.integrator), start);
  pictures_from_ = Clock::now() + seconds_of(kHeldShare * before);
  render_all();
}

void SessionWorker::show_picture(uint64_t done, bool last) {
  if (stop_.load() || ((done < next_picture_ || Clock::now() < pictures_from_) && !last)) return;
  next_picture_ = 2 * done;
  DenoiserInput input;
  double rays, seconds;
  int threads;
  ViewPicture picture;
  {
    const auto state = state_.lock();
    input = state->denoiser_input();
    rays = double(state->statistics.rays);
    seconds = state->progress.render_seconds;
    threads = state->threads;
    picture.render = state->progress.render;
    picture.iteration = state->progress.iteration;
    picture.samples = state->progress.samples;
  }
  if (pictures_from_ == Clock::time_point())
    schedule_.rendered(double(input.width) * double(input.height), double(done), seconds);
  picture.divider = level_.divider;
  picture.width = input.width;
  picture.height = input.height;
  picture.rgba = picture_of(input, done, rays, threads, picture.not_denoised);
  if (level_.surfaces && picture.not_denoised.empty()) add_surfaces(input, picture);
  const auto state = state_.lock();
  if (stop_.load()) return;
  state->picture = std::move(picture);
  state.notify();
}

/// Gives a coarse picture the size of the view.
void SessionWorker::add_surfaces(const DenoiserInput& input, ViewPicture& picture) {
  const RenderSettings& s = view_settings_;
  const std::shared_ptr<const Scene> scene = state_.lock()->scene;
  const SurfaceGuides guides = trace_surface_guides(*scene, view_camera_, s, stop_);
  const ViewSize fine = divided(s.width, s.height, s.region, 1),
                 coarse = divided(s.width, s.height, s.region, level_.divider);
  picture.rgba = with_surfaces(picture.rgba, {input.albedo, input.normal, coarse},
                               {guides.albedo, guides.normal, fine});
  picture.samples /= level_.divider * level_.divider;
  picture.divider = 1;
  picture.coarse_light = true;
  picture.width = fine.region[2] - fine.region[0];
  picture.height = fine.region[3] - fine.region[1];
}

/// Denoised if that is possible, else `why_not` is set.
std::vector<float> SessionWorker::picture_of(const DenoiserInput& input, uint64_t done, double rays, int threads,
                                             std::string& why_not) {
  const auto start = Clock::now();
  try {
    std::vector<float> rgba = denoiser_(input, double(done), rays, threads, stop_);
    if (double(done) < ViewDenoiser::kConsistentSamples)
      schedule_.denoised(double(input.width) * double(input.height), seconds_since(start));
    return rgba;
  } catch (const DenoisingCancelled& cancelled) {
    why_not = cancelled.what();
  } catch (const std::runtime_error& failure) {
    denoiser_.clear();
    why_not = std::string("The view is not denoised: ") + failure.what();
    state_.lock()->warn(why_not);
  }
  return input.combined;
}

}  // namespace ajar
