// Bidirectional path tracing [Veach 1997, chapter 10]: a walk from the eye, a walk from a light, and all paths that
// connect them, weighted by multiple importance sampling over all strategies that can find the same path.
//
// Strategy s has s vertices from the light:
//   s = 0          the eye walk hits emission
//   s = 1          a light is sampled at the end of the eye walk
//   s = count - 1  the light walk is connected to the lens; its paths can reach any point of the film
// No strategy hits the lens. Russian roulette is part of the throughputs but not of the densities in the weights, so
// that the weights still sum to one.
//
// Walks below surfaces: a walk from the eye that enters a surface with subsurface scattering continues at the point where
// the light leaves (media/subsurface_walk.h). No other walk can find this pair of points, so the strategies of such a path
// are those that connect it at the exit or later. The density of the part before is common to all of them and cancels in
// the weights. The walk from the eye samples the lobes that the path tracer would sample; the weights use the densities
// of all lobes, which depend only on the vertices. Other paths have the factor of eye_history.h.
//
// Surfaces that depend on the kind of the ray (shading/ray_kind_surfaces.h): walks from lights end at eye-only ones,
// connections do not pass them, and the walk from the eye continues as after an exit. On the last edge to a light, shadow
// rays pass such surfaces in one way, which walks from lights take too, and rays that hit the light in another. Both
// count with the weights of path tracing, which defines this light (weight_past_ray_kinds).
#pragma once

#include <optional>
#include <vector>

#include "transport/bidirectional/vertex_merging.h"
#include "transport/paths/light_passes.h"
#include "transport/paths/walk.h"

namespace ajar {

/// A path that was found: s vertices from the light, t from the eye.
struct FoundPath {
  int s = 0, t = 0;
  Color contribution{0.0f};  ///< weight times f / p: an estimate of radiance times pixels^2 at `film`
  Vec2 film{0.0f};
  int hit = -1;  ///< for s = 0: index of the light that was hit
};

/// Which paths are found. Eye-only are paths with walks below surfaces or by eye-only surfaces, which only walks from the
/// eye find up to the last such place, and paths whose edge to the light passes a surface that depends on the kind of the
/// ray.
enum class PathClasses : uint8_t {
  All,
  NotEyeOnly,  ///< those of a PathSpace
  EyeOnly,     ///< the others
  Diffuse      ///< as NotEyeOnly, but no light enters surfaces: the lobes are diffuse reflection, for photons
};

/// The light that light sampling finds, by the sides of the shadow terminator (shadow_terminator.h).
enum class SampledLights : uint8_t {
  BeforeTerminator,
  Both,
  BeyondTerminator  ///< no other paths are found, and none that are direct
};

class BidirectionalWalks {
 public:
  /// `light_walks`: number of light walks for the whole film per eye walk in each pixel^2. There are as many paths that
  /// reach the lens directly (t = 1), and their contributions are to be divided by this number.
  BidirectionalWalks(const Scene& scene, double light_walks);

  /// Walks from the eye through `film` and from a light, and returns all paths with a contribution. Every call takes
  /// its random numbers from the same dimensions of the sampler in the same order.
  const std::vector<FoundPath>& sample(Vec2 film, Sampler& sampler, SampleAux* aux = nullptr);
  /// Whether it is a path LS*E or L(D)S*E.
  bool is_direct(const FoundPath& path) const;
  float alpha() const { return alpha_; }
  /// Light by unconnectable paths in the last sample, if `merging` is set.
  Color merged() const { return merged_; }
  /// The passes of a path that the last sample has found.
  PathPasses passes_of(const FoundPath& path) const;
  /// The index of the light from which the last photon comes.
  uint32_t light_of_photon() const { return uint32_t(light_[0].vertex.light); }
  /// A walk from the eye alone: the light that media emit along it.
  Color sample_glow(Vec2 film, Sampler& sampler);
  /// Light that media emit, along the walk from the eye of the last sample. It is in no path found.
  Color glow() const { return glow_; }
  uint64_t rays() const { return rays_; }
  /// Paths that were left out because their contribution was not finite.
  uint64_t refused() const { return refused_; }

  /// Copies the vertices of a path of the last sample to `out`, light first, with flags as in the path, and returns
  /// their number. `edges` receives the transmittance of the edges and the probability of passing.
  int copy_path(const FoundPath& path, PathVertex* out, PathEdge* edges) const;

