// Input nodes: values, geometry, coordinates, attributes, properties of the object and of the ray.
#include <algorithm>

#include "geometry/mesh_analysis.h"
#include "shading/functions/math_functions.h"
#include "shading/functions/point_functions.h"
#include "shading/nodes/node_type.h"

namespace ajar::nodes {
namespace {

using enum SocketType;

Value camera_point(ProgramBuilder& b, int node) {
  const CameraDescription* camera = b.camera();
  if (!camera) {
    b.report(node, "there is no camera; world coordinates are used");
    return b.emit(Op::Position, Vector, {});
  }
  const uint32_t matrix = b.add_matrix(glm::affineInverse(to_matrix(camera->world_from_camera)));
  return b.emit(Op::CameraPosition, Vector, {}, 0, matrix);
}

Value window_point(ProgramBuilder& b, int node) {
  const CameraDescription* camera = b.camera();
  if (!camera || camera->kind == CameraKind::Panorama) {
    b.report(node, "window coordinates need a perspective or orthographic camera");
    return b.constant(Vec3(0.0f), Vector);
  }
  const uint32_t matrix = b.add_matrix(glm::affineInverse(to_matrix(camera->world_from_camera)));
  Mat4 screen(0.0f);  // first column: the window; second column: 1 for a perspective camera, else 0
  screen[0] = camera->screen_window;
  screen[1][0] = camera->kind == CameraKind::Perspective ? 1.0f : 0.0f;
  return b.emit(Op::WindowPosition, Vector, {}, 0, matrix << 16 | b.add_matrix(screen));
}

bool value_node(ProgramBuilder& b, int node, std::string_view, Value& value) {
  value = b.constant(b.number(node, "value"));
  return true;
}

bool rgb_node(ProgramBuilder& b, int node, std::string_view, Value& value) {
  const std::vector<float>* rgb = b.numbers(node, "value");
  value = b.constant(rgb && rgb->size() >= 3 ? Vec3((*rgb)[0], (*rgb)[1], (*rgb)[2]) : Vec3(0.5f), Color);
  return true;
}

Value from_instancer(ProgramBuilder& b, InstancerValue which) {
  return b.emit(Op::FromInstancer, Vector, {}, int(which));
}

bool texture_coordinate(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const bool of_instancer = b.number(node, "from_instancer") != 0.0f;
  if (of_instancer && (output == "Generated" || output == "UV"))
    value = from_instancer(b, output == "UV" ? InstancerValue::Uv : InstancerValue::Generated);
  else if (output == "Generated")
    value = b.coordinates(Op::Generated);
  else if (output == "Normal")
    value = b.object_normal();
  else if (output == "UV")
    value = b.coordinates(Op::ActiveUv);
  else if (output == "Camera")
    value = camera_point(b, node);
  else if (output == "Window")
    value = window_point(b, node);
  else if (output == "Reflection")
    value = b.emit(Op::Reflection, Vector, {});
  else if (output == "Object") {
    const std::vector<float>* rows = b.numbers(node, "object");
    if (rows && rows->size() >= 12) {
      std::array<float, 12> matrix;
      std::copy_n(rows->begin(), 12, matrix.begin());
      value = b.emit(Op::TransformPosition, Vector, {}, 0, b.add_matrix(to_matrix(matrix)));
    } else {
      value = b.coordinates(Op::ObjectPosition);
    }
  } else
    return false;
  return true;
}

bool uv_map(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const std::string_view name = b.text(node, "uv_map");
  if (b.number(node, "from_instancer") != 0.0f)
    value = from_instancer(b, InstancerValue::Uv);
  else
    value = name.empty() ? b.coordinates(Op::ActiveUv) : b.emit(Op::NamedUv, Vector, {}, 0, b.add_name(name));
  return output == "UV";
}

/// Attributes that Cycles makes itself, as vectors. They hide those of the geometry with the same name.
bool made_attribute(ProgramBuilder& b, std::string_view name, Value& value) {
  const auto number = [&](Value found) { value = b.convert(found, Vector); };
  if (name == "generated")
    value = b.coordinates(Op::Generated);
  else if (name == "uv")
    value = b.coordinates(Op::ActiveUv);
  else if (name == "pointiness")
    number(b.part(b.emit(Op::NamedAttribute, Color, {}, 1, b.add_name(kPointiness)), 0));
  else if (name == "random_per_island")
    number(b.part(b.emit(Op::NamedAttribute, Color, {}, 1, b.add_name(kRandomPerIsland)), 0));
  else if (name == "curve_intercept")
    number(b.emit(Op::HairInfo, Float, {}, int(HairOutput::Intercept)));
  else if (name == "curve_length")
    number(b.emit(Op::HairInfo, Float, {}, int(HairOutput::Length)));
  else if (name == "curve_random")
    number(b.emit(Op::HairInfo, Float, {}, int(HairOutput::Random)));
  else if (name == "point_random")
    number(b.part(b.emit(Op::PointInfo, Vector, {}, int(PointOutput::Random)), 0));
  else
    return false;
  return true;
}

/// An attribute of the geometry. As in Cycles, surfaces, hair and points have none with the name of a grid.
Value named_attribute(ProgramBuilder& b, int node, const std::string& name, int alpha) {
  static constexpr std::string_view kGrids[] = {"density",  "color",      "flame",      "heat",      "temperature",
                                                "velocity", "velocity_x", "velocity_y", "velocity_z"};
  const bool of_volumes = std::ranges::find(kGrids, name) != std::end(kGrids);
  if (of_volumes && !b.context().has_grid(name))
    b.report(node,
             "'" + name + "' is the name of a grid of volumes, so other objects have no such attribute, as in Cycles");
  return b.emit(Op::NamedAttribute, Color, {}, alpha | (of_volumes ? kOfVolumesAlone : 0),
                b.add_name(name == "vertex_color" ? "" : name));
}

bool attribute_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  enum { Geometry, Object, Instancer, ViewLayer };
  const int type = b.choice(node, "attribute_type", {"GEOMETRY", "OBJECT", "INSTANCER", "VIEW_LAYER"});
  if (type == ViewLayer) {  // the value is equal everywhere and was looked up by the exporter
    const std::vector<float>* found = b.numbers(node, "value");
    const Vec4 v = found && found->size() >= 4 ? Vec4((*found)[0], (*found)[1], (*found)[2], (*found)[3]) : Vec4(0.0f);
    value = output == "Alpha" ? b.constant(v.w) : b.constant(Vec3(v), output == "Color" ? Color : Vector);
    if (output == "Fac") value = b.convert(value, Float);
    return output == "Color" || output == "Vector" || output == "Fac" || output == "Alpha";
  }
  const std::string name(b.text(node, "attribute_name"));
  Value whole;
  const bool is_made = type == Geometry && made_attribute(b, name, whole);
  if (!is_made)
    whole = type == Geometry ? named_attribute(b, node, name, 1)
                             : b.emit(Op::ObjectProperty, Color, {}, type == Instancer, b.add_name(name));
  if (output == "Color")
    value = {Color, whole.at};
  else if (output == "Vector")
    value = {Vector, whole.at};
  else if (output == "Fac")
    value = b.convert({Vector, whole.at}, Float);
  else if (output == "Alpha")
    value = is_made ? b.constant(1.0f) : b.part(whole, 3);
  else
    return false;
  return true;
}

bool vertex_color(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value whole = named_attribute(b, node, std::string(b.text(node, "layer_name")), 0);
  value = output == "Alpha" ? b.part(whole, 3) : whole;
  return output == "Color" || output == "Alpha";
}

bool geometry(ProgramBuilder& b, int, std::string_view output, Value& value) {
  if (output == "Position")
    value = b.emit(Op::Position, Vector, {});
  else if (output == "Normal")
    value = b.surface_normal();
  else if (output == "Tangent")
    value = b.emit(Op::RadialTangent, Vector, {}, int(Axis::Z));
  else if (output == "True Normal")
    value = b.emit(Op::TrueNormal, Vector, {});
  else if (output == "Incoming")
    value = b.emit(Op::Incoming, Vector, {});
  else if (output == "Parametric")
    value = b.coordinates(Op::Parametric);
  else if (output == "Backfacing")
    value = b.emit(Op::Backfacing, Float, {});
  else if (output == "Pointiness")
    value = b.part(b.emit(Op::NamedAttribute, Color, {}, 1, b.add_name(kPointiness)), 0);
  else if (output == "Random Per Island")
    value = b.part(b.emit(Op::NamedAttribute, Color, {}, 1, b.add_name(kRandomPerIsland)), 0);
  else
    return false;
  return true;
}

bool object_info(ProgramBuilder& b, int, std::string_view output, Value& value) {
  if (output == "Location")
    value = b.emit(Op::ObjectLocation, Vector, {});
  else if (output == "Color")
    value = b.emit(Op::ObjectColor, Color, {});
  else if (output == "Alpha")
    value = b.part(b.emit(Op::ObjectColor, Color, {}), 3);
  else if (output == "Object Index")
    value = b.emit(Op::ObjectIndex, Float, {});
  else if (output == "Material Index")
    value = b.constant(float(b.context().material_pass_index));
  else if (output == "Random")
    value = b.emit(Op::ObjectRandom, Float, {});
  else
    return false;
  return true;
}

bool light_path_node(ProgramBuilder& b, int, std::string_view output, Value& value) {
  static constexpr std::string_view kOutputs[] = {
      "Is Camera Ray",     "Is Shadow Ray",       "Is Diffuse Ray",        "Is Glossy Ray",      "Is Singular Ray",
      "Is Reflection Ray", "Is Transmission Ray", "Is Volume Scatter Ray", "Ray Length",         "Ray Depth",
      "Diffuse Depth",     "Glossy Depth",        "Transparent Depth",     "Transmission Depth", "Portal Depth"};
  for (int i = 0; i < int(std::size(kOutputs)); ++i) {
    if (output != kOutputs[i]) continue;
    value = b.emit(Op::LightPath, Float, {}, i);
    return true;
  }
  return false;
}

bool light_falloff(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int power = output == "Quadratic" ? 0 : output == "Linear" ? 1 : output == "Constant" ? 2 : -1;
  if (power < 0) return false;
  value = b.emit(Op::LightFalloff, Float,
                 {b.input(node, "Strength", Float, Vec4(100.0f)), b.input(node, "Smooth", Float)},
                 power | (b.number(node, "suns_have_none") != 0.0f ? 4 : 0));
  return true;
}

bool camera_data(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value p = camera_point(b, node);
  if (output == "View Vector")
    value = b.emit(Op::Normalize, Vector, {p});
  else if (output == "View Z Depth")
    value = b.part(p, 2);
  else if (output == "View Distance") {
    const Value none = b.constant(Vec3(0.0f), Vector);
    value = b.emit(Op::VectorMathValue, Float, {p, none}, int(VectorOperation::Length));
  } else
    return false;
  return true;
}

Value normal_input(ProgramBuilder& b, int node) {
  return b.is_linked(node, "Normal") ? b.input(node, "Normal", Vector) : b.surface_normal();
}

Value own_or_world_distance(ProgramBuilder& b, int node) {
  const Value own = b.input(node, "Distance", Float, Vec4(1.0f));
  return b.constant_value(own) != 0.0f ? own : b.constant(b.number(node, "world_distance"));
}

bool fresnel_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.emit(Op::Fresnel, Float, {b.input(node, "IOR", Float, Vec4(1.5f)), normal_input(b, node)});
  return output == "Fac";
}

