#include "scene/scene.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "description/archive.h"
#include "description/validate.h"
#include "math/random.h"
#include "scene/accel.h"

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

/// Grey surface of objects without a material, as in Blender.
NodeGraph default_surface() {
  NodeGraph graph;
  Node diffuse;
  diffuse.type = "ShaderNodeBsdfDiffuse";
  diffuse.name = "Default Surface";
  diffuse.inputs.push_back({"Color", {}, Vec4(0.8f, 0.8f, 0.8f, 1.0f)});
  diffuse.inputs.push_back({"Roughness", {}, Vec4(0.0f)});
  graph.nodes.push_back(std::move(diffuse));
  graph.surface = {0, "BSDF"};
  return graph;
}

/// Whether the material traces rays at its own object only. The mesh then needs its own structure.
bool asks_for_itself(const MaterialDescription& material) {
  return std::any_of(material.graph.nodes.begin(), material.graph.nodes.end(), [](const Node& node) {
    return node.type == "ShaderNodeAmbientOcclusion" &&
           std::any_of(node.properties.begin(), node.properties.end(), [](const NodeProperty& p) {
             return p.name == "only_local" && !p.numbers.empty() && p.numbers[0] != 0.0f;
           });
  });
}

/// Moves the vertices and normals of a mesh to world space.
void bake(BuiltMesh& mesh, const Mat4& world_from_object) {
  for (size_t i = 0; i + 1 < mesh.positions.size(); ++i)
    mesh.positions[i] = transform_point(world_from_object, mesh.positions[i]);
  if (mesh.strands) mesh.strands = transformed(*mesh.strands, world_from_object);
  const Mat3 linear(world_from_object);
  const Mat3 normal_matrix = is_singular(world_from_object) ? linear : glm::inverseTranspose(linear);
  for (Vec3& n : mesh.normals) {
    n = normal_matrix * n;
    const float len = glm::length(n);
    n = len > 0.0f ? n / len : Vec3(0.0f);
  }
  mesh.baked = true;
}

BuiltMesh take(MeshDescription&& d) {
  BuiltMesh mesh;
  mesh.name = std::move(d.name);
  if (!d.strands.empty()) {
    mesh.strands = make_strands(d);
    for (uint32_t i = 0; !d.material_slots.empty() && i < mesh.strands->segment_count(); ++i)
      mesh.material_slots.push_back(d.material_slots[mesh.strands->strand_of(i)]);
    d.positions.clear();
  }
  mesh.positions = std::move(d.positions);
  mesh.positions.push_back(Vec3(0.0f));
  mesh.triangles = std::move(d.triangles);
  if (!mesh.strands) mesh.material_slots = std::move(d.material_slots);
  mesh.normal_domain = d.normal_domain;
  mesh.normals = std::move(d.normals);
  mesh.attributes = std::move(d.attributes);
  mesh.source = std::move(d.shared);
  mesh.texture_space_location = d.texture_space_location;
  mesh.texture_space_size = d.texture_space_size;
  mesh.active_uv = mesh.find_attribute(d.active_uv);
  mesh.undeformed_position = mesh.find_attribute(kUndeformedPosition);
  return mesh;
}

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

Scene::Scene() = default;
Scene::~Scene() = default;

void Scene::compile(CameraShader::Of of, size_t index, const NodeGraph& graph, const std::string& owner,
                    ShaderContext context, Diagnostics& diagnostics) {
  bool sees_camera = false;
  context.sees_camera = &sees_camera;
  ShaderProgram& program = of == CameraShader::Of::Material ? programs_[index]
                           : of == CameraShader::Of::Lamp   ? lamp_programs_[index]
                                                            : world_program_;
  program = ShaderProgram::compile(graph, owner, *textures_, diagnostics, context);
  if (sees_camera)
    camera_shaders_.push_back({of, index, owner, graph, context.material_pass_index,
                               context.world_from_lamp ? *context.world_from_lamp : std::array<float, 12>{}});
}

