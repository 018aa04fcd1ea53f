#include "transport/chains/mutations/bidirectional_mutation.h"

#include <algorithm>

#include "transport/chains/mutations/regrow.h"

namespace ajar {

namespace {

double weight_of_removed(int removed) {
  constexpr double kShort[] = {0.1, 0.25, 0.25, 0.15, 0.1};
  return removed < 5 ? kShort[removed] : 0.1 * std::pow(0.7, removed - 4);
}

}  // namespace

/// Number of positions of a gap of `removed` vertices. With none removed, the gap is an edge.
int BidirectionalMutation::places_of_gap(int removed, int count) const {
  return removed == 0 ? count - 1 : count - min_eye() - removed + 1;
}

double BidirectionalMutation::probability_of_gap(int removed, int count) const {
  const int max_removed = count - min_eye();
  if (removed < 0 || removed > max_removed) return 0.0;
  double sum = 0.0;
  for (int r = 0; r <= max_removed; ++r) sum += weight_of_removed(r);
  return weight_of_removed(removed) / sum / double(places_of_gap(removed, count));
}

std::array<double, 5> BidirectionalMutation::probabilities_of_growth(int removed, int kept) const {
  constexpr double kWeights[5] = {0.05, 0.2, 0.5, 0.2, 0.05};
  std::array<double, 5> probabilities{};
  double sum = 0.0;
  for (int i = 0; i < 5; ++i) {
    const int grown = removed + i - 2, count = kept + grown;
    if (grown < 0 || (grown == 0 && removed == 0) || count < 3 || count > space_.max_vertices) continue;
    sum += probabilities[size_t(i)] = kWeights[i];
  }
  if (sum > 0.0)
    for (double& c : probabilities) c /= sum;
  return probabilities;
}

bool BidirectionalMutation::possible(const Path& path, Gap gap, int grown, int s) const {
  const int t = grown - s;
  if (gap.eye == 0 && t < 1) return false;  // the lens is a vertex of the eye's side
  // A kept light vertex has no outgoing ray; rays start only with a new light vertex.
  if (gap.light == 1 && s > 0) return false;
  if (gap.light == 0 && s == 0) return t - (gap.eye == 0) >= 1;   // the walk from the eye hits the light
  if (gap.light == 0 && s == 1 && gap.eye + t < 2) return false;  // light is sampled at a surface
  if (!space_.to_lens && gap.eye + t == 1) return false;          // nothing is joined to the lens
  const PathVertex& last_light = path.vertices[size_t(std::max(0, gap.light - 1))];
  const PathVertex& last_eye = path.vertices[size_t(path.count - std::max(1, gap.eye))];
  if (gap.light >= 1 && s == 0 && !last_light.connectable()) return false;
  if (gap.eye >= 1 && t == 0 && !last_eye.connectable()) return false;
  return true;
}

bool BidirectionalMutation::sample(const Path& from, Sampler& sampler, Path& to, uint64_t& rays) const {
  // Choose the gap.
  const int n = from.count, max_removed = n - min_eye();
  float u = sampler.get_1d();
  int removed = 0;
  for (double left = double(u); removed < max_removed; ++removed) {
    left -= probability_of_gap(removed, n) * double(places_of_gap(removed, n));
    if (left < 0.0) break;
  }
  Gap gap;
  const int places = places_of_gap(removed, n);
  gap.light = std::min(int(sampler.get_1d() * float(places)), places - 1) + (removed == 0);
  gap.eye = n - removed - gap.light;
  const auto growth = probabilities_of_growth(removed, gap.light + gap.eye);
  int grown = -1;
  u = sampler.get_1d();
  for (int i = 0; i < 5; ++i) {
    if (!(growth[size_t(i)] > 0.0)) continue;
    grown = removed + i - 2;
    u -= float(growth[size_t(i)]);
    if (u < 0.0f) break;
  }
  if (grown < 0) return false;
  return grow_into(from, gap, grown, sampler, to, rays);
}

/// Copies the vertices on both sides of the gap to a path of `count` vertices.
void BidirectionalMutation::keep_ends(const Path& from, Gap gap, int count, Path& to) const {
  const int n = from.count;
  to.count = count;
  to.film = from.film;
  std::copy_n(from.vertices.begin(), gap.light, to.vertices.begin());
  std::copy_n(from.edges.begin(), std::max(0, gap.light - 1), to.edges.begin());
  std::copy_n(from.scattering.begin(), gap.light, to.scattering.begin());
  std::copy_n(from.vertices.begin() + n - gap.eye, gap.eye, to.vertices.begin() + count - gap.eye);
  std::copy_n(from.edges.begin() + n - gap.eye, std::max(0, gap.eye - 1), to.edges.begin() + count - gap.eye);
  std::copy_n(from.scattering.begin() + n - gap.eye, gap.eye, to.scattering.begin() + count - gap.eye);
}

/// Grows the t vertices on the eye's side; the last of them is the light if none grow from its side.
bool BidirectionalMutation::grow_from_eye(Gap gap, int s, int t, float time, Sampler& sampler, Path& to,
                                          uint64_t& rays) const {
  const Scene& scene = space_.scene;
  const int count = to.count, end_new = count - gap.eye;  // new vertices are before end_new
  const int eye_end = end_new - t;                        // index of the last vertex on the eye's side
  if (gap.eye == 0) make_lens_vertex(scene, sampler.get_2d(), time, to.vertices[size_t(count - 1)]);
  const bool hits_light = gap.light == 0 && s == 0;
  for (int i = std::min(end_new - 1, count - 2); i >= eye_end; --i) {
    Ray ray;
    if (i == count - 2) {
      to.film = space_.film_at(sampler.get_2d());
      if (!space_.on_film(to.film)) return false;
      ray = leave_lens(scene, to.film, to.vertices[size_t(count - 1)]);
    } else {
      PathVertex& at = to.vertices[size_t(i + 1)];
      const float u_lobe = sampler.get_1d();
      const auto drawn = sample_direction(at, to.to_eye(i + 1), u_lobe, sampler.get_2d());
      if (!drawn || (drawn->flags & kTransparent)) return false;
      at.specular = drawn->specular;
      ray = scene.spawn_ray(at.point, drawn->wi);
    }
    if (i == 0 && hits_light) {
      if (!grow_light(space_, ray, to, sampler, rays)) return false;
    } else {
      if (!grow(space_, ray, {i == count - 2 ? Growth::ToLightFromLens : Growth::ToLight}, to, i, sampler, rays))
        return false;
      if (!to.vertices[size_t(i)].scatters()) return false;
    }
  }
  return true;
}

/// Grows the s vertices on the light's side.
bool BidirectionalMutation::grow_from_light(Gap gap, int s, float time, Sampler& sampler, Path& to,
                                            uint64_t& rays) const {
  const Scene& scene = space_.scene;
  if (gap.light == 0 && s == 1) {
    const float u_choice = sampler.get_1d();
    return to.vertices[1].connectable() &&
           sample_light(scene, to.vertices[1], u_choice, sampler.get_2d(), to.vertices[0]);
  }
  for (int i = std::max(gap.light, 1); i < gap.light + s; ++i) {
    Ray ray;
    if (i == 1) {
      const float u_choice = sampler.get_1d();
      const Vec2 u_position = sampler.get_2d();
      if (!start_at_light(scene, space_.guide, {u_choice, u_position, sampler.get_2d()}, time, to.vertices[0], ray))
        return false;
    } else {
      PathVertex& at = to.vertices[size_t(i - 1)];
      const WalkDirection next = sample_walk_direction(space_.guide, at, to.to_light(i - 1), sampler);
      if (!next.found) return false;
      at.specular = next.specular;
      ray = scene.spawn_ray(at.point, next.direction);
    }
    if (!grow(space_, ray, {Growth::ToEye}, to, i, sampler, rays)) return false;
    if (!to.vertices[size_t(i)].scatters()) return false;
  }
  return true;
}

bool BidirectionalMutation::grow_into(const Path& from, Gap gap, int grown, Sampler& sampler, Path& to,
                                      uint64_t& rays) const {
  int choices = 0;
  for (int s = 0; s <= grown; ++s) choices += possible(from, gap, grown, s);
  if (choices == 0) return false;
  int s = -1;
  for (int left = std::min(int(sampler.get_1d() * float(choices)), choices - 1); left >= 0; --left) do
      ++s;
    while (!possible(from, gap, grown, s));
  const int t = grown - s, count = gap.light + gap.eye + grown;

  keep_ends(from, gap, count, to);
  // A path that keeps a vertex keeps its time.
  float time = from.time();
  if (gap.eye == 0 && gap.light == 0 && space_.scene.moves()) time = space_.scene.camera().time_of(sampler.get_1d());
  if (!grow_from_eye(gap, s, t, time, sampler, to, rays) || !grow_from_light(gap, s, time, sampler, to, rays))
    return false;
  // Connect both sides.
  const int light_end = gap.light + s - 1;  // index of the last vertex on the light's side
  if (gap.light > 0 || s > 0) {
    PathVertex &a = to.vertices[size_t(light_end)], &b = to.vertices[size_t(light_end + 1)];
    if (!a.connectable() || !b.connectable()) return false;
    a.specular = b.specular = false;
    if (!join_at(space_, to, light_end, rays)) return false;
    if (light_end + 1 == count - 1 && !arrive_on_film(space_, to)) return false;
  }
  if (!space_.complete(to, gap.light - 1, count - gap.eye)) return false;
  // If a specular surface leads a new walk along the old path, a new vertex equals a removed one. The proposal then
  // belongs to a smaller gap.
  const SharedEnds shared = shared_ends(from, to);
  return shared.eye == gap.eye &&
         (shared.light == gap.light || (gap.light == 0 && shared.light == 1 && to.vertices[0].delta));
}

double BidirectionalMutation::pdf_given_gap(const Path& from, const Path& to, Gap gap) const {
  const int removed = from.count - gap.light - gap.eye, grown = to.count - gap.light - gap.eye;
  if (removed < 0 || grown < 0 || std::abs(grown - removed) > 2 || gap.eye < min_eye()) return 0.0;
  const double probability = probability_of_gap(removed, from.count) *
                             probabilities_of_growth(removed, gap.light + gap.eye)[size_t(grown - removed + 2)];
  return probability > 0.0 ? probability * pdf_of_growth(from, to, gap) : 0.0;
}

double BidirectionalMutation::pdf_of_growth(const Path& from, const Path& to, Gap gap) const {
  const int grown = to.count - gap.light - gap.eye;
  if (grown < 0) return 0.0;
  const int first_new = gap.light, end_new = to.count - gap.eye;
  // from_eye[i]: density of finding all new vertices from i on from the eye.
  std::array<double, kMaxPathVertices + 1> from_eye;
  from_eye[size_t(end_new)] = 1.0;
  for (int i = end_new - 1; i >= first_new; --i) {
    double pdf = to.pdf_from_eye(i, space_.pdf_lens_area());
    if (i == to.count - 2) pdf /= space_.film_area();
    from_eye[size_t(i)] = from_eye[size_t(i + 1)] * pdf;
  }
  double from_light = 1.0, sum = 0.0;
  int choices = 0;
  for (int s = 0; s <= grown; ++s) {
    if (s > 0) from_light *= to.pdf_from_light(first_new + s - 1);
    if (!possible(from, gap, grown, s)) continue;
    ++choices;
    const double rest = from_eye[size_t(first_new + s)];
    if (gap.light == 0 && s == 0) {
      if (to.light.can_be_hit) sum += rest * to.hit_choice;
      continue;
    }
    const int light_end = first_new + s - 1;
    if (!to.joinable(light_end) || !to.joinable(light_end + 1)) continue;
    sum += rest * (gap.light == 0 && s == 1 ? double(to.light.pdf_sampled) : from_light);
  }
  return choices > 0 ? sum / choices : 0.0;
}

double BidirectionalMutation::pdf(const Path& from, const Path& to) const {
  const SharedEnds shared = shared_ends(from, to);
  double pdf = pdf_given_gap(from, to, {shared.light, shared.eye});
  // A light without extent may have been removed and found again at the same position.
  if (shared.light == 1 && to.vertices[0].delta) pdf += pdf_given_gap(from, to, {0, shared.eye});
  return pdf;
}

}  // namespace ajar
