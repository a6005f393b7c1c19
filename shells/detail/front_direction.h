// Directions in front of all faces around a vertex.
#pragma once

#include <recede/geometry/vec.h>

#include <span>

namespace recede::detail {

double least_cosine(std::span<const Vec3> normals, const Vec3& direction);

/// The axis of the narrowest cone around some unit normals, by steps from `start`: its least cosine with them
/// is the greatest, about. Where that is small, the best of all axes through two and three of the normals is
/// taken, unless they are very many; so a direction in front of all of them is found where there is one.
Vec3 axis_of_normals(std::span<const Vec3> normals, const Vec3& start);

}  // namespace recede::detail
