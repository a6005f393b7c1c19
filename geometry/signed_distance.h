// How far inside or outside of a closed surface a point is.
#pragma once

#include <recede/geometry/closest_point.h>

#include <cmath>
#include <string>

namespace recede {

/// Answers may be asked for in parallel.
class SignedDistance {
 public:
  /// Polygons are triangulated, vertices of one place are one. Throws `InputError`, with `source` in front,
  /// for a soup that `validate` refuses, no triangle of any area, and a surface that isn't closed: each edge
  /// must be run along as often one way as the other. Where faces enclose a volume below 0 all of them are
  /// taken as turned over: what they enclose is inside. Pieces that meet each other, or themselves, aren't
  /// found: of two that overlap the nearer one decides.
  explicit SignedDistance(const PolygonSoup& surface, const std::string& source = "the surface");

  /// Above 0 inside, object units. The sign is that of the angle-weighted normal of the nearest point's face,
  /// edge or vertex (Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted
  /// pseudonormal"). Minus infinity for points whose distance, or its square, isn't finite.
  double inside_by(const Vec3& point) const;

  double volume() const { return std::abs(volume_); }  ///< enclosed, object units to the third

 private:
  struct Triangles;
  explicit SignedDistance(Triangles triangles);
  Vec3 normal_at(Index triangle, const Vec3& point) const;

  std::vector<Vec3> positions_;
  std::vector<Index> triangles_;  // three vertices each
  ClosestPointTree tree_;
  std::vector<Vec3> face_normals_;  // unit
  std::vector<Vec3> edge_normals_;  // of the side from each corner to the next: sums over its faces
  std::vector<Vec3> vertex_normals_;
  double volume_ = 0;    // below 0 where faces face inwards
  double rounding_ = 0;  // of nearest points
};

}  // namespace recede
