// A finer picture from a coarse one: light of the coarse picture on the surfaces of the fine one.
//
// A fine pixel takes the light of coarse pixels around it that see a similar surface, by normal and albedo. Light is the
// colour over the albedo, so that textures are as sharp as the fine guides [joint bilateral upsampling, Kopf et al. 2007].
// Borders of shadows stay as coarse as they are.
#pragma once

#include <vector>

#include "view/view_pictures.h"

namespace ajar {

/// A picture and its guides, over the region of `size`.
struct GuidedPicture {
  const std::vector<float>& albedo;  ///< RGB
  const std::vector<float>& normal;  ///< XYZ
  const ViewSize& size;
};

/// `rgba`: the coarse picture. Returns the fine one, RGBA.
std::vector<float> with_surfaces(const std::vector<float>& rgba, const GuidedPicture& coarse,
                                 const GuidedPicture& fine);

}  // namespace ajar
