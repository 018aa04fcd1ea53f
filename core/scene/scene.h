// The built scene: geometry in Embree, compiled shaders, and lights. It is constant during a render and shared by all
// threads. There are no globals.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "description/diagnostics.h"
#include "description/scene_description.h"
#include "geometry/camera.h"
#include "geometry/geometry.h"
#include "lights/light_set.h"
#include "shading/images/texture.h"
#include "shading/ray_kind_surfaces.h"
#include "shading/shader_program.h"

namespace ajar {

class Accel;

/// VisibilityBits of which an object needs one to be seen by a ray of this kind (bits of ShadingPoint::ray_kind).
inline uint32_t visibility_mask(uint32_t ray_kind) {
  // Most kinds have the same bits.
  constexpr uint32_t kSame = kRayCamera | kRayDiffuse | kRayGlossy | kRayTransmission;
  static_assert(kSame == (kVisibleCamera | kVisibleDiffuse | kVisibleGlossy | kVisibleTransmission) &&
                uint32_t(kRayCamera) == kVisibleCamera && uint32_t(kRayDiffuse) == kVisibleDiffuse &&
                uint32_t(kRayGlossy) == kVisibleGlossy);
  // As in Cycles, transmitted rays are neither diffuse nor glossy here.
  const uint32_t same = ray_kind & (ray_kind & kRayTransmission ? kSame & ~uint32_t(kRayDiffuse | kRayGlossy) : kSame);
  return same | (ray_kind & kRayVolumeScatter ? kVisibleVolumeScatter : 0u) |
         (ray_kind & kRayShadow ? kVisibleShadow : 0u);
}

/// The closest surface along a ray.
struct Hit {
  float t = kInfinity;
  uint32_t instance = ~0u;
  uint32_t primitive = ~0u;
  Vec2 barycentric{0.0f};
  bool found() const { return instance != ~0u; }
};

/// A lamp with extent that a ray hits. Lamps never block rays.
struct LampHit {
  float t = kInfinity;
  uint32_t light = ~0u;
  Vec3 normal{0.0f};
};

struct BuildStatistics {
  double seconds = 0.0;
  uint64_t triangles = 0, instanced_triangles = 0, instances = 0, meshes = 0, lights = 0, strands = 0, points = 0;
  uint64_t geometry_bytes = 0, accel_bytes = 0, texture_bytes = 0, light_tree_bytes = 0, environment_bytes = 0;
  uint64_t skipped_triangles = 0, repaired_values = 0;
  uint64_t moving_instances = 0, deforming_meshes = 0;
  bool transparent_shadows = false;
  /// taken over from the previous scene, neither copied nor built again
  uint64_t kept_meshes = 0, kept_textures = 0;
  uint64_t tiled_textures = 0, made_textures = 0;     ///< in the cache of tiles; of these, with new files
  uint64_t compiled_programs = 0, kept_programs = 0;  ///< of materials
  /// put into the top-level structure, which can be that of the previous scene; the others were there
  uint64_t placed_instances = 0;
  bool kept_environment = false;
};

/// `ray`, directed at `place` and blocked by what shades it, shortened so that it ends just before it. It ends at a point moved off the surface
/// there, to the side of the ray, like the origin of a ray that leaves the surface. A margin along the ray would be too
/// small at grazing angles. At other angles it would let light pass what is just before the end: the other wall of a
/// corner, or the shade of a distant lamp. Rays to infinity are unchanged.
inline Ray end_before(Ray ray, const LightPlace& place) {
  // Bound of the distance by which a ray misses a plane, as a fraction of its length.
  constexpr float kRelativeError = 1e-6f;
  ray.blockers = place.blockers;
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
    bool alone = false;                 ///< for Scene::catchers
    const std::atomic<bool>* stop = nullptr;
    std::function<void(const char* step, float fraction)> progress;
  };
  /// Throws SceneError if the scene cannot be rendered, Cancelled if stopped.
  /// Data that the description shares with `previous` (MeshDescription::shared, images) are taken over and not built
  /// again. `previous` cannot be used after that.
  static std::shared_ptr<Scene> build(SceneDescription description, const Options& options, Diagnostics& diagnostics,
                                      std::shared_ptr<Scene> previous = nullptr);
  /// Changes the camera and the resolution. Only the sole owner may call this, between renders. Only shaders that
  /// depend on the camera are compiled again. The settings of caustics stay as they were compiled. Throws SceneError,
  /// without a change, if there would be no image.
  void change_view(const CameraDescription& camera, RenderSettings settings);
  ~Scene();

