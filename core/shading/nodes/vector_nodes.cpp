// Vector nodes: Vector Math, Mapping, rotations, transforms, separating and combining, curves, tilings.
#include "shading/functions/math_functions.h"
#include "shading/functions/point_functions.h"
#include "shading/nodes/curve_tables.h"
#include "shading/nodes/node_type.h"

namespace ajar::nodes {
namespace {

using enum SocketType;

bool vector_math_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int operation = b.choice(
      node, "operation",
      {"ADD",     "SUBTRACT",    "MULTIPLY",    "DIVIDE",   "MULTIPLY_ADD", "CROSS_PRODUCT", "PROJECT",   "REFLECT",
       "REFRACT", "FACEFORWARD", "DOT_PRODUCT", "DISTANCE", "LENGTH",       "SCALE",         "NORMALIZE", "ABSOLUTE",
       "MINIMUM", "MAXIMUM",     "FLOOR",       "CEIL",     "FRACTION",     "MODULO",        "WRAP",      "SNAP",
       "SINE",    "COSINE",      "TANGENT",     "POWER",    "SIGN",         "ROUND"});
  const Value v0 = b.input(node, "Vector", Vector), v1 = b.input(node, "Vector_001", Vector);
  if (output == "Value") {
    value = b.emit(Op::VectorMathValue, Float, {v0, v1}, operation);
    return true;
  }
  value = b.emit(Op::VectorMath, Vector,
                 {v0, v1, b.input(node, "Vector_002", Vector), b.input(node, "Scale", Float, Vec4(1.0f))}, operation);
  return output == "Vector";
}

bool mapping_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const auto kind = MappingKind(b.choice(node, "vector_type", {"POINT", "TEXTURE", "VECTOR", "NORMAL"}));
  const Value vector = b.input(node, "Vector", Vector), location = b.input(node, "Location", Vector),
              rotation = b.input(node, "Rotation", Vector), scale = b.input(node, "Scale", Vector, Vec4(1.0f));
  const bool fixed = location.is_constant() && rotation.is_constant() && scale.is_constant();
  if (fixed && kind != MappingKind::Normal) {  // one matrix replaces six sines per hit
    const auto map = [&](Vec3 v) {
      return mapping(kind, v, b.constant_vector(location), b.constant_vector(rotation), b.constant_vector(scale));
    };
    const Vec3 origin = map(Vec3(0.0f));
    const Mat4 matrix(Vec4(map({1, 0, 0}) - origin, 0.0f), Vec4(map({0, 1, 0}) - origin, 0.0f),
                      Vec4(map({0, 0, 1}) - origin, 0.0f), Vec4(origin, 1.0f));
    value = b.emit(Op::Affine, Vector, {vector}, 0, b.add_matrix(matrix));
  } else {
    value = b.emit(Op::Mapping, Vector, {vector, location, rotation, scale}, int(kind));
  }
  return output == "Vector";
}

bool vector_rotate(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int type = b.choice(node, "rotation_type", {"AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ"});
  Vec3 unit(0.0f);
  if (type >= 1 && type <= 3) unit[type - 1] = 1.0f;
  const Value axis = type == 0 ? b.input(node, "Axis", Vector, Vec4(0, 0, 1, 0)) : b.constant(unit, Vector);
  value = b.emit(Op::VectorRotate, Vector,
                 {b.input(node, "Vector", Vector), b.input(node, "Center", Vector), axis, b.input(node, "Angle", Float),
                  b.input(node, "Rotation", Vector)},
                 (type == 4 ? 1 : 0) | (b.number(node, "invert") != 0.0f ? 2 : 0));
  return output == "Vector";
}

enum class VectorKind : uint8_t { Point, Vector, Normal };

/// The vector after a constant transform.
Value between_spaces(ProgramBuilder& b, Value vector, VectorKind kind, const Mat4& to_from) {
  if (kind == VectorKind::Point) return b.emit(Op::Affine, Vector, {vector}, 0, b.add_matrix(to_from));
  const Mat3 linear(to_from);
  const Mat4 turned(kind == VectorKind::Normal ? glm::inverseTranspose(linear) : linear);
  const Value result = b.emit(Op::Affine, Vector, {vector}, 0, b.add_matrix(turned));
  return kind == VectorKind::Normal ? b.emit(Op::Normalize, Vector, {result}) : result;
}

