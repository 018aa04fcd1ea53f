#include "scene/scene.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "description/archive.h"
#include "description/validate.h"
#include "geometry/shared_corners.h"
#include "math/random.h"
#include "scene/accel.h"
#include "scene/catchers.h"
#include "scene/default_surface.h"
#include "scene/dice_meshes.h"
#include "scene/displace.h"
#include "scene/pass_names.h"
#include "shading/images/color_spaces.h"
#include "shading/images/tile_cache.h"
#include "shading/ray_kind_surfaces.h"

namespace ajar {

namespace {
constexpr int kMaxMotionKeys = 129;  // limit of Embree

/// Whether a transform flattens space, so that it has no inverse, or shrinks it so far that rays in it could not be
/// distinguished.
bool is_singular(const Mat4& m) {
  constexpr float kSmallest = 1e-12f;
  const Mat3 linear(m);
  if (!(std::min({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])}) > kSmallest)) return true;
  const float scale = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  const float det = glm::determinant(linear);
  return !(std::abs(det) > 1e-9f * scale) || !std::isfinite(1.0f / det);
}

/// Whether the material traces rays at its own object only. The mesh then needs its own structure.
bool asks_for_itself(const MaterialDescription& material) {
  return std::any_of(material.graph.nodes.begin(), material.graph.nodes.end(), [](const Node& node) {
    return node.type == "ShaderNodeBevel" ||
           ((node.type == "ShaderNodeAmbientOcclusion" || node.type == "ShaderNodeRaycast") &&
            std::any_of(node.properties.begin(), node.properties.end(), [](const NodeProperty& p) {
              return p.name == "only_local" && !p.numbers.empty() && p.numbers[0] != 0.0f;
            }));
  });
}

/// Moves the vertices and normals of a mesh to world space.
void bake(BuiltMesh& mesh, const Mat4& world_from_object) {
  for (size_t i = 0; i + 1 < mesh.positions.size(); ++i)
    mesh.positions[i] = transform_point(world_from_object, mesh.positions[i]);
  if (mesh.strands) mesh.strands = transformed(*mesh.strands, world_from_object);
  if (mesh.points) mesh.points = transformed(*mesh.points, world_from_object);
  const Mat3 linear(world_from_object);
  const Mat3 normal_matrix = is_singular(world_from_object) ? linear : glm::inverseTranspose(linear);
  if (mesh.deformation) mesh.deformation = transformed(*mesh.deformation, world_from_object, normal_matrix);
  for (Vec3& n : mesh.normals) {
    n = normal_matrix * n;
    const float len = glm::length(n);
    n = len > 0.0f ? n / len : Vec3(0.0f);
  }
  mesh.baked = true;
}

struct Stopwatch {
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
};

}  // namespace

Scene::Scene() = default;
Scene::~Scene() = default;

void Scene::compile(CameraShader::Of of, size_t index, const NodeGraph& graph, const std::string& owner,
                    ShaderContext context, Diagnostics& diagnostics) {
  bool sees_camera = false;
  context.sees_camera = &sees_camera;
  context.takes_means = of == CameraShader::Of::Material && context.camera->kind != CameraKind::Texels;
  ShaderProgram& program = of == CameraShader::Of::Material ? programs_[index]
                           : of == CameraShader::Of::Lamp   ? lamp_programs_[index]
                                                            : world_program_;
  program = ShaderProgram::compile(graph, owner, *textures_, diagnostics, context);
  if (sees_camera)
    camera_shaders_.push_back({of, index, owner, graph, context.material_pass_index, context.displacement_method,
                               context.bump_terminator, context.lamp ? std::optional(*context.lamp) : std::nullopt});
}

