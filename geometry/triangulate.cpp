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

using LocalTriangle = std::array<std::size_t, 3>;

/// Clips the best-shaped ear until three corners are left. Only corners that turn inward can lie in an ear,
/// and only the neighbours of a clipped ear change, so a polygon of n corners costs about n squared simple
/// steps.
class EarClipper {
 public:
  explicit EarClipper(const PlanePolygon& polygon) : polygon_(polygon), loop_(polygon.points.size()) {
    const std::size_t n = loop_.size();
    for (std::size_t i = 0; i < n; ++i) loop_[i] = {(i + n - 1) % n, (i + 1) % n, 0, false};
    for (std::size_t i = 0; i < n; ++i) loop_[i].quality = quality(i);
  }

  void run(std::vector<LocalTriangle>& triangles) {
    std::size_t corner = 0;
    for (std::size_t left = loop_.size(); left > 3; --left) {
      const std::size_t ear = best_ear(corner);
      triangles.push_back({loop_[ear].before, ear, loop_[ear].after});
      corner = clip(ear);
    }
    triangles.push_back({loop_[corner].before, corner, loop_[corner].after});
  }

 private:
  struct Corner {
    std::size_t before, after;
    double quality;
    bool blocked;  // another corner lay in its triangle
  };

  double quality(std::size_t i) const { return shape_quality(polygon_, loop_[i].before, i, loop_[i].after); }

  bool contains_other(std::size_t ear) const {
    const std::size_t a = loop_[ear].before, c = loop_[ear].after;
    for (std::size_t p = loop_[c].after; p != a; p = loop_[p].after) {
      if (loop_[p].quality <= 0 && polygon_.twice_area(a, ear, p) >= 0 &&
          polygon_.twice_area(ear, c, p) >= 0 && polygon_.twice_area(c, a, p) >= 0) {
        return true;
      }
    }
    return false;
  }

  /// The corner of best quality that isn't blocked, or `loop_.size()`.
  std::size_t best_open(std::size_t start) const {
    std::size_t best = loop_.size(), i = start;
    do {
      const bool better = best == loop_.size() || loop_[i].quality > loop_[best].quality;
      if (!loop_[i].blocked && loop_[i].quality > 0 && better) best = i;
      i = loop_[i].after;
    } while (i != start);
    return best;
  }

  std::size_t best_ear(std::size_t start) {
    // A blocked corner may have become free since it was looked at: a second round sees all again.
    for (int round = 0; round < 2; ++round) {
      for (std::size_t ear = best_open(start); ear != loop_.size(); ear = best_open(start)) {
        if (!contains_other(ear)) return ear;
        loop_[ear].blocked = true;
      }
      std::size_t i = start;
      do {
        loop_[i].blocked = false;
        i = loop_[i].after;
      } while (i != start);
    }
    // A polygon that crosses itself: the corner that turns most strongly goes, so that every corner stays
    // covered.
    std::size_t best = start;
    for (std::size_t i = loop_[start].after; i != start; i = loop_[i].after) {
      if (loop_[i].quality > loop_[best].quality) best = i;
    }
    return best;
  }

  /// Takes the ear out; returns a corner that is left.
  std::size_t clip(std::size_t ear) {
    const std::size_t a = loop_[ear].before, c = loop_[ear].after;
    loop_[a].after = c;
    loop_[c].before = a;
    for (const std::size_t i : {a, c}) {
      loop_[i].quality = quality(i);
      loop_[i].blocked = false;
    }
    return a;
  }

  const PlanePolygon& polygon_;
  std::vector<Corner> loop_;
};

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
    EarClipper(polygon).run(triangles);
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

PolygonSoup triangulated(const PolygonSoup& soup) {
  PolygonSoup triangles;
  triangles.positions = soup.positions;
  triangles.corner_vertices = triangulate(soup);
  triangles.face_offsets.resize(triangles.n_corners() / 3 + 1);
  for (std::size_t t = 0; t < triangles.face_offsets.size(); ++t) {
    triangles.face_offsets[t] = static_cast<Index>(3 * t);
  }
  return triangles;
}

}  // namespace recede