bool layer_weight(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.emit(Op::LayerWeight, Float, {b.input(node, "Blend", Float, Vec4(0.5f)), normal_input(b, node)},
                 output == "Fresnel" ? 0 : 1);
  return output == "Fresnel" || output == "Facing";
}

bool ambient_occlusion(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  constexpr int kMaxSamples = 128;
  // If the node has no distance, the distance of the world is used.
  const Value distance = b.is_linked(node, "Distance") ? b.input(node, "Distance", Float)
                                                       : own_or_world_distance(b, node);
  const int samples = std::clamp(int(b.number(node, "samples", 16.0f)), 0, kMaxSamples);
  const int variant = (b.number(node, "inside") != 0.0f ? 1 : 0) | (b.number(node, "only_local") != 0.0f ? 2 : 0);
  value = b.emit(Op::AmbientOcclusion, Float, {normal_input(b, node), distance}, variant, uint32_t(samples));
  if (output == "Color") value = b.emit(Op::Scale, Color, {b.input(node, "Color", Color, Vec4(1.0f)), value});
  return output == "AO" || output == "Color";
}

/// A linked normal gets the difference that the bevel makes to the normal of the surface.
bool bevel_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  constexpr int kMaxSamples = 128;
  const int samples = std::clamp(int(b.number(node, "samples", 4.0f)), 0, kMaxSamples);
  value = b.emit(Op::Bevel, Vector, {b.input(node, "Radius", Float, Vec4(0.05f))}, 0, uint32_t(samples));
  if (b.is_linked(node, "Normal")) {
    const auto combine = [&](VectorOperation operation, Value x, Value y) {
      return b.emit(Op::VectorMath, Vector, {x, y, b.constant(Vec3(0.0f), Vector), b.constant(1.0f)}, int(operation));
    };
    const Value change = combine(VectorOperation::Subtract, value, b.surface_normal());
    value = combine(VectorOperation::Add, b.input(node, "Normal", Vector), change);
    value = b.emit(Op::Normalize, Vector, {value});
  }
  return output == "Normal";
}

