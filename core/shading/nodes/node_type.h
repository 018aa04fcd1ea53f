// A node family is one file, which lists its nodes as rows of this table.
#pragma once

#include <span>
#include <string_view>

#include "shading/program/program_builder.h"

namespace ajar {

struct NodeType {
  std::string_view name;  ///< bl_idname
  NodeFunction function;
};

}  // namespace ajar
