// How a height map lies on a surface: how far it stretches there, and how long its waves are.
#pragma once

#include <recede/geometry/displacement_map.h>
#include <recede/geometry/polygon_soup.h>

#include <vector>

namespace recede {

/// How the texture coordinates of a surface stretch over it.
struct MapStretch {
  Vec2 sides = Vec2::Ones();   ///< lengths of steps of 1 in u and in v on the surface: means by area
  Vec2 spread = Vec2::Zero();  ///< their standard deviations as shares of the means, by area
};

/// Triangles without area in the texture are left out. Throws `InputError` for a surface that
/// `validate` refuses, without texture coordinates, or on which all of them lie on a line.
MapStretch measure_stretch(const PolygonSoup& surface);

/// The length of a typical wave of heights: 2 pi times the RMS of heights over that of slopes, for a sine its
/// wavelength. In object units when `sides` are; 0 for a flat map.
/// `counted` says by texel, row by row, which of them count; empty: all.
double mean_wavelength(const DisplacementMap& map, const Vec2& sides, const std::vector<bool>& counted = {});

/// Which texels' middles lie in a triangle of the surface, row by row. Texture coordinates beyond the unit
/// square cover none.
std::vector<bool> covered_texels(const PolygonSoup& surface, int columns, int rows);

}  // namespace recede
