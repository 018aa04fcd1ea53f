#include "integrators/render_plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "integrators/integrator.h"
#include "transport/bidirectional/lens_light.h"
#include "transport/direct/light_cut_cache.h"

namespace ajar {

namespace {

/// Maximum share of the samples for the pilot of direct light, the same in each iteration, because cells that the first
/// iteration does not reach learn nothing. The bounds are samples per pixel and iteration. The pilot is skipped below
/// the minimum. It has one sample if the number of samples is not known.
constexpr float kPilotShare = 0.08f, kMinPilot = 0.15f, kMaxPilot = 4.0f;
/// A render with at most this many samples ends before a measurement could decide whether guiding is efficient.
constexpr int kMinSamplesToMeasure = 16;

std::string number(uint64_t n) { return std::to_string(n); }
std::string memory(uint64_t bytes) {
  char text[32];
  if (bytes < (1u << 20))
    std::snprintf(text, sizeof text, "%.1f KiB", double(bytes) / 1024.0);
  else
    std::snprintf(text, sizeof text, "%.1f MiB", double(bytes) / 1048576.0);
  return text;
}

/// Whether the pass has a part of the light.
bool separates_light(const std::string& pass) { return is_part_pass(pass) || !light_group_of(pass).empty(); }
bool can_separate(const IntegratorInfo& integrator, const std::string& pass) {
  return is_part_pass(pass) ? integrator.knows_parts : integrator.knows_groups;
}

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// Decisions and their plan steps, one function for each.
class Planner {
 public:
  Planner(const Scene& scene, const IntegratorInfo& integrator)
      : scene_(scene), settings_(scene.settings()), integrator_(integrator) {}

  RenderPlan make() {
    plan_.media = scene_.has_media();
    plan_.parts = integrator_.knows_parts &&
                  std::any_of(settings_.passes.begin(), settings_.passes.end(), separates_light);
    // Media may emit, and light sampling does not find light behind portals.
    plan_.ends_early = !plan_.media && !scene_.emission_without_lights() && !scene_.has_portals();
    choose_lights();
    look_at_camera();
    look_at_shaders();
    choose_direct();
    choose_guiding();
    choose_photons();
    look_at_passes();
    return std::move(plan_);
  }

 private:
  void add(const char* step, bool used, std::string reason, std::string cost = {}) {
    plan_.steps.push_back({step, used, std::move(reason), used ? std::move(cost) : std::string()});
  }

  /// Techniques with walks from lights are those that follow hints.
  bool walks_from_lights() const { return integrator_.follows_hints && !integrator_.automatic; }

  void choose_lights() {
    const LightSet& lights = scene_.lights();
    const BuildStatistics& built = scene_.statistics();
    add("light sampling", scene_.scatters_light() && lights.can_choose(),
        !scene_.scatters_light() ? "nothing scatters light: the camera sees emission alone"
        : lights.empty()         ? "nothing emits light"
        : lights.can_choose()
            ? (lights.size() == 1 ? std::string("one light or emissive triangle")
                                  : number(lights.size()) + " lights and emissive triangles, chosen by a light tree")
            : "only the world emits, equally in all directions: scattered rays sample it better",
        "a shadow ray at each rough surface; light tree: " + memory(built.light_tree_bytes));
    const bool environment = lights.environment_index() >= 0;
    add("environment", environment, environment ? "the world emits light" : "the world is black",
        "tables: " + memory(built.environment_bytes));
    const bool catchers = scene_.catchers() != nullptr;
    add("shadow catchers", catchers,
        catchers ? "the camera sees shadow catchers: they are compared with a scene without the other objects"
                 : "the camera sees no shadow catcher",
        "a second path where the camera sees a catcher");
    add("light linking", lights.any_linked(),
        lights.any_linked() ? "some lights light some objects only" : "every light lights every object",
        "a light tree for each group of objects with the same lights");
    const bool lamp_shapes = scene_.has_lamp_shapes();
    add("lamp shapes", lamp_shapes, lamp_shapes ? "some lamps have extent and can be hit" : "no lamp has extent",
        "a second, small search along each ray");
    add("volumes", plan_.media,
        plan_.media ? "light scatters or is absorbed between surfaces"
                    : "no visible material and no world has a volume",
        "sampled along each ray and along each shadow ray");
  }

  void look_at_camera() {
    const BuildStatistics& built = scene_.statistics();
    const bool lens = scene_.camera().has_lens();
    add("depth of field", lens, lens ? "the camera has an aperture" : "the camera is a pinhole",
        "two random numbers a sample");
    const char* const against = LensLight::reason_against(scene_);
    plan_.lens_light = integrator_.samples_lens_light && !*against;
    add("small lights out of focus", plan_.lens_light,
        !integrator_.samples_lens_light ? "this integrator finds them by camera rays"
        : *against                      ? against
                                        : "a trial looks for lights that few camera rays would hit",
        "a light sample for each sample, or for a part of them, if the trial finds such lights");
    const uint64_t moving = built.moving_instances;
    const std::string instances = number(moving) + (moving == 1 ? " object moves" : " objects move");
    add("motion keys", scene_.moves(),
        !scene_.moves()            ? "nothing moves while the shutter is open"
        : !scene_.camera().moves() ? instances
        : moving == 0              ? "the camera moves"
                                   : "the camera and " + instances,
        "transforms are interpolated for each ray");
  }

