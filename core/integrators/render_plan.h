// What a scene needs, what is skipped, and why: decided here and only here, before an integrator prepares, and handed
// to it. Each decision is a field that the integrators read, and a step with its reason and its cost that is printed,
// tested and shown.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scene/scene.h"
#include "transport/bidirectional/vertex_merging.h"
#include "transport/direct/direct_methods.h"
#include "transport/hints/hints.h"
#include "transport/photons/photon_tracer.h"

namespace ajar {

struct IntegratorInfo;

struct PlanStep {
  std::string step;
  bool used;
  std::string reason;
  std::string cost;  ///< of what is used: memory, rays or work; empty where it is not worth a word
};
using PlanSteps = std::vector<PlanStep>;

/// How direct light is sampled at rough surfaces.
struct DirectPlan {
  DirectMethod method = DirectMethod::Mis;
  int samples = 1;  ///< of an estimate at what the camera sees
  bool biased = false;
  float pilot_samples = 0.0f;  ///< of a pixel in each iteration of the pilot of a method that learns first
};

enum class Guiding : uint8_t {
  Off,
  Measured,
  /// Measured: guided where a measurement during the render says that it pays
  On
};

struct RenderPlan {
  bool media = false;  ///< light scatters between surfaces
  bool parts = false;  ///< passes made of SampleParts are asked for, and the integrator tells them
  /// emission that light sampling does not know of is nowhere: a path's last ray may be left out
  bool ends_early = false;
  DirectPlan direct;
  Guiding guiding = Guiding::Off;  ///< of path tracing
  bool merging = false;            ///< paths that no connection finds are merged with photons
  PhotonPlan photons;
  std::shared_ptr<const AttachedHints> hints;  ///< of the scene; never null
  PlanSteps steps;
  /// What was asked for and is not done, each a sentence for the artist.
  std::vector<std::string> warnings;
};

/// `integrator`: who renders. `hints`: of the scene, where they are attached already.
RenderPlan make_render_plan(const Scene& scene, const IntegratorInfo& integrator,
                            std::shared_ptr<const AttachedHints> hints = nullptr);
/// For the integrator that the scene's settings name.
RenderPlan make_render_plan(const Scene& scene);

}  // namespace ajar