/// Compiles the materials that an object shows; `shown_by` has an object for each, or -1. Programs of materials that are
/// equal in `previous` are taken over, with their diagnostics.
void Scene::compile_materials(const SceneDescription& d, const std::vector<int>& shown_by, ShaderContext context,
                              Scene* previous, Diagnostics& diagnostics) {
  std::map<uint64_t, size_t> at_hand;
  for (size_t i = 0; previous && i < previous->material_fingerprints_.size(); ++i)
    if (previous->material_fingerprints_[i] != 0) at_hand[previous->material_fingerprints_[i]] = i;
  const auto shows_the_same_images = [&](const ShaderProgram& program) {
    for (const auto& [image, texture] : program.images())
      if (textures_->load(image, "", diagnostics) != texture) return false;
    return true;
  };
  uint64_t grids = 0;
  for (const std::string& name : grid_names_) grids = hash64(grids + std::hash<std::string>()(name));
  for (size_t i = 0; i < d.materials.size(); ++i) {
    const MaterialDescription& material = d.materials[i];
    material_pass_indices_.push_back(material.pass_index);
    programs_.emplace_back();
    opaque_shadows_.push_back(!material.transparent_shadow);
    material_fingerprints_.push_back(0);
    material_diagnostics_.emplace_back();
    if (shown_by[i] < 0) continue;
    const uint64_t number = hash64(
        fingerprint(material) + (context.reflective_caustics ? 1 : 0) + (context.refractive_caustics ? 2 : 0) +
        (context.bump_terminator == BumpTerminator::Microfacet ? 4 : 0) + fingerprint(d.color) + grids);
    const auto found = at_hand.find(number);
    if (found != at_hand.end() && shows_the_same_images(previous->programs_[found->second])) {
      programs_[i] = std::move(previous->programs_[found->second]);
      material_diagnostics_[i] = std::move(previous->material_diagnostics_[found->second]);
      material_fingerprints_[i] = number;
      at_hand.erase(found);
      ++statistics_.kept_programs;
    } else {
      ++statistics_.compiled_programs;
      const size_t seeing_camera = camera_shaders_.size();
      context.material_pass_index = material.pass_index;
      context.displacement_method = material.displacement_method;
      context.bump_terminator = material.bump_map_correction ? d.settings.bump_terminator : BumpTerminator::None;
      context.user = d.objects[size_t(shown_by[i])].name;
      compile(CameraShader::Of::Material, i, material.graph, material.name, context, material_diagnostics_[i]);
      if (camera_shaders_.size() == seeing_camera) material_fingerprints_[i] = number;
    }
    for (const Diagnostic& diagnostic : material_diagnostics_[i]) report_once(diagnostics, diagnostic);
  }
}

/// Whether the world emits exactly the same as that of `previous`.
bool Scene::shows_the_world_of(const Scene& previous) const {
  for (const Scene* scene : {this, &previous})
    for (const CameraShader& shader : scene->camera_shaders_)
      if (shader.of == CameraShader::Of::World) return false;
  return world_fingerprint_ == previous.world_fingerprint_ &&
         world_program_.images() == previous.world_program_.images();
}

void Scene::change_view(const CameraDescription& camera, RenderSettings settings) {
  validate_view(camera, settings);
  ShaderContext context;
  context.camera = &camera;
  context.image_width = settings.width;
  context.reflective_caustics = settings.reflective_caustics = settings_.reflective_caustics;
  context.refractive_caustics = settings.refractive_caustics = settings_.refractive_caustics;
  settings.bump_terminator = settings_.bump_terminator;
  context.grids = &grid_names_;
  context.working_from_rec709 = working_from_rec709_;
  Diagnostics repeated;  // the build has reported these
  for (const CameraShader& shader : std::exchange(camera_shaders_, {})) {
    context.material_pass_index = shader.material_pass_index;
    context.displacement_method = shader.displacement_method;
    context.bump_terminator = shader.bump_terminator;
    context.lamp = shader.lamp ? &*shader.lamp : nullptr;
    compile(shader.of, shader.index, shader.graph, shader.owner, context, repeated);
  }
  if (catchers_) catchers_->change_view(camera, settings);
  settings_ = std::move(settings);
  camera_ = Camera(camera, settings_.width, settings_.height);
}

/// Builds a scene in steps. What the description shares with the previous scene is moved from there.
class Scene::Builder {
 public:
  Builder(SceneDescription description, const Options& options, Diagnostics& diagnostics,
          std::shared_ptr<Scene> previous)
      : d_(std::move(description)), options_(options), diagnostics_(diagnostics), previous_(std::move(previous)) {}

