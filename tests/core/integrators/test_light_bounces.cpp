// Max Bounces of lights: after more bounces they are not sampled any more, in every integrator that follows them.
#include "agreement.h"
#include "render/session.h"

namespace ajar::test_light_bounces {

using namespace fixtures;

namespace {

/// A room with mirrors and glass. Each lamp has its own number of bounces; rays can hit the area lamp and the large
/// sphere, and not the point.
SceneDescription limited_room() {
  SceneDescription d = grey_room();
  add_object(d, sphere(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.3f), moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f));
  add_object(d, sphere(), add_glossy(d, 0.0f), moved(Vec3(-0.5f, 0.5f, -0.6f), 0.3f));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.9f, 8.0f));
  d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 6.0f));
  d.lights.push_back(point_light(Vec3(0.5f, 0.2f, 0.2f), 6.0f, 0.2f));
  const int bounces[] = {1, 0, 2};
  const char* names[] = {"Panel", "Bulb", "Globe"};
  for (size_t i = 0; i < 3; ++i) {
    d.lights[i].name = names[i];
    d.lights[i].max_bounces = bounces[i];
  }
  return d;
}

}  // namespace

TEST(LightBounces, a_light_without_indirect_light_lights_directly_only) {
  SceneDescription d = grey_room();
  d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 8.0f));
  SceneDescription direct = d;
  d.lights[0].max_bounces = 0;
  direct.settings.bounces.total = 0;
  for (const char* integrator : {"path", "bdpt", "erpt", "metropolis", "pmc_pt"})
    EXPECT_TRUE(
        statistical::means_agree(whole(direct, "path", 64, 8, 100), whole(d, integrator, 64, 8, 200), {0.01, 5}))
        << integrator;
}

TEST(LightBounces, every_integrator_of_paths_has_the_mean_of_path_tracing) {
  const TransportScene scene{"limited_room", limited_room()};
  TransportScene unlimited{"unlimited", limited_room()};
  for (LightDescription& light : unlimited.description.lights) light.max_bounces = 1024;
  const double with = reference(scene.description, 64, 16)[kValues].mean(),
               without = reference(unlimited.description, 64, 16)[kValues].mean();
  EXPECT_LT(with, 0.85 * without);
  for (const char* integrator : {"bdpt", "erpt", "metropolis", "pmc_pt"})
    expect_agreement(scene, integrator, 48, 4, 0.06);
}

TEST(LightBounces, other_integrators_name_the_lights_that_they_do_not_limit) {
  SceneDescription d = limited_room();
  d.lights[2].max_bounces = 1024;
  d.settings.samples = 1;
  d.settings.photons = 500;
  d.settings.integrator = "photon_map";
  Session session;
  session.start(std::move(d));
  EXPECT_TRUE(session.wait(kHang));
  int said = 0;
  for (const Diagnostic& diagnostic : session.diagnostics())
    said += diagnostic.message.find("Max Bounces of 'Panel', 'Bulb'. Path Tracing does.") != std::string::npos;
  EXPECT_EQ(said, 1);
}

}  // namespace ajar::test_light_bounces
