#include "transport/chains/mutations/hint_mutation.h"

#include <algorithm>

#include "transport/chains/mutations/regrow.h"

namespace ajar {

namespace {

/// Ratio of the probabilities of growing n + 1 and n vertices.
constexpr double kLonger = 0.65;

}  // namespace

float HintMutation::lens_probability(const Hints::Hint& hint, bool has_joinable) const {
  if (!space_.to_lens || (hint.vertices.size() <= 2 && space_.without_direct)) return 0.0f;  // the latter: direct light
  return has_joinable ? 0.5f : 1.0f;
}

bool HintMutation::sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const {
  const float u = sampler.get_1d();
  if (u < hint_probability_) return sample_hint(from, sampler, to, rays);
  return u < hint_probability_ + regrow_probability_ ? regrow(from, sampler, to, rays)
                                                     : bidirectional_.sample(from, sampler, to, rays);
}

bool HintMutation::sample_hint(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const {
  const Scene& scene = space_.scene;
  const uint32_t index = hints_.choose(sampler.get_1d());
  const Hints::Hint& hint = hints_[index];
  to.hint = int(index);
  const int joint = first_joinable_from_eye(from), end = int(hint.vertices.size());
  const bool to_lens = sampler.get_1d() < lens_probability(hint, joint > 0);
  if (joint <= 0 && !to_lens) return false;
  // Copy the kept vertices.
  const int kept = to_lens ? 1 : from.count - joint;
  to.count = end + kept;
  if (to.count > space_.max_vertices) return false;
  to.film = from.film;
  std::copy_n(from.vertices.begin() + from.count - kept, kept, to.vertices.begin() + end);
  std::copy_n(from.edges.begin() + from.count - kept, kept - 1, to.edges.begin() + end);
  std::copy_n(from.scattering.begin() + from.count - kept, kept, to.scattering.begin() + end);
  // Build the hint's vertices from the light.
  const uint32_t light = Hints::choose_light(hint, sampler.get_1d());
  Vec3 position, normal;
  Hints::sample_position(hint, scene.lights().light(light), sampler.get_2d(), position, normal);
  Vec3 direction = Hints::sample_direction(hint, 0, position, sampler.get_2d());
  PathVertex& start = to.vertices[0];
  make_light_vertex(scene, light, position, normal, direction, from.time(), start);
  Ray ray = leave_light(scene, start, direction);
  for (int i = 1; i < end; ++i) {
    if (!grow(space_, ray, {Growth::ToEye, {Collisions::Kind::None}}, to, i, sampler, rays)) return false;
    PathVertex& vertex = to.vertices[size_t(i)];
    const Hints::Vertex& meant = hint.vertices[size_t(i)];
    vertex.specular = meant.specular;
    if (!vertex.specular && !vertex.connectable()) return false;
    if (i + 1 == end) break;
    if (vertex.specular) {
      const auto followed = follow_direction(vertex, to.to_light(i), meant.transmitted, sampler.get_1d());
      if (!followed) return false;
      direction = followed->wi;
    } else {
      direction = Hints::sample_direction(hint, size_t(i), vertex.position(), sampler.get_2d());
    }
    ray = scene.spawn_ray(vertex.point, direction);
  }
  if (!join_at(space_, to, end - 1, rays)) return false;
  if (to_lens && !arrive_on_film(space_, to)) return false;
  if (!space_.complete(to, 0, end)) return false;
  // The proposal must differ in exactly the vertices that were to change.
  const SharedEnds shared = shared_ends(from, to);
  return shared.eye == kept && (shared.light == 0 || (shared.light == 1 && start.delta));
}

/// The densities of all hints [Fan 2006, eq. 4.6, per solid angle].
double HintMutation::pdf_of_hints(const Path& from, const Path& to) const {
  const SharedEnds shared = shared_ends(from, to);
  if (shared.light > (to.vertices[0].delta ? 1 : 0)) return 0.0;
  const int joint = first_joinable_from_eye(from), end = to.count - shared.eye;
  const bool to_joint = joint > 0 && shared.eye == from.count - joint && first_joinable_from_eye(to) == end;
  if (!to_joint && shared.eye != 1) return 0.0;
  double pdf = 0.0;
  for (size_t i = 0; i < hints_.size(); ++i) {
    const Hints::Hint& hint = hints_[i];
    if (int(hint.vertices.size()) != end) continue;
    const double to_lens = lens_probability(hint, joint > 0);
    const double probability = hint.share * (to_joint ? 1.0 - to_lens : to_lens);
    if (probability > 0.0) pdf += probability * pdf_of_hint(space_.scene.lights(), hint, to, end);
  }
  return pdf;
}

bool HintMutation::regrow(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const {
  const int joint = first_joinable_from_eye(from), kept = from.count - joint, longest = max_grown(kept);
  if (joint <= 0 || longest < min_grown()) return false;
  // The number of vertices has a truncated geometric distribution.
  const double u = double(sampler.get_1d()) * (1.0 - std::pow(kLonger, longest - min_grown() + 1));
  const int grown = std::min(min_grown() + int(std::log1p(-u) / std::log(kLonger)), longest);
  return bidirectional_.grow_into(from, {0, kept}, grown, sampler, to, rays);
}

double HintMutation::pdf_of_regrowth(const Path& from, const Path& to) const {
  const SharedEnds shared = shared_ends(from, to);
  const int joint = first_joinable_from_eye(from), kept = from.count - joint, grown = to.count - kept,
            longest = max_grown(kept);
  if (joint <= 0 || shared.eye != kept || shared.light > (to.vertices[0].delta ? 1 : 0) || grown < min_grown() ||
      grown > longest)
    return 0.0;
  const double probability = std::pow(kLonger, grown - min_grown()) * (1.0 - kLonger) /
                             (1.0 - std::pow(kLonger, longest - min_grown() + 1));
  return probability * bidirectional_.pdf_of_growth(from, to, {0, kept});
}

/// All three parts count, whichever of them drew the proposal [Fan 2006, eq. 4.7].
double HintMutation::pdf(const Path& from, const Path& to) const {
  double pdf = double(1.0f - hint_probability_ - regrow_probability_) * bidirectional_.pdf(from, to);
  if (hint_probability_ > 0.0f) pdf += double(hint_probability_) * pdf_of_hints(from, to);
  if (regrow_probability_ > 0.0f) pdf += double(regrow_probability_) * pdf_of_regrowth(from, to);
  return pdf;
}

}  // namespace ajar
