#include <recede/geometry/detail/edge_table.h>
#include <recede/geometry/error.h>
#include <recede/geometry/parameterization.h>
#include <recede/shells/detail/surface_disc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

namespace recede::detail {

namespace {

double triangle_area(const PolygonSoup& base, Index triangle) { return vector_area(base, triangle).norm(); }

Vec3 point_of(const PolygonSoup& base, const ShellPlace& place) {
  Vec3 point = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    point += place.weights[static_cast<int>(k)] * base.positions[base.face(place.triangle)[k]];
  return point;
}

// Ways along edges are longer than those across triangles, on regular meshes by up to a sixth.
constexpr double k_longer_along_edges = 1.5;

// Distances of vertices along edges from the corners of a triangle, as far as `most`.
std::vector<double> distances_along_edges(const PolygonSoup& base, const EdgeTable& edges,
                                          const ShellPlace& place, double most) {
  std::vector<std::vector<std::pair<Index, double>>> ways(base.positions.size());
  for (std::size_t edge = 0; edge < edges.n_edges(); ++edge) {
    const Index corner = edges.sides(edge)[0];
    const Index a = base.corner_vertices[corner],
                b = base.corner_vertices[corner % 3 == 2 ? corner - 2 : corner + 1];
    const double length = (base.positions[a] - base.positions[b]).norm();
    ways[a].emplace_back(b, length);
    ways[b].emplace_back(a, length);
  }
  std::vector<double> distances(base.positions.size(), std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, Index>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  const Vec3 middle = point_of(base, place);
  for (const Index v : base.face(place.triangle)) {
    distances[v] = (base.positions[v] - middle).norm();
    next.emplace(distances[v], v);
  }
  while (!next.empty()) {
    const auto [distance, v] = next.top();
    next.pop();
    if (distance > distances[v] || distance > most) continue;
    for (const auto& [to, length] : ways[v]) {
      if (!(distance + length < distances[to])) continue;
      distances[to] = distance + length;
      next.emplace(distances[to], to);
    }
  }
  return distances;
}

}  // namespace

SurfaceDisc::SurfaceDisc(const PolygonSoup& base, const ShellPlace& place, double radius, const Vec3& axis) {
  grow(base, place, radius);
  spread(base, place, axis);
}

// Triangles are added nearest first where the disc stays one: over one side with a new vertex opposite, or
// over more sides.
void SurfaceDisc::grow(const PolygonSoup& base, const ShellPlace& place, double radius) {
  const EdgeTable edges = build_edge_table(base);
  const double most = k_longer_along_edges * radius;
  const std::vector<double> distances = distances_along_edges(base, edges, place, most);
  const auto distance_to = [&](Index triangle) {
    double least = std::numeric_limits<double>::infinity();
    for (const Index v : base.face(triangle)) least = std::min(least, distances[v]);
    return least;
  };
  std::vector<unsigned char> is_taken(base.n_faces(), 0), has_vertex(base.positions.size(), 0);
  using Candidate = std::pair<double, Index>;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> next;
  const auto neighbor_over = [&](Index corner) {
    const std::span<const Index> sides = edges.sides(edges.edge_of_corner[corner]);
    if (sides.size() != 2) return k_no_index;
    const Index other = sides[0] == corner ? sides[1] : sides[0];
    // Of sides that run the same way one face is turned over.
    return base.corner_vertices[other] == base.corner_vertices[corner] ? k_no_index : other / 3;
  };
  const auto take = [&](Index triangle) {
    is_taken[triangle] = 1;
    triangles_.push_back(triangle);
    for (Index k = 0; k < 3; ++k) {
      has_vertex[base.corner_vertices[3 * triangle + k]] = 1;
      const Index neighbor = neighbor_over(3 * triangle + k);
      if (neighbor == k_no_index || is_taken[neighbor]) continue;
      if (const double distance = distance_to(neighbor); distance <= most) next.emplace(distance, neighbor);
    }
  };
  take(place.triangle);
  while (!next.empty()) {
    const Index triangle = next.top().second;
    next.pop();
    if (is_taken[triangle] || !(triangle_area(base, triangle) > 0)) continue;
    int sides = 0, vertices = 0;
    for (Index k = 0; k < 3; ++k) {
      const Index neighbor = neighbor_over(3 * triangle + k);
      sides += neighbor != k_no_index && is_taken[neighbor] ? 1 : 0;
      vertices += has_vertex[base.corner_vertices[3 * triangle + k]];
    }
    // Three vertices and one side would close a ring; three sides a disc whose whole border they are.
    if (sides == 2 || (sides == 1 && vertices == 2)) take(triangle);
  }
  std::sort(triangles_.begin(), triangles_.end());
}

void SurfaceDisc::spread(const PolygonSoup& base, const ShellPlace& place, const Vec3& axis) {
  std::vector<Index> number_of_vertex(base.positions.size(), k_no_index);
  number_of_triangle_.assign(base.n_faces(), k_no_index);
  std::vector<Vec3> positions;
  double area = 0;
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    number_of_triangle_[triangles_[i]] = static_cast<Index>(i);
    area += triangle_area(base, triangles_[i]);
    for (const Index v : base.face(triangles_[i])) {
      if (number_of_vertex[v] == k_no_index) {
        number_of_vertex[v] = static_cast<Index>(positions.size());
        positions.push_back(base.positions[v]);
      }
      corners_.push_back(number_of_vertex[v]);
    }
  }
  if (!(area > 0)) throw InputError("there is no area around the place from or to which matter moves");
  constexpr int k_stretch_rounds = 8;
  const Parameterization map = parameterize_disk(
      positions, corners_, {.border = DiskBorder::natural, .stretch_rounds = k_stretch_rounds});
  points_ = map.uvs;
  stretch_ = map.stretch.l2;

