// One render from start to finish in its own threads. Final render, viewport and
// command line are the same loop with another stopping rule.
//
// A viewport goes on: `update` gives the session its scene as it is now, `change_view` another camera. Both return at
// once and end what runs by themselves. Of several that come while a scene is being built, the latest counts.
//
// The owner polls: `wait`, `snapshot`, `progress`, `error`. Nothing calls back into
// the owner. An exception in a thread surfaces once, as text, through `error`.
#pragma once

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

namespace ajar {

struct Progress {
  enum class Phase : uint8_t { Idle, Building, Rendering, Done, Cancelled, Failed } phase = Phase::Idle;
  std::string step;
  float fraction = 0.0f;   ///< of the whole, in [0, 1]
  double samples = 0.0;    ///< per pixel, mean
  uint64_t iteration = 0;  ///< of this render; from the first on there is a picture
  uint64_t render = 0;     ///< the number that `start`, `update` or `change_view` gave
  double build_seconds = 0.0, render_seconds = 0.0;
  double remaining_seconds = -1.0;  ///< until the first of the ends that the settings name; below 0: not known
  double estimated_relmse = -1.0, estimated_perceptual_error = -1.0;  ///< as the film estimates them
};

/// An estimate of the error, and when it was made.
struct ErrorPoint {
  double seconds, samples, relmse, perceptual;
};

class Session {
 public:
  Session();
  ~Session();  ///< cancels and joins
  Session(const Session&) = delete;

  /// Build the description and render it. Returns at once, with the number of this render.
  uint64_t start(SceneDescription description);
  /// The same for a scene that will be edited: meshes stay apart from their transforms, and what the description shares
  /// with the scene of before (MeshDescription::shared, images) is neither copied nor built again.
  uint64_t update(SceneDescription description);
  /// The scene at hand seen otherwise: nothing is built again. Of the settings, all but those of caustics.
  uint64_t change_view(const CameraDescription& camera, const RenderSettings& settings);
  /// Before `start`: go on from here. Its samples count towards those asked for.
  /// `scene` is the fingerprint of what will be rendered, 0 when it is not known; another than the checkpoint's is
  /// refused.
  void resume(Checkpoint from, uint64_t scene = 0);
  /// Before `start`: begin with what the frame before has learned. What does not suit is left aside; the plan says
  /// which and why. The render takes random numbers of its own, whatever its seed.
  void begin_with(std::shared_ptr<const Learned> learned);
  /// What the next frame may begin with, once a render is done; else null.
  std::shared_ptr<const Learned> learned() const;
  /// Everything found so far, at the last iteration boundary; nothing before the first. Asking once makes later ones be
  /// kept.
  std::optional<Checkpoint> checkpoint() const;
  void cancel();
  /// Let the render wait after the iteration it is in, or go on. A time limit does not count the time it waits. A
  /// cancel ends the wait.
  void pause(bool paused);
  bool is_paused() const;
  /// Wait until done or `seconds` have passed; true when done, cancelled or failed.
  bool wait(double seconds);
  Progress progress() const;
  /// The text of what went wrong, empty when nothing has; given once.
  std::string take_error();
  Diagnostics diagnostics() const;
  /// How the artist's light paths were attached; empty before the scene is built.
  std::vector<HintReport> hint_reports() const;

  /// Pass as floats at the last iteration boundary; empty before the first. Rows bottom up.
  std::vector<float> snapshot(const std::string& pass) const;
  /// At most so many photons of the last pass at the last iteration boundary, and how many there were; none from
  /// integrators without photons. While it renders, those of the boundary after one was asked: nothing is kept unless
  /// somebody asks.
  PhotonPoints photons(uint64_t most) const;
  int width() const;
  int height() const;

  /// The estimates of the error so far, the oldest first.
  std::vector<ErrorPoint> error_over_time() const;

  /// Everything `--ajar-stats` promises, as JSON text.
  std::string statistics_json() const;

 private:
  std::unique_ptr<class SessionWorker> worker_;
};

}  // namespace ajar