  std::shared_ptr<Scene> build() {
    step("Checking the scene", 0.0f);
    if (!options_.alone && has_catchers(d_)) s_.catchers_ = alone(catchers_alone(d_));
    moved_ = moved_meshes(d_);
    find_kept_meshes();
    const ValidationCounts counts = validate(d_, diagnostics_);
    s_.settings_ = d_.settings;
    s_.camera_ = Camera(d_.camera, d_.settings.width, d_.settings.height);
    s_.statistics_.skipped_triangles = counts.skipped_triangles;
    s_.statistics_.repaired_values = counts.repaired_values;
    if (has_subdivision(d_)) {
      step("Subdividing meshes", 0.05f);
      dice_meshes(d_, diagnostics_, options_.stop);
    }
    step("Preparing geometry", 0.1f);
    take_meshes();
    add_instances();
    step("Compiling shaders", 0.3f);
    compile_shaders();
    displace_meshes();
    if (s_.has_media_) widen_media(s_.meshes_, s_.instances_, s_.material_table_, s_.programs_);
    step("Building the ray tracing structure", 0.5f);
    build_structure();
    step("Gathering lights", 0.9f);
    gather_lights();
    s_.statistics_.seconds = watch_.seconds();
    step("Built", 1.0f);
    return scene_;
  }

 private:
  std::shared_ptr<Scene> alone(SceneDescription catchers) const {
    const Options options{.alone = true, .stop = options_.stop};
    Diagnostics repeated;  // the build of the whole scene reports them
    return Builder(std::move(catchers), options, repeated, nullptr).build();
  }
  void step(const char* name, float fraction) const {
    if (options_.stop && options_.stop->load(std::memory_order_relaxed)) throw Cancelled();
    if (options_.progress) options_.progress(name, fraction);
  }
  void find_kept_meshes();
  void take_meshes();
  void add_instances();
  void add_instance(const InstanceDescription& in);
  void add_motion(const InstanceDescription& in, BuiltInstance& instance);
  void compile_shaders();
  void compile_world(const ShaderContext& context);
  void displace_meshes();
  void build_structure();
  void gather_lights();

  const Stopwatch watch_;
  SceneDescription d_;
  const Options& options_;
  Diagnostics& diagnostics_;
  const std::shared_ptr<Scene> previous_;  // null: there is none
  const std::shared_ptr<Scene> scene_{new Scene()};
  Scene& s_ = *scene_;
  std::vector<bool> moved_;                              // meshes whose materials may move their vertices
  std::vector<BuiltMesh*> kept_;                         // meshes of the previous scene that are moved to this one
  std::vector<uint32_t> users_;                          // instances of each mesh
  std::vector<uint32_t> first_material_;                 // of each object, in the table
  std::vector<int> shown_by_;                            // an object with each material, or -1; the last is the default
  std::vector<std::pair<size_t, size_t>> first_motion_;  // instance, index of its first matrix
};

/// Shared meshes that the previous scene has are left empty in the description. `take_meshes` takes them over.
void Scene::Builder::find_kept_meshes() {
  kept_.assign(d_.meshes.size(), nullptr);
  std::map<const MeshDescription*, BuiltMesh*> at_hand;
  if (previous_) {
    for (BuiltMesh& mesh : previous_->meshes_)
      if (mesh.source && !mesh.baked && !mesh.displaced) at_hand[mesh.source.get()] = &mesh;
  }
  for (size_t i = 0; i < d_.meshes.size(); ++i) {
    const auto source = d_.meshes[i].shared;
    if (!source) continue;
    const auto found = at_hand.find(source.get());
    if (found != at_hand.end() && !(found->second->divided && moved_[i])) {
      kept_[i] = found->second;
      at_hand.erase(found);
    } else {
      d_.meshes[i] = *source;
      d_.meshes[i].shared = source;
    }
  }
}

void Scene::Builder::take_meshes() {
  users_.assign(d_.meshes.size(), 0);
  for (const InstanceDescription& instance : d_.instances) ++users_[d_.objects[instance.object].mesh];
  for (size_t i = 0; i < d_.meshes.size(); ++i) {
    s_.meshes_.push_back(kept_[i] ? std::move(*kept_[i]) : take_mesh(std::move(d_.meshes[i])));
    if (!kept_[i] && !moved_[i]) share_corners(s_.meshes_.back());
    s_.statistics_.kept_meshes += kept_[i] ? 1 : 0;
  }
}

