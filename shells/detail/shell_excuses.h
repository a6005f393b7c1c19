// Triangles over which no layer is valid, and what can be valid beside them.
#pragma once

#include <recede/shells/detail/shell_directors.h>

#include <span>
#include <vector>

namespace recede::detail {

/// See `ShellLayer::excused`. `validity` is that of any layer over the surface: its bottom is looked at.
std::vector<Index> find_excused_triangles(const ShellSurface& surface, const ShellValidity& validity);

/// Checks of a layer that say nothing of what some triangles do among themselves, but all of the rest:
/// whether it is valid by itself, with walls around what is left out, and where it meets what is left out.
class ExcusingCheck {
 public:
  ExcusingCheck(const ShellSurface& surface, double side, std::span<const Index> excused);

  /// With vertices only what their triangles take part in; with none, everything.
  ShellValidity operator()(std::span<const Vec3> tops, std::span<const Index> changed,
                           Progress* progress) const;

 private:
  const ShellSurface& surface_;
  double side_;
  std::vector<unsigned char> is_excused_;  // of each triangle; empty: none is
  std::vector<Index> rest_;                // the other triangles
  std::vector<Index> rest_corners_;        // three vertices of each
};

}  // namespace recede::detail
