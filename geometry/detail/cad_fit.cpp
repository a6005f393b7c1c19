#include <recede/geometry/detail/cad_fit.h>

#include <Eigen/LU>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt2d.hxx>

#include <array>
#include <cmath>
#include <numbers>

namespace recede::detail {

namespace {

constexpr int k_degree = 5, k_deepest = 10;
using Basis = Eigen::Matrix<double, k_degree + 1, 1>;
using Controls = Eigen::Matrix<double, k_degree + 1, 2>;

Basis bernstein(double x) {
  constexpr std::array<double, k_degree + 1> k_binomials{1, 5, 10, 10, 5, 1};
  Basis values;
  for (int i = 0; i <= k_degree; ++i) {
    values[i] = k_binomials[static_cast<std::size_t>(i)] * std::pow(x, i) * std::pow(1 - x, k_degree - i);
  }
  return values;
}

// Chebyshev's places between the ends, with the ends themselves: interpolation there is near the best.
double node(int i) { return (1 - std::cos(std::numbers::pi * i / k_degree)) / 2; }

struct Interpolation {
  Eigen::Matrix<double, k_degree + 1, k_degree + 1> to_controls;
  Interpolation() {
    for (int i = 0; i <= k_degree; ++i) to_controls.row(i) = bernstein(node(i)).transpose();
    to_controls = to_controls.inverse().eval();
  }
};

struct Fit {
  const FitRequest& request;
  std::vector<double> ends;
  std::vector<Vec2> controls;

  void add(double from, double to, int depth) {
    static const Interpolation interpolation;
    Controls samples;
    for (int i = 0; i <= k_degree; ++i) {
      samples.row(i) = request.target(from + (to - from) * node(i)).transpose();
    }
    Controls fitted = interpolation.to_controls * samples;
    // A coordinate that stands still does so exactly.
    for (int axis = 0; axis < 2; ++axis) {
      if ((samples.col(axis).array() == samples(0, axis)).all()) fitted.col(axis) = samples.col(axis);
    }
    fitted.row(0) = samples.row(0);
    fitted.row(k_degree) = samples.row(k_degree);
    if (depth < k_deepest && !is_near(fitted, from, to)) {
      const double middle = (from + to) / 2;
      add(from, middle, depth + 1);
      add(middle, to, depth + 1);
      return;
    }
    if (controls.empty()) controls.push_back(fitted.row(0).transpose());
    for (int i = 1; i <= k_degree; ++i) controls.push_back(fitted.row(i).transpose());
    ends.push_back(to);
  }

  bool is_near(const Controls& fitted, double from, double to) const {
    for (int i = 0; i < k_degree; ++i) {
      const double x = (node(i) + node(i + 1)) / 2;
      const Vec2 point = fitted.transpose() * bernstein(x);
      if (!(request.distance(point, request.target(from + (to - from) * x)) <= request.tolerance))
        return false;
    }
    return true;
  }
};

}  // namespace

Handle(Geom2d_BSplineCurve) fit_curve(const FitRequest& request) {
  Fit fit{request, {request.ends.front()}, {}};
  for (std::size_t i = 0; i + 1 < request.ends.size(); ++i) fit.add(request.ends[i], request.ends[i + 1], 0);
  TColgp_Array1OfPnt2d poles(1, static_cast<int>(fit.controls.size()));
  for (int i = 1; i <= poles.Length(); ++i) {
    const Vec2& point = fit.controls[static_cast<std::size_t>(i - 1)];
    poles(i) = gp_Pnt2d(point[0], point[1]);
  }
  const int n = static_cast<int>(fit.ends.size());
  TColStd_Array1OfReal knots(1, n);
  TColStd_Array1OfInteger multiplicities(1, n);
  for (int i = 1; i <= n; ++i) {
    knots(i) = fit.ends[static_cast<std::size_t>(i - 1)];
    multiplicities(i) = i == 1 || i == n ? k_degree + 1 : k_degree;
  }
  return new Geom2d_BSplineCurve(poles, knots, multiplicities, k_degree);
}

}  // namespace recede::detail
