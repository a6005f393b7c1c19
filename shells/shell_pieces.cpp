#include <recede/geometry/detail/edge_table.h>
#include <recede/geometry/disjoint_sets.h>
#include <recede/shells/detail/shell_pieces.h>

#include <algorithm>

namespace recede::detail {
namespace {

EdgeTable edge_table_of(std::size_t n_vertices, std::span<const Index> triangles) {
  std::vector<Index> offsets(triangles.size() / 3 + 1);
  for (std::size_t t = 0; t < offsets.size(); ++t) offsets[t] = static_cast<Index>(3 * t);
  return build_edge_table(n_vertices, triangles, offsets);
}

std::vector<Index> open_sides_of(const EdgeTable& edges) {
  std::vector<Index> sides;
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    if (edges.sides(e).size() == 1) sides.push_back(edges.sides(e)[0]);
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

std::pair<Index, Index> ascending(Index a, Index b) { return std::minmax(a, b); }

/// Prisms of triangles that run along a side in the same direction lie on the same side of it.
void add_overlaps_at_edges(std::span<const Index> triangles, const EdgeTable& edges, ShellPieces& pieces) {
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    const std::span<const Index> sides = edges.sides(e);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      for (std::size_t j = i + 1; j < sides.size(); ++j) {
        if (triangles[sides[i]] != triangles[sides[j]]) continue;
        pieces.overlapping_neighbours.push_back(ascending(sides[i] / 3, sides[j] / 3));
      }
    }
  }
}

/// A closed fan of prisms fills the space around the step of its vertex, and leaves none for other triangles.
void add_overlaps_at_vertices(std::size_t n_vertices, std::span<const Index> triangles,
                              const EdgeTable& edges, ShellPieces& pieces) {
  // Corners at the same vertex whose triangles are connected there, named by the lowest one.
  DisjointSets fans(triangles.size());
  std::vector<char> is_open(triangles.size(), 0);
  const auto for_ends = [&](Index first, Index other, auto&& act) {
    const Index corners[] = {first, next_in_triangle(first)}, others[] = {other, next_in_triangle(other)};
    for (const Index a : corners) {
      for (const Index b : others) {
        if (triangles[a] == triangles[b]) act(a, b);
      }
    }
  };
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    const std::span<const Index> sides = edges.sides(e);
    for (std::size_t i = 1; i < sides.size(); ++i) {
      for_ends(sides[0], sides[i], [&](Index a, Index b) { fans.unite(a, b); });
    }
  }
  for (const Index wall : pieces.walls) {
    for_ends(wall, wall, [&](Index a, Index) { is_open[fans.find(a)] = 1; });
  }
  std::vector<Index> closed_fan(n_vertices, k_no_index);
  for (std::size_t c = triangles.size(); c-- > 0;) {
    const auto corner = static_cast<Index>(c);
    if (fans.find(corner) == corner && is_open[corner] == 0) closed_fan[triangles[corner]] = corner;
  }
  for (std::size_t c = 0; c < triangles.size(); ++c) {
    const auto corner = static_cast<Index>(c);
    const Index closed = closed_fan[triangles[corner]];
    if (fans.find(corner) != corner || closed == k_no_index || closed == corner) continue;
    pieces.overlapping_neighbours.push_back(ascending(closed / 3, corner / 3));
  }
}

void number_pieces(std::size_t n_triangles, const EdgeTable& edges, ShellPieces& pieces) {
  DisjointSets sets(n_triangles);
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    const std::span<const Index> sides = edges.sides(e);
    for (std::size_t i = 1; i < sides.size(); ++i) sets.unite(sides[0] / 3, sides[i] / 3);
  }
  pieces.piece_of_triangle.resize(n_triangles);
  for (std::size_t t = 0; t < n_triangles; ++t) {
    const auto triangle = static_cast<Index>(t);
    const Index first = sets.find(triangle);  // the lowest one
    if (first == triangle) {
      pieces.piece_of_triangle[t] = static_cast<Index>(pieces.n_pieces());
      pieces.first_triangle.push_back(triangle);
    } else {
      pieces.piece_of_triangle[t] = pieces.piece_of_triangle[first];
    }
  }
}

}  // namespace

std::vector<Index> find_open_sides(std::size_t n_vertices, std::span<const Index> triangles) {
  return open_sides_of(edge_table_of(n_vertices, triangles));
}

ShellPieces find_shell_pieces(std::size_t n_vertices, std::span<const Index> triangles) {
  const EdgeTable edges = edge_table_of(n_vertices, triangles);
  ShellPieces pieces;
  pieces.walls = open_sides_of(edges);
  add_overlaps_at_edges(triangles, edges, pieces);
  add_overlaps_at_vertices(n_vertices, triangles, edges, pieces);
  auto& overlaps = pieces.overlapping_neighbours;
  std::sort(overlaps.begin(), overlaps.end());
  overlaps.erase(std::unique(overlaps.begin(), overlaps.end()), overlaps.end());
  number_pieces(triangles.size() / 3, edges, pieces);
  return pieces;
}

}  // namespace recede::detail
