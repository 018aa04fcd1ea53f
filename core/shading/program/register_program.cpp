#include "shading/program/register_program.h"

#include "geometry/geometry.h"
#include "math/hash.h"
#include "shading/bsdf/closures.h"
#include "shading/functions/bump.h"
#include "shading/functions/color_functions.h"
#include "shading/functions/gabor.h"
#include "shading/functions/math_functions.h"
#include "shading/functions/noise.h"
#include "shading/functions/patterns.h"
#include "shading/functions/point_functions.h"
#include "shading/functions/radial_tiling.h"
#include "shading/functions/ray_functions.h"
#include "shading/functions/texture_functions.h"
#include "shading/functions/voronoi.h"

namespace ajar {

const OpInfo& info(Op op) {
  static constexpr OpInfo kInfo[] = {
#define AJAR_OP(name, width, needs_point) {#name, width, needs_point},
      AJAR_SHADER_OPS(AJAR_OP)
#undef AJAR_OP
  };
  return kInfo[size_t(op)];
}

bool can_shift(Op op) {
  switch (op) {
    case Op::Position:
    case Op::Parametric:
    case Op::Generated:
    case Op::ObjectPosition:
    case Op::TransformPosition:
    case Op::CameraPosition:
    case Op::WindowPosition:
    case Op::ActiveUv:
    case Op::NamedUv:
    case Op::NamedAttribute:
    case Op::Wireframe:
    case Op::HairInfo: return true;
    default: return false;
  }
}

namespace {

/// The world is at infinity: the camera rotates its position but does not translate it.
Vec3 seen_by_camera(const ShadingPoint& point, const Mat4& camera_from_world) {
  const Vec3 p = point.position;
  return point.instance ? transform_point(camera_from_world, p) : transform_vector(camera_from_world, p);
}

Vec3 window_position(const ShadingPoint& point, const Mat4& camera_from_world, const Mat4& screen) {
  const Vec3 p = seen_by_camera(point, camera_from_world);
  const bool perspective = screen[1][0] != 0.0f;
  const float scale = perspective ? -1.0f / p.z : 1.0f;
  const Vec4 window = screen[0];
  return {(p.x * scale - window.x) / (window.y - window.x), (p.y * scale - window.z) / (window.w - window.z), 0.0f};
}

/// Position in Blender's camera space, where z grows away from the camera.
Vec3 camera_position(const ShadingPoint& point, const Mat4& camera_from_world) {
  const Vec3 p = seen_by_camera(point, camera_from_world);
  return {p.x, p.y, -p.z};
}

// variant: kind + 4 * (from + 4 * to). Kinds: points, vectors, normals as vectors, and normals that stay perpendicular to
// a surface that is scaled unevenly. Cameras have no scale.
Vec3 vector_transform(const ShadingPoint& point, uint8_t variant, const Mat4& camera_from_world, Vec3 v) {
  const int kind = variant & 3;
  const bool is_point = kind == 0, stays_perpendicular = kind == 3;
  const auto from = nodes::Space(variant >> 2 & 3), to = nodes::Space(variant >> 4 & 3);
  const auto apply = [&](const Mat4& m) { v = is_point ? transform_point(m, v) : transform_vector(m, v); };
  const auto flip_z = [&] { v.z = -v.z; };
  const auto between_object_and_world = [&](bool to_world) {
    if (!point.instance) return;
    Mat4 moved;
    const Mat4& m = to_world != stays_perpendicular ? world_from_object(*point.instance, point.time, moved)
                                                    : object_from_world(*point.instance, point.time, moved);
    if (stays_perpendicular)
      v = glm::transpose(Mat3(m)) * v;
    else
      apply(m);
  };
  if (from != to) {
    if (from == nodes::Space::Object) between_object_and_world(true);
    if (from == nodes::Space::Camera) flip_z(), apply(glm::affineInverse(camera_from_world));
    if (to == nodes::Space::Object) between_object_and_world(false);
    if (to == nodes::Space::Camera) apply(camera_from_world), flip_z();
  }
  return kind >= 2 ? nodes::normalize_or_zero(v) : v;
}

/// The number of octaves after the first, at most 15 as in Blender; 0 for NaN.
float detail_of(float x) { return x > 0.0f ? std::min(x, 15.0f) : 0.0f; }

// variant: dimensions - 1, kind of fractal << 2, normalised << 5
nodes::NoiseParameters noise_parameters(const Instruction& i, Vec3 octaves, Vec3 shape) {
  nodes::NoiseParameters n;
  n.dimensions = (i.variant & 3) + 1;
  n.fractal = nodes::Fractal(i.variant >> 2 & 7);
  n.normalize = i.variant >> 5 & 1;
  const auto generation = NoiseGeneration(i.data);
  n.octaves = detail_of(octaves.x);
  if (generation == NoiseGeneration::Musgrave) {
    n.lacunarity = std::max(octaves.z, 1e-5f);
    n.persistence = std::pow(n.lacunarity, -std::max(octaves.y, 1e-5f));
  } else {
    n.octaves += 1.0f;
    n.lacunarity = octaves.z;
    n.persistence = generation == NoiseGeneration::First ? saturate(octaves.y) : std::max(octaves.y, 0.0f);
  }
  n.offset = shape.x, n.gain = shape.y, n.distortion = shape.z;
  return n;
}

// variant: dimensions - 1, feature << 2, metric << 5, normalised << 7; data: VoronoiGeneration
nodes::VoronoiParameters voronoi_parameters(const Instruction& i, float scale, Vec3 shape, Vec3 octaves) {
  nodes::VoronoiParameters v;
  v.dimensions = (i.variant & 3) + 1;
  v.feature = nodes::VoronoiFeature(i.variant >> 2 & 7);
  v.metric = nodes::VoronoiMetric(i.variant >> 5 & 3);
  v.normalize = i.variant >> 7;
  v.generation = nodes::VoronoiGeneration(i.data);
  v.scale = scale;
  v.smoothness = glm::clamp(0.5f * shape.x, 0.0f, 0.5f);
  v.exponent = shape.y;
  v.randomness = saturate(shape.z);
  v.detail = detail_of(octaves.x);
  v.roughness = saturate(octaves.y);
  v.lacunarity = octaves.z;
  return v;
}

// variant: rings, axis << 1, profile << 3
nodes::WaveParameters wave_parameters(uint8_t variant, Vec3 distortion, Vec3 shape) {
  nodes::WaveParameters w;
  w.rings = variant & 1;
  w.axis = nodes::WaveAxis(variant >> 1 & 3);
  w.profile = nodes::WaveProfile(variant >> 3 & 3);
  w.distortion = distortion.x, w.detail = detail_of(distortion.y), w.detail_scale = distortion.z;
  w.detail_roughness = shape.x, w.phase = shape.y;
  return w;
}

}  // namespace

namespace {

/// `points` are the point and the two points beside it. All three are equal if there is no bump mapping.
void run_at(const Instruction* code, size_t count, const ProgramTables& tables, const ShadingPoint* const* points,
            float* registers) {
  const float* constants = tables.constants.data();
  for (const Instruction* i = code; i != code + count; ++i) {
    const ShadingPoint& point = *points[size_t(i->shift)];
    float* const out = registers + i->out;
    const auto f = [&](int k) { return *operand(i->in[k], registers, constants); };
    const auto v = [&](int k) { return load3(operand(i->in[k], registers, constants)); };
    const auto store3 = [out](Vec3 value) { out[0] = value.x, out[1] = value.y, out[2] = value.z; };
    const auto store4 = [out](Vec4 value) { out[0] = value.x, out[1] = value.y, out[2] = value.z, out[3] = value.w; };
    switch (i->op) {
      case Op::Splat: store3(Vec3(f(0))); break;
      case Op::Luminance: *out = luminance(v(0)); break;
      case Op::Average: {
        const Vec3 a = v(0);
        *out = (a.x + a.y + a.z) * (1.0f / 3.0f);
        break;
      }
      case Op::Combine: store3({f(0), f(1), f(2)}); break;
      case Op::Saturate: *out = saturate(f(0)); break;
      case Op::SaturateColor: store3(glm::clamp(v(0), 0.0f, 1.0f)); break;
      case Op::Product: *out = f(0) * f(1); break;
      case Op::ProductInverse: *out = f(0) * (1.0f - f(1)); break;
      case Op::Sum: *out = f(0) + f(1); break;
      case Op::Scale: store3(v(0) * f(1)); break;
      case Op::Math: *out = nodes::math(nodes::MathOperation(i->variant), f(0), f(1), f(2)); break;
      case Op::VectorMath:
        store3(nodes::vector_math(nodes::VectorOperation(i->variant), v(0), v(1), v(2), f(3)));
        break;
      case Op::VectorMathValue: *out = nodes::vector_math_value(nodes::VectorOperation(i->variant), v(0), v(1)); break;
      case Op::MixFloat: *out = f(1) * (1.0f - f(0)) + f(2) * f(0); break;
      case Op::MixVector: store3(v(1) * (1.0f - f(0)) + v(2) * f(0)); break;
      case Op::MixVectorNonUniform: store3(v(1) * (1.0f - v(0)) + v(2) * v(0)); break;
      case Op::MixColor: store3(nodes::blend(nodes::Blend(i->variant), f(0), v(1), v(2))); break;
      case Op::Clamp: *out = nodes::clamp_between(f(0), f(1), f(2), i->variant); break;
      case Op::MapRange:
        *out = nodes::map_range(nodes::RangeInterpolation(i->variant), f(0), f(1), f(2), f(3), f(4), f(5));
        break;
      case Op::MapRangeVector: {
        const Vec3 a = v(0), b = v(1), c = v(2), d = v(3), e = v(4), g = v(5);
        for (int k = 0; k < 3; ++k)
          out[k] = nodes::map_range_component(nodes::RangeInterpolation(i->variant), a[k], b[k], c[k], d[k], e[k],
                                              g[k]);
        break;
      }
      case Op::Mapping: store3(nodes::mapping(nodes::MappingKind(i->variant), v(0), v(1), v(2), v(3))); break;
      case Op::Affine: store3(transform_point(tables.matrices[i->data], v(0))); break;
      case Op::VectorRotate: {  // vector, centre, axis, angle, Euler angles; variant 1: Euler, 2: inverted
        const Vec3 centre = v(1), p = v(0) - centre;
        if (i->variant & 1) {
          const Mat3 rotate = nodes::euler_rotation(v(4));
          store3((i->variant & 2 ? p * rotate : rotate * p) + centre);
        } else {
          const Vec3 axis = nodes::normalize_or_zero(v(2));
          store3(axis == Vec3(0.0f) ? p + centre
                                    : nodes::rotate_around(p, axis, i->variant & 2 ? -f(3) : f(3)) + centre);
        }
        break;
      }
      case Op::Normalize: store3(nodes::normalize_or_zero(v(0))); break;
      case Op::Invert: store3(nodes::invert(v(1), f(0))); break;
      case Op::Gamma: store3(nodes::gamma(v(0), f(1))); break;
      case Op::BrightContrast: store3(nodes::bright_contrast(v(0), f(1), f(2))); break;
      case Op::HueSaturation: store3(nodes::hue_saturation(v(4), f(0), f(1), f(2), f(3))); break;
      case Op::CombineColor: store3(nodes::combine(nodes::ColorModel(i->variant), v(0))); break;
      case Op::SeparateColor: store3(nodes::separate(nodes::ColorModel(i->variant), v(0))); break;
      case Op::Blackbody: store3(nodes::blackbody(f(0), i->variant == 0)); break;
      case Op::Ramp: store4(nodes::table_lookup(tables.curves[i->data], f(0))); break;
      case Op::Curve: {
        const CurveTable& table = tables.curves[i->data];
        const Vec3 c = v(1), x = (c - table.min) / (table.max - table.min);
        const Vec3 curved(nodes::table_lookup(table, x.x).x, nodes::table_lookup(table, x.y).y,
                          nodes::table_lookup(table, x.z).z);
        store3((1.0f - f(0)) * c + f(0) * curved);
        break;
      }
      case Op::FloatCurve: {
        const CurveTable& table = tables.curves[i->data];
        const float c = f(1), curved = nodes::table_lookup(table, (c - table.min) / (table.max - table.min)).x;
        *out = (1.0f - f(0)) * c + f(0) * curved;
        break;
      }
      case Op::Checker: *out = nodes::checker(v(0) * f(1)); break;
      case Op::SelectColor: store3(f(0) == 1.0f ? v(1) : v(2)); break;
      case Op::Gradient: *out = nodes::gradient(nodes::GradientKind(i->variant), v(0)); break;
      case Op::Noise: *out = nodes::noise_value(noise_parameters(*i, v(2), v(3)), v(0), f(1)); break;
      case Op::NoiseColor: store3(nodes::noise_color(noise_parameters(*i, v(2), v(3)), v(0), f(1))); break;
      case Op::WhiteNoise: store3(nodes::white_noise(i->variant, v(0), f(1))); break;
      case Op::Voronoi: {
        const nodes::VoronoiResult result = nodes::voronoi(voronoi_parameters(*i, f(2), v(3), v(4)), v(0), f(1));
        out[0] = result.distance;
        for (int k = 0; k < 3; ++k) out[1 + k] = result.color[k];
        for (int k = 0; k < 4; ++k) out[4 + k] = result.position[k];
        break;
      }
      case Op::Wave: *out = nodes::wave(wave_parameters(i->variant, v(1), v(2)), v(0)); break;
      case Op::Magic: store3(nodes::magic(v(0), f(1), i->variant, f(2))); break;
      case Op::Brick: {  // position, (mortar size, smoothness, bias), (width, height, 0), (offset, squash, 0)
        const Vec3 mortar = v(1), size = v(2), rows = v(3);
        nodes::BrickParameters b{mortar.x, mortar.y, mortar.z, size.x, size.y, rows.x, rows.y};
        b.offset_frequency = int(i->data & 0xffff), b.squash_frequency = int(i->data >> 16);
        const Vec2 result = nodes::brick(b, v(0));
        out[0] = result.x, out[1] = result.y;
        break;
      }
      case Op::Gabor: {  // position, (frequency, anisotropy, angle), direction; variant: dimensions
        const Vec3 shape = v(1);
        store3(nodes::gabor({i->variant, shape.x, shape.y, shape.z, v(2)}, v(0)));
        break;
      }
      case Op::RadialTiling: {  // position, sides, roundness; variant: normalised
        const nodes::RadialTile tile = nodes::radial_tile(f(1), f(2), i->variant != 0, Vec2(v(0)));
        store3(Vec3(tile.place, 0.0f));
        out[3] = tile.sector, out[4] = tile.width, out[5] = tile.turn;
        break;
      }
      case Op::Sky: store3(tables.skies[i->data].radiance(v(0))); break;
      case Op::Ies: *out = tables.ies_profiles[i->data].towards(v(0)); break;
      case Op::Wavelength: store3(nodes::wavelength(f(0), i->variant == 0)); break;
      case Op::Image: store4(nodes::image(tables.images[i->data], Vec2(v(0)))); break;
      case Op::ImageBox: store4(nodes::image_box(tables.images[i->data], v(0), nodes::object_normal(point))); break;
      case Op::ImageOver:  // coordinates at the point and beside it
        store4(nodes::image_over(tables.images[i->data], {v(0), v(1), v(2)}, tables.bump.filter_widths[0]));
        break;
      case Op::ImageBoxOver:
        store4(nodes::image_box_over(tables.images[i->data], {v(0), v(1), v(2)}, tables.bump.filter_widths[0],
                                     nodes::object_normal(point)));
        break;
      case Op::Environment: {
        const Vec3 d = nodes::normalize_or_zero(v(0));
        const bool ball = nodes::EnvironmentProjection(i->variant) == nodes::EnvironmentProjection::MirrorBall;
        store4(nodes::image(tables.images[i->data], ball ? nodes::mirror_ball(d) : nodes::equirectangular(d)));
        break;
      }
      case Op::ProjectSphere: store3(Vec3(nodes::project_sphere(v(0)), 0.0f)); break;
      case Op::ProjectTube: store3(Vec3(nodes::project_tube(v(0)), 0.0f)); break;
      case Op::Position: store3(point.position); break;
      case Op::ShadingNormal: store3(point.ns); break;
      case Op::TrueNormal: store3(nodes::true_normal(point)); break;
      case Op::Incoming: store3(point.wo); break;
      case Op::Parametric: store3({1.0f - point.barycentric.x - point.barycentric.y, point.barycentric.x, 0.0f}); break;
      case Op::Backfacing: *out = point.backfacing ? 1.0f : 0.0f; break;
      case Op::RadialTangent: store3(nodes::radial_tangent(point, nodes::Axis(i->variant))); break;
      case Op::UvTangent: store3(nodes::uv_tangent(point, tables.names[i->data])); break;
      case Op::Generated: store3(nodes::generated(point)); break;
      case Op::ObjectPosition: store3(nodes::object_position(point)); break;
      case Op::TransformPosition: store3(transform_point(tables.matrices[i->data], point.position)); break;
      case Op::ObjectIncoming: store3(nodes::object_incoming(point)); break;
      case Op::ObjectNormal: store3(nodes::object_normal(point)); break;
      case Op::CameraPosition: store3(camera_position(point, tables.matrices[i->data])); break;
      case Op::WindowPosition:
        store3(window_position(point, tables.matrices[i->data >> 16], tables.matrices[i->data & 0xffff]));
        break;
      case Op::Reflection: store3(nodes::reflection(point)); break;
      case Op::ActiveUv: store3(nodes::active_uv(point)); break;
      case Op::NamedUv: {
        const Vec4 uv = nodes::attribute(point, tables.names[i->data], nullptr);
        store3({uv.x, uv.y, 0.0f});
        break;
      }
      case Op::NamedAttribute: {
        bool found;
        const Vec4 value = nodes::attribute(point, tables.names[i->data], &found);
        const int missing = i->variant & ~kOfVolumesAlone;
        if (i->variant != missing && point.primitive != kInsideVolume) found = false;
        store4(found ? value : missing == 2 ? Vec4(1.0f) : Vec4(0.0f, 0.0f, 0.0f, missing));
        break;
      }
      case Op::ObjectLocation: store3(point.instance ? Vec3(point.instance->world_from_object[3]) : Vec3(0.0f)); break;
      case Op::ObjectColor: store4(point.object ? point.object->color : Vec4(1.0f)); break;
      case Op::ObjectIndex: *out = point.object ? float(point.object->pass_index) : 0.0f; break;
      case Op::ObjectRandom: *out = point.instance ? point.instance->random : 0.0f; break;
      case Op::FromInstancer: store3(nodes::from_instancer(point, nodes::InstancerValue(i->variant))); break;
      case Op::ObjectProperty: store4(nodes::object_property(point, tables.names[i->data], i->variant != 0)); break;
      case Op::LightPath: *out = nodes::light_path(point, nodes::LightPathOutput(i->variant)); break;
      case Op::LightFalloff: {  // strength, smooth; variant: power of the distance (0, 1 or 2)
        // Variant + 4: no power of an infinite distance (suns).
        const float r2 = sqr(point.ray_length), smooth = f(1);
        const int power = i->variant & 4 && !std::isfinite(r2) ? 0 : i->variant & 3;
        float strength = f(0) * (power == 0 ? 1.0f : power == 1 ? point.ray_length : r2);
        if (smooth > 0.0f && std::isfinite(r2)) strength *= r2 / (smooth + r2);
        *out = strength;
        break;
      }
      case Op::Fresnel: {
        const float eta = std::max(f(0), 1e-5f);
        *out = nodes::fresnel(glm::dot(point.wo, v(1)), point.backfacing ? 1.0f / eta : eta);
        break;
      }
      case Op::LayerWeight: {  // blend, normal; variant 0: Fresnel, 1: facing
        const float cosine = glm::dot(point.wo, v(1));
        float blend = f(0);
        if (i->variant == 0) {
          const float eta = std::max(1.0f - blend, 1e-5f);
          *out = nodes::fresnel(cosine, point.backfacing ? eta : 1.0f / eta);
        } else {
          float facing = std::abs(cosine);
          if (blend != 0.5f) {
            blend = glm::clamp(blend, 0.0f, 1.0f - 1e-5f);
            facing = std::pow(facing, blend < 0.5f ? 2.0f * blend : 0.5f / (1.0f - blend));
          }
          *out = 1.0f - facing;
        }
        break;
      }
      case Op::NormalMap:
        store3(nodes::normal_map(point, nodes::NormalMapSpace(i->variant & 7),
                                 nodes::NormalMapGeneration(i->variant >> 3), tables.names[i->data], f(0), v(1)));
        break;
      case Op::Bump: {  // height at the point, heights beside it, strength, distance, normal
        // variant: keep the normal, Filter Width << 1
        const auto offsets = nodes::bump_offsets(point, tables.bump, tables.bump.filter_widths[i->variant >> 1]);
        const Vec3 n = nodes::bump(offsets, {f(0), f(1), f(2)}, f(3), f(4), v(5));
        store3(i->variant & 1 ? n : closures::safe_shading_normal(point.ng, point.wo, n));
        break;
      }
      case Op::Displacement:
        store3(nodes::displacement(point, nodes::DisplacementSpace(i->variant), f(0), v(1)));
        break;
      case Op::VectorDisplacement:
        store3(nodes::vector_displacement(point, nodes::DisplacementSpace(i->variant), v(0)));
        break;
      case Op::AmbientOcclusion: {  // normal, distance; variant: inside, only local
        const nodes::OcclusionParameters parameters{f(1), int(i->data), (i->variant & 1) != 0, (i->variant & 2) != 0};
        *out = nodes::openness(point, parameters, v(0));
        break;
      }
      case Op::Raycast: {  // position, direction, length; variant: only local
        const nodes::RaycastHit hit = nodes::raycast(point, {v(0), v(1), f(2), i->variant != 0});
        out[0] = hit.found ? 1.0f : 0.0f;
        out[1] = hit.own ? 1.0f : 0.0f;
        out[2] = hit.distance;
        for (int k = 0; k < 3; ++k) out[3 + k] = hit.normal[k];
        break;
      }
      case Op::RaycastAttribute:
        store4(nodes::attribute_at_hit(point, {v(0), v(1), f(2), i->variant != 0}, tables.names[i->data]));
        break;
      case Op::Bevel: store3(nodes::bevelled_normal(point, f(0), int(i->data))); break;
      case Op::Wireframe:
        *out = nodes::is_near_edge(point, i->variant ? f(0) * nodes::pixel_width(point, tables.bump) : f(0)) ? 1.0f
                                                                                                             : 0.0f;
        break;
      case Op::HairInfo:
        *out = i->variant == int(nodes::HairOutput::Misses) ? nodes::hair_misses(point, v(0), f(1))
                                                            : nodes::hair_info(point, nodes::HairOutput(i->variant));
        break;
      case Op::HairTangentNormal: store3(nodes::hair_tangent_normal(point)); break;
      case Op::PointInfo: store3(nodes::point_info(point, nodes::PointOutput(i->variant))); break;
      case Op::VectorTransform: store3(vector_transform(point, i->variant, tables.matrices[i->data], v(0))); break;
    }
  }
}

void run_bumped(const Instruction* code, size_t count, const ProgramTables& tables, const ShadingPoint& point,
                float* registers) {
  const auto beside = [&](int width) {
    const nodes::BumpOffsets offsets = nodes::bump_offsets(point, tables.bump,
                                                           tables.bump.filter_widths[size_t(width)]);
    return std::array{nodes::shifted(point, offsets.x), nodes::shifted(point, offsets.y)};
  };
  const std::array<ShadingPoint, 2> first = beside(0);
  const ShadingPoint* points[kMostShifts] = {&point, &first[0], &first[1]};
  if (tables.bump.widths <= 1) [[likely]]
    return run_at(code, count, tables, points, registers);
  std::array<std::array<ShadingPoint, 2>, BumpFootprint::kMostWidths - 1> others;
  for (int width = 1; width < tables.bump.widths; ++width) {
    others[size_t(width - 1)] = beside(width);
    for (size_t i = 0; i < 2; ++i) points[size_t(2 * width + 1) + i] = &others[size_t(width - 1)][i];
  }
  run_at(code, count, tables, points, registers);
}

}  // namespace

void run(const Instruction* code, size_t count, const ProgramTables& tables, const ShadingPoint& point,
         float* registers) {
  if (count == 0) return;
  if (tables.bump.used) {
    run_bumped(code, count, tables, point, registers);
  } else {
    const ShadingPoint* const here = &point;
    run_at(code, count, tables, &here, registers);
  }
}

void run_inside(const Instruction* code, size_t count, const ProgramTables& tables, const ShadingPoint& point,
                float* registers) {
  const ShadingPoint* points[kMostShifts];
  std::fill(std::begin(points), std::end(points), &point);
  run_at(code, count, tables, points, registers);
}

}  // namespace ajar
