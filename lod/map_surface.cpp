#include <recede/lod/detail/map_surface.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

namespace recede::detail {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

using FlatTriangle = std::array<Vec2, 3>;

/// A side of `a` has all of `b` on its outer side. `a` runs counter-clockwise.
bool side_separates(const FlatTriangle& a, const FlatTriangle& b) {
  constexpr double k_touch = 1e-9;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 side = a[(k + 1) % 3] - a[k];
    const double room = k_touch * side.norm();
    if (std::all_of(b.begin(), b.end(), [&](const Vec2& p) { return cross(side, p - a[k]) <= room; }))
      return true;
  }
  return false;
}

/// Triangles in the cells of a grid over the unit square, to find those that overlap.
class OverlapSearch {
 public:
  explicit OverlapSearch(const std::vector<FlatTriangle>& triangles) : triangles_(triangles) {
    constexpr double k_most_cells = 1024;  // a side
    const double side = std::sqrt(static_cast<double>(triangles.size()));
    cells_ = static_cast<std::size_t>(std::clamp(side, 1.0, k_most_cells));
  }

  bool any() const {
    std::vector<std::vector<Index>> lists(cells_ * cells_);
    for (Index t = 0; t < triangles_.size(); ++t) {
      const FlatTriangle& own = triangles_[t];
      const Vec2 low = own[0].cwiseMin(own[1]).cwiseMin(own[2]),
                 high = own[0].cwiseMax(own[1]).cwiseMax(own[2]);
      for (std::size_t y = cell(low.y()); y <= cell(high.y()); ++y) {
        for (std::size_t x = cell(low.x()); x <= cell(high.x()); ++x) {
          std::vector<Index>& list = lists[y * cells_ + x];
          if (std::any_of(list.begin(), list.end(),
                          [&](Index other) { return overlap(own, triangles_[other]); }))
            return true;
          list.push_back(t);
        }
      }
    }
    return false;
  }

 private:
  static bool overlap(const FlatTriangle& a, const FlatTriangle& b) {
    return !side_separates(a, b) && !side_separates(b, a);
  }
  std::size_t cell(double coordinate) const {
    return std::min(static_cast<std::size_t>(coordinate * static_cast<double>(cells_)), cells_ - 1);
  }

  const std::vector<FlatTriangle>& triangles_;
  std::size_t cells_ = 1;
};

double angle_at(const PolygonSoup& soup, const std::array<Index, 3>& corners, std::size_t k) {
  const auto position = [&](std::size_t i) -> const Vec3& {
    return soup.positions[soup.corner_vertices[corners[i % 3]]];
  };
  const Vec3 a = (position(k + 1) - position(k)).stableNormalized();
  const Vec3 b = (position(k + 2) - position(k)).stableNormalized();
  return angle_between(a, b);
}

Vec3 normal_of(const PolygonSoup& soup, const std::array<Index, 3>& corners) {
  const Vec3& a = soup.positions[soup.corner_vertices[corners[0]]];
  const Vec3 ab = soup.positions[soup.corner_vertices[corners[1]]] - a;
  const Vec3 ac = soup.positions[soup.corner_vertices[corners[2]]] - a;
  return ab.cross(ac).stableNormalized();
}

std::vector<std::array<Index, 3>> corner_triples(const PolygonSoup& soup) {
  std::vector<Index> corners;
  triangulate(soup, nullptr, &corners);
  std::vector<std::array<Index, 3>> triples(corners.size() / 3);
  for (std::size_t t = 0; t < triples.size(); ++t)
    triples[t] = {corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]};
  return triples;
}

}  // namespace

std::string why_not_one_to_one(const PolygonSoup& soup) {
  if (soup.corner_uvs.empty()) return "no texture coordinates";
  for (const Vec2& uv : soup.corner_uvs) {
    if (!(uv.minCoeff() >= 0 && uv.maxCoeff() <= 1)) return "outside the unit square";
  }
  std::vector<FlatTriangle> triangles;
  for (const auto& corners : corner_triples(soup)) {
    FlatTriangle triangle{soup.corner_uvs[corners[0]], soup.corner_uvs[corners[1]],
                          soup.corner_uvs[corners[2]]};
    const double twice_area = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
    if (twice_area == 0) return "triangles without area";
    if (twice_area < 0) std::swap(triangle[1], triangle[2]);
    triangles.push_back(triangle);
  }
  return OverlapSearch(triangles).any() ? "triangles overlap" : "";
}

std::vector<Index> points_of_corners(const PolygonSoup& soup) {
  PolygonSoup bare;
  bare.positions = soup.positions;
  bare.face_offsets = soup.face_offsets;
  bare.corner_vertices = soup.corner_vertices;
  merge_identical_vertices(bare);
  return bare.corner_vertices;
}

std::vector<Vec3> point_normals(const PolygonSoup& soup) {
  const std::vector<Index> points = points_of_corners(soup);
  std::vector<Vec3> sums(soup.positions.size(), Vec3::Zero()), any = sums;
  for (const auto& corners : corner_triples(soup)) {
    const Vec3 normal = normal_of(soup, corners);
    for (std::size_t k = 0; k < 3; ++k) {
      sums[points[corners[k]]] += angle_at(soup, corners, k) * normal;
      if (any[points[corners[k]]].isZero(0)) any[points[corners[k]]] = normal;
    }
  }
  constexpr double k_vanishing = 1e-6;  // radians
  std::vector<Vec3> normals(soup.n_corners());
  for (std::size_t c = 0; c < normals.size(); ++c) {
    const Vec3 sum = sums[points[c]].norm() > k_vanishing ? sums[points[c]] : any[points[c]];
    normals[c] = sum.isZero(0) ? Vec3(Vec3::UnitZ()) : Vec3(sum.normalized());
  }
  return normals;
}

