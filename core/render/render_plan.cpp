#include "render/render_plan.h"

#include "integrators/integrator.h"
#include "transport/photons/photon_tracer.h"
#include "transport/bidirectional/vertex_merging.h"

namespace ajar {

RenderPlan make_render_plan(const Scene& scene) {
  RenderPlan plan;
  const LightSet& lights = scene.lights();
  const auto add = [&](const char* step, bool used, std::string reason) { plan.push_back({step, used, std::move(reason)}); };
  const auto number = [](uint64_t n) { return std::to_string(n); };

  add("light sampling", lights.can_choose(),
      lights.empty()         ? "nothing emits light"
      : lights.can_choose() ? (lights.size() == 1 ? std::string("one light or emissive triangle") : number(lights.size()) + " lights and emissive triangles, chosen by a light tree")
                             : "only the world emits, alike in all directions: scattered rays find it better");
  const bool environment = lights.environment_index() >= 0;
  add("environment", environment, environment ? "the world emits light" : "the world is black");
  const bool lamp_shapes = scene.has_lamp_shapes();
  add("lamp shapes", lamp_shapes, lamp_shapes ? "some lamps have extent and can be hit" : "no lamp has extent");
  const bool transparent = scene.statistics().transparent_shadows;
  add("transparent shadows", transparent,
      transparent ? "a visible material lets light straight through" : "no visible material is transparent: shadow rays stop at the first hit");
  const bool lens = scene.camera().has_lens();
  add("depth of field", lens, lens ? "the camera has an aperture" : "the camera is a pinhole");
  const uint64_t moving = scene.statistics().moving_instances;
  const std::string instances = number(moving) + (moving == 1 ? " object moves" : " objects move");
  add("motion keys", scene.moves(), !scene.moves()           ? "nothing moves while the shutter is open"
                                    : !scene.camera().moves() ? instances
                                    : moving == 0             ? "the camera moves"
                                                              : "the camera and " + instances);
  const int textures = scene.textures().decoded_count();
  add("textures", textures > 0, textures > 0 ? number(uint64_t(textures)) + " images decoded" : "no visible material uses an image");
  uint64_t used = 0, constant = 0;
  for (const ShaderProgram& program : scene.programs()) {
    ++used;
    constant += program.is_constant() ? 1 : 0;
  }
  add("shader programs", constant < used, number(used - constant) + " of " + number(used) + " materials evaluated per hit, the others constant");
  const PhotonPlan photons = plan_photons(scene);
  add("photon map", photons.global, photons.global_reason);
  add("caustic map", photons.caustic, photons.caustic_reason);
  const bool merges = find_integrator(scene.settings().integrator).can_merge, wanted = scene.settings().vertex_merging != "off";
  const MergingPlan merging = plan_merging(scene);
  add("vertex merging", merges && wanted && merging.used,
      !merges ? "this integrator joins no paths, or merges them all" : !merging.used || wanted ? merging.reason : std::string("switched off, though ") + merging.reason);
  const bool aux = scene.settings().passes.size() > 1;
  add("passes beyond Combined", aux, aux ? number(scene.settings().passes.size() - 1) + " asked for" : "nobody asked for one");
  return plan;
}

}  // namespace ajar
