// Every closure at several settings, for the tests in test_bsdf.cpp and test_closures.cpp.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "shading/bsdf/closures.h"
#include "shading/bsdf/hair.h"
#include "shading/bsdf/huang.h"

namespace ajar::fixtures {

struct Material {
  std::string name;
  std::function<void(Bsdf&, const closures::Surface&)> add;  ///< its normal shall be surface.ng
  bool conserves_all = false;                                ///< white: scatters all light that arrives
  bool has_fresnel_at_normal = false;
  float largest_weight = 4.0f;  ///< maximum weight of a sample over a grid of directions
};
inline std::ostream& operator<<(std::ostream& out, const Material& m) { return out << m.name; }

/// The direction with this cosine to ng = z and this azimuth around it, in radians.
inline Vec3 direction(float cosine, float azimuth = 0.4f) {
  const float s = safe_sqrt(1.0f - cosine * cosine);
  return {s * std::cos(azimuth), s * std::sin(azimuth), cosine};
}

/// The BSDF that a shader builds for a hit from above (wo.z >= 0) or from below.
inline Bsdf make_bsdf(const Material& material, Vec3 wo) {
  const bool below = wo.z < 0.0f;
  closures::Surface surface{wo, Vec3(0, 0, below ? -1.0f : 1.0f), below};
  Bsdf bsdf;
  bsdf.ng = bsdf.n = surface.ng;
  material.add(bsdf, surface);
  bsdf.prepare(wo);
  return bsdf;
}

inline std::vector<Material> all_materials() {
  using namespace closures;
  const Color white(1.0f), tint(0.9f, 0.6f, 0.3f);
  const Vec3 tangent(0.8f, 0.6f, 0.0f);
  std::vector<Material> list;
  list.push_back({"diffuse", [=](Bsdf& b, const Surface& s) { add_diffuse(b, s, white, s.ng, 0.0f); }, true});
  list.push_back(
      {"diffuse_rough", [=](Bsdf& b, const Surface& s) { add_diffuse(b, s, white, s.ng, 0.8f); }, false, false, 60.0f});
  list.push_back({"translucent", [=](Bsdf& b, const Surface& s) { add_translucent(b, s, white, s.ng); }, true});

  for (const float sigma : {0.3f, 1.0f})
    list.push_back({sigma < 1.0f ? "velvet_fine" : "velvet",
                    [=](Bsdf& b, const Surface& s) { add_velvet(b, s, white, s.ng, sigma); }, false, false, 300.0f});
  for (const auto& [size, smooth, label] :
       {std::tuple(0.5f, 0.0f, "sharp"), {0.4f, 0.3f, "smooth"}, {0.9f, 0.5f, "wide"}}) {
    list.push_back({std::string("toon_diffuse_") + label,
                    [=, size = size, smooth = smooth](Bsdf& b, const Surface& s) {
                      add_toon(b, white, s.ng, false, size, smooth);
                    },
                    false, false, 1000.0f});
    list.push_back(
        {std::string("toon_glossy_") + label,
         [=, size = size, smooth = smooth](Bsdf& b, const Surface& s) { add_toon(b, white, s.ng, true, size, smooth); },
         false, false, 1000.0f});
  }

  const std::pair<const char*, Distribution> distributions[] = {{"ggx", Distribution::Ggx},
                                                                {"beckmann", Distribution::Beckmann},
                                                                {"multi_ggx", Distribution::MultiGgx},
                                                                {"ashikhmin_shirley", Distribution::AshikhminShirley}};
  for (const auto& [name, d] : distributions) {
    const bool multiple = d == Distribution::MultiGgx;
    for (const auto& [roughness, label] : {std::pair(0.15f, "smooth"), {0.5f, "medium"}, {1.0f, "rough"}})
      list.push_back({std::string("glossy_") + name + "_" + label,
                      [=, d = d, roughness = roughness](Bsdf& b, const Surface& s) {
                        add_glossy(b, s, white, s.ng, {d, roughness}, {tangent, 0.0f, 0.0f});
                      },
                      multiple, false, 12.0f});
    list.push_back({std::string("glossy_") + name + "_anisotropic", [=, d = d](Bsdf& b, const Surface& s) {
                      add_glossy(b, s, tint, s.ng, {d, 0.5f}, {tangent, 0.6f, 0.1f});
                    }});
    if (d == Distribution::AshikhminShirley) continue;
    for (const auto& [roughness, label] : {std::pair(0.2f, "smooth"), {0.7f, "rough"}})
      list.push_back({std::string("glass_") + name + "_" + label,
                      [=, d = d, roughness = roughness](Bsdf& b, const Surface& s) {
                        add_glass(b, s, white, s.ng, {d, roughness, 1.5f});
                      },
                      multiple, !multiple});
    if (multiple) continue;
    list.push_back({std::string("refraction_") + name, [=, d = d](Bsdf& b, const Surface& s) {
                      add_refraction(b, s, white, s.ng, {d, 0.4f, 1.33f});
                    }});
  }

  // The models of Blender 4.0 and later.
  list.push_back({"diffuse_rough_multiple",
                  [=](Bsdf& b, const Surface& s) { add_diffuse(b, s, white, s.ng, 0.8f, white); }, true, false, 60.0f});
  for (const float roughness : {0.1f, 0.6f})
    list.push_back({roughness < 0.5f ? "sheen_fine" : "sheen",
                    [=](Bsdf& b, const Surface& s) { add_sheen(b, white, s.ng, roughness); }, false, false, 300.0f});
  for (const Distribution d : {Distribution::Ggx, Distribution::Beckmann, Distribution::MultiGgx}) {
    const bool multiple = d == Distribution::MultiGgx;
    const std::string name = multiple ? "multi_ggx" : d == Distribution::Ggx ? "ggx" : "beckmann";
    list.push_back({"correlated_glossy_" + name,
                    [=](Bsdf& b, const Surface& s) {
                      add_glossy(b, s, white, s.ng, {d, 0.6f, true}, {tangent, multiple ? 0.0f : 0.6f, 0.1f});
                    },
                    multiple, false, 12.0f});
    list.push_back({"correlated_glass_" + name,
                    [=](Bsdf& b, const Surface& s) {
                      add_glass(b, s, white, s.ng, {d, 0.5f, 1.5f, true});
                    },
                    multiple});
  }
  list.push_back({"glass_with_film", [=](Bsdf& b, const Surface& s) {
                    add_glass(b, s, white, s.ng, {Distribution::Ggx, 0.3f, 1.5f, true, {400.0f, 1.8f}});
                  }});
  for (const bool is_conductor : {false, true})
    for (const float thickness : {0.0f, 300.0f})
      list.push_back(
          {std::string(is_conductor ? "conductor" : "metal") + (thickness > 0.0f ? "_with_film" : ""),
           [=](Bsdf& b, const Surface& s) {
             const Metal metal{is_conductor, Color(0.9f, 0.6f, 0.3f), Color(2.5f, 1.5f, 0.7f), {thickness, 1.6f}};
             add_metallic(b, white, s.ng, {Distribution::MultiGgx, 0.4f, true}, {tangent, 0.5f, 0.1f}, metal);
           }});

  const auto principled = [&](const char* name, float largest, auto&& change) {
    for (int version : {1, 2}) {
      PrincipledInputs in;
      in.version = version;
      in.tangent = tangent;
      change(in);
      list.push_back({std::string("principled_") + std::to_string(version) + "_" + name,
                      [=](Bsdf& b, const Surface& s) {
                        PrincipledInputs here = in;
                        here.normal = here.clearcoat_normal = s.ng;
                        add_principled(b, s, white, here);
                      },
                      false, false, largest});
    }
  };
  principled("default", 4.0f, [](PrincipledInputs&) {});
  principled("metal", 4.0f, [=](PrincipledInputs& in) {
    in.metallic = 1.0f, in.base_color = tint, in.anisotropic = 0.7f, in.anisotropic_rotation = 0.2f;
  });
  principled("cloth", 30.0f, [=](PrincipledInputs& in) { in.sheen = 1.0f, in.base_color = tint, in.roughness = 0.8f; });
  principled("glass", 8.0f, [=](PrincipledInputs& in) {
    in.transmission = 1.0f, in.roughness = 0.3f, in.transmission_roughness = 0.2f, in.specular_tint = 0.5f,
    in.base_color = tint;
  });
  principled("everything", 30.0f, [=](PrincipledInputs& in) {
    in.distribution = Distribution::MultiGgx;
    in.metallic = 0.3f, in.transmission = 0.4f, in.clearcoat = 0.8f, in.clearcoat_roughness = 0.2f, in.sheen = 0.3f;
    in.specular_tint_color = Color(0.9f, 0.8f, 0.7f), in.coat_tint = Color(0.9f, 0.95f, 1.0f), in.base_color = tint,
    in.anisotropic = 0.3f;
  });
  principled("film", 8.0f, [=](PrincipledInputs& in) {
    in.film = {350.0f, 1.7f}, in.metallic = 0.3f, in.transmission = 0.4f;
  });
  principled("thin_wall", 8.0f, [=](PrincipledInputs& in) {
    in.thin_wall = 1.0f, in.transmission = 0.6f, in.subsurface = 0.7f, in.subsurface_anisotropy = 0.4f;
    in.diffuse_roughness = 0.5f, in.base_color = tint;
  });

  for (const bool absorbs : {false, true})
    list.push_back({absorbs ? "hair_chiang_dark" : "hair_chiang_white",
                    [=](Bsdf& b, const Surface& s) {
                      hair::Fiber fiber;
                      if (absorbs) fiber.absorption = hair::absorption_of_color(tint, 0.4f);
                      fiber.longitudinal = hair::longitudinal_variance(absorbs ? 0.5f : 0.3f);
                      fiber.longitudinal_first = hair::longitudinal_variance(0.2f);
                      fiber.azimuthal = hair::azimuthal_scale(0.4f);
                      fiber.tilt = absorbs ? 0.06f : 0.0f;
                      b.add(hair::chiang_lobe(white, s.ng, tangent, fiber));
                    },
                    !absorbs});
  for (const bool transmission : {false, true})
    list.push_back({transmission ? "hair_transmission" : "hair_reflection", [=](Bsdf& b, const Surface& s) {
                      b.add(hair::part_lobe(transmission, tint, s.ng, tangent, 0.3f, 0.4f, -0.1f));
                    }});
  for (const bool is_oval : {false, true})
    for (const float alpha : {0.15f, 0.5f})
      list.push_back({std::string("hair_huang") + (is_oval ? "_oval" : "") + (alpha < 0.3f ? "_smooth" : "_rough"),
                      [=](Bsdf& b, const Surface& s) {
                        hair::RoughFiber fiber;
                        fiber.alpha = alpha;
                        fiber.tilt = 0.05f;
                        fiber.seed = 1234567890u;
                        if (is_oval) {
                          fiber.absorption = hair::absorption_of_color(tint, 0.4f);
                          fiber.aspect = 0.7f;
                          fiber.major = Vec3(0.3f, -0.2f, 0.9f);
                        }
                        b.add(hair::huang_lobe(white, s.ng, tangent, fiber));
                      },
                      false, false, 40.0f});
  return list;
}

}  // namespace ajar::fixtures
