#include "render/session_worker.h"

#include <algorithm>
#include <bit>

#include <tbb/task_arena.h>

#include "choice/technique_choice.h"
#include "denoise/shown_error.h"
#include "math/random.h"
#include "platform/platform.h"
#include "render/deadline.h"
#include "render/importance_map.h"
#include "render/memory_estimate.h"
#include "scene/path_tracing_only.h"

namespace ajar {

namespace {

constexpr uint32_t kImportancePilot = 0x6c676874u;  // for a separate seed
constexpr double kMaxDropped = 1e-3;                // coverage of mattes without a rank that is not reported

/// Gives the integrator what the previous frame has learned, and reports what it uses.
PlanSteps use_learned(const SessionState& state, Integrator& chosen) {
  if (!state.learned) return {};
  const Learned& learned = *state.learned;
  const std::string why_not = state.base ? "this render continues from a checkpoint"
                              : learned.integrator != state.integrator_name
                                  ? "that frame was rendered by " +
                                        std::string(find_integrator(learned.integrator).label)
                              : !learned.is_of_scene(state.scene->center(), state.scene->radius())
                                  ? "that frame shows a scene of another size or place"
                                  : "";
  if (!why_not.empty()) return {{"learned in the frame before", false, why_not, ""}};
  PlanSteps steps;
  for (LearnedPart& part : chosen.begin_with(learned)) {
    const bool used = part.why_not.empty();
    steps.push_back(
        {"learned in the frame before: " + part.name, used, used ? "learning continues from it" : part.why_not, ""});
  }
  if (steps.empty())
    steps.push_back({"learned in the frame before", false,
                     "with these settings, nothing is learned that can be used in another frame", ""});
  return steps;
}

/// Throws SceneError if the render cannot continue from the checkpoint.
void check_base(const SessionState& state, const RenderSettings& s) {
  if (!state.base) return;
  Checkpoint here;
  here.frame = {s.width, s.height};
  here.region = s.region;
  here.exposure = s.exposure;
  here.scene = state.scene_fingerprint;
  here.view = state.view_fingerprint;
  if (const std::string why = reason_against_merging(*state.base, here); !why.empty())
    throw SceneError("The checkpoint does not fit this render: " + why + ".");
}

/// Only while nothing writes to the film.
void estimate_error(SessionState& state, double seconds, uint64_t done) {
  const auto start = Clock::now();
  const auto in_film = state.samples_in_film + uint32_t(state.mixture ? state.mixture->parts()[0].done : done);
  const Film::ErrorEstimate estimate = state.mixture ? state.mixture->estimated_error()
                                                     : state.film->estimated_error(in_film);
  if (std::has_single_bit(done)) state.film->remember(in_film);
  state.progress.estimated_relmse = estimate.relmse;
  state.progress.estimated_perceptual_error = estimate.perceptual;
  if (estimate.relmse >= 0.0)
    state.error_over_time.push_back({seconds, state.progress.samples, estimate.relmse, estimate.perceptual});
  state.policy.error_looked_at(start);
}

}  // namespace

uint64_t SessionWorker::ask(Job job, bool abort_building) {
  const auto state = state_.lock();
  job.number = ++state->last_number;
  if (state->next && state->next->description && !job.description) {
    // The scene is not built yet: it gets the newer view.
    state->next->description->camera = job.camera;
    state->next->description->settings = job.settings;
    state->next->number = job.number;
  } else {
    state->next = std::move(job);
  }
  state->picture.reset();
  stop_.store(true);
  if (abort_building) stop_building_.store(true);
  platform::keep_task_threads();
  if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
  state.notify();
  return state->last_number;
}

void SessionWorker::cancel() {
  const auto state = state_.lock();
  if (state->next) {
    state->next.reset();
    if (!state->busy) state->progress.phase = Progress::Phase::Cancelled;
  }
  state->picture.reset();
  stop_.store(true);
  stop_building_.store(true);
  state.notify();
}

void SessionWorker::quit() {
  {
    const auto state = state_.lock();
    state->quit = true;
    state.notify();
  }
  if (thread_.joinable()) thread_.join();
}

/// The thread: does one job after another.
void SessionWorker::work() {
  for (;;) {
    Job job;
    int threads;
    {
      auto state = state_.lock();
      state.wait([](const SessionState& s) { return s.next || s.quit; });
      if (!state->next) return;
      job = std::move(*state->next);
      state->next.reset();
      stop_.store(false);
      stop_building_.store(false);
      state->begin(job);
      threads = state->threads;
    }
    Progress::Phase end = Progress::Phase::Done;
    std::string what;
    try {
      // The session has its own arena: several sessions share the machine, but not their queues.
      tbb::task_arena arena(threads);
      arena.execute([&] { run(std::move(job)); });
      if (stop_.load()) end = Progress::Phase::Cancelled;
    } catch (const Cancelled&) {
      end = Progress::Phase::Cancelled;
    } catch (const std::bad_alloc&) {
      end = Progress::Phase::Failed;
      what = "There is not enough memory for this scene.";
    } catch (const std::exception& exception) {
      end = Progress::Phase::Failed;
      what = exception.what();
    }
    const auto state = state_.lock();
    state->busy = false;
    state->error = what;
    if (state->film) state->measure_film();
    state->film_idle = true;
    state->progress.phase = end;
    if (end == Progress::Phase::Done) state->progress.fraction = 1.0f;
    state.notify();
  }
}

void SessionWorker::run(Job job) {
  const auto start = Clock::now();
  use_path_tracing_where_others_fail(job);
  ignore_clamping_of_auto(job);
  // Invalid settings are refused before anything is built.
  const RenderSettings asked = job.description ? job.description->settings : job.settings;
  auto chosen = make_integrator(asked.integrator);
  const CameraDescription camera = job.description ? job.description->camera : job.camera;
  const bool final_render = job.description && job.final;
  if (job.description) {
    check_memory_limit(*job.description);
    build(job);
  } else {
    const auto state = state_.lock();
    if (!state->scene) throw SceneError("There is no scene to render.");
    state->scene->change_view(job.camera, std::move(job.settings));
  }
  if (stop_.load()) return;
  limit_start_ = Clock::now();
  cpu_start_ = platform::cpu_seconds();
  // While the artist navigates, there is no time for a pilot.
  if (final_render && find_integrator(asked.integrator).automatic) chosen = choose(camera);
  if (stop_.load()) return;
  level_ = {0, false};
  awaits_choice_ = false;
  if (!final_render && state_.lock()->shows_pictures) return render_view(camera, start);
  prepare(std::move(chosen), start);
  render_all();
}

void SessionWorker::build(Job& job) {
  const auto start = Clock::now();
  Scene::Options options;
  options.bake_single_instances = !job.keep;
  options.stop = &stop_building_;
  options.progress = [this, start](const char* step, float fraction) {
    const auto state = state_.lock();
    state->progress.step = step;
    state->progress.fraction = 0.05f * fraction;
    state->progress.build_seconds = seconds_since(start);
  };
  std::shared_ptr<Scene> previous = std::move(state_.lock()->scene);
  Diagnostics found;
  std::shared_ptr<Scene> built;
  try {
    built = Scene::build(std::move(*job.description), options, found, std::move(previous));
  } catch (...) {
    state_.lock()->diagnostics = std::move(found);
    throw;
  }
  if (!replaced_integrator_.empty())
    found.push_back({Diagnostic::Severity::Warning, replaced_integrator_,
                     "does not render " + replaced_because_ + ": the scene is rendered by Path Tracing"});
  view_choice_.reset();
  auto hints = std::make_shared<const AttachedHints>(attach_hints(*built));
  const auto state = state_.lock();
  state->diagnostics = std::move(found);
  state->hints = std::move(hints);
  state->scene = std::move(built);
}

/// A seed that neither the renders of the checkpoint nor the frame that has trained the learned data have used.
uint32_t SessionWorker::own_seed(const RenderSettings& s) {
  const auto state = state_.lock();
  uint32_t seed = s.seed;
  const auto& base = state->base;
  for (uint32_t k = 0; base && std::find(base->seeds.begin(), base->seeds.end(), seed) != base->seeds.end(); ++k)
    seed = hash_combine(s.seed, uint32_t(base->seeds.size()) + k);
  return state->learned && !base ? hash_combine(seed, state->learned->frames) : seed;
}

std::unique_ptr<ImagePlan> SessionWorker::make_image_plan(const RenderSettings& s, const GoalSupport& support,
                                                          uint32_t seed) {
  const bool few = s.samples > 0 && s.samples < 16;
  const auto importance = [this, of = state_.lock()->scene, pilot_seed = hash_combine(seed, kImportancePilot)] {
    return importance_map(of, pilot_seed, stop_);
  };
  return std::make_unique<ImagePlan>(s.image_error, std::max(few ? 2u : 4u, support.equal), s.seed, importance,
                                     support.by_passes ? Counts::Any : Counts::Round);
}

/// Lets the integrator and the film begin at the wanted range. If they cannot, the render gets a seed of its own.
PlanSteps SessionWorker::take_range(const std::shared_ptr<const Scene>& scene, const RenderPlan& plan,
                                    Integrator& chosen, std::unique_ptr<Film>& film, uint32_t& seed) {
  const RenderSettings& s = scene->settings();
  const auto state = state_.lock();
  const std::optional<SampleRange> range = state->wanted_range(s);
  if (!range) return {};
  std::string why_not;
  uint32_t before = 0;
  film->begin_at(range->first);
  chosen.prepare(scene, plan, range->seed);
  if (scene->catchers() || !film->keep_exact_sums())
    why_not = "shadow catchers, Cryptomatte, AOVs, light groups, motion vectors and occlusion have no exact sums";
  if (why_not.empty() && state->base) try {
      film->set_sums(state->base->sums);
      before = film->sample_counts().min;
    } catch (const std::invalid_argument& error) {
      why_not = error.what();
    }
  if (s.image == ImageSampling::PmcIp) why_not = "the samples of a pixel depend on other pixels";
  if (why_not.empty() && !chosen.begin_at(range->first + before)) why_not = "samples depend on those before them";
  if (why_not.empty()) {
    seed = range->seed;
    state->range = range;
    state->samples_in_film = before;
    if (state->base) state->base->passes.clear(), state->base->sums = {};
    state->continued = std::exchange(state->base, std::nullopt);
    return {{"range of samples", true, "the samples of each pixel begin at number " + std::to_string(range->first),
             "a second number for each sum of the film"}};
  }
  if (range->first > 0 && !state->base) seed = hash_combine(seed, range->first);
  film = make_film(s, s.passes);
  chosen.prepare(scene, plan, seed);
  return {{"range of samples", false, why_not + "; the render has a seed of its own", ""}};
}

/// Everything between the choice of an integrator and its first sample.
void SessionWorker::prepare(std::unique_ptr<Integrator> chosen, Clock::time_point start) {
  std::shared_ptr<Scene> scene;
  RenderPlan plan;
  {
    const auto state = state_.lock();
    scene = state->scene;
    check_base(*state, scene->settings());
    plan = make_render_plan(*scene, find_integrator(state->integrator_name), state->hints);
    for (const std::string& warning : plan.warnings) state->warn(warning);
  }
  RenderSettings s = scene->settings();
  uint32_t seed = own_seed(s);
  auto film = make_film(s, s.passes);
  chosen->prepare(scene, plan, seed);
  PlanSteps learned_steps = take_range(scene, plan, *chosen, film, seed);
  for (PlanStep& step : use_learned(*state_.lock(), *chosen)) learned_steps.push_back(std::move(step));
  std::unique_ptr<Mixture> mixture = make_mixture(scene, {*chosen, *film}, seed);
  const GoalSupport support = chosen->goal_support();
  const bool adapts = s.image == ImageSampling::PmcIp && support.follows;
  std::unique_ptr<ImagePlan> image_plan = adapts ? make_image_plan(s, support, seed) : nullptr;

  const auto state = state_.lock();
  if (s.image == ImageSampling::PmcIp && !adapts && has_importance(*scene))
    state->warn(std::string(find_integrator(state->integrator_name).label) +
                " cannot give pixels different numbers of samples: their importance has no effect.");
  PlanSteps& steps = state->plan;
  steps = std::move(plan.steps);
  steps.insert(steps.begin(), state->technique_steps.begin(), state->technique_steps.end());
  steps.insert(steps.end(), learned_steps.begin(), learned_steps.end());
  if (ignores_clamping_)
    steps.push_back({"clamping", false,
                     "only path tracing can clamp, and the image must not depend on the technique that is chosen", ""});
  steps.push_back({"image sampling", adapts,
                   adapts                            ? "the number of samples of each pixel depends on its noise"
                   : s.image == ImageSampling::PmcIp ? "this integrator cannot give pixels different numbers of samples"
                                                     : "all pixels get the same number of samples",
                   adapts ? "a few numbers for each pixel, read from time to time" : ""});
  if (adapts && scene->any_light_importance())
    steps.push_back(
        {"importance of light", true,
         "a pilot of path tracing measures where the light of groups with an importance other than 1 arrives",
         "the pilot"});
  state->image_plan = std::move(image_plan);
  // The owner ends the render in time for one image to be denoised. With a mixture, there are two.
  if (mixture && s.seconds > 0.0)
    s.seconds = std::max(0.5 * s.seconds, s.seconds - mixture->choice().denoise_seconds / state->threads);
  state->settings = s;
  state->seed = seed;
  state->film = std::move(film);
  state->integrator = std::move(chosen);
  state->mixture = std::move(mixture);
  state->policy = StoppingPolicy(s, state->samples_before() + double(state->samples_in_film));
  state->progress.phase = Progress::Phase::Rendering;
  state->progress.step = "Rendering";
  state->progress.build_seconds = seconds_since(start);
}

/// Waits while the owner has paused the render. The time limit does not count this time. The first iteration does not
/// wait, so that there is an image.
void SessionWorker::wait_while_paused() {
  const auto start = Clock::now();
  auto state = state_.lock();
  if (!state->paused) return;
  state.wait([this](const SessionState& s) { return !s.paused || stop_.load(); });
  limit_start_ += Clock::now() - start;
}

/// Renders the next samples by the technique whose turn it is, and returns their number.
int SessionWorker::run_iteration(Render& render, double elapsed, uint64_t done, const std::atomic<bool>* deadline) {
  Mixture::Part& part = render.mixture ? render.mixture->due() : render.only;
  ImagePlan* image_plan = &part.film == &render.only.film ? render.image_plan : nullptr;
  int samples;
  {
    const auto state = state_.lock();
    samples = state->policy.next_samples(elapsed, part.done, image_plan, part.integrator.goal_support());
    if (render.mixture) samples = std::min(samples, int(render.mixture->samples_of_turn()));
    if (render.mixture && render.settings.samples > 0)
      samples = std::max(1, std::min(samples, render.settings.samples - int(done)));
  }
  // The first samples of each technique are complete, so that its image has no holes.
  const std::atomic<bool>& stop = deadline && part.done > 0 ? *deadline : stop_;
  if (image_plan) image_plan->plan(part.film, uint32_t(part.done) + uint32_t(samples));
  part.integrator.run_iteration(part.film, samples, stop);
  if (stop.load()) return samples;
  const auto state = state_.lock();  // the owner reads the counts of a mixture
  if (render.mixture)
    render.mixture->add_done(uint64_t(samples));
  else
    part.done += uint64_t(samples);
  return samples;
}

/// A time limit can end an iteration at any point. Pixels keep the samples that they have, and chains are weighted by
/// the steps that they took. This end does not depend on the values of samples, except that started samples are
/// finished. The first sample of each pixel is always taken, so that the image has no holes.
void SessionWorker::render_all() {
  uint64_t done = 0;
  ShownErrorSchedule shown_error;
  double rendering;  // time of the iterations and of the choice of a technique, without publishing
  bool complete;     // the checkpoint has all samples already
  const auto owned = [this, &rendering, &complete] {
    const auto state = state_.lock();
    rendering = state->pilot_seconds;
    complete = state->samples_in_film > 0 && state->policy.enough(0.0, 0.0, -1.0);
    state->policy.remaining_time.begin(seconds_since(limit_start_));
    return Render{{*state->integrator, *state->film}, state->image_plan.get(), state->mixture.get(), state->settings};
  };
  Render render = owned();
  const double limit = render.settings.seconds;
  // A time limit counts all the time since the build.
  const auto elapsed = [&] { return limit > 0.0 ? seconds_since(limit_start_) : rendering; };
  if (complete) publish(0.0, 0, false);
  while (!complete && !stop_.load()) {
    if (done > 0) wait_while_paused();
    std::optional<Deadline> deadline;
    if (limit > 0.0) deadline.emplace(limit_start_ + seconds_of(limit), state_, stop_);
    const bool may_be_cut = deadline && done > 0;
    const auto start = Clock::now();
    const int samples = run_iteration(render, elapsed(), done, may_be_cut ? &deadline->passed() : nullptr);
    const bool cut = may_be_cut && deadline->passed().load() && !stop_.load();
    if (!cut) done += uint64_t(samples);
    if (render.mixture && !cut && render.mixture->trial_ends())
      share_work(*render.mixture, done, render.settings.samples);
    rendering += seconds_since(start);
    const double so_far = elapsed();
    publish(so_far, done, cut);
    if (render.settings.denoised && render.settings.target_error > 0.0 && !cut && shown_error.due(done)) {
      shown_error.looked_at(done);
      const DenoiserInput input = state_.lock()->denoiser_input();
      const double relmse = shown_relmse(input, render.settings.threads, stop_);
      state_.lock()->progress.denoised_relmse = relmse;
    }
    const auto ended = [&] {
      const auto state = state_.lock();
      return cut || state->policy.enough(so_far, double(done), state->progress.shown_relmse());
    };
    const bool last = ended();
    if (level_.divider > 0) show_picture(done, last);
    if (last) break;
    if (changes_technique(done, so_far)) return render_by_choice();
  }
}

void SessionWorker::keep_checkpoint(SessionState& state) {
  constexpr double kShare = 0.05;  // of the time
  if (state.published_checkpoint && checkpoint_seconds_ > kShare * seconds_since(checkpoint_time_)) return;
  checkpoint_time_ = Clock::now();
  state.published_checkpoint = state.checkpoint();
  checkpoint_seconds_ = seconds_since(checkpoint_time_);
}

void SessionWorker::publish(double seconds, uint64_t done, bool cut) {
  const auto state = state_.lock();
  const Integrator& integrator = *state->integrator;
  Progress& progress = state->progress;
  if (state->statistics.hints.empty()) {
    for (const HintStatistics& hint : integrator.statistics().hints)
      if (!hint.report.attached)
        state->diagnostics.push_back({Diagnostic::Severity::Warning, hint.report.name,
                                      "This light hint is not used: " + hint.report.reason + "."});
  }
  state->statistics = integrator.statistics();
  if (state->mixture) state->mixture->add_to(state->statistics);
  state->measure_film();
  if (state->film->dropped_mattes() > kMaxDropped)
    report_once(state->diagnostics,
                {Diagnostic::Severity::Warning, "",
                 "Cryptomatte: in some pixels there are more mattes than ranks; more Levels show all of them."});
  progress.samples = state->samples_before() + state->sample_counts.mean;
  progress.render_seconds = seconds;
  state->cpu_seconds = platform::cpu_seconds() - cpu_start_;
  if (!cut && state->policy.error_due(seconds, done)) estimate_error(*state, seconds, done);
  state->policy.remaining_time.add(seconds_since(limit_start_), double(done));
  progress.remaining_seconds = state->policy.remaining_seconds(seconds, progress.shown_relmse());
  progress.fraction = 0.05f + 0.95f * state->policy.fraction(seconds, done);
  ++progress.iteration;
  for (const std::string& pass : state->wanted) state->published[pass] = state->resolve(pass);
  state->wanted.clear();
  if (state->wanted_photons > 0) state->published_photons = state->photons(std::exchange(state->wanted_photons, 0));
  if (state->checkpoint_wanted) keep_checkpoint(*state);
  state.notify();
}

}  // namespace ajar