void Scene::Builder::add_instances() {
  const uint32_t default_material = uint32_t(d_.materials.size());
  first_material_.resize(d_.objects.size());
  shown_by_.assign(d_.materials.size() + 1, -1);
  for (size_t i = 0; i < d_.objects.size(); ++i) {
    first_material_[i] = uint32_t(s_.material_table_.size());
    if (d_.objects[i].materials.empty()) s_.material_table_.push_back(default_material);
    for (int material : d_.objects[i].materials)
      s_.material_table_.push_back(material < 0 ? default_material : uint32_t(material));
  }
  s_.instances_.reserve(d_.instances.size());
  s_.instance_origins_ = std::move(d_.instance_origins);
  s_.instance_values_ = std::move(d_.instance_values);
  for (const InstanceDescription& in : d_.instances) add_instance(in);
  for (const auto& [index, first] : first_motion_) s_.instances_[index].motion = &s_.motion_[first];
  s_.statistics_.moving_instances = first_motion_.size();
  s_.statistics_.instances = s_.instances_.size();
  s_.statistics_.meshes = s_.meshes_.size();
  for (const BuiltMesh& mesh : s_.meshes_) {
    s_.statistics_.triangles += mesh.triangles.size();
    s_.statistics_.strands += mesh.strands ? mesh.strands->strand_count() : 0;
    s_.statistics_.points += mesh.points ? mesh.points->spheres.size() : 0;
    s_.statistics_.geometry_bytes += mesh.memory_bytes();
    s_.statistics_.deforming_meshes += mesh.deforms() || mesh.velocity >= 0 ? 1 : 0;
  }
}

/// Meshes that are used once, or that a singular transform flattens, are moved to world space.
void Scene::Builder::add_instance(const InstanceDescription& in) {
  const ObjectDescription& object = d_.objects[in.object];
  BuiltInstance instance;
  instance.world_from_object = to_matrix(in.world_from_object);
  instance.object = uint32_t(in.object);
  instance.mesh = uint32_t(object.mesh);
  const bool singular = is_singular(instance.world_from_object);
  instance.object_from_world = singular ? Mat4(1.0f) : glm::inverse(instance.world_from_object);
  instance.flips_orientation = glm::determinant(Mat3(instance.world_from_object)) < 0.0f;
  const bool stays = s_.meshes_[instance.mesh].source != nullptr ||  // in object space, for the next scene
                     // A radius cannot tell how an uneven scale flattens strands and points, as in Cycles.
                     ((s_.meshes_[instance.mesh].strands || s_.meshes_[instance.mesh].points) &&
                      !scales_evenly(instance.world_from_object)) ||
                     std::any_of(object.materials.begin(), object.materials.end(),
                                 [&](int m) { return m >= 0 && asks_for_itself(d_.materials[size_t(m)]); });
  if (singular && (users_[instance.mesh] > 1 || stays)) {
    BuiltMesh copy = s_.meshes_[instance.mesh];
    copy.source.reset();
    copy.structure.reset();
    instance.mesh = uint32_t(s_.meshes_.size());
    s_.meshes_.push_back(std::move(copy));
    users_.push_back(1);
  }
  // A flat object does not move: its mesh is flattened, so there is no matrix to move it.
  if (in.motion_key_count > 1 && !singular) add_motion(in, instance);
  const bool moves = instance.motion_count > 0;
  if (users_[instance.mesh] == 1 && !moves && (singular || (options_.bake_single_instances && !stays)) &&
      !s_.meshes_[instance.mesh].baked)
    bake(s_.meshes_[instance.mesh], instance.world_from_object);
  instance.first_material = first_material_[in.object];
  instance.material_count = std::max<uint32_t>(1, uint32_t(object.materials.size()));
  instance.visibility = object.visibility & kVisibleAll;
  if (object.visibility & kVisibleShadow) instance.visibility |= blocker_bit(object.blocker_set);
  instance.random = in.random;
  if (in.first_frame_key >= 0 && !singular) {
    instance.first_frame = uint32_t(s_.frames_.size());
    for (int k = 0; k < 2; ++k) s_.frames_.push_back(to_matrix(d_.motion_keys[size_t(in.first_frame_key + k)]));
  }
  if (in.origin >= 0) instance.origin = &s_.instance_origins_[size_t(in.origin)];
  const InstanceValues& own = s_.instance_values_;
  if (in.values >= 0) instance.values = &own.values[size_t(in.values) * size_t(own.columns)];
  s_.instances_.push_back(instance);
  s_.statistics_.instanced_triangles += s_.meshes_[instance.mesh].triangles.size();
  for (uint32_t k = 0; k < instance.material_count; ++k)
    shown_by_[s_.material_table_[instance.first_material + k]] = in.object;
}

