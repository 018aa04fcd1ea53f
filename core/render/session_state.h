// The state that the worker and the owner of a session share: requests, and results so far. One lock guards it
// (synchronized.h). Functions that take a `SessionState&` need the lock.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "choice/mixture.h"
#include "denoise/shown_error.h"
#include "film/film.h"
#include "film/image_plan.h"
#include "integrators/integrator.h"
#include "integrators/learned.h"
#include "render/checkpoint.h"
#include "render/clock.h"
#include "render/session.h"
#include "render/stopping_policy.h"
#include "view/view_pictures.h"

namespace ajar {

/// A request of the owner that the worker has not started.
struct Job {
  uint64_t number = 0;
  std::optional<SceneDescription> description;  ///< none: the present scene
  bool keep = false;                            ///< keep what the description shares with the previous scene
  bool final = false;                           ///< a render from start to finish, not a view that changes
  CameraDescription camera;                     ///< used with `settings` if there is no description
  RenderSettings settings;
};

struct SessionState {
  // ---- Of the owner --------------------------------------------------------------------------
  std::optional<Job> next;
  uint64_t last_number = 0;
  bool quit = false, paused = false;
  bool busy = false;                         ///< the worker has a job
  bool shows_pictures = false;               ///< later jobs that are no final renders make pictures for a view
  bool checkpoint_wanted = false;            ///< keep one at every iteration boundary
  std::set<std::string> wanted{"Combined"};  ///< passes to resolve at the next boundary
  uint64_t wanted_photons = 0;               ///< number of photons that the owner has requested
  std::optional<Checkpoint> base;            ///< the checkpoint from which this render continues
  uint64_t scene_fingerprint = 0;
  std::optional<uint32_t> first_sample;    ///< number of the first sample; none: the render has no range of its own
  std::shared_ptr<const Learned> learned;  ///< in the previous frame

  // ---- Of the render -------------------------------------------------------------------------
  RenderSettings settings;
  int threads = 0;
  std::shared_ptr<Scene> scene;                ///< changed only by the worker, while nothing renders
  std::shared_ptr<const AttachedHints> hints;  ///< of the scene
  std::unique_ptr<Integrator> integrator;      ///< belongs to the worker while it renders
  std::unique_ptr<Film> film;                  ///< belongs to the worker until it is idle
  std::unique_ptr<ImagePlan> image_plan;       ///< null: all pixels get the same number of samples
  Learned::Mixed mixed;                        ///< techniques of the render
  double samples_of_work = 1.0;                ///< chosen with them, as in Learned
  std::unique_ptr<Mixture> mixture;            ///< null: there is one technique. Belongs to the worker as the film does
  bool film_idle = false;                      ///< no thread writes to the film: it may be resolved directly
  uint32_t seed = 0;                           ///< in use: a resumed render has its own
  uint64_t view_fingerprint = 0;               ///< 0: unknown
  std::optional<SampleRange> range;            ///< its seed and first sample; none: the render has no range
  /// The description of the checkpoint whose sums the film continues. Its samples are in the film.
  std::optional<Checkpoint> continued;
  uint32_t samples_in_film = 0;  ///< before this render, in each pixel
  std::string integrator_name;
  PlanSteps plan;
  PlanSteps technique_steps;              ///< how the technique was chosen
  std::optional<Learned::Choice> choice;  ///< of the technique
  double pilot_seconds = 0.0;
  double cpu_seconds = 0.0;  ///< of the process since the scene was built, in all threads
  StoppingPolicy policy;

  // ---- Results so far ------------------------------------------------------------------------
  Progress progress;
  std::string error;
  Diagnostics diagnostics;
  IntegratorStatistics statistics;
  std::vector<ErrorPoint> error_over_time;
  Film::SampleCounts sample_counts{};  ///< of the film at the last iteration boundary
  uint64_t film_bytes = 0;
  uint64_t refused = 0;  ///< samples without a finite value
  std::map<std::string, std::vector<float>> published;
  std::optional<Checkpoint> published_checkpoint;
  PhotonPoints published_photons;
  std::optional<ViewPicture> picture;  ///< of the last request, not taken yet

  bool finished() const { return !next && !busy; }
  double samples_before() const { return base ? base->samples : 0.0; }

  /// Starts a new render. Results of the previous one are not shown as its results.
  void begin(const Job& job);
  /// Forgets the film and what belongs to it. The number of the iteration is kept.
  void begin_film();
  void warn(const std::string& message) { report_once(diagnostics, {Diagnostic::Severity::Warning, "", message}); }
  void measure_film();
  /// A pass of all samples so far, including those of a checkpoint. Only while nothing writes to the film.
  std::vector<float> resolve(const std::string& pass) const;
  /// Those of the technique that has photons.
  PhotonPoints photons(uint64_t max_count) const;
  /// The passes for a denoiser; guides only if the settings ask for them. Only while nothing writes to the film.
  DenoiserInput denoiser_input() const;
  /// The range of samples that the owner asks for, or the one of the checkpoint.
  std::optional<SampleRange> wanted_range(const RenderSettings& s) const;
  Checkpoint checkpoint_of_film() const;  ///< of the samples of the film alone
  Checkpoint checkpoint() const;
};

/// The statistics of a render as JSON text: all values of `--ajar-stats`.
std::string statistics_json(const SessionState& state);
/// Those of the render so far, with damage that it has found in the texture cache.
Diagnostics diagnostics_of(const SessionState& state);

}  // namespace ajar
