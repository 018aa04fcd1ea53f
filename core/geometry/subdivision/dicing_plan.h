// The plan of an adaptive subdivision: into how many pieces each edge is divided, and which parts of the patches become
// grids of triangles.
//
// After "DiagSplit: Parallel, Crack-free, Adaptive Tessellation for Micropolygon Rendering" (Fisher et al. 2009), as in
// Cycles. The number of pieces of an edge depends only on the edge, so that both of its faces have the same vertices
// there. An edge whose pieces would differ too much in size, such as one that leads into the distance, is divided at
// its middle first. A part with such an edge is divided across it, between a vertex of this edge and one of the
// opposite edge.
#pragma once

#include <vector>

#include "geometry/subdivision/limit_surface.h"
#include "geometry/subdivision/pixel_size.h"

namespace ajar {

/// How finely a mesh is divided.
struct DicingRate {
  const PixelSize* pixels = nullptr;    ///< null: `edge_length` is in object space
  std::vector<Mat4> world_from_object;  ///< of instances; the finest rate is used
  float edge_length = 1.0f;
  int max_subdivisions = 12;
  size_t max_triangles = ~size_t(0);
};

constexpr uint32_t kNoVertex = ~0u;

/// An edge of patches or between parts of a patch.
struct DicedEdge {
  uint32_t start = kNoVertex, end = kNoVertex;  ///< vertices
  int pieces = 0;                               ///< of equal size; 0: they are those of its halves
  int first_half = -1;                          ///< index of two edges that replace it, or -1
  float split = 0.5f;                           ///< place of the vertex between them
  uint32_t inner = kNoVertex;                   ///< without halves: first of the pieces - 1 vertices between its ends
  uint32_t patch = 0;                           ///< a patch with this edge, and where its ends are
  Vec2 from{0.0f}, to{0.0f};
};

/// An edge along a part.
struct SideOfPart {
  uint32_t edge = 0;
  bool reversed = false;  ///< the edge starts at the end of the side
};

/// A part of a patch. Side k leads from corner k to the next one, counter-clockwise.
struct DicedPart {
  uint32_t patch = 0;
  Vec2 corners[4];
  SideOfPart sides[4];
  uint32_t first_inner = 0;  ///< of the vertices that are on no side
  size_t first_triangle = 0;
};

struct DicingPlan {
  std::vector<PatchPoint> points;  ///< the first vertices: corners of patches, and ends of halves of edges
  std::vector<DicedEdge> edges;    ///< their vertices follow
  std::vector<DicedPart> parts;    ///< whose inner vertices follow
  size_t vertices = 0, triangles = 0;
  bool is_complete = true;  ///< false: it was ended because of the number of triangles

  int pieces_of(const SideOfPart& side) const { return pieces_of(side.edge); }
  int pieces_of(uint32_t edge) const {
    const DicedEdge& e = edges[edge];
    return e.first_half < 0 ? e.pieces : pieces_of(uint32_t(e.first_half)) + pieces_of(uint32_t(e.first_half) + 1);
  }
};

DicingPlan plan_dicing(const SubdivisionDescription& subdivision, std::span<const SurfacePatch> patches,
                       const LimitSurface& surface, const DicingRate& rate);

}  // namespace ajar
