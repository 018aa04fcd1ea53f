// One render from start to finish in its own threads. Final render, viewport and command line are the same loop with
// different stopping rules.
//
// In a viewport, `update` gives the session the present scene, and `change_view` another camera. Both return
// immediately and end the running job. If several requests arrive while a scene is being built, the latest counts.
//
// The owner polls: `wait`, `snapshot`, `progress`, `take_error`. Nothing calls back into the owner. An exception in a
// thread is reported once, as text, by `take_error`.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "film/film.h"
#include "integrators/integrator.h"
#include "integrators/render_plan.h"
#include "render/checkpoint.h"
#include "transport/hints/hints.h"
#include "view/view_pictures.h"

namespace ajar {

struct Progress {
  enum class Phase : uint8_t { Idle, Building, Rendering, Done, Cancelled, Failed } phase = Phase::Idle;
  std::string step;
  float fraction = 0.0f;   ///< of the whole render, in [0, 1]
  double samples = 0.0;    ///< per pixel, mean
  uint64_t iteration = 0;  ///< of this render; there is an image after the first
  uint64_t render = 0;     ///< the number that `start`, `update` or `change_view` returned
  double build_seconds = 0.0, render_seconds = 0.0;
  double remaining_seconds = -1.0;  ///< until the first end in the settings; negative: unknown
  double estimated_relmse = -1.0, estimated_perceptual_error = -1.0;  ///< estimated by the film
  /// Of the denoised image. Estimated only if it can end the render (denoise/shown_error.h).
  double denoised_relmse = -1.0;

  /// The estimated error of the image that the artist sees; negative: unknown.
  double shown_relmse() const {
    if (denoised_relmse < 0.0) return estimated_relmse;
    return estimated_relmse < 0.0 ? denoised_relmse : std::min(denoised_relmse, estimated_relmse);
  }
};

/// An estimate of the error, and its time.
struct ErrorPoint {
  double seconds, samples, relmse, perceptual;
};

/// Of a pass; the numbers are 0 if there is no image.
struct PassSize {
  int width = 0, height = 0, channels = 0;
};

class Session {
 public:
  Session();
  ~Session();  ///< cancels and joins
  Session(const Session&) = delete;

  /// Builds the description and renders it. Returns immediately, with the number of this render.
  uint64_t start(SceneDescription description);
  /// The same for the next frame of an animation: what the description shares with the scene before is kept, as in
  /// `update`.
  uint64_t next_frame(SceneDescription description);
  /// The same for a scene that will be edited: meshes stay separate from their transforms, and data that the
  /// description shares with the previous scene (MeshDescription::shared, images) are neither copied nor built again.
  uint64_t update(SceneDescription description);
  /// Renders the present scene with another camera and other settings, except those of caustics. Nothing is built
  /// again.
  uint64_t change_view(const CameraDescription& camera, const RenderSettings& settings);
  /// Before `start`: continue from this checkpoint. Its samples count towards the requested ones. `scene` is the
  /// fingerprint of the scene that will be rendered, 0 if it is unknown. A checkpoint with another fingerprint is
  /// refused.
  void resume(Checkpoint from, uint64_t scene = 0);
  /// Before `start`: the samples of each pixel have the numbers from `first` on, and the checkpoint keeps their sums, so
  /// that renders of other ranges with the same seed add up to one render (render/checkpoint.h). If samples depend on each
  /// other, the render gets a seed of its own instead; the plan states why. A checkpoint of a range is continued in it.
  void begin_at(uint32_t first);
  /// Before `start`: begin with what the previous frame has learned. Parts that do not fit are not used; the plan lists
  /// them with the reason. The render uses its own random numbers, whatever its seed.
  void begin_with(std::shared_ptr<const Learned> learned);
  /// What the next frame can begin with, once a render is done; null before that.
  std::shared_ptr<const Learned> learned() const;
  /// Everything so far, at a recent iteration boundary; empty before the first. After the first call, later checkpoints
  /// are kept, as often as takes a twentieth of the time.
  std::optional<Checkpoint> checkpoint() const;
  void cancel();
  /// Lets the render wait after the present iteration, or continue. The time limit does not count this time. A cancel
  /// ends the wait. The first iteration is always rendered.
  void pause(bool paused);
  bool is_paused() const;
  /// Whether the following renders of `update` and `change_view` make denoised pictures for a view, from coarse ones to
  /// those of the size in the settings (view/view_pictures.h). The guides need not be in the settings. Without a
  /// denoiser the pictures are noisy, and the diagnostics say so.
  void show_pictures(bool shown);
  /// The newest picture of the render that was asked for last. It is returned only once.
  std::optional<ViewPicture> take_picture();
  /// Waits until the render is done or `seconds` have passed. Returns true if it is done, cancelled or failed.
  bool wait(double seconds);
  Progress progress() const;
  /// The text of an error, empty if there is none. It is returned only once.
  std::string take_error();
  Diagnostics diagnostics() const;
  /// How the artist's light hints were attached; empty before the scene is built.
  std::vector<HintReport> hint_reports() const;

  /// A pass as floats at the last iteration boundary; empty before the first. Rows from the bottom up.
  /// `size`: if given, receives that of the pass.
  std::vector<float> snapshot(const std::string& pass, PassSize* size = nullptr) const;
  /// Up to `max_photons` photons of the last pass at the last iteration boundary, and their total number; empty for
  /// integrators without photons. Photons are kept only on request, so during a render the result is that of the first
  /// boundary after a request.
  PhotonPoints photons(uint64_t max_photons) const;
  int width() const;
  int height() const;

  /// The estimates of the error so far, in the order of time.
  std::vector<ErrorPoint> error_over_time() const;

  /// The statistics of `--ajar-stats`, as JSON text.
  std::string statistics_json() const;

 private:
  std::unique_ptr<class SessionWorker> worker_;
};

}  // namespace ajar
