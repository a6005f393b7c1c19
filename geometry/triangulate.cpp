#include <recede/geometry/polygon_soup.h>

#include <array>

namespace recede {
namespace {

/// Polygon corners as numbers 0..n-1 and their positions in the plane of the polygon's vector area.
struct PlanePolygon {
  std::vector<Vec2> points;

  double twice_area(std::size_t a, std::size_t b, std::size_t c) const {
    const Vec2 u = points[b] - points[a];
    const Vec2 v = points[c] - points[a];
    return u.x() * v.y() - u.y() * v.x();
  }
};

PlanePolygon project(const PolygonSoup& soup, std::span<const Index> face, const Vec3& normal) {
  // Drop onto the two axes orthogonal to the normal.
  const Vec3 u = normal.unitOrthogonal();
  const Vec3 v = normal.cross(u);
  PlanePolygon polygon;
  const Vec3 origin = soup.positions[face[0]];
  for (const Index vertex : face) {
    const Vec3 p = soup.positions[vertex] - origin;
    polygon.points.emplace_back(p.dot(u), p.dot(v));
  }
  return polygon;
}

/// Ratio of twice the area to the square of the longest side; negative for a triangle that turns the wrong
/// way.
double shape_quality(const PlanePolygon& polygon, std::size_t a, std::size_t b, std::size_t c) {
  const double longest = std::max({(polygon.points[a] - polygon.points[b]).squaredNorm(),
                                   (polygon.points[b] - polygon.points[c]).squaredNorm(),
                                   (polygon.points[c] - polygon.points[a]).squaredNorm()});
  return longest > 0 ? polygon.twice_area(a, b, c) / longest : 0;
}

bool contains_other(const PlanePolygon& polygon, const std::vector<std::size_t>& loop, std::size_t a,
                    std::size_t b, std::size_t c) {
  for (const std::size_t p : loop) {
    if (p == a || p == b || p == c) continue;
    if (polygon.twice_area(a, b, p) >= 0 && polygon.twice_area(b, c, p) >= 0 &&
        polygon.twice_area(c, a, p) >= 0) {
      return true;
    }
  }
  return false;
}

using LocalTriangle = std::array<std::size_t, 3>;

/// Clips the best-shaped ear until three corners are left. A polygon that crosses itself has no ear at some
/// point; then the corner that turns most strongly goes first, so that every corner stays covered.
void clip_ears(const PlanePolygon& polygon, std::vector<LocalTriangle>& triangles) {
  std::vector<std::size_t> loop(polygon.points.size());
  for (std::size_t i = 0; i < loop.size(); ++i) loop[i] = i;
  while (loop.size() > 3) {
    std::size_t best = 0;
    double best_quality = -2;
    bool best_is_ear = false;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const std::size_t a = loop[(i + loop.size() - 1) % loop.size()], b = loop[i],
                        c = loop[(i + 1) % loop.size()];
      const double quality = shape_quality(polygon, a, b, c);
      const bool is_ear = quality > 0 && !contains_other(polygon, loop, a, b, c);
      if ((is_ear && !best_is_ear) || (is_ear == best_is_ear && quality > best_quality)) {
        best = i;
        best_quality = quality;
        best_is_ear = is_ear;
      }
    }
    triangles.push_back(
        {loop[(best + loop.size() - 1) % loop.size()], loop[best], loop[(best + 1) % loop.size()]});
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(best));
  }
  triangles.push_back({loop[0], loop[1], loop[2]});
}

/// Diagonal 0-2 unless 1-3 is clearly better: a tie must not be decided by the last bit.
void cut_quad(const PlanePolygon& polygon, std::vector<LocalTriangle>& triangles) {
  constexpr double k_clearly = 1e-9;  // of a shape quality, which is at most 1
  const double first = std::min(shape_quality(polygon, 0, 1, 2), shape_quality(polygon, 0, 2, 3));
  const double second = std::min(shape_quality(polygon, 0, 1, 3), shape_quality(polygon, 1, 2, 3));
  if (second > first + k_clearly) {
    triangles.push_back({0, 1, 3});
    triangles.push_back({1, 2, 3});
  } else {
    triangles.push_back({0, 1, 2});
    triangles.push_back({0, 2, 3});
  }
}

void triangulate_polygon(const PolygonSoup& soup, std::size_t face, std::vector<LocalTriangle>& triangles) {
  const auto corners = soup.face(face);
  triangles.clear();
  if (corners.size() == 3) {
    triangles.push_back({0, 1, 2});
    return;
  }
  const Vec3 area = vector_area(soup, face);
  const double length = area.norm();
  if (!(length > 0)) {  // no plane to cut in: a fan covers every corner
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) triangles.push_back({0, i, i + 1});
    return;
  }
  const PlanePolygon polygon = project(soup, corners, area / length);
  if (corners.size() == 4) {
    cut_quad(polygon, triangles);
  } else {
    clip_ears(polygon, triangles);
  }
}

}  // namespace

std::vector<Index> triangulate(const PolygonSoup& soup, std::vector<Index>* triangle_faces,
                               std::vector<Index>* triangle_corners) {
  const std::size_t n_triangles = soup.n_corners() - 2 * soup.n_faces();
  std::vector<Index> indices;
  indices.reserve(3 * n_triangles);
  if (triangle_faces != nullptr) {
    triangle_faces->clear();
    triangle_faces->reserve(n_triangles);
  }
  if (triangle_corners != nullptr) {
    triangle_corners->clear();
    triangle_corners->reserve(3 * n_triangles);
  }
  std::vector<LocalTriangle> triangles;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    triangulate_polygon(soup, f, triangles);
    for (const LocalTriangle& triangle : triangles) {
      if (triangle_faces != nullptr) triangle_faces->push_back(static_cast<Index>(f));
      for (const std::size_t local : triangle) {
        const std::size_t corner = soup.face_offsets[f] + local;
        indices.push_back(soup.corner_vertices[corner]);
        if (triangle_corners != nullptr) triangle_corners->push_back(static_cast<Index>(corner));
      }
    }
  }
  return indices;
}

}  // namespace recede
