// A shader node graph that is compiled once into a short register program and evaluated at every hit.
//
// Compilation starts at the output sockets and follows the links backwards, so unused nodes are never compiled. It
// folds every subgraph that depends only on constants. The rest becomes instructions over a small file of float
// registers. A graph with a constant surface keeps its finished closures and executes no instruction per hit.
//
// An unknown node type is replaced by a documented fallback. `Diagnostics` reports it once per material, with the names
// of the node and of the material.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "description/diagnostics.h"
#include "description/scene_description.h"
#include "shading/bsdf/bsdf.h"
#include "shading/bsdf/shading_point.h"
#include "shading/media/medium.h"
#include "shading/program/shader_context.h"

namespace ajar {

class Texture;
class TextureStore;

/// The result of a shader. `bsdf.prepare(wo)` has been called.
struct SurfaceShading {
  Bsdf bsdf;
  Color emission{0.0f};     ///< radiance towards wo
  float holdout = 0.0f;     ///< fraction of the surface that is a hole in the film
  SubsurfaceMedium medium;  ///< valid if bsdf.has_subsurface()
};

struct SkyDisc {
  Vec3 direction;
  float angular_radius;
};

class ShaderProgram {
 public:
  /// Compiles `graph` of the material, world or lamp `owner`. Textures are registered in `textures`. Never throws for a
  /// broken graph: it uses fallbacks and reports them.
  static ShaderProgram compile(const NodeGraph& graph, const std::string& owner, TextureStore& textures,
                               Diagnostics& diagnostics, const ShaderContext& context = {});
  ShaderProgram();
  ShaderProgram(ShaderProgram&&) noexcept;
  ShaderProgram& operator=(ShaderProgram&&) noexcept;
  ~ShaderProgram();

  /// Computes the surface closures at `point` and overwrites `out`. Sets out.bsdf.ng and out.bsdf.n (the safe shading
  /// normal) first.
  void evaluate_surface(const ShadingPoint& point, SurfaceShading& out) const;
  /// Computes only the emitted radiance, for lights and the world. This is cheaper than evaluate_surface.
  Color evaluate_emission(const ShadingPoint& point) const;
  /// Computes only the fraction of light that passes straight through, for shadow rays.
  Color evaluate_transparency(const ShadingPoint& point) const;
  /// Adds the contribution of the volume to the medium at `point`, whose `primitive` is kInsideVolume.
  void add_medium(const ShadingPoint& point, MediumPoint& medium) const;

  /// A value of an AOV Output node; `name` is the hash of its name.
  struct Aov {
    uint32_t name;
    Color color;
    float value;
  };
  bool has_aovs() const;
  /// Calls show(Aov) for each AOV Output node.
  void evaluate_aovs(const ShadingPoint& point, const std::function<void(const Aov&)>& show) const;

  /// The vector in world space by which the vertex at `point` moves, without a check that it is finite.
  Vec3 displacement(const ShadingPoint& point) const;
  bool displaces() const;                 ///< vertices move
  bool bends_undisplaced_normal() const;  ///< and the normals of the surface before that are bent (see displace.h)

  bool is_constant() const;  ///< no instruction is executed at a hit
  bool emits() const;        ///< the emission can be non-zero
  bool emission_is_constant() const;
  bool emission_is_slow() const;  ///< it computes noise, and looks up no image, which could have small lights
  bool emission_depends_on_mesh_alone() const;  ///< it is the same for all instances
  bool emission_depends_on_side() const;        ///< or on the direction to the eye
  bool emission_depends_on_distance() const;    ///< of the lit point: Light Falloff, Ray Length
  bool may_be_transparent() const;              ///< has a Transparent closure with a non-zero weight
  bool has_portal() const;                      ///< has a ray portal, which lets no shadow ray pass
  bool scatters() const;                        ///< has a closure other than emission and transparency
  bool has_subsurface() const;                  ///< light can enter the surface
  bool enters_after_diffuse() const;            ///< also after a diffuse bounce
  bool subsurface_has_normal() const;  ///< closures with subsurface scattering have other normals than the surface
  bool has_volume() const;             ///< encloses a volume, which may be empty
  bool has_surface() const;            ///< false for an object that only encloses a volume: its surface is invisible
  bool only_encloses() const { return has_volume() && !has_surface(); }
  bool medium_varies() const;  ///< the medium varies within one object
  /// may_be_rough: some lobe can be diffuse or have at least this roughness. may_be_smooth: some lobe can have less.
  /// Transparent lobes do not count. may_be_rough_glossy: like may_be_rough, but diffuse lobes do not count.
  bool may_be_rough(float roughness) const;
  bool may_be_rough_glossy(float roughness) const;
  bool may_be_smooth(float roughness) const;
  /// How the lobes depend on the direction for which they are made, beyond what Bsdf accounts for when directions are
  /// swapped.
  enum class ViewDependence : uint8_t {
    None,
    Side,      ///< by the visible side, by normals that are bent towards the eye, by layers: Bsdf::turn_to
    Direction  ///< in other ways, too: Fresnel and Layer Weight nodes, for example
  };
  ViewDependence view_dependence() const;
  /// Small parts of the sky that can emit most of its light. Only the world's program has them.
  std::vector<SkyDisc> sky_discs() const;
  /// The images that the program looks up: their indices in the scene's list, and their textures.
  std::vector<std::pair<int, const Texture*>> images() const;
  int instruction_count() const;
  int register_count() const;   ///< floats that an evaluation stores at the same time
  std::string listing() const;  ///< the program as text, for tests and for debugging

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace ajar
