#include <recede/geometry/detail/edge_table.h>
#include <recede/geometry/disjoint_sets.h>
#include <recede/geometry/error.h>
#include <recede/geometry/polygon_mesh.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede {

void PolygonMesh::add_corner_uvs() {
  if (!has_corner_uvs()) add_property(corner_uv_, "corner:uv");
}
void PolygonMesh::add_corner_normals() {
  if (!has_corner_normals()) add_property(corner_normal_, "corner:normal");
}
void PolygonMesh::add_vertex_colors() {
  if (!has_vertex_colors()) add_property(vertex_color_, "vertex:color");
}
std::size_t PolygonMesh::add_vertex_scalar(std::string name) {
  add_property(vertex_scalars_.emplace_back(), "vertex:" + name);
  vertex_scalar_names_.push_back(std::move(name));
  return vertex_scalars_.size() - 1;
}
void PolygonMesh::add_face_materials() {
  if (!has_face_materials()) add_property(face_material_, "face:material");
}
void PolygonMesh::add_feature_edges() {
  if (!has_feature_edges()) add_property(edge_feature_, "edge:feature");
}

namespace {

using detail::EdgeTable;
using detail::next_corner;
using Halfedge = PolygonMesh::HalfedgeHandle;

int to_int(std::size_t value) { return static_cast<int>(value); }

/// Two sides that run in opposite directions: an edge that a half-edge mesh can hold with both faces.
bool is_paired(const PolygonSoup& soup, std::span<const Index> sides) {
  return sides.size() == 2 && soup.corner_vertices[sides[0]] != soup.corner_vertices[sides[1]];
}

/// For every corner the lowest corner of its fan: the corners around one vertex that paired edges connect.
std::vector<Index> fans(const PolygonSoup& soup, const EdgeTable& edges) {
  DisjointSets sets(soup.n_corners());
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    const auto sides = edges.sides(e);
    if (!is_paired(soup, sides)) continue;
    sets.unite(sides[0], next_corner(soup, edges.corner_faces, sides[1]));
    sets.unite(sides[1], next_corner(soup, edges.corner_faces, sides[0]));
  }
  std::vector<Index> lowest(soup.n_corners());
  for (Index c = 0; c < lowest.size(); ++c) lowest[c] = sets.find(c);
  return lowest;
}

/// Feature edges of split vertices hold for every copy: named again through the sides that lie on them.
void refresh_feature_edges(PolygonSoup& soup, const EdgeTable& edges,
                           const std::vector<Index>& old_vertices) {
  if (soup.feature_edges.empty()) return;
  auto marked = soup.feature_edges;
  for (auto& [a, b] : marked) {
    if (a > b) std::swap(a, b);
  }
  std::sort(marked.begin(), marked.end());
  for (std::size_t c = 0; c < soup.n_corners(); ++c) {
    const Index next = next_corner(soup, edges.corner_faces, static_cast<Index>(c));
    const std::pair<Index, Index> before = std::minmax(old_vertices[c], old_vertices[next]);
    if (!std::binary_search(marked.begin(), marked.end(), before)) continue;
    soup.feature_edges.emplace_back(std::minmax(soup.corner_vertices[c], soup.corner_vertices[next]));
  }
  std::sort(soup.feature_edges.begin(), soup.feature_edges.end());
  soup.feature_edges.erase(std::unique(soup.feature_edges.begin(), soup.feature_edges.end()),
                           soup.feature_edges.end());
}

}  // namespace

RepairStep split_non_manifold(PolygonSoup& soup) {
  RepairStep step{"split_non_manifold", 0, ""};
  const EdgeTable edges = detail::build_edge_table(soup);
  std::size_t opened = 0;
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    const auto sides = edges.sides(e);
    if (sides.size() > 1 && !is_paired(soup, sides)) ++opened;
  }
  const std::vector<Index> fan = fans(soup, edges);
  const std::vector<Index> old_vertices = soup.corner_vertices;
  std::vector<Index> first_fan(soup.positions.size(), k_no_index);
  std::vector<Index> fan_vertex(soup.n_corners(), k_no_index);
  for (std::size_t c = 0; c < soup.n_corners(); ++c) {
    const Index vertex = old_vertices[c];
    if (fan[c] == c) {
      if (first_fan[vertex] == k_no_index) {
        first_fan[vertex] = static_cast<Index>(c);
        fan_vertex[c] = vertex;
      } else {
        fan_vertex[c] = static_cast<Index>(soup.positions.size());
        soup.positions.push_back(Vec3(soup.positions[vertex]));
        if (!soup.vertex_colors.empty()) soup.vertex_colors.push_back(Vec4(soup.vertex_colors[vertex]));
        for (VertexScalar& scalar : soup.vertex_scalars) {
          scalar.values.push_back(double{scalar.values[vertex]});
        }
        ++step.changed;
      }
    }
    soup.corner_vertices[c] = fan_vertex[fan[c]];
  }
  if (step.changed == 0) return step;
  refresh_feature_edges(soup, edges, old_vertices);
  step.detail = fmt::format(
      "added {} copies of vertices; opened {} edges that more than two faces, or two faces of "
      "opposite orientation, share",
      step.changed, opened);
  return step;
}

