// The part of the session's worker that chooses techniques.
#include <algorithm>

#include "choice/technique_choice.h"
#include "denoise/shown_error.h"
#include "math/random.h"
#include "render/deadline.h"
#include "render/session_worker.h"
#include "scene/path_tracing_only.h"

namespace ajar {

namespace {

constexpr double kPilotTimeShare = 0.25;         // maximum share of a time limit for the choice of a technique
constexpr uint32_t kSeedOfOthers = 0x7365636fu;  // for a separate seed

/// Whether the technique that was chosen for earlier frames probably suits this one. Not for a render that continues
/// from a checkpoint.
bool takes_choice_of(const Scene& scene, const Learned& before, const Learned::Choice& here) {
  return before.choice->age < Learned::kMaxAge && before.is_of_scene(scene.center(), scene.radius()) &&
         before.choice->is_near(here, before.radius);
}

PlanStep fewer_samples(int samples, int asked) {
  return {"samples", true,
          std::to_string(samples) + ": the work of " + std::to_string(asked) + " samples of path tracing", ""};
}

}  // namespace

/// What only path tracing renders is rendered by it, whatever technique is asked for.
void SessionWorker::use_path_tracing_where_others_fail(Job& job) {
  replaced_integrator_.clear();
  RenderSettings& settings = job.description ? job.description->settings : job.settings;
  if (settings.integrator == "path") return;
  replaced_because_ = job.description ? path_tracing_only(*job.description)
                                      : path_tracing_only(state_.lock()->scene.get(), job.camera, settings);
  if (replaced_because_.empty()) return;
  const IntegratorInfo& asked = find_integrator(settings.integrator);
  if (asked.automatic) {  // path tracing is one of its choices, with a guide where a measurement finds that it pays
    state_.lock()->technique_steps = {
        {"technique", true, "path tracing: the others do not render " + replaced_because_, ""}};
    if (settings.guiding == Guiding::Off) settings.guiding = Guiding::Auto;
  } else {
    replaced_integrator_ = asked.label;
  }
  settings.integrator = "path";
}

/// The image of `auto` must not depend on the technique that it chooses. Path tracing alone can clamp, so `auto` does not.
void SessionWorker::ignore_clamping_of_auto(Job& job) {
  RenderSettings& settings = job.description ? job.description->settings : job.settings;
  ignores_clamping_ = find_integrator(settings.integrator).automatic &&
                      (settings.clamp_direct > 0.0f || settings.clamp_indirect > 0.0f);
  if (ignores_clamping_) settings.clamp_direct = settings.clamp_indirect = 0.0f;
}

/// Chooses the technique for the scene by a pilot, which the plan then lists.
std::unique_ptr<Integrator> SessionWorker::choose(const CameraDescription& camera) {
  std::shared_ptr<Scene> scene;
  std::shared_ptr<const Learned> learned;
  std::shared_ptr<const AttachedHints> hints;
  double seconds;
  bool may_mix, is_range;
  {
    const auto state = state_.lock();
    state->progress.step = "Choosing a technique";
    scene = state->scene;
    hints = state->hints;
    if (!state->base) learned = state->learned;
    seconds = state->settings.seconds;
    // A checkpoint and a range of samples are those of one technique.
    may_mix = !state->base && !state->first_sample && !state->checkpoint_wanted;
    is_range = state->first_sample.has_value();
  }
  Learned::Choice here = place_of(scene->camera());
  TechniqueChoice made;
  PlanSteps steps;
  if (learned && learned->choice && takes_choice_of(*scene, *learned, here)) {
    made.settings = scene->settings();
    made.settings.integrator = learned->integrator;
    made.settings.guiding = learned->guiding;
    if (may_mix) made.mixed = learned->mixed;
    made.samples_of_work = learned->samples_of_work;
    here = *learned->choice;
    ++here.age;
    const std::string age = here.age == 1 ? "one frame" : std::to_string(here.age) + " frames";
    steps = {{"technique", true,
              std::string(find_integrator(learned->integrator).label) + ": as chosen " + age + " before", ""}};
  } else {
    std::optional<Deadline> deadline;
    if (seconds > 0.0) deadline.emplace(limit_start_ + seconds_of(kPilotTimeShare * seconds), state_, stop_);
    made = choose_technique(scene, camera, deadline ? deadline->passed() : stop_, hints, may_mix);
    steps = made.plan();
  }
  auto chosen = make_integrator(made.settings.integrator);
  // A range of samples has its number. After the trial of a mixture, its number follows from what the trial has measured.
  const int asked = made.settings.samples;
  if (!is_range && !(made.mixed.trial_work > 0.0)) {
    made.settings.samples = samples_for_work(asked, made.samples_of_work);
    if (made.settings.samples < asked) steps.push_back(fewer_samples(made.settings.samples, asked));
  }
  const auto state = state_.lock();
  scene->change_view(camera, std::move(made.settings));
  state->technique_steps = std::move(steps);
  state->integrator_name = scene->settings().integrator;
  state->pilot_seconds = made.seconds;
  state->choice = here;
  state->mixed = std::move(made.mixed);
  state->samples_of_work = made.samples_of_work;
  return chosen;
}

/// All techniques of the render, if there are several, else null. `first`: the integrator and the film of the render.
/// `seed`: its seed.
std::unique_ptr<Mixture> SessionWorker::make_mixture(const std::shared_ptr<const Scene>& scene, Mixture::Part first,
                                                     uint32_t seed) {
  Learned::Mixed mixed;
  std::shared_ptr<const AttachedHints> hints;
  {
    const auto state = state_.lock();
    mixed = state->mixed;
    hints = state->hints;
  }
  if (mixed.techniques.empty()) return nullptr;
  std::vector<std::unique_ptr<Integrator>> others;
  for (size_t k = 1; k < mixed.techniques.size(); ++k) {
    const std::string& name = mixed.techniques[k].integrator;
    const RenderPlan plan = make_render_plan(*scene, find_integrator(name), hints);
    for (const std::string& warning : plan.warnings) state_.lock()->warn(warning);
    others.push_back(make_integrator(name));
    others.back()->prepare(scene, plan, hash_combine(seed, kSeedOfOthers + uint32_t(k)));
  }
  return std::make_unique<Mixture>(std::move(mixed), first, std::move(others), scene->settings());
}

/// After the trial of a mixture, whose techniques have `done` samples: they share the rest of the work by the errors of
/// their denoised images. `samples`: that end the render; it is lowered to those that the rest of the work pays for.
void SessionWorker::share_work(Mixture& mixture, uint64_t done, int& samples) {
  const double rest = mixture.choice().trial_work / kTrialShare * (1.0 - kTrialShare);
  const DenoiserInput input = state_.lock()->denoiser_input();
  const int threads = state_.lock()->threads;
  const std::vector<double> errors = relmse_of_techniques(input, threads, stop_);
  if (stop_.load()) return;
  const auto state = state_.lock();
  state->plan.push_back(mixture.share_by(errors));
  state->mixed = mixture.choice();
  if (samples <= 0) return;
  const double all = double(done + mixture.samples_for(rest));
  state->samples_of_work = std::min(1.0, all / samples);
  if (all >= samples) return;
  state->plan.push_back(fewer_samples(int(all), samples));
  samples = int(all);
  state->settings.samples = samples;
  state->policy.limit_samples(samples);
}

}  // namespace ajar
