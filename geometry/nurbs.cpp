#include <recede/geometry/detail/knots.h>
#include <recede/geometry/detail/weighted.h>
#include <recede/geometry/error.h>
#include <recede/geometry/nurbs.h>

#include <algorithm>
#include <cmath>

namespace recede {

namespace {

using detail::BasisDerivatives;
using detail::Weighted;
using detail::weighted_point;

void validate_knots(const std::vector<double>& knots, int degree, std::size_t n_points,
                    const std::string& what) {
  if (degree < 1 || degree > detail::k_most_degree)
    throw InputError(what + ": the degree is " + std::to_string(degree) + ", not between 1 and " +
                     std::to_string(detail::k_most_degree));
  const auto p = static_cast<std::size_t>(degree);
  if (n_points < p + 1 || knots.size() != n_points + p + 1) {
    throw InputError(what + ": " + std::to_string(knots.size()) + " knots don't fit to " +
                     std::to_string(n_points) + " points and degree " + std::to_string(degree));
  }
  for (std::size_t i = 0; i < knots.size(); ++i) {
    if (!std::isfinite(knots[i]))
      throw InputError(what + ": knot " + std::to_string(i) + " isn't a finite number");
    if (i > 0 && knots[i] < knots[i - 1])
      throw InputError(what + ": knot " + std::to_string(i) + " is below the one before");
  }
  const double begin = knots[p], end = knots[n_points];
  if (!(begin < end)) throw InputError(what + ": the knots leave no domain");
  for (std::size_t i = p + 1; i + p < n_points; ++i) {
    if (knots[i] > begin && knots[i + p] < end && knots[i] == knots[i + p])
      throw InputError(what + ": knot " + std::to_string(i) + " is there more often than the degree");
  }
}

template <typename Point>
void validate_net(const std::vector<Point>& points, const std::vector<double>& weights,
                  const std::string& what) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite())
      throw InputError(what + ": control point " + std::to_string(i) + " isn't finite");
  }
  if (weights.empty()) return;
  if (weights.size() != points.size()) {
    throw InputError(what + ": " + std::to_string(weights.size()) + " weights for " +
                     std::to_string(points.size()) + " points");
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] > 0 && std::isfinite(weights[i])))
      throw InputError(what + ": weight " + std::to_string(i) + " isn't above 0");
  }
}

// Rows of weighted control points, so that knots of curves and of both axes of surfaces are inserted alike.
template <int Dimension>
struct ControlRows {
  std::size_t n_rows = 1;
  std::vector<Weighted<Dimension>> points;  // row by row

  std::size_t row_length() const { return points.size() / n_rows; }
};

// Boehm's algorithm (A5.1) for one knot.
template <int Dimension>
void insert_once(std::vector<double>& knots, int degree, ControlRows<Dimension>& rows, double t) {
  const std::size_t n = rows.row_length();
  const auto p = static_cast<std::size_t>(degree);
  const std::size_t span = detail::find_span(knots, degree, n, t);
  const auto multiplicity = static_cast<std::size_t>(std::count(knots.begin(), knots.end(), t));
  if (multiplicity >= p) return;
  // With t at the end of the domain its copies lie behind the span.
  const std::size_t behind = t > knots[span] ? 0 : multiplicity;
  std::vector<Weighted<Dimension>> longer;
  longer.reserve(rows.points.size() + rows.n_rows);
  for (std::size_t row = 0; row < rows.n_rows; ++row) {
    const auto* points = rows.points.data() + row * n;
    for (std::size_t i = 0; i <= n; ++i) {
      if (i + p <= span) {
        longer.push_back(points[i]);
      } else if (i + behind > span) {
        longer.push_back(points[i - 1]);
      } else {
        const double share = (t - knots[i]) / (knots[i + p] - knots[i]);
        Weighted<Dimension> point;
        point.add(1 - share, points[i - 1]);
        point.add(share, points[i]);
        longer.push_back(point);
      }
    }
  }
  rows.points = std::move(longer);
  knots.insert(knots.begin() + static_cast<std::ptrdiff_t>(span) + 1, t);
}

template <int Dimension>
void store(const Weighted<Dimension>& from, bool is_rational,
           std::vector<Eigen::Matrix<double, Dimension, 1>>& points, std::vector<double>& weights) {
  if (is_rational) {
    points.push_back(from.sum / from.weight);
    weights.push_back(from.weight);
  } else {
    points.push_back(from.sum);
  }
}

template <int Dimension>
ControlRows<Dimension> rows_of(const NurbsCurve<Dimension>& curve) {
  ControlRows<Dimension> rows;
  for (std::size_t i = 0; i < curve.points.size(); ++i)
    rows.points.push_back(weighted_point<Dimension>(curve, i));
  return rows;
}

