// Polygons into a file and back.
#pragma once

#include <recede/geometry/mesh_io.h>

namespace recede::bench {

/// Whether the file that is written gives the same positions and faces, in the same order.
inline bool comes_back_from(const std::filesystem::path& file, const PolygonSoup& soup) {
  write_soup(file, soup);
  const PolygonSoup back = read_soup(file);
  return back.positions == soup.positions && back.face_offsets == soup.face_offsets &&
         back.corner_vertices == soup.corner_vertices;
}

}  // namespace recede::bench
