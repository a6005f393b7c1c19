// The boundary of a layer as a list of triangles and tetrahedra.
#pragma once

#include <recede/shells/detail/box_tree.h>
#include <recede/shells/detail/shell_pieces.h>
#include <recede/shells/detail/simplex_contact.h>

#include <span>
#include <vector>

namespace recede::detail {

/// The parts of the boundary have numbers: the bottom triangles first, then the top ones, then the hulls of
/// the walls.
struct LayerBoundary {
  std::vector<Vec3> points;  ///< the bottom positions, then the top ones
  std::span<const Index> triangles;
  ShellPieces pieces;
  /// Of each part; empty: all are plain. Excused ones aren't compared with each other, and inner walls, which
  /// stand around excused triangles, with none of them.
  enum class Kind : unsigned char { plain, excused, inner_wall };
  std::vector<Kind> kinds{};

  Index n_vertices() const { return static_cast<Index>(points.size() / 2); }
  Index n_triangles() const { return static_cast<Index>(triangles.size() / 3); }
  std::size_t n_parts() const { return 2 * std::size_t{n_triangles()} + pieces.walls.size(); }

  bool is_wall(Index part) const { return part >= 2 * n_triangles(); }
  /// The corner at which a wall begins.
  Index wall_corner(Index part) const { return pieces.walls[part - 2 * n_triangles()]; }
  /// The triangle that a part belongs to.
  Index triangle(Index part) const {
    if (is_wall(part)) return wall_corner(part) / 3;
    return part < n_triangles() ? part : part - n_triangles();
  }
  bool is_excused(Index part) const { return !kinds.empty() && kinds[part] == Kind::excused; }
  bool are_compared(Index a, Index b) const {
    return kinds.empty() || kinds[a] == Kind::plain || kinds[b] == Kind::plain ||
           (kinds[a] == Kind::inner_wall && kinds[b] == Kind::inner_wall);
  }
  /// The corners of a wall: its bottom side, then the top one, in the same direction.
  Simplex simplex(Index part) const;
};

BoxTree::Box box_of_part(const LayerBoundary& layer, Index part);
std::vector<BoxTree::Box> boxes_of_parts(const LayerBoundary& layer);

/// See `ShellValidity`. `tree` is that of the layer's parts. Triangles without a piece don't count.
std::vector<std::pair<Index, Index>> find_nested_pieces(const LayerBoundary& layer, const BoxTree& tree);

}  // namespace recede::detail
