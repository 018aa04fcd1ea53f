#include "geometry/subdivision/dice.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "geometry/uv_tangents.h"

namespace ajar {

namespace {

/// Vertices along a side, with their places from 0 to 1.
struct Chain {
  std::vector<uint32_t> vertices;
  std::vector<float> places;
  void clear() {
    vertices.clear();
    places.clear();
  }
  void add(uint32_t vertex, float place) {
    vertices.push_back(vertex);
    places.push_back(place);
  }
};

/// Appends the vertices of an edge without its last one.
void append(const DicingPlan& plan, SideOfPart side, float from, float to, Chain& chain) {
  const DicedEdge& edge = plan.edges[side.edge];
  if (edge.first_half >= 0) {
    const uint32_t first = uint32_t(edge.first_half);
    const float middle = from + (to - from) * (side.reversed ? 1.0f - edge.split : edge.split);
    append(plan, {side.reversed ? first + 1 : first, side.reversed}, from, middle, chain);
    append(plan, {side.reversed ? first : first + 1, side.reversed}, middle, to, chain);
    return;
  }
  chain.add(side.reversed ? edge.end : edge.start, from);
  for (int i = 1; i < edge.pieces; ++i)
    chain.add(edge.inner + uint32_t(side.reversed ? edge.pieces - 1 - i : i - 1),
              from + (to - from) * (float(i) / float(edge.pieces)));
}

/// Triangles between two rows of vertices in the same direction, with the inner row to the left.
template <class Add>
void stitch(const Chain& outer, const Chain& inner, const Add& add) {
  size_t i = 0, j = 0;
  const size_t last_outer = outer.vertices.size() - 1, last_inner = inner.vertices.size() - 1;
  while (i < last_outer || j < last_inner) {
    const bool is_outer = j == last_inner || (i < last_outer && outer.places[i] + outer.places[i + 1] <=
                                                                    inner.places[j] + inner.places[j + 1]);
    if (is_outer) {
      add(outer.vertices[i], outer.vertices[i + 1], inner.vertices[j]);
      ++i;
    } else {
      add(outer.vertices[i], inner.vertices[j + 1], inner.vertices[j]);
      ++j;
    }
  }
}

class Dicer {
 public:
  Dicer(const MeshDescription& mesh, std::span<const SurfacePatch> patches, const LimitSurface& surface,
        const DicingPlan& plan, const std::atomic<bool>* stop)
      : mesh_(mesh), patches_(patches), surface_(surface), plan_(plan), stop_(stop) {}

  MeshDescription run() {
    const SubdivisionDescription& s = mesh_.subdivision;
    all_flat_ = !s.flat_faces.empty() &&
                std::all_of(s.flat_faces.begin(), s.flat_faces.end(), [](uint8_t flat) { return flat != 0; });
    has_flat_ = std::any_of(s.flat_faces.begin(), s.flat_faces.end(), [](uint8_t flat) { return flat != 0; });
    is_smooth_ = s.scheme == SubdivisionScheme::CatmullClark;
    prepare();
    tbb::parallel_for(size_t(0), plan_.points.size(), [&](size_t i) { set_vertex(uint32_t(i), plan_.points[i]); });
    tbb::parallel_for(size_t(0), plan_.edges.size(), [&](size_t i) { set_edge(plan_.edges[i]); });
    tbb::parallel_for(tbb::blocked_range<size_t>(0, plan_.parts.size()), [&](const tbb::blocked_range<size_t>& range) {
      Workspace workspace;
      for (size_t i = range.begin(); i < range.end(); ++i) {
        if (stop_ && stop_->load(std::memory_order_relaxed)) return;
        set_part(plan_.parts[i], workspace);
      }
    });
    finish_normals();
    add_tangents();
    return std::move(out_);
  }

 private:
  struct Workspace {
    Chain sides[4], low, high;
    std::vector<uint32_t> vertices;                  // of the part
    std::vector<Vec2> uvs;                           // of these vertices
    std::vector<float> values;                       // of an attribute at these vertices
    std::vector<std::array<uint32_t, 3>> triangles;  // in these vertices
  };

