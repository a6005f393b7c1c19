// What the triangles alone say about a layer over them: its walls, its pieces, and where it can't be valid
// whatever the positions.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <span>
#include <utility>
#include <vector>

namespace recede::detail {

/// The next corner of a corner's triangle.
inline Index next_in_triangle(Index corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

/// The one before it.
inline Index previous_in_triangle(Index corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

/// Corners from which a side that only one triangle has runs to the next corner of the triangle; ascending.
std::vector<Index> find_open_sides(std::size_t n_vertices, std::span<const Index> triangles);

struct ShellPieces {
  std::vector<Index> walls;  ///< at open sides, by their corners
  /// See `ShellValidity`.
  std::vector<std::pair<Index, Index>> overlapping_neighbours;
  /// Triangles connected over sides are one piece; pieces are numbered by their lowest triangles.
  std::vector<Index> piece_of_triangle;
  std::vector<Index> first_triangle;  ///< of each piece

  std::size_t n_pieces() const { return first_triangle.size(); }
};

ShellPieces find_shell_pieces(std::size_t n_vertices, std::span<const Index> triangles);

}  // namespace recede::detail
