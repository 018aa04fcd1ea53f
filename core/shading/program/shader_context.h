// What the compiler of shader graphs is told about the scene around a graph.
#pragma once

#include <array>

#include "description/scene_description.h"

namespace ajar {

/// What a program may need of the scene around it. All of it is optional.
struct ShaderContext {
  const CameraDescription* camera = nullptr;  ///< for camera and window coordinates, and the size of pixels
  int image_width = 0;                        ///< pixels of the full frame
  bool* sees_camera = nullptr;                ///< set when the program depends on the camera
  const std::array<float, 12>* world_from_lamp = nullptr;       ///< when it is a lamp's
  int material_pass_index = 0;                                  ///< Object Info > Material Index
  bool reflective_caustics = true, refractive_caustics = true;  ///< RenderSettings' switches
  BumpTerminator bump_terminator = BumpTerminator::Cubic;
};

}  // namespace ajar