  /// Walks from a light while the path can be unconnectable. Calls visit(vertices before it, vertex, f / p, first
  /// shading point) for each vertex that stores a photon. The depths at `first` hold the scattering next to the light.
  template <class Visit>
  void walk_photon(Sampler& sampler, Visit&& visit) {
    for_photons_ = true;
    if (pass_time) time_ = *pass_time;
    walk_from_light(sampler);
    for_photons_ = false;
    for (int j = 2; j < light_count_; ++j)
      if (light_[size_t(j - 1)].vertex.specular && light_[size_t(j)].vertex.stores_photons())
        visit(j, light_[size_t(j)].vertex, light_[size_t(j)].beta, light_[2].vertex.point);
  }
  /// The vertex at which a walk from the eye would merge; null if there is none.
  const PathVertex* find_merging_vertex(Vec2 film, Sampler& sampler);

  /// Unconnectable paths that photons find are not returned.
  bool leaves_unconnectable = false;
  /// Finds their light, which `merged` returns; null: no merging.
  const VertexMerging* merging = nullptr;
  /// If the film separates light: receives that of merged() and glow(), and the albedo of the first surface.
  LightPasses passes;
  /// A guide that walks from lights follow in addition; null: none.
  const LightWalkGuide* guide = nullptr;
  /// The media of the scene, if it has any.
  const PathMedia* media = nullptr;
  /// Time of all paths, where photons of one time are looked up; empty: each sample draws its own.
  std::optional<float> pass_time;
  /// Paths by light beyond the terminator are not paths of a PathSpace.
  SampledLights sampled = SampledLights::BeforeTerminator;
  PathClasses classes = PathClasses::All;
  /// The point on the lens, if it is given.
  std::optional<Vec2> lens_point;
  /// Whether light can enter the first surface that the last walk from the eye met, or the surface is eye-only.
  bool enters_first() const { return enters_first_; }
  /// Whether a path of the last sample has walks below surfaces.
  bool is_below(const FoundPath& path) const { return path.t >= 2 && eye_[size_t(path.t - 1)].below; }

  /// For tests: return only the strategy with this many light vertices (-1: all). Its weight is the one among all
  /// strategies.
  int only_strategy = -1;

 private:
  /// Dimension of the sampler from which on connections draw, so that they are the same for walks of any length.
  static constexpr uint32_t kConnectionDimensions = 2048;
  struct WalkVertex {
    PathVertex vertex;
    PathEdge edge;          ///< to the vertex before it in the walk
    Scattering scattering;  ///< towards the next vertex of the walk
    Color beta{0.0f};       ///< f / p up to this vertex, without its own scattering
    float fwd = 0.0f;       ///< density with which this walk finds the vertex
    float rev = 0.0f;       ///< density with which the opposite walk finds it, given the next two vertices of this walk
    int exit = -1;          ///< of the eye: the last vertex up to here that only this walk finds; -1: none
    int collisions = 0;     ///< of the eye: vertices before it in media
    bool below = false;     ///< of the eye: light has left a surface up to here
    bool stays = false;     ///< of the eye: light enters some lobes here; the walk continues by the others, `staying_`
  };
  struct LightHit {
    int t = 0;  ///< eye vertices before it
    Color contribution{0.0f};
    PathVertex light;
    PathEdge edge;
    float pdf = 0.0f;  ///< density of the light vertex by the walk that hit it
  };
  struct Densities;