namespace {

/// Fills a half-edge mesh from whole lists: half-edge 2e runs along the first side of edge e, 2e + 1 against
/// it.
class MeshBuilder {
 public:
  explicit MeshBuilder(const PolygonSoup& soup) : soup_(soup), edges_(detail::build_edge_table(soup)) {}

  PolygonMesh build() {
    check_edges();
    mesh_.resize(soup_.positions.size(), edges_.n_edges(), soup_.n_faces());
    for (std::size_t v = 0; v < soup_.positions.size(); ++v) {
      mesh_.set_point(PolygonMesh::VertexHandle(to_int(v)), soup_.positions[v]);
    }
    link_faces();
    link_borders();
    check_vertices();
    copy_attributes();
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError("to_polygon_mesh: " + what + "; split_non_manifold opens it");
  }

  void check_edges() const {
    for (std::size_t e = 0; e < edges_.n_edges(); ++e) {
      const auto sides = edges_.sides(e);
      if (sides.size() == 1 || is_paired(soup_, sides)) continue;
      const Index c = sides[0];
      refuse(fmt::format("edge {}-{} has {} faces that don't pair", soup_.corner_vertices[c],
                         soup_.corner_vertices[next_corner(soup_, edges_.corner_faces, c)], sides.size()));
    }
  }

  /// The half-edge along a corner's side.
  Halfedge side_halfedge(Index corner) const {
    const Index edge = edges_.edge_of_corner[corner];
    return Halfedge(to_int(2 * std::size_t{edge} + (edges_.sides(edge)[0] == corner ? 0 : 1)));
  }

  void link_faces() {
    for (std::size_t f = 0; f < soup_.n_faces(); ++f) {
      const PolygonMesh::FaceHandle face(to_int(f));
      const Index first = soup_.face_offsets[f], last = soup_.face_offsets[f + 1] - 1;
      Halfedge previous = side_halfedge(last);
      // The face starts at the half-edge that points at its first corner.
      mesh_.set_halfedge_handle(face, previous);
      for (Index c = first; c <= last; ++c) {
        const Halfedge h = side_halfedge(c);
        const Index to = soup_.corner_vertices[c == last ? first : c + 1];
        mesh_.set_face_handle(h, face);
        mesh_.set_vertex_handle(h, PolygonMesh::VertexHandle(to_int(to)));
        mesh_.set_next_halfedge_handle(previous, h);
        mesh_.set_halfedge_handle(PolygonMesh::VertexHandle(to_int(soup_.corner_vertices[c])), h);
        previous = h;
      }
    }
  }

  /// Border half-edges run against the only side of their edge. A vertex of a border starts with its border
  /// half-edge.
  void link_borders() {
    std::vector<Halfedge> border_from(soup_.positions.size());
    const auto each_border = [&](auto&& visit) {
      for (std::size_t e = 0; e < edges_.n_edges(); ++e) {
        const auto sides = edges_.sides(e);
        if (sides.size() != 1) continue;
        const Index from = soup_.corner_vertices[next_corner(soup_, edges_.corner_faces, sides[0])];
        visit(Halfedge(to_int(2 * e + 1)), from, soup_.corner_vertices[sides[0]]);
      }
    };
    each_border([&](Halfedge h, Index from, Index to) {
      if (border_from[from].is_valid()) refuse(fmt::format("vertex {} lies on two borders", from));
      border_from[from] = h;
      mesh_.set_vertex_handle(h, PolygonMesh::VertexHandle(to_int(to)));
      mesh_.set_boundary(h);
      mesh_.set_halfedge_handle(PolygonMesh::VertexHandle(to_int(from)), h);
    });
    each_border([&](Halfedge h, Index, Index to) { mesh_.set_next_halfedge_handle(h, border_from[to]); });
  }

  /// Every corner of a vertex must be met on one turn around it.
  void check_vertices() const {
    std::vector<Index> degree(soup_.positions.size(), 0);
    for (const Index v : soup_.corner_vertices) ++degree[v];
    for (std::size_t v = 0; v < degree.size(); ++v) {
      const Halfedge start = mesh_.halfedge_handle(PolygonMesh::VertexHandle(to_int(v)));
      if (!start.is_valid()) continue;
      Index met = 0;
      Halfedge h = start;
      do {
        if (!mesh_.is_boundary(h)) ++met;
        h = mesh_.next_halfedge_handle(mesh_.opposite_halfedge_handle(h));
      } while (h != start && met <= degree[v]);
      if (met != degree[v]) refuse(fmt::format("vertex {} joins several fans of faces", v));
    }
  }

