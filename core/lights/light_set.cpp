#include "lights/light_set.h"

#include <algorithm>
#include <bit>

#include "lights/light_set_data.h"
#include "math/random.h"

namespace ajar {

namespace {

// Ids of branches: nodes of the tree, then one id per distant light, or a single one if there are many.
constexpr uint32_t kDistantBranch = 0x80000000u;
constexpr size_t kMaxDistantBranches = 8;

}  // namespace

LightSet::LightSet() : data_(std::make_unique<Data>()) {}
LightSet::LightSet(LightSet&&) noexcept = default;
LightSet& LightSet::operator=(LightSet&&) noexcept = default;
LightSet::~LightSet() = default;

size_t LightSet::size() const { return data_->size; }
uint32_t LightSet::lamp_count() const { return uint32_t(data_->lamps.size()); }
int LightSet::environment_index() const { return data_->environment_index; }
const std::vector<uint32_t>& LightSet::distant_disks() const { return data_->distant_disks; }
size_t LightSet::tree_bytes() const {
  size_t bytes = data_->all.tree.memory_bytes() + data_->clusters.memory_bytes();
  for (const LightChooser& linked : data_->linked) bytes += linked.tree.memory_bytes();
  return bytes;
}
size_t LightSet::environment_bytes() const { return data_->environment.table_bytes(); }
double LightSet::total_power() const { return data_->by_power.total(); }

Light LightSet::light(uint32_t index, float time) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) return d.lamps[index];
  Light light;
  const LightFlags known = flags(index);
  light.visibility = known.visibility;
  light.receivers = known.receivers;
  light.blockers = known.blockers;
  light.power = float(double(power_pmf(index)) * d.by_power.total());
  if (d.is_environment(index)) {
    light.type = LightType::Environment;
    return light;
  }
  const Data::TriangleBlock& block = d.block_of(index);
  const BuiltInstance& instance = d.instances[block.instance];
  light.type = LightType::Triangle;
  light.instance = block.instance;
  light.primitive = index - block.first;
  const WorldTriangle triangle = world_triangle(d.meshes[instance.mesh], instance, light.primitive, time);
  light.position = triangle.p0;
  light.edge1 = triangle.e1;
  light.edge2 = triangle.e2;
  light.frame = Frame(triangle.normal);
  light.area = triangle.area;
  light.radiance = d.emission_of(block, light.primitive).radiance;
  return light;
}

bool LightSet::moves(uint32_t index) const {
  const Data& d = *data_;
  if (d.is_lamp(index) || d.is_environment(index)) return false;
  const BuiltInstance& instance = d.instances[d.block_of(index).instance];
  return ajar::moves(d.meshes[instance.mesh], instance);
}

bool LightSet::any_moves() const {
  const Data& d = *data_;
  return std::any_of(d.blocks.begin(), d.blocks.end(),
                     [&](const Data::TriangleBlock& block) { return moves(block.first); });
}

LightFlags LightSet::flags(uint32_t index) const {
  const Data& d = *data_;
  if (d.is_lamp(index)) {
    const Light& lamp = d.lamps[index];
    return {lamp.type, lamp.visibility, lamp.cast_shadow, lamp.mis,
            lamp.soft, lamp.receivers,  lamp.blockers,    lamp.max_bounces};
  }
  if (d.is_environment(index))
    return {
        .type = LightType::Environment, .visibility = d.environment_visibility, .max_bounces = d.environment_bounces};
  const Data::TriangleBlock& block = d.block_of(index);
  return {LightType::Triangle, d.instances[block.instance].visibility, true, true, false, block.receivers,
          block.blockers};
}

bool LightSet::any_without_walks() const { return data_->any_without_walks; }
bool LightSet::took_environment_over() const { return data_->took_environment_over; }
bool LightSet::can_choose() const { return !data_->all.tree.empty() || !data_->all.distant.empty(); }

uint64_t LightSet::fingerprint() const {
  uint64_t hash = hash64(data_->all.tree.fingerprint() ^ data_->size);
  if (!data_->clusters.empty()) hash = hash64(hash ^ data_->clusters.fingerprint());
  const auto add = [&](float x) { hash = hash64(hash ^ std::bit_cast<uint32_t>(x)); };
  for (const LightChooser::DistantLight& l : data_->all.distant) {
    hash = hash64(hash ^ l.light);
    for (const float x : {l.irradiance, l.direction.x, l.direction.y, l.direction.z, l.cos_size}) add(x);
  }
  return hash;
}

LightSet::Choice LightSet::choose(Vec3 p, Vec3 n, float u, uint32_t receiver_set) const {
  return data_->chooser(receiver_set).choose(u, p, n);
}

