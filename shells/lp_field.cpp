#include <recede/geometry/error.h>
#include <recede/shells/detail/lp_field.h>
#include <recede/shells/detail/power_triangle.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::detail {
namespace {

void check(const LpDistanceOptions& options) {
  constexpr double k_largest_power = 1000;
  if (!(options.p > 1 && options.p <= k_largest_power))
    throw OptionError("p must be above 1 and at most 1000");
  if (options.form == LpForm::calibrated && !(options.p > 2))
    throw OptionError("p must be above 2 for the calibrated form");
  if (!(options.opening >= 0)) throw OptionError("opening must not be negative");
  if (options.error && !(*options.error > 0 && *options.error < 1))
    throw OptionError("error must lie between 0 and 1");
  if (!(options.support > 0)) throw OptionError("support must be above 0");
}

struct Surface {
  std::vector<Vec3> positions;  ///< in the frame
  std::vector<Index> corners;   ///< of triangles with an area
  std::vector<double> areas;
};

Surface surface_of(const PolygonSoup& soup, const LpFrame& frame) {
  Surface surface;
  surface.positions.reserve(soup.positions.size());
  for (const Vec3& p : soup.positions) surface.positions.push_back(frame.inside(p));
  const std::vector<Index> corners = triangulate(soup);
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    const Vec3 &a = surface.positions[corners[t]], &b = surface.positions[corners[t + 1]],
               &c = surface.positions[corners[t + 2]];
    const double area = 0.5 * (b - a).cross(c - a).norm();
    if (!(area > 0)) continue;
    surface.areas.push_back(area);
    for (std::size_t k = 0; k < 3; ++k) surface.corners.push_back(corners[t + k]);
  }
  if (surface.areas.empty()) throw InputError("the surface of an averaged distance has no area");
  return surface;
}

std::vector<LpElement> elements_of(const Surface& surface, LpSource source) {
  std::vector<LpElement> elements;
  if (source == LpSource::triangles) {
    for (std::size_t t = 0; t < surface.areas.size(); ++t) {
      const auto corner = [&](std::size_t k) { return surface.positions[surface.corners[3 * t + k]]; };
      elements.push_back({{corner(0), corner(1), corner(2)}, surface.areas[t]});
    }
    return elements;
  }
  std::vector<double> masses(surface.positions.size());
  for (std::size_t i = 0; i < surface.corners.size(); ++i)
    masses[surface.corners[i]] += surface.areas[i / 3] / 3;
  for (std::size_t v = 0; v < masses.size(); ++v) {
    const Vec3& at = surface.positions[v];
    if (masses[v] > 0) elements.push_back({{at, at, at}, masses[v]});
  }
  return elements;
}

const PolygonSoup& checked(const PolygonSoup& soup, const LpDistanceOptions& options) {
  check(options);
  validate(soup, "surface");
  return soup;
}

/// Of what has faces: a lost vertex may be anywhere.
Box3 box_of_faces(const PolygonSoup& soup) {
  Box3 box;
  for (const Index vertex : soup.corner_vertices) box.extend(soup.positions[vertex]);
  return box;
}

/// The nearest triangle, or point of the source.
std::unique_ptr<const ClosestPointTree> nearest_of(const Surface& surface, LpSource source) {
  if (source == LpSource::triangles)
    return std::make_unique<const ClosestPointTree>(surface.positions, surface.corners);
  std::vector<Index> points;
  for (const Index corner : surface.corners) points.insert(points.end(), 3, corner);
  return std::make_unique<const ClosestPointTree>(surface.positions, points);
}

