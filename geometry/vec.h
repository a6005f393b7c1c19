// Small vectors that every room shares. Double precision; see the rule on numbers in docs/design.md.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace recede {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;

/// Axis-aligned box; empty (min > max) when it was extended by nothing.
using Box3 = Eigen::AlignedBox3d;

}  // namespace recede
