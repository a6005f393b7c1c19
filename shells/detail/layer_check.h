// Checks of a layer again and again while its tops move.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/shells/detail/layer_boundary.h>
#include <recede/shells/shell_validity.h>

#include <memory>
#include <span>
#include <vector>

namespace recede::detail {

/// What `check_shell` finds, without finding out anew what doesn't change: how the mesh is connected, and
/// where its bottom meets itself. Boxes follow the tops in the same tree.
///
/// With excused triangles it says nothing of what these do among themselves, but all of the rest: whether it
/// is valid by itself, with walls around what is left out, and where it meets what is left out. Pieces are
/// those of the rest: of what meets itself, a ray tells nothing.
class LayerCheck {
 public:
  /// Positions and triangles are referred to. Throws as `check_shell`.
  LayerCheck(std::span<const Vec3> bottom, std::span<const Vec3> top, std::span<const Index> triangles,
             std::span<const Index> excused, bool is_inward, Progress* progress);

  /// Triangles that are excused have none.
  const ShellPieces& pieces() const { return layer_.pieces; }

  /// All of it.
  ShellValidity check_all() const;

  /// Takes over the tops of some vertices and returns what their triangles' prisms, tops and walls take part
  /// in: of pairs, those with a part that moved.
  ShellValidity check_moved(std::span<const Vec3> top, std::span<const Index> vertices);

 private:
  void add_nested_pieces(ShellValidity& validity) const;

  LayerBoundary layer_;
  bool is_inward_;
  Progress* progress_;
  std::vector<std::size_t> starts_;  // of each vertex
  std::vector<Index> around_;        // triangles
  BoxTree tree_;
  std::vector<unsigned char> has_moved_;  // of each part; none outside of `check_moved`
};

}  // namespace recede::detail
