#include "transport/paths/compact_path.h"

namespace ajar {

void CompactPath::pack(const Path& path) {
  film_ = path.film;
  light_ = path.light;
  hit_choice_ = path.hit_choice;
  film_density_ = path.film_density;
  target_ = path.target;
  f_ = path.f;
  vertices_.resize(size_t(path.count));
  media_.clear();
  for (size_t i = 0; i < vertices_.size(); ++i) {
    const PathVertex& v = path.vertices[i];
    vertices_[i] = {v.kind,    v.specular,         v.distant, v.delta,       v.light,           v.pass,
                    v.program, v.shading.emission, v.point,   path.edges[i], path.scattering[i]};
    if (v.media.present || !media_.empty()) {
      media_.resize(vertices_.size());
      media_[i] = v.media;
    }
  }
}

void CompactPath::unpack(Path& path) const {
  path.count = int(vertices_.size());
  path.film = film_;
  path.light = light_;
  path.hit_choice = hit_choice_;
  path.film_density = film_density_;
  path.target = target_;
  path.f = f_;
  for (size_t i = 0; i < vertices_.size(); ++i) {
    const Vertex& kept = vertices_[i];
    PathVertex& v = path.vertices[i];
    v.kind = kept.kind;
    v.specular = kept.specular;
    v.distant = kept.distant;
    v.delta = kept.delta;
    v.light = kept.light;
    v.pass = kept.pass;
    v.program = kept.program;
    v.point = kept.point;
    v.media.present = false;
    if (!media_.empty()) v.media = media_[i];
    path.edges[i] = kept.edge;
    path.scattering[i] = kept.scattering;
    if (v.kind == VertexKind::Surface) {
      v.program->evaluate_surface(v.point, v.shading);
      if (v.program->may_be_transparent()) v.shading.bsdf.remove_transparency(v.point.wo);
    } else {
      v.shading.bsdf = Bsdf();
    }
    v.shading.emission = kept.emission;
  }
}

}  // namespace ajar
