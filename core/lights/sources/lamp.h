// Blender's lamps: the radiance that a description defines, and the sampling of each shape.
//
// Units (as in Cycles 3.4; P = color * energy):
//   point, spot  W       intensity P / (4 pi); with a radius r, the radiance of the sphere is P / (4 pi^2 r^2)
//   spot         -       times, in the outer `blend` part of the cone, a smoothstep, and times cos(theta) unless
//                        LightDescription::even_spot; theta is measured from the axis, at the light. A point inside an
//                        even spot's sphere sees all of it.
//   area         W       radiance P / (4 A) on one side, times max(0, 1 - tan(theta) tan((pi - spread) / 2)) by the
//                        spread, normalised to the same flux
//   sun          W/m^2   radiance P / (pi tan^2(angle / 2) cos^3(theta)): a disk tangent to the sphere of directions,
//                        with a uniform sampling density; P is the irradiance on a surface that faces a small sun
//   even sun     W/m^2   LightDescription::even_sun: radiance P / (pi sin^2(angle / 2)) in the whole cone; P is the
//                        irradiance on a surface that faces the sun
// The scale of the lamp's matrix scales area lamps and the cones of even spots, not the spheres.
//
// Lamps never block rays. A sphere also emits inwards: a point inside sees its inner side. A ray hits it once, where it
// enters or, from inside, where it leaves.
//
// A soft lamp (LightDescription::soft_falloff) is a disk of the same radius r and radiance around the centre, which faces
// the lit point. From the distance d it fills the cone sin^2 = r^2 / (r^2 + d^2), as a sphere does whose radius shrinks
// near the point. Whole paths and rays that leave lamps place their light end on the far side of the lamp's sphere, where
// the line of light comes in; this does not depend on the lit point, which may be inside. The normal there is the inward
// one, and the density is that of a sphere. `soft_lamp_distance` tells whether the line illuminates a point.
#pragma once

#include <vector>

#include "description/scene_description.h"
#include "lights/sources/light.h"

namespace ajar {

/// The lamp without its shader (`shader` = -1, `power` not yet set).
Light make_lamp(const LightDescription& description);
/// Emitted watts (integral over area and directions), per colour. `scene_radius` is the radius of the disk of suns.
Color lamp_flux(const Light& light, float scene_radius);
/// Factor on `light.radiance` in direction wo: cone, spread, side, profile of the sun.
float lamp_profile(const Light& light, Vec3 wo);
/// Probability density (per solid angle) with which directions in a sun with extent are sampled.
float sun_pdf(const Light& light, Vec3 wo);

/// Limits the part from `begin` to `end` of a ray to that in a cone which contains the light from all points of a lamp
/// with a cone. If there is none, both are equal.
void clip_to_cone(const Light& light, const Ray& ray, float& begin, float& end);

std::optional<LightSample> sample_lamp_li(const Light& light, Vec3 p, Vec2 u);
float pdf_lamp_li(const Light& light, Vec3 p, Vec3 wi, float distance, Vec3 light_normal);

/// A place on a light that is not distant, uniform over its area, and the normal there; on a sphere also of the far side.
void sample_place(const Light& light, Vec2 u, Vec3& position, Vec3& normal);

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

/// For soft lamps. The distance of the disk from p in direction wi; nothing if that misses the disk.
std::optional<float> soft_lamp_distance(const Light& light, Vec3 p, Vec3 wi);
/// The inward normal where the line through `position` towards wo enters the sphere; nothing if it misses the sphere.
std::optional<Vec3> soft_lamp_normal(const Light& light, Vec3 position, Vec3 wo);
/// Where rays of the lamp's light start, which are on the line from `position` towards wo: beside the centre.
Vec3 soft_lamp_start(const Light& light, Vec3 position, Vec3 wo);

}  // namespace ajar
