// Blender's lamps: the radiance that a description defines, and the sampling of each shape.
//
// Units (as in Cycles 3.4; P = color * energy):
//   point, spot  W       intensity P / (4 pi); with a radius r, the radiance of the sphere is P / (4 pi^2 r^2)
//   spot         -       times cos(theta) and, in the outer `blend` part of the cone, a smoothstep. The cosine is that
//                        of Cycles; theta is measured from the axis, at the light.
//   area         W       radiance P / (4 A) on one side, times max(0, 1 - tan(theta) tan((pi - spread) / 2)) by the
//                        spread, normalised to the same flux
//   sun          W/m^2   irradiance P on a surface that faces the sun; radiance P / (pi tan^2(angle / 2) cos^3(theta)):
//                        a disk tangent to the sphere of directions, with a uniform sampling density
// The scale of the lamp's matrix scales area lamps only.
//
// Lamps never block rays. A sphere lamp is a sphere. Cycles 3.4 has a disk that faces the lit point, which is equal at
// a distance. A sphere also emits inwards: a point inside sees its inner side. A ray hits it once, where it enters or,
// from inside, where it leaves.
#pragma once

#include <vector>

#include "description/scene_description.h"
#include "lights/light.h"

namespace ajar {

/// The lamp without its shader (`shader` = -1, `power` not yet set).
Light make_lamp(const LightDescription& description);
/// Emitted watts (integral over area and directions), per colour. `scene_radius` is the radius of the disk of suns.
Color lamp_flux(const Light& light, float scene_radius);
/// Factor on `light.radiance` in direction wo: cone, spread, side, profile of the sun.
float lamp_profile(const Light& light, Vec3 wo);

std::optional<LightSample> sample_lamp_li(const Light& light, Vec3 p, Vec2 u);
float pdf_lamp_li(const Light& light, Vec3 p, Vec3 wi, float distance, Vec3 light_normal);

/// `center` and `radius` of the scene define the disk on which the rays of suns start.
std::optional<LightRay> sample_lamp_le(const Light& light, Vec2 u_position, Vec2 u_direction, Vec3 center,
                                       float radius);
/// Densities as in LightRay; `normal` is the normal of the light at the origin.
void pdf_lamp_le(const Light& light, Vec3 normal, Vec3 direction, float scene_radius, float& pdf_area,
                 float& pdf_solid_angle);

/// Where a ray hits a lamp with extent, by the rule above. Scene may use a faster way.
struct LampCrossing {
  float t;
  Vec3 normal;
};
std::optional<LampCrossing> intersect_lamp_shape(const Light& light, const Ray& ray);

}  // namespace ajar
