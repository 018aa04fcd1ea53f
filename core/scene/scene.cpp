#include "scene/scene.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "math/random.h"
#include "scene/accel.h"
#include "description/archive.h"
#include "description/validate.h"

namespace ajar {

namespace {

/// Without the comparisons of glm::abs.
Vec3 absolute(Vec3 v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
Mat3 absolute(const Mat3& m) { return Mat3(glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2])); }

constexpr int kMaxMotionKeys = 129;   // of Embree

/// True for transforms that flatten space, which have no inverse, and for those that shrink it so far that rays in it would not be told apart.
bool is_singular(const Mat4& m) {
  constexpr float kSmallest = 1e-12f;
  const Mat3 linear(m);
  if (!(std::min({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])}) > kSmallest)) return true;
  const float scale = glm::length(linear[0]) * glm::length(linear[1]) * glm::length(linear[2]);
  const float det = glm::determinant(linear);
  return !(std::abs(det) > 1e-9f * scale) || !std::isfinite(1.0f / det);
}

/// Grey surface of objects without a material, as Blender shows them.
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

/// Does the material trace rays at its object alone? Then the mesh needs a structure of its own.
bool asks_for_itself(const MaterialDescription& material) {
  return std::any_of(material.graph.nodes.begin(), material.graph.nodes.end(), [](const Node& node) {
    return node.type == "ShaderNodeAmbientOcclusion" && std::any_of(node.properties.begin(), node.properties.end(), [](const NodeProperty& p) {
      return p.name == "only_local" && !p.numbers.empty() && p.numbers[0] != 0.0f;
    });
  });
}

