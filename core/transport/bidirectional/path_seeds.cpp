#include "transport/bidirectional/path_seeds.h"

namespace ajar {

BidirectionalWalks walks_over(const PathSpace& space) {
  BidirectionalWalks walks(space.scene, space.film_area());
  walks.leaves_unconnectable = space.without_unconnectable;
  walks.guide = space.guide;
  walks.classes = space.has_subsurface ? PathClasses::NotEyeOnly : PathClasses::Diffuse;
  walks.media = space.media;
  return walks;
}

double PathSeeds::sample(Sampler& sampler) {
  found_.clear();
  left_out_ = left_out_light_ = 0.0;
  film_ = space_.film_at(sampler.get_2d());
  double sum = 0.0;
  for (const FoundPath& path : walks_.sample(film_, sampler)) {
    if (space_.without_direct && walks_.is_direct(path)) {
      if (path.t > 1) left_out_ += double(luminance(glm::abs(path.contribution)));
      left_out_light_ += double(luminance(glm::abs(path.contribution))) * (path.t > 1 ? space_.film_area() : 1.0);
      continue;
    }
    // Walks from the eye have density 1 per pixel^2. Walks that end on the lens cover the whole film.
    const double area = path.t > 1 ? space_.film_area() : 1.0;
    const double energy = double(luminance(glm::abs(path.contribution))) * double(space_.weight(path.film)) * area;
    if (!(energy > 0.0) || !std::isfinite(energy)) continue;
    sum += energy;
    found_.push_back({&path, sum});
  }
  return sum;
}

bool PathSeeds::take(double u, Path& path) {
  if (found_.empty()) return false;
  size_t i = 0;
  while (i + 1 < found_.size() && found_[i].energy_up_to <= u * found_.back().energy_up_to) ++i;
  const FoundPath& chosen = *found_[i].path;
  path.count = walks_.copy_path(chosen, path.vertices.data(), path.edges.data());
  path.film = chosen.film;
  if (space_.complete(path, 1, path.count - 2)) return true;
  ++failed_;
  return false;
}

}  // namespace ajar
