// The parts of the module; each binds one header of the core.
#pragma once

#include <pybind11/pybind11.h>

namespace ajar {
struct MeshDescription;
}

namespace ajar::python {

void bind_shader_graph(pybind11::module_& module);
void bind_description(pybind11::module_& module);
/// RenderSettings. bind_description calls it, because the settings need its enums and the description needs them.
void bind_settings(pybind11::module_& module);
/// Adaptive subdivision. bind_description calls it, because it needs the cameras.
void bind_subdivision(pybind11::module_& module);
/// The arguments of set_subdivision as a dict, or None.
pybind11::object subdivision_of(const MeshDescription& mesh);
void bind_session(pybind11::module_& module);
void bind_image(pybind11::module_& module);
void bind_denoise(pybind11::module_& module);

}  // namespace ajar::python
