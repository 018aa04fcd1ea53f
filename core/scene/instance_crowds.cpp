#include "scene/instance_crowds.h"

#include <map>

#include <tbb/parallel_for.h>

#include "description/diagnostics.h"
#include "scene/embree.h"

namespace ajar {

namespace {

/// Minimum extent of an instance over its distance from the origin. Smaller ones would lose their shape to rounding.
constexpr float kLeastExtent = 1.0f / 8192.0f;

bool suits(const BuiltMesh& mesh) {
  return mesh.has_triangles() && !mesh.empty() && !mesh.baked && !mesh.deformation &&
         mesh.triangles.size() <= InstanceCrowds::kMostTriangles &&
         mesh.positions.size() - 1 <= 3 * mesh.triangles.size();
}

bool keeps_its_shape(const BuiltMesh& mesh, const Mat4& world) {
  Vec3 lower(kInfinity), upper(-kInfinity);
  for (size_t v = 0; v + 1 < mesh.positions.size(); ++v) {
    const Vec3 p = transform_point(world, mesh.positions[v]);
    lower = glm::min(lower, p);
    upper = glm::max(upper, p);
  }
  const float farthest = max_component(glm::max(glm::abs(lower), glm::abs(upper)));
  return max_component(upper - lower) >= kLeastExtent * farthest;
}

}  // namespace

InstanceCrowds::InstanceCrowds(std::vector<BuiltMesh>& meshes, const std::vector<BuiltInstance>& instances) {
  for (BuiltMesh& mesh : meshes) mesh.crowded = false;
  std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> alike;
  for (uint32_t i = 0; i < instances.size(); ++i) {
    const BuiltInstance& instance = instances[i];
    const BuiltMesh& mesh = meshes[instance.mesh];
    if (suits(mesh) && !instance.motion && keeps_its_shape(mesh, instance.world_from_object))
      alike[{instance.mesh, instance.visibility}].push_back(i);
  }
  size_t left = kMostOfAll;
  for (auto& [key, members] : alike) {
    BuiltMesh& mesh = meshes[key.first];
    const size_t triangles = members.size() * mesh.triangles.size();
    if (members.size() < kFewest || triangles > left) continue;
    left -= triangles;
    mesh.crowded = true;
    is_member_.resize(instances.size(), false);
    for (const uint32_t i : members) is_member_[i] = true;
    crowds_.push_back({key.first, key.second, uint32_t(mesh.triangles.size()), std::move(members)});
  }
  if (!crowds_.empty()) first_ = uint32_t(instances.size());
}

size_t InstanceCrowds::instance_count() const {
  size_t count = 0;
  for (const Crowd& crowd : crowds_) count += crowd.instances.size();
  return count;
}

void InstanceCrowds::attach(RTCDevice device, RTCScene scene, const std::vector<BuiltMesh>& meshes,
                            const std::vector<BuiltInstance>& instances) const {
  for (size_t c = 0; c < crowds_.size(); ++c) {
    const Crowd& crowd = crowds_[c];
    const BuiltMesh& mesh = meshes[crowd.mesh];
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const size_t vertices = mesh.positions.size() - 1;
    const auto buffer = [&]<class Item>(RTCBufferType type, RTCFormat format, size_t each) {
      return static_cast<Item*>(
          rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), each * crowd.instances.size()));
    };
    Vec3* const positions = buffer.operator()<Vec3>(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, vertices);
    UVec3* const triangles = buffer.operator()<UVec3>(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, crowd.triangles);
    if (!positions || !triangles) {
      rtcReleaseGeometry(geometry);
      throw SceneError("There is not enough memory for the ray tracing structure of the instances.");
    }
    tbb::parallel_for(size_t(0), crowd.instances.size(), [&](size_t k) {
      const Mat4& world = instances[crowd.instances[k]].world_from_object;
      for (size_t v = 0; v < vertices; ++v) positions[k * vertices + v] = transform_point(world, mesh.positions[v]);
      for (size_t t = 0; t < crowd.triangles; ++t)
        triangles[k * crowd.triangles + t] = mesh.triangles[t] + uint32_t(k * vertices);
    });
    rtcSetGeometryMask(geometry, crowd.visibility);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, first_ + unsigned(c));
    rtcReleaseGeometry(geometry);
  }
}

}  // namespace ajar
