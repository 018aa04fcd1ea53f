// What a session's worker and its owner share: what was asked, and what has been found so far. Guarded by one lock
// (synchronized.h); functions that take a `SessionState&` need it.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "film/film.h"
#include "film/image_plan.h"
#include "integrators/integrator.h"
#include "integrators/learned.h"
#include "render/checkpoint.h"
#include "render/clock.h"
#include "render/session.h"
#include "render/stopping_policy.h"

namespace ajar {

/// What the owner asked for and the worker has not begun.
struct Job {
  uint64_t number = 0;
  std::optional<SceneDescription> description;  ///< else the scene at hand
  bool keep = false;                            ///< what is shared with the scene of before
  CameraDescription camera;                     ///< these two when there is no description
  RenderSettings settings;
};

struct SessionState {
  // ---- Of the owner --------------------------------------------------------------------------
  std::optional<Job> next;
  uint64_t last_number = 0;
  bool quit = false, paused = false;
  bool busy = false;                         ///< the worker has a job
  bool checkpoint_wanted = false;            ///< keep one at every iteration boundary
  std::set<std::string> wanted{"Combined"};  ///< passes to resolve at the next boundary
  uint64_t wanted_photons = 0;               ///< that somebody looks at
  std::optional<Checkpoint> base;            ///< what this render goes on from
  uint64_t scene_fingerprint = 0;
  std::shared_ptr<const Learned> learned;  ///< in the frame before

  // ---- Of the render -------------------------------------------------------------------------
  RenderSettings settings;
  int threads = 0;
  std::shared_ptr<Scene> scene;                ///< changed by the worker alone, while nothing renders
  std::shared_ptr<const AttachedHints> hints;  ///< of the scene
  std::unique_ptr<Integrator> integrator;      ///< the worker's, while it renders
  std::unique_ptr<Film> film;                  ///< the worker's, until it is idle
  std::unique_ptr<ImagePlan> image_plan;       ///< none: all pixels get the same number of samples
  bool film_idle = false;                      ///< no thread writes to the film: it may be resolved directly
  uint32_t seed = 0;                           ///< in use: a resumed render has its own
  std::string integrator_name;
  PlanSteps plan;
  PlanSteps technique_steps;              ///< how the technique was chosen
  std::optional<Learned::Choice> choice;  ///< of the technique
  double pilot_seconds = 0.0;
  StoppingPolicy policy;

  // ---- Found so far --------------------------------------------------------------------------
  Progress progress;
  std::string error;
  Diagnostics diagnostics;
  IntegratorStatistics statistics;
  std::vector<ErrorPoint> error_over_time;
  Film::SampleCounts sample_counts{};  ///< of the film at the last iteration boundary
  uint64_t film_bytes = 0;
  std::map<std::string, std::vector<float>> published;
  std::optional<Checkpoint> published_checkpoint;
  PhotonPoints published_photons;

  bool finished() const { return !next && !busy; }
  double samples_before() const { return base ? base->samples : 0.0; }

  /// A new render: nothing of the one before is shown as this one's.
  void begin(const Job& job);
  void warn(const std::string& message) { report_once(diagnostics, {Diagnostic::Severity::Warning, "", message}); }
  void measure_film();
  /// A pass of everything so far, that of a render resumed included. While nothing writes to the film.
  std::vector<float> resolve(const std::string& pass) const;
  Checkpoint checkpoint() const;
};

}  // namespace ajar
