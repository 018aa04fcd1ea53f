// The shader of objects without a material.
#pragma once

#include <utility>

#include "description/scene_description.h"

namespace ajar {

/// Grey surface of objects without a material, as in Blender.
inline NodeGraph default_surface() {
  NodeGraph graph;
  Node diffuse;
  diffuse.type = "ShaderNodeBsdfDiffuse";
  diffuse.name = "Default Surface";
  diffuse.inputs.push_back({"Color", {}, Vec4(0.8f, 0.8f, 0.8f, 1.0f)});
  diffuse.inputs.push_back({"Roughness", {}, Vec4(0.0f)});
  graph.nodes.push_back(std::move(diffuse));
  graph.surface = {0, "BSDF"};
  return graph;
}

}  // namespace ajar
