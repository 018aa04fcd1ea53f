// The thread of a session. It does one job after another. A job is a build and a render, or a render of the present
// scene.
//
// The data that it shares with the owner are in SessionState, locked for each use. While it renders, the integrator,
// the film and the scene belong to it; the owner uses them only while the film is idle.
#pragma once

#include <atomic>
#include <thread>

#include "render/session_state.h"
#include "render/synchronized.h"

namespace ajar {

class SessionWorker {
 public:
  ~SessionWorker() { quit(); }

  Synchronized<SessionState>::Access state() const { return state_.lock(); }
  /// Ends the running job and does this one next; `abort_building`: even while the scene is being built. Returns the
  /// number of the job.
  uint64_t ask(Job job, bool abort_building);
  void cancel();
  /// Ends the thread.
  void quit();

 private:
  /// The data of a render in progress that only the worker uses.
  struct Render {
    Integrator& integrator;
    Film& film;
    ImagePlan* image_plan;  ///< null: all pixels get the same number of samples
    RenderSettings settings;
  };

  void work();
  void run(Job job);
  void build(Job& job);
  void replace_integrator(Job& job);
  std::unique_ptr<Integrator> choose(const CameraDescription& camera);
  uint32_t own_seed(const RenderSettings& settings);
  std::unique_ptr<ImagePlan> make_image_plan(const RenderSettings& settings, const GoalSupport& support, uint32_t seed);
  void prepare(std::unique_ptr<Integrator> chosen, Clock::time_point start);
  void render_all();
  void wait_while_paused();
  /// `cut`: the time limit has ended an iteration. Pixels then have different numbers of samples, and their error is
  /// not estimated again.
  void publish(double seconds, uint64_t done, bool cut);

  Synchronized<SessionState> state_;
  std::atomic<bool> stop_{false};  // stop rendering
  std::atomic<bool> stop_building_{false};
  std::string replaced_integrator_;  // label of the integrator that path tracing replaces; empty: none
  std::string replaced_for_;         // why
  Clock::time_point limit_start_;    // start of the time limit: the end of the build
  std::thread thread_;
};

}  // namespace ajar
