// Triangles of a level for the report's viewer, in few bytes.
#pragma once

#include <recede/geometry/closest_point.h>
#include <recede/geometry/polygon_soup.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace recede::detail {

/// A vertex for each look: corners of one point with other normals, colours or texture coordinates have
/// vertices of their own.
struct ViewerMesh {
  std::array<std::vector<std::uint16_t>, 3> positions;  ///< shares of a box, 65535 is its far side
  std::vector<std::uint16_t> distances;                 ///< to the input, shares of `largest_distance`
  std::array<std::vector<std::uint16_t>, 2> normals;    ///< octahedral, 0 to 1022 are -1 to 1
  std::array<std::vector<std::uint8_t>, 3> colors;      ///< sRGB
  std::array<std::vector<std::uint16_t>, 2> uvs;        ///< 65535 is 1; empty without `with_uvs`
  std::vector<Index> indices;                           ///< three for each triangle
  double largest_distance = 0;                          ///< object units
};

/// The triangles of `triangulate`. `box` must hold all positions, and 0 to 1 all texture coordinates where
/// they are wanted.
ViewerMesh viewer_mesh(const PolygonSoup& level, const Box3& box, const ClosestPointTree& input,
                       bool with_uvs = false);

/// The lists of a `ViewerMesh` in their order, vertices before indices. Each is stored as differences from
/// the value before (from 0 for the first), modulo its range; the lowest bytes of all values come first,
/// then the next. All that is compressed (zlib) and written as base64.
std::string pack(const ViewerMesh& mesh);

}  // namespace recede::detail