  void copy_attributes() {
    mesh_.materials = soup_.materials;
    if (!soup_.vertex_colors.empty()) {
      mesh_.add_vertex_colors();
      for (const auto v : mesh_.vertices())
        mesh_.vertex_color(v) = soup_.vertex_colors[static_cast<std::size_t>(v.idx())];
    }
    for (const VertexScalar& scalar : soup_.vertex_scalars) {
      const std::size_t number = mesh_.add_vertex_scalar(scalar.name);
      for (const auto v : mesh_.vertices())
        mesh_.vertex_scalar(number, v) = scalar.values[static_cast<std::size_t>(v.idx())];
    }
    if (!soup_.face_materials.empty()) {
      mesh_.add_face_materials();
      for (const auto f : mesh_.faces())
        mesh_.face_material(f) = soup_.face_materials[static_cast<std::size_t>(f.idx())];
    }
    if (!soup_.corner_uvs.empty()) mesh_.add_corner_uvs();
    if (!soup_.corner_normals.empty()) mesh_.add_corner_normals();
    if (mesh_.has_corner_uvs() || mesh_.has_corner_normals()) copy_corner_attributes();
    if (!soup_.feature_edges.empty()) copy_feature_edges();
  }

  void copy_corner_attributes() {
    for (Index c = 0; c < soup_.n_corners(); ++c) {
      // The side that starts at c points at the next corner.
      const Index next = next_corner(soup_, edges_.corner_faces, c);
      const Halfedge h = side_halfedge(c);
      if (mesh_.has_corner_uvs()) mesh_.corner_uv(h) = soup_.corner_uvs[next];
      if (mesh_.has_corner_normals()) mesh_.corner_normal(h) = soup_.corner_normals[next];
    }
  }

  void copy_feature_edges() {
    mesh_.add_feature_edges();
    std::vector<std::pair<Index, Index>> marked = soup_.feature_edges;
    for (auto& [a, b] : marked) {
      if (a > b) std::swap(a, b);
    }
    std::sort(marked.begin(), marked.end());
    for (std::size_t e = 0; e < edges_.n_edges(); ++e) {
      const Index c = edges_.sides(e)[0];
      const std::pair<Index, Index> ends = std::minmax(
          soup_.corner_vertices[c], soup_.corner_vertices[next_corner(soup_, edges_.corner_faces, c)]);
      const bool feature = std::binary_search(marked.begin(), marked.end(), ends);
      mesh_.set_feature_edge(PolygonMesh::EdgeHandle(to_int(e)), feature);
    }
  }

  const PolygonSoup& soup_;
  EdgeTable edges_;
  PolygonMesh mesh_;
};

}  // namespace

PolygonMesh to_polygon_mesh(const PolygonSoup& soup) { return MeshBuilder(soup).build(); }

MeshFromSoup repair_to_polygon_mesh(PolygonSoup soup) {
  validate(soup, "mesh");
  RepairReport report;
  report.steps.push_back(merge_identical_vertices(soup));
  report.steps.push_back(remove_degenerate_faces(soup));
  report.steps.push_back(remove_duplicate_faces(soup));
  report.steps.push_back(orient_consistently(soup));
  report.steps.push_back(remove_unreferenced_vertices(soup));
  report.steps.push_back(split_non_manifold(soup));
  return {to_polygon_mesh(soup), std::move(report)};
}

PolygonSoup to_soup(const PolygonMesh& mesh) {
  PolygonSoup soup;
  soup.positions.reserve(mesh.n_vertices());
  for (const auto v : mesh.vertices()) soup.positions.push_back(mesh.point(v));
  soup.face_offsets.reserve(mesh.n_faces() + 1);
  soup.corner_vertices.reserve(mesh.n_halfedges());
  for (const auto f : mesh.faces()) {
    const Halfedge start = mesh.halfedge_handle(f);
    Halfedge h = start;
    do {
      soup.corner_vertices.push_back(static_cast<Index>(mesh.to_vertex_handle(h).idx()));
      if (mesh.has_corner_uvs()) soup.corner_uvs.push_back(mesh.corner_uv(h));
      if (mesh.has_corner_normals()) soup.corner_normals.push_back(mesh.corner_normal(h));
      h = mesh.next_halfedge_handle(h);
    } while (h != start);
    soup.face_offsets.push_back(static_cast<Index>(soup.corner_vertices.size()));
    if (mesh.has_face_materials()) soup.face_materials.push_back(mesh.face_material(f));
  }
  if (mesh.has_vertex_colors()) {
    for (const auto v : mesh.vertices()) soup.vertex_colors.push_back(mesh.vertex_color(v));
  }
  for (std::size_t i = 0; i < mesh.vertex_scalar_names().size(); ++i) {
    VertexScalar& scalar = soup.vertex_scalars.emplace_back();
    scalar.name = mesh.vertex_scalar_names()[i];
    for (const auto v : mesh.vertices()) scalar.values.push_back(mesh.vertex_scalar(i, v));
  }
  if (mesh.has_feature_edges()) {
    for (const auto e : mesh.edges()) {
      if (!mesh.is_feature_edge(e)) continue;
      const Halfedge h = mesh.halfedge_handle(e, 0);
      soup.feature_edges.push_back(std::minmax(static_cast<Index>(mesh.from_vertex_handle(h).idx()),
                                               static_cast<Index>(mesh.to_vertex_handle(h).idx())));
    }
  }
  soup.materials = mesh.materials;
  return soup;
}

