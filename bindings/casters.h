// GLM vectors in Python: results are tuples, arguments are any sequences of numbers.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "math/types.h"

namespace pybind11::detail {

template <int N>
struct type_caster<glm::vec<N, float, glm::defaultp>> {
  using Vector = glm::vec<N, float, glm::defaultp>;
  PYBIND11_TYPE_CASTER(Vector, const_name("Sequence[float]"));

  bool load(handle source, bool) {
    if (!PySequence_Check(source.ptr()) || PySequence_Size(source.ptr()) != N) {
      PyErr_Clear();
      return false;
    }
    for (int i = 0; i < N; ++i) {
      const object item = reinterpret_steal<object>(PySequence_GetItem(source.ptr(), i));
      const double number = item ? PyFloat_AsDouble(item.ptr()) : -1.0;
      if (PyErr_Occurred()) {
        PyErr_Clear();
        return false;
      }
      value[i] = static_cast<float>(number);
    }
    return true;
  }

  static handle cast(const Vector& vector, return_value_policy, handle) {
    tuple result(N);
    for (int i = 0; i < N; ++i) result[i] = float_(vector[i]);
    return result.release();
  }
};

}  // namespace pybind11::detail
