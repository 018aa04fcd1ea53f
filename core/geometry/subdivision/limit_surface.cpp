#include "geometry/subdivision/limit_surface.h"

#include <opensubdiv/far/patchMap.h>
#include <opensubdiv/far/patchTable.h>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace ajar {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

constexpr int kMaxWeights = 20;     // of a patch of OpenSubdiv
constexpr float kSharpest = 10.0f;  // sharpness of OpenSubdiv that is never smooth

/// A value in the form that OpenSubdiv refines.
struct Refined {
  Vec3 value{0.0f};
  void Clear(void* = nullptr) { value = Vec3(0.0f); }
  void AddWithWeight(const Refined& other, float weight) { value += other.value * weight; }
};

struct Weights {
  float value[kMaxWeights], du[kMaxWeights], dv[kMaxWeights];
};

class FlatSurface : public LimitSurface {
 public:
  FlatSurface(const MeshDescription& mesh, std::span<const SurfacePatch> patches) : mesh_(mesh), patches_(patches) {}
  Vec3 position(PatchPoint point) const override {
    return interpolate_face(patches_[point.patch], point.uv, [&](uint32_t corner) {
      return mesh_.positions[mesh_.subdivision.corner_vertices[corner]];
    });
  }
  void evaluate(PatchPoint point, Vec3& at, Vec3& normal) const override {
    at = position(point);
    normal = Vec3(0.0f);
  }
  bool is_smooth(size_t) const override { return false; }
  Vec3 smooth_value(size_t, PatchPoint) const override { return Vec3(0.0f); }

 private:
  const MeshDescription& mesh_;
  const std::span<const SurfacePatch> patches_;
};

/// The values of a UV map, with equal corners of a vertex as one value.
struct MergedMap {
  size_t attribute = 0;
  std::vector<Far::Index> of_corner;
  std::vector<Vec3> values;
};

MergedMap merge(const MeshDescription& mesh, size_t index) {
  const std::vector<uint32_t>& vertices = mesh.subdivision.corner_vertices;
  const Attribute& map = mesh.attributes[index];
  MergedMap merged;
  merged.attribute = index;
  merged.of_corner.resize(vertices.size());
  std::vector<Far::Index> first(mesh.positions.size(), -1), next;  // the values of each vertex, as lists
  for (size_t c = 0; c < vertices.size(); ++c) {
    const Vec3 uv(map.values[2 * c], map.values[2 * c + 1], 0.0f);
    Far::Index at = first[vertices[c]];
    while (at >= 0 && merged.values[size_t(at)] != uv) at = next[size_t(at)];
    if (at < 0) {
      at = Far::Index(merged.values.size());
      merged.values.push_back(uv);
      next.push_back(first[vertices[c]]);
      first[vertices[c]] = at;
    }
    merged.of_corner[c] = at;
  }
  return merged;
}

/// Sharp vertices, with those between two sharp edges of a single face, as in Blender and Cycles.
struct Corners {
  std::vector<Far::Index> vertices;
  std::vector<float> sharpness;
};

Corners corners_of(const MeshDescription& mesh) {
  const SubdivisionDescription& s = mesh.subdivision;
  Corners corners{{s.creased_vertices.begin(), s.creased_vertices.end()}, s.vertex_sharpness};
  if (s.creased_edges.empty()) return corners;
  std::vector<uint8_t> faces(mesh.positions.size(), 0), edges(mesh.positions.size(), 0);
  std::vector<float> least(mesh.positions.size(), kSharpest), given(mesh.positions.size(), 0.0f);
  for (const uint32_t vertex : s.corner_vertices) faces[vertex] = uint8_t(std::min(faces[vertex] + 1, 2));
  for (size_t i = 0; i < s.creased_edges.size(); ++i)
    for (const uint32_t vertex : s.creased_edges[i]) {
      edges[vertex] = uint8_t(std::min(edges[vertex] + 1, 3));
      least[vertex] = std::min(least[vertex], s.edge_sharpness[i]);
    }
  for (size_t i = 0; i < s.creased_vertices.size(); ++i) given[s.creased_vertices[i]] = s.vertex_sharpness[i];
  for (size_t v = 0; v < faces.size(); ++v) {
    if (faces[v] != 1 || edges[v] != 2) continue;
    corners.vertices.push_back(Far::Index(v));  // the last one counts
    corners.sharpness.push_back(std::min(given[v] + least[v], kSharpest));
  }
  return corners;
}

