// Adaptive subdivision: the faces of a mesh, and what the division into triangles follows.
#include <set>

#include "arrays.h"
#include "bind.h"
#include "description/scene_description.h"

namespace ajar::python {
namespace {

template <class Element, class T>
std::vector<Element> read(const py::dict& values, const char* name, const std::string& mesh) {
  return values.contains(name)
             ? copy_rows<Element>(values[name].cast<Array<T>>(), std::string(name) + " of mesh \"" + mesh + "\"")
             : std::vector<Element>();
}

void set_subdivision(MeshDescription& mesh, SubdivisionScheme scheme, const Array<uint32_t>& face_sizes,
                     const Array<uint32_t>& corner_vertices, const py::kwargs& more) {
  const std::string of = " of mesh \"" + mesh.name + "\"";
  SubdivisionDescription s;
  s.scheme = scheme;
  s.face_sizes = copy_rows<uint32_t>(face_sizes, "face_sizes" + of);
  s.corner_vertices = copy_rows<uint32_t>(corner_vertices, "corner_vertices" + of);
  for (const auto& [name, value] : more) {
    static const std::set<std::string> known = {
        "flat_faces",   "creased_edges", "edge_sharpness", "creased_vertices", "vertex_sharpness",
        "keep_corners", "uv_smoothing",  "in_pixels",      "edge_length",      "tangents"};
    if (!known.contains(name.cast<std::string>()))
      throw py::type_error("set_subdivision has no argument \"" + name.cast<std::string>() + "\"");
  }
  s.flat_faces = read<uint8_t, uint8_t>(more, "flat_faces", mesh.name);
  s.creased_edges = read<std::array<uint32_t, 2>, uint32_t>(more, "creased_edges", mesh.name);
  s.edge_sharpness = read<float, float>(more, "edge_sharpness", mesh.name);
  s.creased_vertices = read<uint32_t, uint32_t>(more, "creased_vertices", mesh.name);
  s.vertex_sharpness = read<float, float>(more, "vertex_sharpness", mesh.name);
  if (more.contains("keep_corners")) s.keep_corners = more["keep_corners"].cast<bool>();
  if (more.contains("uv_smoothing")) s.uv_smoothing = more["uv_smoothing"].cast<UvSmoothing>();
  if (more.contains("in_pixels")) s.in_pixels = more["in_pixels"].cast<bool>();
  if (more.contains("edge_length")) s.edge_length = more["edge_length"].cast<float>();
  if (more.contains("tangents")) s.tangents = more["tangents"].cast<std::vector<std::string>>();
  mesh.subdivision = std::move(s);
}

}  // namespace

py::object subdivision_of(const MeshDescription& mesh) {
  const SubdivisionDescription& s = mesh.subdivision;
  if (s.empty()) return py::none();
  py::dict d;
  d["scheme"] = s.scheme;
  d["face_sizes"] = to_array<uint32_t>(s.face_sizes);
  d["corner_vertices"] = to_array<uint32_t>(s.corner_vertices);
  d["flat_faces"] = to_array<uint8_t>(s.flat_faces);
  d["creased_edges"] = to_array<uint32_t>(s.creased_edges);
  d["edge_sharpness"] = to_array<float>(s.edge_sharpness);
  d["creased_vertices"] = to_array<uint32_t>(s.creased_vertices);
  d["vertex_sharpness"] = to_array<float>(s.vertex_sharpness);
  d["keep_corners"] = s.keep_corners;
  d["uv_smoothing"] = s.uv_smoothing;
  d["in_pixels"] = s.in_pixels;
  d["edge_length"] = s.edge_length;
  d["tangents"] = s.tangents;
  return d;
}

void bind_subdivision(py::module_& module) {
  py::enum_<SubdivisionScheme>(module, "SubdivisionScheme", "The surface that adaptive subdivision divides.")
      .value("None_", SubdivisionScheme::None, "The mesh is not subdivided.")
      .value("CatmullClark", SubdivisionScheme::CatmullClark, "The smooth surface of Catmull and Clark.")
      .value("Simple", SubdivisionScheme::Simple, "The faces as they are.");
  py::enum_<UvSmoothing>(module, "UvSmoothing", "What stays sharp when a UV map becomes smooth with the surface.")
      .value("None_", UvSmoothing::None, "Everything: the map is not smooth.")
      .value("KeepCorners", UvSmoothing::KeepCorners, "Corners.")
      .value("KeepCornersAndJunctions", UvSmoothing::KeepCornersAndJunctions, "Corners and junctions.")
      .value("KeepCornersJunctionsAndConcave", UvSmoothing::KeepCornersJunctionsAndConcave,
             "Corners, junctions, darts and concave corners.")
      .value("KeepBoundaries", UvSmoothing::KeepBoundaries, "Boundaries.")
      .value("All", UvSmoothing::All, "Nothing.");
  py::class_<DicingDescription>(module, "DicingDescription", "What adaptive subdivision of all meshes follows.")
      .def_readwrite("camera", &DicingDescription::camera,
                     "CameraDescription. The camera whose pixels count. If it is not present, that of the scene.")
      .def_readwrite("offscreen_scale", &DicingDescription::offscreen_scale,
                     "float, >= 1. How much coarser surfaces become with the distance from the field of view.")
      .def_readwrite("max_subdivisions", &DicingDescription::max_subdivisions,
                     "int, 0 to 16. An edge of a face has at most 2^max_subdivisions pieces.");
  module.def("set_subdivision", &set_subdivision, py::arg("mesh"), py::arg("scheme"), py::arg("face_sizes"),
             py::arg("corner_vertices"),
             "Give a mesh without triangles faces, which are divided into triangles when the scene is built. Its data "
             "per triangle are then per face, and its corners are those of the faces. mesh: a MeshDescription of "
             "`make_mesh`. scheme: SubdivisionScheme. face_sizes: uint32[f], the number of corners of each face. "
             "corner_vertices: uint32[c], the vertex of each corner, counter-clockwise. More arguments by name: "
             "flat_faces: uint8[f], 1 for faces that are shaded flat. creased_edges: uint32[e, 2], the vertices of "
             "sharp edges, and edge_sharpness: float32[e], 0 to 10. creased_vertices: uint32[v], and vertex_sharpness: "
             "float32[v]. keep_corners: bool, whether a vertex with one face is sharp. uv_smoothing: UvSmoothing. "
             "in_pixels: bool, whether edge_length: float, the length of the edges of the triangles, is in pixels and "
             "not in object space. tangents: list of str, the names of attributes for smooth tangents of the "
             "triangles.");
}

}  // namespace ajar::python