  void look_at_shaders() {
    const BuildStatistics& built = scene_.statistics();
    const bool transparent = built.transparent_shadows;
    add("transparent shadows", transparent,
        transparent ? "a visible material lets light straight through"
                    : "no visible material is transparent: shadow rays stop at the first hit",
        "shadow rays are shaded at each surface they pass");
    add("ray portals", scene_.has_portals(),
        scene_.has_portals() ? "a visible material sends rays to another place: light behind it is found by paths from "
                               "the eye, and shadow rays end there"
                             : "no visible material has a Ray Portal");
    const int textures = scene_.textures().decoded_count();
    add("textures", textures > 0,
        textures > 0 ? number(uint64_t(textures)) + " images decoded" : "no visible material uses an image",
        memory(built.texture_bytes));
    uint64_t used = 0, constant = 0;
    int longest = 0;
    for (const ShaderProgram& program : scene_.programs()) {
      ++used;
      constant += program.is_constant() ? 1 : 0;
      longest = std::max(longest, program.instruction_count());
    }
    add("shader programs", constant < used,
        number(used - constant) + " of " + number(used) + " materials evaluated per hit, the others constant",
        "at most " + number(uint64_t(longest)) + " instructions a hit");
    look_below_surfaces();
    const bool by_kind = scene_.depends_on_ray_kind();
    add("surfaces by the kind of the ray", by_kind,
        by_kind ? "a visible material follows the Light Path node or has no transparent shadows, or shadow rays and "
                  "diffuse rays see different objects: paths from the eye find the light past them that other paths do "
                  "not know"
                : "no visible surface scatters light, or lets it pass, by the kind of the ray");
  }

  /// Chains and populations render only paths without walks below surfaces; they splat and take further samples.
  void look_below_surfaces() {
    const bool below = scene_.has_subsurface();
    const bool divides = integrator_.can_merge && integrator_.takes_further_samples;
    add("walks below surfaces", below,
        !below ? "light enters no visible material"
        : divides
            ? "paths with such walks are traced from the eye and connected to walks from lights; all others belong "
              "to " +
                  std::string(integrator_.label)
            : "light enters a visible material",
        divides ? "a walk from the eye for each direct sample" : "a random walk where a path enters");
  }

  /// Past surfaces that depend on the kind of the ray, light samples and hits find different light. The weights of the
  /// default method define how much of either counts, so other methods would change the image there.
  void choose_direct() {
    const Choice<DirectMethod>& asked = choice_of(settings_.direct);
    DirectPlan& direct = plan_.direct;
    direct = {asked.value, std::max(1, settings_.direct_samples), asked.biased, 1.0f};
    std::string instead;
    // Passes of light parts, and lights that are hidden from some kinds of lobes, need the direction of the sampled
    // light. Only the default method gives it, and only the default method supports media.
    const bool partial = scene_.lights().any_partial();
    if (plan_.media)
      instead = "there are volumes";
    else if (partial)
      instead = "a light is hidden from some kinds of rays or has its own blockers";
    else if (scene_.lights().any_linked())
      instead = "a light does not light all objects";
    else if (scene_.lights().any_limited())
      instead = "a light has its own number of bounces";
    else if (scene_.depends_on_ray_kind())
      instead = "a visible surface depends on the kind of the ray";
    else if (plan_.parts && integrator_.has_direct_methods)
      instead = "passes of parts of the light are asked for";
    if (asked.value == DirectMethod::Mis && direct.samples == 1) instead.clear();
    if (!instead.empty()) direct = {};
    if (settings_.samples > 0 && settings_.seconds == 0.0)
      direct.pilot_samples = std::min(
          kMaxPilot, kPilotShare * float(settings_.samples) / float(LightCutCache::iterations(scene_.lights())));
    else
      direct.pilot_samples = 1.0f;
    // Only the path tracer has a pilot. The irradiance cache learns from its passes.
    if (direct.method == DirectMethod::PmcHi && integrator_.has_direct_methods && !integrator_.stores_records &&
        direct.pilot_samples < kMinPilot) {
      direct.method = DirectMethod::Mis;
      instead = "too few samples to learn from";
    }
    const Choice<DirectMethod>& used = choice_of(direct.method);
    add("direct light method", instead.empty(),
        instead.empty()
            ? std::string(used.label) +
                  (direct.samples > 1 ? ", " + number(uint64_t(direct.samples)) + " samples" : "") + ": as asked for"
            : instead + ": the default method is used",
        number(uint64_t(direct.samples)) + (direct.samples > 1 ? " shadow rays" : " shadow ray") +
            " at a surface that the camera sees");
    if (scene_.lights().any_limited() && !integrator_.follows_light_bounces)
      plan_.warnings.emplace_back(std::string(integrator_.label) + " does not follow Max Bounces of " +
                                  listed(scene_.limited_lights()) + ". Path Tracing does.");
    if (walks_from_lights() && !scene_.partly_hidden_objects().empty())
      plan_.warnings.emplace_back("Only some kinds of bounces see " + listed(scene_.partly_hidden_objects()) +
                                  ". Walks from lights see what diffuse rays see: light that these objects block can "
                                  "differ. Path Tracing follows each kind of ray.");
    if (settings_.direct == DirectMethod::Mis) return;
    if (partial)
      plan_.warnings.emplace_back(
          "A light is hidden from some kinds of rays or has its own blockers: direct light is sampled by the default "
          "method.");
    if (scene_.lights().any_linked())
      plan_.warnings.emplace_back("A light does not light all objects: direct light is sampled by the default method.");
    if (plan_.media) plan_.warnings.emplace_back("There are volumes: direct light is sampled by the default method.");
  }

