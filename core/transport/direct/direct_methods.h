// The list of the methods for direct light.
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
  const char* label;  ///< name in the UI
  bool biased;
  const char* sentence;  ///< one sentence, shown to the artist
};
/// The list of methods, in the order of the UI.
const std::vector<DirectMethodInfo>& direct_method_list();
/// Throws SceneError with the valid names if the name is unknown.
const DirectMethodInfo& find_direct_method(const std::string& name);
const DirectMethodInfo& find_direct_method(DirectMethod method);

}  // namespace ajar
