#include <recede/geometry/detail/plane_predicates.h>
#include <recede/shells/detail/shell_excuses.h>

#include <algorithm>

namespace recede::detail {

namespace {

// Exact, as that of prisms is.
bool has_area(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto flat = [&](const Vec3& p) { return Vec2(p[(axis + 1) % 3], p[(axis + 2) % 3]); };
    if (orientation(flat(a), flat(b), flat(c)) != 0) return true;
  }
  return false;
}

}  // namespace

std::vector<Index> find_excused_triangles(const ShellSurface& surface, const ShellValidity& validity) {
  const std::size_t n = surface.triangles.size() / 3;
  // Around a hopeless vertex no prisms fit together, in whatever direction they stand.
  std::vector<unsigned char> is_excused(n, 0), is_hopeless(surface.positions.size(), 0);
  for (const ShellValidity::Pairs* pairs : {&validity.bottom_contacts, &validity.overlapping_neighbours}) {
    for (const auto& [a, b] : *pairs) {
      is_excused[a] = is_excused[b] = 1;
      // Two that meet beside a common vertex do so up to it: the triangles there run through each other.
      const std::span<const Index> own = surface.triangles.subspan(3 * std::size_t{a}, 3),
                                   others = surface.triangles.subspan(3 * std::size_t{b}, 3);
      for (const Index v : own) {
        if (std::find(others.begin(), others.end(), v) != others.end()) is_hopeless[v] = 1;
      }
    }
  }
  for (std::size_t t = 0; t < n; ++t) {
    const std::span<const Index> corners = surface.triangles.subspan(3 * t, 3);
    const Vec3 &a = surface.positions[corners[0]], &b = surface.positions[corners[1]],
               &c = surface.positions[corners[2]];
    if (!has_area(a, b, c)) is_excused[t] = 1;
    const Vec3 normal = (b - a).cross(c - a).stableNormalized();
    for (const Index v : corners) {
      if (!(normal.dot(surface.normals[v]) > 0)) is_hopeless[v] = 1;
    }
  }
  std::vector<Index> excused;
  for (std::size_t t = 0; t < n; ++t) {
    const std::span<const Index> corners = surface.triangles.subspan(3 * t, 3);
    const bool is_around =
        std::any_of(corners.begin(), corners.end(), [&](Index v) { return is_hopeless[v] != 0; });
    if (is_excused[t] != 0 || is_around) excused.push_back(static_cast<Index>(t));
  }
  return excused;
}

LayerBoundary excusing(LayerBoundary layer, std::span<const Index> excused) {
  if (excused.empty()) return layer;
  using Kind = LayerBoundary::Kind;
  const std::size_t n = layer.n_triangles();
  std::vector<Kind> of_triangles(n, Kind::plain);
  for (const Index t : excused) of_triangles[t] = Kind::excused;
  std::vector<Index> rest, corners;
  for (std::size_t t = 0; t < n; ++t) {
    if (of_triangles[t] == Kind::excused) continue;
    rest.push_back(static_cast<Index>(t));
    for (std::size_t k = 0; k < 3; ++k) corners.push_back(layer.triangles[3 * t + k]);
  }
  const ShellPieces whole = std::move(layer.pieces), alone = find_shell_pieces(layer.n_vertices(), corners);
  ShellPieces& pieces = layer.pieces;
  pieces = {};
  // What is open in the whole mesh is so in the rest, too.
  for (const Index corner : alone.walls) pieces.walls.push_back(3 * rest[corner / 3] + corner % 3);
  for (const Index corner : whole.walls) {
    if (of_triangles[corner / 3] == Kind::excused) pieces.walls.push_back(corner);
  }
  std::sort(pieces.walls.begin(), pieces.walls.end());
  for (const auto& pair : whole.overlapping_neighbours) {
    if (of_triangles[pair.first] == Kind::plain || of_triangles[pair.second] == Kind::plain)
      pieces.overlapping_neighbours.push_back(pair);
  }
  pieces.piece_of_triangle.assign(n, k_no_index);
  for (std::size_t i = 0; i < rest.size(); ++i)
    pieces.piece_of_triangle[rest[i]] = alone.piece_of_triangle[i];
  for (const Index first : alone.first_triangle) pieces.first_triangle.push_back(rest[first]);
  layer.kinds = of_triangles;
  layer.kinds.insert(layer.kinds.end(), of_triangles.begin(), of_triangles.end());
  for (const Index corner : pieces.walls) {
    const bool is_inner = !std::binary_search(whole.walls.begin(), whole.walls.end(), corner);
    layer.kinds.push_back(is_inner ? Kind::inner_wall : of_triangles[corner / 3]);
  }
  return layer;
}

}  // namespace recede::detail
