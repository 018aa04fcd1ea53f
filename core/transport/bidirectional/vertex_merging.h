// Vertex merging: photons find the paths that bidirectional walks cannot connect.
//
// These are the paths E S+ (D S+)+ L and E S+ (D S+)+ D L (is_unconnectable, path_vertex.h): caustics of a lamp, or of
// a surface that it lights, seen in mirrors and through glass. S are events of delta lobes, which cannot be connected.
// No two of the other vertices are neighbours, except those at the light. A walk from the eye finds such a path only by
// hitting the lamp or the surface beside it: a rare sample with a very large weight. If lamps cannot be hit, it finds
// none. Integrators that leave these paths out of their integrand (BidirectionalWalks::leaves_unconnectable,
// PathSpace::without_unconnectable) get their light from here. Photons walk L [D] S+ (D S+)* and are stored where D may
// come next. The walk E S+ D from the eye merges with the photons around its *first* D [Jensen 2001; vertex merging of
// Georgiev et al. 2012]. A path has one first D from the eye, so each path is counted once.
//
// The estimate is consistent: each pass has its own photons, and radii decrease from pass to pass [Knaus and Zwicker
// 2011]. The light of a photon is divided by the surface that exists around it (photon_discs.h). Lamps, emissive
// triangles, suns and the bright spots of the environment send photons (sends_photons, path_vertex.h). Paths from even
// parts of the sky and from wide suns are left to the walks from the eye, which find them well, and so are those from
// lamps at which no walk starts (LightFlags::starts_walks). Limits of bounces apply to the whole path. At surfaces that
// mix kinds of lobes, the photon counts as the kind of the lobe that it drew.
#pragma once

#include <atomic>
#include <memory>

#include "transport/paths/path_vertex.h"
#include "transport/photons/photon_map.h"

namespace ajar {

class BidirectionalWalks;

struct MergingPlan {
  bool used = false;
  const char* reason = "";
};
/// Whether there may be unconnectable paths that photons find. The answer depends on materials, lights and bounce
/// limits alone.
MergingPlan plan_merging(const Scene& scene);

class VertexMerging {
 public:
  VertexMerging();
  ~VertexMerging();
  VertexMerging(const VertexMerging&) = delete;
  VertexMerging& operator=(const VertexMerging&) = delete;

  /// Has no cost if not `active`.
  void prepare(const Scene& scene, const PathMedia* media, bool active, uint32_t seed);
  bool active() const { return active_; }
  /// From now on photons follow hints. Call it after prepare and before the first pass.
  void follow(const LightWalkGuide* guide) { guide_ = guide; }
  /// Traces the photons of pass `index` (from 0) and sets their radius. Returns false when stopped. Must not run at the
  /// same time as lookups.
  bool begin_pass(uint32_t index, const std::atomic<bool>& stop);
  /// Light by unconnectable paths that leaves vertex number `place` of a walk from the eye (1: the first) towards the
  /// vertex before. There must be at least one vertex before it, and all of them must be specular.
  Color radiance(const PathVertex& vertex, int place) const;
  /// The part of it that is light of a light group of the scene.
  Color radiance_of_group(const PathVertex& vertex, int place, int group) const;

  uint64_t rays() const;
  /// Photons that were left out because their flux was not finite.
  uint64_t refused() const { return refused_; }
  size_t photons() const { return map_.size(); }
  size_t memory_bytes() const { return map_.memory_bytes() + behind_.capacity() * sizeof(Behind); }
  float radius() const { return radius_; }
  /// Time of the photons of the pass, and of the paths that look them up; 0 where nothing moves.
  float time() const { return time_; }

 private:
  /// Vertices before the photon in its path, and its scattering events by kind without the one next to the light.
  struct Behind {
    uint8_t vertices, diffuse, glossy, transmission;
    uint32_t light;  ///< where the photon comes from
  };
  struct Workers;

 public:
  /// Memory of a photon in addition to the photon itself: in the map, and in the list from which the next map is built.
  static constexpr size_t kBytesBehind = 2 * sizeof(Behind);

 private:
  bool trace(uint32_t index, std::vector<Photon>& photons, std::vector<Behind>& behind, const std::atomic<bool>& stop);
  float choose_first_radius() const;
  float counted(const PathVertex& vertex, int place, const Behind& behind, Vec3 to_light) const;

  const Scene* scene_ = nullptr;
  const PathMedia* media_ = nullptr;
  bool active_ = false;
  const LightWalkGuide* guide_ = nullptr;
  uint32_t seed_ = 0, passes_done_ = 0;
  int max_vertices_ = 0;
  uint64_t refused_ = 0;
  std::unique_ptr<Workers> workers_;
  PhotonMap map_;
  std::vector<Behind> behind_;
  float first_radius_ = 0.0f, radius_ = 0.0f, time_ = 0.0f;
};

}  // namespace ajar
