// Converts between NumPy arrays and the vectors of a description, with a check of the shape and one copy.
#pragma once

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "casters.h"

namespace ajar::python {

namespace py = pybind11;

template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;
using Floats = Array<float>;

/// Text such as "float32[n, 3]", for messages.
std::string shape_text(const py::array& array);

/// Returns n. Throws ValueError unless `array` is [n, columns] or a flat array of n * columns numbers.
template <typename T>
size_t check_rows(const Array<T>& array, size_t columns, const std::string& what) {
  const bool flat = array.ndim() == 1 && array.size() % columns == 0;
  const bool rows = array.ndim() == 2 && size_t(array.shape(1)) == columns;
  // An empty list arrives as [0].
  if (!flat && !rows && array.size() != 0)
    throw py::value_error(what + " must be an array [n, " + std::to_string(columns) + "], not " + shape_text(array));
  return array.size() / columns;
}

/// The elements of `array` as vectors of `Element`, copied without the interpreter lock.
template <typename Element, typename T>
std::vector<Element> copy_rows(const Array<T>& array, const std::string& what) {
  constexpr size_t columns = sizeof(Element) / sizeof(T);
  const size_t rows = check_rows(array, columns, what);
  const T* source = array.data();
  py::gil_scoped_release release;
  const auto* first = reinterpret_cast<const Element*>(source);
  return std::vector<Element>(first, first + rows);
}

/// All numbers of `array`, which can have any shape.
inline std::vector<float> copy_numbers(const Floats& array) {
  const float* first = array.data();
  const size_t count = array.size();
  py::gil_scoped_release release;
  return std::vector<float>(first, first + count);
}

/// A new array [rows, columns] (or [rows] for columns 1) with a copy of `values`.
template <typename T, typename Element>
py::array_t<T> to_array(const std::vector<Element>& values, size_t columns = sizeof(Element) / sizeof(T)) {
  const size_t count = values.size() * sizeof(Element) / sizeof(T);
  std::vector<size_t> shape{count / columns};
  if (columns > 1) shape.push_back(columns);
  py::array_t<T> result(shape);
  std::memcpy(result.mutable_data(), values.data(), count * sizeof(T));
  return result;
}

/// An array that owns `values`, without a copy.
py::array_t<float> take_array(std::vector<float>&& values, const std::vector<size_t>& shape);

}  // namespace ajar::python
