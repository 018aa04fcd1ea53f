// A path in compact form, in which populations store it: a quarter of a kilobyte per vertex. Unpacking shades the
// surfaces again.
#pragma once

#include <vector>

#include "transport/paths/path.h"

namespace ajar {

class CompactPath {
 public:
  void pack(const Path& path);
  /// Restores the same path, bit for bit.
  void unpack(Path& path) const;
  bool empty() const { return vertices_.empty(); }
  void clear() { vertices_.clear(); }
  Vec2 film() const { return film_; }
  /// Multiplies the stored target. Use it when the target function is multiplied by `factor`.
  void scale_target(double factor) { target_ *= factor; }
  size_t bytes() const {
    return sizeof(*this) + vertices_.capacity() * sizeof(Vertex) + media_.capacity() * sizeof(VertexMedia);
  }

 private:
  struct Vertex {
    VertexKind kind;
    bool specular, distant, delta;
    int light;
    float pass;
    const ShaderProgram* program;
    Color emission;
    ShadingPoint point;
    PathEdge edge;
    Scattering scattering;
  };
  std::vector<Vertex> vertices_;
  std::vector<VertexMedia> media_;  ///< of the vertices, in scenes with media
  Vec2 film_{0.0f};
  LightEnd light_;
  float hit_choice_ = 1.0f, film_density_ = 0.0f;
  double target_ = 0.0;
  glm::dvec3 f_{0.0};
};

}  // namespace ajar
