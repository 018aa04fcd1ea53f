#include "transport/direct/estimators/make_estimator.h"

#include "transport/direct/estimators/fixed_shares.h"
#include "transport/direct/estimators/ocv.h"
#include "transport/direct/estimators/ocv_progressive.h"
#include "transport/direct/estimators/pmc_hi.h"
#include "transport/direct/estimators/pmc_hi_paper.h"
#include "transport/direct/estimators/ris.h"

namespace ajar {

std::unique_ptr<DirectEstimator> make_direct_estimator(const Scene& scene, DirectMethod method,
                                                       const DirectRequest& request) {
  switch (method) {
    case DirectMethod::Ris: return std::make_unique<Ris>(scene, request);
    case DirectMethod::PmcHi: return std::make_unique<PmcHi>(scene, request);
    case DirectMethod::PmcHiPaper: return std::make_unique<PmcHiPaper>(scene, request);
    case DirectMethod::Correlated:
    case DirectMethod::Ocv:
    case DirectMethod::OcvPaper: return std::make_unique<Ocv>(scene, method, request);
    case DirectMethod::OcvProgressive: return std::make_unique<OcvProgressive>(scene, request);
    case DirectMethod::Mis:
    case DirectMethod::MisBalance:
    case DirectMethod::Bsdf:
    case DirectMethod::Light: break;
  }
  return std::make_unique<FixedShares>(scene, method, request);
}

}  // namespace ajar
