// The undirected edges of a soup, each with the corners whose sides lie on it.
#pragma once

#include <recede/geometry/polygon_soup.h>

namespace recede::detail {

/// A corner's side runs from its vertex to the next corner's vertex of the same face.
struct EdgeTable {
  std::vector<Index> edge_of_corner;  ///< edge on which the corner's side lies
  std::vector<Index> edge_offsets;    ///< E + 1 entries: edge e has sides [offsets[e], offsets[e+1])
  std::vector<Index> edge_corners;    ///< corners, grouped by edge, ascending
  std::vector<Index> corner_faces;    ///< face of each corner

  std::size_t n_edges() const { return edge_offsets.size() - 1; }
  std::span<const Index> sides(std::size_t edge) const {
    return {edge_corners.data() + edge_offsets[edge], edge_offsets[edge + 1] - edge_offsets[edge]};
  }
};

/// Edges are numbered by their lower vertex, then by their upper one.
EdgeTable build_edge_table(std::size_t n_vertices, std::span<const Index> corner_vertices,
                           std::span<const Index> face_offsets);
inline EdgeTable build_edge_table(const PolygonSoup& soup) {
  return build_edge_table(soup.positions.size(), soup.corner_vertices, soup.face_offsets);
}

/// The corner after `corner` in its face.
inline Index next_corner(const PolygonSoup& soup, const std::vector<Index>& corner_faces, Index corner) {
  const Index face = corner_faces[corner];
  return corner + 1 == soup.face_offsets[face + 1] ? soup.face_offsets[face] : corner + 1;
}

}  // namespace recede::detail
