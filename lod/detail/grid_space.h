// Space in voxels: pixels of an image, and a depth whose steps are as long as a pixel is wide there.
//
// S. Gumhold, T. Huettner: Multiresolution Rendering With Displacement Mapping. Graphics Hardware 1999:
// equations 2 to 4, and 7 and 8 for the limits of the picture.
#pragma once

#include <recede/lod/view_dependent_remesh.h>

#include <array>
#include <cstdint>

namespace recede::detail {

/// A place in whole voxels: x to the right, y downwards, z away from the eye.
using GridPoint = std::array<std::int32_t, 3>;

/// A point as a view has it.
struct ViewPoint {
  Vec3 from_eye;  ///< object units
  /// Along the view, object units, no less than the nearest that counts nor a share of the distance.
  double true_depth = 0;
  /// The depth by which voxels are made: the same where heights may bring the point into the picture, and
  /// growing fast beyond, so that voxels do.
  double depth = 0;
  double slack = 0;  ///< how far beyond the pyramid of view it counts as inside, object units
  GridPoint voxel{};
  static constexpr std::size_t k_sides = 5;
  /// How far it lies beyond the left, right, upper and lower side of the pyramid of view, and behind the eye,
  /// object units; negative: inside.
  std::array<double, k_sides> beyond{};
};

class GridSpace {
 public:
  /// `nearest`: depth below which voxels don't get smaller; `reach`: how far points may move; object units.
  /// Throws `OptionError` for numbers out of range.
  GridSpace(const RemeshView& view, double voxel_pixels, double nearest, double reach);

  const Vec3& eye() const { return eye_; }
  /// Side of a voxel at a depth, object units.
  double voxel_size(double depth) const { return depth * voxel_; }
  /// Steps from depth 1 to a depth (equation 4). The near plane of the source only shifts them.
  double steps_to(double depth) const { return std::log(depth) / log_step_; }

  ViewPoint view(const Vec3& point) const;

  /// All of an edge or triangle lies more than `reach` beyond one side of the pyramid of view: nothing that
  /// moves it by no more is seen. Equations 7 and 8 without their division by the least depth, so that it
  /// holds behind the eye too, and for any reach.
  template <typename... Points>
  static bool is_unseen(double reach, const Points&... points) {
    for (std::size_t side = 0; side < ViewPoint::k_sides; ++side) {
      if (((points.beyond[side] > reach) && ...)) return true;
    }
    return false;
  }

  /// Whether an edge of what may be in the picture isn't one for voxels: the depths of its ends differ too
  /// much (steps of screen depth aren't steps of the logarithm), an end is so far outside that the voxels
  /// there are no measure for the picture, or it is very long. Depends on the two ends alone.
  bool is_uneven(const ViewPoint& a, const ViewPoint& b, double largest_depth_ratio) const;

 private:
  Vec3 eye_, right_, down_, forward_;
  double nearest_ = 1, reach_ = 0, voxel_ = 0, log_step_ = 0;
  double least_share_ = 0;  // of a point's distance: no depth is less
  Vec2 middle_, tangent_;
};

/// Voxel of a coordinate: the same rounding everywhere.
inline double rounded(double coordinate) { return std::floor(coordinate + 0.5); }

/// The axis along which two places differ most, and by how much: the number of pieces of their edge. x before
/// y before z when equal (definition 1 of the source).
struct MainDirection {
  std::size_t axis = 0;
  std::int32_t length = 0;
};
MainDirection main_direction(const GridPoint& a, const GridPoint& b);

}  // namespace recede::detail
