// Bidirectional path tracing as a way to find paths [Veach 1997, chapter 10]: a walk from the eye, one from a light,
// and every path that joining them gives, weighted by multiple importance sampling over all ways to find the same path.
//
// Strategy s has s vertices found from the light: 0 hits emission by chance, 1 samples a light at the eye walk's
// end, count - 1 joins the light walk to the lens (its paths land anywhere on the film). The lens is never hit.
// Russian roulette is in the throughputs, not in the densities of the weights, which then
// still sum to one.
#pragma once

#include <vector>

#include "transport/bidirectional/vertex_merging.h"
#include "transport/paths/walk.h"

namespace ajar {

/// One path found: s vertices from the light, t from the eye.
struct FoundPath {
  int s = 0, t = 0;
  Color contribution{0.0f};  ///< weight times f / p: an estimate of pixels^2 times radiance at `film`
  Vec2 film{0.0f};
  int hit = -1;  ///< s = 0: which of the lights met
};

class BidirectionalWalks {
 public:
  /// `light_walks`: light walks made for the whole film while each pixel^2 of it gets one eye walk. Paths that reach
  /// the lens directly (t = 1) are then as many, and their contributions are to be divided by it.
  BidirectionalWalks(const Scene& scene, double light_walks);

  /// Walk from the eye through `film` and from a light: all paths that carry light. Every call takes its numbers from
  /// the same dimensions of the sampler in the same order.
  const std::vector<FoundPath>& sample(Vec2 film, Sampler& sampler, SampleAux* aux = nullptr);
  /// Is it a path LS*E or L(D)S*E?
  bool is_direct(const FoundPath& path) const;
  float alpha() const { return alpha_; }
  /// Light by unconnectable paths in the last sample, when there is `merging`.
  Color merged() const { return merged_; }
  uint64_t rays() const { return rays_; }

  /// Copy the vertices of a path just found into `out`, light first, flags as in the path; returns how many. The edges'
  /// transmittance and probability of passing go to `edges`.
  int copy_path(const FoundPath& path, PathVertex* out, PathEdge* edges) const;

  /// Walk from a light only as far as the path can be unconnectable; visit(vertices before it, vertex, f / p, first
  /// shading point) for each place where a photon lies. Depths at `first` hold the scattering next to the light.
  template <class Visit>
  void walk_photon(Sampler& sampler, Visit&& visit) {
    for_photons_ = true;
    walk_from_light(sampler);
    for_photons_ = false;
    for (int j = 2; j < light_count_; ++j)
      if (light_[size_t(j - 1)].vertex.specular && light_[size_t(j)].vertex.connectable())
        visit(j, light_[size_t(j)].vertex, light_[size_t(j)].beta, light_[2].vertex.point);
  }
  /// Where a walk from the eye would merge; null where it would not.
  const PathVertex* find_merging_vertex(Vec2 film, Sampler& sampler);

  /// Unconnectable paths, where photons find them, are not among those found.
  bool leaves_unconnectable = false;
  /// Their light is in `merged`.
  const VertexMerging* merging = nullptr;
  /// What walks from lights follow besides; null: nothing.
  const LightWalkGuide* guide = nullptr;
  /// Light sampling also finds what lies beyond the terminator (shadow_terminator.h). Such paths are no paths of a
  /// PathSpace.
  bool finds_beyond_terminator = false;
  /// For tests: only the strategy with this many light vertices (-1: all), weighted as one of all.
  int only_strategy = -1;

 private:
  struct WalkVertex {
    PathVertex vertex;
    PathEdge edge;          ///< to the vertex before it in the walk
    Scattering scattering;  ///< where the walk went on
    Color beta{0.0f};       ///< f / p up to this vertex, its own scattering not included
    float fwd = 0.0f;       ///< density with which the walk found it
    float rev = 0.0f;       ///< density with which a walk the other way finds it, given the walk's next two vertices
  };
  struct LightHit {
    int t = 0;  ///< eye vertices before it
    Color contribution{0.0f};
    PathVertex light;
    PathEdge edge;
    float pdf = 0.0f;  ///< of the light vertex by the walk that met it
  };
  struct Densities;

  void walk_from_eye(Vec2 film, Sampler& sampler, SampleAux* aux);
  void walk_from_light(Sampler& sampler);
  void meet(int t, const PathVertex& light, const PathEdge& edge, Color beta, float pdf_direction);
  void find_by_hit(int index);
  void find_by_light_sample(int t, Sampler& sampler);
  void find_by_connection(int s, int t);
  void find_by_lens(int s);
  void found(int s, int t, Color contribution, Vec2 film, int hit);
  /// Is the path of the first t eye vertices and a light unconnectable, and not to be found here? `joined`: light was
  /// sampled at the last of them.
  bool leaves_out(int t, bool joined) const;
  /// Limits for kinds of bounces; `edge` is the one that joins the walks.
  float limits_factor(int s, int t, const PathEdge& edge) const;

  const Scene& scene_;
  double light_walks_;
  float margin_;  ///< of the film: half the width of the pixel filter
  int max_vertices_;
  std::vector<WalkVertex> eye_, light_;
  int eye_count_ = 0, light_count_ = 0;
  LightEnd light_end_;
  std::vector<LightHit> hits_;
  int hit_count_ = 0;
  std::vector<PathVertex> sampled_lights_;  ///< by t
  std::vector<PathEdge> sampled_edges_;
  PathVertex lens_;
  std::vector<PathEdge> connections_;  ///< of the paths found, in their order
  std::vector<FoundPath> found_;
  Vec2 film_{0.0f};
  float alpha_ = 0.0f;
  Color merged_{0.0f};
  bool for_photons_ = false;  ///< end walks from lights where a photon's path would
  uint64_t rays_ = 0;
};

}  // namespace ajar
