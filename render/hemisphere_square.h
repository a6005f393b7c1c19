// The hemisphere of directions as a square of equal areas.
#pragma once

#include <recede/geometry/vec.h>

namespace recede {

/// The place in the unit square of a unit direction with z >= 0: equal solid angles have equal areas, and
/// neighbours stay neighbours. +z is in the middle, the horizon is the border; directions below it are taken
/// as on it. Shirley and Chiu 1997, "A low distortion map between disk and square", after an equal-area map
/// of the hemisphere to the disk.
Vec2 hemisphere_to_square(const Vec3& direction);

/// The inverse: the unit direction of a place in the square.
Vec3 square_to_hemisphere(const Vec2& place);

}  // namespace recede