/// Output of Raycast: "Attribute_N" or "Attribute_N_Alpha", whose attribute is named by the input "Value_N".
constexpr std::string_view kAttributeAtHit = "Attribute_";

/// `which`: the rest of the name of the output. The exporter states the type of the socket.
bool raycast_attribute(ProgramBuilder& b, int node, std::string_view which, const std::array<Value, 3>& ray,
                       int only_local, Value& value) {
  const std::string_view number = which.substr(0, which.find('_'));
  const std::string_view name = b.text(node, "Value_" + std::string(number));
  const Value whole = b.emit(Op::RaycastAttribute, Color, {ray[0], ray[1], ray[2]}, only_local, b.add_name(name));
  const std::string_view type = b.text(node, "attribute_type_" + std::string(number));
  if (which != number)
    value = b.part(whole, 3);
  else if (type == "VALUE")
    value = b.convert({Vector, whole.at}, Float);
  else
    value = {type == "VECTOR" ? Vector : Color, whole.at};
  return true;
}

bool raycast_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value position = b.is_linked(node, "Position") ? b.input(node, "Position", Vector)
                                                       : b.emit(Op::Position, Vector, {});
  const Value direction = b.is_linked(node, "Direction") ? b.input(node, "Direction", Vector) : b.surface_normal();
  const Value length = b.input(node, "Length", Float, Vec4(1.0f));
  const int only_local = b.number(node, "only_local") != 0.0f;
  if (output.starts_with(kAttributeAtHit))
    return raycast_attribute(b, node, output.substr(kAttributeAtHit.size()), {position, direction, length}, only_local,
                             value);
  const Value hit = b.emit(Op::Raycast, Vector, {position, direction, length}, only_local);
  const Value found = b.part(hit, 0), distance = b.part(hit, 2);
  if (output == "Is Hit")
    value = found;
  else if (output == "Self Hit")
    value = b.part(hit, 1);
  else if (output == "Hit Distance")
    value = distance;
  else if (output == "Hit Normal")
    value = {Vector, component(hit.at, 3)};
  else if (output == "Hit Position") {
    const auto combine = [&](VectorOperation operation, Value x, Value y, Value scale) {
      return b.emit(Op::VectorMath, Vector, {x, y, b.constant(Vec3(0.0f), Vector), scale}, int(operation));
    };
    const Value way = combine(VectorOperation::Scale, direction, direction, distance);
    const Value place = combine(VectorOperation::Add, position, way, distance);
    value = combine(VectorOperation::Scale, place, place, found);
  } else {
    b.report(node, "its output '" + std::string(output) + "' is not supported yet; 0 is used");
    value = b.constant(Vec3(0.0f), Color);
  }
  return true;
}