  void prepare() {
    out_.name = mesh_.name;
    out_.active_uv = mesh_.active_uv;
    out_.texture_space_location = mesh_.texture_space_location;
    out_.texture_space_size = mesh_.texture_space_size;
    out_.grids = mesh_.grids;
    out_.density_in_object_space = mesh_.density_in_object_space;
    out_.flow = mesh_.flow;
    out_.positions.resize(plan_.vertices);
    out_.triangles.resize(plan_.triangles);
    if (!mesh_.material_slots.empty()) out_.material_slots.resize(plan_.triangles);
    const bool given = !mesh_.normals.empty();
    if (!all_flat_ && (is_smooth_ || given)) {
      out_.normal_domain = is_smooth_ || mesh_.normal_domain == Domain::Vertex ? Domain::Vertex : Domain::Corner;
      out_.normals.resize(out_.normal_domain == Domain::Vertex ? plan_.vertices : 3 * plan_.triangles);
    }
    for (const Attribute& attribute : mesh_.attributes) {
      Attribute diced;
      diced.name = attribute.name;
      diced.domain = attribute.domain;
      diced.components = attribute.components;
      const size_t count = attribute.domain == Domain::Vertex   ? plan_.vertices
                           : attribute.domain == Domain::Corner ? 3 * plan_.triangles
                                                                : plan_.triangles;
      diced.values.resize(count * size_t(attribute.components));
      out_.attributes.push_back(std::move(diced));
    }
  }

  /// The value of an attribute of vertices or corners.
  void value_at(size_t index, PatchPoint point, float* value) const {
    const Attribute& attribute = mesh_.attributes[index];
    if (surface_.is_smooth(index)) {
      const Vec3 smooth = surface_.smooth_value(index, point);
      for (int k = 0; k < attribute.components; ++k) value[k] = smooth[k];
      return;
    }
    const bool of_vertices = attribute.domain == Domain::Vertex;
    for (int k = 0; k < attribute.components; ++k)
      value[k] = interpolate_face(patches_[point.patch], point.uv, [&](uint32_t corner) {
        const size_t element = of_vertices ? mesh_.subdivision.corner_vertices[corner] : corner;
        return attribute.values[element * size_t(attribute.components) + size_t(k)];
      });
  }
  Vec3 given_normal(PatchPoint point) const {
    const bool of_vertices = mesh_.normal_domain == Domain::Vertex;
    return interpolate_face(patches_[point.patch], point.uv, [&](uint32_t corner) {
      return mesh_.normals[of_vertices ? mesh_.subdivision.corner_vertices[corner] : corner];
    });
  }
  static Vec3 unit_or_zero(Vec3 v) {
    const float length = glm::length(v);
    return length > 0.0f && length < kInfinity ? v / length : Vec3(0.0f);
  }

  void set_vertex(uint32_t vertex, PatchPoint point) {
    Vec3 normal;
    surface_.evaluate(point, out_.positions[vertex], normal);
    if (!is_finite(out_.positions[vertex])) out_.positions[vertex] = Vec3(0.0f);
    if (!out_.normals.empty() && out_.normal_domain == Domain::Vertex)
      out_.normals[vertex] = unit_or_zero(is_smooth_ ? normal : given_normal(point));
    for (size_t i = 0; i < mesh_.attributes.size(); ++i)
      if (mesh_.attributes[i].domain == Domain::Vertex)
        value_at(i, point, &out_.attributes[i].values[vertex * size_t(mesh_.attributes[i].components)]);
  }

  void set_edge(const DicedEdge& edge) {
    if (edge.first_half >= 0) return;
    for (int i = 1; i < edge.pieces; ++i)
      set_vertex(edge.inner + uint32_t(i - 1),
                 {edge.patch, edge.from + (edge.to - edge.from) * (float(i) / float(edge.pieces))});
  }

  static Vec2 place_in(const DicedPart& part, float s, float t) {
    const Vec2* c = part.corners;
    return (c[0] * (1.0f - s) + c[1] * s) * (1.0f - t) + (c[3] * (1.0f - s) + c[2] * s) * t;
  }

