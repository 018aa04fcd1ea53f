#include "render/session.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>

#include <sys/resource.h>

#include <nlohmann/json.hpp>
#include <tbb/task_arena.h>

#include "film/image_plan.h"
#include "integrators/learned.h"
#include "math/random.h"
#include "render/importance_map.h"
#include "render/memory_estimate.h"
#include "render/remaining_time.h"
#include "render/technique_choice.h"
#include "transport/direct/direct_methods.h"

namespace ajar {

namespace {

using Clock = std::chrono::steady_clock;
constexpr uint32_t kImportancePilot = 0x6c676874u;   // makes a seed of its own
constexpr int kMostThreads = 1024;     // of Blender
constexpr double kPilotTimeShare = 0.25;   // of a time limit at most goes into choosing a technique
constexpr double kErrorShare = 0.02;   // of a render's time goes into looking at its error

/// Where the settings name no number of threads: AJAR_THREADS, or all of the machine.
int default_threads() {
  const char* named = std::getenv("AJAR_THREADS");
  const int threads = named ? std::atoi(named) : 0;
  return threads > 0 ? threads : tbb::this_task_arena::max_concurrency();
}

Clock::duration seconds_of(double seconds) { return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::min(seconds, 1e8))); }
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

const char* name_of(Progress::Phase phase) {
  switch (phase) {
    case Progress::Phase::Idle: return "idle";
    case Progress::Phase::Building: return "building";
    case Progress::Phase::Rendering: return "rendering";
    case Progress::Phase::Done: return "done";
    case Progress::Phase::Cancelled: return "cancelled";
    case Progress::Phase::Failed: return "failed";
  }
  return "";
}

const char* name_of(Honesty honesty) {
  switch (honesty) {
    case Honesty::Unbiased: return "unbiased";
    case Honesty::Consistent: return "consistent";
    case Honesty::Biased: return "biased";
  }
  return "";
}

/// Throws SceneError with the valid names.
void check_choice(const char* option, const std::string& value, std::initializer_list<const char*> valid) {
  std::string names;
  for (const char* name : valid) {
    if (value == name) return;
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  throw SceneError("Unknown " + std::string(option) + " '" + value + "'. Valid names: " + names + ".");
}

/// Raises a flag at a moment, or when the render is stopped before. Needs a thread, so that whoever looks at the flag need not look at a clock.
class Deadline {
 public:
  /// `changed` is notified under `mutex` whenever `stop` is raised.
  Deadline(Clock::time_point at, std::mutex& mutex, std::condition_variable& changed, const std::atomic<bool>& stop)
      : mutex_(mutex), changed_(changed), thread_([this, at, &stop] {
          std::unique_lock lock(mutex_);
          changed_.wait_until(lock, at, [&] { return over_ || stop.load(); });
          passed_.store(true);
        }) {}
  Deadline(const Deadline&) = delete;
  ~Deadline() {
    {
      std::lock_guard lock(mutex_);
      over_ = true;
      changed_.notify_all();
    }
    thread_.join();
  }
  const std::atomic<bool>& passed() const { return passed_; }

 private:
  std::mutex& mutex_;
  std::condition_variable& changed_;
  bool over_ = false;
  std::atomic<bool> passed_{false};
  std::thread thread_;
};

}  // namespace

/// What the owner asked for and the worker has not begun.
struct Job {
  uint64_t number = 0;
  std::optional<SceneDescription> description;   // else the scene at hand
  bool keep = false;                             // what is shared with the scene of before
  CameraDescription camera;                      // these two when there is no description
  RenderSettings settings;
};

struct Session::Data {
  std::thread thread;
  std::atomic<bool> stop{false};                 // stop rendering
  std::atomic<bool> stop_building{false};
  mutable std::mutex mutex;                      // guards everything below
  std::condition_variable changed;
  std::optional<Job> next;
  bool checkpoint_wanted = false;                // keep one at every iteration boundary
  std::optional<Checkpoint> published_checkpoint;
  bool quit = false;
  bool paused = false;
  bool busy = false;                             // the worker has a job
  uint64_t last_number = 0;
  Progress progress;
  std::string error;
  Diagnostics diagnostics;
  RenderSettings settings;
  std::unique_ptr<Film> film;
  bool film_idle = false;                        // no thread writes to the film: it may be resolved directly
  Film::SampleCounts sample_counts{};            // of the film at the last iteration boundary
  uint64_t film_bytes = 0;
  std::map<std::string, std::vector<float>> published;
  mutable std::set<std::string> wanted{"Combined"};
  PhotonPoints published_photons;
  mutable uint64_t wanted_photons = 0;           // that somebody looks at
  std::shared_ptr<Scene> scene;                  // changed by the worker alone, while nothing renders
  std::unique_ptr<Integrator> integrator;
  std::unique_ptr<ImagePlan> image_plan;  // none: all pixels get the same number of samples
  IntegratorStatistics statistics;
  std::vector<ErrorPoint> error_over_time;
  Clock::time_point last_error_look;
  double error_look_seconds = 0.0;   ///< what the last look took
  std::vector<HintReport> hint_reports;
  PlanSteps plan;
  std::string integrator_name;
  double pilot_seconds = 0.0;
  Clock::time_point limit_start;                 // of the time limit: the scene is built
  RemainingTime remaining_time;
  PlanSteps technique_steps;                    // how the technique was chosen
  std::optional<Checkpoint> base;                // what this render goes on from
  std::shared_ptr<const Learned> learned;        // in the frame before
  std::optional<Learned::Choice> choice;         // of the technique
  uint64_t scene_fingerprint = 0;
  uint32_t seed = 0;                             // in use: a resumed render has its own
  int threads = 0;

