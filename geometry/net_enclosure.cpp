#include <recede/geometry/detail/net_enclosure.h>

#include <cmath>

namespace recede::detail {

namespace {

constexpr double k_for_rounding = 1e-12;  // between products of weights, relative

// Differences of a net along both axes, `order` of them each, as hulls of points and of weights. All is in
// parameters of the net from 0 to 1.
struct Hull {
  IntervalVec3 points;
  RealInterval weights{1e300, -1e300};
  double length = 0;  // of the longest point
};

Hull hull_of_differences(const BezierNet& net, const Vec3& origin, std::array<std::size_t, 2> order) {
  Hull hull;
  const auto [p, q] = net.degrees;
  if (order[0] > p || order[1] > q) {
    hull.points.extend(Vec3::Zero());
    hull.weights = {0, 0};
    return hull;
  }
  static constexpr std::array<std::array<double, 3>, 3> k_signs{{{1, 0, 0}, {-1, 1, 0}, {1, -2, 1}}};
  double factor = 1;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (std::size_t k = 0; k < order[axis]; ++k) factor *= static_cast<double>(net.degrees[axis] - k);
  }
  for (std::size_t i = 0; i + order[0] <= p; ++i) {
    for (std::size_t j = 0; j + order[1] <= q; ++j) {
      Vec4 sum = Vec4::Zero();
      for (std::size_t k = 0; k <= order[0]; ++k) {
        for (std::size_t l = 0; l <= order[1]; ++l)
          sum += k_signs[order[0]][k] * k_signs[order[1]][l] * net.at(i + k, j + l);
      }
      sum *= factor;
      const Vec3 point = sum.head<3>() - sum.w() * origin;
      hull.points.extend(point);
      hull.length = std::max(hull.length, point.norm());
      hull.weights.lower = std::min(hull.weights.lower, sum.w());
      hull.weights.upper = std::max(hull.weights.upper, sum.w());
    }
  }
  return hull;
}

DerivativeEnclosure enclose_polynomial(const BezierNet& net) {
  const auto hull = [&](std::size_t u, std::size_t v) {
    return hull_of_differences(net, Vec3::Zero(), {u, v});
  };
  const Hull du = hull(1, 0), dv = hull(0, 1);
  return {
      du.points, dv.points, {du.length, dv.length, hull(2, 0).length, hull(1, 1).length, hull(0, 2).length}};
}

// With positions from a point within: as far as they are from it, bounds on weights count.
DerivativeEnclosure enclose_rational(const BezierNet& net) {
  IntervalVec3 box;
  for (const Vec4& point : net.points) box.extend(point.head<3>() / point.w());
  const Vec3 origin = 0.5 * (box.lower + box.upper);
  const IntervalVec3 around{box.lower - origin, box.upper - origin};
  const auto hull = [&](std::size_t u, std::size_t v) { return hull_of_differences(net, origin, {u, v}); };
  const RealInterval weights = hull(0, 0).weights;
  const RealInterval over_weight{1 / weights.upper, 1 / weights.lower}, two{2, 2};
  const Hull u = hull(1, 0), v = hull(0, 1), uu = hull(2, 0), uv = hull(1, 1), vv = hull(0, 2);
  DerivativeEnclosure result;
  result.du = over_weight * (u.points - u.weights * around);
  result.dv = over_weight * (v.points - v.weights * around);
  const IntervalVec3 duu = over_weight * (uu.points - two * (u.weights * result.du) - uu.weights * around);
  const IntervalVec3 duv =
      over_weight * (uv.points - u.weights * result.dv - v.weights * result.du - uv.weights * around);
  const IntervalVec3 dvv = over_weight * (vv.points - two * (v.weights * result.dv) - vv.weights * around);
  result.lengths = {result.du.length(), result.dv.length(), duu.length(), duv.length(), dvv.length()};
  return result;
}

// Whether weights are products of one number for each u and one for each v, as those of extruded surfaces and
// of surfaces of revolution are.
bool has_separable_weights(const BezierNet& net) {
  const auto [p, q] = net.degrees;
  for (std::size_t i = 1; i <= p; ++i) {
    for (std::size_t j = 1; j <= q; ++j) {
      const double product = net.at(i, 0).w() * net.at(0, j).w();
      if (!(std::abs(net.at(i, j).w() * net.at(0, 0).w() - product) <= k_for_rounding * product))
        return false;
    }
  }
  return true;
}

// A row of a net along an axis, as a net of degree 0 along the other.
BezierNet row_of(const BezierNet& net, std::size_t axis, std::size_t row) {
  BezierNet result{net.degrees, true, net.part, {}};
  result.degrees[1 - axis] = 0;
  for (std::size_t i = 0; i <= net.degrees[axis]; ++i)
    result.points.push_back(axis == 0 ? net.at(i, row) : net.at(row, i));
  return result;
}

// With separable weights, derivatives along an axis are means of those of the rows along it, and each of
// these has an origin of its own. The mixed one is bounded by differences of points (Floater 1992,
// "Derivatives of rational Bezier curves", first along one axis, then along the other).
DerivativeEnclosure enclose_separable(const BezierNet& net) {
  const auto [p, q] = net.degrees;
  DerivativeEnclosure result{{}, {}, {}};
  for (std::size_t row = 0; row <= q; ++row) {
    const DerivativeEnclosure of_row = enclose_rational(row_of(net, 0, row));
    result.du.extend(of_row.du.lower);
    result.du.extend(of_row.du.upper);
    result.lengths.u = std::max(result.lengths.u, of_row.lengths.u);
    result.lengths.uu = std::max(result.lengths.uu, of_row.lengths.uu);
  }
  for (std::size_t row = 0; row <= p; ++row) {
    const DerivativeEnclosure of_row = enclose_rational(row_of(net, 1, row));
    result.dv.extend(of_row.dv.lower);
    result.dv.extend(of_row.dv.upper);
    result.lengths.v = std::max(result.lengths.v, of_row.lengths.v);
    result.lengths.vv = std::max(result.lengths.vv, of_row.lengths.vv);
  }
  RealInterval along_u{1e300, 0}, along_v{1e300, 0};
  for (std::size_t i = 0; i <= p; ++i) {
    along_u = {std::min(along_u.lower, net.at(i, 0).w()), std::max(along_u.upper, net.at(i, 0).w())};
    for (std::size_t j = 0; j < q && i < p; ++j) {
      const Vec3 twist =
          net.point(i + 1, j + 1) - net.point(i, j + 1) - net.point(i + 1, j) + net.point(i, j);
      result.lengths.uv = std::max(result.lengths.uv, twist.norm());
    }
  }
  for (std::size_t j = 0; j <= q; ++j)
    along_v = {std::min(along_v.lower, net.at(0, j).w()), std::max(along_v.upper, net.at(0, j).w())};
  const double ratio = along_u.upper / along_u.lower * along_v.upper / along_v.lower;
  result.lengths.uv *= static_cast<double>(p * q) * ratio * ratio;
  return result;
}

}  // namespace

