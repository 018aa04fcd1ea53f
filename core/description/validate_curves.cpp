#include "description/validate_curves.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

/// Removes strands and their data; `keep` has one flag for each strand.
void compact_strands(MeshDescription& mesh, const std::vector<uint8_t>& keep) {
  const auto end_of = [&](size_t strand) {
    return strand + 1 < mesh.strands.size() ? size_t(mesh.strands[strand + 1]) : mesh.positions.size();
  };
  const auto compact = [&](auto& array, bool per_point, size_t each) {
    if (array.empty()) return;
    size_t out = 0;
    for (size_t strand = 0; strand < keep.size(); ++strand) {
      if (!keep[strand]) continue;
      const size_t first = per_point ? mesh.strands[strand] : strand, end = per_point ? end_of(strand) : strand + 1;
      for (size_t i = first * each; i < end * each; ++i) array[out++] = array[i];
    }
    array.resize(out);
  };
  for (Attribute& attribute : mesh.attributes)
    compact(attribute.values, attribute.domain == Domain::Vertex, size_t(attribute.components));
  compact(mesh.material_slots, false, 1);
  compact(mesh.radii, true, 1);
  std::vector<uint32_t> first;
  uint32_t points = 0;
  for (size_t strand = 0; strand < keep.size(); ++strand) {
    if (!keep[strand]) continue;
    first.push_back(points);
    points += uint32_t(end_of(strand) - mesh.strands[strand]);
  }
  compact(mesh.positions, true, 1);
  mesh.strands = std::move(first);
}

}  // namespace

void validate_strands(MeshDescription& mesh, ValidationCounts& counts, Diagnostics& diagnostics) {
  const auto warn = [&](const std::string& text) {
    report_once(diagnostics, {Diagnostic::Severity::Warning, mesh.name, text});
  };
  constexpr int kMaxSubdivisions = 4;  // limit of Embree: 16 pieces
  constexpr float kFarthest = 1e18f;   // limit of Embree
  mesh.strand_subdivisions = std::clamp(mesh.strand_subdivisions, 0, kMaxSubdivisions);
  mesh.normals.clear();
  const bool ordered = mesh.strands[0] == 0 && mesh.strands.back() < mesh.positions.size() &&
                       std::is_sorted(mesh.strands.begin(), mesh.strands.end());
  if (!ordered || mesh.radii.size() != mesh.positions.size() || !mesh.triangles.empty() ||
      mesh.positions.size() > 0x3fffffffu) {
    warn("The strands do not match the points; they are left out.");
    const std::string name = mesh.name;
    mesh = MeshDescription();
    mesh.name = name;
    return;
  }
  const size_t count = mesh.strands.size();
  if (!mesh.material_slots.empty() && mesh.material_slots.size() != count) {
    warn("Material slots do not match the strands; slot 0 is used everywhere.");
    mesh.material_slots.clear();
  }
  uint64_t repaired = validate_attributes(mesh, diagnostics);
  for (float& radius : mesh.radii) {
    if (radius >= 0.0f && radius < kFarthest) continue;
    radius = 0.0f;
    ++repaired;
  }
  if (repaired > 0) warn(count_of(repaired, "invalid radius or attribute value") + " replaced.");
  counts.repaired_values += repaired;
  std::vector<uint8_t> keep(count, 1);
  uint64_t bad_strands = 0, points_only = 0;
  for (size_t i = 0; i < count; ++i) {
    const size_t first = mesh.strands[i], end = i + 1 < count ? mesh.strands[i + 1] : mesh.positions.size();
    bool bad = false, long_enough = false;
    for (size_t point = first; point < end; ++point) {
      bad |= !(max_component(glm::abs(mesh.positions[point])) < kFarthest) || !is_finite(mesh.positions[point]);
      long_enough |= mesh.positions[point] != mesh.positions[first];
    }
    if (!bad && long_enough) continue;
    keep[i] = 0;
    (bad ? bad_strands : points_only) += 1;
  }
  if (bad_strands > 0) warn(count_of(bad_strands, "strand") + " with invalid points left out.");
  if (points_only == count) warn("No strand has a length; the hair is invisible.");
  if (bad_strands + points_only > 0) compact_strands(mesh, keep);
}

/// Points that cannot be shown get the radius 0. They stay in the list, because values are random by the index of a point.
void validate_points(MeshDescription& mesh, ValidationCounts& counts, Diagnostics& diagnostics) {
  const auto warn = [&](const std::string& text) {
    report_once(diagnostics, {Diagnostic::Severity::Warning, mesh.name, text});
  };
  constexpr float kFarthest = 1e18f;  // limit of Embree
  mesh.normals.clear();
  if (mesh.radii.size() != mesh.positions.size() || mesh.positions.size() > 0x7fffffffu) {
    warn("The radii do not match the points; they are left out.");
    mesh.positions.clear();
    mesh.radii.clear();
    mesh.attributes.clear();
    mesh.material_slots.clear();
    return;
  }
  if (!mesh.material_slots.empty() && mesh.material_slots.size() != mesh.positions.size()) {
    warn("Material slots do not match the points; slot 0 is used everywhere.");
    mesh.material_slots.clear();
  }
  const uint64_t repaired = validate_attributes(mesh, diagnostics);
  if (repaired > 0) warn(count_of(repaired, "invalid attribute value") + " replaced.");
  counts.repaired_values += repaired;
  uint64_t bad = 0;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const bool is_near = max_component(glm::abs(mesh.positions[i])) < kFarthest && is_finite(mesh.positions[i]);
    if (is_near && mesh.radii[i] >= 0.0f && mesh.radii[i] < kFarthest) continue;
    if (!is_near) mesh.positions[i] = Vec3(0.0f);
    mesh.radii[i] = 0.0f;
    ++bad;
  }
  if (bad > 0) warn(count_of(bad, "point") + " with invalid radii or positions left out.");
}

}  // namespace ajar