  bool follows_ray_kinds() const {
    return any_by_ray_kind_ && (classes == PathClasses::All || classes == PathClasses::EyeOnly);
  }
  /// Of the first edge of a walk from a light.
  RayKindSurfaces first_from_light() const {
    return follows_ray_kinds() && !for_photons_ ? RayKindSurfaces::AsShadow : RayKindSurfaces::FromLight;
  }
  /// Whether the walk from the eye has chosen one history of lobes, by which bounces are counted.
  bool knows_history() const { return (has_subsurface_ && classes != PathClasses::Diffuse) || follows_ray_kinds(); }
  void walk_from_eye(Vec2 film, Sampler& sampler, SampleAux* aux);
  void find_beyond_terminator(Sampler& sampler);
  static void arrive_at(WalkVertex& next, const PathVertex& previous, const Through& through, Color beta,
                        float pdf_direction);
  void begin_at_lens();
  void record_seen(const WalkVertex& at, int i, SampleAux*& aux);
  void merge(const WalkVertex& at, int i);
  void add_glow(Color light, int bounces);
  /// The light of a path of the last sample.
  const PathVertex& light_of(const FoundPath& path) const {
    return path.s == 0   ? hits_[size_t(path.hit)].light
           : path.s == 1 ? sampled_lights_[size_t(path.t)]
                         : light_[0].vertex;
  }
  float weight_of_first_edge(int s, const Scattering& at_end) const;
  bool scatters_at(int i, uint32_t base, Sampler& sampler);
  bool enters_surface(int i, uint32_t base, Sampler& sampler);
  bool leaves_class(int t, const PathEdge& light_edge) const;
  void walk_from_light(Sampler& sampler);
  std::optional<BsdfSample> sample_bounce(const PathVertex& vertex, TransportMode mode, Sampler& sampler) const;
  void meet_lamp(int t, const LightMet& met, Vec3 direction, const Through& before, Color beta, float pdf_direction);
  void meet_emitter(int t, const WalkVertex& at, float pdf_direction);
  Color emitted_in_media(const Ray& ray, float t_end, const PathVertex& vertex, Sampler& sampler) const;
  void meet(int t, const PathVertex& light, const PathEdge& edge, Color beta, float pdf_direction);
  bool is_limited(const PathVertex& light, int bounces) const {
    return any_limited_ && is_past_bounces(scene_, light, bounces);
  }
  void find_by_hit(int index);
  void find_by_light_sample(int t, Sampler& sampler);
  void find_by_connection(int s, int t);
  void find_by_lens(int s);
  /// `edge` connects the two walks.
  void found(const FoundPath& path, const PathEdge& edge);
  /// Whether the path of the first t eye vertices and a light is unconnectable and left to photons. `joined`: the light
  /// was sampled at the last of them.
  bool leaves_out(int t, bool joined) const;
  /// Factor of the limits for kinds of bounces. `edge` connects the two walks.
  float limits_factor(int s, int t, const PathEdge& edge) const;
  /// `weight` times the factor of what the path has been through.
  Color with_history(float weight, int s, int t, const PathEdge& edge) const;
  Color history_factor(int s, int t, const PathEdge& edge) const;
  /// The vertex at the end of the walk from the eye, with the lobes by which it scatters light to the eye.
  const PathVertex& scattering_end(int t) const {
    return eye_[size_t(t - 1)].stays ? staying_[size_t(t - 1)] : eye_[size_t(t - 1)].vertex;
  }
  /// Maximum number of vertices from the light of a path with this many vertices from the eye. In the class EyeOnly,
  /// no light walk is connected to the lens.
  int last_strategy(int count, int t) const {
    return count - 1 - std::max(eye_[size_t(t - 1)].exit, classes == PathClasses::EyeOnly ? 1 : 0);
  }

  const Scene& scene_;
  double light_walks_;
  float margin_;  ///< around the film: half the width of the pixel filter
  int max_vertices_;
  bool has_subsurface_, enters_after_diffuse_ = false, any_by_ray_kind_, any_limited_;  ///< of the scene
  std::vector<WalkVertex> eye_, light_;
  std::vector<PathVertex> staying_;  ///< of the eye; index: that of the vertex
  int eye_count_ = 0, light_count_ = 0;
  LightEnd light_end_;
  std::vector<LightHit> hits_;
  int hit_count_ = 0;
  std::vector<PathVertex> sampled_lights_;  ///< index: t
  std::vector<PathEdge> sampled_edges_;
  PathVertex lens_;
  std::vector<PathEdge> connections_;  ///< of the paths in `found_`, in the same order
  std::vector<FoundPath> found_;
  Vec2 film_{0.0f};
  float time_ = 0.0f;
  float alpha_ = 0.0f;
  Color merged_{0.0f}, glow_{0.0f};
  PathPasses first_;  ///< of the walk from the eye, by its first scattering
  bool enters_first_ = false;
  bool for_photons_ = false;  ///< the light walk ends where a photon's path would end
  uint64_t rays_ = 0, refused_ = 0;
};

}  // namespace ajar
