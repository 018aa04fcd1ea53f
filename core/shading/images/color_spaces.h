// Colour spaces of images and the working space of a scene, by its OpenColorIO configuration.
//
// As in Cycles, an image in sRGB keeps its encoding and is decoded after interpolation, if the working space has the
// primaries of Rec. 709. Values in other spaces are converted to the working space when the image is decoded.
#pragma once

#include <memory>
#include <string>

#include "description/scene_description.h"

namespace ajar {

enum class ColorEncoding : uint8_t {
  Data,     ///< no colours
  Working,  ///< colours of the working space
  Srgb,     ///< colours of the working space, with the curve of sRGB
  Other     ///< to be converted by `ColorSpaces::convert`
};

class ColorSpaces {
 public:
  explicit ColorSpaces(const ColorDescription& description = {});
  ColorSpaces(ColorSpaces&&) noexcept;
  ColorSpaces& operator=(ColorSpaces&&) noexcept;
  ~ColorSpaces();

  const ColorDescription& description() const;
  /// The encoding of colour space `name`; an empty name is the default for images of integers or floats. If the space
  /// is not known, `problem` says so, and a similar encoding is returned.
  ColorEncoding encoding(const std::string& name, bool is_float, std::string& problem);
  /// Converts colours with straight alpha from the colour space, whose encoding is Other, to the working space.
  void convert(const std::string& name, float* rgba, int64_t count);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// The matrix from linear Rec. 709 to the working space. The identity if they are equal, or if the space is not known.
Mat3 working_from_rec709(const ColorDescription& description);

}  // namespace ajar