  bool finished() const { return !next && !busy; }

  uint64_t ask(Job job, bool abort_building);
  void work();
  void begin(const Job& job);
  void run(Job job);
  void build(Job& job);
  std::unique_ptr<Integrator> choose(const CameraDescription& camera);
  bool takes_choice_of(const Learned& before, const Learned::Choice& here) const;
  bool is_scene_of(const Learned& before) const;
  PlanSteps use_learned(Integrator& chosen);
  void fall_back(std::unique_ptr<Integrator>& chosen);
  void render_all();
  void wait_while_paused();
  bool enough(double render_seconds, double samples, double relmse) const;
  int next_samples(double render_seconds, uint64_t done) const;
  bool error_due(double render_seconds, uint64_t done) const;
  void estimate_error(double render_seconds, uint64_t done);
  void publish(double render_seconds, uint64_t done, bool cut);
  double remaining_seconds(double render_seconds) const;
  void measure_film();
  std::vector<float> resolve(const std::string& pass) const;
  Checkpoint checkpoint() const;
  double samples_before() const { return base ? base->samples : 0.0; }
};

Session::Session() : data_(std::make_unique<Data>()) {}

Session::~Session() {
  cancel();
  {
    std::lock_guard lock(data_->mutex);
    data_->quit = true;
    data_->changed.notify_all();
  }
  if (data_->thread.joinable()) data_->thread.join();
}

uint64_t Session::start(SceneDescription description) {
  Job job;
  job.description = std::move(description);
  return data_->ask(std::move(job), true);
}

uint64_t Session::update(SceneDescription description) {
  Job job;
  job.description = std::move(description);
  job.keep = true;
  return data_->ask(std::move(job), false);
}

uint64_t Session::change_view(const CameraDescription& camera, const RenderSettings& settings) {
  Job job;
  job.camera = camera;
  job.settings = settings;
  return data_->ask(std::move(job), false);
}

uint64_t Session::Data::ask(Job job, bool abort_building) {
  std::lock_guard lock(mutex);
  job.number = ++last_number;
  if (next && next->description && !job.description) {
    // A scene not yet begun is looked at from the newer place.
    next->description->camera = job.camera;
    next->description->settings = job.settings;
    next->number = job.number;
  } else {
    next = std::move(job);
  }
  stop.store(true);
  if (abort_building) stop_building.store(true);
  if (!thread.joinable()) thread = std::thread([this] { work(); });
  changed.notify_all();
  return last_number;
}

/// The worker's life: one job after another.
void Session::Data::work() {
  for (;;) {
    Job job;
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, [this] { return next || quit; });
      if (!next) return;
      job = std::move(*next);
      next.reset();
      begin(job);
    }
    Progress::Phase end = Progress::Phase::Done;
    std::string what;
    try {
      // The session's own arena: several sessions share the machine without sharing queues.
      tbb::task_arena arena(threads);
      arena.execute([&] { run(std::move(job)); });
      if (stop.load()) end = Progress::Phase::Cancelled;
    } catch (const Cancelled&) {
      end = Progress::Phase::Cancelled;
    } catch (const std::bad_alloc&) {
      end = Progress::Phase::Failed;
      what = "There is not enough memory for this scene.";
    } catch (const std::exception& exception) {
      end = Progress::Phase::Failed;
      what = exception.what();
    }
    std::lock_guard lock(mutex);
    busy = false;
    error = what;
    if (film) measure_film();
    film_idle = true;
    progress.phase = end;
    if (end == Progress::Phase::Done) progress.fraction = 1.0f;
    changed.notify_all();
  }
}

