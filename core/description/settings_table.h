// One row for each field of RenderSettings: what it is called, means and may be. The rest of the program reads the rows:
// validation, the archive, the Python module, the command line of ajar-render, and the properties of the add-on.
// Defaults stand in RenderSettings only.
#pragma once

#include <limits>
#include <span>
#include <string>
#include <variant>

#include "description/settings.h"

namespace ajar {

/// A pointer to the field of a row in one object.
using SettingField = std::variant<int*, uint32_t*, float*, double*, bool*, std::string*, FilterKind*, BumpTerminator*,
                                  DirectMethod*, Guiding*, Merging*, ImageSampling*, ErrorMeasure*, std::array<int, 4>*,
                                  std::array<float, 4>*, std::vector<std::string>*, BounceLimits*, MistDescription*>;

/// What becomes of a value outside its range: an error, the bound, or the default.
enum class Outside : uint8_t { Refuse, Clamp, Reset };

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();
inline constexpr double kMaxInt = std::numeric_limits<int>::max();
inline constexpr double kMaxFloat = std::numeric_limits<float>::max();

/// Of a number. A NaN is treated as a value below the range.
struct SettingRange {
  double min = -kUnbounded, max = kUnbounded;
  Outside below = Outside::Clamp, above = Outside::Refuse;
};

/// How the add-on shows a setting.
struct SettingProperty {
  const char* label = nullptr;                                        ///< null: the add-on has no property for it
  const char* description = nullptr;                                  ///< for the artist
  double min = -kUnbounded, max = kUnbounded, soft_max = kUnbounded;  ///< of its property, within the range
  const char* subtype = "NONE";                                       ///< of Blender: what the number measures
  const char* name = nullptr;                                         ///< null: that of the field
  const char* initial = nullptr;  ///< the name of a choice that is not the core's default
};

template <class Struct>
struct Setting {
  const char* name;  ///< of the field, here and in Python
  SettingField (*field)(Struct&);
  const char* text;  ///< its meaning, in sentences
  const char* unit = "";
  SettingRange range = {};
  const char* option = nullptr;  ///< on the command line of ajar-render; null: the name with hyphens
  char since = '2';              ///< the version of the archive that has it first
  SettingProperty property = {};
};

/// The rows of a struct. RenderSettings: in the order of files, in which a new field is the last one.
template <class Struct>
std::span<const Setting<Struct>> setting_table();
template <>
std::span<const Setting<RenderSettings>> setting_table();
template <>
std::span<const Setting<BounceLimits>> setting_table();

/// Apply the ranges. Throws SceneError with the name of the setting for a value that is refused.
void apply_ranges(RenderSettings& settings);

/// The type in Python, the unit and the range, such as "int, pixels, 1 to 65536".
template <class Struct>
std::string facts_of(const Setting<Struct>& setting);
extern template std::string facts_of(const Setting<RenderSettings>&);
extern template std::string facts_of(const Setting<BounceLimits>&);

}  // namespace ajar
