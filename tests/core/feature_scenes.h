// Small scenes that each have one feature of real scenes: hair, motion, lights that some rays do not see, panoramas, lamps
// of negative power. Every integrator renders them with the mean of path tracing.
#pragma once

#include "transport_scenes.h"

namespace ajar::fixtures {

/// Moves an instance from one position to another while the shutter is open, by scales and translations.
inline void move_instance(SceneDescription& d, size_t instance, const Mat4& from, const Mat4& to) {
  d.instances[instance].first_motion_key = int(d.motion_keys.size());
  d.instances[instance].motion_key_count = 2;
  d.motion_keys.push_back(rows(from));
  d.motion_keys.push_back(rows(to));
}

/// A material that only encloses a volume of this node type. `density` at x = -1 and 1 of the unit cube.
inline int add_medium(SceneDescription& d, const std::string& type, Color color, Vec2 density,
                      float anisotropy = 0.0f) {
  GraphBuilder b;
  NodeInput socket = value_input("Density", density.x);
  if (density.x != density.y) {
    const int coordinates = b.node("ShaderNodeTexCoord");
    const int x = b.node("ShaderNodeSeparateXYZ", {linked_input("Vector", coordinates, "Generated")});
    const int ramp = b.node("ShaderNodeMapRange", {linked_input("Value", x, "X"), value_input("From Min", 0.0f),
                                                   value_input("From Max", 1.0f), value_input("To Min", density.x),
                                                   value_input("To Max", density.y)});
    socket = linked_input("Density", ramp, "Result");
  }
  b.graph.volume = {
      b.node(type, {value_input("Color", Vec4(color, 1.0f)), socket, value_input("Anisotropy", anisotropy)}), "Volume"};
  return add_material(d, b);
}
inline std::vector<TransportScene> feature_scenes() {
  std::vector<TransportScene> scenes;
  const LightDescription lamp = area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f);
  const Mat4 ball = moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f);
  const auto add = [&](const char* name, const std::function<void(SceneDescription&)>& fill) {
    SceneDescription d = grey_room();
    fill(d);
    scenes.push_back({name, std::move(d)});
  };
  for (const StrandShape shape : {StrandShape::Ribbon, StrandShape::Round})
    add(shape == StrandShape::Ribbon ? "ribbons" : "round_hair", [&](SceneDescription& d) {
      add_object(d, curls(300, shape), add_diffuse(d, Color(0.8f, 0.5f, 0.3f)), moved(Vec3(0.2f, 0.2f, -0.3f), 1.5f));
      d.lights.push_back(lamp);
    });
  add("shaded_hair", [&](SceneDescription& d) {
    GraphBuilder b;
    const int fibre = b.node("ShaderNodeBsdfHairPrincipled",
                             {value_input("Color", Vec4(0.8f, 0.5f, 0.3f, 1.0f)), value_input("Roughness", 0.5f),
                              value_input("Radial Roughness", 0.5f), value_input("Offset", 0.1f)});
    b.graph.surface = {fibre, "BSDF"};
    add_object(d, curls(300, StrandShape::Ribbon), add_material(d, b), moved(Vec3(0.2f, 0.2f, -0.3f), 1.5f));
    d.lights.push_back(lamp);
  });
  for (const float aspect : {1.0f, 0.6f})
    add(aspect == 1.0f ? "hair_of_facets" : "oval_hair", [&](SceneDescription& d) {
      GraphBuilder b;
      const int fibre = b.node("ShaderNodeBsdfHairPrincipled",
                               {value_input("Color", Vec4(0.8f, 0.5f, 0.3f, 1.0f)), value_input("Roughness", 0.4f),
                                value_input("Aspect Ratio", aspect), value_input("Offset", 0.1f)},
                               {text_property("model", "HUANG")});
      b.graph.surface = {fibre, "BSDF"};
      add_object(d, curls(300, StrandShape::Ribbon), add_material(d, b), moved(Vec3(0.2f, 0.2f, -0.3f), 1.5f));
      d.lights.push_back(lamp);
    });
  add("points", [&](SceneDescription& d) {
    add_object(d, random_cloud(150, 0.02f), add_diffuse(d, Color(0.8f, 0.5f, 0.3f)),
               moved(Vec3(0.2f, 0.2f, -0.3f), 0.6f));
    d.lights.push_back(lamp);
  });
  // Light that crosses a point leaves at another place than the one where it is scattered. The points are small.
  add("translucent_points", [&](SceneDescription& d) {
    add_object(d, random_cloud(300, 0.015f), add_half_diffuse(d, "ShaderNodeBsdfTranslucent", 0.0f),
               moved(Vec3(0.2f, 0.2f, -0.3f), 0.6f));
    d.lights.push_back(lamp);
  });
  // Light that refraction sends into a point arrives from a direction in which no walk from a light arrives.
  add("frosted_points", [&](SceneDescription& d) {
    add_object(d, random_cloud(20, 0.1f), add_glass(d, 0.25f), moved(Vec3(0.2f, 0.2f, -0.3f), 0.6f));
    d.lights.push_back(lamp);
  });
  // Light that leaves the liquid through the glass is no caustic of the map.
  add("liquid_in_glass", [&](SceneDescription& d) {
    GraphBuilder b;
    b.graph.surface = {b.node("ShaderNodeBsdfGlass", {value_input("Color", Vec4(1.0f)), value_input("Roughness", 0.0f),
                                                      value_input("IOR", 1.3f)}),
                       "BSDF"};
    b.graph.volume = {
        b.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(0.8f, 0.75f, 0.7f, 1.0f)),
                                           value_input("Density", 1.5f), value_input("Anisotropy", 0.0f)}),
        "Volume"};
    add_object(d, sphere(), add_material(d, b), moved(Vec3(0.1f, 0.1f, -0.2f), 0.75f));
    d.lights.push_back(area_lamp(Vec3(0, 0, 0.95f), Vec3(0, 0, -1), 1.8f, 8.0f));
    BounceLimits& limits = d.settings.bounces;
    limits.total = limits.diffuse = limits.glossy = limits.transmission = limits.volume = 24;
  });
  add("shining_points", [&](SceneDescription& d) {
    add_object(d, random_cloud(20, 0.03f), add_diffuse(d, Color(0.3f), Color(3.0f, 2.0f, 1.0f)),
               moved(Vec3(-0.3f, 0.2f, 0.2f), 0.4f));
    d.lights.push_back(lamp);
  });
  add("moving_light", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.3f), Color(2.0f, 1.5f, 1.0f)), ball);
    move_instance(d, 1, moved(Vec3(-0.5f, 0.3f, -0.4f), 0.3f), moved(Vec3(0.5f, 0.3f, 0.2f), 0.3f));
    d.lights.push_back(lamp);
  });
  add("moving_ball", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    move_instance(d, 1, moved(Vec3(-0.5f, 0.3f, -0.4f), 0.4f), moved(Vec3(0.5f, 0.3f, 0.2f), 0.4f));
    d.lights.push_back(lamp);
  });
  add("moving_glass", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glass(d, 0.0f), ball);
    move_instance(d, 1, moved(Vec3(-0.3f, 0.3f, -0.4f), 0.4f), moved(Vec3(0.3f, 0.3f, -0.2f), 0.4f));
    d.lights.push_back(lamp);
  });
  add("deforming_ball", [&](SceneDescription& d) {
    MeshDescription mesh = sphere(8);
    for (const Vec3 factor : {Vec3(0.5f, 0.5f, 1.5f), Vec3(1.5f, 1.0f, 0.5f)})
      for (const Vec3 p : mesh.positions) mesh.motion_positions.push_back(factor * p);
    add_object(d, std::move(mesh), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
  });
  add("zooming_camera", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
    d.camera.window_motion = {0.7f * d.camera.screen_window, 1.1f * d.camera.screen_window};
  });
  add("moving_camera", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
    const std::array<float, 12> start = d.camera.world_from_camera;
    std::array<float, 12> end = start;
    end[3] += 0.2f, end[7] += 0.1f, end[11] -= 0.2f;
    d.camera.motion = {start, end};
    d.camera.shutter = {0.0f, 0.4f, 0.6f, 1.0f};
  });
  // The shader of a light sees the distance of the lit point, of which a light that sends photons knows nothing yet.
  const auto fading = [](float strength) {
    GraphBuilder b;
    const int falloff = b.node("ShaderNodeLightFalloff",
                               {value_input("Strength", strength), value_input("Smooth", 0.0f)});
    b.graph.surface = {
        b.node("ShaderNodeEmission", {value_input("Color", Vec4(1.0f)), linked_input("Strength", falloff, "Linear")}),
        "Emission"};
    return b;
  };
  add("fading_lamp", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
    d.lights.back().graph = fading(1.0f).graph;
  });
  add("fading_mesh", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    add_object(d, plane(0.3f), add_material(d, fading(5.0f)), moved(Vec3(-0.3f, 0.2f, 0.9f), 1.0f));
  });
  add("lamp_without_shadow", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(point_light(Vec3(0.1f, 0.1f, 0.8f), 20.0f));
    d.lights.back().cast_shadow = false;
  });
  add("hidden_from_camera", [&](SceneDescription& d) {
    add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.objects.back().visibility = kVisibleAll & ~kVisibleCamera;
    d.lights.push_back(lamp);
  });
  // Walks from lights do not see it.
  add("object_hidden_from_diffuse", [&](SceneDescription& d) {
    add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.objects.back().visibility = kVisibleAll & ~(kVisibleDiffuse | kVisibleShadow);
    d.lights.push_back(lamp);
  });
  // Shadow rays pass the card, and the wall behind it is lit. The card is lit too, and lights the wall.
  add("card_without_shadow", [&](SceneDescription& d) {
    add_object(d, plane(0.35f), add_diffuse(d, Color(0.9f, 0.3f, 0.2f)), moved(Vec3(0.1f, 0.1f, 0.2f)));
    d.objects.back().visibility = kVisibleAll & ~kVisibleShadow;
    d.lights.push_back(lamp);
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 2.0f));
  });
  // Mirrors and shadow rays see it, diffuse rays do not.
  add("shadow_of_the_unseen", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.objects.back().visibility = kVisibleAll & ~kVisibleDiffuse;
    add_object(d, cube(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.0f), moved(Vec3(-0.5f, 0.4f, -0.7f), 0.25f));
    d.lights.push_back(lamp);
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 2.0f));
  });
  add("hidden_from_glossy", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glossy(d, 0.3f), ball);
    add_object(d, cube(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.4f), moved(Vec3(-0.5f, 0.4f, -0.7f), 0.25f));
    d.lights.push_back(lamp);
    d.lights.back().visibility = kVisibleAll & ~kVisibleGlossy;
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 2.0f));
  });
  add("hidden_from_diffuse", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glossy(d, 0.0f), ball);
    add_object(d, cube(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.4f), moved(Vec3(-0.5f, 0.4f, -0.7f), 0.25f));
    add_object(d, plane(0.2f), add_diffuse(d, Color(0.0f), Color(5.0f)),
               shining(Vec3(0.5f, 0.5f, 0.5f), Vec3(0, -1, -1)));
    d.objects.back().visibility = kVisibleAll & ~kVisibleDiffuse;
    d.lights.push_back(lamp);
    d.lights.back().visibility = kVisibleAll & ~kVisibleDiffuse;
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 2.0f));
  });
  add("linked_lights", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glossy(d, 0.3f), ball);
    d.objects.back().receiver_set = 1;
    add_object(d, cube(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.0f), moved(Vec3(-0.5f, 0.4f, -0.7f), 0.25f));
    d.objects.back().receiver_set = 2;
    add_object(d, plane(0.2f), add_diffuse(d, Color(0.0f), Color(5.0f)),
               shining(Vec3(0.5f, 0.5f, 0.5f), Vec3(0, -1, -1)));
    d.objects.back().links.receivers = 0b110;
    d.lights.push_back(lamp);
    d.lights.back().links.receivers = 0b101;
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 2.0f));
    d.lights.back().links.receivers = 0b010;
  });
  add("linked_blockers", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    add_object(d, plane(0.2f), add_diffuse(d, Color(0.3f, 0.6f, 0.2f)), moved(Vec3(0.1f, 0.1f, 0.05f), 1.0f));
    d.objects.back().blocker_set = 1;
    add_object(d, plane(0.3f), add_half_diffuse(d, "ShaderNodeBsdfTransparent", 0.0f),
               moved(Vec3(-0.1f, 0.1f, -0.35f), 1.0f));
    d.objects.back().blocker_set = 2;
    add_object(d, plane(0.2f), add_diffuse(d, Color(0.0f), Color(5.0f)),
               shining(Vec3(0.5f, 0.5f, 0.5f), Vec3(0, -1, -1)));
    d.objects.back().blocker_set = 1;
    d.objects.back().links.blockers = 0b101;
    d.lights.push_back(lamp);
    d.lights.back().links.blockers = 0b011;
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 2.0f));
    d.lights.back().links = {0b1, 0b100};
  });
  const auto panorama = [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
    d.camera.kind = CameraKind::Panorama;
    d.camera.panorama.kind = PanoramaKind::Equirectangular;
    d.camera.screen_window = Vec4(0, 1, 0, 1);
  };
  add("full_panorama", panorama);
  add("panorama_with_lens", [&](SceneDescription& d) {
    panorama(d);
    d.camera.aperture_radius = 0.05f;
    d.camera.focus_distance = 1.0f;
  });
  add("soft_lamp_with_a_shade", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), moved(Vec3(0.3f, 0.3f, -0.5f), 0.3f));
    add_object(d, plane(0.2f), add_diffuse(d, Color(0.3f, 0.6f, 0.2f)), moved(Vec3(0.1f, 0.1f, 0.05f), 1.0f));
    add_object(d, plane(0.3f), add_half_diffuse(d, "ShaderNodeBsdfTransparent", 0.0f),
               moved(Vec3(-0.1f, 0.1f, -0.35f), 1.0f));
    d.lights.push_back(point_light(Vec3(0.1f, 0.1f, 0.2f), 8.0f, 0.4f));
    d.lights.back().soft_falloff = true;
  });
  add("negative_lamp", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
    d.lights.push_back(area_lamp(Vec3(0.6f, 0.3f, 0.5f), Vec3(-1, 0, -0.5f), 0.3f, -0.7f));
  });
  const auto foggy = [&](SceneDescription& d, int medium, const Mat4& where) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    add_object(d, textured_cube(), medium, where);
    d.lights.push_back(lamp);
    d.settings.bounces.volume = 6;
  };
  const Mat4 all = moved(Vec3(0.0f), 0.98f), aside = moved(Vec3(-0.4f, 0.3f, 0.1f), 0.4f);
  add("fog_around_the_camera", [&](SceneDescription& d) {
    foggy(d, add_medium(d, "ShaderNodeVolumeScatter", Color(0.9f, 0.7f, 0.4f), Vec2(0.5f)), all);
  });
  add("linked_fog", [&](SceneDescription& d) {
    foggy(d, add_medium(d, "ShaderNodeVolumeScatter", Color(0.9f, 0.7f, 0.4f), Vec2(0.8f)), aside);
    d.objects.back().receiver_set = 1;
    d.lights.back().links.receivers = 0b01;
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 6.0f, 0.1f));
    d.lights.back().links.receivers = 0b10;
  });
  add("forward_scattering_fog", [&](SceneDescription& d) {
    foggy(d, add_medium(d, "ShaderNodeVolumeScatter", Color(0.9f), Vec2(1.5f), 0.6f), aside);
    d.settings.bounces.volume = 0;
  });
  add("uneven_smoke", [&](SceneDescription& d) {
    foggy(d, add_medium(d, "ShaderNodeVolumeScatter", Color(0.8f, 0.9f, 0.9f), Vec2(0.2f, 3.0f), 0.3f), aside);
  });
  add("smoke_without_shadow", [&](SceneDescription& d) {
    foggy(d, add_medium(d, "ShaderNodeVolumeScatter", Color(0.8f, 0.9f, 0.9f), Vec2(0.6f, 1.4f)), all);
    d.objects.back().visibility &= ~kVisibleShadow;
  });
  add("overlapping_volumes", [&](SceneDescription& d) {
    foggy(d, add_medium(d, "ShaderNodeVolumeScatter", Color(0.8f, 0.9f, 0.9f), Vec2(0.4f)), all);
    add_object(d, textured_cube(), add_medium(d, "ShaderNodeVolumeAbsorption", Color(0.3f, 0.5f, 0.9f), Vec2(2.0f)),
               aside);
  });
  add("volume_of_the_world", [&](SceneDescription& d) {
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 6.0f, 0.1f));
    GraphBuilder b;
    b.graph.volume = {
        b.node("ShaderNodeVolumeScatter", {value_input("Color", Vec4(0.9f)), value_input("Density", 0.4f)}), "Volume"};
    d.world.graph = b.graph;
    d.settings.bounces.volume = 4;
  });
  add("volume_in_glass", [&](SceneDescription& d) {
    GraphBuilder b;
    b.graph.surface = {
        b.node("ShaderNodeBsdfGlass",
               {value_input("Color", Vec4(1.0f)), value_input("Roughness", 0.3f), value_input("IOR", 1.2f)},
               {text_property("distribution", "GGX")}),
        "BSDF"};
    b.graph.volume = {b.node("ShaderNodeVolumeScatter",
                             {value_input("Color", Vec4(0.9f, 0.6f, 0.3f, 1.0f)), value_input("Density", 1.5f)}),
                      "Volume"};
    add_object(d, sphere(), add_material(d, b), ball);
    d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 1.5f, 8.0f));
    d.settings.bounces.volume = 4;
  });
  add("glowing_volume", [&](SceneDescription& d) {
    GraphBuilder b;
    const int scatters = b.node("ShaderNodeVolumeScatter",
                                {value_input("Color", Vec4(0.8f)), value_input("Density", 1.0f)});
    const int emits = b.node("ShaderNodeEmission",
                             {value_input("Color", Vec4(1.0f, 0.6f, 0.3f, 1.0f)), value_input("Strength", 1.5f)});
    b.graph.volume = {b.node("ShaderNodeAddShader", {linked_input("Shader", scatters, "Volume"),
                                                     linked_input("Shader_001", emits, "Emission")}),
                      "Shader"};
    foggy(d, add_material(d, b), aside);
  });
  return scenes;
}