/// With the lock held: nothing of the render before is shown as this one's.
void Session::Data::begin(const Job& job) {
  busy = true;
  stop.store(false);
  stop_building.store(false);
  progress = {};
  progress.phase = Progress::Phase::Building;
  progress.render = job.number;
  error.clear();
  settings = job.description ? job.description->settings : job.settings;
  integrator.reset();   // before the scene it holds is changed
  film.reset();
  image_plan.reset();
  film_idle = false;
  sample_counts = {};
  film_bytes = 0;
  published.clear();
  published_checkpoint.reset();
  wanted = {"Combined"};
  published_photons = {};
  wanted_photons = 0;
  statistics = {};
  error_over_time.clear();
  integrator_name = settings.integrator;
  pilot_seconds = 0.0;
  technique_steps.clear();
  choice.reset();
  threads = std::min(settings.threads > 0 ? settings.threads : default_threads(), kMostThreads);
  if (!job.description) return;
  diagnostics.clear();
  hint_reports.clear();
  plan.clear();
  if (!job.keep) scene.reset();
}

void Session::Data::run(Job job) {
  const auto start = Clock::now();
  // What cannot be rendered is refused before anything is built.
  auto chosen = make_integrator(settings.integrator);
  find_direct_method(settings.direct);
  check_choice("guiding", settings.guiding, {"off", "on", "auto"});
  check_choice("vertex merging", settings.vertex_merging, {"off", "on"});
  check_choice("image sampling", settings.image, {"uniform", "pmc_ip"});
  check_choice("image error", settings.image_error, {"relative", "perceptual"});
  const CameraDescription camera = job.description ? job.description->camera : job.camera;
  const bool final_render = job.description && !job.keep;
  if (job.description) {
    check_memory_limit(*job.description);
    build(job);
  } else {
    std::lock_guard lock(mutex);
    if (!scene) throw SceneError("There is no scene to look at.");
    scene->change_view(job.camera, std::move(job.settings));
  }
  if (stop.load()) return;
  limit_start = Clock::now();
  // While the artist moves about there is no time for a pilot.
  if (final_render && settings.integrator == kAutomatic) chosen = choose(camera);
  if (stop.load()) return;
  fall_back(chosen);
  const RenderSettings& s = scene->settings();
  auto new_film = std::make_unique<Film>(s.region[0], s.region[1], s.region[2], s.region[3], s.passes);
  if (base) {
    Checkpoint here;
    here.frame = {s.width, s.height};
    here.region = s.region;
    here.exposure = s.exposure;
    here.scene = scene_fingerprint;
    if (const std::string why = reason_against_merging(*base, here); !why.empty()) throw SceneError("The checkpoint does not fit this render: " + why + ".");
  }
  uint32_t own_seed = s.seed;
  // A number that the render of before has not used.
  for (uint32_t k = 0; base && std::find(base->seeds.begin(), base->seeds.end(), own_seed) != base->seeds.end(); ++k)
    own_seed = hash_combine(s.seed, uint32_t(base->seeds.size()) + k);
  // Numbers that taught what this frame begins with must not choose its samples.
  if (learned && !base) own_seed = hash_combine(own_seed, learned->frames);
  RenderPlan made = make_render_plan(*scene, find_integrator(integrator_name));
  {
    std::lock_guard lock(mutex);
    for (const std::string& warning : made.warnings) report_once(diagnostics, {Diagnostic::Severity::Warning, "", warning});
  }
  chosen->prepare(scene, made, own_seed);
  const PlanSteps learned_steps = use_learned(*chosen);
  const GoalSupport support = chosen->goal_support();
  const bool adapts = s.image == "pmc_ip" && support.follows;
  std::unique_ptr<ImagePlan> new_plan;
  if (adapts) {
    const bool few = s.samples > 0 && s.samples < 16;
    const auto importance = [this, of = scene, pilot_seed = hash_combine(own_seed, kImportancePilot)] { return importance_map(of, pilot_seed, stop); };
    new_plan = std::make_unique<ImagePlan>(s.image_error == "perceptual" ? ErrorMeasure::Perceptual : ErrorMeasure::Relative, std::max(few ? 2u : 4u, support.equal),
                                           s.seed, importance, support.by_passes ? Counts::Any : Counts::Round);
  }
  if (s.image == "pmc_ip" && !adapts && has_importance(*scene)) {
    std::lock_guard lock(mutex);
    report_once(diagnostics, {Diagnostic::Severity::Warning, "", std::string(find_integrator(integrator_name).label) +
                                                                   " cannot give pixels different numbers of samples: what is more important gets no more of them."});
  }
  {
    std::lock_guard lock(mutex);
    plan = std::move(made.steps);
    plan.insert(plan.begin(), technique_steps.begin(), technique_steps.end());
    plan.insert(plan.end(), learned_steps.begin(), learned_steps.end());
    plan.push_back({"image sampling", adapts,
                    adapts               ? "pixels get samples by their noise"
                    : s.image == "pmc_ip" ? "this integrator cannot give pixels different numbers of samples"
                                          : "all pixels get the same number of samples"});
    if (adapts && scene->any_light_importance())
      plan.push_back({"importance of light", true, "a pilot of path tracing measures where the light of groups that matter more or less arrives"});
    image_plan = std::move(new_plan);
    settings = s;
    seed = own_seed;
    film = std::move(new_film);
    integrator = std::move(chosen);
    progress.phase = Progress::Phase::Rendering;
    progress.step = "Rendering";
    progress.build_seconds = seconds_since(start);
  }
  render_all();
}

