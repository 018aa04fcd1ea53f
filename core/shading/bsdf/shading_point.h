// Everything a shader may ask about the point it shades. Made by Scene::shading_point from a hit;
// world, lamps and background fill only what they have.
#pragma once

#include <cstdint>

#include "math/types.h"

namespace ajar {

/// What kind of ray arrived: bits, as Blender's Light Path node tells them.
enum RayKindBits : uint32_t {
  kRayCamera = 1,
  kRayDiffuse = 2,
  kRayGlossy = 4,
  kRayTransmission = 8,
  kRayShadow = 16,
  kRayReflection = 32,
  kRaySingular = 64,
  kRayVolumeScatter = 128
};

/// ShadingPoint::primitive of points inside a volume, away from all triangles: what triangles interpolate is zero
/// there.
constexpr uint32_t kInsideVolume = ~0u;

class Scene;
struct BuiltMesh;
struct BuiltInstance;
struct ObjectDescription;

struct ShadingPoint {
  Vec3 position{0.0f};        ///< world space
  Vec3 position_error{0.0f};  ///< bound on its rounding error, per axis
  Vec3 wo{0, 0, 1};           ///< towards where the ray came from
  Vec3 ng{0, 0, 1};           ///< geometric normal, turned towards wo
  Vec3 ns{0, 0, 1};           ///< smooth normal, turned with ng, not yet made safe
  bool backfacing = false;    ///< whether ng was turned
  Vec2 barycentric{0.0f};  ///< weights of the triangle's second and third vertex; along and across a strand's segment
  uint32_t primitive = 0;  ///< triangle of the mesh, or segment of its strands
  const BuiltMesh* mesh = nullptr;  ///< null for world and lamps
  const BuiltInstance* instance = nullptr;
  const Scene* scene = nullptr;               ///< null for world and lamps, and while a scene is built
  const ObjectDescription* object = nullptr;  ///< for Object Info; may be null
  Vec3 dpdu{0.0f}, dpdv{0.0f};  ///< world-space edge vectors p1-p0, p2-p0 of the triangle; along and across a strand
  float ray_length = 0.0f;
  float time = 0.0f;
  uint32_t ray_kind = kRayCamera;
  int ray_depth = 0, diffuse_depth = 0, glossy_depth = 0, transparent_depth = 0, transmission_depth = 0;
};

}  // namespace ajar
