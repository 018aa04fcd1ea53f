#include "scene/accel.h"

#include <algorithm>
#include <bit>
#include <utility>

#include <tbb/parallel_for.h>
#include <tbb/version.h>

#include "lights/sources/lamp.h"
#include "scene/embree_device.h"
#include "scene/instance_crowds.h"
#include "scene/lamp_geometry.h"
#include "scene/scene.h"
#include "scene/strand_buffers.h"

namespace ajar {

namespace {

constexpr float kFarthest = 1.8e18f;  // maximum coordinate with which Embree computes

/// Maximum distance of the origins of rays for which these stay within kFarthest in the space of an instance.
float farthest_through(const Mat4& object_from_world) {
  float farthest = kFarthest;
  for (int row = 0; row < 3; ++row) {
    const float stretch = std::abs(object_from_world[0][row]) + std::abs(object_from_world[1][row]) +
                          std::abs(object_from_world[2][row]);
    const float reach = (kFarthest - std::abs(object_from_world[3][row])) / std::max(1.0f, stretch);
    farthest = reach > 0.0f ? std::min(farthest, reach) : 0.0f;
  }
  return farthest;
}

/// A ray does not hit the strand that it leaves, as in Cycles: the closures of a strand describe how light passes
/// through it.
void reject_own_strand(const RTCFilterFunctionNArguments* args) {
  const unsigned n = args->N;
  const auto& strands = *static_cast<const Strands*>(args->geometryUserPtr);
  for (unsigned i = 0; i < n; ++i) {
    const unsigned own = RTCRayN_id(args->ray, n, i);
    if (args->valid[i] != -1 || own == 0) continue;
    unsigned instance = RTCHitN_instID(args->hit, n, i, 0);
    if (instance == RTC_INVALID_GEOMETRY_ID) instance = RTCHitN_geomID(args->hit, n, i);
    if (strand_tag(instance, strands.strand_of(RTCHitN_primID(args->hit, n, i))) == own) args->valid[i] = 0;
  }
}

/// Tubes and spheres are visible from outside only, as in Cycles.
void reject_from_inside(const RTCFilterFunctionNArguments* args) {
  const unsigned n = args->N;
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] != -1) continue;
    const Vec3 direction(RTCRayN_dir_x(args->ray, n, i), RTCRayN_dir_y(args->ray, n, i),
                         RTCRayN_dir_z(args->ray, n, i));
    const Vec3 ng(RTCHitN_Ng_x(args->hit, n, i), RTCHitN_Ng_y(args->hit, n, i), RTCHitN_Ng_z(args->hit, n, i));
    if (glm::dot(ng, direction) > 0.0f) args->valid[i] = 0;
  }
}

void reject_own_strand_or_from_inside(const RTCFilterFunctionNArguments* args) {
  reject_own_strand(args);
  reject_from_inside(args);
}

}  // namespace

struct Accel::Data {
  std::shared_ptr<Device> shared_device;
  RTCDevice device = nullptr;
  RTCScene top = nullptr, lamps = nullptr;
  // by mesh, as used by the instances in `top`; null for baked and empty meshes
  std::vector<void*> mesh_structures;
  bool only_still_instances = false;  // in `top`
  size_t placed = 0;
  InstanceCrowds crowds;       // in `top`, after the instances
  float farthest = kFarthest;  // maximum distance of the origins of rays: see farthest_through
  std::vector<uint32_t> lamp_of_geometry;
  std::vector<Light> few_lamps;  // a loop over few lamps is faster than a structure
  std::vector<uint32_t> few_lamp_indices;
  std::vector<Light> lamp_shapes;  // of geometries; never reallocated
  const std::atomic<bool>* stop = nullptr;

  ~Data() {
    if (lamps) rtcReleaseScene(lamps);
    if (top) rtcReleaseScene(top);
  }

  void check() {
    if (stop && stop->load(std::memory_order_relaxed)) throw Cancelled();
    std::lock_guard lock(shared_device->error_mutex);
    if (!shared_device->error.empty())
      throw SceneError("Building the ray tracing structure failed: " + std::exchange(shared_device->error, {}));
  }

