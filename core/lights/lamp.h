// Blender's lamps: what a description means in radiance, and how each shape is sampled.
//
// Units (as Cycles 3.4; P = color * energy):
//   point, spot  W       intensity P / (4 pi); with a radius r the sphere's radiance is P / (4 pi^2 r^2)
//   spot         -       times cos(theta) and, in the outer `blend` part of the cone, smoothstep: the
//                        cosine is Cycles', and `theta` is measured from the axis at the light
//   area         W       radiance P / (4 A) on one side, times the spread's max(0, 1 - tan(theta) tan((pi - spread) /
//   2)),
//                        normalised to the same flux
//   sun          W/m^2   irradiance P facing the sun; radiance P / (pi tan^2(angle / 2) cos^3(theta)): a
//                        disk tangent to the sphere of directions, of uniform sampling density
// The scale of the lamp's matrix scales area lamps only.
//
// Lamps never block rays. A sphere is a sphere, where Cycles 3.4 turns a disk towards the point lit: equal from afar.
// It shines inwards as well: p inside sees its inner side. A ray sees it once, where it enters or, from inside, leaves.
#pragma once

#include <vector>

#include "description/scene_description.h"
#include "lights/light.h"

namespace ajar {

/// The lamp without its shader (`shader` = -1, `power` not yet set).
Light make_lamp(const LightDescription& description);
/// Watts emitted (integral over area and directions), per colour. `scene_radius` is the disk's of the suns.
Color lamp_flux(const Light& light, float scene_radius);
/// Factor on `light.radiance` towards wo: cone, spread, side, the sun's profile.
float lamp_profile(const Light& light, Vec3 wo);

std::optional<LightSample> sample_lamp_li(const Light& light, Vec3 p, Vec2 u);
float pdf_lamp_li(const Light& light, Vec3 p, Vec3 wi, float distance, Vec3 light_normal);

/// `center` and `radius` of the scene place the disk from which suns shine.
std::optional<LightRay> sample_lamp_le(const Light& light, Vec2 u_position, Vec2 u_direction, Vec3 center,
                                       float radius);
/// Densities as in LightRay; `normal` is the light's at `position`.
void pdf_lamp_le(const Light& light, Vec3 normal, Vec3 direction, float scene_radius, float& pdf_area,
                 float& pdf_solid_angle);

/// Where a ray crosses a lamp with extent, by the rule above; Scene may use its own faster way.
struct LampCrossing {
  float t;
  Vec3 normal;
};
std::optional<LampCrossing> intersect_lamp_shape(const Light& light, const Ray& ray);

}  // namespace ajar
