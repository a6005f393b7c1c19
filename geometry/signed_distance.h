// How far inside or outside of a closed surface a point is.
#pragma once

#include <recede/geometry/closest_point.h>

#include <string>

namespace recede {

/// Answers may be asked for in parallel.
class SignedDistance {
 public:
  /// Polygons are triangulated, vertices of one place are one. Throws `InputError`, with `source` in front,
  /// for a soup that `validate` refuses, no triangle of any area, and a surface that isn't closed: each edge
  /// must be run along as often one way as the other. Pieces that meet each other, or themselves, aren't
  /// found: of two that overlap the nearer one decides.
  explicit SignedDistance(const PolygonSoup& surface, const std::string& source = "the surface");

  /// Above 0 inside, object units. The sign is that of the angle-weighted normal of the nearest point's face,
  /// edge or vertex (Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted
  /// pseudonormal"). `hint` is a triangle thought to be near and receives the nearest one.
  double inside_by(const Vec3& point, Index* hint = nullptr) const;

  const Box3& box() const { return box_; }
  double volume() const { return volume_; }  ///< by the faces' orientation, below 0 where they face inwards

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
  Box3 box_;
  double volume_ = 0, rounding_ = 0;
};

}  // namespace recede
