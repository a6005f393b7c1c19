#include <recede/geometry/error.h>
#include <recede/shells/lp_distance.h>

#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace recede {
namespace {

struct Ball {
  Vec3 center = Vec3::Zero();
  double squared_radius = -1;
};

/// The smallest ball with all of up to four points on its surface.
Ball ball_through(std::span<const Vec3> points) {
  if (points.empty()) return {};
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> sides(static_cast<Eigen::Index>(points.size()) - 1, 3);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> halves(sides.rows());
  for (Eigen::Index i = 0; i < sides.rows(); ++i) {
    const Vec3 side = points[static_cast<std::size_t>(i) + 1] - points[0];
    sides.row(i) = side.transpose();
    halves[i] = 0.5 * side.squaredNorm();
  }
  if (sides.rows() == 0) return {points[0], 0};
  // The least solution lies in the points' own plane; four points of one circle are solved as three.
  const Vec3 offset = sides.completeOrthogonalDecomposition().solve(halves);
  return {points[0] + offset, offset.squaredNorm()};
}

/// Welzl 1991, "Smallest enclosing disks (balls and ellipsoids)": the smallest ball around all `points` with
/// the `n_fixed` points of `fixed` on its surface.
Ball smallest_ball(std::span<const Vec3> points, std::array<Vec3, 4>& fixed, std::size_t n_fixed) {
  Ball ball = ball_through(std::span(fixed).first(n_fixed));
  if (n_fixed == 4) return ball;
  constexpr double k_inside = 1e-12;  // relative to the radius
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((points[i] - ball.center).squaredNorm() <= ball.squared_radius * (1 + k_inside)) continue;
    fixed[n_fixed] = points[i];
    ball = smallest_ball(points.first(i), fixed, n_fixed + 1);
  }
  return ball;
}

}  // namespace

Vec3 extended_gradient(const ClosestPointTree& surface, const Vec3& x,
                       const ExtendedGradientOptions& options) {
  if (!(options.tolerance >= 0)) throw OptionError("tolerance must not be negative");
  const double distance = std::sqrt(surface.closest(x).squared_distance);
  if (!(distance > 0)) return Vec3::Zero();
  // Relative to the place and its distance, where rounding and tolerances have known sizes.
  std::vector<Vec3> points;
  for (const ClosestPointTree::Hit& hit : surface.closest_within(x, distance * (1 + options.tolerance)))
    points.push_back((hit.point - x) / distance);
  // In a random order points seldom lie outside of the ball so far; always the same one.
  std::shuffle(points.begin(), points.end(), std::mt19937(1));
  std::array<Vec3, 4> fixed;
  return -smallest_ball(points, fixed, 0).center;
}

}  // namespace recede