std::vector<Vec3> point_directions(const PolygonSoup& soup, const std::vector<Index>& points) {
  std::vector<Vec3> directions(soup.positions.size(), Vec3::Zero()), sums = directions;
  std::vector<std::uint8_t> is_seen(soup.positions.size(), 0), differ = is_seen;
  for (std::size_t c = 0; c < soup.corner_normals.size(); ++c) {
    const Index point = points[c];
    const Vec3& normal = soup.corner_normals[c];
    if (is_seen[point] == 0) directions[point] = normal;
    if (normal != directions[point]) differ[point] = 1;
    is_seen[point] = 1;
    sums[point] += normal;
  }
  constexpr double k_vanishing = 1e-6;
  std::vector<Vec3> by_triangles;
  for (std::size_t c = 0; c < points.size(); ++c) {
    Vec3& direction = directions[points[c]];
    if (is_seen[points[c]] == 2) continue;
    is_seen[points[c]] = 2;
    if (differ[points[c]] != 0) direction = sums[points[c]];
    if (direction.norm() > k_vanishing) {
      direction.normalize();
      continue;
    }
    if (by_triangles.empty()) by_triangles = point_normals(soup);
    direction = by_triangles[c];
  }
  return directions;
}

std::vector<Vec4> tangents_of(const PolygonSoup& soup) {
  const std::vector<Index> points = points_of_corners(soup);
  using Group = std::tuple<Index, double, double, bool>;
  std::map<Group, Vec3> sums;
  std::vector<Group> groups(soup.n_corners());
  for (const auto& corners : corner_triples(soup)) {
    const Vec3& a = soup.positions[soup.corner_vertices[corners[0]]];
    const Vec3 ab = soup.positions[soup.corner_vertices[corners[1]]] - a;
    const Vec3 ac = soup.positions[soup.corner_vertices[corners[2]]] - a;
    const Vec2 uv_ab = soup.corner_uvs[corners[1]] - soup.corner_uvs[corners[0]];
    const Vec2 uv_ac = soup.corner_uvs[corners[2]] - soup.corner_uvs[corners[0]];
    const bool mirrored = cross(uv_ab, uv_ac) < 0;
    // Along growing u, up to a positive factor.
    const Vec3 along_u = ((mirrored ? -1 : 1) * (uv_ac.y() * ab - uv_ab.y() * ac)).stableNormalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const Index c = corners[k];
      groups[c] = {points[c], soup.corner_uvs[c].x(), soup.corner_uvs[c].y(), mirrored};
      sums.try_emplace(groups[c], Vec3::Zero()).first->second += angle_at(soup, corners, k) * along_u;
    }
  }
  std::vector<Vec4> tangents(soup.n_corners());
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Vec3& normal = soup.corner_normals[c];
    const auto found = sums.find(groups[c]);
    const Vec3 sum = found == sums.end() ? Vec3(Vec3::Zero()) : found->second;
    Vec3 tangent = sum - normal * normal.dot(sum);
    constexpr double k_vanishing = 1e-6;
    tangent = tangent.norm() > k_vanishing ? Vec3(tangent.normalized()) : Vec3(normal.unitOrthogonal());
    tangents[c] << tangent, (std::get<3>(groups[c]) ? -1.0 : 1.0);
  }
  return tangents;
}

MapTriangles::MapTriangles(const BakedMaps& maps) : maps_(maps) {
  triangulate(maps.surface, nullptr, &corners_);
}

Vec3 MapTriangles::weights(std::size_t triangle, const Vec2& point) const {
  const Vec2 a = uv(triangle, 0) - point, b = uv(triangle, 1) - point, c = uv(triangle, 2) - point;
  const double twice_area = cross(uv(triangle, 1) - uv(triangle, 0), uv(triangle, 2) - uv(triangle, 0));
  const double first = cross(b, c) / twice_area, second = cross(c, a) / twice_area;
  return {first, second, 1 - first - second};
}

double MapTriangles::texel_width(std::size_t triangle, int size) const {
  const auto position = [&](std::size_t k) -> const Vec3& {
    return maps_.surface.positions[maps_.surface.corner_vertices[corner(triangle, k)]];
  };
  const double on_surface = (position(1) - position(0)).cross(position(2) - position(0)).norm();
  const double in_map = std::abs(cross(uv(triangle, 1) - uv(triangle, 0), uv(triangle, 2) - uv(triangle, 0)));
  return std::sqrt(on_surface / in_map) / size;
}

MapPlace MapTriangles::at(std::size_t triangle, const Vec3& weights) const {
  MapPlace point{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (std::size_t k = 0; k < 3; ++k) {
    const Index c = corner(triangle, k);
    const double weight = weights[static_cast<Eigen::Index>(k)];
    const Vec3& normal = maps_.surface.corner_normals[c];
    const Vec4& tangent = maps_.corner_tangents[c];
    point.position += weight * maps_.surface.positions[maps_.surface.corner_vertices[c]];
    point.normal += weight * normal;
    point.tangent += weight * tangent.head<3>();
    point.bitangent += weight * tangent.w() * normal.cross(tangent.head<3>());
  }
  point.normal = point.normal.stableNormalized();
  if (point.normal.isZero(0)) point.normal = maps_.surface.corner_normals[corner(triangle, 0)];
  point.tangent = point.tangent.stableNormalized();
  point.bitangent = point.bitangent.stableNormalized();
  return point;
}

}  // namespace recede::detail
