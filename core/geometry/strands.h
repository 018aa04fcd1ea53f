// Hair: curves with a width, many in one geometry.
//
// A strand is a Catmull-Rom curve through its points, or straight between them (StrandShape::Linear); its first and last
// keys are repeated. A segment lies between two
// consecutive points. A ray hits a segment (Hit::primitive) at a position u in [0, 1] along it and v in [-1, 1] across
// it. A ribbon faces each ray that hits it and is shaded as a tube. A ray that leaves it therefore starts outside the
// tube (Scene::spawn_ray), so that light arrives from all sides.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "description/scene_description.h"
#include "math/random.h"

namespace ajar {

struct Strands {
  std::vector<Vec4> keys;  ///< positions and radii for Embree; the first and the last of each strand are repeated
  /// of each segment: the first of its four keys; the segment runs from the second to the third
  std::vector<uint32_t> first_key;
  std::vector<uint32_t> roots;  ///< of each strand: the key of its first point
  /// of each point: its distance from the root along straight lines, as a fraction of the length
  std::vector<float> intercepts;
  std::vector<float> lengths;  ///< of each strand, in object space
  /// `keys` at evenly spaced times while the shutter is open; empty: they do not move
  std::vector<std::vector<Vec4>> motion;
  StrandShape shape = StrandShape::Ribbon;
  int subdivisions = 2;  ///< each segment of a ribbon has 2^subdivisions straight pieces, as in Cycles

  size_t segment_count() const { return first_key.size(); }
  size_t strand_count() const { return lengths.size(); }
  /// Every strand has three more keys than segments, and one more point than segments.
  uint32_t strand_of(uint32_t segment) const { return (first_key[segment] - segment) / 3; }
  uint32_t point_of(uint32_t segment) const { return segment + strand_of(segment); }

  Vec3 center(uint32_t segment, float u, float time) const;
  /// Direction along the strand, not normalised and never zero.
  Vec3 tangent(uint32_t segment, float u, float time) const;
  /// Linear between the points.
  float radius(uint32_t segment, float u, float time) const;
  /// Position of the first point of the strand.
  Vec3 root(uint32_t segment) const { return Vec3(keys[roots[strand_of(segment)]]); }
  size_t memory_bytes() const;

 private:
  /// The four keys of a segment at a time; `mixed` is the storage for those of moving strands.
  const Vec4* control(uint32_t segment, float time, std::array<Vec4, 4>& mixed) const;
};

/// `mesh` must be a valid mesh of strands.
std::shared_ptr<const Strands> make_strands(const MeshDescription& mesh);
/// A transformed copy. Radii are scaled by the mean scale of lengths over the directions (the cube root of the scale of
/// volumes).
std::shared_ptr<const Strands> transformed(const Strands& strands, const Mat4& matrix);

/// Identifies a strand of an instance in Ray::strand; never 0. Two strands share a tag with a probability of 2^-31.
inline uint32_t strand_tag(uint32_t instance, uint32_t strand) { return hash_combine(hash32(instance), strand) | 1u; }

}  // namespace ajar
