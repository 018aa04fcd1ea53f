// Makes the estimator of a method for direct light.
#pragma once

#include <memory>

#include "transport/direct/direct_estimator.h"

namespace ajar {

std::unique_ptr<DirectEstimator> make_direct_estimator(const Scene& scene, DirectMethod method,
                                                       const DirectRequest& request);

}  // namespace ajar