/// As in the kernel.
double weight_of(double distance, double support) {
  if (std::isinf(support)) return 1;
  const double t =
      std::clamp((k_lp_fade_end * support - distance) / ((k_lp_fade_end - 1) * support), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Vec3 lane_of(const double (&values)[3][k_lp_lanes], std::size_t lane) {
  return {values[0][lane], values[1][lane], values[2][lane]};
}

void add(double integral, const Vec3& gradient, double area, LpSums& sums) {
  sums.integral += integral;
  for (std::size_t k = 0; k < 3; ++k) sums.gradient[k] += gradient[static_cast<Eigen::Index>(k)];
  sums.area += area;
}

void add_triangles(const LpBlock& block, const LpQuery& query, LpSums& sums) {
  const Vec3 x(query.point[0], query.point[1], query.point[2]);
  for (std::size_t lane = 0; lane < k_lp_lanes; ++lane) {
    if (!(block.mass[lane] > 0)) continue;
    const Vec3 a = lane_of(block.corners[0], lane) - x, b = lane_of(block.corners[1], lane) - x,
               c = lane_of(block.corners[2], lane) - x;
    const Vec3 centroid = (a + b + c) / 3;
    const double squared_radius =
        std::max({(a - centroid).squaredNorm(), (b - centroid).squaredNorm(), (c - centroid).squaredNorm()});
    const double excess = std::max(0.0, std::sqrt(squared_radius) - k_lp_large_triangle * query.support);
    const double weight = weight_of(centroid.norm() - excess, query.support), unit = query.unit;
    if (!(weight > 0)) continue;
    const TriangleIntegral part =
        integrate_power(a / unit, b / unit, c / unit, lane_of(block.normal, lane), query.p);
    add(weight * unit * unit * part.value, weight * unit * part.gradient, weight * block.mass[lane], sums);
  }
}

void add_points(const LpBlock& block, const LpQuery& query, LpSums& sums) {
  for (std::size_t lane = 0; lane < k_lp_lanes; ++lane) {
    const Vec3 r = Vec3(query.point[0], query.point[1], query.point[2]) - lane_of(block.corners[0], lane);
    const double squared = r.squaredNorm();
    const double mass = block.mass[lane] * weight_of(std::sqrt(squared), query.support);
    if (!(squared > 0) || !(mass > 0)) continue;
    const double power = mass * std::pow(query.unit * query.unit / squared, 0.5 * query.p);
    add(power, -query.p * power / squared * r, mass, sums);
  }
}

}  // namespace

LpFrame::LpFrame(const Box3& box) {
  if (box.isEmpty()) return;
  center = 0.5 * box.min() + 0.5 * box.max();
  const double largest = (0.5 * box.max() - 0.5 * box.min()).maxCoeff();
  if (largest > 0) exponent = -std::ilogb(largest);
}

Vec3 LpFrame::inside(const Vec3& p) const {
  const Vec3 d = p - center;
  return {std::ldexp(d.x(), exponent), std::ldexp(d.y(), exponent), std::ldexp(d.z(), exponent)};
}

double LpFrame::outside(double length) const { return std::ldexp(length, -exponent); }

LpField::LpField(const PolygonSoup& soup, const LpDistanceOptions& options)
    : options_(options),
      frame_(box_of_faces(checked(soup, options))),
      support_(std::ldexp(options.support, frame_.exponent)) {
  const Surface surface = surface_of(soup, frame_);
  tree_ = LpTree(
      elements_of(surface, options.source),
      {options.p, options.expansion == LpExpansion::quadrupole, options.opening, options.error.value_or(0)});
  for (const double area : surface.areas) mass_ += area;
  area_ = std::ldexp(mass_, -2 * frame_.exponent);
  if (options.p != 3) nearest_ = nearest_of(surface, options.source);
  is_together_ = options.p == 3 && options.source == LpSource::triangles && !options.error;
  if (is_together_ && std::isfinite(support_)) fades_ = fades_of(tree_, support_);
}

LpQuery LpField::query_of(const Vec3& point) const {
  if (!point.allFinite()) throw InputError("an averaged distance was asked for a point that isn't finite");
  const Vec3 x = frame_.inside(point);
  // The surface has a size of about 1 here: cubes neither overflow nor vanish.
  constexpr double k_farthest = 1e50;
  if (!(x.cwiseAbs().maxCoeff() < k_farthest))
    throw InputError("a point is too far away from the surface for an averaged distance");
  return {{x.x(), x.y(), x.z()},       options_.p, 1, support_, options_.error.has_value(),
          tree_.first_order_left_out()};
}

LpValue LpField::at(const Vec3& point) const {
  LpQuery query = query_of(point);
  const bool is_exact = options_.source == LpSource::triangles;
  if (nearest_) {
    query.unit =
        std::sqrt(nearest_->closest(Vec3(query.point[0], query.point[1], query.point[2])).squared_distance);
    // Nothing is at a distance of 0 to be relative to: on the surface, or at a point that is left out.
    if (!(query.unit > 0)) {
      if (options_.p >= 2 && is_exact) return {};
      query.unit = 1;
    }
  }
  const auto add_leaf = !is_exact ? add_points : options_.p == 3 ? nullptr : add_triangles;
  return value_of(
      lp_kernel().sum({tree_.nodes.data(), tree_.extents.data(), tree_.blocks.data(), add_leaf}, query),
      query.unit);
}

void LpField::at_each(std::span<const Vec3> points, std::span<LpValue> values) const {
  if (!is_together_) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = at(points[i]);
    return;
  }
  constexpr std::size_t k_at_once = 8;
  std::array<LpQuery, k_at_once> queries;
  std::array<LpSums, k_at_once> sums;
  const std::size_t room = fades_.empty() ? tree_.nodes.size() + k_lp_visits_ahead : 0;
  const auto visits = std::make_unique_for_overwrite<LpVisit[]>(room);
  const LpArrays arrays{tree_.nodes.data(), tree_.extents.data(), tree_.blocks.data(), nullptr};
  for (std::size_t first = 0; first < points.size(); first += k_at_once) {
    const std::size_t n = std::min(k_at_once, points.size() - first);
    for (std::size_t i = 0; i < n; ++i) queries[i] = query_of(points[first + i]);
    if (fades_.empty()) {
      lp_kernel().sum_each(arrays, queries.data(), static_cast<int>(n), visits.get(), sums.data());
      for (LpSums& of_one : sums) of_one.area = mass_;
    } else {
      lp_kernel().sum_packet(arrays, fades_.data(), queries.data(), static_cast<int>(n), sums.data());
    }
    for (std::size_t i = 0; i < n; ++i) values[first + i] = value_of(sums[i], 1);
  }
}