  double flat_area = 0;
  for (std::size_t i = 0; i < corners_.size(); i += 3) {
    const Vec2 first = points_[corners_[i + 1]] - points_[corners_[i]],
               second = points_[corners_[i + 2]] - points_[corners_[i]];
    flat_area += (first.x() * second.y() - first.y() * second.x()) / 2;
  }
  const double scale = std::sqrt(area / flat_area);
  for (Vec2& point : points_) point *= scale;
  const Vec2 origin = to_plane(place.triangle, place.weights).value();
  // Where the axis leads in the plane, by the triangle of the place.
  const Index number = number_of_triangle_[place.triangle];
  const std::span<const Index> face = base.face(place.triangle);
  Eigen::Matrix<double, 3, 2> in_space;
  Eigen::Matrix2d in_plane;
  for (int k = 0; k < 2; ++k) {
    const std::size_t corner = static_cast<std::size_t>(k) + 1;
    in_space.col(k) = base.positions[face[corner]] - base.positions[face[0]];
    in_plane.col(k) = points_[corners_[3 * number + corner]] - points_[corners_[3 * number]];
  }
  const Vec2 weights = (in_space.transpose() * in_space).ldlt().solve(in_space.transpose() * axis);
  const Vec2 along = in_plane * weights;
  const Eigen::Rotation2Dd turn(-std::atan2(along.y(), along.x()));
  std::vector<Vec3> flat;
  for (Vec2& point : points_) {
    point = turn * (point - origin);
    flat.emplace_back(point.x(), point.y(), 0);
  }
  flat_.emplace(flat, corners_);
}

std::optional<Vec2> SurfaceDisc::to_plane(Index triangle, const Vec3& weights) const {
  const Index number = number_of_triangle_[triangle];
  if (number == k_no_index) return {};
  Vec2 point = Vec2::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    point += weights[static_cast<int>(k)] * points_[corners_[3 * number + k]];
  return point;
}

std::optional<ShellPlace> SurfaceDisc::from_plane(const Vec2& point) const {
  const Vec3 flat(point.x(), point.y(), 0);
  const ClosestPointTree::Hit hit = flat_->closest(flat);
  const Triangle corners = flat_->triangle(hit.triangle);
  const Vec3 first = corners.b - corners.a, second = corners.c - corners.a, off = hit.point - corners.a;
  const double size = std::max(first.norm(), second.norm());
  if (hit.squared_distance > 1e-18 * size * size) return {};  // rounding of nearest points
  const double area = first.cross(second).z();
  ShellPlace place{.triangle = triangles_[hit.triangle]};
  place.weights.y() = off.cross(second).z() / area;
  place.weights.z() = first.cross(off).z() / area;
  place.weights.x() = 1 - place.weights.y() - place.weights.z();
  return place;
}

}  // namespace recede::detail
