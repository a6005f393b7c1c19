// What places of a height field see of each other when the surface under it is bent.
#pragma once

#include <recede/render/height_field_visibility.h>

#include <vector>

namespace recede {

/// Curvatures of the undisplaced surface along u and v: inverse radii, in the inverse of the units of the
/// heights; greater than 0 where it bulges towards the side from which it is seen.
struct BaseCurvature {
  double along_u = 0, along_v = 0;
  bool is_flat() const { return along_u == 0 && along_v == 0; }
};

/// Where a place sees on the bent surface what it saw along the directions of the visibility, and how much
/// each of these counts beside the flat case.
struct BentDirections {
  std::vector<Vec3> directions{};  ///< unit length, in the frame of the undisplaced surface at the place
  std::vector<double> weights{};   ///< solid angle around it, as a share of that before
  Vec3 normal = Vec3::UnitZ();     ///< of the place: heights above a bulge are stretched, so slopes fall
};

/// Valid for radii that are large beside the bumps: it is taken for granted that what is seen stays the same
/// (Heidrich et al. 2000, section on varying base geometry). Directions without a place beside those with one
/// move along with them: left in place, as the source leaves it open, they would take half of the effect
/// away. Throws `OptionError` for curvatures that aren't finite.
BentDirections bend_directions(const HeightFieldVisibility& visibility, std::size_t place,
                               const BaseCurvature& curvature);

}  // namespace recede