void Session::Data::build(Job& job) {
  const auto start = Clock::now();
  Scene::Options options;
  options.bake_single_instances = !job.keep;
  options.stop = &stop_building;
  options.progress = [this, start](const char* step, float fraction) {
    std::lock_guard lock(mutex);
    progress.step = step;
    progress.fraction = 0.05f * fraction;
    progress.build_seconds = seconds_since(start);
  };
  std::shared_ptr<Scene> previous;
  {
    std::lock_guard lock(mutex);
    previous = std::move(scene);
  }
  Diagnostics found;
  std::shared_ptr<Scene> built;
  try {
    built = Scene::build(std::move(*job.description), options, found, std::move(previous));
  } catch (...) {
    std::lock_guard lock(mutex);
    diagnostics = std::move(found);
    throw;
  }
  std::vector<HintReport> reports;
  Hints::attach(*built, reports);
  std::lock_guard lock(mutex);
  diagnostics = std::move(found);
  hint_reports = std::move(reports);
  scene = std::move(built);
}

bool Session::Data::enough(double render_seconds, double samples, double relmse) const {
  if (settings.samples > 0 && samples_before() + samples >= double(settings.samples)) return true;
  if (settings.seconds > 0.0 && render_seconds >= settings.seconds) return true;
  return settings.target_error > 0.0 && relmse >= 0.0 && samples >= RemainingTime::kLeastSamples && relmse <= settings.target_error;
}

/// First single samples for a quick picture, then as many as last about a third of a second.
int Session::Data::next_samples(double render_seconds, uint64_t done) const {
  double next = double(std::max<uint64_t>(1, done));
  if (done > 0 && render_seconds > 0.0) {
    const double rate = double(done) / render_seconds;
    next = std::min(next, std::max(1.0, rate * 0.33));
    if (settings.seconds > 0.0) next = std::min(next, std::max(1.0, rate * (settings.seconds - render_seconds)));
  }
  if (settings.samples > 0) next = std::min(next, double(settings.samples) - samples_before() - double(done));
  if (image_plan) {
    const GoalSupport support = integrator->goal_support();
    if (support.by_passes) return 1;
    next = std::min(next, double(image_plan->next_decision(uint32_t(done))) - double(done));
    if (done < support.equal) next = std::min(next, double(support.equal / 4 - done % (support.equal / 4)));
  }
  // Pictures of 2^k samples are what errors are estimated from.
  next = std::min(next, double(std::bit_ceil(done + 1)) - double(done));
  // A render that stops by its error looks at it after fixed numbers of samples, so that the clock has no say in the picture.
  if (settings.target_error > 0.0) {
    const uint64_t step = std::max<uint64_t>(1, std::bit_floor(std::max<uint64_t>(1, done)) / 8);
    next = std::min(next, double(step - done % step));
  }
  return std::max(1, int(next));
}

/// A pass of everything so far, that of a render resumed included. With the lock held, while nothing writes to the film.
std::vector<float> Session::Data::resolve(const std::string& pass) const {
  std::vector<float> values = film->resolve(pass, settings.exposure);
  if (!base) return values;
  const auto before = base->passes.find(pass);
  if (before == base->passes.end()) return values;
  const double samples = film->sample_counts().mean;
  return samples > 0.0 ? merge_pass(pass, before->second, base->samples, values, samples) : before->second;
}

