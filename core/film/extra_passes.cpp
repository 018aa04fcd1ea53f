#include "film/extra_passes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace ajar {

namespace {

constexpr std::string_view kMattes[] = {"CryptoObject", "CryptoMaterial", "CryptoAsset"};
constexpr int kSpareRanks = 4;  ///< of a table, beyond those that its passes show
constexpr std::string_view kMotion = "Vector", kOcclusion = "AO", kRoughness = "Roughness", kTime = "Render Time";

bool by_weight(const std::pair<float, double>& a, const std::pair<float, double>& b) {
  // The order of equal coverages must not depend on the order of the samples.
  return a.second != b.second ? a.second > b.second
                              : std::bit_cast<uint32_t>(a.first) < std::bit_cast<uint32_t>(b.first);
}

/// The number of ranks of each matte that the passes show.
std::array<int, 3> shown_ranks(const std::vector<std::string>& passes) {
  std::array<int, 3> ranks{};
  for (const std::string& pass : passes)
    if (const auto matte = matte_pass(pass))
      ranks[size_t(matte->kind)] = std::max(ranks[size_t(matte->kind)], 2 * (matte->number + 1));
  return ranks;
}

}  // namespace

std::optional<MattePass> matte_pass(const std::string& pass) {
  for (size_t kind = 0; kind < std::size(kMattes); ++kind) {
    if (!pass.starts_with(kMattes[kind])) continue;
    const std::string_view digits = std::string_view(pass).substr(kMattes[kind].size());
    if (digits.size() != 2 || digits[0] != '0' || digits[1] < '0' || digits[1] > '7') return {};
    return MattePass{MatteKind(kind), digits[1] - '0'};
  }
  return {};
}

std::optional<AovPass> aov_pass(const std::string& pass) {
  for (const char* prefix : {kColorAov, kValueAov})
    if (pass.starts_with(prefix) && pass.size() > std::strlen(prefix))
      return AovPass{murmur_hash3(std::string_view(pass).substr(std::strlen(prefix))), prefix == kColorAov};
  return {};
}

std::string light_group_of(const std::string& pass) {
  return pass.starts_with(kLightGroup) ? pass.substr(std::strlen(kLightGroup)) : std::string();
}

ExtraPasses::ExtraPasses(const std::vector<std::string>& passes, size_t pixels) {
  const std::array<int, 3> shown = shown_ranks(passes);
  for (size_t kind = 0; kind < shown.size(); ++kind) {
    if (shown[kind] == 0) continue;
    tables_[kind].ranks = shown[kind] + kSpareRanks;
    tables_[kind].all.resize(pixels * size_t(tables_[kind].ranks));
    any_mattes_ = true;
  }
  for (const std::string& pass : passes) {
    const auto aov = aov_pass(pass);
    if (aov && std::find(aov_passes_.begin(), aov_passes_.end(), *aov) == aov_passes_.end())
      aov_passes_.push_back(*aov);
    if (const std::string group = light_group_of(pass);
        !group.empty() && std::find(groups_.begin(), groups_.end(), group) == groups_.end())
      groups_.push_back(group);
    if (pass == kMotion) motion_.resize(pixels, glm::dvec4(0.0)), motion_count_.resize(pixels);
    if (pass == kOcclusion) occlusion_.resize(pixels);
    if (pass == kRoughness) roughness_.resize(pixels);
    if (pass == kTime) seconds_.resize(pixels);
  }
  aovs_.resize(pixels * aov_passes_.size(), Vec4(0.0f));
  group_light_.resize(pixels * groups_.size(), glm::dvec3(0.0));
}

uint64_t ExtraPasses::bytes_per_pixel(const std::vector<std::string>& passes) {
  uint64_t bytes = 0;
  for (const int ranks : shown_ranks(passes)) bytes += ranks > 0 ? uint64_t(ranks + kSpareRanks) * sizeof(Rank) : 0;
  for (const std::string& pass : passes) {
    if (aov_pass(pass)) bytes += sizeof(Vec4);
    if (!light_group_of(pass).empty()) bytes += sizeof(glm::dvec3);
    if (pass == kMotion) bytes += sizeof(glm::dvec4) + sizeof(float);
    if (pass == kOcclusion || pass == kRoughness || pass == kTime) bytes += sizeof(double);
  }
  return bytes;
}