  void set_part(const DicedPart& part, Workspace& w) {
    w.vertices.clear();
    w.uvs.clear();
    w.triangles.clear();
    for (int k = 0; k < 4; ++k) {
      Chain& side = w.sides[k];
      side.clear();
      append(plan_, part.sides[k], 0.0f, 1.0f, side);
      for (size_t i = 0; i < side.vertices.size(); ++i) {
        const float s = side.places[i];
        w.vertices.push_back(side.vertices[i]);
        w.uvs.push_back(place_in(part,
                                 k == 0   ? s
                                 : k == 1 ? 1.0f
                                 : k == 2 ? 1.0f - s
                                          : 0.0f,
                                 k == 0   ? 0.0f
                                 : k == 1 ? s
                                 : k == 2 ? 1.0f
                                          : 1.0f - s));
        side.vertices[i] = uint32_t(w.vertices.size() - 1);  // from here on within the part
      }
    }
    for (int k = 0; k < 4; ++k) w.sides[k].add(w.sides[(k + 1) % 4].vertices[0], 1.0f);
    const auto pieces = [&](int k) { return w.sides[k].vertices.size() - 1; };
    const size_t mu = std::max(pieces(0), pieces(2)), mv = std::max(pieces(1), pieces(3));
    const auto add = [&](uint32_t a, uint32_t b, uint32_t c) { w.triangles.push_back({a, b, c}); };
    if (mu == 1 || mv == 1) {
      const int along = mv == 1 ? 0 : 1;
      Chain& opposite = w.high;
      opposite.clear();
      const Chain& other = w.sides[along + 2];
      for (size_t i = other.vertices.size(); i-- > 0;) opposite.add(other.vertices[i], 1.0f - other.places[i]);
      stitch(w.sides[along], opposite, add);
    } else {
      set_grid(part, mu, mv, w);
    }
    write_triangles(part, w);
  }

  /// A grid of equal cells, connected with the sides by triangles.
  void set_grid(const DicedPart& part, size_t mu, size_t mv, Workspace& w) {
    const uint32_t first = uint32_t(w.vertices.size());
    const auto inner = [&](size_t i, size_t j) { return first + uint32_t((j - 1) * (mu - 1) + i - 1); };
    for (size_t j = 1; j < mv; ++j) {
      for (size_t i = 1; i < mu; ++i) {
        const uint32_t vertex = part.first_inner + uint32_t((j - 1) * (mu - 1) + i - 1);
        const Vec2 uv = place_in(part, float(i) / float(mu), float(j) / float(mv));
        w.vertices.push_back(vertex);
        w.uvs.push_back(uv);
        set_vertex(vertex, {part.patch, uv});
      }
    }
    for (size_t j = 1; j + 1 < mv; ++j) {
      for (size_t i = 1; i + 1 < mu; ++i) {
        w.triangles.push_back({inner(i, j), inner(i + 1, j), inner(i + 1, j + 1)});
        w.triangles.push_back({inner(i, j), inner(i + 1, j + 1), inner(i, j + 1)});
      }
    }
    const auto add = [&](uint32_t a, uint32_t b, uint32_t c) { w.triangles.push_back({a, b, c}); };
    for (int k = 0; k < 4; ++k) {
      const size_t cells = k % 2 == 0 ? mu : mv;
      w.low.clear();
      for (size_t i = 1; i < cells; ++i) {
        const uint32_t vertex = k == 0   ? inner(i, 1)
                                : k == 1 ? inner(mu - 1, i)
                                : k == 2 ? inner(mu - i, mv - 1)
                                         : inner(1, mv - i);
        w.low.add(vertex, float(i) / float(cells));
      }
      stitch(w.sides[k], w.low, add);
    }
  }

