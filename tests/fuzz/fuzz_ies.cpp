// Interprets arbitrary bytes as an IES file. It is refused with a message, or its values are finite in all directions.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "shading/functions/ies.h"

using namespace ajar;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string error;
  const nodes::IesProfile profile = nodes::IesProfile::read({reinterpret_cast<const char*>(data), size}, error);
  if (profile.empty() != !error.empty()) std::abort();
  if (profile.empty()) return 0;
  for (const Vec3 direction :
       {Vec3(0, 0, -1), Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0.3f, -0.7f, 0.1f), Vec3(0.0f), Vec3(1e30f)})
    if (std::isnan(profile.towards(direction))) std::abort();
  return 0;
}