uint64_t ExtraPasses::memory_bytes() const {
  uint64_t bytes = aovs_.size() * sizeof(Vec4) + group_light_.size() * sizeof(glm::dvec3) +
                   motion_.size() * (sizeof(glm::dvec4) + sizeof(float)) +
                   (occlusion_.size() + roughness_.size() + seconds_.size()) * sizeof(double);
  for (const Table& table : tables_) bytes += table.all.size() * sizeof(Rank);
  return bytes;
}

void ExtraPasses::begin(SampleExtras& extras, uint32_t pixel, uint32_t index) const {
  extras.wants_mattes = any_mattes_;
  extras.wants_motion = !motion_.empty();
  extras.wants_occlusion = !occlusion_.empty();
  extras.wants_roughness = !roughness_.empty();
  extras.aov_passes = aov_passes_.empty() ? nullptr : &aov_passes_;
  extras.pixel = pixel;
  extras.index = index;
  extras.mattes.clear();
  extras.aovs.assign(aov_passes_.size(), Vec4(0.0f));
  extras.motion = Vec4(0.0f);
  extras.has_motion = false;
  extras.occlusion = extras.roughness = 0.0f;
  if (!seconds_.empty()) extras.begin = std::chrono::steady_clock::now();
}

void ExtraPasses::add_to(Table& table, size_t pixel, float id, float weight) {
  Rank* const first = table.all.data() + pixel * size_t(table.ranks);
  Rank* smallest = first;
  for (Rank* rank = first; rank != first + table.ranks; ++rank) {
    if (rank->weight == 0.0f || rank->id == id) {
      rank->id = id;
      rank->weight += weight;
      return;
    }
    if (rank->weight < smallest->weight) smallest = rank;
  }
  dropped_.fetch_add(double(std::min(weight, smallest->weight)), std::memory_order_relaxed);
  if (weight > smallest->weight) *smallest = {id, weight};
}

void ExtraPasses::add(size_t pixel, const SampleExtras& extras) {
  if (!seconds_.empty())
    seconds_[pixel] += std::chrono::duration<double>(std::chrono::steady_clock::now() - extras.begin).count();
  for (const MatteSample& sample : extras.mattes)
    for (size_t kind = 0; kind < tables_.size(); ++kind)
      if (tables_[kind].ranks > 0 && sample.weight > 0.0f && std::isfinite(sample.weight))
        add_to(tables_[kind], pixel, sample.ids[kind], sample.weight);
  for (size_t i = 0; i < extras.aovs.size(); ++i)
    if (std::isfinite(glm::dot(extras.aovs[i], Vec4(1.0f)))) aovs_[pixel * aov_passes_.size() + i] += extras.aovs[i];
  if (extras.has_motion && !motion_.empty()) {
    motion_[pixel] += glm::dvec4(extras.motion);
    motion_count_[pixel] += 1.0f;
  }
  if (!occlusion_.empty() && std::isfinite(extras.occlusion)) occlusion_[pixel] += double(extras.occlusion);
  if (!roughness_.empty() && std::isfinite(extras.roughness)) roughness_[pixel] += double(extras.roughness);
}

void ExtraPasses::add_groups(size_t pixel, const std::vector<Color>& light) {
  for (size_t i = 0; i < light.size(); ++i) group_light_[pixel * groups_.size() + i] += glm::dvec3(light[i]);
}

bool ExtraPasses::makes(const std::string& pass) {
  return matte_pass(pass) || aov_pass(pass) || !light_group_of(pass).empty() || pass == kMotion || pass == kOcclusion ||
         pass == kRoughness || pass == kTime;
}

