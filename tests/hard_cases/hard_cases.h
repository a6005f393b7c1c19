// Meshes that break simplifiers, made by code.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace recede::test {

struct HardCase {
  std::string name, description;
  PolygonSoup soup;
  std::string refusal{};     ///< part of the error text when no operation may take it; empty: all must
  bool closed_flat = false;  ///< simplification may not change the surface at all
};
/// For the names of tests.
void PrintTo(const HardCase& hard_case, std::ostream* out);

/// All cases, a few hundred to some thousand faces each.
std::vector<HardCase> hard_cases();

/// More of the same kinds, up to some ten thousand faces: for benchmarks.
std::vector<HardCase> large_hard_cases();

// Those that tests look at one by one.
PolygonSoup sliver_strip(Index n);                  ///< 2 n triangles of aspect 1e9
PolygonSoup collapsed_grid(Index n);                ///< n x n cells of which 24 in 25 have no area
PolygonSoup book_of_sheets(Index sheets, Index n);  ///< sheets that share one spine
PolygonSoup loose_cubes(Index n);                   ///< n cubes that don't touch, 12 triangles each
PolygonSoup wound_wrong(const PolygonSoup& soup, Index seed);  ///< a third of the faces flipped
PolygonSoup double_sided_sheet(Index n);                       ///< every face twice, in both orientations
PolygonSoup touching_boxes();                                  ///< two closed boxes with a common wall

// Ways to spoil a mesh.
void append(PolygonSoup& to, const PolygonSoup& part);  ///< that shares nothing with it
PolygonSoup transformed(PolygonSoup soup, double scale, const Vec3& offset);
PolygonSoup unwelded(const PolygonSoup& soup);    ///< faces that share no vertex
PolygonSoup with_duplicates(PolygonSoup soup);    ///< every seventh face twice
PolygonSoup with_caps(PolygonSoup soup);          ///< triangles over edges and their middles, without area
PolygonSoup with_fins(PolygonSoup soup);          ///< third faces at edges, outwards from the origin
PolygonSoup with_holes(const PolygonSoup& soup);  ///< without every 37th face

/// Vertices and faces in another order, and faces that start elsewhere; the same surface.
PolygonSoup shuffled(const PolygonSoup& soup, unsigned seed);

}  // namespace recede::test
