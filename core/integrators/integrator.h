// What every rendering algorithm looks like from outside.
//
// prepare once, then iterations; each iteration adds an estimate of the same image
// to the film and ends soon (well below a second per megapixel and core). Work units are fixed by the image and
// chains are numbered, so the same seed gives the same image for any number of threads.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "film/film.h"
#include "integrators/render_plan.h"
#include "scene/scene.h"
#include "transport/hints/hints.h"
#include "transport/photons/photon_points.h"

namespace ajar {

class FollowedHints;  // transport/hints/followed_hints.h
struct Learned;       // integrators/learned.h

enum class Bias : uint8_t { Unbiased, Consistent, Biased };

/// How an integrator heeds the film's goals (film/image_plan.h).
struct GoalSupport {
  /// `run_iteration` gives each pixel the samples that goals ask for, if any are set; their mean then is what
  /// `samples_per_pixel` says
  bool follows = false;
  /// samples of an iteration share what was made for it: the average pixel's goal must grow by one sample at a time
  bool by_passes = false;
  /// pixels learn from each other, so that the plan's proof does not hold: the picture is consistent
  bool learns = false;
  /// all pixels must have so many samples before goals may differ, and iterations until then end at each quarter of
  /// them
  uint32_t equal = 0;
};

struct IntegratorStatistics {
  uint64_t rays = 0;  ///< closest-hit and shadow rays
  uint64_t paths = 0;
  std::map<std::string, double> extra;
  std::vector<HintStatistics> hints;  ///< of integrators that follow them: all that are switched on, attached or not
};

/// A part of what an earlier frame has learned, and why it is not used; used where there is no reason.
struct LearnedPart {
  std::string name, why_not;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual Bias bias() const = 0;
  /// `plan`: of this scene; who renders decides nothing that stands in it. The integrator keeps the scene, not the
  /// plan.
  virtual void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) = 0;
  /// The same with the plan that the scene's settings lead to.
  void prepare(std::shared_ptr<const Scene> scene, uint32_t seed) {
    const RenderPlan plan = make_render_plan(*scene);
    prepare(std::move(scene), plan, seed);
  }
  /// After `prepare`: begin with what an earlier frame has learned, and say with which parts.
  virtual std::vector<LearnedPart> begin_with(const Learned& /*learned*/) { return {}; }
  /// Add what the next frame may begin with. When this one is done.
  virtual void hand_on(Learned& /*learned*/) {}
  /// After `prepare`.
  virtual GoalSupport goal_support() const { return {}; }
  /// Add `samples_per_pixel` samples per pixel (on average) to the film. Returns early, leaving
  /// whole pixels consistent, when `stop` is raised.
  virtual void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) = 0;
  virtual IntegratorStatistics statistics() const = 0;
  /// At most so many photons of the last pass, for people to look at; none from integrators that store none. Between
  /// iterations.
  virtual PhotonPoints photons(uint64_t /*most*/) const { return {}; }
};

/// Rays, and what the last pass had. The rays are those of photons, of which a small picture has more than its share.
void add_statistics_of(const VertexMerging& merging, IntegratorStatistics& statistics);
/// Rays that learned what hints bring.
void add_statistics_of(const FollowedHints& followed, IntegratorStatistics& statistics);

struct IntegratorInfo {
  const char* name;
  const char* label;  ///< in the UI
  Bias bias;
  const char* sentence;  ///< one sentence for the artist
  std::unique_ptr<Integrator> (*make)();
  bool joins_camera = false;    ///< joins paths from lights to the camera
  bool renders_motion = false;  ///< its paths have times
  bool knows_parts = false;     ///< gives the passes made of SampleParts
  /// knows vertex merging (transport/bidirectional/vertex_merging.h); with it, it is consistent
  bool can_merge = false;
  bool renders_media = false;    ///< light scatters between surfaces, too
  bool renders_strands = false;  ///< of hair, whose ribbons lie otherwise for each ray
  bool follows_hints = false;    ///< that the artist has drawn (transport/hints/hint_guide.h)
};
/// The one list of integrators, in the order of the UI.
const std::vector<IntegratorInfo>& integrator_list();
/// Why this integrator cannot render the scene, as a clause for the artist; empty when it can.
std::string reason_against(const IntegratorInfo& integrator, const Scene& scene);
/// Throws SceneError naming the valid ones for an unknown name.
const IntegratorInfo& find_integrator(const std::string& name);
std::unique_ptr<Integrator> make_integrator(const std::string& name);

}  // namespace ajar
