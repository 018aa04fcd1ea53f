#include "transport/hints/hint_shares.h"

#include <array>

namespace ajar {

double pdf_of_hint(const LightSet& lights, const Hints::Hint& hint, const Path& path, int end) {
  if (int(hint.vertices.size()) != end || path.vertices[0].distant || path.vertices[0].light < 0) return 0.0;
  std::array<Hints::PathPoint, kMaxPathVertices> points;
  for (int i = 0; i < end; ++i) {
    const bool specular = i > 0 && !path.joinable(i);
    points[size_t(i)] = {path.vertices[size_t(i)].position(), specular, specular && path.transmits(i)};
  }
  const PathVertex& light = path.vertices[0];
  double pdf = Hints::pdf(hint, uint32_t(light.light), lights.flags(uint32_t(light.light)).type, light.point.ng,
                          {points.data(), size_t(end)});
  if (!(pdf > 0.0)) return 0.0;
  pdf *= path.light.pdf_by_power;
  for (int i = 1; i < end; ++i) {
    pdf *= path.light_step(i);
    if (i + 1 < end && points[size_t(i)].specular) pdf *= path.scattering[size_t(i)].follow_to_eye;
  }
  return pdf;
}

void add_hint_shares(const LightSet& lights, const Hints& hints, const Path& path, double weight,
                     std::vector<double>& sums) {
  const int ends[2] = {first_joinable_from_eye(path), path.count - 1};
  std::array<uint32_t, 16> able;
  size_t count = 0;
  for (uint32_t i = 0; i < hints.size() && count < able.size(); ++i) {
    const int end = int(hints[i].vertices.size());
    if ((end == ends[0] || end == ends[1]) && pdf_of_hint(lights, hints[i], path, end) > 0.0) able[count++] = i;
  }
  for (size_t k = 0; k < count; ++k) sums[able[k]] += weight / double(count);
}

}  // namespace ajar
