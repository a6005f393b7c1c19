#include "surface_defects.h"

#include <algorithm>
#include <utility>

namespace recede::bench {
namespace {

/// Faces thinner than this, area over the square of the longest side, count as degenerate.
constexpr double k_no_area = 1e-10;

bool is_degenerate(const PolygonSoup& soup, std::size_t face) {
  const auto vertices = soup.face(face);
  std::vector<Index> different(vertices.begin(), vertices.end());
  std::sort(different.begin(), different.end());
  different.erase(std::unique(different.begin(), different.end()), different.end());
  if (different.size() < 3) return true;
  double longest = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec3& here = soup.positions[vertices[i]];
    const Vec3& next = soup.positions[vertices[(i + 1) % vertices.size()]];
    longest = std::max(longest, (next - here).squaredNorm());
  }
  return !(vector_area(soup, face).norm() > k_no_area * longest);
}

}  // namespace

SurfaceDefects count_defects(PolygonSoup soup) {
  merge_identical_vertices(soup);
  SurfaceDefects defects;
  std::vector<std::pair<Index, Index>> edges;
  edges.reserve(soup.n_corners());
  for (std::size_t face = 0; face < soup.n_faces(); ++face) {
    if (is_degenerate(soup, face)) ++defects.degenerate_faces;
    const auto vertices = soup.face(face);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      edges.push_back(std::minmax(vertices[i], vertices[(i + 1) % vertices.size()]));
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    while (last < edges.size() && edges[last] == edges[first]) ++last;
    if (last - first == 1) ++defects.border_edges;
    if (last - first > 2) ++defects.non_manifold_edges;
  }
  return defects;
}

SurfaceDefects new_defects(const SurfaceDefects& now, const SurfaceDefects& before) {
  const auto excess = [](std::size_t more, std::size_t less) { return more > less ? more - less : 0; };
  return {excess(now.border_edges, before.border_edges),
          excess(now.non_manifold_edges, before.non_manifold_edges),
          excess(now.degenerate_faces, before.degenerate_faces)};
}

double quad_share(const PolygonSoup& soup) {
  if (soup.n_faces() == 0) return 0;
  std::size_t quads = 0;
  for (std::size_t face = 0; face < soup.n_faces(); ++face) quads += soup.face_size(face) == 4;
  return static_cast<double>(quads) / static_cast<double>(soup.n_faces());
}

}  // namespace recede::bench