  void choose_guiding() {
    const bool asked = settings_.guiding != Guiding::Off;
    const bool few = settings_.samples != 0 && settings_.samples <= kMinSamplesToMeasure;
    plan_.guiding = settings_.guiding;
    if (settings_.guiding == Guiding::Auto && few) plan_.guiding = Guiding::Off;
    add("path guiding", plan_.guiding != Guiding::Off,
        !asked                           ? "not asked for"
        : plan_.guiding == Guiding::Off  ? "too few samples to learn from"
        : plan_.guiding == Guiding::Auto ? "a measurement during the render decides"
                                         : "asked for",
        "a tree over the scene, and a mixture of lobes at each surface and in volumes");
  }

  void choose_photons() {
    plan_.photons = plan_photons(scene_);
    const std::string photons = number(photons_of_a_pass(settings_)) + " photons a pass";
    add("photon map", plan_.photons.global, plan_.photons.global_reason, photons);
    add("caustic map", plan_.photons.caustic, plan_.photons.caustic_reason, "photons of the same passes");
    add("learned starts of light", walks_from_lights() && plan_.photons.caustic,
        !walks_from_lights()    ? "this integrator has no walks from lights"
        : plan_.photons.caustic ? "smooth surfaces may hide the light that matters; used where few starts reach it"
                                : plan_.photons.caustic_reason,
        "at least " + number(kPhotonsOfEmissionRound) + " photons before the render");
    const bool merges = integrator_.can_merge, wanted = settings_.vertex_merging != Merging::Off;
    const MergingPlan merging = plan_merging(scene_);
    plan_.merging = wanted && merging.used;
    add("vertex merging", merges && plan_.merging,
        !merges                   ? "this integrator does not connect paths, or merges all of them"
        : !merging.used || wanted ? merging.reason
                                  : std::string("switched off, although ") + merging.reason,
        photons);
  }

  void look_at_passes() {
    const bool aux = settings_.passes.size() > 1;
    add("passes beyond Combined", aux,
        aux ? number(settings_.passes.size() - 1) + " asked for" : "no pass is asked for",
        memory(uint64_t(settings_.width) * uint64_t(settings_.height) * 16 * (settings_.passes.size() - 1)) +
            " at most");
    std::vector<std::string> parts, black;
    for (const std::string& pass : settings_.passes)
      if (separates_light(pass)) (can_separate(integrator_, pass) ? parts : black).push_back(pass);
    if (!black.empty())
      plan_.warnings.emplace_back(std::string(integrator_.label) + " does not render the passes " + listed(black) +
                                  ": they stay black. Path Tracing renders them.");
    if (plan_.parts && integrator_.has_direct_methods && settings_.direct != DirectMethod::Mis)
      plan_.warnings.emplace_back("For the passes " + listed(parts) +
                                  ", direct light is sampled by the default method.");
  }

  const Scene& scene_;
  const RenderSettings& settings_;
  const IntegratorInfo& integrator_;
  RenderPlan plan_;
};

}  // namespace

RenderPlan make_render_plan(const Scene& scene, const IntegratorInfo& integrator,
                            std::shared_ptr<const AttachedHints> hints) {
  if (scene.camera().sees_texels() && !integrator.bakes)
    throw SceneError(std::string(integrator.label) + " cannot bake. Choose Path Tracing.");
  RenderPlan plan = Planner(scene, integrator).make();
  plan.hints = hints ? std::move(hints) : std::make_shared<const AttachedHints>(attach_hints(scene));
  return plan;
}

std::string left_out_by(const Scene& scene, const IntegratorInfo& integrator) {
  for (const std::string& pass : scene.settings().passes)
    if (separates_light(pass) && !can_separate(integrator, pass))
      return is_part_pass(pass) ? "passes of parts of the light are asked for" : "passes of light groups are asked for";
  if (scene.lights().any_limited() && !integrator.follows_light_bounces) return "a light has its own number of bounces";
  return {};
}

RenderPlan make_render_plan(const Scene& scene) {
  return make_render_plan(scene, find_integrator(scene.settings().integrator));
}

}  // namespace ajar
