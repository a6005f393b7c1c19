// Points times their weights: rational curves and surfaces are polynomial in these.
#pragma once

#include <recede/geometry/nurbs.h>

namespace recede::detail {

/// A sum of weighted points, and the sum of their weights.
template <int Dimension>
struct Weighted {
  Eigen::Matrix<double, Dimension, 1> sum = Eigen::Matrix<double, Dimension, 1>::Zero();
  double weight = 0;

  void add(double factor, const Weighted& other) {
    sum += factor * other.sum;
    weight += factor * other.weight;
  }
};

/// A control point of a curve or surface.
template <int Dimension, typename Net>
Weighted<Dimension> weighted_point(const Net& net, std::size_t i) {
  if (net.weights.empty()) return {net.points[i], 1.0};
  return {net.weights[i] * net.points[i], net.weights[i]};
}

/// Derivatives of weighted points of a surface.
struct WeightedDerivatives {
  Weighted<3> point, du, dv, duu, duv, dvv;

  /// Adds a row of control points along v, given as its value and derivatives there, by the values of the
  /// basis along u.
  void add_row(const std::array<double, 3>& u, const std::array<Weighted<3>, 3>& row) {
    point.add(u[0], row[0]);
    du.add(u[1], row[0]);
    dv.add(u[0], row[1]);
    duu.add(u[2], row[0]);
    duv.add(u[1], row[1]);
    dvv.add(u[0], row[2]);
  }

  /// Those of the surface itself, by the rule for quotients (equation 4.20 of The NURBS Book).
  SurfaceDerivatives projected(bool is_rational) const {
    if (!is_rational) return {point.sum, du.sum, dv.sum, duu.sum, duv.sum, dvv.sum};
    SurfaceDerivatives result;
    const double weight = point.weight;
    result.point = point.sum / weight;
    result.du = (du.sum - du.weight * result.point) / weight;
    result.dv = (dv.sum - dv.weight * result.point) / weight;
    result.duu = (duu.sum - 2 * du.weight * result.du - duu.weight * result.point) / weight;
    result.duv =
        (duv.sum - du.weight * result.dv - dv.weight * result.du - duv.weight * result.point) / weight;
    result.dvv = (dvv.sum - 2 * dv.weight * result.dv - dvv.weight * result.point) / weight;
    return result;
  }
};

}  // namespace recede::detail
