#include "mutate_scene.h"

#include <bit>
#include <cmath>

namespace ajar::fuzz {

namespace {

int below(Random& random, size_t n) { return n == 0 ? 0 : int(random() % n); }

float number(Random& random) {
  constexpr float kOdd[] = {0.0f,   -0.0f, 1.0f,  -1.0f,  0.5f,  2.0f, 1e-7f,    1e-20f,
                            1e-38f, 1e7f,  1e20f, -1e20f, 3e38f, NAN,  INFINITY, -INFINITY};
  const int kind = below(random, 3);
  if (kind == 0) return kOdd[below(random, std::size(kOdd))];
  if (kind == 1) return std::ldexp(float(below(random, 2001) - 1000) / 1000.0f, below(random, 21) - 10);
  return std::bit_cast<float>(uint32_t(random()) << 1 | uint32_t(random() & 1));
}
int integer(Random& random) {
  constexpr int kOdd[] = {0, 1, 2, 3, 8, 33, 129, 130, 65536, 2147483647, -1, -2147483647 - 1};
  return kOdd[below(random, std::size(kOdd))];
}

template <class T>
T* any_of(std::vector<T>& list, Random& random) {
  return list.empty() ? nullptr : &list[size_t(below(random, list.size()))];
}
/// Adds, removes or swaps an element.
template <class T>
void rearrange(std::vector<T>& list, Random& random) {
  if (list.empty()) list.emplace_back();
  const int at = below(random, list.size()), what = below(random, 3);
  if (what == 0 && list.size() < 64)
    list.push_back(T(list[size_t(at)]));
  else if (what == 1)
    list.erase(list.begin() + at);
  else
    std::swap(list[size_t(at)], list[size_t(below(random, list.size()))]);
}
template <size_t N>
void set_one(std::array<float, N>& numbers, Random& random) {
  numbers[size_t(below(random, N))] = number(random);
}
template <class V>
void set_one_of(V& vector, Random& random) {
  vector[below(random, size_t(V::length()))] = number(random);
}

void mutate(NodeGraph& graph, Random& random) {
  Node* node = any_of(graph.nodes, random);
  if (!node) return;
  NodeInput* input = any_of(node->inputs, random);
  NodeProperty* property = any_of(node->properties, random);
  switch (below(random, 6)) {
    case 0:
      if (input) set_one_of(input->value, random);
      break;
    case 1:
      if (input) input->link.node = below(random, graph.nodes.size() + 2) - 1;
      break;
    case 2:
      if (property && !property->numbers.empty())
        property->numbers[size_t(below(random, property->numbers.size()))] = number(random);
      break;
    case 3: std::swap(graph.surface, graph.volume); break;
    case 4: node->inputs.empty() ? void() : node->inputs.pop_back(); break;
    default: graph.volume.node = below(random, graph.nodes.size() + 1) - 1; break;
  }
}

void mutate(LightDescription& light, Random& random) {
  float* const numbers[] = {&light.energy,    &light.radius, &light.spot_angle,       &light.spot_blend,
                            &light.sun_angle, &light.spread, &light.light_importance, &light.area_size.x};
  switch (below(random, 6)) {
    case 0: light.kind = LightKind(below(random, 4)); break;
    case 1: light.area_shape = AreaShape(below(random, 2)); break;
    case 2: set_one(light.world_from_light, random); break;
    case 3: light.visibility = uint32_t(random()) & 63u; break;
    case 4: (below(random, 2) ? light.cast_shadow : light.multiple_importance) ^= true; break;
    default: *numbers[below(random, std::size(numbers))] = number(random); break;
  }
}

void mutate(ObjectDescription& object, Random& random) {
  float* const numbers[] = {&object.importance, &object.light_importance, &object.shadow_terminator_offset,
                            &object.color.x};
  switch (below(random, 5)) {
    case 0: object.visibility = uint32_t(random()) & 63u; break;
    case 1: (below(random, 2) ? object.holdout : object.shadow_catcher) ^= true; break;
    case 2: object.materials.push_back(below(random, 8) - 1); break;
    case 3: object.mesh = below(random, 8) - 1; break;
    default: *numbers[below(random, std::size(numbers))] = number(random); break;
  }
}

void mutate(MeshDescription& mesh, Random& random) {
  if (!mesh.strands.empty() && below(random, 2)) {
    switch (below(random, 5)) {
      case 0:
        mesh.strands[size_t(below(random, mesh.strands.size()))] = uint32_t(below(random, mesh.positions.size() + 2));
        break;
      case 1:
        if (float* radius = any_of(mesh.radii, random)) *radius = number(random);
        break;
      case 2: mesh.strand_shape = StrandShape(below(random, 3)); break;
      case 3: mesh.strand_subdivisions = integer(random); break;
      default: rearrange(mesh.strands, random); break;
    }
    return;
  }
  if (mesh.is_points() && below(random, 2)) {
    switch (below(random, 3)) {
      case 0:
        if (float* radius = any_of(mesh.radii, random)) *radius = number(random);
        break;
      case 1: mesh.radii.pop_back(); break;
      default: mesh.material_slots.assign(mesh.positions.size(), uint16_t(below(random, 3))); break;
    }
    return;
  }
  switch (below(random, 5)) {
    case 0:
      if (Vec3* p = any_of(mesh.positions, random)) set_one_of(*p, random);
      break;
    case 1:
      if (UVec3* t = any_of(mesh.triangles, random))
        (*t)[below(random, 3)] = uint32_t(below(random, mesh.positions.size() + 1));
      break;
    case 2:
      mesh.normal_domain = Domain(below(random, 3)),
      mesh.normals.resize(mesh.normal_domain == Domain::Face     ? mesh.triangles.size()
                          : mesh.normal_domain == Domain::Vertex ? mesh.positions.size()
                                                                 : 3 * mesh.triangles.size(),
                          Vec3(0, 0, 1));
      break;
    case 3: mesh.material_slots.assign(mesh.triangles.size(), uint16_t(random())); break;
    default:
      if (Attribute* a = any_of(mesh.attributes, random)) {
        a->domain = Domain(below(random, 3));
        a->components = below(random, 6);
      }
  }
}

void mutate(CameraDescription& camera, Random& random) {
  float* const numbers[] = {
      &camera.clip_start,       &camera.clip_end,       &camera.aperture_radius,      &camera.focus_distance,
      &camera.blade_rotation,   &camera.aperture_ratio, &camera.panorama.fisheye_fov, &camera.panorama.fisheye_lens,
      &camera.panorama.sensor.x};
  switch (below(random, 8)) {
    case 0: camera.kind = CameraKind(below(random, 3)); break;
    case 1: camera.panorama.kind = PanoramaKind(below(random, 6)); break;
    case 2: set_one(camera.world_from_camera, random); break;
    case 3: set_one_of(camera.screen_window, random); break;
    case 4: camera.shutter.push_back(number(random)); break;
    case 5: camera.motion.push_back(camera.world_from_camera), set_one(camera.motion.back(), random); break;
    case 6: camera.blades = integer(random); break;
    default: *numbers[below(random, std::size(numbers))] = number(random); break;
  }
}

void mutate(RenderSettings& s, Random& random) {
  int* const integers[] = {&s.bounces.total,
                           &s.bounces.diffuse,
                           &s.bounces.glossy,
                           &s.bounces.transmission,
                           &s.bounces.transparent,
                           &s.bounces.volume,
                           &s.photons,
                           &s.gather_rays,
                           &s.direct_samples,
                           &s.samples,
                           &s.threads,
                           &s.memory_limit,
                           &s.width,
                           &s.height};
  float* const numbers[] = {&s.filter_width,  &s.exposure,   &s.clamp_direct, &s.clamp_indirect, &s.importance_factor,
                            &s.photon_radius, &s.mist.start, &s.mist.depth,   &s.mist.exponent};
  switch (below(random, 6)) {
    case 0: s.filter = FilterKind(below(random, 3)); break;
    case 1: s.region[size_t(below(random, 4))] = below(random, 13); break;
    case 2: set_one(s.importance_region, random); break;
    case 3: *integers[below(random, std::size(integers))] = integer(random); break;
    case 4: s.seed = uint32_t(random()); break;
    default: *numbers[below(random, std::size(numbers))] = number(random); break;
  }
}

void mutate(InstanceDescription& instance, SceneDescription& d, Random& random) {
  switch (below(random, 3)) {
    case 0: set_one(instance.world_from_object, random); break;
    case 1: {
      instance.first_motion_key = int(d.motion_keys.size());
      instance.motion_key_count = 1 + below(random, 3);
      for (int k = 0; k < instance.motion_key_count; ++k)
        d.motion_keys.push_back(instance.world_from_object), set_one(d.motion_keys.back(), random);
      break;
    }
    default: instance.first_motion_key = integer(random), instance.motion_key_count = integer(random); break;
  }
}

void mutate(HintDescription& hint, Random& random) {
  switch (below(random, 3)) {
    case 0: hint.points.push_back(Vec3(number(random), number(random), number(random))); break;
    case 1: hint.spreads.push_back(number(random)); break;
    default: (below(random, 2) ? hint.spread : hint.weight) = number(random); break;
  }
}

void mutate(ImageDescription& image, Random& random) {
  switch (below(random, 3)) {
    case 0: image.alpha_mode = AlphaMode(below(random, 4)); break;
    case 1:
      image.pixels.empty() ? void() : void(image.pixels[size_t(below(random, image.pixels.size()))] = number(random));
      break;
    default: (below(random, 2) ? image.width : image.height) = integer(random); break;
  }
}

}  // namespace

void mutate(SceneDescription& d, Random& random) {
  const auto one_of = [&](auto& list) {
    if (below(random, 8) == 0)
      rearrange(list, random);
    else if (auto* one = any_of(list, random))
      mutate(*one, random);
  };
  switch (below(random, 12)) {
    case 0: one_of(d.lights); break;
    case 1: one_of(d.objects); break;
    case 2: one_of(d.meshes); break;
    case 3: one_of(d.hints); break;
    case 4: one_of(d.images); break;
    case 5: mutate(d.camera, random); break;
    case 6: mutate(d.settings, random); break;
    case 7:
      if (InstanceDescription* instance = any_of(d.instances, random)) mutate(*instance, d, random);
      break;
    case 8: rearrange(d.instances, random); break;
    case 9: below(random, 2) ? mutate(d.world.graph, random) : set_one_of(d.world.color, random); break;
    case 10: below(random, 4) ? void(d.world.light_importance = number(random)) : rearrange(d.materials, random); break;
    default:
      if (MaterialDescription* material = any_of(d.materials, random)) {
        if (below(random, 8) == 0) material->displacement_method = DisplacementMethod(below(random, 3));
        mutate(material->graph, random);
      }
      break;
  }
}

}  // namespace ajar::fuzz
