// Shapes by formulas, with narrow places in which layers get into each other's way.
#pragma once

#include <recede/geometry/polygon_soup.h>

namespace recede::bench {

/// A sheet bent along x = 0, so that its front is the narrower the more it turns (radians), around a radius.
/// Of finer rows or sides lengths in the fold stay within 0.003 of a thickness of 0.3.
constexpr int k_strip_sides = 192, k_strip_rows = 32;
PolygonSoup bent_strip(double turning, double radius);

/// A ball of radius 1 and 12 n^2 triangles, with spikes along the twelve corners of an icosahedron and
/// notches along the twenty of a dodecahedron.
PolygonSoup spiky_ball(int n);

/// The same with two ears instead, thin along x.
PolygonSoup eared_ball(int n);

/// A tube bent to 5/6 of a circle of radius 1, with round ends.
PolygonSoup hook();

constexpr double k_notch_gap = 0.3;
constexpr std::size_t k_notch_rows = 5;

/// Two arms with a gap between them that ends in a notch: a profile, drawn out along y in rows.
PolygonSoup notch_and_arms();

}  // namespace recede::bench