  RTCScene new_scene() {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    watch(scene);
    return scene;
  }

  /// Lets the next build of the scene be stopped.
  void watch(RTCScene scene) {
    rtcSetSceneProgressMonitorFunction(
        scene,
        [](void* self, double) { return !(static_cast<Data*>(self)->stop && static_cast<Data*>(self)->stop->load()); },
        this);
  }

  /// Builds the scene. Its progress monitor is then removed, because the scene can outlive this object.
  static void commit(RTCScene scene) {
    rtcCommitScene(scene);
    rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  }

  bool take_top(Data& previous, const std::vector<BuiltInstance>& instances,
                const std::vector<BuiltInstance>& previous_instances);

  RTCGeometry new_geometry(const BuiltMesh& mesh) {
    RTCGeometry geometry = mesh.strands  ? new_strands(*mesh.strands)
                           : mesh.points ? new_points(*mesh.points)
                                         : new_triangles(mesh);
    // The default of Embree 3; that of Embree 4 is 1. The mask of the instance decides which rays see it.
    rtcSetGeometryMask(geometry, ~0u);
    return geometry;
  }

  RTCGeometry new_triangles(const BuiltMesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto set_positions = [&](unsigned key, const std::vector<Vec3>& positions) {
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, key, RTC_FORMAT_FLOAT3, positions.data(), 0,
                                 sizeof(Vec3), positions.size() - 1);
    };
    if (mesh.deformation) {
      rtcSetGeometryTimeStepCount(geometry, unsigned(mesh.deformation->keys.size()));
      for (unsigned key = 0; key < mesh.deformation->keys.size(); ++key)
        set_positions(key, mesh.deformation->keys[key].positions);
    } else {
      set_positions(0, mesh.positions);
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                               sizeof(UVec3), mesh.triangles.size());
    return geometry;
  }

  RTCGeometry new_strands(const Strands& strands) {
    const bool ribbons = strands.shape == StrandShape::Ribbon, linear = strands.shape == StrandShape::Linear;
    RTCGeometry geometry = rtcNewGeometry(device, ribbons  ? RTC_GEOMETRY_TYPE_FLAT_CATMULL_ROM_CURVE
                                                  : linear ? RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE
                                                           : RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE);
    // A straight piece has two keys, those in the middle of the four of a segment.
    set_keys(geometry, strands.keys, strands.motion, linear ? 1 : 0);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, strands.first_key.data(), 0,
                               sizeof(uint32_t), strands.first_key.size());
    if (linear)
      mark_joints(geometry, strands);
    else  // the same rate as in Cycles
      rtcSetGeometryTessellationRate(geometry, float((1 << strands.subdivisions) + 1));
    const auto filter = ribbons ? reject_own_strand : reject_own_strand_or_from_inside;
    rtcSetGeometryUserData(geometry, const_cast<Strands*>(&strands));
    rtcSetGeometryIntersectFilterFunction(geometry, filter);
    rtcSetGeometryOccludedFilterFunction(geometry, filter);
    return geometry;
  }

  RTCGeometry new_points(const Points& points) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    set_keys(geometry, points.spheres, points.motion);
    rtcSetGeometryIntersectFilterFunction(geometry, reject_from_inside);
    rtcSetGeometryOccludedFilterFunction(geometry, reject_from_inside);
    return geometry;
  }
};

namespace {

/// Whether two instances are equal in the top-level structure.
bool is_placed_alike(const BuiltInstance& a, const BuiltInstance& b) {
  return a.visibility == b.visibility && a.world_from_object == b.world_from_object;
}

void set_place(RTCGeometry geometry, const BuiltInstance& instance) {
  if (instance.motion) rtcSetGeometryTimeStepCount(geometry, instance.motion_count);
  for (uint32_t k = 0; k < instance.motion_count; ++k)
    rtcSetGeometryTransform(geometry, k, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &instance.motion[k][0][0]);
  if (!instance.motion)
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &instance.world_from_object[0][0]);
}

}  // namespace