  void write_triangles(const DicedPart& part, Workspace& w) {
    const uint32_t face = patches_[part.patch].face;
    size_t t = part.first_triangle;
    for (const auto& triangle : w.triangles) {
      out_.triangles[t] = {w.vertices[triangle[0]], w.vertices[triangle[1]], w.vertices[triangle[2]]};
      if (!out_.material_slots.empty()) out_.material_slots[t] = mesh_.material_slots[face];
      ++t;
    }
    for (size_t a = 0; a < mesh_.attributes.size(); ++a) {
      const Attribute& attribute = mesh_.attributes[a];
      const size_t n = size_t(attribute.components);
      std::vector<float>& values = out_.attributes[a].values;
      if (attribute.domain == Domain::Face) {
        for (size_t i = part.first_triangle; i < t; ++i) std::copy_n(&attribute.values[face * n], n, &values[i * n]);
      } else if (attribute.domain == Domain::Corner) {
        w.values.resize(w.vertices.size() * n);
        for (size_t i = 0; i < w.vertices.size(); ++i) value_at(a, {part.patch, w.uvs[i]}, &w.values[i * n]);
        size_t corner = 3 * part.first_triangle;
        for (const auto& triangle : w.triangles)
          for (const uint32_t vertex : triangle) std::copy_n(&w.values[vertex * n], n, &values[corner++ * n]);
      }
    }
    if (out_.normals.empty() || out_.normal_domain != Domain::Corner) return;
    size_t corner = 3 * part.first_triangle;
    for (const auto& triangle : w.triangles)
      for (const uint32_t vertex : triangle)
        out_.normals[corner++] = unit_or_zero(given_normal({part.patch, w.uvs[vertex]}));
  }

  Vec3 triangle_normal(UVec3 v) const {
    const std::vector<Vec3>& p = out_.positions;
    return unit_or_zero(glm::cross(p[v.y] - p[v.x], p[v.z] - p[v.x]));
  }

  /// Where the surface has no normal, the mean of those of the triangles. Flat faces get those of their triangles.
  void finish_normals() {
    if (out_.normals.empty()) return;
    if (out_.normal_domain == Domain::Vertex &&
        std::find(out_.normals.begin(), out_.normals.end(), Vec3(0.0f)) != out_.normals.end()) {
      std::vector<Vec3> sums(out_.positions.size(), Vec3(0.0f));
      for (const UVec3& v : out_.triangles)
        for (int k = 0; k < 3; ++k) sums[v[k]] += triangle_normal(v);
      for (size_t i = 0; i < sums.size(); ++i)
        if (out_.normals[i] == Vec3(0.0f)) out_.normals[i] = unit_or_zero(sums[i]);
    }
    if (!has_flat_) return;
    if (out_.normal_domain == Domain::Vertex) {
      std::vector<Vec3> corners;
      corners.reserve(3 * out_.triangles.size());
      for (const UVec3& v : out_.triangles)
        for (int k = 0; k < 3; ++k) corners.push_back(out_.normals[v[k]]);
      out_.normals = std::move(corners);
      out_.normal_domain = Domain::Corner;
    }
    Attribute marks;
    marks.name = kFlatFaces;
    marks.domain = Domain::Face;
    marks.components = 1;
    marks.values.resize(out_.triangles.size(), 0.0f);
    for (size_t p = 0; p < plan_.parts.size(); ++p) {
      if (mesh_.subdivision.flat_faces[patches_[plan_.parts[p].patch].face] == 0) continue;
      const size_t end = p + 1 < plan_.parts.size() ? plan_.parts[p + 1].first_triangle : plan_.triangles;
      for (size_t t = plan_.parts[p].first_triangle; t < end; ++t) {
        marks.values[t] = 1.0f;
        for (size_t k = 0; k < 3; ++k) out_.normals[3 * t + k] = triangle_normal(out_.triangles[t]);
      }
    }
    std::erase_if(out_.attributes, [](const Attribute& attribute) { return attribute.name == kFlatFaces; });
    out_.attributes.push_back(std::move(marks));
  }