// Along v the net lies row by row; along u it is turned.
ControlRows<3> rows_of(const NurbsSurface& surface, std::size_t axis) {
  const std::size_t n_u = surface.n_points(0), n_v = surface.n_points(1);
  ControlRows<3> rows;
  rows.n_rows = axis == 0 ? n_v : n_u;
  rows.points.reserve(surface.points.size());
  const std::size_t length = axis == 0 ? n_u : n_v;
  for (std::size_t row = 0; row < rows.n_rows; ++row) {
    for (std::size_t i = 0; i < length; ++i)
      rows.points.push_back(weighted_point<3>(surface, axis == 0 ? i * n_v + row : row * n_v + i));
  }
  return rows;
}

template <int Dimension>
NurbsCurve<Dimension> curve_of(int degree, std::vector<double> knots, const ControlRows<Dimension>& rows,
                               bool is_rational) {
  NurbsCurve<Dimension> curve{degree, std::move(knots), {}, {}};
  for (const Weighted<Dimension>& point : rows.points) store(point, is_rational, curve.points, curve.weights);
  return curve;
}

NurbsSurface surface_of(const NurbsSurface& like, std::size_t axis, std::vector<double> knots,
                        const ControlRows<3>& rows) {
  NurbsSurface surface{like.degrees, like.knots, {}, {}};
  surface.knots[axis] = std::move(knots);
  const std::size_t n_u = surface.n_points(0), n_v = surface.n_points(1), length = rows.row_length();
  for (std::size_t i = 0; i < n_u; ++i) {
    for (std::size_t j = 0; j < n_v; ++j)
      store(rows.points[axis == 0 ? j * length + i : i * length + j], like.is_rational(), surface.points,
            surface.weights);
  }
  return surface;
}

// Makes both ends of the range knots as often as the degree, and cuts off what is outside.
template <int Dimension>
void cut(std::vector<double>& knots, int degree, ControlRows<Dimension>& rows, const ParameterRange& range) {
  for (const double t : {range.begin, range.end}) {
    for (int i = 0; i < degree; ++i) insert_once(knots, degree, rows, t);
  }
  const std::size_t n = rows.row_length();
  const auto p = static_cast<std::size_t>(degree);
  const auto first_knot = static_cast<std::size_t>(std::upper_bound(knots.begin(), knots.end(), range.begin) -
                                                   knots.begin());  // behind its copies
  const auto end_knot =
      static_cast<std::size_t>(std::lower_bound(knots.begin(), knots.end(), range.end) - knots.begin());
  const std::size_t first = first_knot - p - 1;
  const std::size_t count = end_knot - first_knot + p + 1;
  std::vector<Weighted<Dimension>> kept;
  for (std::size_t row = 0; row < rows.n_rows; ++row) {
    const auto from = rows.points.begin() + static_cast<std::ptrdiff_t>(row * n + first);
    kept.insert(kept.end(), from, from + static_cast<std::ptrdiff_t>(count));
  }
  rows.points = std::move(kept);
  std::vector<double> inside(p + 1, range.begin);
  inside.insert(inside.end(), knots.begin() + static_cast<std::ptrdiff_t>(first_knot),
                knots.begin() + static_cast<std::ptrdiff_t>(end_knot));
  inside.insert(inside.end(), p + 1, range.end);
  knots = std::move(inside);
}

}  // namespace

template <int Dimension>
void validate(const NurbsCurve<Dimension>& curve, const std::string& source) {
  validate_knots(curve.knots, curve.degree, curve.points.size(), source);
  validate_net(curve.points, curve.weights, source);
}

void validate(const NurbsSurface& surface, const std::string& source) {
  std::size_t n_points = 1;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto besides = static_cast<std::size_t>(std::max(0, surface.degrees[axis])) + 1;
    const std::size_t n = surface.knots[axis].size() - std::min(besides, surface.knots[axis].size());
    validate_knots(surface.knots[axis], surface.degrees[axis], n, source + (axis == 0 ? ": u" : ": v"));
    n_points *= n;
  }
  if (n_points != surface.points.size()) {
    throw InputError(source + ": " + std::to_string(surface.points.size()) +
                     " control points where knots need " + std::to_string(n_points));
  }
  validate_net(surface.points, surface.weights, source);
}

template <int Dimension>
CurveDerivatives<Dimension> derivatives(const NurbsCurve<Dimension>& curve, double t) {
  const std::size_t span = detail::find_span(curve.knots, curve.degree, curve.points.size(), t);
  const BasisDerivatives basis(curve.knots, curve.degree, span, t);
  std::array<Weighted<Dimension>, 3> sums;
  const std::size_t first = span - static_cast<std::size_t>(curve.degree);
  for (std::size_t i = 0; i <= static_cast<std::size_t>(curve.degree); ++i) {
    const Weighted<Dimension> point = weighted_point<Dimension>(curve, first + i);
    for (std::size_t order = 0; order < 3; ++order) sums[order].add(basis.of[order][i], point);
  }
  if (!curve.is_rational()) return {sums[0].sum, sums[1].sum, sums[2].sum};
  CurveDerivatives<Dimension> result;
  const double weight = sums[0].weight;
  result.point = sums[0].sum / weight;
  result.first = (sums[1].sum - sums[1].weight * result.point) / weight;
  result.second = (sums[2].sum - 2 * sums[1].weight * result.first - sums[2].weight * result.point) / weight;
  return result;
}