Accel::Accel(std::vector<BuiltMesh>& meshes, const std::vector<BuiltInstance>& instances, bool compact,
             const std::atomic<bool>* stop, Accel* previous, const std::vector<BuiltInstance>& previous_instances)
    : data_(std::make_unique<Data>()) {
  Data& d = *data_;
  d.stop = stop;
  if (previous && previous->data_->shared_device->compact != compact) {
    previous = nullptr;
    for (BuiltMesh& mesh : meshes) mesh.structure.reset();
  }
  d.shared_device = previous ? previous->data_->shared_device : std::make_shared<Device>(compact);
  d.device = d.shared_device->handle;
  tbb::parallel_for(size_t(0), meshes.size(), [&](size_t i) {
    if (meshes[i].baked || meshes[i].empty() || meshes[i].structure || (stop && stop->load())) return;
    RTCScene scene = d.new_scene();
    // The device outlives its scenes by Embree's reference count; our Device object must outlive them as well.
    meshes[i].structure = std::shared_ptr<void>(
        scene, [device = d.shared_device](void* old) { rtcReleaseScene(static_cast<RTCScene>(old)); });
    RTCGeometry geometry = d.new_geometry(meshes[i]);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    d.commit(scene);
  });
  d.check();

  for (const BuiltInstance& instance : instances) {
    if (meshes[instance.mesh].baked) continue;
    if (!instance.motion) d.farthest = std::min(d.farthest, farthest_through(instance.object_from_world));
    for (uint32_t key = 0; instance.motion && key < instance.motion_count; ++key)
      d.farthest = std::min(d.farthest, farthest_through(glm::affineInverse(instance.motion[key])));
  }
  d.only_still_instances = true;
  for (const BuiltMesh& mesh : meshes) d.mesh_structures.push_back(mesh.baked ? nullptr : mesh.structure.get());
  for (const BuiltInstance& instance : instances)
    d.only_still_instances &= !instance.motion && d.mesh_structures[instance.mesh];
  d.crowds = InstanceCrowds(meshes, instances);
  if (previous && d.take_top(*previous->data_, instances, previous_instances)) return;

  d.top = d.new_scene();
  d.crowds.attach(d.device, d.top, meshes, instances);
  d.placed = d.crowds.instance_count();
  d.check();
  for (size_t i = 0; i < instances.size(); ++i) {
    const BuiltInstance& instance = instances[i];
    const BuiltMesh& mesh = meshes[instance.mesh];
    if (mesh.empty() || d.crowds.has(uint32_t(i))) continue;
    RTCGeometry geometry;
    if (mesh.baked) {
      geometry = d.new_geometry(mesh);
    } else {
      geometry = rtcNewGeometry(d.device, RTC_GEOMETRY_TYPE_INSTANCE);
      rtcSetGeometryInstancedScene(geometry, static_cast<RTCScene>(mesh.structure.get()));
      set_place(geometry, instance);
    }
    rtcSetGeometryMask(geometry, instance.visibility);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(d.top, geometry, unsigned(i));
    rtcReleaseGeometry(geometry);
    ++d.placed;
    if ((i & 1023) == 0) d.check();
  }
  d.commit(d.top);
  d.check();
}

