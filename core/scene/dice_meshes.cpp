#include "scene/dice_meshes.h"

#include <algorithm>
#include <cstdio>

#include "platform/platform.h"

namespace ajar {

namespace {

constexpr size_t kMostInstances = 64;  // whose detail decides about a mesh: those with the smallest pixels

/// Half of the memory of the machine is for triangles, their attributes and the structure for rays.
size_t most_triangles() {
  constexpr double kBytesPerTriangle = 250.0;
  const double bytes = double(platform::memory_bytes());
  return size_t(std::clamp(0.5 * bytes / kBytesPerTriangle, 1e6, 1e9));
}

/// The middle of the vertices.
Vec3 middle_of(const MeshDescription& mesh) {
  Vec3 sum(0.0f);
  for (const Vec3& p : mesh.positions) sum += p / float(mesh.positions.size());
  return sum;
}

std::string rounded(float value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", double(value));
  return text;
}

const MeshDescription& described(const SceneDescription& d, size_t mesh) {
  return d.meshes[mesh].shared ? *d.meshes[mesh].shared : d.meshes[mesh];
}

}  // namespace

PixelSize dicing_pixels(const SceneDescription& d) {
  return PixelSize(d.dicing.camera.present ? d.dicing.camera : d.camera, std::max(1, d.settings.width),
                   std::max(1, d.settings.height), d.dicing.offscreen_scale);
}

bool has_subdivision(const SceneDescription& d) {
  for (size_t i = 0; i < d.meshes.size(); ++i)
    if (!described(d, i).subdivision.empty()) return true;
  return false;
}

DicingRate dicing_rate_of(const SceneDescription& d, size_t mesh, const PixelSize& pixels) {
  const SubdivisionDescription& s = described(d, mesh).subdivision;
  DicingRate rate;
  rate.edge_length = s.edge_length;
  rate.max_subdivisions = d.dicing.max_subdivisions;
  rate.pixels = s.in_pixels ? &pixels : nullptr;
  const Vec3 middle = middle_of(described(d, mesh));
  std::vector<std::pair<float, const InstanceDescription*>> instances;
  for (const InstanceDescription& instance : d.instances)
    if (instance.object >= 0 && size_t(instance.object) < d.objects.size() &&
        d.objects[size_t(instance.object)].mesh == int(mesh)) {
      const Mat4 matrix = to_matrix(instance.world_from_object);
      const float scale = std::cbrt(std::abs(glm::determinant(Mat3(matrix))));
      instances.push_back({pixels.at(transform_point(matrix, middle)) / std::max(scale, 1e-20f), &instance});
    }
  const size_t count = std::min(instances.size(), kMostInstances);
  const auto finer = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::partial_sort(instances.begin(), instances.begin() + ptrdiff_t(count), instances.end(), finer);
  for (size_t i = 0; i < count; ++i)
    rate.world_from_object.push_back(to_matrix(instances[i].second->world_from_object));
  return rate;
}

void dice_meshes(SceneDescription& d, Diagnostics& diagnostics, const std::atomic<bool>* stop) {
  const PixelSize pixels = dicing_pixels(d);
  size_t left = most_triangles();
  for (size_t i = 0; i < d.meshes.size(); ++i) {
    if (stop && stop->load(std::memory_order_relaxed)) return;
    MeshDescription& mesh = d.meshes[i];
    if (mesh.subdivision.empty()) continue;
    DicingRate rate = dicing_rate_of(d, i, pixels);
    rate.max_triangles = std::max<size_t>(left, 1000);
    DicingReport report;
    if (rate.world_from_object.empty()) {
      mesh = MeshDescription();
      continue;
    }
    mesh = dice(mesh, rate, report, stop);
    left -= std::min(left, mesh.triangles.size());
    if (report.is_damaged)
      report_once(diagnostics, {Diagnostic::Severity::Warning, mesh.name,
                                "Its faces cannot be smoothed; they are divided as they are."});
    if (report.coarser > 1.0f)
      report_once(diagnostics,
                  {Diagnostic::Severity::Warning, mesh.name,
                   "Adaptive subdivision would need more memory than this machine has; its triangles are " +
                       rounded(report.coarser) + " times as long. Increase the dicing rate."});
  }
}

}  // namespace ajar
