#include "shading/nodes/curve_tables.h"

namespace ajar::nodes {
namespace {

bool add_table(ProgramBuilder& b, int node, std::string_view property, CurveTable table, uint32_t& index) {
  if (const auto found = b.node_data.find(node); found != b.node_data.end()) return index = found->second, true;
  const std::vector<float>* numbers = b.numbers(node, property);
  if (!numbers || numbers->size() < 8) {
    b.report(node, "has no " + std::string(property) + " data; its input is used");
    return false;
  }
  const auto at = [&](size_t i) { return std::isfinite((*numbers)[i]) ? (*numbers)[i] : 0.0f; };
  table.values.reserve(numbers->size() / 4);
  for (size_t i = 0; i + 3 < numbers->size(); i += 4) table.values.emplace_back(at(i), at(i + 1), at(i + 2), at(i + 3));
  b.tables.curves.push_back(std::move(table));
  index = b.node_data[node] = uint32_t(b.tables.curves.size() - 1);
  return true;
}

}  // namespace

bool ramp_table(ProgramBuilder& b, int node, uint32_t& index) {
  CurveTable table;
  table.interpolate = b.text(node, "ramp_interpolation") != "CONSTANT" && b.text(node, "interpolation") != "CONSTANT";
  return add_table(b, node, "ramp", std::move(table), index);
}

bool curve_table(ProgramBuilder& b, int node, uint32_t& index) {
  CurveTable table;
  const std::vector<float>* range = b.numbers(node, "curve_range");
  if (range && range->size() >= 2 && (*range)[1] > (*range)[0] && std::isfinite((*range)[1] - (*range)[0]))
    table.min = (*range)[0], table.max = (*range)[1];
  table.extrapolate = b.number(node, "curve_extrapolate") != 0.0f;
  return add_table(b, node, "curve", std::move(table), index);
}

}  // namespace ajar::nodes
