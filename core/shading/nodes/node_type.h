// One row of the table in which the file of a node family lists its nodes.
#pragma once

#include <span>
#include <string_view>

#include "shading/program/program_builder.h"

namespace ajar {

struct NodeType {
  std::string_view name;  ///< Blender's bl_idname
  NodeFunction function;
};

}  // namespace ajar