/// With the lock held, while nothing writes to the film.
Checkpoint Session::Data::checkpoint() const {
  Checkpoint c;
  c.frame = {settings.width, settings.height};
  c.region = settings.region;
  c.exposure = settings.exposure;
  c.seeds = {seed};
  c.integrators = {integrator_name};
  c.samples = film->sample_counts().mean;
  c.seconds = progress.render_seconds;
  c.rays = statistics.rays;
  c.refused = film->refused();
  c.relmse = progress.estimated_relmse;
  for (const std::string& pass : settings.passes) c.passes[pass] = film->resolve(pass, settings.exposure);
  for (const char* pass : {"Sample Count", "Variance"}) c.passes[pass] = film->resolve(pass, settings.exposure);
  return base ? merge(*base, c) : c;
}

/// Whether to look at the error again: the render may stop by it, it may be the last time, or looking takes a small share of the time since.
bool Session::Data::error_due(double render_seconds, uint64_t done) const {
  return settings.target_error > 0.0 || std::has_single_bit(done) || enough(render_seconds, double(done), -1.0) ||
         error_look_seconds < kErrorShare * seconds_since(last_error_look);
}

/// With the lock held, while nothing writes to the film.
void Session::Data::estimate_error(double render_seconds, uint64_t done) {
  const auto start = Clock::now();
  const Film::ErrorEstimate estimate = film->estimated_error(uint32_t(done));
  if (std::has_single_bit(done)) film->remember(uint32_t(done));
  progress.estimated_relmse = estimate.relmse;
  progress.estimated_perceptual_error = estimate.perceptual;
  if (estimate.relmse >= 0.0) error_over_time.push_back({render_seconds, progress.samples, estimate.relmse, estimate.perceptual});
  error_look_seconds = seconds_since(start);
  last_error_look = Clock::now();
}

/// With the lock held, while nothing writes to the film.
void Session::Data::measure_film() {
  sample_counts = film->sample_counts();
  film_bytes = film->memory_bytes();
}

/// Until the first of the ends. With the lock held.
double Session::Data::remaining_seconds(double render_seconds) const {
  double least = kInfinity;
  const auto consider = [&](double seconds) {
    if (seconds >= 0.0) least = std::min(least, seconds);
  };
  if (settings.samples > 0) consider(remaining_time.until_samples(double(settings.samples) - samples_before()));
  if (settings.seconds > 0.0) consider(std::max(0.0, settings.seconds - render_seconds));
  consider(remaining_time.until_error(progress.estimated_relmse, settings.target_error));
  return std::isfinite(least) ? least : -1.0;
}

/// `cut`: the time limit has ended an iteration, after which pixels have different numbers of samples and their error is not estimated again.
void Session::Data::publish(double render_seconds, uint64_t done, bool cut) {
  std::lock_guard lock(mutex);
  if (statistics.hints.empty()) {
    for (const HintStatistics& hint : integrator->statistics().hints)
      if (!hint.report.attached) diagnostics.push_back({Diagnostic::Severity::Warning, hint.report.name, "This light hint is not used: " + hint.report.reason + "."});
  }
  statistics = integrator->statistics();
  measure_film();
  progress.samples = samples_before() + sample_counts.mean;
  progress.render_seconds = render_seconds;
  if (!cut && error_due(render_seconds, done)) estimate_error(render_seconds, done);
  float fraction = 0.0f;
  if (settings.samples > 0) fraction = float((samples_before() + double(done)) / settings.samples);
  remaining_time.add(seconds_since(limit_start), double(done));
  progress.remaining_seconds = remaining_seconds(render_seconds);
  if (settings.seconds > 0.0) fraction = std::max(fraction, float(render_seconds / settings.seconds));
  progress.fraction = 0.05f + 0.95f * std::min(1.0f, fraction);
  ++progress.iteration;
  for (const std::string& pass : wanted) published[pass] = resolve(pass);
  wanted.clear();
  if (wanted_photons > 0) published_photons = integrator->photons(std::exchange(wanted_photons, 0));
  if (checkpoint_wanted) published_checkpoint = checkpoint();
  changed.notify_all();
}

/// Much the same place, not necessarily with the same things in it.
bool Session::Data::is_scene_of(const Learned& before) const {
  const float ratio = scene->radius() / before.radius;
  return glm::length(scene->center() - before.center) < 0.5f * before.radius && ratio < 2.0f && ratio > 0.5f;
}

/// Whether the technique chosen for frames before is likely to suit this one, too.
bool Session::Data::takes_choice_of(const Learned& before, const Learned::Choice& here) const {
  const Learned::Choice& there = *before.choice;
  return !base && there.age < Learned::kMostAge && is_scene_of(before) && reason_against(find_integrator(before.integrator), *scene).empty() &&
         glm::length(here.eye - there.eye) < 0.1f * before.radius && glm::dot(here.direction, there.direction) > 0.9f;
}

