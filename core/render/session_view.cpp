// The part of a session's thread that makes the pictures of a 3D view (view/view_pictures.h).
#include <algorithm>

#include "render/session_worker.h"
#include "view/surface_detail.h"
#include "view/surface_guides.h"

namespace ajar {

namespace {

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

/// Renders coarse images of one sample, then the one of the settings.
void SessionWorker::render_view(const CameraDescription& camera, Clock::time_point start) {
  view_camera_ = camera;
  view_settings_ = state_.lock()->scene->settings();
  auto& passes = view_settings_.passes;
  const bool guided = !OpenImageDenoise::version().empty();
  for (const char* guide : kGuides)
    if (guided && std::find(passes.begin(), passes.end(), guide) == passes.end()) passes.emplace_back(guide);
  const double pixels = area_of(view_settings_.region);
  for (level_ = schedule_.first(pixels);; level_ = schedule_.finer(level_, pixels, guided)) {
    {
      const auto state = state_.lock();
      state->settings = at_level(view_settings_, level_);
      state->begin_film();
      state->scene->change_view(camera, state->settings);
    }
    prepare(make_integrator(view_settings_.integrator), start);
    next_picture_ = 1;
    render_all();
    if (level_.divider == 1 || stop_.load()) return;
    start = Clock::now();
  }
}

void SessionWorker::show_picture(uint64_t done, bool last) {
  if (stop_.load() || (done < next_picture_ && !last)) return;
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
