// Passes that are accumulated in tables of their own, only if they are asked for: Cryptomatte, AOVs, light groups, motion
// vectors, ambient occlusion, roughness and the time of samples.
//
// Cryptomatte 1.2 (Friedman and Jones 2015): a matte is identified by a 32-bit hash of its name, stored as a float. The
// pass has, for each pixel, the ids with the largest coverage and their coverages. A pixel has a table of some more ids
// than the pass shows. If it is full, a new id replaces the one with the smallest coverage if that is smaller than its
// own. The coverage that is lost in this way is counted.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "math/name_hash.h"
#include "math/types.h"

namespace ajar {

enum class MatteKind : uint8_t { Object, Material, Asset };
/// A pass of Cryptomatte: "CryptoObject00" has the two ids with the largest coverage, "CryptoObject01" the next two.
struct MattePass {
  MatteKind kind;
  int number;
};
std::optional<MattePass> matte_pass(const std::string& pass);

/// A pass of an AOV Output node: its colour or its value.
struct AovPass {
  uint32_t name;  ///< hash of the name of the node's output
  bool is_color;
  bool operator==(const AovPass&) const = default;
};
inline constexpr const char *kColorAov = "AOV Color ", *kValueAov = "AOV Value ";  ///< names of passes begin with these
std::optional<AovPass> aov_pass(const std::string& pass);

/// The pass of a light group is named after its group.
inline constexpr const char* kLightGroup = "Combined_";
/// The name of the group of a pass; empty: it is the pass of no group.
std::string light_group_of(const std::string& pass);

/// A surface that a camera ray sees: its ids by MatteKind, and its coverage of the sample.
struct MatteSample {
  std::array<float, 3> ids;
  float weight;
};

/// Values of one sample for these passes.
struct SampleExtras {
  bool wants_mattes = false, wants_motion = false, wants_occlusion = false, wants_roughness = false;
  std::chrono::steady_clock::time_point begin;       ///< of the sample, for the pass Render Time
  const std::vector<AovPass>* aov_passes = nullptr;  ///< null: none
  uint32_t pixel = 0, index = 0;                     ///< the number of the pixel and of its sample
  std::vector<MatteSample> mattes;
  std::vector<Vec4> aovs;  ///< for each of aov_passes
  Vec4 motion{0.0f};
  bool has_motion = false;
  float occlusion = 0.0f, roughness = 0.0f;
};

class ExtraPasses {
 public:
  ExtraPasses() = default;
  ExtraPasses(const std::vector<std::string>& passes, size_t pixels);
  static bool makes(const std::string& pass);
  static uint64_t bytes_per_pixel(const std::vector<std::string>& passes);
  uint64_t memory_bytes() const;
  /// Whether any of them is made from SampleExtras.
  bool wanted() const {
    return any_mattes_ || !aov_passes_.empty() || !motion_.empty() || !occlusion_.empty() || !roughness_.empty() ||
           !seconds_.empty();
  }
  /// The light groups whose passes are asked for, in the order in which add_groups expects their light.
  const std::vector<std::string>& groups() const { return groups_; }
  /// Prepares the values of sample `index` of a pixel.
  void begin(SampleExtras& extras, uint32_t pixel, uint32_t index) const;
  void add(size_t pixel, const SampleExtras& extras);
  void add_groups(size_t pixel, const std::vector<Color>& light);
  /// Writes a pass of a pixel with `count` samples.
  void resolve(const std::string& pass, size_t pixel, double count, float exposure, float* out) const;
  /// Coverage of mattes that did not fit into the tables, as a number of samples.
  double dropped() const { return dropped_.load(std::memory_order_relaxed); }

 private:
  struct Rank {
    float id = 0.0f, weight = 0.0f;
  };
  struct Table {
    int ranks = 0;  ///< of each pixel; 0: the matte is not asked for
    std::vector<Rank> all;
  };
  void add_to(Table& table, size_t pixel, float id, float weight);
  std::array<Table, 3> tables_;
  bool any_mattes_ = false;
  std::atomic<double> dropped_{0.0};
  std::vector<AovPass> aov_passes_;
  std::vector<Vec4> aovs_;
  std::vector<std::string> groups_;
  std::vector<glm::dvec3> group_light_;
  std::vector<glm::dvec4> motion_;
  std::vector<float> motion_count_;
  std::vector<double> occlusion_, roughness_, seconds_;
};

/// The passes of one matte of two renders, merged by the ids of their ranks. Two ranks of a pixel are four floats in a
/// pass. The weights of the renders are `wa` and `wb`.
std::vector<std::vector<float>> merge_mattes(const std::vector<const std::vector<float>*>& a, double wa,
                                             const std::vector<const std::vector<float>*>& b, double wb);

}  // namespace ajar
