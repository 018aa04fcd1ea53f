// Node graphs and materials. The form of a graph: docs/developer/node_contract.md.
#include "bind.h"
#include "casters.h"
#include "description/scene_description.h"

namespace ajar::python {

namespace py = pybind11;

void bind_shader_graph(py::module_& module) {
  py::class_<NodeLink>(module, "NodeLink", "An output socket of a node, by index and identifier.")
      .def(py::init([](int node, std::string socket) { return NodeLink{node, std::move(socket)}; }),
           py::arg("node") = -1, py::arg("socket") = "")
      .def_readwrite("node", &NodeLink::node)
      .def_readwrite("socket", &NodeLink::socket);

  py::class_<NodeInput>(module, "NodeInput")
      .def_readwrite("socket", &NodeInput::socket)
      .def_readwrite("link", &NodeInput::link)
      .def_readwrite("value", &NodeInput::value);

  py::class_<NodeProperty>(module, "NodeProperty")
      .def_readwrite("name", &NodeProperty::name)
      .def_readwrite("text", &NodeProperty::text)
      .def_readwrite("numbers", &NodeProperty::numbers);

  py::class_<Node>(module, "Node")
      .def_readwrite("type", &Node::type)
      .def_readwrite("name", &Node::name)
      .def_readonly("inputs", &Node::inputs)
      .def_readonly("properties", &Node::properties);

  py::class_<NodeGraph>(module, "NodeGraph")
      .def(py::init<>())
      .def_readonly("nodes", &NodeGraph::nodes, "Copies of the nodes.")
      .def_readwrite("surface", &NodeGraph::surface)
      .def_readwrite("volume", &NodeGraph::volume)
      .def_readwrite("displacement", &NodeGraph::displacement)
      .def(
          "add_node",
          [](NodeGraph& graph, std::string type, std::string name) {
            graph.nodes.push_back({std::move(type), std::move(name), {}, {}});
            return graph.nodes.size() - 1;
          },
          py::arg("type"), py::arg("name"), "Add a node; returns its index.")
      .def(
          "add_input",
          [](NodeGraph& graph, size_t node, std::string socket, Vec4 value, const NodeLink& link) {
            graph.nodes.at(node).inputs.push_back({std::move(socket), link, value});
          },
          py::arg("node"), py::arg("socket"), py::arg("value") = Vec4(0.0f), py::arg("link") = NodeLink{})
      .def(
          "add_property",
          [](NodeGraph& graph, size_t node, std::string name, std::string text, std::vector<float> numbers) {
            graph.nodes.at(node).properties.push_back({std::move(name), std::move(text), std::move(numbers)});
          },
          py::arg("node"), py::arg("name"), py::arg("text") = "", py::arg("numbers") = std::vector<float>{});

  py::class_<MaterialDescription>(module, "MaterialDescription")
      .def_readwrite("name", &MaterialDescription::name)
      .def_readwrite("graph", &MaterialDescription::graph)
      .def_readwrite("pass_index", &MaterialDescription::pass_index);
}

}  // namespace ajar::python
