// The emissive triangles of a LightSet: which instances emit, and the power of each triangle.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include <tbb/parallel_for.h>

#include "lights/light_set_data.h"

namespace ajar {

namespace {

/// Triangles with varying emission also get this fraction of the mean of their instance.
constexpr float kTriangleFloor = 0.05f;
/// With more triangles of varying emission than this in the scene, each is rated by its centre alone, else at four points
/// or more: a screen of two triangles shows a whole image.
constexpr size_t kManyVarying = 20000;
constexpr uint32_t kPointsOfMesh = 1024, kMostPoints = 512;
constexpr uint32_t kChunk = 1024;  ///< triangles in a task
/// With at least so many triangles in all its instances, a mesh that emits alike in all of them is a cluster in each.
constexpr size_t kClusteredTriangles = size_t(1) << 18;

/// A mesh and the programs of its slots.
using EmissionKey = std::pair<uint32_t, std::vector<const ShaderProgram*>>;

double volume_scale(const BuiltInstance& instance) {
  return std::abs(double(glm::determinant(Mat3(instance.world_from_object))));
}
/// False for an instance that is flat or a point: it has no object space.
bool is_invertible(const BuiltInstance& instance) {
  const Mat4& inverse = instance.object_from_world;
  return volume_scale(instance) > 0.0 && is_finite(Vec3(inverse[0])) && is_finite(Vec3(inverse[1])) &&
         is_finite(Vec3(inverse[2])) && is_finite(Vec3(inverse[3]));
}

}  // namespace

/// An instance that may emit, and the watts of its triangles.
struct LightSet::Data::Pending {
  TriangleBlock block;
  bool constant = true, grows = false;
  std::shared_ptr<std::vector<float>> luminances;  ///< of triangles of varying emission
  std::vector<double> power;
  double total = 0.0;     ///< without what is added to triangles of varying emission
  bool may_emit = false;  ///< some power, or a program that can emit
  int growth = 0;
  int leader = -1;  ///< of instances that are clusters of the same mesh: the first one of them
  int shared = -1;  ///< LightClusters::Shared

