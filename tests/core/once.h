// References that several tests of one scene share.
#pragma once

#include <map>
#include <vector>

#include "description/archive.h"

namespace ajar::fixtures {

/// The result of `make`, which is called once for each scene in the process. Each lambda expression has its own results.
template <typename Make>
const auto& once(const SceneDescription& d, const Make& make) {
  static std::map<std::vector<char>, decltype(make())> known;
  const std::vector<char> key = to_bytes(d);
  const auto found = known.find(key);
  return found != known.end() ? found->second : known.emplace(key, make()).first->second;
}

}  // namespace ajar::fixtures