  void add_tangents() {
    std::vector<Vec3> normals;
    for (const std::string& name : mesh_.subdivision.tangents) {
      if (normals.empty())
        for (size_t c = 0; c < 3 * out_.triangles.size(); ++c) {
          const UVec3 v = out_.triangles[c / 3];
          normals.push_back(out_.normals.empty()                   ? triangle_normal(v)
                            : out_.normal_domain == Domain::Vertex ? out_.normals[v[int(c % 3)]]
                                                                   : out_.normals[c]);
        }
      const std::string uv_map = name.substr(std::min(name.size(), std::string_view(kTangentOf).size()));
      const std::string& wanted = uv_map.empty() ? out_.active_uv : uv_map;
      std::vector<Vec2> uvs;
      for (const Attribute& map : out_.attributes)
        for (size_t c = 0;
             map.name == wanted && map.domain == Domain::Corner && map.components == 2 && c < normals.size(); ++c)
          uvs.push_back({map.values[2 * c], map.values[2 * c + 1]});
      if (uvs.size() != normals.size() && !uv_map.empty()) continue;
      Attribute tangents;
      tangents.name = name;
      tangents.domain = Domain::Corner;
      tangents.components = 4;
      for (const Vec4& tangent : uv_tangents(out_.positions, out_.triangles, normals, uvs))
        for (int k = 0; k < 4; ++k) tangents.values.push_back(tangent[k]);
      out_.attributes.push_back(std::move(tangents));
    }
  }

  const MeshDescription& mesh_;
  const std::span<const SurfacePatch> patches_;
  const LimitSurface& surface_;
  const DicingPlan& plan_;
  const std::atomic<bool>* stop_;
  MeshDescription out_;
  bool all_flat_ = false, has_flat_ = false, is_smooth_ = false;
};

}  // namespace

MeshDescription dice(const MeshDescription& mesh, const DicingRate& rate, DicingReport& report,
                     const std::atomic<bool>* stop) {
  const std::vector<SurfacePatch> patches = patches_of(mesh.subdivision);
  const std::unique_ptr<const LimitSurface> surface = make_limit_surface(mesh, patches, report.is_damaged);
  DicingRate tried = rate;
  DicingPlan plan = plan_dicing(mesh.subdivision, patches, *surface, tried);
  constexpr int kAttempts = 12;
  for (int i = 0; i < kAttempts && !plan.is_complete; ++i) {
    const double excess = double(plan.triangles) / double(std::max<size_t>(1, rate.max_triangles));
    tried.edge_length *= float(std::max(1.25, std::sqrt(excess) * 1.05));
    plan = plan_dicing(mesh.subdivision, patches, *surface, tried);
  }
  report.coarser = tried.edge_length / rate.edge_length;
  if (!plan.is_complete) plan = DicingPlan();
  return Dicer(mesh, patches, *surface, plan, stop).run();
}

double estimate_diced_triangles(const MeshDescription& mesh, const DicingRate& rate) {
  double sum = 0.0;
  const SubdivisionDescription& s = mesh.subdivision;
  for (size_t f = 0, first = 0; f < s.face_sizes.size(); first += s.face_sizes[f++]) {
    if (first + s.face_sizes[f] > s.corner_vertices.size()) break;  // not yet validated
    const auto at = [&](size_t k) {
      const uint32_t vertex = s.corner_vertices[first + k];
      return vertex < mesh.positions.size() ? mesh.positions[vertex] : Vec3(0.0f);
    };
    float finest = 0.0f;
    const auto measure = [&](const Mat4& matrix) {
      Vec3 area(0.0f), middle(0.0f);
      for (size_t k = 0; k < s.face_sizes[f]; ++k) {
        middle += transform_point(matrix, at(k)) / float(s.face_sizes[f]);
        if (k >= 2)
          area += 0.5f * glm::cross(transform_point(matrix, at(k - 1)) - transform_point(matrix, at(0)),
                                    transform_point(matrix, at(k)) - transform_point(matrix, at(0)));
      }
      const float edge = rate.edge_length * (rate.pixels ? rate.pixels->at(middle) : 1.0f);
      finest = std::max(finest, glm::length(area) / sqr(edge));
    };
    if (!rate.pixels) measure(Mat4(1.0f));
    for (const Mat4& matrix : rate.world_from_object)
      if (rate.pixels) measure(matrix);
    const double most = std::ldexp(1.0, 2 * rate.max_subdivisions);
    sum += 2.0 * (finest < most ? std::max(double(finest), 1.0) : most);
  }
  return sum;
}

}  // namespace ajar