/// A material with subsurface scattering. In Blender 5, light enters `after_diffuse` bounces as well.
inline int add_skin(SceneDescription& d, bool after_diffuse, const char* method = "RANDOM_WALK") {
  GraphBuilder b;
  b.graph.surface = {b.node("ShaderNodeSubsurfaceScattering",
                            {value_input("Color", Vec4(0.8f, 0.5f, 0.4f, 1.0f)), value_input("Scale", 0.1f),
                             value_input("Radius", Vec4(1.0f, 0.4f, 0.2f, 0.0f))},
                            {text_property("falloff", method),
                             number_property("enters_after_diffuse", {after_diffuse ? 1.0f : 0.0f})}),
                     "BSSRDF"};
  return add_material(d, b);
}
/// The same of a Principled BSDF of the first or second generation, with reflection above it.
inline int add_principled_skin(SceneDescription& d, bool second) {
  GraphBuilder b;
  const NodeInput color = value_input("Base Color", Vec4(0.8f, 0.5f, 0.4f, 1.0f)),
                  radius = value_input("Subsurface Radius", Vec4(0.1f, 0.04f, 0.02f, 0.0f));
  const NodeProperty rule = number_property("enters_after_diffuse", {second ? 1.0f : 0.0f});
  const int node = second ? b.node("ShaderNodeBsdfPrincipled",
                                   {color, radius, value_input("Subsurface Weight", 0.8f),
                                    value_input("Subsurface Scale", 1.0f), value_input("Roughness", 0.4f),
                                    value_input("Coat Weight", 0.5f), value_input("Coat Roughness", 0.3f)},
                                   {rule})
                          : b.node("ShaderNodeBsdfPrincipled",
                                   {color, radius, value_input("Subsurface", 0.8f),
                                    value_input("Subsurface Color", Vec4(0.8f, 0.4f, 0.3f, 1.0f)),
                                    value_input("Roughness", 0.4f), value_input("Specular", 0.8f)},
                                   {rule});
  b.graph.surface = {node, "BSDF"};
  return add_material(d, b);
}
/// A ball with subsurface scattering in the room of the other scenes.
inline TransportScene subsurface_scene() {
  SceneDescription d = grey_room();
  add_object(d, sphere(), add_skin(d, false), moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f));
  d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
  return {"skin", std::move(d)};
}
/// Rooms whose floor and one wall, or whose ball, have subsurface scattering, so that much light passes between such
/// surfaces, and between them and the other walls.
inline std::vector<TransportScene> subsurface_scenes() {
  std::vector<TransportScene> scenes;
  const auto add = [&](const char* name, const std::function<int(SceneDescription&)>& material,
                       const std::function<void(SceneDescription&)>& more = {}) {
    SceneDescription d = grey_room(9);
    const int skin = material(d);
    add_object(d, cube(), skin, moved(Vec3(0.0f, 0.0f, -1.9f), 1.0f));
    add_object(d, cube(), skin, moved(Vec3(-1.8f, 0.0f, 0.0f), 1.0f));
    add_object(d, sphere(), skin, moved(Vec3(0.2f, 0.3f, -0.5f), 0.4f));
    d.lights.push_back(area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f));
    if (more) more(d);
    scenes.push_back({name, std::move(d)});
  };
  add("skin_all_around", [](SceneDescription& d) { return add_skin(d, false); });
  add("skin_after_diffuse", [](SceneDescription& d) { return add_skin(d, true); });
  add("principled_skin", [](SceneDescription& d) { return add_principled_skin(d, false); });
  add("principled_skin_after_diffuse", [](SceneDescription& d) { return add_principled_skin(d, true); });
  add(
      "skin_with_limits", [](SceneDescription& d) { return add_principled_skin(d, false); },
      [](SceneDescription& d) { d.settings.bounces = {4, 1, 1, 2, 8, 0}; });
  add(
      "skin_beside_glass_and_mirror", [](SceneDescription& d) { return add_principled_skin(d, false); },
      [](SceneDescription& d) {
        add_object(d, sphere(), add_glass(d, 0.0f), moved(Vec3(-0.3f, -0.1f, -0.5f), 0.25f));
        add_object(d, sphere(), add_glossy(d, 0.0f), moved(Vec3(0.6f, -0.1f, -0.6f), 0.25f));
      });
  return scenes;
}

}  // namespace ajar::fixtures