/// The technique that suits the scene best, by a pilot that the plan then tells of.
std::unique_ptr<Integrator> Session::Data::choose(const CameraDescription& camera) {
  {
    std::lock_guard lock(mutex);
    progress.step = "Choosing a technique";
  }
  const Camera& view = scene->camera();
  Learned::Choice here{view.position(), view.generate_ray(0.5f * Vec2(float(view.width()), float(view.height())), Vec2(0.5f), 0.0f).direction, 0};
  TechniqueChoice made;
  PlanSteps steps;
  if (learned && learned->choice && takes_choice_of(*learned, here)) {
    made.settings = scene->settings();
    made.settings.integrator = learned->integrator;
    here = *learned->choice;
    ++here.age;
    steps = {{"technique", true, std::string(find_integrator(learned->integrator).label) + ": as chosen " + (here.age == 1 ? "a frame" : std::to_string(here.age) + " frames") + " before"}};
  } else {
    std::optional<Deadline> deadline;
    if (settings.seconds > 0.0) deadline.emplace(limit_start + seconds_of(kPilotTimeShare * settings.seconds), mutex, changed, stop);
    made = choose_technique(scene, camera, deadline ? deadline->passed() : stop);
    steps = made.plan();
  }
  auto chosen = make_integrator(made.settings.integrator);
  std::lock_guard lock(mutex);
  scene->change_view(camera, std::move(made.settings));
  technique_steps = std::move(steps);
  integrator_name = scene->settings().integrator;
  pilot_seconds = made.seconds;
  choice = here;
  return chosen;
}

/// Hand the integrator what the frame before has learned, and say what is used of it.
PlanSteps Session::Data::use_learned(Integrator& chosen) {
  if (!learned) return {};
  const std::string why_not = base                                     ? "this one goes on from a checkpoint"
                              : learned->integrator != integrator_name ? "that was rendered by " + std::string(find_integrator(learned->integrator).label)
                              : !is_scene_of(*learned)                 ? "that shows a scene of another size or elsewhere"
                                                                       : "";
  if (!why_not.empty()) return {{"learned in the frame before", false, why_not}};
  PlanSteps steps;
  for (LearnedPart& part : chosen.begin_with(*learned)) {
    const bool used = part.why_not.empty();
    steps.push_back({"learned in the frame before: " + part.name, used, used ? "it goes on learning from there" : part.why_not});
  }
  if (steps.empty()) steps.push_back({"learned in the frame before", false, "with these settings nothing is learned that holds in another frame"});
  return steps;
}

/// Path tracing renders what the integrator asked for cannot, and the artist is told.
void Session::Data::fall_back(std::unique_ptr<Integrator>& chosen) {
  const IntegratorInfo& asked = find_integrator(integrator_name);
  const std::string why = reason_against(asked, *scene);
  if (why.empty()) return;
  const IntegratorInfo& path = find_integrator("path");
  chosen = path.make();
  std::lock_guard lock(mutex);
  integrator_name = path.name;
  technique_steps.push_back({asked.label, false, why});
  report_once(diagnostics, {Diagnostic::Severity::Warning, "", std::string(asked.label) + " does not render this scene: " + why + ". " + path.label + " renders it."});
}

/// Wait while the owner wants it; the time is not counted. Without the lock held.
void Session::Data::wait_while_paused() {
  const auto start = Clock::now();
  std::unique_lock lock(mutex);
  if (!paused) return;
  changed.wait(lock, [this] { return !paused || stop.load(); });
  limit_start += Clock::now() - start;
}

/// A time limit ends an iteration where it stands: pixels keep the samples they have, and chains are weighed by the steps they took. When it ends does not
/// depend on what the samples found, except that those begun are finished. The first sample of each pixel is always taken: a picture has no holes.
void Session::Data::render_all() {
  uint64_t done = 0;
  double rendering = pilot_seconds;  // time of iterations and what chose them, without publishing
  remaining_time.begin(seconds_since(limit_start));
  // A time limit is of all that the artist waits for.
  const auto elapsed = [&] { return settings.seconds > 0.0 ? seconds_since(limit_start) : rendering; };
  while (!stop.load()) {
    wait_while_paused();
    std::optional<Deadline> deadline;
    if (settings.seconds > 0.0) deadline.emplace(limit_start + seconds_of(settings.seconds), mutex, changed, stop);
    const int samples = next_samples(elapsed(), done);
    const auto start = Clock::now();
    if (image_plan) image_plan->plan(*film, uint32_t(done) + uint32_t(samples));
    const bool may_be_cut = deadline && done > 0;
    integrator->run_iteration(*film, samples, may_be_cut ? deadline->passed() : stop);
    rendering += seconds_since(start);
    const bool cut = may_be_cut && deadline->passed().load() && !stop.load();
    if (!cut) done += uint64_t(samples);
    const double so_far = elapsed();
    publish(so_far, done, cut);
    double relmse;
    {
      std::lock_guard lock(mutex);
      relmse = progress.estimated_relmse;
    }
    if (cut || enough(so_far, double(done), relmse)) break;
  }
}

