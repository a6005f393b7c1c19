// Parts of soups: cut out, put together, and as bytes.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <span>
#include <string>
#include <string_view>

namespace recede::detail {

/// The corners of some faces with all that faces and corners have; vertices keep their numbers and stay
/// behind.
PolygonSoup take_faces(const PolygonSoup& soup, std::span<const Index> faces);

/// Some faces with the vertices that they use, in the same order, all with what they have. `vertices`
/// receives their numbers in `soup`. Materials stay behind, and so do feature edges.
PolygonSoup cut_out(const PolygonSoup& soup, std::span<const Index> faces, std::vector<Index>& vertices);

/// Appends vertices and faces. What one of both lacks becomes zero there, colours 1, materials none; the
/// longer list of materials counts for both.
void append(PolygonSoup& soup, const PolygonSoup& more);

/// All of a soup but materials and feature edges, for this machine.
std::string to_bytes(const PolygonSoup& soup);
PolygonSoup soup_from_bytes(std::string_view bytes);

}  // namespace recede::detail
