// What a scene needs, what is skipped, and why. All these decisions are made here, before an integrator prepares, and
// passed to it. Each decision is a field that integrators read, and a step with its reason and its cost that is
// printed, tested and displayed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "description/choices.h"
#include "scene/scene.h"
#include "transport/bidirectional/vertex_merging.h"
#include "transport/hints/hints.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

struct IntegratorInfo;

struct PlanStep {
  std::string step;
  bool used;
  std::string reason;
  std::string cost;  ///< of a used step: memory, rays or work; empty if negligible
};
using PlanSteps = std::vector<PlanStep>;

/// How direct light is sampled at rough surfaces.
struct DirectPlan {
  DirectMethod method = DirectMethod::Mis;
  int samples = 1;  ///< of an estimate at a surface that the camera sees
  bool biased = false;
  float pilot_samples = 0.0f;  ///< for methods that learn first: samples per pixel in each iteration of their pilot
};

struct RenderPlan {
  bool media = false;  ///< light scatters between surfaces
  bool parts = false;  ///< passes that consist of SampleParts are requested, and the integrator renders them
  /// All emission is known to light sampling, so the last ray of a path may be left out.
  bool ends_early = false;
  DirectPlan direct;
  Guiding guiding = Guiding::Off;  ///< of path tracing
  bool lens_light = false;         ///< path tracing tries transport/bidirectional/lens_light.h
  bool merging = false;            ///< paths that cannot be connected are merged with photons
  PhotonPlan photons;
  std::shared_ptr<const AttachedHints> hints;  ///< of the scene; never null
  PlanSteps steps;
  /// What the settings ask for but is not done. One sentence for each, shown to the artist.
  std::vector<std::string> warnings;
};

/// `integrator`: renders the scene. `hints`: of the scene, if they are already attached.
RenderPlan make_render_plan(const Scene& scene, const IntegratorInfo& integrator,
                            std::shared_ptr<const AttachedHints> hints = nullptr);
/// For the integrator in the scene's settings.
RenderPlan make_render_plan(const Scene& scene);

/// What the scene asks for and this integrator leaves out, as a reason of `auto` not to choose it; empty: nothing.
std::string left_out_by(const Scene& scene, const IntegratorInfo& integrator);

}  // namespace ajar
