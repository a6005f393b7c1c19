// What is wrong with a surface besides its distance from another.
#pragma once

#include <recede/geometry/polygon_soup.h>

namespace recede::bench {

struct SurfaceDefects {
  std::size_t border_edges = 0;        ///< edges of one face
  std::size_t non_manifold_edges = 0;  ///< edges of more than two faces
  std::size_t degenerate_faces = 0;    ///< less than three different vertices, or no area to speak of
};

/// Counts after merging vertices at the same position, so that copies of split vertices aren't borders.
SurfaceDefects count_defects(PolygonSoup soup);

/// What of `now` wasn't there `before`, by counts.
SurfaceDefects new_defects(const SurfaceDefects& now, const SurfaceDefects& before);

/// Share of the faces with four sides, 0 to 1.
double quad_share(const PolygonSoup& soup);

}  // namespace recede::bench
