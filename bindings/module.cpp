// The Python module `_ajar`; the package `ajar` re-exports it.
//
// Python never holds a pointer into a description's arrays: what it reads is copied, what it
// gives is copied once. Calls that may take long release the interpreter lock; nothing in the core calls Python.
#include "arrays.h"
#include "bind.h"
#include "film/image_io.h"
#include "scene/accel.h"
#include "scene/scene.h"

namespace ajar::python {

std::string shape_text(const py::array& array) {
  std::string text = py::str(array.dtype()).cast<std::string>() + "[";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i ? ", " : "") + std::to_string(array.shape(i));
  return text + "]";
}

py::array_t<float> take_array(std::vector<float>&& values, std::vector<size_t> shape) {
  auto* owned = new std::vector<float>(std::move(values));
  py::capsule owner(owned, [](void* pointer) { delete static_cast<std::vector<float>*>(pointer); });
  return py::array_t<float>(shape, owned->data(), owner);
}

static std::map<std::string, std::string> library_versions() {
  return {{"Embree", embree_version()}, {"TBB", tbb_version()}, {"OpenImageIO", openimageio_version()}};
}

}  // namespace ajar::python

PYBIND11_MODULE(_ajar, module) {
  namespace py = pybind11;
  module.doc() = "Ajar's renderer: scene descriptions, sessions, images.";
  module.attr("__version__") = AJAR_VERSION;
  module.attr("version") = AJAR_VERSION;
  module.attr("instruction_set") = AJAR_ARCH;
  module.def("library_versions", &ajar::python::library_versions, "What the module found at run time: name to version.");
  // All are RuntimeError with the core's own text, which names the artist's object.
  py::register_exception<ajar::SceneError>(module, "SceneError", PyExc_RuntimeError);
  py::register_exception<ajar::Cancelled>(module, "Cancelled", PyExc_RuntimeError);
  ajar::python::bind_shader_graph(module);
  ajar::python::bind_description(module);
  ajar::python::bind_session(module);
  ajar::python::bind_image(module);
}
