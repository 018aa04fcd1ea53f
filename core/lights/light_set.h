// All lights of a scene: chosen by power, sampled, and found again when a ray hits them.
//
// The order of lights is fixed by the description: lamps first (light i is lamp i, also
// when it emits nothing), then the triangles of emissive instances, then the environment. An instance with any emissive
// material owns one index for *every* of its triangles, so that a hit's light is first_light + primitive; those that do
// not emit have no power and are never chosen. A triangle costs four bytes a table, its vertices stay in the mesh.
// A set in which nothing emits is empty. Nothing here traces rays.
//
// Choosing is for light sampling combined with BSDF sampling (MIS), for a point and its normal: lamps and triangles by
// a light tree (light_tree.h), which estimates the irradiance each sends there; suns and environment, of which there
// are few, by their own irradiance; the share between the two by the same estimates, within bounds, since neither knows
// of walls. Of the environment only what exceeds its mean counts: BSDF sampling finds the rest better (environment.h),
// and a constant world is never chosen. Measured on nine spheres, leaving a constant world out divides the variance by
// 1.2 alone, by 5.6 beside a sun, by 2.8 beside a lamp. Light sampling alone must use choose_by_power, which covers
// everything. Where there are media, and up to eight lights, half of the choices are even: fog is lit from all around,
// there is no cosine that would tell lights apart, and where a strong lamp stands behind a wall nearly all choices
// would go to it.
//
// The meshes, instances and programs it was built from must outlive it and stay where they are.
#pragma once

#include <memory>
#include <vector>

#include "geometry/geometry.h"
#include "lights/light.h"
#include "shading/shader_program.h"

namespace ajar {

class LightSet;

/// What LightSet needs to know of the built geometry and shaders.
struct LightBuildInput {
  const SceneDescription& description;  ///< of its lights and its world
  const std::vector<ObjectDescription>& objects;
  const std::vector<BuiltMesh>& meshes;
  std::vector<BuiltInstance>& instances;            ///< first_light is filled in
  const std::vector<uint32_t>& material_table;      ///< first_material + slot -> program
  const std::vector<ShaderProgram>& programs;       ///< materials, in order
  const std::vector<ShaderProgram>& lamp_programs;  ///< one per LightDescription; of an empty graph: unused
  const ShaderProgram& world_program;
  Vec3 scene_center{0.0f};
  float scene_radius = 1.0f;
  bool has_media = false;
  LightSet*
      same_world = nullptr;  ///< of a scene before whose world emitted exactly the same: its tables are taken over
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
  /// Made on demand for triangles; ask `flags` at every sample.
  Light light(uint32_t index) const;
  LightFlags flags(uint32_t index) const;
  int environment_index() const;  ///< -1 when the world is black
  bool has_distant_disks() const { return !distant_disks().empty(); }
  /// Luminance of all watts emitted.
  double total_power() const;
  /// Of the tree that local lights are chosen by, and of the table that directions to the environment are: 0 where
  /// there is none.
  size_t tree_bytes() const;
  size_t environment_bytes() const;

  /// A lamp, the triangles of an emissive instance, or the environment: lights first .. first + count - 1. Dark lamps
  /// are left out.
  struct SourceRange {
    uint32_t first, count;
    Vec3 center;  ///< of the scene, for distant sources
    bool distant;
  };
  std::vector<SourceRange> sources() const;

  /// Choose a light for a point that light reaches from the side of its normal n; n = 0 where it may come from all
  /// around (volumes, surfaces that transmit). The pmf is 0 when there is none to choose.
  struct Choice {
    uint32_t light;
    float pmf;
    float u_remapped;  ///< few bits left when there are many lights
  };
  bool can_choose() const;
  /// Of everything that choosing depends on: sets with the same one choose alike, and branches mean the same lights in
  /// both.
  uint64_t fingerprint() const;
  /// Is there a light that only some kinds of lobes see?
  bool any_partial() const;
  bool took_environment_over() const;
  Choice choose(Vec3 p, Vec3 n, float u) const;
  float choice_pmf(Vec3 p, Vec3 n, uint32_t light) const;

  /// The same choice in two steps, the first of which may be learned: branches that together hold every light once, in
  /// ascending order, with their shares for a neighbourhood of p; then a light of one of them, for p itself. Every
  /// distant light is a branch of its own while there are few.
  struct Branch {
    uint32_t id;
    float share;
  };
  void cut(Vec3 p, float radius, Vec3 n, int most, std::vector<Branch>& branches) const;
  Choice choose_in(uint32_t branch, Vec3 p, Vec3 n, float u) const;
  /// 0 for lights of other branches.
  float pmf_in(uint32_t branch, Vec3 p, Vec3 n, uint32_t light) const;
  /// The branch that holds a light that can be chosen is the last one whose id is not above this.
  uint32_t place_of(uint32_t light) const;

  /// A direction towards light `index` seen from p. Empty when p cannot receive from it. Shaders see
  /// `ray_kind`; by default none of Light Path's kinds, as Cycles does when it samples a light.
  std::optional<LightSample> sample_li(uint32_t index, Vec3 p, Vec2 u, float time, uint32_t ray_kind = 0) const;
  /// Density with which sample_li would have chosen the direction `wi` that reaches
  /// the light at `distance` with the light's geometric normal `light_normal`.
  float pdf_li(uint32_t index, Vec3 p, Vec3 wi, float distance, Vec3 light_normal) const;
  /// Radiance leaving lamp `index` from `position` towards `wo` (spot cone, spread and shader included); for suns
  /// `position` does not matter. `distance` is how far the light goes, which shaders may ask (Light Falloff); suns' do
  /// not.
  Color lamp_radiance(uint32_t index, Vec3 position, Vec3 wo, float time, float distance, uint32_t ray_kind = 0) const;

  /// Radiance of the environment (without suns) from direction `wi`, as a ray of this kind sees it.
  Color environment_radiance(Vec3 wi, uint32_t ray_kind) const;
  /// Suns with extent around direction `wi`: calls back for each (there are few).
  template <class F>
  void for_each_distant_disk(Vec3 wi, F&& visit) const {
    for (uint32_t index : distant_disks()) {
      if (distant_disk_contains(index, wi)) visit(index);
    }
  }
  const std::vector<uint32_t>& distant_disks() const;
  bool distant_disk_contains(uint32_t index, Vec3 wi) const;

  /// Rays that leave lights; for photons and bidirectional paths. They start from the outside of spheres only.
  Choice choose_by_power(float u) const;
  float power_pmf(uint32_t light) const;
  std::optional<LightRay> sample_le(uint32_t index, Vec2 u_position, Vec2 u_direction, float time) const;
  struct LePdf {
    float pdf_area, pdf_solid_angle;
  };
  LePdf pdf_le(uint32_t index, Vec3 position, Vec3 normal, Vec3 direction) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace ajar
