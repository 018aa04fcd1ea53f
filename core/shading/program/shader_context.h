// What the compiler of a shader graph knows about the scene.
#pragma once

#include <array>

#include "description/scene_description.h"

namespace ajar {

/// Data of the scene that a program may need. All of it is optional.
struct ShaderContext {
  const CameraDescription* camera = nullptr;  ///< for camera and window coordinates, and the size of pixels
  int image_width = 0;                        ///< pixels of the full frame
  bool* sees_camera = nullptr;                ///< set to true if the program depends on the camera
  const std::array<float, 12>* world_from_lamp = nullptr;       ///< only for the shader of a lamp
  int material_pass_index = 0;                                  ///< value of Object Info > Material Index
  bool reflective_caustics = true, refractive_caustics = true;  ///< switches of RenderSettings
  BumpTerminator bump_terminator = BumpTerminator::Cubic;
};

}  // namespace ajar