bool tangent_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  if (b.choice(node, "direction_type", {"RADIAL", "UV_MAP"}) == 1)
    value = b.emit(Op::UvTangent, Vector, {}, 0, b.add_name(b.text(node, "uv_map")));
  else
    value = b.emit(Op::RadialTangent, Vector, {}, b.choice(node, "axis", {"X", "Y", "Z"}, 2));
  return output == "Tangent";
}

bool normal_map_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int space = b.choice(node, "space", {"TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"});
  Value color = b.input(node, "Color", Color, Vec4(0.5f, 0.5f, 1.0f, 1.0f));
  if (b.choice(node, "convention", {"OPENGL", "DIRECTX"}) == 1) {  // green points down, so it is replaced by 1 - green
    const Value green = b.emit(Op::ProductInverse, Float, {b.constant(1.0f), b.part(color, 1)});
    const Value turned = b.emit(Op::Combine, Vector, {b.part(color, 0), green, b.part(color, 2)});
    color = {Color, turned.at};
  }
  const int generation = b.choice(node, "generation", {"1", "2", "3"});
  value = b.emit(Op::NormalMap, Vector, {b.input(node, "Strength", Float, Vec4(1.0f)), color}, space | generation << 3,
                 b.add_name(b.text(node, "uv_map")));
  return output == "Normal";
}