/// Takes over the top-level structure of `previous` and updates the changed instances. Returns false if a new structure
/// is better.
bool Accel::Data::take_top(Data& previous, const std::vector<BuiltInstance>& instances,
                           const std::vector<BuiltInstance>& previous_instances) {
  if (!previous.top || !only_still_instances || !previous.only_still_instances ||
      instances.size() != previous_instances.size() || crowds != previous.crowds)
    return false;
  // The instances of an Embree scene own it. An equal address therefore means the same scene.
  std::vector<uint32_t> changed;
  for (size_t i = 0; i < instances.size(); ++i) {
    const BuiltInstance &now = instances[i], &before = previous_instances[i];
    if (mesh_structures[now.mesh] != previous.mesh_structures[before.mesh] || !is_placed_alike(now, before)) {
      if (crowds.has(uint32_t(i))) return false;
      changed.push_back(uint32_t(i));
    }
    if (changed.size() > instances.size() / 2) return false;
  }
  top = std::exchange(previous.top, nullptr);
  placed = changed.size();
  if (changed.empty()) return true;
  for (const uint32_t i : changed) {
    RTCGeometry geometry = rtcGetGeometry(top, i);
    rtcSetGeometryInstancedScene(geometry, static_cast<RTCScene>(mesh_structures[instances[i].mesh]));
    set_place(geometry, instances[i]);
    rtcSetGeometryMask(geometry, instances[i].visibility);
    rtcCommitGeometry(geometry);
  }
  watch(top);
  commit(top);
  check();
  return true;
}

size_t Accel::placed_instances() const { return data_->placed; }

Accel::~Accel() = default;

void Accel::build_lamps(const LightSet& lights) {
  Data& d = *data_;
  constexpr size_t kFew = 8;
  std::vector<uint32_t> shapes;
  for (uint32_t i = 0; i < lights.lamp_count(); ++i) {
    const Light light = lights.light(i);
    if (has_shape(light) && light.mis && !is_black(light.radiance)) shapes.push_back(i);
  }
  if (shapes.size() <= kFew) {
    for (uint32_t i : shapes) d.few_lamps.push_back(lights.light(i));
    d.few_lamp_indices = std::move(shapes);
    return;
  }
  d.lamps = d.new_scene();
  d.lamp_shapes.reserve(shapes.size());
  for (uint32_t i : shapes) {
    d.lamp_shapes.push_back(lights.light(i));
    RTCGeometry geometry = lamp_geometry(d.device, d.lamp_shapes.back());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(d.lamps, geometry, unsigned(d.lamp_of_geometry.size()));
    rtcReleaseGeometry(geometry);
    d.lamp_of_geometry.push_back(i);
  }
  d.commit(d.lamps);
  d.check();
}

namespace {

inline void fill(RTCRay& r, const Ray& ray, uint32_t mask) {
  r.org_x = ray.origin.x;
  r.org_y = ray.origin.y;
  r.org_z = ray.origin.z;
  r.tnear = ray.t_min;
  r.dir_x = ray.direction.x;
  r.dir_y = ray.direction.y;
  r.dir_z = ray.direction.z;
  r.time = ray.time;
  r.tfar = ray.t_max;
  r.mask = mask;
  r.id = ray.strand;
  r.flags = 0;
}

/// Whether Embree can trace the ray: it has no NaN and is not farther out than Embree can compute, where `farthest`
/// leaves room for the spaces of instances. Builds of Embree with assertions, such as Debian's, end the program for
/// other rays.
inline bool is_traceable(const Ray& ray, float farthest = kFarthest) {
  return length_squared(ray.origin) + length_squared(ray.direction) <= farthest * farthest && ray.t_min >= 0.0f &&
         ray.t_max <= kInfinity && ray.time >= 0.0f && ray.time <= 1.0f;
}

/// The nearest hit; its geomID is invalid if there is none.
inline RTCRayHit nearest(RTCScene scene, const Ray& ray, uint32_t mask, bool coherent) {
  RTCRayHit query;
  fill(query.ray, ray, mask);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree::intersect(scene, query, coherent);
  return query;
}

}  // namespace

void Accel::intersect(const Ray& ray, uint32_t ray_kind, Hit& hit) const {
  if (!is_traceable(ray, data_->farthest)) return;
  const uint32_t mask = ray_kind == kRayShadow ? ray.blockers : visibility_mask(ray_kind);
  const RTCRayHit query = nearest(data_->top, ray, mask, (ray_kind & kRayCamera) != 0);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    hit.instance = ~0u;
    hit.t = ray.t_max;
    return;
  }
  hit.t = query.ray.tfar;
  hit.instance = query.hit.instID[0] != RTC_INVALID_GEOMETRY_ID ? query.hit.instID[0] : query.hit.geomID;
  hit.primitive = query.hit.primID;
  data_->crowds.resolve(hit.instance, hit.primitive);
  hit.barycentric = Vec2(query.hit.u, query.hit.v);
}