/// Compiles the materials in `used`. Programs of materials that are equal in `previous` are taken over, with their
/// diagnostics.
void Scene::compile_materials(const SceneDescription& d, const std::vector<uint8_t>& used, ShaderContext context,
                              Scene* previous, Diagnostics& diagnostics) {
  std::map<uint64_t, size_t> at_hand;
  for (size_t i = 0; previous && i < previous->material_fingerprints_.size(); ++i)
    if (previous->material_fingerprints_[i] != 0) at_hand[previous->material_fingerprints_[i]] = i;
  const auto shows_the_same_images = [&](const ShaderProgram& program) {
    for (const auto& [image, texture] : program.images())
      if (textures_->load(image, "", diagnostics) != texture) return false;
    return true;
  };
  for (size_t i = 0; i < d.materials.size(); ++i) {
    const MaterialDescription& material = d.materials[i];
    material_pass_indices_.push_back(material.pass_index);
    programs_.emplace_back();
    material_fingerprints_.push_back(0);
    material_diagnostics_.emplace_back();
    if (!used[i]) continue;
    const uint64_t number = hash64(fingerprint(material) + (context.reflective_caustics ? 1 : 0) +
                                   (context.refractive_caustics ? 2 : 0) +
                                   (context.bump_terminator == BumpTerminator::Microfacet ? 4 : 0));
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
  context.bump_terminator = settings.bump_terminator = settings_.bump_terminator;
  Diagnostics repeated;  // the build has reported these
  for (const CameraShader& shader : std::exchange(camera_shaders_, {})) {
    context.material_pass_index = shader.material_pass_index;
    context.world_from_lamp = shader.of == CameraShader::Of::Lamp ? &shader.world_from_lamp : nullptr;
    compile(shader.of, shader.index, shader.graph, shader.owner, context, repeated);
  }
  settings_ = std::move(settings);
  camera_ = Camera(camera, settings_.width, settings_.height);
}

std::shared_ptr<Scene> Scene::build(SceneDescription d, const Options& options, Diagnostics& diagnostics,
                                    std::shared_ptr<Scene> previous) {
  const Stopwatch watch;
  const auto step = [&](const char* name, float fraction) {
    if (options.stop && options.stop->load(std::memory_order_relaxed)) throw Cancelled();
    if (options.progress) options.progress(name, fraction);
  };
  step("Checking the scene", 0.0f);
  // Shared meshes that the previous scene has are left empty here and taken over below.
  std::vector<BuiltMesh*> kept(d.meshes.size(), nullptr);
  std::map<const MeshDescription*, BuiltMesh*> at_hand;
  if (previous) {
    for (BuiltMesh& mesh : previous->meshes_)
      if (mesh.source && !mesh.baked) at_hand[mesh.source.get()] = &mesh;
  }
  for (size_t i = 0; i < d.meshes.size(); ++i) {
    const auto source = d.meshes[i].shared;
    if (!source) continue;
    const auto found = at_hand.find(source.get());
    if (found != at_hand.end()) {
      kept[i] = found->second;
      at_hand.erase(found);
    } else {
      d.meshes[i] = *source;
      d.meshes[i].shared = source;
    }
  }
  const ValidationCounts counts = validate(d, diagnostics);

  std::shared_ptr<Scene> scene(new Scene());
  Scene& s = *scene;
  s.settings_ = d.settings;
  s.camera_ = Camera(d.camera, d.settings.width, d.settings.height);
  s.statistics_.skipped_triangles = counts.skipped_triangles;
  s.statistics_.repaired_values = counts.repaired_values;

  // Meshes that are used once, or that a singular transform flattens, are moved to world space.
  step("Preparing geometry", 0.1f);
  std::vector<uint32_t> users(d.meshes.size(), 0);
  for (const InstanceDescription& instance : d.instances) ++users[d.objects[instance.object].mesh];
  for (size_t i = 0; i < d.meshes.size(); ++i) {
    s.meshes_.push_back(kept[i] ? std::move(*kept[i]) : take(std::move(d.meshes[i])));
    s.statistics_.kept_meshes += kept[i] ? 1 : 0;
  }
  const uint32_t default_material = uint32_t(d.materials.size());
  std::vector<uint32_t> first_material(d.objects.size());
  std::vector<uint8_t> used(d.materials.size() + 1, 0);
  for (size_t i = 0; i < d.objects.size(); ++i) {
    first_material[i] = uint32_t(s.material_table_.size());
    if (d.objects[i].materials.empty()) s.material_table_.push_back(default_material);
    for (int material : d.objects[i].materials)
      s.material_table_.push_back(material < 0 ? default_material : uint32_t(material));
  }
  std::vector<std::pair<size_t, size_t>> first_motion;  // instance, index of its first matrix
  s.instances_.reserve(d.instances.size());
  for (const InstanceDescription& in : d.instances) {
    const ObjectDescription& object = d.objects[in.object];
    BuiltInstance instance;
    instance.world_from_object = to_matrix(in.world_from_object);
    instance.object = uint32_t(in.object);
    instance.mesh = uint32_t(object.mesh);
    const bool singular = is_singular(instance.world_from_object);
    instance.object_from_world = singular ? Mat4(1.0f) : glm::inverse(instance.world_from_object);
    instance.flips_orientation = glm::determinant(Mat3(instance.world_from_object)) < 0.0f;
    const bool stays = s.meshes_[instance.mesh].source != nullptr ||  // in object space, for the next scene
                       std::any_of(object.materials.begin(), object.materials.end(),
                                   [&](int m) { return m >= 0 && asks_for_itself(d.materials[size_t(m)]); });
    if (singular && (users[instance.mesh] > 1 || stays)) {
      BuiltMesh copy = s.meshes_[instance.mesh];
      copy.source.reset();
      copy.structure.reset();
      instance.mesh = uint32_t(s.meshes_.size());
      s.meshes_.push_back(std::move(copy));
      users.push_back(1);
    }
    // A flat object does not move: its mesh is flattened, so there is no matrix to move it.
    if (in.motion_key_count > 1 && !singular) {
      std::vector<SplitTransform> keys;
      for (int k = 0; k < in.motion_key_count; ++k)
        keys.push_back(split(to_matrix(d.motion_keys[size_t(in.first_motion_key + k)])));
      std::vector<Mat4> matrices = straightened(keys, kMaxMotionKeys);
      // A matrix that is singular at some keys is replaced by a nearly singular one.
      for (Mat4& matrix : matrices) {
        if (!is_singular(matrix)) continue;
        for (int axis = 0; axis < 3; ++axis) matrix[axis] += 1e-5f * instance.world_from_object[axis];
      }
      // If that is still singular, the object does not move.
      if (std::none_of(matrices.begin(), matrices.end(), is_singular)) {
        instance.motion_count = uint32_t(matrices.size());
        first_motion.push_back({s.instances_.size(), s.motion_.size()});
        s.motion_.insert(s.motion_.end(), matrices.begin(), matrices.end());
      }
    }
    const bool moves = instance.motion_count > 0;
    if (users[instance.mesh] == 1 && !moves && (singular || (options.bake_single_instances && !stays)) &&
        !s.meshes_[instance.mesh].baked)
      bake(s.meshes_[instance.mesh], instance.world_from_object);
    instance.first_material = first_material[in.object];
    instance.material_count = std::max<uint32_t>(1, uint32_t(object.materials.size()));
    instance.visibility = object.visibility;
    instance.random = in.random;
    s.instances_.push_back(instance);
    s.statistics_.instanced_triangles += s.meshes_[instance.mesh].triangles.size();
    for (uint32_t k = 0; k < instance.material_count; ++k) used[s.material_table_[instance.first_material + k]] = 1;
  }
  for (const auto& [index, first] : first_motion) s.instances_[index].motion = &s.motion_[first];
  s.statistics_.moving_instances = first_motion.size();
  s.statistics_.instances = s.instances_.size();
  s.statistics_.meshes = s.meshes_.size();
  for (const BuiltMesh& mesh : s.meshes_) {
    s.statistics_.triangles += mesh.triangles.size();
    s.statistics_.strands += mesh.strands ? mesh.strands->strand_count() : 0;
    s.statistics_.geometry_bytes += mesh.memory_bytes();
  }

  // Shaders: only those that are used.
  step("Compiling shaders", 0.3f);
  s.textures_ = std::make_unique<TextureStore>(std::move(d.images), previous ? previous->textures_.get() : nullptr);
  ShaderContext context;
  context.camera = &d.camera;
  context.image_width = d.settings.width;
  context.reflective_caustics = d.settings.reflective_caustics;
  context.refractive_caustics = d.settings.refractive_caustics;
  context.bump_terminator = d.settings.bump_terminator;
  s.compile_materials(d, used, context, previous.get(), diagnostics);
  if (d.settings.integrator != "path" && d.settings.integrator != "auto") {
    for (size_t i = 0; i < d.materials.size(); ++i)
      if (used[i] && s.programs_[i].has_subsurface())
        report_once(diagnostics, {Diagnostic::Severity::Warning, d.materials[i].name,
                                  "its subsurface scattering is approximated by diffuse reflection; only the path "
                                  "tracer walks below surfaces"});
  }
  s.material_pass_indices_.push_back(0);
  s.programs_.push_back(ShaderProgram::compile(default_surface(), "Default Surface", *s.textures_, diagnostics));
  for (size_t i = 0; i < used.size(); ++i) s.any_transparent_ |= used[i] && s.programs_[i].may_be_transparent();
  s.statistics_.transparent_shadows = s.any_transparent_;
  for (size_t i = 0; i < d.lights.size(); ++i) {
    s.lamp_programs_.emplace_back();
    context.world_from_lamp = &d.lights[i].world_from_light;
    s.compile(CameraShader::Of::Lamp, i, d.lights[i].graph, d.lights[i].name, context, diagnostics);
  }
  context.world_from_lamp = nullptr;
  if (d.world.graph.empty()) {
    Node background;
    background.type = "ShaderNodeBackground";
    background.inputs.push_back({"Color", {}, Vec4(d.world.color, 1.0f)});
    background.inputs.push_back({"Strength", {}, Vec4(1.0f)});
    d.world.graph.nodes.push_back(std::move(background));
    d.world.graph.surface = {0, "Background"};
  }
  s.world_fingerprint_ = fingerprint(d.world.graph);
  s.compile(CameraShader::Of::World, 0, d.world.graph, d.world.name, context, diagnostics);
  s.has_media_ = s.world_program_.has_volume();
  if (s.world_program_.medium_varies())
    report_once(diagnostics, {Diagnostic::Severity::Warning, d.world.name,
                              "its volume varies from place to place; it is rendered as in the centre of the scene"});
  for (size_t i = 0; i < used.size(); ++i) s.has_media_ |= used[i] && s.programs_[i].has_volume();
  s.textures_->forget_previous();
  s.statistics_.kept_textures = uint64_t(s.textures_->kept_count());
  s.statistics_.texture_bytes = s.textures_->memory_bytes();

  step("Building the ray tracing structure", 0.5f);
  s.accel_ = std::make_unique<Accel>(s.meshes_, s.instances_, options.stop, previous ? previous->accel_.get() : nullptr,
                                     previous ? std::move(previous->instances_) : std::vector<BuiltInstance>());
  s.statistics_.placed_instances = s.accel_->placed_instances();
  Vec3 lower, upper;
  s.accel_->bounds(lower, upper);
  if (lower.x <= upper.x) {
    s.center_ = 0.5f * (lower + upper);
    s.radius_ = std::max(0.5f * glm::length(upper - lower), 1e-6f);
  }

  step("Gathering lights", 0.9f);
  s.objects_ = std::move(d.objects);
  s.lights_ = LightSet(
      {d, s.objects_, s.meshes_, s.instances_, s.material_table_, s.programs_, s.lamp_programs_, s.world_program_,
       s.center_, s.radius_, s.has_media_, previous && s.shows_the_world_of(*previous) ? &previous->lights_ : nullptr},
      diagnostics);
  s.statistics_.kept_environment = s.lights_.took_environment_over();
  s.accel_->build_lamps(s.lights_);
  s.statistics_.lights = s.lights_.size();
  s.statistics_.light_tree_bytes = s.lights_.tree_bytes();
  s.statistics_.environment_bytes = s.lights_.environment_bytes();
  s.statistics_.accel_bytes = s.accel_->memory_bytes();
  for (const LightDescription& light : d.lights) s.lamp_importances_.push_back(light.light_importance);
  s.world_light_importance_ = d.world.light_importance;
  s.hints_ = std::move(d.hints);
  s.statistics_.seconds = watch.seconds();
  step("Built", 1.0f);
  return scene;
}

}  // namespace ajar