void Session::cancel() {
  std::lock_guard lock(data_->mutex);
  if (data_->next) {
    data_->next.reset();
    if (!data_->busy) data_->progress.phase = Progress::Phase::Cancelled;
  }
  data_->stop.store(true);
  data_->stop_building.store(true);
  data_->changed.notify_all();
}

void Session::pause(bool paused) {
  std::lock_guard lock(data_->mutex);
  data_->paused = paused;
  data_->changed.notify_all();
}

bool Session::is_paused() const {
  std::lock_guard lock(data_->mutex);
  return data_->paused;
}

bool Session::wait(double seconds) {
  std::unique_lock lock(data_->mutex);
  return data_->changed.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return data_->finished(); });
}

Progress Session::progress() const {
  std::lock_guard lock(data_->mutex);
  return data_->progress;
}

std::string Session::take_error() {
  std::lock_guard lock(data_->mutex);
  return std::exchange(data_->error, {});
}

Diagnostics Session::diagnostics() const {
  std::lock_guard lock(data_->mutex);
  return data_->diagnostics;
}

std::vector<HintReport> Session::hint_reports() const {
  std::lock_guard lock(data_->mutex);
  return data_->hint_reports;
}

std::vector<float> Session::snapshot(const std::string& pass) const {
  std::lock_guard lock(data_->mutex);
  if (data_->film && data_->film_idle) return data_->resolve(pass);
  data_->wanted.insert(pass);
  const auto found = data_->published.find(pass);
  return found == data_->published.end() ? std::vector<float>{} : found->second;
}

PhotonPoints Session::photons(uint64_t most) const {
  std::lock_guard lock(data_->mutex);
  if (data_->integrator && data_->film_idle) return data_->integrator->photons(most);
  data_->wanted_photons = most;
  return data_->published_photons;
}

void Session::resume(Checkpoint from, uint64_t scene) {
  std::lock_guard lock(data_->mutex);
  data_->scene_fingerprint = scene;
  data_->base = std::move(from);
}

void Session::begin_with(std::shared_ptr<const Learned> learned) {
  std::lock_guard lock(data_->mutex);
  data_->learned = std::move(learned);
}

std::shared_ptr<const Learned> Session::learned() const {
  std::lock_guard lock(data_->mutex);
  const Data& d = *data_;
  if (d.progress.phase != Progress::Phase::Done || !d.integrator) return nullptr;
  auto learned = std::make_shared<Learned>();
  learned->integrator = d.integrator_name;
  learned->frames = d.learned ? d.learned->frames + 1 : 1;
  learned->center = d.scene->center();
  learned->radius = d.scene->radius();
  learned->choice = d.choice;
  d.integrator->hand_on(*learned);
  return learned;
}

std::optional<Checkpoint> Session::checkpoint() const {
  std::lock_guard lock(data_->mutex);
  data_->checkpoint_wanted = true;
  if (data_->film && data_->film_idle && data_->film->sample_counts().mean > 0.0) return data_->checkpoint();
  return data_->published_checkpoint;
}

int Session::width() const {
  std::lock_guard lock(data_->mutex);
  return data_->film ? data_->film->width() : 0;
}

int Session::height() const {
  std::lock_guard lock(data_->mutex);
  return data_->film ? data_->film->height() : 0;
}

std::vector<ErrorPoint> Session::error_over_time() const {
  std::lock_guard lock(data_->mutex);
  return data_->error_over_time;
}

