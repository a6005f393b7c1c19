#include <recede/geometry/detail/control_mesh.h>
#include <recede/geometry/disjoint_sets.h>
#include <recede/geometry/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::detail {
namespace {

constexpr double k_largest = 1e70;         // squares of areas of larger things overflow
constexpr std::size_t k_most_edges = 500;  // of a vertex or a face; OpenSubdiv ends at 511

void require_sharpness(double sharpness, const char* what) {
  if (!(sharpness >= 0)) throw OptionError(fmt::format("the sharpness of {} must be 0 or more", what));
}

float stored_sharpness(double sharpness) {
  return static_cast<float>(std::min(sharpness, k_infinite_sharpness));
}

/// Builds the mesh in the order of its members; edges keep their vertices when Loop cuts polygons.
class ControlMeshBuilder {
 public:
  ControlMeshBuilder(const PolygonSoup& control, const SubdivisionOptions& options)
      : control_(control), options_(options) {}

  ControlMesh build() {
    check_options();
    validate(control_, "control mesh");
    if (control_.n_faces() == 0) throw InputError("control mesh: has no faces");
    for (const Vec3& position : control_.positions) {
      if (position.cwiseAbs().maxCoeff() > k_largest)
        throw InputError(fmt::format("control mesh: has positions beyond {}", k_largest));
    }
    check_faces();
    keep_used_vertices();
    check_edges();
    check_vertices();
    find_sharp_edges();
    if (options_.scheme == SubdivisionScheme::loop) cut_polygons();
    set_sharpness();
    number_uvs();
    return std::move(mesh_);
  }

 private:
  void check_options() const {
    if (options_.level < 0 || options_.level > SubdivisionOptions::k_largest_level) {
      throw OptionError(
          fmt::format("the level of subdivision must be 0 to {}", SubdivisionOptions::k_largest_level));
    }
    if (options_.error && !(*options_.error > 0)) throw OptionError("the error must be positive");
    if (options_.crease_angle && !(*options_.crease_angle >= 0 && *options_.crease_angle <= std::numbers::pi))
      throw OptionError("the crease angle must be 0 to 180 degrees");
    require_sharpness(options_.crease_sharpness, "creases");
    require_sharpness(options_.feature_sharpness, "feature edges");
    const std::size_t n = control_.positions.size();
    for (const SubdivisionCrease& crease : options_.creases) {
      require_sharpness(crease.sharpness, "a crease");
      if (crease.first >= n || crease.second >= n) throw no_edge(crease.first, crease.second);
    }
    for (const SubdivisionCorner& corner : options_.corners) {
      require_sharpness(corner.sharpness, "a corner");
      if (corner.vertex >= n) throw OptionError(fmt::format("the corner {} is no vertex", corner.vertex));
    }
  }

  static OptionError no_edge(Index a, Index b) {
    return OptionError(fmt::format("the crease {}-{} is no edge of the control mesh", a, b));
  }

  void check_faces() const {
    std::vector<Index> sorted;
    for (std::size_t f = 0; f < control_.n_faces(); ++f) {
      sorted.assign(control_.face(f).begin(), control_.face(f).end());
      std::sort(sorted.begin(), sorted.end());
      const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
      if (twice != sorted.end())
        throw InputError(fmt::format("control mesh: face {} visits vertex {} twice", f, *twice));
      if (sorted.size() > k_most_edges)
        throw InputError(fmt::format("control mesh: face {} has more than {} sides", f, k_most_edges));
    }
  }

  void keep_used_vertices() {
    PolygonSoup& soup = mesh_.soup;
    new_numbers_.assign(control_.positions.size(), k_no_index);
    for (const Index v : control_.corner_vertices) new_numbers_[v] = 0;
    for (std::size_t v = 0; v < new_numbers_.size(); ++v) {
      if (new_numbers_[v] == k_no_index) continue;
      new_numbers_[v] = static_cast<Index>(old_numbers_.size());
      old_numbers_.push_back(static_cast<Index>(v));
    }
    for (const VertexScalar& scalar : control_.vertex_scalars)
      soup.vertex_scalars.push_back({scalar.name, {}});
    for (const Index old : old_numbers_) {
      soup.positions.push_back(control_.positions[old]);
      if (!control_.vertex_colors.empty()) soup.vertex_colors.push_back(control_.vertex_colors[old]);
      for (std::size_t i = 0; i < control_.vertex_scalars.size(); ++i)
        soup.vertex_scalars[i].values.push_back(control_.vertex_scalars[i].values[old]);
    }
    soup.face_offsets = control_.face_offsets;
    soup.corner_uvs = control_.corner_uvs;
    soup.face_materials = control_.face_materials;
    soup.materials = control_.materials;
    for (const Index v : control_.corner_vertices) soup.corner_vertices.push_back(new_numbers_[v]);
  }