void Scene::Builder::add_motion(const InstanceDescription& in, BuiltInstance& instance) {
  std::vector<SplitTransform> keys;
  keys.reserve(size_t(in.motion_key_count));
  for (int k = 0; k < in.motion_key_count; ++k)
    keys.push_back(split(to_matrix(d_.motion_keys[size_t(in.first_motion_key + k)])));
  std::vector<Mat4> matrices = straightened(keys, kMaxMotionKeys);
  // A matrix that is singular at some keys is replaced by a nearly singular one.
  for (Mat4& matrix : matrices) {
    if (!is_singular(matrix)) continue;
    for (int axis = 0; axis < 3; ++axis) matrix[axis] += 1e-5f * instance.world_from_object[axis];
  }
  // If that is still singular, the object does not move.
  if (std::none_of(matrices.begin(), matrices.end(), is_singular)) {
    instance.motion_count = uint32_t(matrices.size());
    first_motion_.push_back({s_.instances_.size(), s_.motion_.size()});
    s_.motion_.insert(s_.motion_.end(), matrices.begin(), matrices.end());
  }
}

/// Of the materials, only those that are used.
void Scene::Builder::compile_shaders() {
  s_.textures_ = std::make_unique<TextureStore>(std::move(d_.images), previous_ ? previous_->textures_.get() : nullptr,
                                                d_.color, texture_cache_of(d_.settings));
  ShaderContext context;
  context.camera = &d_.camera;
  context.image_width = d_.settings.width;
  context.reflective_caustics = d_.settings.reflective_caustics;
  context.refractive_caustics = d_.settings.refractive_caustics;
  context.bump_terminator = d_.settings.bump_terminator;
  for (const BuiltMesh& mesh : s_.meshes_)
    for (const VoxelGrid& grid : mesh.grids) s_.grid_names_.insert(grid.name());
  context.grids = &s_.grid_names_;
  context.working_from_rec709 = s_.working_from_rec709_ = ajar::working_from_rec709(d_.color);
  s_.compile_materials(d_, shown_by_, context, previous_.get(), diagnostics_);
  s_.material_pass_indices_.push_back(0);
  s_.opaque_shadows_.push_back(false);
  s_.programs_.push_back(ShaderProgram::compile(default_surface(), "Default Surface", *s_.textures_, diagnostics_));
  for (size_t i = 0; i < shown_by_.size(); ++i)
    s_.any_transparent_ |= shown_by_[i] >= 0 && s_.programs_[i].may_be_transparent();
  for (size_t i = 0; i < shown_by_.size(); ++i) s_.any_portal_ |= shown_by_[i] >= 0 && s_.programs_[i].has_portal();
  for (size_t i = 0; i < d_.materials.size(); ++i)
    s_.ray_kinds_.push_back(shown_by_[i] >= 0 ? ray_kinds_of(d_.materials[i]) : RayKinds::None);
  s_.ray_kinds_.push_back(RayKinds::None);
  for (const BuiltInstance& instance : s_.instances_) {
    const std::span<const uint32_t> materials = s_.materials_of(instance);
    s_.shadow_rays_differ_ |= shadow_rays_differ_for(instance.visibility) &&
                              !std::all_of(materials.begin(), materials.end(),
                                           [&](uint32_t m) { return s_.programs_[m].only_encloses(); });
  }
  s_.any_ray_kind_ = s_.shadow_rays_differ_ || std::any_of(s_.ray_kinds_.begin(), s_.ray_kinds_.end(),
                                                           [](RayKinds kinds) { return kinds != RayKinds::None; });
  s_.statistics_.transparent_shadows = s_.any_transparent_;
  for (size_t i = 0; i < d_.lights.size(); ++i) {
    s_.lamp_programs_.emplace_back();
    const LampSpace lamp(d_.lights[i]);
    context.lamp = &lamp;
    s_.compile(CameraShader::Of::Lamp, i, d_.lights[i].graph, d_.lights[i].name, context, diagnostics_);
  }
  context.lamp = nullptr;
  compile_world(context);
  bool scatters = false;
  for (size_t i = 0; i < shown_by_.size(); ++i) {
    if (shown_by_[i] < 0) continue;
    s_.has_media_ |= s_.programs_[i].has_volume();
    scatters |= s_.programs_[i].scatters();
  }
  s_.scatters_light_ = scatters || s_.has_media_;
  s_.textures_->forget_previous();
  s_.count_textures();
}