std::string Session::statistics_json() const {
  std::lock_guard lock(data_->mutex);
  const Data& d = *data_;
  using nlohmann::json;
  json j;
  j["version"] = AJAR_VERSION;
  j["state"] = name_of(d.progress.phase);
  j["integrator"] = d.integrator_name;
  j["direct"] = d.settings.direct;
  j["guiding"] = d.settings.guiding;
  j["vertex_merging"] = d.settings.vertex_merging;
  j["image"] = d.settings.image;
  j["seeds"] = d.base ? d.base->seeds : std::vector<uint32_t>{};
  if (d.film) j["seeds"].push_back(d.seed);
  if (d.base) j["resumed"] = {{"samples", d.base->samples}, {"seconds", d.base->seconds}, {"rays", d.base->rays}, {"refused_samples", d.base->refused}};
  j["threads"] = d.threads;
  j["frames_before"] = d.learned ? d.learned->frames : 0;
  j["resolution"] = {d.settings.width, d.settings.height};
  j["build_seconds"] = d.progress.build_seconds;
  j["pilot_seconds"] = d.pilot_seconds;
  j["render_seconds"] = d.progress.render_seconds;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  j["peak_memory_bytes"] = int64_t(usage.ru_maxrss) * 1024;
  j["rays"] = d.statistics.rays;
  j["paths"] = d.statistics.paths;
  if (d.progress.render_seconds > 0.0) {
    j["rays_per_second"] = double(d.statistics.rays) / d.progress.render_seconds;
  }
  for (const auto& [key, value] : d.statistics.extra) j[key] = value;
  if (d.film) {
    const Film::SampleCounts& counts = d.sample_counts;
    j["samples_per_pixel"] = {{"mean", d.samples_before() + counts.mean}, {"min", counts.least}, {"max", counts.most}};
    j["refused_samples"] = d.film->refused();
    j["film_bytes"] = d.film_bytes;
  }
  if (d.integrator) {
    const Honesty honesty = d.integrator->honesty();
    j["honesty"] = name_of(d.image_plan && d.integrator->goal_support().learns ? std::max(honesty, Honesty::Consistent) : honesty);
  }
  if (d.scene) {
    const BuildStatistics& b = d.scene->statistics();
    j["scene"] = {{"triangles", b.triangles},
                  {"strands", b.strands},
                  {"instanced_triangles", b.instanced_triangles},
                  {"instances", b.instances},
                  {"meshes", b.meshes},
                  {"lights", b.lights},
                  {"geometry_bytes", b.geometry_bytes},
                  {"accel_bytes", b.accel_bytes},
                  {"texture_bytes", b.texture_bytes},
                  {"light_tree_bytes", b.light_tree_bytes},
                  {"environment_bytes", b.environment_bytes},
                  {"skipped_triangles", b.skipped_triangles},
                  {"repaired_values", b.repaired_values},
                  {"kept_meshes", b.kept_meshes},
                  {"kept_textures", b.kept_textures},
                  {"compiled_programs", b.compiled_programs},
                  {"kept_programs", b.kept_programs},
                  {"placed_instances", b.placed_instances},
                  {"kept_environment", b.kept_environment}};
  }
  j["plan"] = json::array();
  for (const PlanStep& step : d.plan) j["plan"].push_back({{"step", step.step}, {"used", step.used}, {"reason", step.reason}, {"cost", step.cost}});
  j["hints"] = json::array();
  for (const HintStatistics& hint : d.statistics.hints) {
    const HintReport& r = hint.report;
    json positions = json::array(), segments = json::array();
    for (const Vec3& p : r.positions) positions.push_back({p.x, p.y, p.z});
    for (const HintSegmentState state : r.segments)
      segments.push_back(state == HintSegmentState::Attached ? "attached" : state == HintSegmentState::Bounced ? "bounced" : "failed");
    j["hints"].push_back({{"name", r.name},
                          {"attached", r.attached},
                          {"reason", r.reason},
                          {"proposed", hint.proposed},
                          {"accepted", hint.accepted},
                          {"energy_share", hint.energy_share},
                          {"positions", std::move(positions)},
                          {"segments", std::move(segments)}});
  }
  j["acceptance_rates"] = json::object();
  for (const auto& [key, proposed] : d.statistics.extra) {
    if (!key.starts_with("proposed_") || !(proposed > 0.0)) continue;
    const auto accepted = d.statistics.extra.find("accepted_" + key.substr(9));
    if (accepted != d.statistics.extra.end()) j["acceptance_rates"][key.substr(9)] = accepted->second / proposed;
  }
  j["estimated_error"] = json::array();
  j["estimated_perceptual_error"] = json::array();
  for (const ErrorPoint& point : d.error_over_time) {
    j["estimated_error"].push_back({point.seconds, point.samples, point.relmse});
    j["estimated_perceptual_error"].push_back({point.seconds, point.samples, point.perceptual});
  }
  j["diagnostics"] = json::array();
  for (const Diagnostic& diagnostic : d.diagnostics) {
    const char* severity = diagnostic.severity == Diagnostic::Severity::Info      ? "info"
                           : diagnostic.severity == Diagnostic::Severity::Warning ? "warning"
                                                                                  : "error";
    j["diagnostics"].push_back({{"severity", severity}, {"object", diagnostic.object}, {"message", diagnostic.message}});
  }
  // Names may hold bytes that are not UTF-8; they are replaced, not fatal.
  return j.dump(1, ' ', false, json::error_handler_t::replace);
}

}  // namespace ajar
