// Billboard clouds: rectangles that stand for parts of a model from far away, be it a mesh or loose leaves.
//
// X. Decoret, F. Durand, F. Sillion, J. Dorsey: Billboard Clouds for Extreme Model Simplification. SIGGRAPH
// 2003. J. Meseth: Towards Predictive Rendering in Virtual Reality. Dissertation, Bonn 2008, chapter 7.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>

#include <numbers>
#include <vector>

namespace recede {

/// A rectangle and the faces that it stands for.
struct Billboard {
  Vec3 center = Vec3::Zero();
  Vec3 axis_u = Vec3::UnitX(), axis_v = Vec3::UnitY();  ///< unit, at a right angle
  Vec2 half_sizes = Vec2::Zero();                       ///< along both
  std::vector<Index> faces;                             ///< rising
  double error = 0;             ///< no point of its faces is farther from its plane, and none beside it
  double normal_deviation = 0;  ///< the largest angle between its normal and one of a face, radians
  double face_area = 0;

  Vec3 normal() const { return axis_u.cross(axis_v); }
  double area() const { return 4 * half_sizes.x() * half_sizes.y(); }
};

struct BillboardCloud {
  double error = 0;  ///< that was asked for: no billboard's is larger, but of a face that is bent by more
  std::vector<Billboard> billboards;
  std::size_t left_out = 0;  ///< faces without area
  bool is_two_sided = false;
  double largest_deviation = std::numbers::pi;  ///< that was permitted, radians
  bool is_impostor = false;  ///< each billboard stands for all faces, see octahedral_impostor.h
};

enum class BillboardMethod {
  face_clustering,  ///< little texture, and normals near to those of the faces
  plane_cover,  ///< few planes, at any angle to the faces; those of a plane are parted where they lie apart
  simplification,  ///< one for each triangle of the simplified model: many; little texture on loose leaves
};

struct BillboardOptions {
  BillboardMethod method = BillboardMethod::face_clustering;
  /// Of the clouds, finest first, in units of the model. None: 0.5, 1, 2 and 4 % of the longest side of its
  /// box.
  std::vector<double> errors{};
  /// Between faces and their billboard, so that it is seen where they are. Of clusters and simplification.
  double largest_deviation = std::numbers::pi / 3;
  /// Area of a billboard over that of its faces, for those of more than one. Of clusters.
  double largest_waste = 4;
  /// Faces count from both sides: turned either way they may share a billboard, as leaves do.
  bool is_two_sided = false;
  /// Faces near to each one that it may share a billboard with. Of clusters.
  std::size_t n_neighbours = 50;
};

/// One cloud for each error. Face clustering: all of them from one run, the least waste and angles first, up
/// to each error in turn (section 7.3 of the dissertation, with the waste of a billboard as it must be meant,
/// its area over that of its faces, and angles in the cost beside it); billboards of a cloud stand for unions
/// of those of the one before.
/// Simplification: down to each error, proved, and then each face goes to the nearest triangle that it is
/// near to and that faces as it does, if need be one farther away; faces for which there is none are
/// clustered. Throws `OptionError` for numbers out of range, `InputError` where no face has an area,
/// `Cancelled`.
std::vector<BillboardCloud> build_billboard_clouds(const PolygonSoup& model,
                                                   const BillboardOptions& options = {},
                                                   Progress* progress = nullptr);

}  // namespace recede
