// Node graphs and materials. docs/developer/node_contract.md defines the form of a graph.
#include "bind.h"
#include "casters.h"
#include "description/scene_description.h"

namespace ajar::python {

namespace py = pybind11;

namespace {

void bind_materials(py::module_& module) {
  py::enum_<DisplacementMethod>(module, "DisplacementMethod", "What the displacement of a material does.")
      .value("Bump", DisplacementMethod::Bump, "It bends the shading normals.")
      .value("Displacement", DisplacementMethod::Displacement, "It moves the vertices.")
      .value("Both", DisplacementMethod::Both,
             "It moves the vertices, and bends the normals that the surface had before.");
  py::class_<MaterialDescription>(module, "MaterialDescription", "A material: a shader graph with a name.")
      .def_readwrite("name", &MaterialDescription::name, "str. The name in Blender, used in messages.")
      .def_readwrite("graph", &MaterialDescription::graph, "NodeGraph. The shader.")
      .def_readwrite("pass_index", &MaterialDescription::pass_index,
                     "int. The value of the pass IndexMA and of Object Info > Material Index.")
      .def_readwrite("displacement_method", &MaterialDescription::displacement_method,
                     "DisplacementMethod. What the displacement of the graph does.");
}

}  // namespace

void bind_shader_graph(py::module_& module) {
  py::class_<NodeLink>(module, "NodeLink",
                       "An output socket of a node, by the index of the node and the identifier of the socket.")
      .def(py::init([](int node, std::string socket) {
             return NodeLink{node, std::move(socket)};
           }),
           py::arg("node") = -1, py::arg("socket") = "",
           "Make a link to an output socket. Without arguments nothing is linked.")
      .def_readwrite("node", &NodeLink::node,
                     "int. The index of the node in the graph. -1 means that nothing is linked.")
      .def_readwrite("socket", &NodeLink::socket, "str. The identifier of the output socket.");

  py::class_<NodeInput>(module, "NodeInput", "An input socket of a node.")
      .def_readwrite("socket", &NodeInput::socket, "str. The identifier of the input socket.")
      .def_readwrite("link", &NodeInput::link, "NodeLink. The socket that is linked to the input.")
      .def_readwrite("value", &NodeInput::value,
                     "tuple of 4 floats. The value if nothing is linked: a number in x, a vector in xyz, a linear "
                     "colour in xyzw.");

  py::class_<NodeProperty>(module, "NodeProperty", "A setting of a node that is not a socket.")
      .def_readwrite("name", &NodeProperty::name, "str. The RNA identifier of the property.")
      .def_readwrite("text", &NodeProperty::text, "str. The value of an enum or a path.")
      .def_readwrite("numbers", &NodeProperty::numbers, "list of floats. The value of numbers and of baked curves.");

  py::class_<Node>(module, "Node", "A node of a graph.")
      .def_readwrite("type", &Node::type, "str. Blender's bl_idname, such as \"ShaderNodeEmission\".")
      .def_readwrite("name", &Node::name, "str. The name of the node, used in messages.")
      .def_readonly("inputs", &Node::inputs, "list of NodeInput. Copies of the inputs.")
      .def_readonly("properties", &Node::properties,
                    "list of NodeProperty. Copies of the properties that are not sockets.");

  py::class_<NodeGraph>(module, "NodeGraph", "A shader graph. The form of a graph: docs/developer/node_contract.md.")
      .def(py::init<>(), "Make one with default values.")
      .def_readonly("nodes", &NodeGraph::nodes, "list of Node. Copies of the nodes.")
      .def_readwrite("surface", &NodeGraph::surface,
                     "NodeLink. The socket that is linked to the Surface input of the active output node. A node index "
                     "of -1 means that nothing is linked.")
      .def_readwrite("volume", &NodeGraph::volume,
                     "NodeLink. The socket that is linked to the Volume input of the active output node. A node index "
                     "of -1 means that nothing is linked.")
      .def_readwrite("displacement", &NodeGraph::displacement,
                     "NodeLink. The socket that is linked to the Displacement input of the active output node. A node "
                     "index of -1 means that nothing is linked.")
      .def(
          "add_node",
          [](NodeGraph& graph, std::string type, std::string name) {
            graph.nodes.push_back({std::move(type), std::move(name), {}, {}});
            return graph.nodes.size() - 1;
          },
          py::arg("type"), py::arg("name"),
          "Add a node and return its index. type: Blender's bl_idname. name: the name for messages.")
      .def(
          "add_input",
          [](NodeGraph& graph, size_t node, std::string socket, Vec4 value, const NodeLink& link) {
            graph.nodes.at(node).inputs.push_back({std::move(socket), link, value});
          },
          py::arg("node"), py::arg("socket"), py::arg("value") = Vec4(0.0f), py::arg("link") = NodeLink{},
          "Add an input socket to a node. node: an index from add_node. socket: the identifier of the input. value: "
          "four floats that are used if link is not set. Raises IndexError for a node that does not exist.")
      .def(
          "add_property",
          [](NodeGraph& graph, size_t node, std::string name, std::string text, std::vector<float> numbers) {
            graph.nodes.at(node).properties.push_back({std::move(name), std::move(text), std::move(numbers)});
          },
          py::arg("node"), py::arg("name"), py::arg("text") = "", py::arg("numbers") = std::vector<float>{},
          "Add a setting to a node. node: an index from add_node. name: the RNA identifier. text: an enum or a path. "
          "numbers: floats. Raises IndexError for a node that does not exist.");

  bind_materials(module);
}

}  // namespace ajar::python