  Hit intersect(const Ray& ray, uint32_t ray_kind) const;
  /// Nearest lamp with extent before t_max that is visible to rays of this kind.
  LampHit intersect_lamp(const Ray& ray, uint32_t ray_kind) const;
  bool has_lamp_shapes() const;
  /// Whether the ray hits anything that casts shadows, even if it is transparent.
  bool is_blocked(const Ray& ray) const;
  /// Whether the ray hits this instance.
  bool is_blocked_by(const BuiltInstance& instance, const Ray& ray) const;
  /// The nearest hit on this instance. Only materials with nodes that ask for it get one (`asks_for_itself`).
  Hit intersect_own(const BuiltInstance& instance, const Ray& ray) const;
  /// Transmittance along the segment (0 if blocked). Evaluates transparent surfaces, at most `max_transparent` of them.
  /// Sets `by_ray_kind`, if it is not null, to whether one of them depends on the kind of the ray.
  Color transmittance(const Ray& ray, int max_transparent, bool* by_ray_kind = nullptr) const;

  /// Fills `point` for shading at `hit`. The position on a triangle comes from the barycentric coordinates, not from t,
  /// for precision.
  void shading_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const;
  const ShaderProgram& material(const Hit& hit) const;
  /// Index of the light of an emissive triangle, or -1.
  int light_of(const Hit& hit) const;
  /// Whether an object or the world has a volume, even an empty one.
  bool has_media() const { return has_media_; }
  /// Whether a visible surface or a volume may scatter light. If not, the camera sees emission alone.
  bool scatters_light() const { return scatters_light_; }
  bool has_transparent_shadows() const { return any_transparent_; }
  /// Whether a visible material has a ray portal.
  bool has_portals() const { return any_portal_; }
  /// Whether a visible surface depends on the kind of the ray, and whether this one does (ray_kind_surfaces.h).
  bool depends_on_ray_kind() const { return any_ray_kind_; }
  bool depends_on_ray_kind(const Hit& hit) const {
    return any_ray_kind_ && (ray_kinds_[size_t(material_index(hit))] != RayKinds::None || shadows_differ_at(hit));
  }
  /// Whether it depends on more than whether the ray is a shadow ray: only walks from the eye can go by way of it.
  bool is_eye_only(const Hit& hit) const {
    return any_ray_kind_ && (ray_kinds_[size_t(material_index(hit))] == RayKinds::All ||
                             (shadows_differ_at(hit) && !hidden_from_shadow_rays(hit)));
  }
  /// Whether shadow rays see some surface that diffuse rays do not see, or the reverse.
  bool shadow_rays_differ() const { return shadow_rays_differ_; }
  /// The kind of a ray that sees all that the shadow ray sees. Where shadow rays differ, it also sees what diffuse rays
  /// see.
  uint32_t shadow_kind(const Ray& shadow_ray) const {
    const bool all = shadow_rays_differ_ && shadow_ray.blockers == kVisibleShadow;
    return all ? uint32_t(kRayShadow | kRayDiffuse) : uint32_t(kRayShadow);
  }
  bool hidden_from_shadow_rays(const Hit& hit) const {
    return shadow_rays_differ_ && !(instances_[hit.instance].visibility & kVisibleShadow);
  }
  /// Whether shadow rays pass the surface, or its transparent parts.
  bool shadow_rays_pass(const Hit& hit) const {
    return hidden_from_shadow_rays(hit) ||
           (material(hit).may_be_transparent() && !opaque_shadows_[size_t(material_index(hit))]);
  }
  /// The transparency of a surface that shadow rays pass, for a ray of the kind of `point`.
  Color transparency(const Hit& hit, const ShadingPoint& point) const {
    return point.ray_kind == kRayShadow && hidden_from_shadow_rays(hit) ? Color(1.0f)
                                                                        : material(hit).evaluate_transparency(point);
  }
  /// Whether light can go below some surface.
  bool has_subsurface() const;
  bool has_strands() const { return statistics_.strands > 0; }
  bool has_points() const { return statistics_.points > 0; }
  /// Whether a surface may emit that is not among the lights.
  bool emission_without_lights() const;
  /// The same scene with its shadow catchers and without other objects; null if the camera sees no catcher.
  const std::shared_ptr<Scene>& catchers() const { return catchers_; }
  /// Importance of one light, and whether that of any source is not 1 (see ObjectDescription::light_importance).
  float light_importance(uint32_t light) const;
  bool any_light_importance() const;
  /// The names of all light groups, and the index of the group of a light or of the emission of an object; -1: none.
  const std::vector<std::string>& light_groups() const { return light_groups_; }
  /// Names of the lamps whose number of bounces is less than the scene's, and of the world.
  const std::vector<std::string>& limited_lights() const { return limited_lights_; }
  /// Names of objects that some kinds of bounces see and others do not, for a message: the first few.
  const std::vector<std::string>& partly_hidden_objects() const { return partly_hidden_objects_; }
  int light_group(uint32_t light) const;
  int light_group_of(const ObjectDescription& object) const;
  /// Transforms of instances one frame before and one after: BuiltInstance::first_frame.
  const std::vector<Mat4>& frames() const { return frames_; }
  /// Ids of Cryptomatte: of the object, of the material, and of the asset.
  std::array<float, 3> matte_ids(const ShadingPoint& point) const;

