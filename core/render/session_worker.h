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
#include "view/view_pictures.h"

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
    Mixture::Part only;     ///< the first technique of a mixture
    ImagePlan* image_plan;  ///< of its film; null: all pixels get the same number of samples
    Mixture* mixture;       ///< null: there is one technique
    RenderSettings settings;
  };

  void work();
  void run(Job job);
  void build(Job& job);
  void use_path_tracing_where_others_fail(Job& job);
  void ignore_clamping_of_auto(Job& job);
  std::unique_ptr<Integrator> choose(const CameraDescription& camera);
  std::unique_ptr<Mixture> make_mixture(const std::shared_ptr<const Scene>& scene, Mixture::Part first, uint32_t seed);
  void share_work(Mixture& mixture, uint64_t done, int& samples);
  uint32_t own_seed(const RenderSettings& settings);
  std::unique_ptr<ImagePlan> make_image_plan(const RenderSettings& settings, const GoalSupport& support, uint32_t seed);
  void prepare(std::unique_ptr<Integrator> chosen, Clock::time_point start);
  PlanSteps take_range(const std::shared_ptr<const Scene>& scene, const RenderPlan& plan, Integrator& chosen,
                       std::unique_ptr<Film>& film, uint32_t& seed);
  void keep_checkpoint(SessionState& state);
  void render_all();
  /// `done`: samples per pixel of all techniques.
  int run_iteration(Render& render, double elapsed, uint64_t done, const std::atomic<bool>* deadline);
  void render_view(const CameraDescription& camera, Clock::time_point start);
  void begin_view(const RenderSettings& settings);
  bool changes_technique(uint64_t done, double seconds);
  void render_by_choice();
  /// Makes a picture of the film if it is time for one; `done`: samples per pixel, `last`: no more follow.
  void show_picture(uint64_t done, bool last);
  void add_surfaces(const DenoiserInput& input, ViewPicture& picture);
  std::vector<float> picture_of(const DenoiserInput& input, uint64_t done, double rays, int threads,
                                std::string& why_not);
  void wait_while_paused();
  /// `cut`: the time limit has ended an iteration. Pixels then have different numbers of samples, and their error is
  /// not estimated again.
  void publish(double seconds, uint64_t done, bool cut);

  Synchronized<SessionState> state_;
  std::atomic<bool> stop_{false};  // stop rendering
  std::atomic<bool> stop_building_{false};
  std::string replaced_integrator_;    // label of the integrator that path tracing replaces; empty: none
  std::string replaced_because_;       // what it does not render
  bool ignores_clamping_ = false;      // the settings ask for it
  Clock::time_point limit_start_;      // start of the time limit: the end of the build
  double cpu_start_ = 0.0;             // CPU time of the process at the end of the build
  Clock::time_point checkpoint_time_;  // of the last checkpoint that was kept
  double checkpoint_seconds_ = 0.0;    // that it took
  ViewLevel level_{0, false};          // of the picture that is rendered for a view; divider 0: there are no pictures
  CameraDescription view_camera_;      // of these pictures
  RenderSettings view_settings_;       // of the picture of the full size
  /// The technique that a pilot has chosen for the present scene in a view with `auto`.
  struct ViewChoice {
    std::string integrator;
    PlanSteps steps;
    Learned::Choice place;
  };
  std::optional<ViewChoice> view_choice_;
  bool awaits_choice_ = false;       // the picture is path traced until the view has been still for a while
  Clock::time_point pictures_from_;  // no pictures of the present technique before
  uint64_t next_picture_ = 1;        // number of samples per pixel at which the next picture is made
  ViewSchedule schedule_;
  ViewDenoiser denoiser_;
  std::thread thread_;
};

}  // namespace ajar