void ExtraPasses::resolve(const std::string& pass, size_t pixel, double count, float exposure, float* out) const {
  const double scale = count > 0.0 ? 1.0 / count : 0.0;
  if (const auto matte = matte_pass(pass)) {
    const Table& table = tables_[size_t(matte->kind)];
    std::vector<std::pair<float, double>> ranks;
    for (int i = 0; i < table.ranks; ++i) {
      const Rank& rank = table.all[pixel * size_t(table.ranks) + size_t(i)];
      if (rank.weight > 0.0f) ranks.emplace_back(rank.id, double(rank.weight));
    }
    std::sort(ranks.begin(), ranks.end(), by_weight);
    for (size_t i = 0; i < 2; ++i) {
      const size_t at = 2 * size_t(matte->number) + i;
      out[2 * i] = at < ranks.size() ? ranks[at].first : 0.0f;
      out[2 * i + 1] = at < ranks.size() ? float(ranks[at].second * scale) : 0.0f;
    }
  } else if (const auto aov = aov_pass(pass)) {
    const auto found = std::find(aov_passes_.begin(), aov_passes_.end(), *aov);
    if (found == aov_passes_.end()) return;
    const Vec4 sum = aovs_[pixel * aov_passes_.size() + size_t(found - aov_passes_.begin())];
    for (int c = 0; c < (aov->is_color ? 4 : 1); ++c) out[c] = float(double(sum[c]) * scale);
  } else if (const std::string group = light_group_of(pass); !group.empty()) {
    const auto found = std::find(groups_.begin(), groups_.end(), group);
    if (found == groups_.end()) return;
    const glm::dvec3 sum = group_light_[pixel * groups_.size() + size_t(found - groups_.begin())];
    for (int c = 0; c < 3; ++c) out[c] = float(sum[c] * scale * double(exposure));
  } else if (pass == kMotion) {
    if (motion_.empty() || !(motion_count_[pixel] > 0.0f)) return;
    for (int c = 0; c < 4; ++c) out[c] = float(motion_[pixel][c] / double(motion_count_[pixel]));
  } else if (pass == kOcclusion) {
    for (int c = 0; c < 3 && !occlusion_.empty(); ++c) out[c] = float(occlusion_[pixel] * scale);
  } else if (pass == kRoughness) {
    if (!roughness_.empty()) out[0] = float(roughness_[pixel] * scale);
  } else if (pass == kTime) {
    if (!seconds_.empty()) out[0] = float(1e3 * seconds_[pixel]);  // of all samples, in milliseconds, as in Cycles
  }
}

std::vector<std::vector<float>> merge_mattes(const std::vector<const std::vector<float>*>& a, double wa,
                                             const std::vector<const std::vector<float>*>& b, double wb) {
  std::vector<std::vector<float>> merged(a.size());
  for (size_t number = 0; number < a.size(); ++number) merged[number].resize(a[number]->size());
  const size_t pixels = a.empty() ? 0 : a.front()->size() / 4;
  std::vector<std::pair<float, double>> ranks;
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    ranks.clear();
    const auto take = [&](const std::vector<const std::vector<float>*>& passes, double weight) {
      for (const std::vector<float>* pass : passes)
        for (size_t i = 0; i < 2; ++i) {
          const float id = (*pass)[4 * pixel + 2 * i], coverage = (*pass)[4 * pixel + 2 * i + 1];
          if (!(coverage > 0.0f)) continue;
          const auto known = std::find_if(ranks.begin(), ranks.end(),
                                          [&](const auto& rank) { return rank.first == id; });
          if (known != ranks.end())
            known->second += weight * double(coverage);
          else
            ranks.emplace_back(id, weight * double(coverage));
        }
    };
    take(a, wa);
    take(b, wb);
    std::sort(ranks.begin(), ranks.end(), by_weight);
    for (size_t at = 0; at < std::min(ranks.size(), 2 * a.size()); ++at) {
      merged[at / 2][4 * pixel + 2 * (at % 2)] = ranks[at].first;
      merged[at / 2][4 * pixel + 2 * (at % 2) + 1] = float(ranks[at].second);
    }
  }
  return merged;
}

}  // namespace ajar
