// What the Light Path node knows of rays behind glass and thin walls. The values are those of Cycles 3.4.1, 5.0.1 and 5.2.3.
#include "agreement.h"
#include "transport_scenes.h"

namespace ajar::test_light_path {

namespace {

using namespace fixtures;

constexpr float kBelow = 2.0f;  // metres from the sheet to the emitter

int add_emitter(SceneDescription& d, const char* output) {
  if (!output) return add_diffuse(d, Color(0.0f), Color(1.0f));
  GraphBuilder b;
  b.emit(b.node("ShaderNodeLightPath"), output);
  return add_material(d, b);
}
int add_smooth_glass(SceneDescription& d) { return add_glass(d, 0.0f); }
int add_thin_wall(SceneDescription& d) {
  return add_closure(d, "ShaderNodeBsdfPrincipled",
                     {value_input("Base Color", Vec4(1.0f)), value_input("Roughness", 0.0f), value_input("IOR", 1.5f),
                      value_input("Specular IOR Level", 0.5f), value_input("Transmission Weight", 1.0f),
                      value_input("Thin Wall", 1.0f)});
}
int add_clear(SceneDescription& d) {
  return add_closure(d, "ShaderNodeBsdfTransparent", {value_input("Color", Vec4(1.0f))});
}

/// The mean of an image in which the camera sees an emitter of this strength (null: 1) through a sheet.
double seen(int (*add_sheet)(SceneDescription&), const char* output, const char* integrator) {
  SceneDescription d;
  set_camera(d, Vec3(0, 0, 3), Vec3(0.0f), 8);
  add_object(d, plane(20.0f), add_sheet(d));
  add_object(d, plane(40.0f), add_emitter(d, output), moved(Vec3(0, 0, -kBelow)));
  RunningMoments mean;
  const std::vector<float> image = render(d, integrator, 16, 1);
  for (size_t i = 0; i < image.size(); i += 4) mean.add(image[i]);
  return mean.mean();
}

}  // namespace

TEST(LightPath, a_ray_behind_glass_or_a_thin_wall_is_transmitted_glossy_and_singular) {
  struct Case {
    const char* output;
    double of_transmitted, of_passed;
  };
  const Case cases[] = {{"Is Camera Ray", 0.0, 1.0},     {"Is Diffuse Ray", 0.0, 0.0},
                        {"Is Glossy Ray", 1.0, 0.0},     {"Is Singular Ray", 1.0, 0.0},
                        {"Is Reflection Ray", 0.0, 0.0}, {"Is Transmission Ray", 1.0, 0.0}};
  for (const char* integrator : {"path", "bdpt"}) {
    const double through_glass = seen(add_smooth_glass, nullptr, integrator),
                 through_wall = seen(add_thin_wall, nullptr, integrator), clear = seen(add_clear, nullptr, integrator);
    ASSERT_GT(through_glass, 0.8);
    ASSERT_GT(through_wall, 0.8);
    for (const Case& c : cases) {
      EXPECT_NEAR(seen(add_smooth_glass, c.output, integrator), c.of_transmitted * through_glass, 1e-4)
          << c.output << ", glass, " << integrator;
      EXPECT_NEAR(seen(add_thin_wall, c.output, integrator), c.of_transmitted * through_wall, 1e-4)
          << c.output << ", thin wall, " << integrator;
      EXPECT_NEAR(seen(add_clear, c.output, integrator), c.of_passed * clear, 1e-4)
          << c.output << ", Transparent, " << integrator;
    }
  }
}

TEST(LightPath, a_ray_begins_at_a_thin_wall_and_not_at_a_transparent_surface) {
  for (const char* integrator : {"path", "bdpt"}) {
    const double behind_wall = seen(add_thin_wall, "Ray Length", integrator) / seen(add_thin_wall, nullptr, integrator),
                 clear = seen(add_clear, "Ray Length", integrator) / seen(add_clear, nullptr, integrator);
    EXPECT_GT(behind_wall, kBelow);
    EXPECT_LT(behind_wall, 1.3 * kBelow) << integrator;
    EXPECT_GT(clear, 3.0 + kBelow) << integrator;
  }
}

// Rays through glass see what is visible to transmission, whatever glossy rays see.
TEST(LightPath, visibility_to_glossy_rays_is_for_reflections) {
  for (const uint32_t hidden_from : {uint32_t(kVisibleGlossy), uint32_t(kVisibleTransmission)}) {
    SceneDescription d;
    set_camera(d, Vec3(0, 0, 3), Vec3(0.0f), 8);
    add_object(d, plane(20.0f), add_smooth_glass(d));
    add_object(d, plane(40.0f), add_diffuse(d, Color(0.0f), Color(1.0f)), moved(Vec3(0, 0, -kBelow)));
    d.objects.back().visibility &= ~hidden_from;
    set_world(d, Color(2.0f));
    d.world.visibility &= ~hidden_from;
    const float center = render(d, "path", 16, 1)[4 * (4 * 8 + 4)];
    if (hidden_from == uint32_t(kVisibleGlossy))
      EXPECT_GT(center, 0.8f);
    else
      EXPECT_LT(center, 0.3f) << "only the reflected sky is left";
  }
}

}  // namespace ajar::test_light_path
