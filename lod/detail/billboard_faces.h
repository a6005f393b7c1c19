// The faces of a model as billboard clouds are made of them.
#pragma once

#include <recede/lod/billboard_cloud.h>
#include <recede/lod/detail/surface_moments.h>

#include <algorithm>
#include <limits>
#include <span>

namespace recede::detail {

/// Faces with an area, around the middle of the model and in units of its size, the longest side of its box.
struct BillboardFaces {
  std::vector<Vec3> points;
  std::vector<Index> numbers;     ///< in the model
  std::vector<Index> offsets{0};  ///< face i has corners [offsets[i], offsets[i + 1])
  std::vector<Index> corners;
  std::vector<Vec3> normals;
  std::vector<SurfaceMoments> moments;
  std::size_t left_out = 0;  ///< faces of the model
  Vec3 center = Vec3::Zero();
  double size = 0;

  std::size_t count() const { return numbers.size(); }
  std::span<const Index> corners_of(Index face) const {
    return {corners.data() + offsets[face], offsets[face + 1] - offsets[face]};
  }
};

/// Of a face's points along a direction.
struct FaceReach {
  double low = std::numeric_limits<double>::infinity(), high = -low;
};

inline FaceReach reach_of(const BillboardFaces& faces, Index face, const Vec3& direction) {
  FaceReach reach;
  for (const Index corner : faces.corners_of(face)) {
    const double at = faces.points[corner].dot(direction);
    reach.low = std::min(reach.low, at);
    reach.high = std::max(reach.high, at);
  }
  return reach;
}

/// Throws `InputError` where no face has an area.
BillboardFaces billboard_faces_of(const PolygonSoup& model);

/// The least rectangle with a normal that some faces fit into, half-way between the farthest of their points,
/// in units of the model. Turned to the front of most of them.
Billboard billboard_facing(const BillboardFaces& faces, std::span<const Index> members, const Vec3& normal,
                           bool is_two_sided);

}  // namespace recede::detail