/// Move a mesh's vertices and normals to world space.
void bake(BuiltMesh& mesh, const Mat4& world_from_object) {
  for (size_t i = 0; i + 1 < mesh.positions.size(); ++i) mesh.positions[i] = transform_point(world_from_object, mesh.positions[i]);
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
    for (uint32_t i = 0; !d.material_slots.empty() && i < mesh.strands->segment_count(); ++i) mesh.material_slots.push_back(d.material_slots[mesh.strands->strand_of(i)]);
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

void Scene::compile(CameraShader::Of of, size_t index, const NodeGraph& graph, const std::string& owner, ShaderContext context,
                    Diagnostics& diagnostics) {
  bool sees_camera = false;
  context.sees_camera = &sees_camera;
  ShaderProgram& program = of == CameraShader::Of::Material ? programs_[index]
                           : of == CameraShader::Of::Lamp   ? lamp_programs_[index]
                                                            : world_program_;
  program = ShaderProgram::compile(graph, owner, *textures_, diagnostics, context);
  if (sees_camera) camera_shaders_.push_back({of, index, owner, graph, context.material_pass_index,
                                              context.world_from_lamp ? *context.world_from_lamp : std::array<float, 12>{}});
}

/// Those of `used`. Programs of materials that `previous` has just the same are taken over with what was said about them.
void Scene::compile_materials(const SceneDescription& d, const std::vector<uint8_t>& used, ShaderContext context, Scene* previous, Diagnostics& diagnostics) {
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
    const uint64_t number = hash64(fingerprint(material) + (context.reflective_caustics ? 1 : 0) + (context.refractive_caustics ? 2 : 0) + (context.bump_terminator == BumpTerminator::Microfacet ? 4 : 0));
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

/// Whether the world emits exactly what that of `previous` does.
bool Scene::shows_the_world_of(const Scene& previous) const {
  for (const Scene* scene : {this, &previous})
    for (const CameraShader& shader : scene->camera_shaders_)
      if (shader.of == CameraShader::Of::World) return false;
  return world_fingerprint_ == previous.world_fingerprint_ && world_program_.images() == previous.world_program_.images();
}

void Scene::change_view(const CameraDescription& camera, RenderSettings settings) {
  validate_view(camera, settings);
  ShaderContext context;
  context.camera = &camera;
  context.image_width = settings.width;
  context.reflective_caustics = settings.reflective_caustics = settings_.reflective_caustics;
  context.refractive_caustics = settings.refractive_caustics = settings_.refractive_caustics;
  context.bump_terminator = settings.bump_terminator = settings_.bump_terminator;
  Diagnostics repeated;  // everything there is to say was said at the build
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
  // Shared meshes that the scene before has are left empty here, and taken over below.
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

  // Meshes: those used once (or flattened by a transform without an inverse) are moved to world space.
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
    for (int material : d.objects[i].materials) s.material_table_.push_back(material < 0 ? default_material : uint32_t(material));
  }
  std::vector<std::pair<size_t, size_t>> first_motion;   // instance, index of its first matrix
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
    const bool stays = s.meshes_[instance.mesh].source != nullptr ||   // as the artist made it, for the next scene
                       std::any_of(object.materials.begin(), object.materials.end(), [&](int m) { return m >= 0 && asks_for_itself(d.materials[size_t(m)]); });
    if (singular && (users[instance.mesh] > 1 || stays)) {
      BuiltMesh copy = s.meshes_[instance.mesh];
      copy.source.reset();
      copy.structure.reset();
      instance.mesh = uint32_t(s.meshes_.size());
      s.meshes_.push_back(std::move(copy));
      users.push_back(1);
    }
    // A flat object stays where it is at the frame: flattening its mesh leaves no matrix to move.
    if (in.motion_key_count > 1 && !singular) {
      std::vector<SplitTransform> keys;
      for (int k = 0; k < in.motion_key_count; ++k) keys.push_back(split(to_matrix(d.motion_keys[size_t(in.first_motion_key + k)])));
      std::vector<Mat4> matrices = straightened(keys, kMaxMotionKeys);
      // What is flat for a while, or nothing, is nearly so.
      for (Mat4& matrix : matrices) {
        if (!is_singular(matrix)) continue;
        for (int axis = 0; axis < 3; ++axis) matrix[axis] += 1e-5f * instance.world_from_object[axis];
      }
      // What is sheared beyond that stays where it is at the frame.
      if (std::none_of(matrices.begin(), matrices.end(), is_singular)) {
        instance.motion_count = uint32_t(matrices.size());
        first_motion.push_back({s.instances_.size(), s.motion_.size()});
        s.motion_.insert(s.motion_.end(), matrices.begin(), matrices.end());
      }
    }
    const bool moves = instance.motion_count > 0;
    if (users[instance.mesh] == 1 && !moves && (singular || (options.bake_single_instances && !stays)) && !s.meshes_[instance.mesh].baked)
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

  // Shaders: only those somebody can see.
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
                                  "its subsurface scattering is approximated by diffuse reflection; only the path tracer walks below surfaces"});
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
    report_once(diagnostics, {Diagnostic::Severity::Warning, d.world.name, "its volume varies from place to place; all of it is as in the middle of the scene"});
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
  s.lights_ = LightSet({d, s.objects_, s.meshes_, s.instances_, s.material_table_, s.programs_, s.lamp_programs_, s.world_program_,
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

Hit Scene::intersect(const Ray& ray, uint32_t ray_kind) const {
  Hit hit;
  accel_->intersect(ray, ray_kind, hit);
  return hit;
}

LampHit Scene::intersect_lamp(const Ray& ray, uint32_t ray_kind) const {
  LampHit hit;
  accel_->intersect_lamp(ray, ray_kind, hit);
  return hit;
}

bool Scene::is_blocked(const Ray& ray) const { return accel_->occluded(ray); }

bool Scene::is_blocked_by(const BuiltInstance& instance, const Ray& ray) const {
  return accel_->occluded_by(instance, meshes_[instance.mesh], ray);
}

bool Scene::has_lamp_shapes() const { return accel_->has_lamps(); }

Color Scene::transmittance(const Ray& shadow_ray, int max_transparent) const {
  if (!any_transparent_) return accel_->occluded(shadow_ray) ? Color(0.0f) : Color(1.0f);
  Color through(1.0f);
  Ray ray = shadow_ray;
  ShadingPoint point;
  for (int crossed = 0;; ++crossed) {
    const Hit hit = intersect(ray, kRayShadow);
    if (!hit.found()) return through;
    const ShaderProgram& program = material(hit);
    if (!program.may_be_transparent() || crossed >= max_transparent) return Color(0.0f);
    shading_point(ray, hit, point);
    point.ray_kind = kRayShadow;
    through *= program.evaluate_transparency(point);
    if (!(max_component(through) > 0.0f)) return Color(0.0f);
    ray = straight_on_to_end(point, ray);
    if (!(ray.t_max > 0.0f)) return through;
  }
}

void Scene::shading_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const {
  const BuiltInstance& instance = instances_[hit.instance];
  const BuiltMesh& mesh = meshes_[instance.mesh];
  point.wo = -ray.direction;
  point.barycentric = hit.barycentric;
  point.primitive = hit.primitive;
  point.mesh = &mesh;
  point.instance = &instance;
  point.scene = this;
  point.object = &objects_[instance.object];
  point.ray_length = hit.t;
  point.time = ray.time;
  if (mesh.strands) [[unlikely]] {
    strand_point(ray, hit, point);
    return;
  }
  const UVec3 v = mesh.triangles[hit.primitive];
  const Vec3 p0 = mesh.positions[v.x], p1 = mesh.positions[v.y], p2 = mesh.positions[v.z];
  const float b1 = hit.barycentric.x, b2 = hit.barycentric.y, b0 = 1.0f - b1 - b2;
  point.position = b0 * p0 + b1 * p1 + b2 * p2;
  point.position_error = gamma_bound(7) * (absolute(b0 * p0) + absolute(b1 * p1) + absolute(b2 * p2));
  point.dpdu = p1 - p0;
  point.dpdv = p2 - p0;
  Vec3 ng = glm::cross(point.dpdu, point.dpdv);
  Vec3 ns(0.0f);
  if (!mesh.normals.empty()) {
    if (mesh.normal_domain == Domain::Vertex) {
      ns = b0 * mesh.normals[v.x] + b1 * mesh.normals[v.y] + b2 * mesh.normals[v.z];
    } else {
      const Vec3* n = mesh.normals.data() + size_t(hit.primitive) * 3;
      ns = b0 * n[0] + b1 * n[1] + b2 * n[2];
    }
  }
  if (!mesh.baked) {
    Mat4 moved;
    const Mat4& m = world_from_object(instance, ray.time, moved);
    const Mat3 linear(m);
    const Mat3 absolute_linear = absolute(linear);
    const Vec3 on_mesh = point.position;
    point.position_error = absolute_linear * (point.position_error + gamma_bound(4) * glm::abs(point.position)) +
                           gamma_bound(4) * glm::abs(Vec3(m[3]));
    point.position = transform_point(m, point.position);
    point.dpdu = linear * point.dpdu;
    point.dpdv = linear * point.dpdv;
    ng = glm::cross(point.dpdu, point.dpdv);
    if (instance.motion) {
      // The interpolated matrix has rounding errors of its own.
      point.position_error += gamma_bound(4) * (absolute_linear * glm::abs(on_mesh) + glm::abs(Vec3(m[3])));
      ns = ns * glm::inverse(linear);
    } else {
      ns = ns * Mat3(instance.object_from_world);  // row vector times inverse = inverse transpose times column
    }
  }
  // A cross product of tiny edges may underflow: scale before normalising.
  float len2 = length_squared(ng);
  if (!(len2 > 1e-30f) || !(len2 < 1e30f)) {
    const float scale = 1.0f / std::max(max_component(glm::abs(point.dpdu)), max_component(glm::abs(point.dpdv)));
    ng = glm::cross(point.dpdu * scale, point.dpdv * scale);
    len2 = length_squared(ng);
  }
  ng = len2 > 0.0f ? ng / std::sqrt(len2) : -ray.direction;
  if (instance.flips_orientation) ng = -ng;
  const float ns_len2 = length_squared(ns);
  ns = ns_len2 > 0.0f && ns_len2 < kInfinity ? ns / std::sqrt(ns_len2) : ng;
  point.backfacing = glm::dot(ng, point.wo) < 0.0f;
  point.ng = point.backfacing ? -ng : ng;
  point.ns = point.backfacing ? -ns : ns;
}

void Scene::strand_point(const Ray& ray, const Hit& hit, ShadingPoint& point) const {
  const BuiltInstance& instance = instances_[hit.instance];
  const BuiltMesh& mesh = meshes_[instance.mesh];
  const Strands& strands = *mesh.strands;
  const Vec3 position = ray.origin + hit.t * ray.direction;
  Mat4 moved, inverse(1.0f);
  const Mat4& world = mesh.baked ? inverse : world_from_object(instance, ray.time, moved);
  Vec3 along = strands.tangent(hit.primitive, hit.barycentric.x), to_ray = -ray.direction, in_object = position;
  if (!mesh.baked) {
    inverse = instance.motion ? glm::affineInverse(world) : instance.object_from_world;
    to_ray = transform_vector(inverse, to_ray);
    in_object = transform_point(inverse, position);
  }
  Vec3 ns;
  if (strands.shape == StrandShape::Ribbon) {
    // Of the tube that the ribbon stands for, where an orthographic look at it would see this place.
    const Vec3 across = glm::cross(along, to_ray), outwards = glm::cross(across, along);
    const float width = glm::length(across), height = glm::length(outwards);
    const float sine = glm::clamp(hit.barycentric.y, -1.0f, 1.0f);
    ns = width > 0.0f && height > 0.0f ? across * (sine / width) + outwards * (safe_sqrt(1.0f - sqr(sine)) / height) : to_ray;
  } else {
    ns = in_object - strands.center(hit.primitive, hit.barycentric.x);
  }
  if (!mesh.baked) {
    ns = ns * Mat3(inverse);   // the transpose of the inverse
    along = transform_vector(world, along);
  }
  const float length = glm::length(ns);
  point.ns = length > 0.0f && length < kInfinity ? ns / length : point.wo;
  // At the rim the normal is perpendicular to the ray, and rounding decides on which side of it.
  if (!(glm::dot(point.ns, point.wo) > 1e-4f)) point.ns = glm::normalize(point.ns + (1e-4f - glm::dot(point.ns, point.wo)) * point.wo);
  point.ng = point.ns;
  point.backfacing = false;
  point.position = position;
  // Embree turns curves into a space around the ray, where places are as exact as they are near.
  point.position_error = Vec3(gamma_bound(8) * (max_component(glm::abs(ray.origin)) + hit.t));
  point.dpdu = along;
  point.dpdv = glm::cross(along, point.ng);
}

int Scene::material_index(const Hit& hit) const {
  const BuiltInstance& instance = instances_[hit.instance];
  const BuiltMesh& mesh = meshes_[instance.mesh];
  uint32_t slot = mesh.material_slots.empty() ? 0 : mesh.material_slots[hit.primitive];
  // Blender shows the last slot for faces whose slot was removed.
  slot = std::min(slot, instance.material_count - 1);
  return int(material_table_[instance.first_material + slot]);
}

int Scene::material_index(const ShadingPoint& point) const {
  Hit hit;
  hit.instance = uint32_t(point.instance - instances_.data());
  hit.primitive = point.primitive;
  return material_index(hit);
}

const ShaderProgram& Scene::material(const Hit& hit) const { return programs_[size_t(material_index(hit))]; }

int Scene::light_of(const Hit& hit) const {
  const uint32_t first = instances_[hit.instance].first_light;
  return first == ~0u ? -1 : int(first + hit.primitive);
}

bool Scene::emission_without_lights() const {
  for (const BuiltInstance& instance : instances_) {
    if (instance.first_light != ~0u) continue;
    for (uint32_t slot = 0; slot < instance.material_count; ++slot) {
      if (programs_[material_table_[instance.first_material + slot]].emits()) return true;
    }
  }
  return false;
}

float Scene::light_importance(uint32_t light) const {
  if (light < lamp_importances_.size()) return lamp_importances_[light];
  if (int(light) == lights_.environment_index()) return world_light_importance_;
  return objects_[instances_[lights_.light(light).instance].object].light_importance;
}

bool Scene::any_light_importance() const {
  const auto emits = [&](uint32_t material) { return programs_[material].emits(); };
  return (world_light_importance_ != 1.0f && lights_.environment_index() >= 0) ||
         std::any_of(lamp_importances_.begin(), lamp_importances_.end(), [](float importance) { return importance != 1.0f; }) ||
         std::any_of(instances_.begin(), instances_.end(), [&](const BuiltInstance& instance) {
           const auto materials = materials_of(instance);
           return objects_[instance.object].light_importance != 1.0f && std::any_of(materials.begin(), materials.end(), emits);
         });
}

float way_out_of_strand(const ShadingPoint& point, Vec3 direction) {
  constexpr float kMaxRadii = 20.0f;   // nearly along the strand the way is long, and others are in it
  const Strands& strands = *point.mesh->strands;
  if (strands.shape != StrandShape::Ribbon) return 0.0f;
  const Mat3 linear = point.mesh->baked ? Mat3(1.0f) : Mat3(point.instance->world_from_object);
  const float scale = std::max({glm::length(linear[0]), glm::length(linear[1]), glm::length(linear[2])});
  const float radius = scale * strands.radius(point.primitive, point.barycentric.x);
  const float sine = glm::length(glm::cross(direction, point.dpdu)) / glm::length(point.dpdu);
  const float way = radius * std::min(1.02f / std::max(sine, 1e-6f), kMaxRadii) + 4.0f * max_component(point.position_error);
  return std::isfinite(way) ? way : 0.0f;
}

}  // namespace ajar
