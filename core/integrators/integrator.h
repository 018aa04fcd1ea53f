// The interface of all rendering algorithms.
//
// `prepare` is called once, then iterations follow. Each iteration adds an estimate of the same image to the film and
// ends soon (well below a second per megapixel and core). The image determines the units of work, and chains are
// numbered, so the same seed gives the same image for any number of threads.
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

class DirectPass;      // transport/bidirectional/direct_pass.h
class FollowedHints;   // transport/hints/followed_hints.h
class PathMedia;       // transport/media/path_media.h
struct MediaCounters;  // transport/media/media.h
struct Learned;        // integrators/learned.h

enum class Bias : uint8_t { Unbiased, Consistent, Biased };

/// Which goals of the film an integrator can follow (film/image_plan.h).
struct GoalSupport {
  /// If goals are set, `run_iteration` gives each pixel the samples that its goal asks for, and `samples_per_pixel` is
  /// their mean.
  bool follows = false;
  /// Samples of an iteration share data that was made for it: the goal of the average pixel must grow by one sample at
  /// a time.
  bool by_passes = false;
  /// Pixels learn from each other, so that the plan's proof does not apply: the image is consistent.
  bool learns = false;
  /// All pixels must have this many samples before goals may differ. Until then iterations end at each quarter of this
  /// number.
  uint32_t equal = 0;
};

struct IntegratorStatistics {
  uint64_t rays = 0;  ///< closest-hit and shadow rays
  uint64_t paths = 0;
  std::map<std::string, double> extra;
  std::vector<HintStatistics> hints;  ///< of integrators that follow hints: all hints that are enabled, attached or not
};

/// A part of what an earlier frame has learned, and why it is not used; empty if it is used.
struct LearnedPart {
  std::string name, why_not;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  virtual Bias bias() const = 0;
  /// `plan`: of this scene. The integrator follows its decisions and makes none of them again. It keeps the scene, not
  /// the plan.
  virtual void prepare(std::shared_ptr<const Scene> scene, const RenderPlan& plan, uint32_t seed) = 0;
  /// The same with the plan that follows from the scene's settings.
  void prepare(std::shared_ptr<const Scene> scene, uint32_t seed) {
    const RenderPlan plan = make_render_plan(*scene);
    prepare(std::move(scene), plan, seed);
  }
  /// Called after `prepare`: starts with what an earlier frame has learned, and returns which parts are used.
  virtual std::vector<LearnedPart> begin_with(const Learned& /*learned*/) { return {}; }
  /// Called when this frame is complete: adds what the next frame can start with.
  virtual void hand_on(Learned& /*learned*/) {}
  /// Called after `prepare`: the samples of this render have the numbers from `first` on, in a film that begins at the
  /// same one. Returns false, and changes nothing, if samples depend on those before them.
  virtual bool begin_at(uint32_t /*first*/) { return false; }
  /// Called after `prepare`.
  virtual GoalSupport goal_support() const { return {}; }
  /// Adds `samples_per_pixel` samples per pixel (on average) to the film. Returns early when `stop` is set; every pixel
  /// then has whole samples only.
  virtual void run_iteration(Film& film, int samples_per_pixel, const std::atomic<bool>& stop) = 0;
  virtual IntegratorStatistics statistics() const = 0;
  /// At most `max_count` photons of the last pass, for display. Empty for integrators that store none. Called between
  /// iterations.
  virtual PhotonPoints photons(uint64_t /*max_count*/) const { return {}; }
};

/// The bias of an integrator that adds this direct light to the light of chains, whose own bias is `chains`.
Bias bias_with(const DirectPass& direct, Bias chains);
/// Adds the rays of all passes and the sizes of the last one. These are rays of photons, of which a small image has
/// more per pixel.
void add_statistics_of(const VertexMerging& merging, IntegratorStatistics& statistics);
/// The same, and the rays of EyeOnlyLight and LightBeyond. These are part of the direct pass's rays.
void add_statistics_of(const DirectPass& direct, IntegratorStatistics& statistics);
/// Memory and counters of media.
void add_statistics_of(const MediaCounters& counters, size_t bytes, IntegratorStatistics& statistics);
/// The same for the media of paths; null: there are none.
void add_statistics_of(const PathMedia* media, IntegratorStatistics& statistics);
/// Adds the rays by which the shares of hints were learned.
void add_statistics_of(const FollowedHints& followed, IntegratorStatistics& statistics);

struct IntegratorInfo {
  const char* name;
  int number;         ///< in .blend files; it is never used again for another integrator
  const char* label;  ///< in the UI
  Bias bias;
  const char* sentence;  ///< one sentence for the artist
  std::unique_ptr<Integrator> (*make)();
  bool knows_parts = false;            ///< renders the passes that consist of SampleParts
  bool knows_groups = false;           ///< renders the passes of light groups
  bool follows_light_bounces = false;  ///< follows Max Bounces of lights
  /// Can use vertex merging (transport/bidirectional/vertex_merging.h), which makes it consistent.
  bool can_merge = false;
  bool follows_hints = false;          ///< follows the artist's light hints (transport/hints/hint_guide.h)
  bool automatic = false;              ///< stands for the choice of a technique (choice/technique_choice.h)
  bool has_direct_methods = false;     ///< samples direct light by the method of the settings
  bool can_guide = false;              ///< supports path guiding (transport/guiding/path_guide.h)
  bool gathers_photons = false;        ///< stores photons and looks them up
  bool takes_further_samples = false;  ///< see transport/bidirectional/further_samples.h
  bool samples_lens_light = false;     ///< see transport/bidirectional/lens_light.h
  bool splats = false;                 ///< paths contribute to other pixels than the one in which they start
  bool stores_records = false;         ///< stores irradiance records
  bool bakes = false;                  ///< needs no more of the camera than its rays (CameraKind::Texels)
};
/// All integrators, in the order of the UI.
const std::vector<IntegratorInfo>& integrator_list();
/// Throws SceneError with the valid names for an unknown name.
const IntegratorInfo& find_integrator(const std::string& name);
std::unique_ptr<Integrator> make_integrator(const std::string& name);

}  // namespace ajar
