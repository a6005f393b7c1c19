// Whether a layer of prisms over a triangle mesh fills space without folds and without meeting itself: the
// proof, by exact signs, that every point of the layer has one place in the mesh and one height.
//
// Why the checks suffice. Take a connected piece of the mesh in whose layer no prism is inverted and whose
// boundary doesn't meet itself. The map from (place in the mesh, height) to space is one-to-one around each
// point: prisms at a common side lie on both sides of what parts them, and those around a vertex surround its
// step once, since all turn the same way and their bottom triangles don't meet. With an open mesh the
// boundary (bottom, walls and top) is one closed surface. It winds around a place at most once, and because
// the map keeps its orientation everywhere, this is how many points come to lie there. With a closed mesh the
// boundary is two such surfaces. Glue to each what it parts from the layer, with a point at infinity: a
// closed space arises that the map, continued, sends to the three-dimensional sphere, one-to-one around each
// point. That is a covering, and the sphere has none but itself. So the layer of one piece is valid. Those of
// two pieces whose boundaries don't meet are apart, or one lies in the other, which no contact shows; a ray
// tells.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>

#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace recede {

struct ShellCheckOptions {
  /// The layer lies behind the triangles: the tops are where the bottoms' backs are.
  bool is_inward = false;
  /// When set, only what the triangles with at least one of these vertices take part in is looked for: after
  /// edits, or in a loop of repairs.
  std::optional<std::span<const Index>> changed_vertices{};
};

/// Which part of a layer's boundary.
enum class ShellPart { bottom, top, wall };

/// The wall over an open side of a mesh may meet another part: the hull of its four corners does.
struct WallContact {
  Index corner = 0;  ///< the side begins at this corner of the list of triangles: corner % 3 of corner / 3
  ShellPart part = ShellPart::bottom;
  Index other = 0;  ///< a triangle, or the corner of the other wall, which is larger
  auto operator<=>(const WallContact&) const = default;
};

/// All lists are sorted. Triangles are given by their numbers; in pairs of the same kind the lower one is
/// first.
struct ShellValidity {
  using Pairs = std::vector<std::pair<Index, Index>>;

  /// Prisms in which the Jacobian isn't above 0 everywhere (below 0 for inward layers); also those without
  /// thickness or area.
  std::vector<Index> inverted;
  /// Triangles that have points in common beside their common vertices and sides.
  Pairs bottom_contacts;
  Pairs top_contacts;
  Pairs layer_contacts;  ///< bottom triangle, top triangle
  std::vector<WallContact> wall_contacts;
  /// Triangles whose prisms overlap next to a side or a vertex that they share, for the mesh isn't a surface
  /// there: they run along the side in the same direction, or one of them belongs to a closed fan around the
  /// vertex and the other one doesn't.
  Pairs overlapping_neighbours;
  /// Connected pieces of the mesh, by their lowest triangles, and other pieces in whose layer their bottom or
  /// top lies. Says something where nothing else is wrong with the two.
  Pairs nested_pieces;

  bool is_valid() const;
  /// False when the bottom meets itself or isn't a surface: no layer over it can be valid then.
  bool has_valid_base() const { return bottom_contacts.empty() && overlapping_neighbours.empty(); }
  bool operator==(const ShellValidity&) const = default;
};

/// Checks the layer of points sum of l_i ((1 - r) bottom_i + r top_i), with weights l_i of a triangle's
/// corners and r from 0 to 1. `triangles` holds three vertex indices each; each vertex has a bottom and a top
/// position. Valid means that these points are different ones all over the mesh; see above for the reason.
///
/// What it says of prisms and triangles is exact for all finite coordinates, up to triangles without area,
/// which are inverted, and may have contacts as well where they only touch. Walls are checked by the hulls
/// of their corners, so a contact of a wall is one that may be. Vertices with different indices are different
/// ones also at the same position, and then their triangles touch: merge them first
/// (`merge_identical_vertices`). Non-empty triangles over the same three vertices always touch. A piece isn't
/// looked for in the layers of others when it shares all its vertices with them.
///
/// With `changed_vertices` the result is the whole one without the entries of which no triangle has such a
/// vertex (for pieces: no triangle of theirs, for walls: neither of the triangles that they stand on).
///
/// Throws `InputError` for lists of unequal length, indices out of range and positions that aren't finite.
/// The same result for any number of threads.
ShellValidity check_shell(std::span<const Vec3> bottom, std::span<const Vec3> top,
                          std::span<const Index> triangles, const ShellCheckOptions& options = {},
                          Progress* progress = nullptr);

}  // namespace recede
