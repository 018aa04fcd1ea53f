#include "shading/program/unsupported_settings.h"

#include <string_view>

namespace ajar::nodes {
namespace {

struct UnsupportedSetting {
  std::string_view node, name;     ///< bl_idname, and the identifier of a property
  float harmless_number;           ///< neutral value of a number
  std::string_view harmless_text;  ///< neutral choice; empty if the setting is a number
  const char* message;
};

constexpr const char* kFromInstancer = "From Instancer is not supported yet: the object's own coordinates are used";

constexpr UnsupportedSetting kSettings[] = {
    {"ShaderNodeTexCoord", "from_instancer", 0.0f, "", kFromInstancer},
    {"ShaderNodeUVMap", "from_instancer", 0.0f, "", kFromInstancer},
    {"ShaderNodeNormalMap", "base", 0.0f, "DISPLACED", "Base is not supported yet: the displaced surface is used"},
};

bool asks(const ProgramBuilder& builder, int node, const UnsupportedSetting& setting) {
  if (!setting.harmless_text.empty())
    return builder.text(node, setting.name, setting.harmless_text) != setting.harmless_text;
  return builder.number(node, setting.name, setting.harmless_number) != setting.harmless_number;
}

}  // namespace

void report_unsupported_settings(ProgramBuilder& builder, int node) {
  for (const UnsupportedSetting& setting : kSettings)
    if (setting.node == builder.node(node).type && asks(builder, node, setting)) builder.report(node, setting.message);
}

}  // namespace ajar::nodes
