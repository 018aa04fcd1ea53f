// From a closure's sockets to lobes: one maker per Blender closure, with Blender's parameters.
// `weight` is the product of the closure's colour and all mix factors above it. Normals are in world space
// and already safe (see safe_shading_normal); `roughness` is the socket's value, squared here.
// Every maker adds the lobes that Cycles would use for the same sockets, in the same physical meaning.
#pragma once

#include "shading/bsdf/bsdf.h"

namespace ajar::closures {

enum class Distribution : uint8_t { Sharp, Ggx, Beckmann, MultiGgx, AshikhminShirley };

struct Surface {
  Vec3 wo;
  Vec3 ng;          ///< turned to wo's side
  bool backfacing;  ///< wo is on the back of the face: indices of refraction are inverted
};

void add_diffuse(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, float roughness);
void add_translucent(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal);
void add_transparent(Bsdf& bsdf, Color weight);
void add_glossy(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, Vec3 tangent, Distribution distribution,
                float roughness, float anisotropy, float rotation);
void add_refraction(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, Distribution distribution,
                    float roughness, float ior);
void add_glass(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, Distribution distribution,
               float roughness, float ior, bool reflects = true, bool refracts = true);

void add_velvet(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, float sigma);
/// `size` and `smooth` are the sockets', in [0, 1] of a right angle.
void add_toon(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, bool glossy, float size, float smooth);
/// Light that enters and leaves as the medium says; whoever cannot follow it sees a diffuse lobe. Channels whose radius
/// is next to nothing are diffuse.
void add_subsurface(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const SubsurfaceMedium& medium);

/// How far light goes below the surface, for the sockets of a closure.
enum class SubsurfaceMethod : uint8_t {
  RandomWalk,  ///< `radius` as the mean free path of the reduced medium that a dipole of this albedo and index has
  FixedRadius  ///< `radius` as in Blender's earlier profiles
};
SubsurfaceMedium make_medium(Color albedo, Color radius, float anisotropy, float ior, SubsurfaceMethod method);

/// Sockets of the Principled BSDF. `version` 1 is Blender 3.x (Disney 2012 with Blender's changes), 2 is Blender 4.0
/// and later; sockets that a version lacks are ignored.
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
  bool enters = false;             ///< version 1: subsurface light is followed, not approximated by diffuse reflection
  float diffuse_roughness = 0.0f;  ///< version 2 (4.3+)
  Vec3 normal{0, 0, 1}, clearcoat_normal{0, 0, 1}, tangent{1, 0, 0};
  bool reflective_caustics = true, refractive_caustics = true;  ///< lobes allowed after a diffuse bounce
};
/// The medium below a Principled surface of version 1.
SubsurfaceMedium principled_medium(const PrincipledInputs& inputs);
/// Emission and alpha are handled by the caller.
void add_principled(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& inputs);

Vec3 bend_shading_normal(Vec3 ng, Vec3 wo, Vec3 ns);
/// Shading normal bent as little as needed so that the mirror direction of wo lies above ng. `ng` is on wo's side.
inline Vec3 safe_shading_normal(Vec3 ng, Vec3 wo, Vec3 ns) { return ns == ng ? ns : bend_shading_normal(ng, wo, ns); }

}  // namespace ajar::closures