  /// Instances with equal keys emit alike. Empty if the emission depends on more than the mesh.
  std::optional<EmissionKey> emission_key(uint32_t mesh) const {
    EmissionKey key{mesh, {}};
    for (const SlotEmission& slot : block.slots) {
      if (slot.program && !slot.program->emission_depends_on_mesh_alone()) return {};
      key.second.push_back(slot.program);
    }
    return key;
  }
};

std::vector<LightSet::Data::Pending> LightSet::Data::gather_blocks(const LightBuildInput& in,
                                                                   Diagnostics& diagnostics) const {
  std::vector<SlotEmission> emissions(in.programs.size());  // of each program
  for (size_t i = 0; i < in.programs.size(); ++i) {
    const ShaderProgram& program = in.programs[i];
    if (!program.emits()) continue;
    emissions[i].program = &program;
    emissions[i].constant = program.emission_is_constant();
    if (emissions[i].constant) emissions[i].radiance = program.evaluate_emission(ShadingPoint());
  }
  std::vector<Pending> blocks;
  uint64_t triangles = lamps.size();
  for (size_t i = 0; i < in.instances.size(); ++i) {
    const BuiltInstance& instance = in.instances[i];
    const BuiltMesh& mesh = in.meshes[instance.mesh];
    const uint32_t count = uint32_t(mesh.triangles.size()), slots = std::max(1u, instance.material_count);
    const uint32_t* const materials = &in.material_table[instance.first_material];
    if (std::none_of(materials, materials + slots, [&](uint32_t m) { return emissions[m].program != nullptr; }))
      continue;
    Pending pending;
    bool emits = false;
    for (uint32_t slot = 0; slot < slots; ++slot) {
      SlotEmission emission = emissions[materials[slot]];
      if (emission.program && !is_finite(emission.radiance)) {
        report_once(diagnostics,
                    {Diagnostic::Severity::Error, in.objects[instance.object].name,
                     "The emission of a material is not a finite number; the object is not used as a light."});
        emission.program = nullptr;
      }
      if (emission.program) {
        emits |= !emission.constant || !is_black(emission.radiance);
        pending.constant &= emission.constant;
        pending.grows |= emission.program->emission_depends_on_distance();
      }
      pending.block.slots.push_back(emission);
    }
    if (emits && !mesh.has_triangles())
      report_once(diagnostics,
                  {Diagnostic::Severity::Warning, in.objects[instance.object].name,
                   mesh.strands ? "The object's hair emits light, which only random rays find: expect noise."
                                : "The point cloud emits light, which only random rays find: expect noise."});
    if (!emits || count == 0) continue;
    if (triangles + count > 0x7fffffffu) {
      report_once(diagnostics, {Diagnostic::Severity::Error, in.objects[instance.object].name,
                                "Too many emissive triangles; the object is not used as a light."});
      continue;
    }
    triangles += count;
    pending.block.instance = uint32_t(i);
    pending.block.count = count;
    blocks.push_back(std::move(pending));
  }
  return blocks;
}

/// Mean luminances of the triangles of varying emission. Instances of a mesh share them if the emission depends on the
/// mesh alone.
void LightSet::Data::find_luminances(const LightBuildInput& in, std::vector<Pending>& blocks) const {
  struct Chunk {
    uint32_t block, begin, end;
  };
  std::vector<Chunk> chunks;
  std::map<EmissionKey, uint32_t> known;
  size_t varying = 0;
  for (uint32_t i = 0; i < blocks.size(); ++i) {
    Pending& pending = blocks[i];
    if (pending.constant) continue;
    if (auto key = pending.emission_key(in.instances[pending.block.instance].mesh)) {
      const auto [found, is_new] = known.emplace(std::move(*key), i);
      if (!is_new) {
        pending.luminances = blocks[found->second].luminances;
        continue;
      }
    }
    const uint32_t count = pending.block.count;
    pending.luminances = std::make_shared<std::vector<float>>(count, 0.0f);
    varying += count;
    for (uint32_t t = 0; t < count; t += kChunk) chunks.push_back({i, t, std::min(t + kChunk, count)});
  }
  const auto points_of = [&](const Pending& pending) {
    return varying > kManyVarying ? 1 : int(std::clamp(kPointsOfMesh / pending.block.count, 4u, kMostPoints));
  };
  tbb::parallel_for(size_t(0), chunks.size(), [&](size_t c) {
    const Pending& pending = blocks[chunks[c].block];
    const BuiltInstance& instance = in.instances[pending.block.instance];
    const BuiltMesh& mesh = in.meshes[instance.mesh];
    const int points = points_of(pending);
    for (uint32_t t = chunks[c].begin; t != chunks[c].end; ++t) {
      const SlotEmission& emission = emission_of(pending.block, t);
      if (!emission.program || emission.constant) continue;
      const WorldTriangle triangle = world_triangle(mesh, instance, t, kMidShutter);
      (*pending.luminances)[t] = float(
          luminous(mean_emission(*emission.program, in.objects[instance.object],
                                 {mesh, instance, t, triangle, kMidShutter, kFar * scene_radius}, points)));
    }
  });
}

/// Finds meshes with so many instances that these become clusters: they emit alike, and they do not move.
void LightSet::Data::find_clusters(const LightBuildInput& in, std::vector<Pending>& blocks) {
  std::map<EmissionKey, std::vector<int>> alike;
  for (size_t i = 0; i < blocks.size(); ++i) {
    const BuiltInstance& instance = in.instances[blocks[i].block.instance];
    if (blocks[i].grows || ajar::moves(in.meshes[instance.mesh], instance)) continue;
    if (!is_invertible(instance)) continue;
    if (auto key = blocks[i].emission_key(instance.mesh)) alike[std::move(*key)].push_back(int(i));
  }
  for (const auto& [key, instances] : alike) {
    if (instances.size() < 2) continue;
    if (instances.size() * size_t(blocks[size_t(instances[0])].block.count) < kClusteredTriangles) continue;
    for (const int i : instances) blocks[size_t(i)].leader = instances[0];
  }
}

/// Watts of every triangle, both sides. Where the emission varies, a fraction of the mean is added.
void LightSet::Data::rate_triangles(const LightBuildInput& in, const BuiltInstance& instance, Pending& pending) const {
  std::vector<float> areas(pending.constant ? 0 : pending.block.count, 0.0f);
  pending.power.resize(pending.block.count);
  double area = 0.0;
  for (uint32_t t = 0; t < pending.block.count; ++t) {
    const SlotEmission& emission = emission_of(pending.block, t);
    if (!emission.program) continue;
    const float a = world_triangle(in.meshes[instance.mesh], instance, t, kMidShutter).area;
    const double watts = 2.0 * M_PI * double(a) *
                         (emission.constant ? luminous(emission.radiance) : double((*pending.luminances)[t]));
    pending.total += pending.power[t] = std::isfinite(watts) ? watts : 0.0;
    if (!emission.constant && std::isfinite(a)) area += double(areas[t] = a);
  }
  pending.may_emit = pending.total > 0.0;
  if (!(area > 0.0)) return;
  pending.may_emit = true;
  const double floor = pending.total > 0.0 ? double(kTriangleFloor) * pending.total / area : 1.0;
  for (uint32_t t = 0; t < pending.block.count; ++t) pending.power[t] += floor * double(areas[t]);
}

/// The power of all blocks. The triangles of clusters are rated once, in object space.
void LightSet::Data::rate(const LightBuildInput& in, std::vector<Pending>& blocks) {
  find_clusters(in, blocks);
  find_luminances(in, blocks);
  tbb::parallel_for(size_t(0), blocks.size(), [&](size_t i) {
    Pending& pending = blocks[i];
    const BuiltInstance& instance = in.instances[pending.block.instance];
    if (pending.leader >= 0 && size_t(pending.leader) != i) return;
    rate_triangles(in, pending.leader >= 0 ? in_object_space(instance) : instance, pending);
    if (pending.grows) pending.growth = growth_of(pending.block, in);
  });
  std::vector<double> totals(blocks.size(), 0.0);  // in object space
  for (size_t i = 0; i < blocks.size(); ++i) {
    Pending& pending = blocks[i];
    if (size_t(pending.leader) != i) continue;
    const BuiltInstance& instance = in.instances[pending.block.instance];
    if (pending.may_emit) pending.shared = clusters.share(in.meshes[instance.mesh], instance, pending.power);
    totals[i] = pending.total;
    pending.power.clear();
  }
  for (Pending& pending : blocks) {
    if (pending.leader < 0) continue;
    const size_t leader = size_t(pending.leader);
    pending.shared = blocks[leader].shared;
    pending.may_emit = pending.shared >= 0;
    // Areas grow with the square of the scale; of an uneven scale, with that of its mean.
    pending.total = totals[leader] * std::pow(volume_scale(in.instances[pending.block.instance]), 2.0 / 3.0);
  }
}

void LightSet::Data::add_triangles(const LightBuildInput& in, Diagnostics& diagnostics, std::vector<Source>& sources,
                                   std::vector<double>& weights) {
  if (!in.with_meshes) return;
  std::vector<Pending> pending = gather_blocks(in, diagnostics);
  rate(in, pending);
  for (Pending& p : pending) {
    if (!p.may_emit) continue;
    BuiltInstance& instance = in.instances[p.block.instance];
    p.block.first = instance.first_light = size;
    const uint32_t first_entry = uint32_t(weights.size());
    if (p.shared >= 0)
      weights.push_back(1.0);
    else
      weights.insert(weights.end(), p.power.begin(), p.power.end());
    if (!clusters.empty()) clusters.add(size, p.block.count, instance, p.shared);
    size += p.block.count;
    const LightLinks& links = in.objects[instance.object].links;
    p.block.receivers = links.receivers;
    p.block.blockers = blockers_of(links);
    any_without_walks |= p.block.blockers != kVisibleShadow;
    any_linked |= p.block.receivers != kAllReceivers;
    any_partial |= LightFlags{LightType::Triangle, instance.visibility}.partial() || p.block.blockers != kVisibleShadow;
    sources.push_back(
        {p.block.first, first_entry, uint32_t(weights.size()) - first_entry, p.total, 1.0, p.growth, p.shared});
    blocks.push_back(std::move(p.block));
  }
}

/// The growth of the emission of some triangles of a block.
int LightSet::Data::growth_of(const TriangleBlock& block, const LightBuildInput& in) const {
  double near = 0.0, far = 0.0;
  const BuiltInstance& instance = in.instances[block.instance];
  const BuiltMesh& mesh = in.meshes[instance.mesh];
  for (uint32_t t = 0; t < block.count; t += std::max(1u, block.count / 64)) {
    const SlotEmission& emission = emission_of(block, t);
    if (!emission.program) continue;
    const WorldTriangle triangle = world_triangle(mesh, instance, t, kMidShutter);
    const auto mean_at = [&](float distance) {
      const double mean = luminous(mean_emission(*emission.program, in.objects[instance.object],
                                                 {mesh, instance, t, triangle, kMidShutter, distance * scene_radius},
                                                 1));
      return std::isfinite(mean) ? mean * double(triangle.area) : 0.0;
    };
    near += mean_at(kNear);
    far += mean_at(kFar);
  }
  return growth_between(near, far);
}

}  // namespace ajar