float LightSet::choice_pmf(Vec3 p, Vec3 n, uint32_t light, uint32_t receiver_set) const {
  return data_->chooser(receiver_set).pmf(light, p, n);
}

LightSet::Choice LightSet::choose(const LightStretch& stretch, float u, uint32_t receiver_set) const {
  return data_->chooser(receiver_set).choose(u, stretch);
}

float LightSet::choice_pmf(const LightStretch& stretch, uint32_t light, uint32_t receiver_set) const {
  return data_->chooser(receiver_set).pmf(light, stretch);
}

void LightSet::cut(Vec3 p, float radius, Vec3 n, int max_branches, std::vector<Branch>& branches) const {
  const LightChooser& d = data_->all;
  branches.clear();
  const size_t distant = d.distant.size() <= kMaxDistantBranches ? d.distant.size() : 1;
  std::vector<LightTree::CutNode> nodes;
  d.tree.cut(p, radius, n, std::max(1, max_branches - int(distant)), nodes);
  const float sum = d.distant_importance(n), share = d.distant_share(sum, p, n);
  for (const LightTree::CutNode& node : nodes) branches.push_back({node.node, (1.0f - share) * node.share});
  for (size_t i = 0; i < distant; ++i)
    branches.push_back(
        {kDistantBranch | uint32_t(i), distant == d.distant.size() ? share * d.distant[i].importance(n) / sum : share});
}

LightSet::Choice LightSet::choose_in(uint32_t branch, Vec3 p, Vec3 n, float u) const {
  const LightChooser& d = data_->all;
  if (branch < kDistantBranch) return d.choose_below(branch, p, n, u);
  return d.distant.size() <= kMaxDistantBranches ? Choice{d.distant[branch - kDistantBranch].light, 1.0f, u}
                                                 : d.choose_distant(n, u);
}

float LightSet::pmf_in(uint32_t branch, Vec3 p, Vec3 n, uint32_t light) const {
  const LightChooser& d = data_->all;
  if (branch < kDistantBranch) return d.pmf_below(branch, p, n, light);
  const size_t i = size_t(std::find_if(d.distant.begin(), d.distant.end(),
                                       [&](const LightChooser::DistantLight& l) { return l.light == light; }) -
                          d.distant.begin());
  if (i == d.distant.size()) return 0.0f;
  if (d.distant.size() <= kMaxDistantBranches) return branch - kDistantBranch == i ? 1.0f : 0.0f;
  return d.distant[i].importance(n) / d.distant_importance(n);
}

uint32_t LightSet::place_of(uint32_t light) const {
  const LightChooser& d = data_->all;
  if (d.contains(light)) return d.leaf_of(light);
  for (size_t i = 0; i < d.distant.size(); ++i)
    if (d.distant[i].light == light) return kDistantBranch | uint32_t(i);
  return ~0u;
}

LightSet::Choice LightSet::choose_by_power(float u) const {
  const auto entry = data_->by_power.sample(u);
  if (data_->clusters.empty()) [[likely]]
    return {entry.index, entry.pmf, entry.u_remapped};
  const LightClusters::Choice inside = data_->clusters.choose_by_power(entry.index, entry.u_remapped);
  return {inside.light, entry.pmf * inside.pmf, inside.u_remapped};
}
std::vector<LightSet::SourceRange> LightSet::sources() const {
  const Data& d = *data_;
  std::vector<SourceRange> sources;
  for (uint32_t i = 0; i < d.lamps.size(); ++i) {
    if (!d.all.can_choose(i)) continue;
    const bool distant = is_distant(d.lamps[i].type);
    sources.push_back({i, 1, distant ? d.scene_center : d.lamps[i].position, distant});
  }
  for (const Data::TriangleBlock& block : d.blocks) {
    // A few triangles spread over the mesh approximate its centre.
    Vec3 center(0.0f);
    const uint32_t step = std::max(1u, block.count / 64);
    uint32_t counted = 0;
    for (uint32_t t = 0; t < block.count; t += step, ++counted) {
      const WorldTriangle triangle = world_triangle(d.meshes[d.instances[block.instance].mesh],
                                                    d.instances[block.instance], t, kMidShutter);
      center += triangle.p0 + (triangle.e1 + triangle.e2) / 3.0f;
    }
    sources.push_back({block.first, block.count, center / float(counted), false});
  }
  if (d.environment_index >= 0 && d.all.can_choose(uint32_t(d.environment_index)))
    sources.push_back({uint32_t(d.environment_index), 1, d.scene_center, true});
  return sources;
}

float LightSet::power_pmf(uint32_t light) const {
  const Data& d = *data_;
  if (d.clusters.empty()) [[likely]]
    return d.by_power.pmf(light);
  return d.by_power.pmf(d.clusters.entry_of(light)) * d.clusters.power_pmf(light);
}

}  // namespace ajar
