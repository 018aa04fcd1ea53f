// Hair: curves with a width, many in one geometry.
//
// A strand is a Catmull-Rom curve through its points, whose ends count twice; its radius is interpolated likewise. A
// segment lies between two points that follow each other, and is what a ray hits (Hit::primitive), at a place u in [0,
// 1] along it and v in [-1, 1] across. Ribbons turn to each ray that meets them, and are shaded as the tubes they stand
// for: a ray that leaves one begins where it is out of the tube (Scene::spawn_ray), so that light reaches it from all
// around.
#pragma once

#include <memory>
#include <vector>

#include "description/scene_description.h"

namespace ajar {

struct Strands {
  std::vector<Vec4> keys;           ///< places and radii, each strand's first and last twice: what Embree reads
  std::vector<uint32_t> first_key;  ///< of each segment: of four keys, it runs from the second to the third
  std::vector<uint32_t> roots;      ///< of each strand: the key of its first point
  /// of each point: its distance from the root along straight lines, as a part of the length
  std::vector<float> intercepts;
  std::vector<float> lengths;  ///< of each strand, in the object's space
  StrandShape shape = StrandShape::Ribbon;
  int subdivisions = 2;  ///< of segments of ribbons: 2 to this power straight pieces, as Cycles has them

  size_t segment_count() const { return first_key.size(); }
  size_t strand_count() const { return lengths.size(); }
  /// Every strand has three keys more than segments, and one point more.
  uint32_t strand_of(uint32_t segment) const { return (first_key[segment] - segment) / 3; }
  uint32_t point_of(uint32_t segment) const { return segment + strand_of(segment); }

  Vec3 center(uint32_t segment, float u) const;
  /// Along the strand, of any length but 0.
  Vec3 tangent(uint32_t segment, float u) const;
  float radius(uint32_t segment, float u) const;
  /// Where its strand begins.
  Vec3 root(uint32_t segment) const { return Vec3(keys[roots[strand_of(segment)]]); }
  size_t memory_bytes() const;
};

/// Of a mesh that is strands and valid.
std::shared_ptr<const Strands> make_strands(const MeshDescription& mesh);
/// The same elsewhere; radii grow as lengths do on average over the directions (the cube root of the volume's growth).
std::shared_ptr<const Strands> transformed(const Strands& strands, const Mat4& matrix);

}  // namespace ajar
