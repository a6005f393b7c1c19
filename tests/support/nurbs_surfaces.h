// NURBS that tests start from: exact ones and random ones.
#pragma once

#include <recede/geometry/nurbs.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace recede::test {

/// A circle of radius 1 around the origin, once around from (1, 0) in four quarters.
inline NurbsCurve2 unit_circle() {
  const double w = std::numbers::sqrt2 / 2;
  return {2,
          {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4},
          {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}, {1, 0}},
          {1, w, 1, w, 1, w, 1, w, 1}};
}

/// A whole ball: v from the south pole to the north pole. Both sides in v are one point.
inline NurbsSurface ball(double radius, const Vec3& center = Vec3::Zero()) {
  const NurbsCurve2 circle = unit_circle();
  const double w = std::numbers::sqrt2 / 2;
  const std::vector<Vec2> profile{
      {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}};  // distance from the axis, height
  const std::vector<double> profile_weights{1, w, 1, w, 1};
  NurbsSurface surface{{2, 2}, {circle.knots, {0, 0, 0, 1, 1, 2, 2, 2}}, {}, {}};
  for (std::size_t i = 0; i < circle.points.size(); ++i) {
    for (std::size_t j = 0; j < profile.size(); ++j) {
      const Vec2 around = circle.points[i] * profile[j].x();
      surface.points.push_back(center + radius * Vec3(around.x(), around.y(), profile[j].y()));
      surface.weights.push_back(circle.weights[i] * profile_weights[j]);
    }
  }
  return surface;
}

/// A quarter of a tube around z, from x to y in u and from z = 0 to `height` in v.
inline NurbsSurface quarter_tube(double radius, double height) {
  const double w = std::numbers::sqrt2 / 2;
  NurbsSurface surface{{2, 1}, {std::vector<double>{0, 0, 0, 1, 1, 1}, {0, 0, 1, 1}}, {}, {}};
  for (const Vec2& point : {Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    for (const double z : {0.0, height}) {
      surface.points.emplace_back(radius * point.x(), radius * point.y(), z);
      surface.weights.push_back(point.sum() > 1.5 ? w : 1.0);
    }
  }
  return surface;
}

/// Random curves and surfaces: knots at random distances, some of them several times, and random weights.
class RandomNurbs {
 public:
  explicit RandomNurbs(unsigned seed) : random_(seed) {}

  double number(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  int integer(int from, int to) { return std::uniform_int_distribution<int>(from, to)(random_); }
  double in(const ParameterRange& range) { return number(range.begin, range.end); }

  /// Clamped where `is_clamped`; inner knots are at most `most_times` at one place.
  std::vector<double> knots(int degree, int n_inner, bool is_clamped, int most_times) {
    double t = number(-2, 2);
    std::vector<double> result;
    const auto move_on = [&] { t += number(0.2, 1.5); };
    for (int i = 0; i <= degree; ++i) {
      result.push_back(t);
      if (!is_clamped) move_on();
    }
    for (int left = n_inner; left > 0;) {
      move_on();
      for (int times = std::min(left, integer(1, most_times)); times > 0; --times, --left)
        result.push_back(t);
    }
    move_on();
    for (int i = 0; i <= degree; ++i) {
      result.push_back(t);
      if (!is_clamped) move_on();
    }
    return result;
  }

  template <int Dimension>
  NurbsCurve<Dimension> curve(int degree, int n_inner, bool is_rational) {
    NurbsCurve<Dimension> result{degree, knots(degree, n_inner, integer(0, 3) > 0, degree), {}, {}};
    for (std::size_t i = 0; i + static_cast<std::size_t>(degree) + 1 < result.knots.size(); ++i) {
      result.points.push_back(
          2 * Eigen::Matrix<double, Dimension, 1>(
                  Eigen::Matrix<double, Dimension, 1>::NullaryExpr([&] { return number(-1, 1); })));
      if (is_rational) result.weights.push_back(number(0.3, 3));
    }
    return result;
  }

  /// A sheet over the plane, up to about 1 high.
  NurbsSurface sheet(int degree_u, int degree_v, int n_inner, bool is_rational, int most_times = 1) {
    NurbsSurface surface{{degree_u, degree_v}, {}, {}, {}};
    for (const std::size_t axis : {std::size_t{0}, std::size_t{1}})
      surface.knots[axis] = knots(surface.degrees[axis], n_inner, integer(0, 3) > 0,
                                  std::min(most_times, surface.degrees[axis]));
    for (std::size_t i = 0; i < surface.n_points(0); ++i) {
      for (std::size_t j = 0; j < surface.n_points(1); ++j) {
        surface.points.emplace_back(static_cast<double>(i) + number(-0.2, 0.2),
                                    static_cast<double>(j) + number(-0.2, 0.2), number(-0.5, 0.5));
        if (is_rational) surface.weights.push_back(number(0.5, 2));
      }
    }
    return surface;
  }

 private:
  std::mt19937 random_;
};

}  // namespace recede::test
