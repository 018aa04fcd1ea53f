// The Python module `_ajar`; the package `ajar` re-exports it.
//
// Python never holds a pointer into the arrays of a description: values that it reads are copies, and values that it
// passes are copied once. Calls that can take long release the interpreter lock. Nothing in the core calls Python.
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

py::array_t<float> take_array(std::vector<float>&& values, const std::vector<size_t>& shape) {
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
  module.doc() =
      "Ajar's renderer: scene descriptions, sessions, images.\n\n"
      "Arrays are NumPy arrays. Arguments are copied once, and results are copies. Arrays of another type are "
      "converted. Calls that take long release the interpreter lock.\n\n"
      "Constants: `VISIBLE_CAMERA`, `VISIBLE_DIFFUSE`, `VISIBLE_GLOSSY`, `VISIBLE_TRANSMISSION`, "
      "`VISIBLE_VOLUME_SCATTER`, `VISIBLE_SHADOW` and their sum `VISIBLE_ALL` are the bits of `visibility`: the kinds "
      "of ray that see an object. `RECEIVER_SETS` and `BLOCKER_SETS` are the numbers of sets of objects for light "
      "linking and for shadow linking. Six constants are names of attributes of a mesh: `UNDEFORMED_POSITION` for the "
      "positions before modifiers (Domain.Vertex, 3 components), `POSITION_BEFORE` and `POSITION_AFTER` for those one "
      "frame before and after (likewise), `FLAT_FACES` for the faces of a mesh with normals of "
      "corners that stay flat when they are displaced (Domain.Face, 1 "
      "component, 0 or 1), `RANDOM_PER_ISLAND` for results of "
      "`random_per_island` (Domain.Face, 1 component) and `POINTINESS` for results of `pointiness` (Domain.Vertex, 1 "
      "component). `TANGENT_OF` begins the names of attributes for results of `uv_tangents`. `version` and "
      "`__version__` are the version of Ajar, `instruction_set` is the instruction set that "
      "the module was compiled for.";
  module.attr("__version__") = AJAR_VERSION;
  module.attr("version") = AJAR_VERSION;
  module.attr("instruction_set") = AJAR_ARCH;
  module.def("library_versions", &ajar::python::library_versions,
             "Return a dict from the name of each library to the version that is loaded at run time.");
  // All exceptions are RuntimeErrors with the text of the core, which names the artist's object.
  py::register_exception<ajar::SceneError>(module, "SceneError", PyExc_RuntimeError)
      .doc() = "A scene, a file or a setting cannot be used. The message names the object.";
  py::register_exception<ajar::Cancelled>(module, "Cancelled", PyExc_RuntimeError)
      .doc() = "An operation was cancelled.";
  ajar::python::bind_shader_graph(module);
  ajar::python::bind_description(module);
  ajar::python::bind_session(module);
  ajar::python::bind_image(module);
  ajar::python::bind_denoise(module);
}
