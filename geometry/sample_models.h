// Models made by code: for the demonstration, tests and benchmarks. The same bytes on every call.
#pragma once

#include <recede/geometry/polygon_soup.h>

namespace recede {

/// The Utah teapot (Martin Newell, 1975; public domain) as quads, z up, 6.5 units wide: 32 Bezier patches of
/// `quads_per_side` squared quads each, triangles where a patch runs into a point. Shared borders of patches
/// are evaluated from the same control points in one order and merged, so that the surface has no cracks but
/// the openings of the original (under the lid, at handle and spout). Every vertex then moves along its
/// normal by `relief` units times a smooth noise between -1 and 1. Throws `OptionError` for less than one
/// quad.
PolygonSoup make_teapot(std::size_t quads_per_side = 40, double relief = 0.02);

/// A sphere of radius 1 with ridges of six octaves of noise, of 6 n^2 quads over the faces of a cube or twice
/// as many triangles; n is chosen so that there are at least `faces` of them. Closed and manifold.
PolygonSoup make_displaced_sphere(std::size_t faces, bool triangles);

struct TreeOptions {
  std::size_t leaves = 2400;  ///< more than that are smaller, so that the crown is as dense
  std::uint32_t seed = 1;     ///< the same one: the same tree
};

/// A broad-leaved tree, y up and about 10 units high, of about 13 000 triangles: trunk and branches as bent
/// tubes that end in points (material `bark`), and at the twigs' ends leaves of four triangles each, folded
/// and bent, seen from both sides (material `leaves`). Vertex colours are factors, a tint for each leaf.
/// Nothing connects its parts; no face is without area.
PolygonSoup make_tree(const TreeOptions& options = {});

}  // namespace recede