  /// Ray from a surface point towards `direction`. Its origin is moved off the surface, to the side of `direction`, by
  /// the error bound of the point.
  Ray spawn_ray(const ShadingPoint& point, Vec3 direction) const;
  /// The rest of `ray` beyond the surface at `point`, which it has hit at distance t and passes straight.
  Ray straight_on(const ShadingPoint& point, const Ray& ray, float t) const {
    const float left = ray.t_max - t;
    Ray next = spawn_ray(point, ray.direction);
    next.t_max = left;
    next.travelled = ray.travelled + t;
    return next;
  }
  /// The same for a shadow ray: the distance to its end is measured from the new origin. t_max is not positive if
  /// nothing is left.
  Ray straight_on_to_end(const ShadingPoint& point, const Ray& ray) const {
    const Vec3 end = ray.origin + ray.direction * ray.t_max;
    Ray next = spawn_ray(point, ray.direction);
    next.blockers = ray.blockers;
    if (ray.t_max < kInfinity) next.t_max = glm::dot(end - next.origin, ray.direction);
    return next;
  }
  /// Ray that ends just before a place on another surface or a light.
  Ray spawn_segment(const ShadingPoint& point, const LightPlace& place) const {
    return end_before(spawn_ray(point, place.wi), place);
  }

  const Camera& camera() const { return camera_; }
  /// Whether anything moves while the shutter is open. Rays then have different times.
  bool moves() const { return statistics_.moving_instances > 0 || statistics_.deforming_meshes > 0 || camera_.moves(); }
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
  bool shadows_differ_at(const Hit& hit) const {
    return shadow_rays_differ_ && shadow_rays_differ_for(instances_[hit.instance].visibility);
  }
  static bool shadow_rays_differ_for(uint32_t visibility) {
    return !(visibility & kVisibleShadow) != !(visibility & kVisibleDiffuse);
  }
  /// The data from which a program is compiled for another camera.
  void count_textures();
  struct CameraShader {
    enum class Of : uint8_t { Material, Lamp, World } of;
    size_t index;
    std::string owner;
    NodeGraph graph;
    int material_pass_index;
    DisplacementMethod displacement_method;
    BumpTerminator bump_terminator;
    std::optional<LampSpace> lamp;  ///< for lamps
  };
  class Builder;
  Scene();
  /// shading_point for hits on strands and on points of a cloud.
  void strand_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const;
  void sphere_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const;
  bool shows_the_world_of(const Scene& previous) const;
  void compile_materials(const SceneDescription& d, const std::vector<int>& shown_by, ShaderContext context,
                         Scene* previous, Diagnostics& diagnostics);
  void compile(CameraShader::Of of, size_t index, const NodeGraph& graph, const std::string& owner,
               ShaderContext context, Diagnostics& diagnostics);
  RenderSettings settings_;
  Camera camera_;
  std::vector<BuiltMesh> meshes_;
  std::vector<BuiltInstance> instances_;
  std::vector<Mat4> motion_;  // of moving instances
  std::vector<InstanceOrigin> instance_origins_;
  InstanceValues instance_values_;
  std::vector<ObjectDescription> objects_;
  std::vector<uint32_t> material_table_;
  std::vector<ShaderProgram> programs_, lamp_programs_;
  std::vector<bool> opaque_shadows_;             // of each program: shadow rays do not pass its transparent parts
  std::vector<RayKinds> ray_kinds_;              // of each program
  std::vector<uint64_t> material_fingerprints_;  // 0 if the program cannot be taken over by the next scene
  std::vector<Diagnostics> material_diagnostics_;
  std::vector<int> material_pass_indices_;
  std::vector<HintDescription> hints_;
  ShaderProgram world_program_;
  uint64_t world_fingerprint_ = 0;
  std::vector<CameraShader> camera_shaders_;
  std::set<std::string> grid_names_;
  Mat3 working_from_rec709_{1.0f};
  std::unique_ptr<TextureStore> textures_;
  LightSet lights_;
  std::shared_ptr<Scene> catchers_;
  std::vector<float> lamp_importances_;
  float world_light_importance_ = 1.0f;
  std::vector<std::string> light_groups_, limited_lights_, partly_hidden_objects_;
  std::vector<int> lamp_groups_, object_groups_;
  int world_group_ = -1;
  std::vector<float> object_mattes_, asset_mattes_, material_mattes_;
  std::vector<Mat4> frames_;  // of instances that have moved since the last frame, or will until the next one
  std::unique_ptr<Accel> accel_;
  BuildStatistics statistics_;
  bool any_transparent_ = false, any_portal_ = false, has_media_ = false, scatters_light_ = true;
  bool any_ray_kind_ = false, shadow_rays_differ_ = false;
  Vec3 center_{0.0f};
  float radius_ = 1.0f;
};

