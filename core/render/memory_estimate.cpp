#include "render/memory_estimate.h"

#include <algorithm>

#include "choice/mixture.h"
#include "film/film.h"
#include "geometry/uv_tangents.h"
#include "integrators/gather_passes.h"
#include "integrators/integrator.h"
#include "scene/dice_meshes.h"
#include "scene/instance_crowds.h"
#include "scene/scene.h"
#include "shading/images/texture.h"
#include "shading/images/tile_cache.h"
#include "transport/bidirectional/further_samples.h"
#include "transport/bidirectional/vertex_merging.h"
#include "transport/guiding/path_guide.h"
#include "transport/media/media.h"
#include "transport/photons/irradiance_records.h"

namespace ajar {

namespace {

const MeshDescription& shared_or_own(const MeshDescription& mesh) { return mesh.shared ? *mesh.shared : mesh; }

/// Number of segments of its strands.
uint64_t segments_of(const MeshDescription& mesh) {
  return mesh.positions.size() > mesh.strands.size() ? mesh.positions.size() - mesh.strands.size() : 0;
}

/// Of its arrays, at most: values of corners that agree take less memory (geometry/shared_corners.h).
uint64_t bytes_of(const MeshDescription& mesh) {
  uint64_t bytes = (mesh.positions.size() + 1) * sizeof(Vec3) + mesh.triangles.size() * sizeof(UVec3) +
                   mesh.material_slots.size() * sizeof(uint16_t) + mesh.normals.size() * sizeof(Vec3);
  for (const Attribute& attribute : mesh.attributes) bytes += attribute.values.size() * sizeof(float);
  const size_t shapes = shape_count(mesh);
  bytes += shapes * (mesh.positions.size() + mesh.normals.size()) * sizeof(Vec3);
  for (const VolumeGrid& grid : mesh.grids)
    bytes += grid.values.size() * sizeof(float) +
             grid.bricks.size() *
                 (sizeof(grid.bricks[0]) + 4 * sizeof(uint32_t));  // at most four places of a table each
  if (mesh.is_points())
    return bytes + (1 + shapes) * mesh.positions.size() * (sizeof(Vec4) - sizeof(Vec3));  // spheres replace positions
  if (mesh.strands.empty()) return bytes;
  const size_t points = mesh.positions.size(), strands = mesh.strands.size(), segments = segments_of(mesh);
  bytes += (points + 2 * strands) * (1 + shapes) * sizeof(Vec4) + points * sizeof(float) +
           strands * (sizeof(uint32_t) + sizeof(float)) + segments * sizeof(uint32_t);
  if (!mesh.material_slots.empty()) bytes += segments * sizeof(uint16_t);  // per segment, not per strand
  return bytes - (1 + shapes) * points * sizeof(Vec3);                     // the keys replace the positions
}

/// What the triangles of an adaptive subdivision need, about.
uint64_t bytes_after_subdivision(const MeshDescription& mesh, const DicingRate& rate, uint64_t of_structure) {
  const uint64_t triangles = uint64_t(estimate_diced_triangles(mesh, rate)), vertices = triangles / 2;
  uint64_t bytes = vertices * 2 * sizeof(Vec3) + triangles * (sizeof(UVec3) + sizeof(uint16_t)) +
                   mesh.subdivision.tangents.size() * triangles * 3 * sizeof(Vec4);
  for (const Attribute& attribute : mesh.attributes)
    bytes += uint64_t(attribute.components) * sizeof(float) *
             (attribute.domain == Domain::Vertex   ? vertices
              : attribute.domain == Domain::Corner ? 3 * triangles
                                                   : triangles);
  return bytes + triangles * of_structure;
}

/// What the displacement of its materials adds to each mesh: the original positions, normals and tangents.
std::vector<uint64_t> bytes_of_displacements(const SceneDescription& d) {
  std::vector<uint64_t> bytes(d.meshes.size(), 0);
  for (const ObjectDescription& object : d.objects) {
    if (object.mesh < 0 || object.mesh >= int(d.meshes.size())) continue;
    const MeshDescription& mesh = shared_or_own(d.meshes[size_t(object.mesh)]);
    if (mesh.triangles.empty()) continue;
    for (const int index : object.materials) {
      if (index < 0 || index >= int(d.materials.size())) continue;
      const MaterialDescription& material = d.materials[size_t(index)];
      if (material.graph.displacement.node < 0 || material.displacement_method == DisplacementMethod::Bump) continue;
      uint64_t added = mesh.positions.size() * sizeof(Vec3);
      if (material.displacement_method == DisplacementMethod::Both) {
        added += (mesh.positions.size() + 1 + mesh.normals.size()) * sizeof(Vec3);
        for (const Attribute& attribute : mesh.attributes)
          if (attribute.name.starts_with(kTangentOf)) added += attribute.values.size() * sizeof(float);
      }
      bytes[size_t(object.mesh)] = std::max(bytes[size_t(object.mesh)], added);
    }
  }
  return bytes;
}

/// Of each object with instances: the instance in Embree's structure, or its triangles (instance_crowds.h).
uint64_t bytes_of_instance_structure(const SceneDescription& d, uint64_t of_triangle) {
  std::vector<uint64_t> each(d.objects.size(), kStructureBytesPerInstance);
  for (size_t i = 0; i < d.objects.size(); ++i) {
    const int index = d.objects[i].mesh;
    if (index < 0 || index >= int(d.meshes.size())) continue;
    const MeshDescription& mesh = shared_or_own(d.meshes[size_t(index)]);
    if (mesh.triangles.size() <= InstanceCrowds::kMostTriangles)
      each[i] = std::max(each[i], mesh.triangles.size() * (of_triangle + sizeof(UVec3)) +
                                      std::min(mesh.positions.size(), 3 * mesh.triangles.size()) * sizeof(Vec3));
  }
  uint64_t bytes = 0;
  for (const InstanceDescription& instance : d.instances)
    bytes += instance.object >= 0 && size_t(instance.object) < each.size() ? each[size_t(instance.object)]
                                                                           : kStructureBytesPerInstance;
  return bytes;
}

void add(MemoryPart& part, const std::string& name, uint64_t bytes) {
  part.bytes += bytes;
  if (bytes <= part.largest_bytes) return;
  part.largest = name;
  part.largest_bytes = bytes;
}

/// Whole images, the tiles of the others within their limit, and what is needed while the largest file of tiles is made:
/// the decoded image, the texture and its next level.
void add_textures(const SceneDescription& d, MemoryPart& part) {
  const TextureCacheOptions cache = texture_cache_of(d.settings);
  uint64_t tiled = 0, largest_made = 0;
  for (const ImageDescription& image : d.images) {
    const uint64_t bytes = texture_bytes(image);
    const TiledUse use = bytes > 0 ? tiled_use(image, d.color, cache) : TiledUse::Whole;
    if (use == TiledUse::Whole) {
      add(part, image.name.empty() ? image.path : image.name, bytes);
      continue;
    }
    tiled += bytes + bytes / 3;
    if (use == TiledUse::Made) largest_made = std::max(largest_made, 2 * bytes + bytes / 3);
  }
  if (tiled > 0) add(part, "texture cache", std::min(tiled, uint64_t(cache.megabytes) << 20));
  if (largest_made > 0) add(part, "new file of the texture cache", largest_made);
}

bool may_merge(const RenderSettings& s) {
  const IntegratorInfo& integrator = find_integrator(s.integrator);
  return s.vertex_merging == Merging::On && (integrator.automatic || integrator.can_merge);
}

/// Maximum memory of the volumes of instances and of the world; 0 without volumes.
uint64_t bytes_of_volumes(const SceneDescription& d) {
  const auto has_volume = [&](int material) {
    return material >= 0 && material < int(d.materials.size()) && d.materials[size_t(material)].graph.volume.node >= 0;
  };
  std::vector<uint64_t> volumes_of(d.objects.size(), 0);
  for (size_t i = 0; i < d.objects.size(); ++i)
    volumes_of[i] = uint64_t(std::count_if(d.objects[i].materials.begin(), d.objects[i].materials.end(), has_volume));
  uint64_t volumes = d.world.graph.volume.node >= 0 ? 1 : 0;
  for (const InstanceDescription& instance : d.instances)
    if (instance.object >= 0 && instance.object < int(d.objects.size())) volumes += volumes_of[size_t(instance.object)];
  return volumes > 0 ? Media::max_bytes(volumes, d.instances.size()) : 0;
}

/// Text such as "1,234 MiB", rounded up.
std::string mebibytes(uint64_t bytes) {
  std::string digits = std::to_string((bytes + (1 << 20) - 1) >> 20);
  for (int at = int(digits.size()) - 3; at > 0; at -= 3) digits.insert(size_t(at), ",");
  return digits + " MiB";
}

/// Whether an additional pilot is rendered (importance_map.h).
bool measures_important_light(const SceneDescription& d) {
  const auto matters = [](const auto& source) { return source.light_importance != 1.0f; };
  return d.settings.image == ImageSampling::PmcIp &&
         (matters(d.world) || std::any_of(d.lights.begin(), d.lights.end(), matters) ||
          std::any_of(d.objects.begin(), d.objects.end(), matters));
}

}  // namespace

uint64_t MemoryEstimate::bytes() const {
  uint64_t sum = 0;
  for (const MemoryPart& part : parts) sum += part.bytes;
  return sum;
}

MemoryEstimate estimate_memory(const SceneDescription& d) {
  MemoryPart geometry{"geometry"}, instances{"instances"}, textures{"textures"}, volumes{"volumes"}, photons{"photons"},
      guide{"path guide"}, records{"irradiance records"}, film{"the picture"};
  const std::vector<uint64_t> displacements = bytes_of_displacements(d);
  const uint64_t of_structure = d.settings.compact_bvh ? kCompactBytesPerTriangle : kStructureBytesPerTriangle;
  for (size_t i = 0; i < d.meshes.size(); ++i) {
    const MeshDescription& mesh = shared_or_own(d.meshes[i]);
    add(geometry, mesh.name,
        bytes_of(mesh) + displacements[i] + mesh.triangles.size() * of_structure + kStructureBytesPerMesh +
            (mesh.subdivision.empty()
                 ? 0
                 : bytes_after_subdivision(mesh, dicing_rate_of(d, i, dicing_pixels(d)), of_structure)) +
            (mesh.strands.empty() ? 0 : segments_of(mesh) * kStructureBytesPerSegment) +
            (mesh.is_points() ? mesh.positions.size() * kStructureBytesPerPoint : 0));
  }
  instances.bytes = d.instances.size() * sizeof(BuiltInstance) + bytes_of_instance_structure(d, of_structure) +
                    d.motion_keys.size() * sizeof(Mat4) + 2 * d.camera.texels.size() * sizeof(Texel) +
                    d.instance_origins.size() * sizeof(InstanceOrigin);
  add_textures(d, textures);
  volumes.bytes = bytes_of_volumes(d);
  const RenderSettings& s = d.settings;
  const IntegratorInfo& integrator = find_integrator(s.integrator);
  if (integrator.gathers_photons || may_merge(s)) {
    const uint64_t paths = s.photons > 0 ? uint64_t(s.photons) : photons_of_a_pass(double(s.width) * s.height);
    photons.bytes = paths * kPhotonsPerPath * (kBytesPerPhoton + (may_merge(s) ? VertexMerging::kBytesBehind : 0));
  }
  const auto& r = s.region;
  const bool whole = r == std::array<int, 4>{0, 0, 0, 0};
  const uint64_t pixels = whole ? uint64_t(s.width) * uint64_t(s.height)
                                : uint64_t(std::max(0, r[2] - r[0])) * uint64_t(std::max(0, r[3] - r[1]));
  if (s.guiding != Guiding::Off && integrator.can_guide)
    guide.bytes = PathGuide::estimated_bytes(pixels, s.samples > 0 ? uint64_t(s.samples) : ~uint64_t(0));
  // At most one record for four pixels.
  if (integrator.stores_records) records.bytes = pixels / 4 * IrradianceRecords::kBytesPerRecord;
  const bool splats = integrator.splats || (integrator.samples_lens_light && d.camera.aperture_radius > 0.0f);
  film.bytes = pixels * Film::bytes_per_pixel(s.passes, splats);
  if (integrator.automatic && s.denoised && can_mix(s.passes))
    film.bytes += pixels * Film::bytes_per_pixel(Mixture::passes_of_others(s.passes), true);
  if (integrator.takes_further_samples) film.bytes += pixels * FurtherSamples::bytes_per_pixel();
  if (s.image == ImageSampling::PmcIp && make_integrator(s.integrator)->goal_support().follows)
    film.bytes += pixels * (sizeof(uint32_t) + EarlySamples::kMaxBytesPerPixel);  // the goal of each pixel
  if (measures_important_light(d))
    film.bytes += pixels * (Film::bytes_per_pixel({"Combined"}, false) + 4 * sizeof(Vec2));
  MemoryEstimate estimate{{geometry, instances, textures, volumes, photons, guide, records, film}};
  std::stable_sort(estimate.parts.begin(), estimate.parts.end(),
                   [](const MemoryPart& a, const MemoryPart& b) { return a.bytes > b.bytes; });
  return estimate;
}

void check_memory_limit(const SceneDescription& d) {
  const uint64_t limit = uint64_t(std::max(0, d.settings.memory_limit)) << 20;
  if (limit == 0) return;
  const MemoryEstimate estimate = estimate_memory(d);
  if (estimate.bytes() <= limit) return;
  std::string parts;
  for (const MemoryPart& part : estimate.parts) {
    if (part.bytes < estimate.bytes() / 100) continue;
    parts += (parts.empty() ? "" : ", ") + part.what + " " + mebibytes(part.bytes);
    if (!part.largest.empty()) parts += " ('" + part.largest + "' " + mebibytes(part.largest_bytes) + ")";
  }
  throw SceneError("This render needs about " + mebibytes(estimate.bytes()) + ", more than the memory limit of " +
                   mebibytes(limit) + ": " + parts + ".");
}

}  // namespace ajar
