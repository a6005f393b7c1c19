// Small vectors that every room shares. Double precision; see the rule on numbers in docs/design.md.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>

namespace recede {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;

/// Axis-aligned box; empty (min > max) when it was extended by nothing.
using Box3 = Eigen::AlignedBox3d;

/// The angle between two directions, radians. The arc tangent keeps its precision at every angle, where an
/// arc cosine loses it near 0.
inline double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace recede