  Index from(Index corner) const { return mesh_.from(corner); }
  Index to(Index corner) const { return mesh_.to(corner); }
  Index after(Index corner) const { return mesh_.after(corner); }
  std::string edge_name(std::span<const Index> sides) const {
    return fmt::format("{}-{}", old_numbers_[from(sides[0])], old_numbers_[to(sides[0])]);
  }

  void check_edges() {
    mesh_.edges = build_edge_table(mesh_.soup);
    for (std::size_t e = 0; e < mesh_.edges.n_edges(); ++e) {
      const auto sides = mesh_.edges.sides(e);
      if (sides.size() > 2)
        throw InputError(fmt::format("control mesh: edge {} has {} faces", edge_name(sides), sides.size()));
      if (sides.size() == 2 && from(sides[0]) == from(sides[1]))
        throw InputError(
            fmt::format("control mesh: the faces of edge {} disagree in orientation", edge_name(sides)));
    }
  }

  /// The corners of a vertex must hang together by edges.
  void check_vertices() const {
    const PolygonSoup& soup = mesh_.soup;
    std::vector<Index> edges(soup.positions.size(), 0);
    for (std::size_t e = 0; e < mesh_.edges.n_edges(); ++e) {
      const Index side = mesh_.edges.sides(e)[0];
      ++edges[from(side)];
      ++edges[to(side)];
    }
    for (std::size_t v = 0; v < edges.size(); ++v) {
      if (edges[v] > k_most_edges) {
        throw InputError(
            fmt::format("control mesh: vertex {} has more than {} edges", old_numbers_[v], k_most_edges));
      }
    }
    // Corners that are joined by edges form fans; one fan has one set.
    DisjointSets fans(soup.n_corners());
    for (std::size_t e = 0; e < mesh_.edges.n_edges(); ++e) {
      const auto sides = mesh_.edges.sides(e);
      if (sides.size() != 2) continue;
      fans.unite(sides[0], after(sides[1]));
      fans.unite(after(sides[0]), sides[1]);
    }
    std::vector<Index> fan_of(soup.positions.size(), k_no_index);
    for (Index c = 0; c < soup.n_corners(); ++c) {
      Index& fan = fan_of[soup.corner_vertices[c]];
      const Index found = fans.find(c);
      if (fan == k_no_index) fan = found;
      if (fan != found) {
        throw InputError(fmt::format("control mesh: several fans of faces touch at vertex {}",
                                     old_numbers_[soup.corner_vertices[c]]));
      }
    }
  }

  using Ends = std::pair<Index, Index>;
  struct SharpEdge {
    Ends ends;
    double sharpness;
  };

  /// While faces are what they were: those of Loop's triangles would find no angle within a polygon.
  void find_sharp_edges() {
    if (options_.feature_sharpness > 0) {
      for (const auto& [a, b] : features()) sharp_.push_back({{a, b}, options_.feature_sharpness});
    }
    if (options_.crease_angle) {
      for (std::size_t e = 0; e < mesh_.edges.n_edges(); ++e) {
        const auto sides = mesh_.edges.sides(e);
        if (sides.size() != 2) continue;
        const Vec3 a = vector_area(mesh_.soup, mesh_.edges.corner_faces[sides[0]]);
        const Vec3 b = vector_area(mesh_.soup, mesh_.edges.corner_faces[sides[1]]);
        if (a.norm() > 0 && b.norm() > 0 && angle_between(a, b) > *options_.crease_angle)
          sharp_.push_back({std::minmax(from(sides[0]), to(sides[0])), options_.crease_sharpness});
      }
    }
    for (const SubdivisionCrease& crease : options_.creases) {
      const Index a = new_numbers_[crease.first], b = new_numbers_[crease.second];
      if (a == k_no_index || b == k_no_index) throw no_edge(crease.first, crease.second);
      sharp_.push_back({std::minmax(a, b), crease.sharpness});
    }
  }

  /// The soup's feature edges whose ends have faces.
  std::vector<Ends> features() const {
    std::vector<Ends> result;
    for (const auto& [a, b] : control_.feature_edges) {
      if (new_numbers_[a] != k_no_index && new_numbers_[b] != k_no_index)
        result.push_back(std::minmax(new_numbers_[a], new_numbers_[b]));
    }
    return result;
  }

