// Which methods for direct light there are.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace ajar {

enum class DirectMethod : uint8_t {
  Mis,
  MisBalance,
  Bsdf,
  Light,
  Ris,
  Correlated,
  PmcHi,
  PmcHiPaper,
  Ocv,
  OcvPaper,
  OcvProgressive
};

struct DirectMethodInfo {
  DirectMethod method;
  const char* name;
  const char* label;  ///< in the UI
  bool biased;
  const char* sentence;  ///< one sentence for the artist
};
/// The one list of methods, in the order of the UI.
const std::vector<DirectMethodInfo>& direct_method_list();
/// Throws SceneError naming the valid ones.
const DirectMethodInfo& find_direct_method(const std::string& name);
const DirectMethodInfo& find_direct_method(DirectMethod method);

}  // namespace ajar
