// What the compiler of a shader graph knows about the scene.
#pragma once

#include <array>
#include <set>
#include <string>

#include "description/scene_description.h"

namespace ajar {

/// The lamp to which a shader belongs.
struct LampSpace {
  std::array<float, 12> world_from_lamp;
  LightKind kind;
  Vec2 area_size;
  float spot_angle;
  bool has_uv, own_coordinates;
  explicit LampSpace(const LightDescription& light)
      : world_from_lamp(light.world_from_light),
        kind(light.kind),
        area_size(light.area_size),
        spot_angle(light.spot_angle),
        has_uv(light.has_uv),
        own_coordinates(light.own_coordinates) {}
};

/// Data of the scene that a program may need. All of it is optional.
struct ShaderContext {
  const CameraDescription* camera = nullptr;  ///< for camera and window coordinates, and the size of pixels
  int image_width = 0;                        ///< pixels of the full frame
  bool* sees_camera = nullptr;                ///< set to true if the program depends on the camera
  const LampSpace* lamp = nullptr;            ///< only for the shader of a lamp
  std::string user;                           ///< an object that shows the material, for messages
  DisplacementMethod displacement_method = DisplacementMethod::Bump;
  int material_pass_index = 0;                                  ///< value of Object Info > Material Index
  bool reflective_caustics = true, refractive_caustics = true;  ///< switches of RenderSettings
  const std::set<std::string>* grids = nullptr;                 ///< names of all grids in the scene
  BumpTerminator bump_terminator = BumpTerminator::Cubic;
  bool takes_means =
      false;  ///< images with levels are read over the footprint of a pixel: for surfaces that a camera sees
  /// From linear Rec. 709 to the working space.
  Mat3 working_from_rec709{1.0f};
  bool has_grid(const std::string& name) const { return grids && grids->contains(name); }
  bool works_in_rec709() const { return working_from_rec709 == Mat3(1.0f); }
};

}  // namespace ajar
