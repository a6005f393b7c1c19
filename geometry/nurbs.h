// Rational B-spline curves and surfaces of any degree: what CAD files are made of.
//
// L. Piegl, W. Tiller: The NURBS Book, 2nd edition. Springer 1997.
#pragma once

#include <recede/geometry/vec.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace recede {

/// Where a parameter runs.
struct ParameterRange {
  double begin = 0, end = 1;
  double length() const { return end - begin; }
  bool contains(double t) const { return begin <= t && t <= end; }
  bool operator==(const ParameterRange&) const = default;
};

/// A curve in the plane (2) or in space (3).
template <int Dimension>
struct NurbsCurve {
  using Point = Eigen::Matrix<double, Dimension, 1>;
  int degree = 1;
  std::vector<double> knots;    ///< not decreasing; as many as points + degree + 1
  std::vector<Point> points;    ///< n, at least degree + 1
  std::vector<double> weights;  ///< n above 0; empty: all are 1

  bool is_rational() const { return !weights.empty(); }
  /// The curve is there from the knot number `degree` to the one after the last point's number.
  ParameterRange domain() const { return {knots[static_cast<std::size_t>(degree)], knots[points.size()]}; }
};

using NurbsCurve2 = NurbsCurve<2>;
using NurbsCurve3 = NurbsCurve<3>;

/// A surface over a rectangle of parameters (u, v), which are axis 0 and axis 1.
struct NurbsSurface {
  std::array<int, 2> degrees{1, 1};
  std::array<std::vector<double>, 2> knots;  ///< as those of curves
  std::vector<Vec3> points;                  ///< all those along v of the first u, then of the next
  std::vector<double> weights;               ///< as many, above 0; empty: all are 1

  bool is_rational() const { return !weights.empty(); }
  /// Control points along an axis.
  std::size_t n_points(std::size_t axis) const {
    return knots[axis].size() - static_cast<std::size_t>(degrees[axis]) - 1;
  }
  ParameterRange domain(std::size_t axis) const {
    return {knots[axis][static_cast<std::size_t>(degrees[axis])], knots[axis][n_points(axis)]};
  }
};

/// Throws `InputError` when counts don't fit, a degree is outside 1 to 25, knots decrease, aren't finite, or
/// leave no domain, one knot inside of the domain is there more often than the degree, a point isn't
/// finite, or a weight isn't above 0. `source` stands in front of the text.
template <int Dimension>
void validate(const NurbsCurve<Dimension>& curve, const std::string& source);
void validate(const NurbsSurface& surface, const std::string& source);

/// The point and its first two derivatives. Parameters outside of the domain continue its end pieces.
template <int Dimension>
struct CurveDerivatives {
  Eigen::Matrix<double, Dimension, 1> point, first, second;
};
template <int Dimension>
CurveDerivatives<Dimension> derivatives(const NurbsCurve<Dimension>& curve, double t);
template <int Dimension>
Eigen::Matrix<double, Dimension, 1> evaluate(const NurbsCurve<Dimension>& curve, double t);

/// The point and its partial derivatives up to the second.
struct SurfaceDerivatives {
  Vec3 point, du, dv, duu, duv, dvv;
};
SurfaceDerivatives derivatives(const NurbsSurface& surface, const Vec2& uv);
Vec3 evaluate(const NurbsSurface& surface, const Vec2& uv);

/// The same curve or surface with `times` more knots at `t`, which lies in the domain (algorithms A5.1 and
/// A5.3). Knots that are there as often as the degree already get no more.
template <int Dimension>
NurbsCurve<Dimension> insert_knot(const NurbsCurve<Dimension>& curve, double t, int times = 1);
NurbsSurface insert_knot(const NurbsSurface& surface, std::size_t axis, double t, int times = 1);

/// The piece of a curve between two parameters of its domain, with its end points as control points.
template <int Dimension>
NurbsCurve<Dimension> part(const NurbsCurve<Dimension>& curve, const ParameterRange& range);
NurbsSurface part(const NurbsSurface& surface, const ParameterRange& u, const ParameterRange& v);

/// The same points from the other end; the domain stays.
template <int Dimension>
NurbsCurve<Dimension> reversed(const NurbsCurve<Dimension>& curve);

}  // namespace recede
