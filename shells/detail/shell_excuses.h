// Triangles over which no layer is valid, and what can be valid beside them.
#pragma once

#include <recede/shells/detail/layer_boundary.h>
#include <recede/shells/detail/shell_directors.h>

#include <span>
#include <vector>

namespace recede::detail {

/// See `ShellLayer::excused`. `validity` is that of any layer over the surface: its bottom is looked at.
std::vector<Index> find_excused_triangles(const ShellSurface& surface, const ShellValidity& validity);

/// The layer with some triangles excused, ascending: see `LayerCheck`. Its pieces are those of the rest, and
/// its walls also stand where the rest is open.
LayerBoundary excusing(LayerBoundary layer, std::span<const Index> excused);

}  // namespace recede::detail
