// A scene with one thing about it changed: what random bytes in a file, most of which are of vertices and names, seldom
// reach.
#pragma once

#include <random>

#include "description/scene_description.h"

namespace ajar::fuzz {

using Random = std::minstd_rand;

void mutate(SceneDescription& description, Random& random);

}  // namespace ajar::fuzz
