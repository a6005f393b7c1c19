#include <recede/geometry/error.h>
#include <recede/lod/detail/loop_triangulation.h>

namespace recede::detail {

namespace {

void check_inside(const ConstrainedDelaunay& delaunay) {
  bool is_empty = true;
  for (const DelaunayTriangle& triangle : delaunay.triangles()) {
    if (!triangle.is_inside) continue;
    is_empty = false;
    for (int k = 0; k < 3; ++k) {
      const Index across = triangle.neighbour(k);
      const bool is_border = across == k_no_index || !delaunay.is_inside(across);
      if (is_border && triangle.turns[static_cast<std::size_t>(k)] < 0)
        throw InputError("loops of a patch run the wrong way around it");
    }
  }
  if (is_empty) throw InputError("loops of a patch go around nothing");
}

}  // namespace

ConstrainedDelaunay triangulate_loops(std::span<const Vec2> points,
                                      std::span<const std::array<Index, 2>> edges) {
  ConstrainedDelaunay delaunay(points, edges);
  delaunay.keep_inside(InsideRule::winding);
  check_inside(delaunay);
  return delaunay;
}

}  // namespace recede::detail
