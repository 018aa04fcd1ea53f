#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "description/archive.h"
#include "description/settings_table.h"
#include "description/validate.h"

namespace ajar::test_settings_table {

namespace {

/// Converts to everything that a field may be.
struct Anything {
  template <class T>
  operator T() const;
};

/// The number of fields of an aggregate: how many initializers it takes.
template <class Struct, class... Given>
constexpr size_t field_count() {
  if constexpr (requires { Struct{Given{}..., Anything{}}; })
    return field_count<Struct, Given..., Anything>();
  else
    return sizeof...(Given);
}

template <class Struct>
void expect_a_row_for_each_field() {
  Struct values;
  std::set<std::string> names;
  std::set<const void*> fields;
  for (const Setting<Struct>& row : setting_table<Struct>()) {
    names.insert(row.name);
    fields.insert(std::visit([](auto* field) -> const void* { return field; }, row.field(values)));
  }
  EXPECT_EQ(names.size(), setting_table<Struct>().size());
  EXPECT_EQ(fields.size(), setting_table<Struct>().size());
  EXPECT_EQ(setting_table<Struct>().size(), field_count<Struct>());
}

template <class Struct>
void expect_defaults_in_their_ranges() {
  Struct defaults;
  for (const Setting<Struct>& row : setting_table<Struct>()) {
    const auto check = [&]<class T>(T* field) {
      if constexpr (std::is_arithmetic_v<T>) {
        EXPECT_GE(double(*field), row.range.min) << row.name;
        EXPECT_LE(double(*field), row.range.max) << row.name;
        if (!row.property.label) return;
        EXPECT_GE(double(*field), row.property.min) << row.name;
        EXPECT_LE(double(*field), row.property.max) << row.name;
      }
    };
    std::visit(check, row.field(defaults));
  }
}

template <class E>
void expect_distinct_choices() {
  std::set<std::string> names;
  std::set<E> values;
  for (const Choice<E>& choice : choices<E>().all) {
    names.insert(choice.name);
    values.insert(choice.value);
    EXPECT_EQ(choice_named<E>(choice.name), choice.value);
    EXPECT_STREQ(name_of(choice.value), choice.name);
  }
  EXPECT_EQ(names.size(), choices<E>().all.size());
  EXPECT_EQ(values.size(), choices<E>().all.size());
  EXPECT_EQ(size_t(*values.rbegin()) + 1, values.size()) << choices<E>().what;
}

std::string refusal(RenderSettings settings) {
  try {
    apply_ranges(settings);
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST(SettingsTable, every_field_of_the_settings_has_a_row) {
  expect_a_row_for_each_field<RenderSettings>();
  expect_a_row_for_each_field<BounceLimits>();
}

TEST(SettingsTable, defaults_are_in_their_ranges) {
  expect_defaults_in_their_ranges<RenderSettings>();
  expect_defaults_in_their_ranges<BounceLimits>();
}

TEST(SettingsTable, rows_are_in_the_order_of_the_versions_of_the_archive) {
  const auto rows = setting_table<RenderSettings>();
  for (size_t i = 1; i < rows.size(); ++i) EXPECT_LE(rows[i - 1].since, rows[i].since) << rows[i].name;
  EXPECT_LE(rows.back().since, to_bytes(SceneDescription{}).at(7));
}

TEST(SettingsTable, choices_have_distinct_names_and_values_without_gaps) {
  expect_distinct_choices<FilterKind>();
  expect_distinct_choices<BumpTerminator>();
  expect_distinct_choices<DirectMethod>();
  expect_distinct_choices<Guiding>();
  expect_distinct_choices<Merging>();
  expect_distinct_choices<ImageSampling>();
  expect_distinct_choices<ErrorMeasure>();
}

TEST(SettingsTable, unknown_names_are_refused_with_the_valid_ones) {
  try {
    choice_named<Guiding>("always");
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(), "Unknown guiding 'always'. Valid names: off, on, auto.");
  }
}

TEST(SettingsTable, values_outside_their_ranges_are_refused_by_the_name_of_the_setting) {
  EXPECT_EQ(refusal({}), "");
  EXPECT_EQ(refusal({.width = 0}), "The setting 'width' is 0. The minimum is 1.");
  EXPECT_EQ(refusal({.height = 65537}), "The setting 'height' is 65537. The maximum is 65536.");
  EXPECT_EQ(refusal({.filter_width = 1001.0f}), "The setting 'filter_width' is 1001. The maximum is 1000.");
  EXPECT_EQ(refusal({.exposure = std::nanf("")}), "The setting 'exposure' is not a number.");
  EXPECT_EQ(refusal({.direct_samples = 65537}), "The setting 'direct_samples' is 65537. The maximum is 65536.");
  EXPECT_EQ(refusal({.gather_rays = 65537}), "The setting 'gather_rays' is 65537. The maximum is 65536.");
}

TEST(SettingsTable, other_values_outside_their_ranges_become_the_bound_or_the_default) {
  RenderSettings s;
  s.bounces.volume = 1 << 21;
  s.bounces.diffuse = -3;
  s.filter_width = std::nanf("");
  s.importance_factor = std::numeric_limits<float>::infinity();
  s.samples = -1;
  s.seconds = std::nan("");
  s.direct_samples = 0;
  apply_ranges(s);
  EXPECT_EQ(s.bounces.volume, 1 << 20);
  EXPECT_EQ(s.bounces.diffuse, 0);
  EXPECT_EQ(s.filter_width, 0.01f);
  EXPECT_EQ(s.importance_factor, 1.0f);
  EXPECT_EQ(s.samples, 0);
  EXPECT_EQ(s.seconds, 0.0);
  EXPECT_EQ(s.direct_samples, 1);
  s.importance_factor = -2.0f;
  apply_ranges(s);
  EXPECT_EQ(s.importance_factor, 1.0f);
}

TEST(SettingsTable, facts_state_the_type_the_unit_and_the_range) {
  std::map<std::string, std::string> facts;
  for (const Setting<RenderSettings>& row : setting_table<RenderSettings>()) facts[row.name] = facts_of(row);
  EXPECT_EQ(facts["width"], "int, pixels, 1 to 65536");
  EXPECT_EQ(facts["seconds"], "float, seconds, >= 0");
  EXPECT_EQ(facts["exposure"], "float");
  EXPECT_EQ(facts["guiding"], "str: \"off\", \"on\" or \"auto\"");
  EXPECT_EQ(facts["passes"], "list of str");
}

}  // namespace ajar::test_settings_table
