#include "transport/media/media.h"

#include <algorithm>
#include <cmath>

namespace ajar {

namespace {

constexpr float kLargestExtent = 1e18f;  ///< of a volume that varies, in metres
constexpr uint64_t kMaxMajorants = 8 * 16 * 16 * 16;
constexpr int kWorldCells = 8;

constexpr uint32_t kEveryVisibility = kVisibleCamera | kVisibleDiffuse | kVisibleGlossy | kVisibleTransmission |
                                      kVisibleVolumeScatter | kVisibleShadow;

/// Number of cells along the longest axis of each of `varying` grids. All grids together have at most kMaxMajorants
/// cells, or one cell each. The volume of the world has at least kWorldCells along each axis.
int cells_of(size_t varying) { return varying <= 8 ? 16 : varying <= 64 ? 8 : varying <= 512 ? 4 : 1; }

void grow(Vec3 p, Vec3& lower, Vec3& upper) {
  lower = glm::min(lower, p);
  upper = glm::max(upper, p);
}

/// World-space bounds of an instance over the whole shutter interval.
void bounds_of(const BuiltMesh& mesh, const BuiltInstance& instance, Vec3& lower, Vec3& upper) {
  Vec3 low(kInfinity), high(-kInfinity);
  const auto grow_by = [&](const std::vector<Vec3>& positions) {
    for (size_t i = 0; i + 1 < positions.size(); ++i) grow(positions[i], low, high);
  };
  grow_by(mesh.positions);
  if (mesh.deformation)
    for (const Deformation::Key& key : mesh.deformation->keys) grow_by(key.positions);
  if (mesh.baked || !(low.x <= high.x)) {
    lower = low;
    upper = high;
    return;
  }
  lower = Vec3(kInfinity);
  upper = Vec3(-kInfinity);
  const uint32_t count = std::max(instance.motion_count, 1u);
  for (uint32_t key = 0; key < count; ++key) {
    const Mat4& m = instance.motion ? instance.motion[key] : instance.world_from_object;
    for (int corner = 0; corner < 8; ++corner)
      grow(transform_point(m,
                           Vec3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y, corner & 4 ? high.z : low.z)),
           lower, upper);
  }
}

}  // namespace

void MediaCounters::add(const MediaCounters& other) {
  lookups += other.lookups;
  exceeded += other.exceeded;
  capped += other.capped;
  refused += other.refused;
  open_ends += other.open_ends;
  too_deep += other.too_deep;
}

bool MediaStack::contains(uint32_t medium) const {
  return std::find(media_.begin(), media_.begin() + count_, medium) != media_.begin() + count_;
}

bool MediaStack::enter(uint32_t medium) {
  if (contains(medium)) return true;
  if (count_ == kMax) return false;
  media_[size_t(count_++)] = medium;
  return true;
}

void MediaStack::leave(uint32_t medium) {
  const auto end = media_.begin() + count_, found = std::find(media_.begin(), end, medium);
  if (found == end) return;
  std::copy(found + 1, end, found);
  --count_;
}

Media::Media(const Scene& scene) : scene_(scene), first_of_instance_(scene.instances().size(), kNone) {
  size_t varying = 0;
  if (const ShaderProgram& program = scene.world_program(); program.has_volume()) {
    world_ = 0;
    varying += program.medium_varies() ? 1 : 0;
    const float half = std::max(scene.radius(), glm::length(scene.camera().position() - scene.center()));
    media_.push_back(
        {kNone, kNone, &program, program.medium_varies(), MajorantGrid::endless(scene.center(), half), 0, 0.0f});
  }
  for (uint32_t i = 0; i < scene.instances().size(); ++i) {
    const BuiltInstance& instance = scene.instances()[i];
    if (!scene.meshes()[instance.mesh].has_triangles()) continue;  // strands and points enclose no volume
    Vec3 lower(kInfinity), upper(-kInfinity);
    for (const uint32_t material : scene.materials_of(instance)) {
      const ShaderProgram& program = scene.programs()[material];
      if (!program.has_volume()) continue;
      if (first_of_instance_[i] == kNone) {
        first_of_instance_[i] = uint32_t(media_.size());
        bounds_of(scene.meshes()[instance.mesh], instance, lower, upper);
        lower_ = glm::min(lower_, lower);
        upper_ = glm::max(upper_, upper);
      }
      const bool known = std::any_of(media_.begin() + first_of_instance_[i], media_.end(),
                                     [&](const Medium& m) { return m.material == material; });
      if (known) continue;
      // Larger volumes are treated as uniform, because the lengths of cells would overflow.
      const bool varies = program.medium_varies() && max_component(upper - lower) < kLargestExtent;
      varying += varies ? 1 : 0;
      media_.push_back({i, material, &program, varies, MajorantGrid(lower, upper), 0, 0.0f});
      media_.back().visibility = instance.visibility;
      any_hidden_ |= (instance.visibility & kEveryVisibility) != kEveryVisibility;
      if (scene.meshes()[instance.mesh].density_in_object_space) {
        const float length = glm::length(Mat3(instance.world_from_object) * Vec3(1.0f / std::sqrt(3.0f)));
        if (length > 0.0f) media_.back().scale = 1.0f / length;
      }
    }
  }
  const int cells_along = cells_of(varying);
  for (Medium& medium : media_)
    if (medium.varies)
      find_majorants(medium, medium.instance == kNone ? std::max(cells_along, kWorldCells) : cells_along,
                     FineMajorants::kMaxDivided / varying);
  find_emission();
}

