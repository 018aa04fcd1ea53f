// RenderSettings, from its table: a property with a docstring for each row, and the rows as `setting_list()`.
#include "arrays.h"
#include "bind.h"
#include "description/settings_table.h"

namespace ajar::python {
namespace {

/// What Python sees of a field: choices that are known by their names are strings.
template <class T>
auto to_python(const T& value) {
  if constexpr (std::is_enum_v<T> && kKnownByName<T>)
    return std::string(name_of(value));
  else if constexpr (std::is_same_v<T, MistDescription>)
    return Vec3(value.start, value.depth, value.exponent);
  else
    return value;
}
template <class T>
using PythonValue = decltype(to_python(std::declval<const T&>()));

template <class T>
T from_python(const PythonValue<T>& value) {
  if constexpr (std::is_enum_v<T> && kKnownByName<T>)
    return choice_named<T>(value);
  else if constexpr (std::is_same_v<T, MistDescription>)
    return {value.x, value.y, value.z};
  else
    return value;
}

template <class Struct>
void bind_rows(py::class_<Struct>& python_class) {
  for (const Setting<Struct>& row : setting_table<Struct>()) {
    const std::string doc = facts_of(row) + ". " + row.text;
    Struct any;
    const auto bind_row = [&]<class T>(T*) {
      const auto field = [&row](Struct& object) -> T& { return *std::get<T*>(row.field(object)); };
      const auto set = [field](Struct& object, const PythonValue<T>& value) { field(object) = from_python<T>(value); };
      if constexpr (std::is_same_v<T, BounceLimits>)
        python_class.def_property(
            row.name, [field](Struct& object) -> T& { return field(object); }, set, doc.c_str());
      else
        python_class.def_property(
            row.name, [field](Struct& object) { return to_python(field(object)); }, set, doc.c_str());
    };
    std::visit(bind_row, row.field(any));
  }
}

/// A row as Python sees it.
struct SettingInfo {
  std::string name, type, unit, text;
  py::object initial;
  double minimum, maximum;
  py::list choices;
  std::string property, label, description, subtype;
  double lowest, highest, soft_maximum;
  py::object shown_first;
};

/// (name, label, sentence, number) of each value.
template <class E>
py::list choices_of() {
  py::list all;
  for (const Choice<E>& choice : choices<E>().all)
    all.append(py::make_tuple(choice.name, choice.label,
                              std::string(choice.sentence) + (choice.biased ? " Biased" : ""), int(choice.value)));
  return all;
}

template <class Struct>
void list_rows(std::vector<SettingInfo>& list, const std::string& prefix, const std::string& property_prefix) {
  Struct defaults;
  for (const Setting<Struct>& row : setting_table<Struct>()) {
    const auto add = [&]<class T>(T* field) {
      if constexpr (std::is_same_v<T, BounceLimits>) {
        list_rows<BounceLimits>(list, std::string(row.name) + ".", std::string(row.name) + "_");
      } else {
        SettingInfo info;
        info.name = prefix + row.name;
        info.unit = row.unit;
        info.text = row.text;
        info.minimum = row.range.min;
        info.maximum = row.range.max;
        info.type = std::is_same_v<T, bool>          ? "bool"
                    : std::is_integral_v<T>          ? "int"
                    : std::is_floating_point_v<T>    ? "float"
                    : std::is_enum_v<T>              ? "choice"
                    : std::is_same_v<T, std::string> ? "name"
                                                     : "list";
        if constexpr (std::is_enum_v<T>) {
          info.choices = choices_of<T>();
          info.initial = py::str(name_of(*field));
        } else {
          info.initial = py::cast(to_python(*field));
        }
        const SettingProperty& shown = row.property;
        info.property = shown.label == nullptr ? "" : shown.name ? shown.name : property_prefix + row.name;
        info.label = shown.label ? shown.label : "";
        info.description = shown.description ? shown.description : "";
        info.subtype = shown.subtype;
        info.lowest = std::max(shown.min, row.range.min);
        info.highest = std::min(shown.max, row.range.max);
        info.soft_maximum = std::min(shown.soft_max, info.highest);
        info.shown_first = shown.initial ? py::str(shown.initial) : info.initial;
        list.push_back(std::move(info));
      }
    };
    std::visit(add, row.field(defaults));
  }
}

}  // namespace

void bind_settings(py::module_& module) {
  py::class_<BounceLimits> bounces(module, "BounceLimits",
                                   "The limits on path length, as in Cycles. Values above 2^20 count as 2^20.");
  bind_rows(bounces);
  py::class_<RenderSettings> settings(module, "RenderSettings",
                                      "What to render and how. `copy.copy` copies the settings. Two settings are equal "
                                      "when all fields are equal. A list that is read is a copy: assign a new list to "
                                      "change it. The assignment of an unknown name of a choice raises SceneError.");
  settings.def(py::init<>(), "Make one with default values.")
      .def("__copy__", [](const RenderSettings& s) { return RenderSettings(s); })
      .def("__eq__", [](const RenderSettings& a, const RenderSettings& b) { return a == b; });
  bind_rows(settings);
  py::class_<SettingInfo>(module, "SettingInfo", "An entry of `setting_list()`.")
      .def_readonly("name", &SettingInfo::name,
                    "str. The name in `RenderSettings`. `bounces.total` is the field `total` of `bounces`.")
      .def_readonly("type", &SettingInfo::type, "str: \"bool\", \"int\", \"float\", \"choice\", \"name\" or \"list\".")
      .def_readonly("unit", &SettingInfo::unit, "str. The unit. Empty for a setting without one.")
      .def_readonly("text", &SettingInfo::text, "str. The meaning, in sentences.")
      .def_readonly("default", &SettingInfo::initial, "The default value. The name of a choice.")
      .def_readonly("minimum", &SettingInfo::minimum, "float. The minimum of a number.")
      .def_readonly("maximum", &SettingInfo::maximum, "float. The maximum of a number.")
      .def_readonly("choices", &SettingInfo::choices,
                    "list of tuples (name, label, sentence, number), in the order of the user interface. The number "
                    "stands for the choice in files of Blender. Empty if `type` is not \"choice\".")
      .def_readonly("property", &SettingInfo::property,
                    "str. The name of the property of the add-on. Empty for a setting that the add-on takes from "
                    "Blender.")
      .def_readonly("label", &SettingInfo::label, "str. The name in the user interface.")
      .def_readonly("description", &SettingInfo::description, "str. The description in the user interface.")
      .def_readonly("subtype", &SettingInfo::subtype, "str. The subtype of the property.")
      .def_readonly("property_minimum", &SettingInfo::lowest, "float. The minimum in the user interface.")
      .def_readonly("property_maximum", &SettingInfo::highest, "float. The maximum in the user interface.")
      .def_readonly("property_soft_maximum", &SettingInfo::soft_maximum,
                    "float. The maximum that sliders of the user interface reach.")
      .def_readonly("property_default", &SettingInfo::shown_first, "The default value in the user interface.");
  module.def(
      "setting_list",
      [] {
        std::vector<SettingInfo> list;
        list_rows<RenderSettings>(list, "", "");
        return list;
      },
      "Return the settings of `RenderSettings` as a list of SettingInfo: names, types, ranges, defaults and texts.");
}

}  // namespace ajar::python
