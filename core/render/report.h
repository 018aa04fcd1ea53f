// The statistics of a render as JSON text: all values of `--ajar-stats`.
#pragma once

#include <string>

#include "render/session_state.h"

namespace ajar {

std::string statistics_json(const SessionState& state);

}  // namespace ajar