template <int Dimension>
Eigen::Matrix<double, Dimension, 1> evaluate(const NurbsCurve<Dimension>& curve, double t) {
  return derivatives(curve, t).point;
}

SurfaceDerivatives derivatives(const NurbsSurface& surface, const Vec2& uv) {
  const std::size_t n_v = surface.n_points(1);
  const std::array<std::size_t, 2> spans{
      detail::find_span(surface.knots[0], surface.degrees[0], surface.n_points(0), uv.x()),
      detail::find_span(surface.knots[1], surface.degrees[1], n_v, uv.y())};
  const BasisDerivatives u(surface.knots[0], surface.degrees[0], spans[0], uv.x()),
      v(surface.knots[1], surface.degrees[1], spans[1], uv.y());
  const std::array<std::size_t, 2> degrees{static_cast<std::size_t>(surface.degrees[0]),
                                           static_cast<std::size_t>(surface.degrees[1])};
  detail::WeightedDerivatives sums;
  for (std::size_t i = 0; i <= degrees[0]; ++i) {
    std::array<Weighted<3>, 3> row;  // derivatives along v
    const std::size_t first = (spans[0] - degrees[0] + i) * n_v + spans[1] - degrees[1];
    for (std::size_t j = 0; j <= degrees[1]; ++j) {
      const Weighted<3> point = weighted_point<3>(surface, first + j);
      for (std::size_t order = 0; order < 3; ++order) row[order].add(v.of[order][j], point);
    }
    sums.add_row({u.of[0][i], u.of[1][i], u.of[2][i]}, row);
  }
  return sums.projected(surface.is_rational());
}

Vec3 evaluate(const NurbsSurface& surface, const Vec2& uv) { return derivatives(surface, uv).point; }

template <int Dimension>
NurbsCurve<Dimension> insert_knot(const NurbsCurve<Dimension>& curve, double t, int times) {
  std::vector<double> knots = curve.knots;
  ControlRows<Dimension> rows = rows_of(curve);
  for (int i = 0; i < times; ++i) insert_once(knots, curve.degree, rows, t);
  return curve_of(curve.degree, std::move(knots), rows, curve.is_rational());
}

NurbsSurface insert_knot(const NurbsSurface& surface, std::size_t axis, double t, int times) {
  std::vector<double> knots = surface.knots[axis];
  ControlRows<3> rows = rows_of(surface, axis);
  for (int i = 0; i < times; ++i) insert_once(knots, surface.degrees[axis], rows, t);
  return surface_of(surface, axis, std::move(knots), rows);
}

template <int Dimension>
NurbsCurve<Dimension> part(const NurbsCurve<Dimension>& curve, const ParameterRange& range) {
  std::vector<double> knots = curve.knots;
  ControlRows<Dimension> rows = rows_of(curve);
  cut(knots, curve.degree, rows, range);
  return curve_of(curve.degree, std::move(knots), rows, curve.is_rational());
}

NurbsSurface part(const NurbsSurface& surface, const ParameterRange& u, const ParameterRange& v) {
  NurbsSurface result = surface;
  for (const std::size_t axis : {std::size_t{0}, std::size_t{1}}) {
    std::vector<double> knots = result.knots[axis];
    ControlRows<3> rows = rows_of(result, axis);
    cut(knots, result.degrees[axis], rows, axis == 0 ? u : v);
    result = surface_of(result, axis, std::move(knots), rows);
  }
  return result;
}

template <int Dimension>
NurbsCurve<Dimension> reversed(const NurbsCurve<Dimension>& curve) {
  NurbsCurve<Dimension> result{curve.degree, {}, {}, {}};
  const auto [begin, end] = curve.domain();
  for (std::size_t i = curve.knots.size(); i-- > 0;) {
    const double t = curve.knots[i];
    // Without rounding at the ends.
    result.knots.push_back(t == begin ? end : t == end ? begin : begin + end - t);
  }
  result.points.assign(curve.points.rbegin(), curve.points.rend());
  result.weights.assign(curve.weights.rbegin(), curve.weights.rend());
  return result;
}

template void validate(const NurbsCurve<2>&, const std::string&);
template CurveDerivatives<2> derivatives(const NurbsCurve<2>&, double);
template Eigen::Matrix<double, 2, 1> evaluate(const NurbsCurve<2>&, double);
template NurbsCurve<2> insert_knot(const NurbsCurve<2>&, double, int);
template NurbsCurve<2> part(const NurbsCurve<2>&, const ParameterRange&);
template NurbsCurve<2> reversed(const NurbsCurve<2>&);
template void validate(const NurbsCurve<3>&, const std::string&);
template CurveDerivatives<3> derivatives(const NurbsCurve<3>&, double);
template Eigen::Matrix<double, 3, 1> evaluate(const NurbsCurve<3>&, double);
template NurbsCurve<3> insert_knot(const NurbsCurve<3>&, double, int);
template NurbsCurve<3> part(const NurbsCurve<3>&, const ParameterRange&);
template NurbsCurve<3> reversed(const NurbsCurve<3>&);

}  // namespace recede