  void cut_polygons() {
    PolygonSoup& soup = mesh_.soup;
    for (std::size_t f = 0; f < soup.n_faces(); ++f)
      if (soup.face_size(f) > 3) ++mesh_.triangulated;
    if (mesh_.triangulated == 0) return;
    std::vector<Index> faces, corners;
    std::vector<Index> vertices = triangulate(soup, &faces, &corners);
    if (!soup.face_materials.empty()) {
      std::vector<Index> materials;
      for (const Index f : faces) materials.push_back(soup.face_materials[f]);
      soup.face_materials = std::move(materials);
    }
    if (!soup.corner_uvs.empty()) {
      std::vector<Vec2> uvs;
      for (const Index c : corners) uvs.push_back(soup.corner_uvs[c]);
      soup.corner_uvs = std::move(uvs);
    }
    soup.corner_vertices = std::move(vertices);
    soup.face_offsets.resize(faces.size() + 1);
    for (std::size_t t = 0; t < soup.face_offsets.size(); ++t)
      soup.face_offsets[t] = static_cast<Index>(3 * t);
    check_edges();  // a diagonal may be an edge of another face
    check_vertices();
  }

  std::optional<std::size_t> find_edge(const Ends& ends) const {
    // Edges are sorted by their ends.
    std::size_t low = 0, high = mesh_.edges.n_edges();
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      const Index side = mesh_.edges.sides(middle)[0];
      const Ends at = std::minmax(from(side), to(side));
      if (at == ends) return middle;
      if (at < ends) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return std::nullopt;
  }

  void set_sharpness() {
    mesh_.edge_sharpness.assign(mesh_.edges.n_edges(), 0);
    mesh_.is_feature.assign(mesh_.edges.n_edges(), false);
    mesh_.vertex_sharpness.assign(mesh_.soup.positions.size(), 0);
    const std::size_t first_named = sharp_.size() - options_.creases.size();
    for (std::size_t i = 0; i < sharp_.size(); ++i) {
      const auto edge = find_edge(sharp_[i].ends);
      if (edge) {
        mesh_.edge_sharpness[*edge] = stored_sharpness(sharp_[i].sharpness);
      } else if (i >= first_named) {
        const SubdivisionCrease& crease = options_.creases[i - first_named];
        throw no_edge(crease.first, crease.second);
      }
    }
    for (const Ends& ends : features()) {
      if (const auto edge = find_edge(ends)) mesh_.is_feature[*edge] = true;
    }
    for (const SubdivisionCorner& corner : options_.corners) {
      const Index v = new_numbers_[corner.vertex];
      if (v != k_no_index) mesh_.vertex_sharpness[v] = stored_sharpness(corner.sharpness);
    }
  }

  void number_uvs() {
    const PolygonSoup& soup = mesh_.soup;
    if (soup.corner_uvs.empty()) return;
    DisjointSets sets(soup.n_corners());
    for (std::size_t e = 0; e < mesh_.edges.n_edges(); ++e) {
      const auto sides = mesh_.edges.sides(e);
      if (sides.size() != 2) continue;
      for (const auto& [a, b] : {Ends(sides[0], after(sides[1])), Ends(after(sides[0]), sides[1])}) {
        if (soup.corner_uvs[a] == soup.corner_uvs[b]) sets.unite(a, b);
      }
    }
    std::vector<Index> numbers(soup.n_corners(), k_no_index);
    for (std::size_t c = 0; c < soup.n_corners(); ++c) {
      Index& number = numbers[sets.find(static_cast<Index>(c))];
      if (number == k_no_index) number = static_cast<Index>(mesh_.n_uv_numbers++);
      mesh_.corner_uv_numbers.push_back(number);
    }
  }

  const PolygonSoup& control_;
  const SubdivisionOptions& options_;
  ControlMesh mesh_;
  std::vector<Index> new_numbers_, old_numbers_;  // of vertices
  std::vector<SharpEdge> sharp_;                  // later ones count; the named ones stand last
};

}  // namespace

ControlMesh make_control_mesh(const PolygonSoup& control, const SubdivisionOptions& options) {
  return ControlMeshBuilder(control, options).build();
}

void require_few_facets(const ControlMesh& control, SubdivisionScheme scheme, int level,
                        const std::string& wish) {
  const bool is_loop = scheme == SubdivisionScheme::loop;
  double faces =
      static_cast<double>(is_loop || level == 0 ? control.soup.n_faces() : control.soup.n_corners());
  for (int l = is_loop ? 0 : 1; l < level; ++l) faces *= 4;
  if (faces <= static_cast<double>(SubdivisionOptions::k_most_faces)) return;
  throw OptionError(fmt::format("{}level {} would have {:.0f} faces, more than {}", wish, level, faces,
                                SubdivisionOptions::k_most_faces));
}

}  // namespace recede::detail
