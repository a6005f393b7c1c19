// Bezier patches by their nets, and boxes that hold their derivatives.
#pragma once

#include <recede/geometry/detail/interval.h>
#include <recede/geometry/surface_bounds.h>

namespace recede::detail {

/// A Bezier patch or a part of one: its net over a rectangle of parameters.
struct BezierNet {
  std::array<std::size_t, 2> degrees;
  bool is_rational;
  ParameterBox part;
  std::vector<Vec4> points;  ///< times weights, v fastest

  const Vec4& at(std::size_t i, std::size_t j) const { return points[i * (degrees[1] + 1) + j]; }
  Vec3 point(std::size_t i, std::size_t j) const { return at(i, j).head<3>() / at(i, j).w(); }
  double width() const { return part.sizes().x(); }
  double height() const { return part.sizes().y(); }
};

/// Both halves along an axis.
std::array<BezierNet, 2> halves(const BezierNet& net, std::size_t axis);

/// Boxes that hold the derivatives, and bounds of their lengths, in parameters of the net from 0 to 1.
struct DerivativeEnclosure {
  IntervalVec3 du, dv;
  DerivativeBounds lengths;
};
DerivativeEnclosure enclose(const BezierNet& net);

}  // namespace recede::detail
