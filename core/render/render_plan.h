// What this scene needs, what is skipped, and why: data, computed before rendering,
// printed, tested and shown.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace ajar {

struct PlanStep {
  std::string step;
  bool used;
  std::string reason;
};
using RenderPlan = std::vector<PlanStep>;

RenderPlan make_render_plan(const Scene& scene);

}  // namespace ajar
