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

/// `albedo` is the colour of the light that bounces between rough facets more than once; black for single scattering.
void add_diffuse(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, float roughness,
                 Color albedo = Color(0.0f), bool keeps_normal = false);
void add_translucent(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal);
void add_transparent(Bsdf& bsdf, Color weight);
/// The ray goes on from `position` in `direction`; straight on if the direction is zero.
void add_portal(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 position, Vec3 direction);
/// Roughness that differs along the tangent and across it.
struct Anisotropy {
  Vec3 tangent{1.0f, 0.0f, 0.0f};
  float amount = 0.0f, rotation = 0.0f;  ///< -1 .. 1, and of the tangent in full turns
};
struct Facets {
  Distribution distribution;
  float roughness;
  bool correlated = false;  ///< the models of Blender 4.0 and later: masking and shadowing depend on each other
};
void add_glossy(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const Facets& facets,
                const Anisotropy& anisotropy);
/// A rough boundary between two transparent materials.
struct RoughBoundary {
  Distribution distribution;
  float roughness, ior;
  bool correlated = false;  ///< as in Facets; light is split into reflection and refraction at each facet
  ThinFilm film{};
};
/// A metal: either its colour along the normal and a tint at 82 degrees (F82), or its complex index n + ik.
struct Metal {
  bool is_conductor = false;
  Color color_or_n{0.8f}, tint_or_k{1.0f};
  ThinFilm film{};
};
void add_metallic(Bsdf& bsdf, Color weight, Vec3 normal, const Facets& facets, const Anisotropy& anisotropy,
                  const Metal& metal, uint8_t layers = 0);
/// Microfibers (Blender 4.0 and later).
void add_sheen(Bsdf& bsdf, Color weight, Vec3 normal, float roughness, bool keeps_normal = false);
void add_refraction(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const RoughBoundary& boundary);
void add_glass(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const RoughBoundary& boundary,
               bool reflects = true, bool refracts = true);

void add_velvet(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, float sigma);
/// `size` and `smooth` are the values of the sockets, 0 to 1, as fractions of a right angle.
void add_toon(Bsdf& bsdf, Color weight, Vec3 normal, bool glossy, float size, float smooth, bool keeps_normal = false);
/// Light enters the surface, scatters in `medium` and leaves elsewhere. Integrators that cannot follow it see a diffuse
/// lobe. Channels with a negligible radius become diffuse. `layers` are those of the Bsdf that cover the closure.
void add_subsurface(Bsdf& bsdf, const Surface& surface, Color weight, Vec3 normal, const SubsurfaceMedium& medium,
                    uint8_t layers = 0);

/// Blender's kinds of subsurface scattering. Random walks differ in the mean free path that follows from the socket Radius, and in the
/// direction in which light enters.
enum class SubsurfaceMethod : uint8_t {
  RandomWalk,            ///< 3.x: that of the reduced medium of a dipole with this albedo and index; diffuse entry
  FixedRadius,           ///< 3.x: a constant factor, as in Blender's earlier profiles; diffuse entry
  Burley,                ///< no walk, but a profile with the radius of FixedRadius
  Skin,                  ///< 4.0 and later: as RandomWalk, but half of the light is refracted by a rough boundary
  RefractedFixedRadius,  ///< Random Walk of 4.0 to 5.1: a constant factor; light is refracted
  Refracted              ///< Random Walk of 5.2: Radius is the mean free path; light is refracted
};
/// The sockets of a closure with subsurface scattering.
struct SubsurfaceInputs {
  SubsurfaceMethod method = SubsurfaceMethod::RandomWalk;
  Color albedo{0.8f}, radius{1.0f};  ///< radius: socket Radius times Scale, in metres
  float anisotropy = 0.0f, ior = 1.4f;
  float alpha = 1.0f;  ///< roughness of the boundary (GGX), for methods in which light is refracted
};
SubsurfaceMedium make_medium(const SubsurfaceInputs& inputs);

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
  bool enters_after_diffuse = false;  ///< light enters the surface after a diffuse bounce as well (Blender 5.0)
  bool enters = false;                ///< subsurface light is followed and not approximated by diffuse reflection
  float diffuse_roughness = 0.0f;     ///< version 2 (Blender 4.3 and later)
  ThinFilm film;                      ///< its index is relative to air
  bool film_on_metal = true;          ///< the film covers the metal too (Blender 5.0)
  float thin_wall = 0.0f;             ///< not 0: the surface is a thin sheet (Blender 5.2)
  bool correlated = false;            ///< as in Facets
  bool is_conductor = false;          ///< metallic closures: base_color and specular_tint_color are n and k
  bool multiple_scattering = false;   ///< rough diffuse closures: light bounces between facets (Blender 4.3 and later)
  Vec3 normal{0, 0, 1}, clearcoat_normal{0, 0, 1}, tangent{1, 0, 0};
  /// Of diffuse and toon lobes, sheen and velvet: not bent towards the eye, if `keeps_normal` (Blender 4.0).
  Vec3 diffuse_normal{0, 0, 1};
  bool keeps_normal = false;
  bool reflective_caustics = true, refractive_caustics = true;  ///< these lobes are allowed after a diffuse bounce

  Anisotropy anisotropy() const { return {tangent, anisotropic, anisotropic_rotation}; }
};
/// The medium below a Principled surface.
SubsurfaceMedium principled_medium(const PrincipledInputs& inputs);
/// Adds the lobes of the Principled BSDF. The caller handles emission and alpha.
void add_principled(Bsdf& bsdf, const Surface& surface, Color weight, const PrincipledInputs& inputs);
/// The fraction of the emission that passes the sheen and the coat of a Principled surface of version 2.
Color emission_through_coat(const Surface& surface, const PrincipledInputs& inputs);

Vec3 bend_shading_normal(Vec3 ng, Vec3 wo, Vec3 ns);
/// The shading normal, bent by the smallest angle for which the mirror direction of wo is above ng. `ng` is on wo's
/// side.
inline Vec3 safe_shading_normal(Vec3 ng, Vec3 wo, Vec3 ns) { return ns == ng ? ns : bend_shading_normal(ng, wo, ns); }

}  // namespace ajar::closures