/// The receiver set of a surface, or of none.
inline uint32_t receiver_set(const ShadingPoint& point) {
  return point.object ? point.object->receiver_set : kEveryLight;
}

/// Whether the point is on hair.
inline bool on_strand(const ShadingPoint& point) { return point.mesh && point.mesh->strands; }
/// Whether the point is on hair or on a point of a cloud, which have no area around it to hold photons.
inline bool on_strand_or_point(const ShadingPoint& point) { return point.mesh && !point.mesh->has_triangles(); }
/// Distance at which a ray from a strand or from a point of a cloud leaves the tube for which a ribbon stands, or the
/// sphere.
float way_out(const ShadingPoint& point, Vec3 direction);

[[gnu::always_inline]] inline Ray Scene::spawn_ray(const ShadingPoint& point, Vec3 direction) const {
  // Twice the error bound of the point also covers the error of the intersection on this surface. That error grows with
  // the largest coordinate, not only with the one along the normal: a floor at z = 0 has no error in z.
  const float distance = 2.0f * max_component(point.position_error);
  const Vec3 offset = point.ng * (glm::dot(direction, point.ng) < 0.0f ? -distance : distance);
  Ray ray;
  ray.origin = point.position + offset;
  ray.direction = direction;
  ray.time = point.time;
  if (on_strand(point)) [[unlikely]]
    ray.strand = strand_tag(uint32_t(point.instance - instances_.data()),
                            point.mesh->strands->strand_of(point.primitive));
  return ray;
}

}  // namespace ajar
