#include "statistical.h"

#include <boost/math/special_functions/beta.hpp>
#include <boost/math/special_functions/gamma.hpp>

namespace ajar::statistical {

double chi_square_p_value(double statistic, double degrees_of_freedom) {
  return boost::math::gamma_q(0.5 * degrees_of_freedom, 0.5 * std::max(0.0, statistic));
}

double student_p_value(double t, double degrees_of_freedom) {
  return boost::math::ibeta(0.5 * degrees_of_freedom, 0.5, degrees_of_freedom / (degrees_of_freedom + t * t));
}

}  // namespace ajar::statistical