bool vector_transform(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int type = b.choice(node, "vector_type", {"POINT", "VECTOR", "NORMAL"}, 1);
  const int from = b.choice(node, "convert_from", {"WORLD", "OBJECT", "CAMERA"});
  const int to = b.choice(node, "convert_to", {"WORLD", "OBJECT", "CAMERA"}, 1);
  Mat4 camera_from_world(1.0f);
  if (from == int(Space::Camera) || to == int(Space::Camera)) {
    if (const CameraDescription* camera = b.camera())
      camera_from_world = glm::affineInverse(to_matrix(camera->world_from_camera));
    else
      b.report(node, "there is no camera; world coordinates are used");
  }
  const Value vector = b.input(node, "Vector", Vector, Vec4(0.5f));
  if (b.context().lamp) {
    Mat4 along_z(1.0f);  // the camera looks along +z
    along_z[2][2] = -1.0f;
    const Mat4 world_from[] = {
        Mat4(1.0f),
        b.number(node, "lamp_has_space") != 0.0f ? to_matrix(b.context().lamp->world_from_lamp) : Mat4(1.0f),
        glm::affineInverse(along_z * camera_from_world)};
    value = between_spaces(b, vector, VectorKind(type), glm::affineInverse(world_from[to]) * world_from[from]);
  } else {
    const bool perpendicular = VectorKind(type) == VectorKind::Normal &&
                               b.number(node, "normals_stay_perpendicular") != 0.0f;
    const int kind = perpendicular ? 3 : type;
    value = b.emit(Op::VectorTransform, Vector, {vector}, kind | from << 2 | to << 4, b.add_matrix(camera_from_world));
  }
  return output == "Vector";
}

bool combine_xyz(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  value = b.emit(Op::Combine, Vector,
                 {b.input(node, "X", Float), b.input(node, "Y", Float), b.input(node, "Z", Float)});
  return output == "Vector";
}

bool separate_xyz(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const int i = output == "X" ? 0 : output == "Y" ? 1 : output == "Z" ? 2 : -1;
  if (i < 0) return false;
  value = b.part(b.input(node, "Vector", Vector), i);
  return true;
}

bool normal_node(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const std::vector<float>* direction = b.numbers(node, "value");
  const Vec3 d = direction && direction->size() >= 3 ? Vec3((*direction)[0], (*direction)[1], (*direction)[2])
                                                     : Vec3(0, 0, 1);
  const Value unit = b.emit(Op::Normalize, Vector, {b.constant(d, Vector)});
  value = output == "Normal"
              ? unit
              : b.emit(Op::VectorMathValue, Float,
                       {unit, b.emit(Op::Normalize, Vector, {b.input(node, "Normal", Vector, Vec4(0, 0, 1, 0))})},
                       int(VectorOperation::DotProduct));
  return output == "Normal" || output == "Dot";
}

bool vector_curve(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value in = b.input(node, "Vector", Vector);
  uint32_t table;
  value = curve_table(b, node, table)
              ? b.emit(Op::Curve, Vector, {b.input(node, "Fac", Float, Vec4(1.0f)), in}, 0, table)
              : in;
  return output == "Vector";
}

bool radial_tiling(ProgramBuilder& b, int node, std::string_view output, Value& value) {
  const Value whole = b.emit(
      Op::RadialTiling, Vector,
      {b.input(node, "Vector", Vector), b.input(node, "Sides", Float, Vec4(5.0f)), b.input(node, "Roundness", Float)},
      b.number(node, "normalize") != 0.0f);
  const int part = output == "Segment ID" ? 3 : output == "Segment Width" ? 4 : output == "Segment Rotation" ? 5 : 0;
  value = part ? b.part(whole, part) : whole;
  return part || output == "Segment Coordinates";
}

constexpr NodeType kNodes[] = {
    {"ShaderNodeVectorMath", vector_math_node}, {"ShaderNodeMapping", mapping_node},
    {"ShaderNodeVectorRotate", vector_rotate},  {"ShaderNodeVectorTransform", vector_transform},
    {"ShaderNodeCombineXYZ", combine_xyz},      {"ShaderNodeSeparateXYZ", separate_xyz},
    {"ShaderNodeNormal", normal_node},          {"ShaderNodeVectorCurve", vector_curve},
    {"ShaderNodeRadialTiling", radial_tiling},
};

}  // namespace

std::span<const NodeType> vector_nodes() { return kNodes; }

}  // namespace ajar::nodes