uint64_t Media::max_bytes(uint64_t volumes, uint64_t instances) {
  // The capacity of a growing vector is at most twice its size.
  return 2 * (volumes * sizeof(Medium) + (kMaxMajorants + volumes) * sizeof(float)) + instances * sizeof(uint32_t) +
         FineMajorants::bytes_of(FineMajorants::kMaxDivided, kMaxMajorants + volumes);
}

uint32_t Media::medium_of(const Hit& hit) const {
  const uint32_t first = first_of_instance_[hit.instance];
  if (first == kNone) return kNone;
  const uint32_t material = uint32_t(scene_.material_index(hit));
  for (uint32_t i = first; i < media_.size() && media_[i].instance == hit.instance; ++i)
    if (media_[i].material == material) return i;
  return kNone;
}

void Media::cross(const Hit& hit, bool inwards, MediaStack& stack, MediaCounters& counters) const {
  const uint32_t medium = medium_of(hit);
  if (medium == kNone) return;
  if (!inwards)
    stack.leave(medium);
  else if (!stack.enter(medium))
    ++counters.too_deep;
}

void Media::leave_all(MediaStack& stack, MediaCounters& counters) const {
  const int world = world_ == kNone ? 0 : 1;
  if (stack.size() == world) return;
  ++counters.open_ends;
  stack = MediaStack();
  if (world_ != kNone) stack.enter(world_);
}

MediaStack Media::around(Vec3 position, float time, MediaCounters& counters) const {
  MediaStack stack, entered;
  if (world_ != kNone) stack.enter(world_);
  for (int axis = 0; axis < 3; ++axis)
    if (!(position[axis] >= lower_[axis] && position[axis] <= upper_[axis])) return stack;
  Ray ray;
  ray.origin = position;
  ray.time = time;
  ShadingPoint point;
  for (int crossed = 0; crossed < kMaxVolumeBounds; ++crossed) {
    const Hit hit = scene_.intersect(ray, kRayCamera);
    if (!hit.found()) break;
    scene_.shading_point(ray, hit, point);
    if (const uint32_t medium = medium_of(hit); medium != kNone) {
      if (!point.backfacing)
        entered.enter(medium);
      else if (!entered.contains(medium) && !stack.enter(medium))
        ++counters.too_deep;
    }
    ray = scene_.straight_on(point, ray, hit.t);
  }
  return stack;
}

bool Media::varies(const MediaStack& stack) const {
  for (int i = 0; i < stack.size(); ++i)
    if (media_[stack[i]].varies) return true;
  return false;
}

bool Media::emits(const MediaStack& stack) const {
  for (int i = 0; i < stack.size(); ++i)
    if (media_[stack[i]].emits) return true;
  return false;
}

bool Media::any_emission() const {
  return std::any_of(media_.begin(), media_.end(), [](const Medium& medium) { return medium.emits; });
}

uint32_t Media::receiver_set(const MediaStack& stack) const {
  const uint32_t instance = stack.empty() ? kNone : media_[stack[stack.size() - 1]].instance;
  return instance == kNone ? kEveryLight : scene_.object(scene_.instances()[instance].object).receiver_set;
}

size_t Media::memory_bytes() const {
  size_t bytes = media_.capacity() * sizeof(Medium) + first_of_instance_.capacity() * sizeof(uint32_t) +
                 majorants_.capacity() * sizeof(float);
  for (const Medium& medium : media_) bytes += medium.fine.memory_bytes();
  return bytes;
}

/// Of uniform media.
void Media::find_emission() {
  MediaStack none;
  Ray ray;
  ShadingPoint path;
  MediaCounters ignored;
  for (Medium& medium : media_) {
    if (medium.varies) continue;
    ShadingPoint inside = inside_of({none, ray, 0.0f, path, kRayCamera});
    MediumPoint point;
    add(medium, inside, point, ignored);
    medium.emits = !is_black(point.emission);
  }
}

}  // namespace ajar
