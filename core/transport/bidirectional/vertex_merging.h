// What no connection finds is found by merging: photons for the paths that bidirectional walks cannot join.
//
// Paths E S+ (D S+)+ L and E S+ (D S+)+ D L (is_unconnectable, path_vertex.h): caustics seen in mirrors and through
// glass, of the lamp or of something that it lights. S are events of delta lobes, which connect to nothing, and no two
// of the other vertices are neighbours but those at the light. A walk from the eye finds them only by coming upon the
// lamp, or what shines beside it, by chance: rare samples of enormous weight; from lamps that cannot be hit, nothing.
// Integrators that leave these paths out of their integrand (BidirectionalWalks::leaves_unconnectable,
// PathSpace::without_unconnectable) get them back from here: photons walk L [D] S+ (D S+)* and lie where D may come
// next, and the eye's walk E S+ D merges with those around its *first* D [Jensen 2001; vertex merging of Georgiev et
// al. 2012]. A path has one first D from the eye, so each is counted once.
//
// Consistent: each pass has photons of its own, and radii shrink from pass to pass [Knaus and Zwicker 2011]. Only lamps
// and emissive triangles at finite places send photons; under a sky or a sun such paths stay with the walks from the
// eye. Limits of bounces hold for the whole path; at surfaces that mix kinds of lobes the photon's side counts the lobe
// it drew.
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
/// Whether there may be such paths that photons find; by materials and lights alone, whatever the settings ask for.
MergingPlan plan_merging(const Scene& scene);

class VertexMerging {
 public:
  VertexMerging();
  ~VertexMerging();
  VertexMerging(const VertexMerging&) = delete;
  VertexMerging& operator=(const VertexMerging&) = delete;

  /// Where it is not `active` it costs nothing.
  void prepare(const Scene& scene, bool active, uint32_t seed);
  bool active() const { return active_; }
  /// Photons follow hints from now on. After prepare, before the first pass.
  void follow(const LightWalkGuide* guide) { guide_ = guide; }
  /// Photons of pass `index` (from 0), and the radius they have. False when stopped. Not while others look up.
  bool begin_pass(uint32_t index, const std::atomic<bool>& stop);
  /// Light by unconnectable paths that leaves vertex `place` of a walk from the eye (1: the first it meets) towards
  /// where it came from. All vertices before it must have been specular, and there must be one.
  Color radiance(const PathVertex& vertex, int place) const;

  uint64_t rays() const;
  size_t photons() const { return map_.size(); }
  size_t memory_bytes() const { return map_.memory_bytes() + behind_.capacity() * sizeof(Behind); }
  float radius() const { return radius_; }

 private:
  /// Vertices of a photon's path before the photon, and its scatterings by kind but for the one next to the light.
  struct Behind {
    uint8_t vertices, diffuse, glossy, transmission;
  };
  struct Workers;

 public:
  /// Of a photon, besides the photon, in the map and in the list that the next map is made from.
  static constexpr size_t kBytesBehind = 2 * sizeof(Behind);

 private:
  bool trace(uint32_t index, std::vector<Photon>& photons, std::vector<Behind>& behind, const std::atomic<bool>& stop);
  float choose_first_radius() const;
  float counted(const PathVertex& vertex, int place, const Behind& behind, Vec3 to_light) const;

  const Scene* scene_ = nullptr;
  bool active_ = false;
  const LightWalkGuide* guide_ = nullptr;
  uint32_t seed_ = 0, passes_done_ = 0;
  int max_vertices_ = 0;
  std::unique_ptr<Workers> workers_;
  PhotonMap map_;
  std::vector<Behind> behind_;
  float first_radius_ = 0.0f, radius_ = 0.0f;
};

}  // namespace ajar
