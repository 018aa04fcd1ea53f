// The passes of a film to which light belongs, for integrators that know the whole path of their light: its light group,
// and the part of Blender's light passes, as path_walk.h separates them. The parts follow from the number of scattering
// events and from the vertex next to the eye.
#pragma once

#include "film/film.h"
#include "transport/paths/path.h"

namespace ajar {

/// Shares of diffuse, glossy and transmitted light in the scattered light; the sum is 1.
using PathShares = std::array<Color, 3>;
/// Where nothing is scattered (light beyond the terminator), the shares are those of the albedo.
PathShares shares_of(const Bsdf& bsdf, const PathShares& scattered);

class LightPasses {
 public:
  LightPasses() = default;
  /// `finds_direct`: the integrator adds all light of "Direct Halves" by the passes of its paths.
  LightPasses(const Scene& scene, const Film& film, bool finds_direct = false);
  /// Whether the film separates light.
  bool any() const { return parts_wanted_ || direct_wanted_ || !shown_.empty(); }
  /// Number of the groups of the scene; 0 if no pass shows one.
  int group_count() const { return int(shown_.size()); }

  /// The part of light that scatters at `first`, the vertex next to the eye, from `to_light` to `to_eye`. The number of
  /// scattering events of the whole path decides between direct and indirect light: of.
  PathPasses scattered_at(const PathVertex& first, Vec3 to_eye, Vec3 to_light, bool specular) const;
  /// The same at a surface with these lobes, at delta lobes, and for light that is known by the kinds of lobes.
  static PathPasses scattered_by(const Bsdf& bsdf, Vec3 to_eye, Vec3 to_light);
  static PathPasses specular(bool transmits);
  static PathPasses scattered(const Bsdf& bsdf, const PathShares& light_of_kinds);
  /// Of a path whose `first` is that of scattered_at; not used if nothing scatters.
  PathPasses of(const Scene& scene, const PathVertex& light, int bounces, const PathPasses& first) const;
  PathPasses of(const Scene& scene, const Path& path) const;
  /// The part alone, of light that is in no group (emission of media) or whose group is added otherwise. `bounces`: number
  /// of scattering events. Without any, the light is that of the environment if `first` says so, else emission.
  PathPasses part_of(int bounces, const PathPasses& first) const;
  /// The pass of a group of the scene; -1: none.
  int shown(int group) const { return group >= 0 && !shown_.empty() ? shown_[size_t(group)] : -1; }
  /// The group alone, by its index in the scene.
  PathPasses of_group(int group) const;

  /// Starts a sample.
  void begin();
  void add(const PathPasses& of, Color light) { add_light(parts_, of, light); }
  /// Adds the light of another sample of the same pixel.
  void add(const SampleParts& other);
  /// Adds the albedo of a surface that the camera sees with this throughput.
  void add_color(const Bsdf& bsdf, Color throughput);
  /// For Film::add_parts.
  const SampleParts& parts() const { return parts_; }

 private:
  std::vector<int> shown_;  ///< of each group of the scene: its pass; -1: none
  size_t count_ = 0;        ///< of groups that the film shows
  bool parts_wanted_ = false, direct_wanted_ = false;
  SampleParts parts_;
};

}  // namespace ajar