namespace {

/// Vector area of each face, not normalised.
std::vector<Vec3> face_areas(const PolygonMesh& mesh) {
  std::vector<Vec3> areas;
  areas.reserve(mesh.n_faces());
  for (const auto f : mesh.faces()) {
    const Halfedge start = mesh.halfedge_handle(f);
    const Vec3 origin = mesh.point(mesh.to_vertex_handle(start));
    Vec3 sum = Vec3::Zero();
    for (Halfedge h = mesh.next_halfedge_handle(start); h != start; h = mesh.next_halfedge_handle(h)) {
      const Vec3 a = mesh.point(mesh.from_vertex_handle(h)) - origin;
      const Vec3 b = mesh.point(mesh.to_vertex_handle(h)) - origin;
      sum += 0.5 * a.cross(b);
    }
    areas.push_back(sum);
  }
  return areas;
}

}  // namespace

std::size_t mark_feature_edges(PolygonMesh& mesh, double angle) {
  const std::vector<Vec3> areas = face_areas(mesh);
  mesh.add_feature_edges();
  std::size_t marked = 0;
  for (const auto e : mesh.edges()) {
    if (mesh.is_boundary(e)) continue;
    const Vec3& a = areas[static_cast<std::size_t>(mesh.face_handle(mesh.halfedge_handle(e, 0)).idx())];
    const Vec3& b = areas[static_cast<std::size_t>(mesh.face_handle(mesh.halfedge_handle(e, 1)).idx())];
    if (angle_between(a, b) <= angle) continue;
    mesh.set_feature_edge(e, true);
    ++marked;
  }
  return marked;
}

namespace {

std::size_t count_border_loops(const PolygonMesh& mesh) {
  std::vector<bool> seen(mesh.n_halfedges(), false);
  std::size_t loops = 0;
  for (const auto start : mesh.halfedges()) {
    if (!mesh.is_boundary(start) || seen[static_cast<std::size_t>(start.idx())]) continue;
    ++loops;
    Halfedge h = start;
    do {
      seen[static_cast<std::size_t>(h.idx())] = true;
      h = mesh.next_halfedge_handle(h);
    } while (h != start);
  }
  return loops;
}

/// Parts that share no vertex, vertices without faces left out.
std::size_t count_components(const PolygonMesh& mesh) {
  DisjointSets parts(mesh.n_vertices());
  for (const auto e : mesh.edges()) {
    const Halfedge h = mesh.halfedge_handle(e, 0);
    parts.unite(static_cast<Index>(mesh.from_vertex_handle(h).idx()),
                static_cast<Index>(mesh.to_vertex_handle(h).idx()));
  }
  std::size_t components = 0;
  for (const auto v : mesh.vertices()) {
    const auto i = static_cast<Index>(v.idx());
    if (parts.find(i) == i && !mesh.is_isolated(v)) ++components;
  }
  return components;
}

}  // namespace

MeshSummary summarize(const PolygonMesh& mesh) {
  MeshSummary summary;
  summary.vertices = mesh.n_vertices();
  summary.edges = mesh.n_edges();
  summary.faces = mesh.n_faces();
  for (const auto f : mesh.faces()) {
    const auto sides = mesh.valence(f);
    ++(sides == 3 ? summary.triangles : sides == 4 ? summary.quads : summary.larger_polygons);
  }
  for (const auto e : mesh.edges()) summary.border_edges += mesh.is_boundary(e) ? 1u : 0u;
  summary.border_loops = count_border_loops(mesh);
  summary.components = count_components(mesh);
  PolygonSoup points;
  for (const auto v : mesh.vertices()) {
    points.positions.push_back(mesh.point(v));
    summary.box.extend(mesh.point(v));
  }
  summary.split_vertices = merge_identical_vertices(points).changed;
  for (const Vec3& area : face_areas(mesh)) summary.area += area.norm();
  return summary;
}

}  // namespace recede