bool Accel::occluded(const Ray& ray) const {
  if (!is_traceable(ray, data_->farthest)) return true;
  RTCRay query;
  fill(query, ray, ray.blockers);
  embree::occluded(data_->top, query);
  return query.tfar < 0.0f;
}

namespace {

Ray in_space_of(const BuiltInstance& instance, const Ray& ray) {
  Mat4 moved;
  const Mat4& m = object_from_world(instance, ray.time, moved);
  Ray inside = ray;
  inside.origin = transform_point(m, ray.origin);
  inside.direction = transform_vector(m, ray.direction);
  return inside;
}

}  // namespace

bool Accel::occluded_by(const BuiltInstance& instance, const BuiltMesh& mesh, const Ray& ray) const {
  if (!mesh.structure) return false;
  const Ray inside = in_space_of(instance, ray);
  if (!is_traceable(inside)) return true;
  RTCRay query;
  fill(query, inside, ~0u);
  embree::occluded(static_cast<RTCScene>(mesh.structure.get()), query);
  return query.tfar < 0.0f;
}

bool Accel::intersect_own(const BuiltInstance& instance, const BuiltMesh& mesh, const Ray& ray, Hit& hit) const {
  if (!mesh.structure) return false;
  const Ray inside = in_space_of(instance, ray);
  if (!is_traceable(inside)) return false;
  const RTCRayHit query = nearest(static_cast<RTCScene>(mesh.structure.get()), inside, ~0u, false);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit.t = query.ray.tfar;
  hit.primitive = query.hit.primID;
  hit.barycentric = Vec2(query.hit.u, query.hit.v);
  return true;
}

void Accel::intersect_lamp(const Ray& ray, uint32_t ray_kind, LampHit& hit) const {
  hit.light = ~0u;
  if (!data_->few_lamps.empty()) {
    const uint32_t mask = visibility_mask(ray_kind);
    Ray left = ray;
    for (size_t i = 0; i < data_->few_lamps.size(); ++i) {
      if (!(data_->few_lamps[i].visibility & mask)) continue;
      const auto crossing = intersect_lamp_shape(data_->few_lamps[i], left);
      if (!crossing) continue;
      left.t_max = hit.t = crossing->t;
      hit.light = data_->few_lamp_indices[i];
      hit.normal = crossing->normal;
    }
    return;
  }
  if (!data_->lamps || !is_traceable(ray)) return;
  Ray to_lamps = ray;
  to_lamps.strand = std::bit_cast<uint32_t>(ray.travelled);  // the shapes of lamps find it in the id of the ray
  const RTCRayHit query = nearest(data_->lamps, to_lamps, visibility_mask(ray_kind), false);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  hit.t = query.ray.tfar;
  hit.light = data_->lamp_of_geometry[query.hit.geomID];
  hit.normal = glm::normalize(Vec3(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z));
}

bool Accel::has_lamps() const { return data_->lamps != nullptr || !data_->few_lamps.empty(); }
uint64_t Accel::memory_bytes() const { return uint64_t(std::max<int64_t>(0, data_->shared_device->bytes.load())); }

void Accel::bounds(Vec3& lower, Vec3& upper) const {
  RTCBounds b;
  rtcGetSceneBounds(data_->top, &b);
  lower = Vec3(b.lower_x, b.lower_y, b.lower_z);
  upper = Vec3(b.upper_x, b.upper_y, b.upper_z);
}

std::string embree_version() {
  const Device device;
  const auto version = int(rtcGetDeviceProperty(device.handle, RTC_DEVICE_PROPERTY_VERSION));
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

std::string tbb_version() { return TBB_runtime_version(); }

}  // namespace ajar
