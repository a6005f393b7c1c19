#include <recede/geometry/detail/edge_table.h>
#include <recede/geometry/error.h>
#include <recede/geometry/signed_distance.h>

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

namespace recede {

/// Of some length of border, over vertices that are merged, with their edges.
struct SignedDistance::Triangles {
  PolygonSoup soup;
  detail::EdgeTable edges;

  Triangles(const PolygonSoup& surface, const std::string& source) {
    validate(surface, source);
    PolygonSoup merged;
    merged.positions = surface.positions;
    merged.face_offsets = surface.face_offsets;
    merged.corner_vertices = surface.corner_vertices;
    merge_identical_vertices(merged);
    soup = triangulated(merged);
    remove_degenerate_faces(soup);
    if (soup.n_faces() == 0)
      throw InputError(fmt::format("{}: there is no triangle to measure distances from", source));
    edges = detail::build_edge_table(soup);
    if (const std::size_t open = count_open(); open > 0) {
      throw InputError(
          fmt::format("{}: the surface must be closed and its faces face outwards, but {} edges "
                      "are open or between faces that differ",
                      source, open));
    }
  }

 private:
  std::size_t count_open() const {
    std::size_t open = 0;
    for (std::size_t edge = 0; edge < edges.n_edges(); ++edge) {
      const Index first = soup.corner_vertices[edges.sides(edge)[0]];
      int balance = 0;
      for (const Index corner : edges.sides(edge)) balance += soup.corner_vertices[corner] == first ? 1 : -1;
      open += balance != 0 ? 1 : 0;
    }
    return open;
  }
};

SignedDistance::SignedDistance(const PolygonSoup& surface, const std::string& source)
    : SignedDistance(Triangles(surface, source)) {}

SignedDistance::SignedDistance(Triangles triangles)
    : positions_(std::move(triangles.soup.positions)),
      triangles_(std::move(triangles.soup.corner_vertices)),
      tree_(positions_, triangles_) {
  const std::size_t n = triangles_.size() / 3;
  Box3 box;
  // A corner of the surface, so that those far from the origin keep their digits.
  const Vec3 origin = positions_[triangles_[0]];
  face_normals_.reserve(n);
  vertex_normals_.assign(positions_.size(), Vec3::Zero());
  edge_normals_.resize(triangles_.size());
  for (std::size_t t = 0; t < n; ++t) {
    std::array<Vec3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = positions_[triangles_[3 * t + k]];
    // Triangles without area have no normal, and add none to their edges and vertices.
    face_normals_.push_back((corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized());
    volume_ += (corners[0] - origin).dot((corners[1] - origin).cross(corners[2] - origin)) / 6;
    for (std::size_t k = 0; k < 3; ++k) {
      box.extend(corners[k]);
      const Vec3 next = corners[(k + 1) % 3] - corners[k], last = corners[(k + 2) % 3] - corners[k];
      vertex_normals_[triangles_[3 * t + k]] += angle_between(next, last) * face_normals_.back();
    }
  }
  // Of nearest points, with which sides they lie on is told.
  rounding_ = 32 * std::numeric_limits<double>::epsilon() *
              box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
  for (std::size_t edge = 0; edge < triangles.edges.n_edges(); ++edge) {
    Vec3 sum = Vec3::Zero();
    for (const Index corner : triangles.edges.sides(edge)) sum += face_normals_[corner / 3];
    for (const Index corner : triangles.edges.sides(edge)) edge_normals_[corner] = sum;
  }
}

double SignedDistance::inside_by(const Vec3& point) const {
  const ClosestPointTree::Hit hit = tree_.closest(point);
  if (hit.triangle == k_no_index) return -std::numeric_limits<double>::infinity();
  const double distance = std::sqrt(hit.squared_distance);
  const bool is_in_front = (point - hit.point).dot(normal_at(hit.triangle, hit.point)) > 0;
  return is_in_front == (volume_ >= 0) ? -distance : distance;
}

Vec3 SignedDistance::normal_at(Index triangle, const Vec3& point) const {
  std::array<Vec3, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = positions_[triangles_[3 * triangle + k]];
  const Vec3& normal = face_normals_[triangle];
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if ((point - corners[k]).squaredNorm() < (point - corners[nearest]).squaredNorm()) nearest = k;
  }
  if ((point - corners[nearest]).norm() <= rounding_)
    return vertex_normals_[triangles_[3 * triangle + nearest]];
  // Where both sides at a corner are that near, as on a needle, their normals are nearly the same.
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 side = corners[(k + 1) % 3] - corners[k];
    if (!(side.cross(point - corners[k]).dot(normal) > rounding_ * side.norm()))
      return edge_normals_[3 * triangle + k];
  }
  return normal;
}

}  // namespace recede
