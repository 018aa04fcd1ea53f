// The scene, built: geometry in Embree, shaders compiled, lights gathered. Immutable
// while it renders and shared by all threads; no globals.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "description/diagnostics.h"
#include "description/scene_description.h"
#include "geometry/camera.h"
#include "geometry/geometry.h"
#include "lights/light_set.h"
#include "shading/functions/texture.h"
#include "shading/shader_program.h"

namespace ajar {

class Accel;

/// VisibilityBits that a ray of this kind (bits of ShadingPoint::ray_kind) needs an object to have.
inline uint32_t visibility_mask(uint32_t ray_kind) {
  // Most are the same bits.
  constexpr uint32_t kSame = kRayCamera | kRayDiffuse | kRayGlossy | kRayTransmission;
  static_assert(kSame == (kVisibleCamera | kVisibleDiffuse | kVisibleGlossy | kVisibleTransmission) &&
                uint32_t(kRayCamera) == kVisibleCamera && uint32_t(kRayDiffuse) == kVisibleDiffuse &&
                uint32_t(kRayGlossy) == kVisibleGlossy);
  return (ray_kind & kSame) | (ray_kind & kRayVolumeScatter ? kVisibleVolumeScatter : 0u) |
         (ray_kind & kRayShadow ? kVisibleShadow : 0u);
}

/// Closest surface found along a ray.
struct Hit {
  float t = kInfinity;
  uint32_t instance = ~0u;
  uint32_t primitive = ~0u;
  Vec2 barycentric{0.0f};
  bool found() const { return instance != ~0u; }
};

/// A lamp with extent crossed by a ray. Lamps never block rays.
struct LampHit {
  float t = kInfinity;
  uint32_t light = ~0u;
  Vec3 normal{0.0f};
};

struct BuildStatistics {
  double seconds = 0.0;
  uint64_t triangles = 0, instanced_triangles = 0, instances = 0, meshes = 0, lights = 0, strands = 0;
  uint64_t geometry_bytes = 0, accel_bytes = 0, texture_bytes = 0, light_tree_bytes = 0, environment_bytes = 0;
  uint64_t skipped_triangles = 0, repaired_values = 0;
  uint64_t moving_instances = 0;
  bool transparent_shadows = false;
  uint64_t kept_meshes = 0, kept_textures = 0;  ///< taken over from the scene before, neither copied nor built again
  uint64_t compiled_programs = 0, kept_programs = 0;  ///< of materials
  /// put into the structure over all, which may be that of before; the others were there
  uint64_t placed_instances = 0;
  bool kept_environment = false;
};

/// `ray`, on its way to a place, up to just before it: to a point moved off the surface there, to the ray's side, like
/// the origin of a ray that leaves it. A margin along the ray itself would be too little where it grazes, and where it
/// does not it would let light through what stands just before the end: the other wall of a corner, the shade of a lamp
/// far away. Unchanged on its way to what is at infinity.
inline Ray end_before(Ray ray, const LightPlace& place) {
  // Of its length, what a ray may miss a plane by.
  constexpr float kRelativeError = 1e-6f;
  if (!(place.distance < kInfinity)) return ray;
  const float off = 2.0f * place.position_error + kRelativeError * place.distance;
  const Vec3 way = place.position + place.normal * (glm::dot(ray.direction, place.normal) > 0.0f ? -off : off) -
                   ray.origin;
  const float length = glm::length(way);
  if (length > 0.0f) ray.direction = way / length;
  ray.t_max = length * (1.0f - kRelativeError);
  return ray;
}

class Scene {
 public:
  struct Options {
    bool bake_single_instances = true;  ///< off in the viewport, where transforms change
    const std::atomic<bool>* stop = nullptr;
    std::function<void(const char* step, float fraction)> progress;
  };
  /// Throws SceneError when there is nothing sensible to render, Cancelled when stopped.
  /// What the description shares with `previous` (MeshDescription::shared, images) is taken over from it and not built
  /// again; `previous` is of no more use.
  static std::shared_ptr<Scene> build(SceneDescription description, const Options& options, Diagnostics& diagnostics,
                                      std::shared_ptr<Scene> previous = nullptr);
  /// Look at the scene through another camera, at another size. For the sole owner, between renders. Shaders that
  /// depend on the camera are compiled again, nothing else is. Caustics stay as they were compiled. Throws SceneError,
  /// changing nothing, when there would be no picture.
  void change_view(const CameraDescription& camera, RenderSettings settings);
  ~Scene();

  Hit intersect(const Ray& ray, uint32_t ray_kind) const;
  /// Nearest lamp with extent before t_max that rays of this kind see.
  LampHit intersect_lamp(const Ray& ray, uint32_t ray_kind) const;
  bool has_lamp_shapes() const;
  /// Does anything that casts shadows lie on the ray, be it transparent? Does a surface of this instance?
  bool is_blocked(const Ray& ray) const;
  bool is_blocked_by(const BuiltInstance& instance, const Ray& ray) const;
  /// Fraction of light let through along the segment (0 when blocked); evaluates
  /// transparent surfaces, at most `max_transparent` of them.
  Color transmittance(const Ray& ray, int max_transparent) const;

  /// Fill `point` for shading at `hit`. The position on a triangle comes from it, not from t, for precision.
  void shading_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const;
  const ShaderProgram& material(const Hit& hit) const;
  /// Index of the light of an emissive triangle, or -1.
  int light_of(const Hit& hit) const;
  /// Whether some object or the world is filled with a volume, be it an empty one.
  bool has_media() const { return has_media_; }
  bool has_transparent_shadows() const { return any_transparent_; }
  bool has_strands() const { return statistics_.strands > 0; }
  /// Whether some surface may emit that no light stands for.
  bool emission_without_lights() const;
  /// Of one light, and whether that of any source is not 1 (ObjectDescription::light_importance and its like).
  float light_importance(uint32_t light) const;
  bool any_light_importance() const;