class SmoothSurface : public LimitSurface {
 public:
  SmoothSurface(const MeshDescription& mesh) {
    std::vector<MergedMap> maps;
    channel_of_.assign(mesh.attributes.size(), -1);
    vertex_values_of_.assign(mesh.attributes.size(), -1);
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
      const Attribute& attribute = mesh.attributes[i];
      const bool is_map = attribute.domain == Domain::Corner && attribute.components == 2;
      if (is_map && mesh.subdivision.uv_smoothing != UvSmoothing::None) {
        channel_of_[i] = int(maps.size());
        maps.push_back(merge(mesh, i));
      }
    }
    make_refiner(mesh, maps);
    if (!refiner_) return;
    make_table(mesh, !maps.empty());
    positions_ = refine_vertices(mesh.positions);
    for (size_t i = 0; i < mesh.attributes.size(); ++i) {
      const Attribute& attribute = mesh.attributes[i];
      if (attribute.name != kUndeformedPosition || attribute.domain != Domain::Vertex || attribute.components != 3)
        continue;
      std::vector<Vec3> values(mesh.positions.size());
      std::memcpy(values.data(), attribute.values.data(), values.size() * sizeof(Vec3));
      vertex_values_of_[i] = int(vertex_values_.size());
      vertex_values_.push_back(refine_vertices(values));
    }
    for (const MergedMap& map : maps) map_values_.push_back(refine_map(map.values, int(map_values_.size())));
    refiner_.reset();
  }
  bool is_valid() const { return table_ != nullptr; }

  Vec3 position(PatchPoint point) const override {
    Weights weights;
    const auto& handle = patch_at(point);
    table_->EvaluateBasis(handle, point.uv.x, point.uv.y, weights.value);
    return sum(positions_, table_->GetPatchVertices(handle), weights.value);
  }
  void evaluate(PatchPoint point, Vec3& position, Vec3& normal) const override {
    Weights weights;
    const auto& handle = patch_at(point);
    table_->EvaluateBasis(handle, point.uv.x, point.uv.y, weights.value, weights.du, weights.dv);
    const Far::ConstIndexArray points = table_->GetPatchVertices(handle);
    position = sum(positions_, points, weights.value);
    normal = glm::cross(sum(positions_, points, weights.du), sum(positions_, points, weights.dv));
  }
  bool is_smooth(size_t attribute) const override {
    return channel_of_[attribute] >= 0 || vertex_values_of_[attribute] >= 0;
  }
  Vec3 smooth_value(size_t attribute, PatchPoint point) const override {
    Weights weights;
    const auto& handle = patch_at(point);
    if (vertex_values_of_[attribute] >= 0) {
      table_->EvaluateBasis(handle, point.uv.x, point.uv.y, weights.value);
      return sum(vertex_values_[size_t(vertex_values_of_[attribute])], table_->GetPatchVertices(handle), weights.value);
    }
    const int channel = channel_of_[attribute];
    table_->EvaluateBasisFaceVarying(handle, point.uv.x, point.uv.y, weights.value, nullptr, nullptr, nullptr, nullptr,
                                     nullptr, channel);
    return sum(map_values_[size_t(channel)], table_->GetPatchFVarValues(handle, channel), weights.value);
  }

 private:
  void make_refiner(const MeshDescription& mesh, const std::vector<MergedMap>& maps) {
    const SubdivisionDescription& s = mesh.subdivision;
    using Options = Sdc::Options;
    Options options;
    options.SetVtxBoundaryInterpolation(s.keep_corners ? Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                                       : Options::VTX_BOUNDARY_EDGE_ONLY);
    constexpr Options::FVarLinearInterpolation kLinear[] = {
        Options::FVAR_LINEAR_ALL,           Options::FVAR_LINEAR_CORNERS_ONLY, Options::FVAR_LINEAR_CORNERS_PLUS1,
        Options::FVAR_LINEAR_CORNERS_PLUS2, Options::FVAR_LINEAR_BOUNDARIES,   Options::FVAR_LINEAR_NONE};
    options.SetFVarLinearInterpolation(kLinear[size_t(s.uv_smoothing)]);
    std::vector<Far::TopologyDescriptor::FVarChannel> channels;
    for (const MergedMap& map : maps) {
      channels.emplace_back();
      channels.back().numValues = int(map.values.size());
      channels.back().valueIndices = map.of_corner.data();
    }
    const auto indices = [](const auto& values) { return reinterpret_cast<const Far::Index*>(values.data()); };
    Far::TopologyDescriptor topology;
    topology.numVertices = int(mesh.positions.size());
    topology.numFaces = int(s.face_sizes.size());
    topology.numVertsPerFace = indices(s.face_sizes);
    topology.vertIndicesPerFace = indices(s.corner_vertices);
    topology.numCreases = int(s.creased_edges.size());
    topology.creaseVertexIndexPairs = indices(s.creased_edges);
    topology.creaseWeights = s.edge_sharpness.data();
    const Corners corners = corners_of(mesh);
    topology.numCorners = int(corners.vertices.size());
    topology.cornerVertexIndices = corners.vertices.data();
    topology.cornerWeights = corners.sharpness.data();
    topology.numFVarChannels = int(channels.size());
    topology.fvarChannels = channels.data();
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Far::SetErrorCallback([](Far::ErrorType, const char*) {});  // the caller reports it
    Far::SetWarningCallback([](const char*) {});
    refiner_.reset(Factory::Create(topology, Factory::Options(Sdc::SCHEME_CATMARK, options)));
  }

  void make_table(const MeshDescription& mesh, bool has_maps) {
    // Deep enough for the sharpest crease that is smooth in the end.
    float sharpest = 0.0f;
    for (const std::vector<float>* values : {&mesh.subdivision.edge_sharpness, &mesh.subdivision.vertex_sharpness})
      for (const float sharpness : *values)
        if (sharpness < kSharpest) sharpest = std::max(sharpest, sharpness);
    const int level = std::clamp(int(std::ceil(sharpest)), 3, 6);
    Far::TopologyRefiner::AdaptiveOptions adaptive(level);
    adaptive.SetSecondaryLevel(3);
    adaptive.useInfSharpPatch = true;
    refiner_->RefineAdaptive(adaptive);
    Far::PatchTableFactory::Options options(static_cast<unsigned int>(level));
    options.useInfSharpPatch = true;
    options.endCapType = Far::PatchTableFactory::Options::ENDCAP_GREGORY_BASIS;
    options.generateFVarTables = has_maps;
    options.generateFVarLegacyLinearPatches = false;
    table_.reset(Far::PatchTableFactory::Create(*refiner_, options));
    map_ = std::make_unique<Far::PatchMap>(*table_);
  }

  std::vector<Refined> refine_vertices(const std::vector<Vec3>& base) const {
    std::vector<Refined> values(size_t(refiner_->GetNumVerticesTotal() + table_->GetNumLocalPoints()));
    for (size_t i = 0; i < base.size(); ++i) values[i].value = base[i];
    const Far::PrimvarRefiner primvars(*refiner_);
    Refined* source = values.data();
    for (int level = 1; level <= refiner_->GetMaxLevel(); ++level) {
      Refined* target = source + refiner_->GetLevel(level - 1).GetNumVertices();
      primvars.Interpolate(level, source, target);
      source = target;
    }
    if (table_->GetNumLocalPoints() > 0)
      table_->ComputeLocalPointValues(values.data(), values.data() + refiner_->GetNumVerticesTotal());
    return values;
  }

  std::vector<Refined> refine_map(const std::vector<Vec3>& base, int channel) const {
    const int refined = refiner_->GetNumFVarValuesTotal(channel);
    std::vector<Refined> values(size_t(refined + table_->GetNumLocalPointsFaceVarying(channel)));
    for (size_t i = 0; i < base.size(); ++i) values[i].value = base[i];
    const Far::PrimvarRefiner primvars(*refiner_);
    Refined* source = values.data();
    for (int level = 1; level <= refiner_->GetMaxLevel(); ++level) {
      Refined* target = source + refiner_->GetLevel(level - 1).GetNumFVarValues(channel);
      primvars.InterpolateFaceVarying(level, source, target, channel);
      source = target;
    }
    if (table_->GetNumLocalPointsFaceVarying(channel) > 0)
      table_->ComputeLocalPointValuesFaceVarying(values.data(), values.data() + refined, channel);
    return values;
  }

  const Far::PatchTable::PatchHandle& patch_at(PatchPoint point) const {
    return *map_->FindPatch(int(point.patch), double(point.uv.x), double(point.uv.y));
  }
  static Vec3 sum(const std::vector<Refined>& values, const Far::ConstIndexArray& points, const float* weights) {
    Vec3 result(0.0f);
    for (int k = 0; k < points.size(); ++k) result += values[size_t(points[k])].value * weights[k];
    return result;
  }

  std::unique_ptr<Far::TopologyRefiner> refiner_;  // while the tables are made
  std::unique_ptr<const Far::PatchTable> table_;
  std::unique_ptr<const Far::PatchMap> map_;
  std::vector<Refined> positions_;
  std::vector<std::vector<Refined>> vertex_values_, map_values_;
  std::vector<int> channel_of_, vertex_values_of_;  // of each attribute; -1: not smooth
};

}  // namespace

std::vector<SurfacePatch> patches_of(const SubdivisionDescription& subdivision) {
  std::vector<SurfacePatch> patches;
  uint32_t first = 0;
  for (uint32_t face = 0; face < subdivision.face_sizes.size(); ++face) {
    const uint32_t size = subdivision.face_sizes[face];
    for (uint32_t corner = 0; corner < (size == 4 ? 1 : size); ++corner) patches.push_back({face, first, corner, size});
    first += size;
  }
  return patches;
}

std::unique_ptr<const LimitSurface> make_limit_surface(const MeshDescription& mesh,
                                                       std::span<const SurfacePatch> patches, bool& is_damaged) {
  is_damaged = false;
  if (mesh.subdivision.scheme == SubdivisionScheme::CatmullClark && !mesh.subdivision.empty()) {
    auto smooth = std::make_unique<SmoothSurface>(mesh);
    if (smooth->is_valid()) return smooth;
    is_damaged = true;
  }
  return std::make_unique<FlatSurface>(mesh, patches);
}

}  // namespace ajar
