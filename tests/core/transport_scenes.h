// Small scenes on which all transport algorithms must agree, one for each type of light, surface and camera.
#pragma once

#include <functional>

#include "graph_fixtures.h"
#include "scene_fixtures.h"

namespace ajar::fixtures {

inline int add_material(SceneDescription& d, const GraphBuilder& builder) {
  MaterialDescription material;
  material.name = "Material " + std::to_string(d.materials.size());
  material.graph = builder.graph;
  d.materials.push_back(material);
  return int(d.materials.size()) - 1;
}

inline int add_closure(SceneDescription& d, const std::string& type, std::initializer_list<NodeInput> inputs,
                       std::initializer_list<NodeProperty> properties = {}) {
  GraphBuilder b;
  b.graph.surface = {b.node(type, inputs, properties), "BSDF"};
  return add_material(d, b);
}

inline int add_glass(SceneDescription& d, float roughness, float ior = 1.45f) {
  return add_closure(d, "ShaderNodeBsdfGlass",
                     {value_input("Color", Vec4(0.95f, 0.9f, 1.0f, 1.0f)), value_input("Roughness", roughness),
                      value_input("IOR", ior)},
                     {text_property("distribution", "GGX")});
}
inline int add_glossy(SceneDescription& d, float roughness, Color color = Color(0.8f, 0.7f, 0.6f)) {
  return add_closure(d, "ShaderNodeBsdfGlossy",
                     {value_input("Color", Vec4(color, 1.0f)), value_input("Roughness", roughness)},
                     {text_property("distribution", "GGX")});
}
/// An equal mix of a diffuse closure and a closure of this type.
inline int add_half_diffuse(SceneDescription& d, const std::string& type, float roughness) {
  GraphBuilder b;
  const int diffuse = b.node("ShaderNodeBsdfDiffuse",
                             {value_input("Color", Vec4(0.7f, 0.3f, 0.3f, 1.0f)), value_input("Roughness", 0.0f)});
  const int other = b.node(type, {value_input("Color", Vec4(0.8f)), value_input("Roughness", roughness)});
  b.graph.surface = {b.node("ShaderNodeMixShader", {value_input("Fac", 0.5f), linked_input("Shader", diffuse, "BSDF"),
                                                    linked_input("Shader_001", other, "BSDF")}),
                     "Shader"};
  return add_material(d, b);
}

inline Mat4 moved(Vec3 position, float scale = 1.0f) {
  return Mat4(Vec4(scale, 0, 0, 0), Vec4(0, scale, 0, 0), Vec4(0, 0, scale, 0), Vec4(position, 1));
}
/// The transform of a lamp: its local -z axis points along `direction`.
inline Mat4 shining(Vec3 position, Vec3 direction) {
  const Frame frame(-glm::normalize(direction));
  return Mat4(Vec4(frame.s, 0), Vec4(frame.t, 0), Vec4(frame.n, 0), Vec4(position, 1));
}

/// A room [-1, 1]^3 of grey walls seen from inside, without light.
inline SceneDescription grey_room(int size = 12) {
  SceneDescription d;
  add_object(d, cube(true), add_diffuse(d, Color(0.6f, 0.5f, 0.7f)));
  set_camera(d, Vec3(0.1f, -0.9f, 0.1f), Vec3(0.0f, 0.5f, -0.25f), size, 0.7f);
  d.settings.bounces = {16, 16, 16, 16, 16, 0};
  return d;
}
inline LightDescription area_lamp(Vec3 position, Vec3 direction, float size, float watts) {
  LightDescription light;
  light.name = "Area";
  light.kind = LightKind::Area;
  light.energy = watts;
  light.area_size = Vec2(size);
  light.world_from_light = rows(shining(position, direction));
  return light;
}

/// A room that is lit by a lamp in a box with a small opening.
inline SceneDescription hidden_lamp() {
  SceneDescription d = grey_room(200);
  add_object(d, cube(true), 0, moved(Vec3(0.7f, 0.7f, 0.7f), 0.28f));
  d.instances.back().world_from_object[10] = 0.2799f;  // a box around the lamp ...
  d.lights.push_back(area_lamp(Vec3(0.7f, 0.7f, 0.75f), Vec3(0, 0, 1), 0.05f, 50.0f));
  MeshDescription& box = d.meshes[size_t(d.objects.back().mesh)];
  box.triangles.resize(box.triangles.size() - 1);  // ... without one triangle
  return d;
}

struct TransportScene {
  std::string name;
  SceneDescription description;
};

inline std::vector<TransportScene> transport_scenes() {
  std::vector<TransportScene> scenes;
  const auto add = [&](const char* name, const std::function<void(SceneDescription&)>& fill) {
    SceneDescription d = grey_room();
    fill(d);
    scenes.push_back({name, std::move(d)});
  };
  /// The same with an open floor instead of the room.
  const auto add_open = [&](const char* name, const std::function<void(SceneDescription&)>& fill) {
    SceneDescription d;
    add_object(d, plane(3.0f), add_diffuse(d, Color(0.6f, 0.5f, 0.7f)), moved(Vec3(0, 0, -0.5f)));
    set_camera(d, Vec3(0.1f, -3.0f, 1.2f), Vec3(0.0f, 0.0f, -0.25f), 12, 0.5f);
    d.settings.bounces = {16, 16, 16, 16, 16, 0};
    fill(d);
    scenes.push_back({name, std::move(d)});
  };
  const Mat4 ball = moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f);
  const LightDescription lamp = area_lamp(Vec3(0.1f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.5f, 8.0f);

  add("area_lamp", [&](SceneDescription& d) {
    add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
  });
  add("glass_ball", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glass(d, 0.0f), ball);
    d.lights.push_back(area_lamp(Vec3(0.3f, 0.1f, 0.95f), Vec3(0, 0, -1), 0.6f, 8.0f));
  });
  add("rough_glass_and_mirror", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glass(d, 0.4f), ball);
    add_object(d, sphere(), add_glossy(d, 0.0f), moved(Vec3(-0.4f, 0.5f, -0.5f), 0.3f));
    d.lights.push_back(lamp);
  });
  add("glossy", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glossy(d, 0.3f), ball);
    add_object(d, cube(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.4f), moved(Vec3(-0.5f, 0.4f, -0.7f), 0.25f));
    d.lights.push_back(lamp);
  });
  add("polished", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glossy(d, 0.15f), ball);
    add_object(d, cube(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.2f), moved(Vec3(-0.5f, 0.4f, -0.7f), 0.25f));
    d.lights.push_back(lamp);
  });
  add("point_light", [&](SceneDescription& d) {
    add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.6f), 8.0f));
  });
  add("sphere_and_spot", [&](SceneDescription& d) {
    add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(point_light(Vec3(-0.3f, 0.2f, 0.5f), 6.0f, 0.15f));
    LightDescription spot = point_light(Vec3(0), 20.0f, 0.05f);
    spot.kind = LightKind::Spot;
    spot.spot_angle = 1.0f;
    spot.world_from_light = rows(shining(Vec3(0.7f, -0.5f, 0.7f), Vec3(-0.6f, 0.8f, -1)));
    d.lights.push_back(spot);
    spot.radius = 0.0f;
    spot.world_from_light = rows(shining(Vec3(-0.7f, -0.5f, 0.7f), Vec3(0.6f, 0.8f, -1)));
    d.lights.push_back(spot);
  });
  add_open("sun", [&](SceneDescription& d) {
    add_object(d, sphere(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.3f), ball);
    LightDescription sun;
    sun.name = "Sun";
    sun.kind = LightKind::Sun;
    sun.energy = 2.0f;
    sun.world_from_light = rows(shining(Vec3(0), Vec3(0.5f, 0.5f, -1)));
    d.lights.push_back(sun);
    sun.sun_angle = 0.3f;
    sun.world_from_light = rows(shining(Vec3(0), Vec3(-0.5f, 0.5f, -1)));
    d.lights.push_back(sun);
  });
  add_open("environment", [&](SceneDescription& d) {
    add_object(d, sphere(), add_glass(d, 0.0f), ball);
    GraphBuilder b;
    const int position = b.node("ShaderNodeTexCoord");
    const int background = b.node("ShaderNodeBackground",
                                  {linked_input("Color", position, "Generated"), value_input("Strength", 1.0f)});
    b.graph.surface = {background, "Background"};
    d.world.graph = b.graph;
  });
  add("thin_lens", [&](SceneDescription& d) {
    add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
    d.camera.aperture_radius = 0.1f;
    d.camera.focus_distance = 1.0f;
    d.camera.blades = 5;
    d.camera.aperture_ratio = 2.0f;
  });
  add("orthographic", [&](SceneDescription& d) {
    add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
    d.camera.kind = CameraKind::Orthographic;
    d.camera.screen_window = Vec4(-0.4f, 0.4f, -0.4f, 0.4f);
  });
  add("fisheye", [&](SceneDescription& d) {
    add_object(d, sphere(), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), ball);
    d.lights.push_back(lamp);
    d.camera.kind = CameraKind::Panorama;
    d.camera.panorama.kind = PanoramaKind::FisheyeEquidistant;
    d.camera.panorama.fisheye_fov = 3.5f;
    d.camera.screen_window = Vec4(0, 1, 0, 1);
  });
  add("textured_emission", [&](SceneDescription& d) {
    GraphBuilder b;
    const int geometry = b.node("ShaderNodeTexCoord");
    const int emission = b.node("ShaderNodeEmission",
                                {linked_input("Color", geometry, "Generated"), value_input("Strength", 3.0f)});
    b.graph.surface = {emission, "Emission"};
    add_object(d, cube(), add_material(d, b), moved(Vec3(0.3f, 0.3f, 0.3f), 0.15f));
    add_object(d, sphere(8), add_diffuse(d, Color(0.8f, 0.4f, 0.2f)), moved(Vec3(-0.3f, 0.3f, -0.4f), 0.4f));
  });
  add("see_through", [&](SceneDescription& d) {
    add_object(d, plane(0.6f), add_half_diffuse(d, "ShaderNodeBsdfTransparent", 0.0f), moved(Vec3(0, 0.2f, 0.3f)));
    add_object(d, plane(0.5f),
               add_closure(d, "ShaderNodeBsdfTransparent", {value_input("Color", Vec4(0.9f, 0.5f, 0.5f, 1.0f))}),
               shining(Vec3(0, -0.2f, -0.3f), Vec3(0, 1, 0.2f)));
    add_object(d, sphere(),
               add_closure(d, "ShaderNodeBsdfTranslucent", {value_input("Color", Vec4(0.7f, 0.9f, 0.5f, 1.0f))}), ball);
    d.lights.push_back(lamp);
  });
  add("bounce_limits", [&](SceneDescription& d) {
    add_object(d, sphere(), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.4f), ball);
    add_object(d, cube(), add_glossy(d, 0.3f), moved(Vec3(-0.5f, 0.4f, -0.7f), 0.25f));
    d.lights.push_back(lamp);
    d.settings.bounces = {4, 1, 1, 2, 8, 0};
  });
  add("translucent_limits", [&](SceneDescription& d) {
    const int leaf = add_closure(d, "ShaderNodeBsdfTranslucent", {value_input("Color", Vec4(0.7f, 0.9f, 0.5f, 1.0f))});
    add_object(d, sphere(), leaf, ball);
    for (const float x : {-0.6f, 0.6f})
      add_object(d, plane(0.4f), leaf, shining(Vec3(x, 0.1f, 0.1f), Vec3(-x, 0.3f, 0)));
    d.lights.push_back(lamp);
    d.settings.bounces = {6, 1, 1, 3, 8, 0};
  });
  add("view_dependent", [&](SceneDescription& d) {
    GraphBuilder b;
    const int weight = b.node("ShaderNodeLayerWeight", {value_input("Blend", 0.5f)});
    const int diffuse = b.node("ShaderNodeBsdfDiffuse",
                               {value_input("Color", Vec4(0.1f, 0.7f, 0.3f, 1.0f)), value_input("Roughness", 0.0f)});
    const int glossy = b.node("ShaderNodeBsdfGlossy",
                              {value_input("Color", Vec4(0.9f)), value_input("Roughness", 0.3f)});
    b.graph.surface = {
        b.node("ShaderNodeMixShader", {linked_input("Fac", weight, "Facing"), linked_input("Shader", diffuse, "BSDF"),
                                       linked_input("Shader_001", glossy, "BSDF")}),
        "Shader"};
    add_object(d, sphere(8), add_material(d, b), ball);
    d.lights.push_back(lamp);
  });
  return scenes;
}

}  // namespace ajar::fixtures