  /// Ray from a surface point towards `direction`, its origin moved off the surface
  /// to the side of `direction` by the error bound of the point.
  Ray spawn_ray(const ShadingPoint& point, Vec3 direction) const;
  /// The rest of `ray` beyond the surface at `point`, which it has met at distance t and which lets it straight
  /// through.
  Ray straight_on(const ShadingPoint& point, const Ray& ray, float t) const {
    const float left = ray.t_max - t;
    Ray next = spawn_ray(point, ray.direction);
    next.t_max = left;
    return next;
  }
  /// The same of a shadow ray: what is left to its end is measured from the new origin. t_max is not positive where
  /// nothing is left.
  Ray straight_on_to_end(const ShadingPoint& point, const Ray& ray) const {
    const Vec3 end = ray.origin + ray.direction * ray.t_max;
    Ray next = spawn_ray(point, ray.direction);
    if (ray.t_max < kInfinity) next.t_max = glm::dot(end - next.origin, ray.direction);
    return next;
  }
  /// Ray to just before a place on another surface or a light.
  Ray spawn_segment(const ShadingPoint& point, const LightPlace& place) const {
    return end_before(spawn_ray(point, place.wi), place);
  }

  const Camera& camera() const { return camera_; }
  /// Does anything move while the shutter is open? Then rays have times of their own.
  bool moves() const { return statistics_.moving_instances > 0 || camera_.moves(); }
  const LightSet& lights() const { return lights_; }
  const std::vector<HintDescription>& hints() const { return hints_; }
  const RenderSettings& settings() const { return settings_; }
  const BuildStatistics& statistics() const { return statistics_; }
  const ShaderProgram& world_program() const { return world_program_; }
  Vec3 center() const { return center_; }
  float radius() const { return radius_; }
  const std::vector<BuiltMesh>& meshes() const { return meshes_; }
  const std::vector<BuiltInstance>& instances() const { return instances_; }
  const std::vector<ShaderProgram>& programs() const { return programs_; }
  /// Program of each material slot of an instance.
  std::span<const uint32_t> materials_of(const BuiltInstance& instance) const {
    return {material_table_.data() + instance.first_material, instance.material_count};
  }
  const ObjectDescription& object(uint32_t index) const { return objects_[index]; }
  const TextureStore& textures() const { return *textures_; }
  int material_index(const Hit& hit) const;
  int material_index(const ShadingPoint& point) const;
  const std::vector<int>& material_pass_indices() const { return material_pass_indices_; }

 private:
  /// What is needed to compile a program for another camera.
  struct CameraShader {
    enum class Of : uint8_t { Material, Lamp, World } of;
    size_t index;
    std::string owner;
    NodeGraph graph;
    int material_pass_index;
    std::array<float, 12> world_from_lamp;  ///< of lamps
  };
  Scene();
  /// What shading_point does where strands are hit.
  void strand_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const;
  bool shows_the_world_of(const Scene& previous) const;
  void compile_materials(const SceneDescription& d, const std::vector<uint8_t>& used, ShaderContext context,
                         Scene* previous, Diagnostics& diagnostics);
  void compile(CameraShader::Of of, size_t index, const NodeGraph& graph, const std::string& owner,
               ShaderContext context, Diagnostics& diagnostics);
  RenderSettings settings_;
  Camera camera_;
  std::vector<BuiltMesh> meshes_;
  std::vector<BuiltInstance> instances_;
  std::vector<Mat4> motion_;  // of the instances that move
  std::vector<ObjectDescription> objects_;
  std::vector<uint32_t> material_table_;
  std::vector<ShaderProgram> programs_, lamp_programs_;
  std::vector<uint64_t> material_fingerprints_;  // of those whose program may serve the next scene, else 0
  std::vector<Diagnostics> material_diagnostics_;
  std::vector<int> material_pass_indices_;
  std::vector<HintDescription> hints_;
  ShaderProgram world_program_;
  uint64_t world_fingerprint_ = 0;
  std::vector<CameraShader> camera_shaders_;
  std::unique_ptr<TextureStore> textures_;
  LightSet lights_;
  std::vector<float> lamp_importances_;
  float world_light_importance_ = 1.0f;
  std::unique_ptr<Accel> accel_;
  BuildStatistics statistics_;
  bool any_transparent_ = false, has_media_ = false;
  Vec3 center_{0.0f};
  float radius_ = 1.0f;
};

/// How far a ray that leaves goes before it can meet anything: ribbons turn to it and may lie across its way up to
/// where it is out of the tube they stand for.
float way_out_of_strand(const ShadingPoint& point, Vec3 direction);

[[gnu::always_inline]] inline Ray Scene::spawn_ray(const ShadingPoint& point, Vec3 direction) const {
  // Twice the bound of the point itself covers the intersection's own error on the surface left behind. That error
  // grows with the largest coordinate, not only the one along the normal: a floor at z = 0 has no error in z.
  const float distance = 2.0f * max_component(point.position_error);
  const Vec3 offset = point.ng * (glm::dot(direction, point.ng) < 0.0f ? -distance : distance);
  Ray ray;
  ray.origin = point.position + offset;
  ray.direction = direction;
  ray.time = point.time;
  if (point.mesh && point.mesh->strands) [[unlikely]]
    ray.t_min = way_out_of_strand(point, direction);
  return ray;
}

}  // namespace ajar
