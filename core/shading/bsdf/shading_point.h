// The data that a shader can read about the point that it shades. Scene::shading_point creates it from a hit. World,
// lamps and background fill only the members that they have.
#pragma once

#include <cstdint>

#include "math/types.h"

namespace ajar {

/// Type of the ray that arrived, as bits with the meaning of Blender's Light Path node.
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

/// Value of ShadingPoint::primitive for points inside a volume, away from all triangles. All values that triangles
/// interpolate are zero there.
constexpr uint32_t kInsideVolume = ~0u;

class Scene;
struct BuiltMesh;
struct BuiltInstance;
struct ObjectDescription;

struct ShadingPoint {
  Vec3 position{0.0f};         ///< world space
  Vec3 position_error{0.0f};   ///< bound on the rounding error of the position, per axis
  Vec3 wo{0, 0, 1};            ///< direction towards the origin of the ray
  Vec3 ng{0, 0, 1};            ///< geometric normal, turned towards wo
  Vec3 ns{0, 0, 1};            ///< smooth normal, turned together with ng; not yet made safe
  bool backfacing = false;     ///< whether ng was turned
  bool undisplaced = false;    ///< on the surface before its displacement (BuiltMesh::undisplaced)
  bool after_diffuse = false;  ///< whether a diffuse lobe, also a translucent one, has scattered the path from the eye
  /// Lobes of subsurface scattering are marked whatever `after_diffuse` is: the owner of the point knows which ones light
  /// enters (transport/paths/eye_history.h).
  bool marks_subsurface = false;
  /// weights of the second and third vertex of the triangle; for strands, positions along and across the segment
  Vec2 barycentric{0.0f};
  uint32_t primitive = 0;           ///< triangle of the mesh, segment of its strands, or point of the cloud
  const BuiltMesh* mesh = nullptr;  ///< null for world and lamps
  const BuiltInstance* instance = nullptr;
  const Scene* scene = nullptr;               ///< null for world and lamps, and while a scene is being built
  const ObjectDescription* object = nullptr;  ///< for the node Object Info; may be null
  /// world-space edge vectors p1-p0 and p2-p0 of the triangle; for strands, vectors along and across; for points, any two
  /// tangents
  Vec3 dpdu{0.0f}, dpdv{0.0f};
  float ray_length = 0.0f;
  float time = 0.0f;
  uint32_t ray_kind = kRayCamera;
  /// As in Cycles, a bounce by a translucent lobe counts as transmission alone.
  int ray_depth = 0, diffuse_depth = 0, glossy_depth = 0, transparent_depth = 0, transmission_depth = 0;
  int portal_depth = 0;  ///< surfaces with a ray portal that the path has passed, counted by path tracing
  /// In the choice of a lobe (Bsdf::channel_weights), not negative: the throughput of a path from the eye. A
  /// path that has passed a red lobe has no use for a green one. The same for all paths if their densities must not
  /// depend on what comes before.
  Color channel_weights{1.0f};
};

}  // namespace ajar
