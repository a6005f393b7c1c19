// NURBS by the recursive definition of their basis functions: slow, short, and with nothing of the library.
#pragma once

#include <recede/geometry/nurbs.h>

#include <algorithm>
#include <vector>

namespace recede::test {

/// The basis function number i. The last knot belongs to the last piece that isn't empty.
inline double basis_function(const std::vector<double>& knots, std::size_t i, int degree, double t) {
  if (degree == 0) {
    if (knots[i] == knots[i + 1]) return 0;
    const bool is_last = t == knots.back() && knots[i + 1] == knots.back();
    return (knots[i] <= t && t < knots[i + 1]) || is_last ? 1 : 0;
  }
  const auto p = static_cast<std::size_t>(degree);
  const double left = knots[i + p] - knots[i], right = knots[i + p + 1] - knots[i + 1];
  double value = 0;
  if (left > 0) value += (t - knots[i]) / left * basis_function(knots, i, degree - 1, t);
  if (right > 0) value += (knots[i + p + 1] - t) / right * basis_function(knots, i + 1, degree - 1, t);
  return value;
}

/// All of them; those without a share at `t` aren't computed.
inline std::vector<double> basis_functions(const std::vector<double>& knots, std::size_t n, int degree,
                                           double t) {
  std::vector<double> values(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    if (knots[i] <= t && t <= knots[i + static_cast<std::size_t>(degree) + 1]) {
      values[i] = basis_function(knots, i, degree, t);
    }
  }
  return values;
}

template <int Dimension>
Eigen::Matrix<double, Dimension, 1> by_definition(const NurbsCurve<Dimension>& curve, double t) {
  const std::vector<double> basis = basis_functions(curve.knots, curve.points.size(), curve.degree, t);
  Eigen::Matrix<double, Dimension, 1> sum = Eigen::Matrix<double, Dimension, 1>::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < basis.size(); ++i) {
    const double weight = basis[i] * (curve.weights.empty() ? 1 : curve.weights[i]);
    sum += weight * curve.points[i];
    weights += weight;
  }
  return sum / weights;
}

inline Vec3 by_definition(const NurbsSurface& surface, const Vec2& uv) {
  // Rounding may leave parameters just outside.
  const ParameterRange u = surface.domain(0), v = surface.domain(1);
  const auto along_u = basis_functions(surface.knots[0], surface.n_points(0), surface.degrees[0],
                                       std::clamp(uv[0], u.begin, u.end));
  const auto along_v = basis_functions(surface.knots[1], surface.n_points(1), surface.degrees[1],
                                       std::clamp(uv[1], v.begin, v.end));
  Vec3 sum = Vec3::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < along_u.size(); ++i) {
    if (along_u[i] == 0) continue;
    for (std::size_t j = 0; j < along_v.size(); ++j) {
      const std::size_t point = i * along_v.size() + j;
      const double weight = along_u[i] * along_v[j] * (surface.weights.empty() ? 1 : surface.weights[point]);
      sum += weight * surface.points[point];
      weights += weight;
    }
  }
  return sum / weights;
}

}  // namespace recede::test
