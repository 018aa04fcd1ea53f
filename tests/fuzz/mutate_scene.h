// Changes one property of a scene. Random changes of bytes rarely reach most properties, since most bytes of a file are
// vertices and names.
#pragma once

#include <random>

#include "description/scene_description.h"

namespace ajar::fuzz {

using Random = std::minstd_rand;

void mutate(SceneDescription& description, Random& random);

}  // namespace ajar::fuzz