LpValue LpField::value_of(const LpSums& sums, double unit) const {
  const double p = options_.p;
  const Vec3 gradient(sums.gradient[0], sums.gradient[1], sums.gradient[2]);
  LpValue result;
  // Not a number: on the surface, or so near that squares overflow.
  if (std::isnan(sums.integral) || std::isinf(sums.integral) || !gradient.allFinite()) return result;
  if (!(sums.integral > 0)) {
    result.distance = std::numeric_limits<double>::infinity();
    return result;
  }
  const bool is_calibrated = options_.form == LpForm::calibrated;
  const double exponent = is_calibrated ? 1 / (p - 2) : 1 / p;
  // unit^-p stands outside of the sums.
  double distance = 0;
  if (is_calibrated && p == 3) {
    distance = 2 * std::numbers::pi / sums.integral;
  } else if (is_calibrated) {
    const double relative = sums.integral / (unit * unit);
    distance = unit * std::pow((p - 2) / (2 * std::numbers::pi) * relative, -exponent);
  } else {
    distance = unit * std::pow(sums.area / sums.integral, exponent);
  }
  const double factor = exponent * distance / sums.integral;
  result.gradient = -factor * gradient;
  if (options_.error && sums.error < sums.integral) {
    const double share = sums.error / sums.integral;
    result.error_bound = share / (1 - share);
    // The gradient is I^-(1 + exponent) times that of I, and both are off.
    const double off = std::pow(1 - share, -(1 + exponent)) - 1;
    result.gradient_error = factor * (sums.gradient_error + off * (gradient.norm() + sums.gradient_error));
  }
  result.distance = frame_.outside(distance);
  return result;
}

}  // namespace recede::detail
