#include <recede/geometry/disjoint_sets.h>
#include <recede/geometry/shading_normals.h>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace recede {

namespace {

// One side of a polygon, to be matched with the neighbour's.
struct Side {
  Index low, high;  // its vertices
  Index from, to;   // its corners in the order of the face
  Index face;
  friend bool operator<(const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.from) < std::tie(b.low, b.high, b.from);
  }
  bool same_edge(const Side& other) const { return low == other.low && high == other.high; }
};

std::vector<Vec3> unit_face_normals(const PolygonSoup& soup) {
  std::vector<Vec3> normals(soup.n_faces());
  tbb::parallel_for(std::size_t{0}, normals.size(), [&](std::size_t face) {
    // `stableNormalized` keeps the direction of areas whose square underflows; zero stays zero.
    normals[face] = vector_area(soup, face).stableNormalized();
  });
  return normals;
}

std::vector<Side> sorted_sides(const PolygonSoup& soup) {
  std::vector<Side> sides(soup.n_corners());
  tbb::parallel_for(std::size_t{0}, soup.n_faces(), [&](std::size_t face) {
    const Index first = soup.face_offsets[face], end = soup.face_offsets[face + 1];
    for (Index corner = first; corner < end; ++corner) {
      const Index next = corner + 1 == end ? first : corner + 1;
      const auto [low, high] = std::minmax(soup.corner_vertices[corner], soup.corner_vertices[next]);
      sides[corner] = {low, high, corner, next, static_cast<Index>(face)};
    }
  });
  tbb::parallel_sort(sides.begin(), sides.end());
  return sides;
}

/// Sets of corners that share one normal.
DisjointSets join_across_smooth_edges(const PolygonSoup& soup, const std::vector<Vec3>& face_normals,
                                      double crease_angle) {
  const std::vector<Side> sides = sorted_sides(soup);
  const double least_cosine = std::cos(crease_angle);
  DisjointSets sets(soup.n_corners());
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    end = begin + 1;
    while (end < sides.size() && sides[end].same_edge(sides[begin])) ++end;
    if (end - begin != 2) continue;
    const Side& a = sides[begin];
    const Side& b = sides[begin + 1];
    const bool consistent = soup.corner_vertices[a.from] == soup.corner_vertices[b.to];
    if (!consistent || face_normals[a.face].dot(face_normals[b.face]) < least_cosine) continue;
    sets.unite(a.from, b.to);
    sets.unite(a.to, b.from);
  }
  return sets;
}

double corner_angle(const PolygonSoup& soup, Index first, Index end, Index corner) {
  const Index before = corner == first ? end - 1 : corner - 1;
  const Index after = corner + 1 == end ? first : corner + 1;
  const Vec3& here = soup.positions[soup.corner_vertices[corner]];
  const Vec3 a = (soup.positions[soup.corner_vertices[before]] - here).stableNormalized();
  const Vec3 b = (soup.positions[soup.corner_vertices[after]] - here).stableNormalized();
  return angle_between(a, b);
}

}  // namespace

std::vector<Vec3> shading_normals(const PolygonSoup& soup, double crease_angle) {
  const std::vector<Vec3> face_normals = unit_face_normals(soup);
  DisjointSets sets = join_across_smooth_edges(soup, face_normals, crease_angle);
  std::vector<Vec3> normals(soup.n_corners(), Vec3::Zero());
  for (std::size_t face = 0; face < soup.n_faces(); ++face) {
    const Index first = soup.face_offsets[face], end = soup.face_offsets[face + 1];
    for (Index corner = first; corner < end; ++corner) {
      normals[sets.find(corner)] += corner_angle(soup, first, end, corner) * face_normals[face];
    }
  }
  // Leaders stand before their followers, so each follower finds its leader's sum already normalised.
  for (Index corner = 0; corner < soup.n_corners(); ++corner) {
    const Index leader = sets.find(corner);
    normals[corner] = leader == corner ? normals[corner].stableNormalized() : normals[leader];
  }
  return normals;
}

}  // namespace recede
