// How often a volume texture lies over a shell.
#pragma once

#include <recede/shells/shell.h>

namespace recede {

/// Periods along s and t to a texture coordinate of 1, with which a texture keeps its proportions: periods of
/// `extent` (s, t, r) are as wide as the layer's mean thickness asks for. Lengths of texture coordinates are
/// means over the surface, by area. Whole numbers, so that a texture meets itself where coordinates go round
/// the surface, and at least 1. Throws `InputError` for a shell without the layer or texture coordinates.
Vec2 proportionate_repeat(const Shell& shell, ShellSide side, const Vec3& extent);

}  // namespace recede
