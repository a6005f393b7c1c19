// Directions in rows and columns over a hemisphere or the sphere, and linear values between them.
#pragma once

#include <recede/geometry/vec.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace recede {

/// Four nodes of a grid around a direction, and how much each of them counts: weights are not negative and
/// sum to 1. At borders and corners a node may be there twice.
struct NodeMix {
  std::array<std::int32_t, 4> nodes{};
  std::array<double, 4> weights{};
};

/// Directions at the middles of `side` x `side` cells of the hemisphere's square (see
/// `hemisphere_to_square`), for a whole sphere of two such squares that are joined along the horizon. The
/// source has parabolic maps (Heidrich and Seidel 1999), in whose squares the corners, 21 % of the nodes,
/// aren't directions of the hemisphere, and a node in the middle stands for four times as much of it as one
/// at the rim. Here all nodes are directions, and stand for the same solid angle, so that a sum over nodes is
/// an integral.
///
/// None is on the horizon: the lowest are at acos(2 / side - 1 / side^2) from the axis, 75 degrees for 7.
struct DirectionGrid {
  int side = 7;               ///< nodes a row, and rows; greater than 0
  bool whole_sphere = false;  ///< front, z > 0, and then back; else the front alone

  std::size_t size() const {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(side) * (whole_sphere ? 2 : 1);
  }

  /// The unit vector of a node. Nodes go by rows; one of the back is below that of the front.
  Vec3 direction(std::size_t node) const;

  /// The nodes around a unit direction, bilinear between the middles of cells. On a whole sphere continuous
  /// everywhere: across the horizon values go from a node of the rim to the one below it. On a hemisphere
  /// they stay the same from the lowest nodes down, and directions below the horizon are taken as on it.
  NodeMix mix(const Vec3& direction) const;
};

}  // namespace recede
