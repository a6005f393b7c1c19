// Whether two soups are the same to the last bit.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <cstring>
#include <string>

namespace recede::test {

template <typename List>
bool same_bytes(const List& a, const List& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0);
}

/// The first list in which two soups differ by a bit, the signs of zeros counted; "" when they are the same.
inline std::string first_difference(const PolygonSoup& a, const PolygonSoup& b) {
  if (!same_bytes(a.positions, b.positions)) return "positions";
  if (a.face_offsets != b.face_offsets) return "face_offsets";
  if (a.corner_vertices != b.corner_vertices) return "corner_vertices";
  if (!same_bytes(a.corner_uvs, b.corner_uvs)) return "corner_uvs";
  if (!same_bytes(a.corner_normals, b.corner_normals)) return "corner_normals";
  if (!same_bytes(a.vertex_colors, b.vertex_colors)) return "vertex_colors";
  if (a.face_materials != b.face_materials) return "face_materials";
  if (a.feature_edges != b.feature_edges) return "feature_edges";
  if (a.materials != b.materials) return "materials";
  if (a.vertex_scalars.size() != b.vertex_scalars.size()) return "vertex_scalars";
  for (std::size_t i = 0; i < a.vertex_scalars.size(); ++i) {
    if (a.vertex_scalars[i].name != b.vertex_scalars[i].name ||
        !same_bytes(a.vertex_scalars[i].values, b.vertex_scalars[i].values))
      return "vertex_scalars";
  }
  return "";
}

}  // namespace recede::test
