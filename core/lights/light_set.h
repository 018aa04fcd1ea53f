// All lights of a scene: their choice by power or by importance, their sampling, and the light that a ray hits.
//
// The description fixes the order of lights: lamps first (light i is lamp i, also if it emits nothing), then the
// triangles of emissive instances, then the environment. An instance with any emissive material has one index for
// *every* one of its triangles, so that the light of a hit is first_light + primitive. Triangles that do not emit have
// no power and are never chosen. A triangle costs four bytes per table; its vertices stay in the mesh. A set is empty
// if nothing emits. No function here traces rays.
//
// `choose` is for light sampling that is combined with BSDF sampling (MIS), for a point and its normal:
// - Lamps and triangles are chosen by a light tree (light_tree.h), which estimates the irradiance that each sends
//   there.
// - Suns and the environment are few and are chosen by their own irradiance.
// - The share of each of these groups follows the same estimates, within bounds, because neither considers occlusion.
// - Of the environment, only the luminance above its mean counts. BSDF sampling is better for the rest (environment.h),
//   and a constant world is never chosen. Measured on nine spheres, leaving a constant world out divides the variance
//   by 1.2 if it is the only light, by 5.6 with a sun, and by 2.8 with a lamp.
// - In scenes with media and up to eight lights, half of the choices are uniform: fog is lit from all sides, no cosine
//   separates the lights, and with a strong lamp behind a wall nearly all choices would go to it.
// Light sampling without BSDF sampling must use choose_by_power, which covers everything.
//
// The meshes, instances and programs from which a set is built must outlive it and must not move.
#pragma once

#include <memory>
#include <vector>

#include "geometry/geometry.h"
#include "lights/light_stretch.h"
#include "lights/sources/light.h"
#include "lights/sources/triangle_light.h"
#include "shading/shader_program.h"

namespace ajar {

class LightSet;

/// The built geometry and shaders from which a LightSet is made.
struct LightBuildInput {
  const SceneDescription& description;  ///< for its lights and its world
  const std::vector<ObjectDescription>& objects;
  const std::vector<BuiltMesh>& meshes;
  std::vector<BuiltInstance>& instances;            ///< first_light is set
  const std::vector<uint32_t>& material_table;      ///< first_material + slot -> program
  const std::vector<ShaderProgram>& programs;       ///< materials, in order
  const std::vector<ShaderProgram>& lamp_programs;  ///< one per LightDescription; unused if its graph is empty
  const ShaderProgram& world_program;
  Vec3 scene_center{0.0f};
  float scene_radius = 1.0f;
  bool has_media = false;
  /// False: emissive meshes are left out, because only rays that hit them matter.
  bool with_meshes = true;
  /// Lights of an earlier scene whose world emits exactly the same; its tables are taken over.
  LightSet* same_world = nullptr;
};

class LightSet {
 public:
  LightSet();
  LightSet(const LightBuildInput& input, Diagnostics& diagnostics);
  LightSet(LightSet&&) noexcept;
  LightSet& operator=(LightSet&&) noexcept;
  ~LightSet();

  size_t size() const;
  bool empty() const { return size() == 0; }
  /// Lamps are the lights below this index.
  uint32_t lamp_count() const;
  /// Made on request for triangles, which can move: at a time of the shutter interval. Use `flags` at every sample.
  Light light(uint32_t index, float time = kMidShutter) const;
  /// Whether it is a triangle of an object that moves.
  bool moves(uint32_t index) const;
  bool any_moves() const;
  LightFlags flags(uint32_t index) const;
  int environment_index() const;  ///< -1 when the world is black
  bool has_distant_disks() const { return !distant_disks().empty(); }
  /// Luminance of all emitted watts.
  double total_power() const;
  /// Memory of the tree by which local lights are chosen, and of the table by which directions to the environment are
  /// chosen; 0 without them.
  size_t tree_bytes() const;
  size_t environment_bytes() const;

  /// A lamp, the triangles of an emissive instance, or the environment: lights first .. first + count - 1. Lamps that
  /// do not emit are left out.
  struct SourceRange {
    uint32_t first, count;
    Vec3 center;  ///< of the scene for distant sources
    bool distant;
  };
  std::vector<SourceRange> sources() const;

