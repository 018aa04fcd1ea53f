// Makers of lobes: one for each closure of Blender, with Blender's parameters. `weight` is the product of the closure's
// colour and all mix factors above it. Normals are in world space and already safe (see safe_shading_normal).
// `roughness` is the value of the socket; the makers square it. Every maker adds the lobes that Cycles would use for
// the same sockets, with the same physical meaning.
#pragma once

#include "shading/bsdf/bsdf.h"

namespace ajar::closures {

enum class Distribution : uint8_t { Sharp, Ggx, Beckmann, MultiGgx, AshikhminShirley };

struct Surface {
  Vec3 wo;
  Vec3 ng;          ///< turned to wo's side
  bool backfacing;  ///< wo is on the back of the face; indices of refraction are inverted
};

void add_diffuse(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, float roughness);
void add_translucent(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal);
void add_transparent(Bsdf& bsdf, Color weight);
/// Roughness that differs along the tangent and across it.
struct Anisotropy {
  Vec3 tangent{1.0f, 0.0f, 0.0f};
  float amount = 0.0f, rotation = 0.0f;  ///< -1 .. 1, and of the tangent in full turns
};
void add_glossy(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, Distribution distribution,
                float roughness, const Anisotropy& anisotropy);
/// A rough boundary between two transparent materials.
struct RoughBoundary {
  Distribution distribution;
  float roughness, ior;
};
void add_refraction(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const RoughBoundary& boundary);
void add_glass(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const RoughBoundary& boundary,
               bool reflects = true, bool refracts = true);

void add_velvet(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, float sigma);
/// `size` and `smooth` are the values of the sockets, 0 to 1, as fractions of a right angle.
void add_toon(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, bool glossy, float size, float smooth);
/// Light enters the surface, scatters in `medium` and leaves elsewhere. Integrators that cannot follow it see a diffuse
/// lobe. Channels with a negligible radius become diffuse.
void add_subsurface(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const SubsurfaceMedium& medium);

/// How the socket Radius of a closure determines the mean free path below the surface.
enum class SubsurfaceMethod : uint8_t {
  RandomWalk,  ///< `radius` is the mean free path of the reduced medium of a dipole with this albedo and index
  FixedRadius  ///< `radius` has the meaning that it has in Blender's earlier profiles
};
SubsurfaceMedium make_medium(Color albedo, Color radius, float anisotropy, float ior, SubsurfaceMethod method);

/// The sockets of the Principled BSDF. `version` 1 is Blender 3.x (Disney 2012 with Blender's changes); 2 is Blender
/// 4.0 and later. Sockets that a version does not have are ignored.
struct PrincipledInputs {
  int version = 1;
  Distribution distribution = Distribution::Ggx;
  Color base_color{0.8f};
  float metallic = 0.0f, roughness = 0.5f, ior = 1.45f, transmission = 0.0f, transmission_roughness = 0.0f;
  float anisotropic = 0.0f, anisotropic_rotation = 0.0f;
  float specular = 0.5f, specular_tint = 0.0f;  ///< version 1
  float specular_ior_level = 0.5f;              ///< version 2
  Color specular_tint_color{1.0f};              ///< version 2
  float sheen = 0.0f, sheen_tint = 0.5f, sheen_roughness = 0.5f;
  Color sheen_tint_color{1.0f};  ///< version 2
  float clearcoat = 0.0f, clearcoat_roughness = 0.03f, coat_ior = 1.5f;
  Color coat_tint{1.0f};
  float subsurface = 0.0f;
  Color subsurface_color{0.8f};
  Color subsurface_radius{1.0f, 0.2f, 0.1f};  ///< metres
  float subsurface_scale = 1.0f, subsurface_ior = 1.4f, subsurface_anisotropy = 0.0f;
  SubsurfaceMethod subsurface_method = SubsurfaceMethod::RandomWalk;
  bool enters = false;  ///< version 1: subsurface light is followed and not approximated by diffuse reflection
  float diffuse_roughness = 0.0f;  ///< version 2 (Blender 4.3 and later)
  Vec3 normal{0, 0, 1}, clearcoat_normal{0, 0, 1}, tangent{1, 0, 0};
  bool reflective_caustics = true, refractive_caustics = true;  ///< these lobes are allowed after a diffuse bounce
};
/// The medium below a Principled surface of version 1.
SubsurfaceMedium principled_medium(const PrincipledInputs& inputs);
/// Adds the lobes of the Principled BSDF. The caller handles emission and alpha.
void add_principled(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& inputs);

Vec3 bend_shading_normal(Vec3 ng, Vec3 wo, Vec3 ns);
/// The shading normal, bent by the smallest angle for which the mirror direction of wo is above ng. `ng` is on wo's
/// side.
inline Vec3 safe_shading_normal(Vec3 ng, Vec3 wo, Vec3 ns) { return ns == ng ? ns : bend_shading_normal(ng, wo, ns); }

}  // namespace ajar::closures