bool wireframe(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const bool in_pixels = b.number(node, "use_pixel_size") != 0.0f;
  if (in_pixels) b.measure_pixels();
  value = b.emit(Op::Wireframe, Float, {b.input(node, "Size", Float, Vec4(0.01f))}, in_pixels);
  return output == "Fac";
}

bool hair_info_node(ProgramBuilder& b, int, std::string_view output, Value& value) {
  static constexpr std::string_view kOutputs[] = {"Is Strand", "Intercept", "Length", "Thickness",
                                                  "Random"};  // in the order of HairOutput
  if (output == "Tangent Normal") {
    value = b.emit(Op::HairTangentNormal, Vector, {});
    return true;
  }
  for (int i = 0; i < int(std::size(kOutputs)); ++i) {
    if (output != kOutputs[i]) continue;
    value = b.emit(Op::HairInfo, Float, {}, i);
    return true;
  }
  return false;
}

bool particle_info(ProgramBuilder& b, int, std::string_view output, Value& value) {
  constexpr struct {
    std::string_view output;
    InstancerValue value;
    bool is_vector = false;
  } kOutputs[] = {{"Index", InstancerValue::Index},
                  {"Random", InstancerValue::Random},
                  {"Age", InstancerValue::Age},
                  {"Lifetime", InstancerValue::Lifetime},
                  {"Location", InstancerValue::Location, true},
                  {"Size", InstancerValue::Size},
                  {"Velocity", InstancerValue::Velocity, true},
                  {"Angular Velocity", InstancerValue::AngularVelocity, true}};
  for (const auto& known : kOutputs) {
    if (output != known.output) continue;
    value = from_instancer(b, known.value);
    if (!known.is_vector) value = b.part(value, 0);
    return true;
  }
  return false;
}

/// The grids of a volume with fixed names. On surfaces they are zero.
bool volume_info(ProgramBuilder& b, int, std::string_view output, Value& value) {
  const std::string name = output == "Color"         ? "color"
                           : output == "Density"     ? "density"
                           : output == "Flame"       ? "flame"
                           : output == "Temperature" ? "temperature"
                                                     : "";
  if (name.empty()) return false;
  const Value whole = b.context().has_grid(name) ? b.emit(Op::NamedAttribute, Color, {}, 0, b.add_name(name))
                                                 : b.constant(Vec3(0.0f), Color);
  value = output == "Color" ? whole : b.part(whole, 0);
  return true;
}

bool point_info_node(ProgramBuilder& b, int, std::string_view output, Value& value) {
  static constexpr std::string_view kOutputs[] = {"Position", "Radius", "Random"};  // in the order of PointOutput
  for (int i = 0; i < int(std::size(kOutputs)); ++i) {
    if (output != kOutputs[i]) continue;
    value = b.emit(Op::PointInfo, Vector, {}, i);
    if (i > 0) value = b.part(value, 0);
    return true;
  }
  return false;
}

constexpr NodeType kNodes[] = {
    {"ShaderNodeValue", value_node},
    {"ShaderNodeRGB", rgb_node},
    {"ShaderNodeTexCoord", texture_coordinate},
    {"ShaderNodeUVMap", uv_map},
    {"ShaderNodeAttribute", attribute_node},
    {"ShaderNodeVertexColor", vertex_color},
    {"ShaderNodeNewGeometry", geometry},
    {"ShaderNodeObjectInfo", object_info},
    {"ShaderNodeLightPath", light_path_node},
    {"ShaderNodeLightFalloff", light_falloff},
    {"ShaderNodeCameraData", camera_data},
    {"ShaderNodeFresnel", fresnel_node},
    {"ShaderNodeLayerWeight", layer_weight},
    {"ShaderNodeTangent", tangent_node},
    {"ShaderNodeNormalMap", normal_map_node},
    {"ShaderNodeWireframe", wireframe},
    {"ShaderNodeAmbientOcclusion", ambient_occlusion},
    {"ShaderNodeBevel", bevel_node},
    {"ShaderNodeRaycast", raycast_node},
    {"ShaderNodeHairInfo", hair_info_node},
    {"ShaderNodeParticleInfo", particle_info},
    {"ShaderNodePointInfo", point_info_node},
    {"ShaderNodeVolumeInfo", volume_info},
};

}  // namespace

std::span<const NodeType> input_nodes() { return kNodes; }

}  // namespace ajar::nodes