  /// A light chosen for a point that receives light on the side of its normal n; n = 0 if it receives light from all
  /// sides (volumes, surfaces that transmit). The pmf is 0 if there is no light to choose.
  struct Choice {
    uint32_t light;
    float pmf;
    float u_remapped;  ///< has few random bits if there are many lights
  };
  bool can_choose() const;
  /// Hash of everything that the choice depends on. Sets with equal hashes make equal choices, and their branches hold
  /// the same lights.
  uint64_t fingerprint() const;
  /// Whether there is a light that only some kinds of lobes see.
  bool any_partial() const { return any_.partial; }
  /// Whether no path starts at some light (LightFlags::starts_walks).
  bool any_without_walks() const;
  bool took_environment_over() const;
  /// Whether a light does not light all objects. Then `choose` for the receiver set of an object chooses among the lights
  /// that light it.
  bool any_linked() const { return any_.linked; }
  /// Whether a light has a maximum number of bounces that the limits of the scene do not have.
  bool any_limited() const { return any_.limited; }
  Choice choose(Vec3 p, Vec3 n, float u, uint32_t receiver_set = kEveryLight) const;
  float choice_pmf(Vec3 p, Vec3 n, uint32_t light, uint32_t receiver_set = kEveryLight) const;
  /// The same for light that a medium scatters along a part of a ray.
  Choice choose(const LightStretch& stretch, float u, uint32_t receiver_set = kEveryLight) const;
  float choice_pmf(const LightStretch& stretch, uint32_t light, uint32_t receiver_set = kEveryLight) const;

  /// The same choice in two steps, of which the first can be learned. `cut` gives branches that together hold every
  /// light once, in ascending order, with their shares for a neighbourhood of p. `choose_in` chooses a light of one
  /// branch for p itself. If there are few distant lights, each of them is a branch.
  struct Branch {
    uint32_t id;
    float share;
  };
  void cut(Vec3 p, float radius, Vec3 n, int max_branches, std::vector<Branch>& branches) const;
  Choice choose_in(uint32_t branch, Vec3 p, Vec3 n, float u) const;
  /// 0 for lights of other branches.
  float pmf_in(uint32_t branch, Vec3 p, Vec3 n, uint32_t light) const;
  /// Position of a light among the branches: the last branch whose id is not above this holds the light.
  uint32_t place_of(uint32_t light) const;

  /// A direction towards light `index`, seen from p. Empty if p cannot receive light from it. Shaders see `ray_kind`;
  /// the default has none of the kinds of Light Path, as in Cycles when it samples a light.
  std::optional<LightSample> sample_li(uint32_t index, Vec3 p, Vec2 u, float time, uint32_t ray_kind = 0) const;
  /// Density with which sample_li chooses the direction `wi` that reaches the light at `distance`, where its geometric
  /// normal is `light_normal`.
  float pdf_li(uint32_t index, Vec3 p, Vec3 wi, float distance, Vec3 light_normal, float time) const;
  /// Radiance that leaves lamp `index` from `position` towards `wo` (with spot cone, spread and shader). `position` is
  /// not used for suns. `distance` is the distance to the lit point, which shaders can read (Light Falloff), except
  /// those of suns.
  Color lamp_radiance(uint32_t index, Vec3 position, Vec3 wo, float time, float distance, uint32_t ray_kind = 0) const;

  /// Radiance of the environment (without suns) from direction `wi`, as a ray of this kind sees it.
  Color environment_radiance(Vec3 wi, uint32_t ray_kind) const;
  /// Calls `visit` for each sun with extent that covers direction `wi` (there are few).
  template <class F>
  void for_each_distant_disk(Vec3 wi, F&& visit) const {
    for (uint32_t index : distant_disks()) {
      if (distant_disk_contains(index, wi)) visit(index);
    }
  }
  const std::vector<uint32_t>& distant_disks() const;
  bool distant_disk_contains(uint32_t index, Vec3 wi) const;

  /// Rays that leave lights, for photons and bidirectional paths. They start only from the outside of spheres.
  Choice choose_by_power(float u) const;
  float power_pmf(uint32_t light) const;
  /// Whether its shader depends on the distance of the lit point, and the radiance of a ray of sample_le at a point at this
  /// distance, over that at kUsualDistance.
  bool depends_on_distance(uint32_t index) const;
  Color falloff(uint32_t index, const LightRay& ray, float distance) const;
  std::optional<LightRay> sample_le(uint32_t index, Vec2 u_position, Vec2 u_direction, float time) const;
  struct LePdf {
    float pdf_area, pdf_solid_angle;
  };
  LePdf pdf_le(uint32_t index, Vec3 normal, Vec3 direction, float time) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
  /// Of some light. Paths ask at every vertex.
  struct {
    bool partial = false, linked = false, limited = false;
  } any_;
};

}  // namespace ajar