void Scene::Builder::compile_world(const ShaderContext& context) {
  if (d_.world.graph.empty()) {
    Node background;
    background.type = "ShaderNodeBackground";
    background.inputs.push_back({"Color", {}, Vec4(d_.world.color, 1.0f)});
    background.inputs.push_back({"Strength", {}, Vec4(1.0f)});
    d_.world.graph.nodes.push_back(std::move(background));
    d_.world.graph.surface = {0, "Background"};
  }
  s_.world_fingerprint_ = hash64(fingerprint(d_.world.graph) + fingerprint(d_.color));
  s_.compile(CameraShader::Of::World, 0, d_.world.graph, d_.world.name, context, diagnostics_);
  s_.has_media_ = s_.world_program_.has_volume();
}

/// Each mesh by the materials of the first instance that shows it, as in Cycles.
void Scene::Builder::displace_meshes() {
  s_.objects_ = std::move(d_.objects);
  std::vector<bool> seen(s_.meshes_.size(), false);
  for (const BuiltInstance& instance : s_.instances_) {
    if (seen[instance.mesh]) continue;
    seen[instance.mesh] = true;
    BuiltMesh& mesh = s_.meshes_[instance.mesh];
    const std::span<const uint32_t> materials = s_.materials_of(instance);
    if (mesh.triangles.empty() || !mesh.grids.empty() ||  // neither hair nor points nor volume objects move
        std::none_of(materials.begin(), materials.end(), [&](uint32_t m) { return s_.programs_[m].displaces(); }))
      continue;
    step("Displacing meshes", 0.4f);
    const ObjectDescription& object = s_.objects_[instance.object];
    s_.statistics_.geometry_bytes -= mesh.memory_bytes();
    const size_t broken = displace(mesh, instance, object, materials, s_.programs_, options_.stop);
    s_.statistics_.geometry_bytes += mesh.memory_bytes();
    if (broken > 0)
      report_once(diagnostics_, {Diagnostic::Severity::Warning, object.name,
                                 "its displacement is not a finite number at " + std::to_string(broken) +
                                     " vertices, which stay where they are"});
  }
}

void Scene::Builder::build_structure() {
  s_.accel_ = std::make_unique<Accel>(s_.meshes_, s_.instances_, s_.settings_.compact_bvh, options_.stop,
                                      previous_ ? previous_->accel_.get() : nullptr,
                                      previous_ ? std::move(previous_->instances_) : std::vector<BuiltInstance>());
  s_.statistics_.placed_instances = s_.accel_->placed_instances();
  Vec3 lower, upper;
  s_.accel_->bounds(lower, upper);
  if (lower.x <= upper.x) {
    s_.center_ = 0.5f * (lower + upper);
    s_.radius_ = std::max(0.5f * glm::length(upper - lower), 1e-6f);
  }
}

void Scene::Builder::gather_lights() {
  // Paths from the lens find small lights out of focus.
  const bool with_meshes = s_.scatters_light_ || s_.camera_.has_lens();
  s_.lights_ = LightSet({d_, s_.objects_, s_.meshes_, s_.instances_, s_.material_table_, s_.programs_,
                         s_.lamp_programs_, s_.world_program_, s_.center_, s_.radius_, s_.has_media_, with_meshes,
                         previous_ && s_.shows_the_world_of(*previous_) ? &previous_->lights_ : nullptr},
                        diagnostics_);
  s_.statistics_.kept_environment = s_.lights_.took_environment_over();
  s_.accel_->build_lamps(s_.lights_);
  s_.statistics_.lights = s_.lights_.size();
  s_.statistics_.light_tree_bytes = s_.lights_.tree_bytes();
  s_.statistics_.environment_bytes = s_.lights_.environment_bytes();
  s_.statistics_.accel_bytes = s_.accel_->memory_bytes();
  for (const LightDescription& light : d_.lights) s_.lamp_importances_.push_back(light.light_importance);
  s_.world_light_importance_ = d_.world.light_importance;
  gather_names(d_, s_.objects_,
               {s_.light_groups_, s_.limited_lights_, s_.partly_hidden_objects_, s_.lamp_groups_, s_.object_groups_,
                s_.world_group_, s_.object_mattes_, s_.asset_mattes_, s_.material_mattes_});
  s_.hints_ = std::move(d_.hints);
}

std::shared_ptr<Scene> Scene::build(SceneDescription description, const Options& options, Diagnostics& diagnostics,
                                    std::shared_ptr<Scene> previous) {
  return Builder(std::move(description), options, diagnostics, std::move(previous)).build();
}

}  // namespace ajar