std::array<BezierNet, 2> halves(const BezierNet& net, std::size_t axis) {
  std::array<BezierNet, 2> result{net, net};
  const double middle = net.part.center()[static_cast<int>(axis)];
  result[0].part.max()[static_cast<int>(axis)] = middle;
  result[1].part.min()[static_cast<int>(axis)] = middle;
  const std::size_t degree = net.degrees[axis], n_rows = net.degrees[1 - axis] + 1;
  const std::size_t step = axis == 0 ? net.degrees[1] + 1 : 1;
  const std::size_t row_step = axis == 0 ? 1 : net.degrees[1] + 1;
  for (std::size_t row = 0; row < n_rows; ++row) {
    Vec4* left = result[0].points.data() + row * row_step;
    Vec4* right = result[1].points.data() + row * row_step;
    // De Casteljau's algorithm; the diagonal of its triangle is the left half.
    for (std::size_t round = 1; round <= degree; ++round) {
      for (std::size_t i = 0; i + round <= degree; ++i)
        right[i * step] = 0.5 * (right[i * step] + right[(i + 1) * step]);
      left[round * step] = right[0];
    }
  }
  // What is left in `right` is its own half, from the last point back to the middle.
  return result;
}

DerivativeEnclosure enclose(const BezierNet& net) {
  if (!net.is_rational) return enclose_polynomial(net);
  return has_separable_weights(net) ? enclose_separable(net) : enclose_rational(net);
}

}  // namespace recede::detail
