// A shader node graph compiled once into a short register program, and evaluated at every hit.
//
// Compilation walks back from the output sockets (so dead nodes never appear), folds
// every subgraph that depends on constants only, and leaves the rest as instructions
// over a small file of float registers. A graph whose surface is constant keeps its finished closures
// and runs no instruction per hit.
// A node type the compiler does not know takes a documented fallback and is reported once per
// material in `Diagnostics`, by node name and material.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "description/diagnostics.h"
#include "description/scene_description.h"
#include "shading/bsdf/bsdf.h"
#include "shading/bsdf/medium.h"
#include "shading/bsdf/shading_point.h"
#include "shading/program/shader_context.h"

namespace ajar {

class Texture;
class TextureStore;

/// What a shader gives back. `bsdf.prepare(wo)` has been called.
struct SurfaceShading {
  Bsdf bsdf;
  Color emission{0.0f};     ///< radiance towards wo
  float holdout = 0.0f;     ///< fraction that cuts a hole in the film
  SubsurfaceMedium medium;  ///< when bsdf.has_subsurface()
};

struct SkyDisc {
  Vec3 direction;
  float angular_radius;
};

class ShaderProgram {
 public:
  /// Compile `graph` of the material (or world, or lamp) `owner`. Textures are
  /// registered in `textures`. Never throws for bad graphs: falls back and reports.
  static ShaderProgram compile(const NodeGraph& graph, const std::string& owner, TextureStore& textures,
                               Diagnostics& diagnostics, const ShaderContext& context = {});
  ShaderProgram();
  ShaderProgram(ShaderProgram&&) noexcept;
  ShaderProgram& operator=(ShaderProgram&&) noexcept;
  ~ShaderProgram();

  /// Surface closures at `point`; what `out` held before is forgotten. Sets out.bsdf.ng and .n (safe shading normals)
  /// first.
  void evaluate_surface(const ShadingPoint& point, SurfaceShading& out) const;
  /// Only the emitted radiance (for lights and the world; cheaper than the above).
  Color evaluate_emission(const ShadingPoint& point) const;
  /// Only what a shadow ray needs: the fraction let straight through.
  Color evaluate_transparency(const ShadingPoint& point) const;
  /// What the volume adds to the medium at `point`, whose `primitive` is kInsideVolume.
  void add_medium(const ShadingPoint& point, MediumPoint& medium) const;

  bool is_constant() const;  ///< no instruction at a hit
  bool emits() const;        ///< emission may be non-zero
  bool emission_is_constant() const;
  bool may_be_transparent() const;  ///< has a Transparent closure with non-zero weight
  bool scatters() const;            ///< has any closure beyond emission and transparency
  bool has_subsurface() const;      ///< light may enter the surface
  bool has_volume() const;          ///< encloses a volume, be it an empty one
  bool has_surface() const;         ///< false: what only encloses a volume is not seen itself
  bool medium_varies() const;       ///< from place to place within one object
  /// Whether some lobe may be diffuse or at least as rough as this; whether some lobe may be smoother. Transparency is
  /// neither.
  bool may_be_rough(float roughness) const;
  bool may_be_smooth(float roughness) const;
  /// The lobes may differ with the direction they are made for, beyond what Bsdf accounts for when
  /// directions are swapped (Fresnel and Layer Weight nodes, bumped normals, coats, which side is seen).
  bool depends_on_view() const;
  /// Small parts of the sky, as seen by the world's program, that may hold most of its light.
  std::vector<SkyDisc> sky_discs() const;
  /// Images it looks up, by their index in the scene's list, and their textures.
  std::vector<std::pair<int, const Texture*>> images() const;
  int instruction_count() const;
  std::string listing() const;  ///< the program as text, for tests and people

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace ajar
