#include "render/session.h"

#include "render/session_worker.h"

namespace ajar {

Session::Session() : worker_(std::make_unique<SessionWorker>()) {}

Session::~Session() {
  cancel();
  worker_->quit();
}

uint64_t Session::start(SceneDescription description) {
  Job job;
  job.description = std::move(description);
  job.final = true;
  return worker_->ask(std::move(job), true);
}

uint64_t Session::next_frame(SceneDescription description) {
  Job job;
  job.description = std::move(description);
  job.final = job.keep = true;
  return worker_->ask(std::move(job), true);
}

uint64_t Session::update(SceneDescription description) {
  Job job;
  job.description = std::move(description);
  job.keep = true;
  return worker_->ask(std::move(job), false);
}

uint64_t Session::change_view(const CameraDescription& camera, const RenderSettings& settings) {
  Job job;
  job.camera = camera;
  job.settings = settings;
  return worker_->ask(std::move(job), false);
}

void Session::cancel() { worker_->cancel(); }

void Session::pause(bool paused) {
  const auto state = worker_->state();
  state->paused = paused;
  state.notify();
}

bool Session::is_paused() const { return worker_->state()->paused; }

bool Session::wait(double seconds) {
  return worker_->state().wait_for(seconds, [](const SessionState& state) { return state.finished(); });
}

Progress Session::progress() const { return worker_->state()->progress; }

std::string Session::take_error() { return std::exchange(worker_->state()->error, {}); }

Diagnostics Session::diagnostics() const { return diagnostics_of(*worker_->state()); }

std::vector<HintReport> Session::hint_reports() const {
  const auto state = worker_->state();
  return state->hints ? state->hints->reports : std::vector<HintReport>();
}

void Session::show_pictures(bool shown) { worker_->state()->shows_pictures = shown; }

std::optional<ViewPicture> Session::take_picture() { return std::exchange(worker_->state()->picture, std::nullopt); }

std::vector<float> Session::snapshot(const std::string& pass, PassSize* size) const {
  const auto state = worker_->state();
  std::vector<float> values;
  if (state->film && state->film_idle) {
    values = state->resolve(pass);
  } else {
    state->wanted.insert(pass);
    if (const auto found = state->published.find(pass); found != state->published.end()) values = found->second;
  }
  if (size && state->film) {
    const int width = state->film->width(), height = state->film->height();
    *size = {width, height, int(values.size() / (size_t(width) * size_t(height)))};
  }
  return values;
}

PhotonPoints Session::photons(uint64_t max_photons) const {
  const auto state = worker_->state();
  if (state->integrator && state->film_idle) return state->photons(max_photons);
  state->wanted_photons = max_photons;
  return state->published_photons;
}

void Session::resume(Checkpoint from, uint64_t scene) {
  const auto state = worker_->state();
  state->scene_fingerprint = scene;
  state->base = std::move(from);
}

void Session::begin_at(uint32_t first) { worker_->state()->first_sample = first; }

void Session::begin_with(std::shared_ptr<const Learned> learned) { worker_->state()->learned = std::move(learned); }

std::shared_ptr<const Learned> Session::learned() const {
  const auto state = worker_->state();
  if (state->progress.phase != Progress::Phase::Done || !state->integrator) return nullptr;
  auto learned = std::make_shared<Learned>();
  learned->integrator = state->integrator_name;
  learned->frames = state->learned ? state->learned->frames + 1 : 1;
  learned->center = state->scene->center();
  learned->radius = state->scene->radius();
  learned->choice = state->choice;
  learned->mixed = state->mixed;
  learned->samples_of_work = state->samples_of_work;
  learned->guiding = state->settings.guiding;
  state->integrator->hand_on(*learned);
  return learned;
}

std::optional<Checkpoint> Session::checkpoint() const {
  const auto state = worker_->state();
  state->checkpoint_wanted = true;
  if (state->film && state->film_idle && state->film->sample_counts().mean > 0.0) return state->checkpoint();
  return state->published_checkpoint;
}

int Session::width() const {
  const auto state = worker_->state();
  return state->film ? state->film->width() : 0;
}

int Session::height() const {
  const auto state = worker_->state();
  return state->film ? state->film->height() : 0;
}

std::vector<ErrorPoint> Session::error_over_time() const { return worker_->state()->error_over_time; }

std::string Session::statistics_json() const { return ajar::statistics_json(*worker_->state()); }

}  // namespace ajar
