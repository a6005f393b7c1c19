#include <recede/geometry/error.h>
#include <recede/shells/detail/cubic_triangle.h>
#include <recede/shells/detail/lp_field.h>
#include <recede/shells/detail/power_triangle.h>

#include <cmath>
#include <numbers>

namespace recede::detail {
namespace {

constexpr double k_fade_end = 1.25;  // of the support
constexpr double k_fading_part =
    0.125;  // where weights differ, radius of parts that are summed up, of the support

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

/// The nearest triangle, or point of the source.
std::unique_ptr<const ClosestPointTree> nearest_of(const Surface& surface, LpSource source) {
  if (source == LpSource::triangles)
    return std::make_unique<const ClosestPointTree>(surface.positions, surface.corners);
  std::vector<Index> points;
  for (const Index corner : surface.corners) points.insert(points.end(), 3, corner);
  return std::make_unique<const ClosestPointTree>(surface.positions, points);
}

template <bool is_cubic>
DoublePair power_of(DoublePair inverse_square, double p, double squared_unit) {
  if constexpr (is_cubic) {
    return inverse_square * root(inverse_square);
  } else {
    return DoublePair{std::pow(inverse_square[0] * squared_unit, 0.5 * p),
                      std::pow(inverse_square[1] * squared_unit, 0.5 * p)};
  }
}

/// 1 up to the support, 0 from 5/4 of it on.
DoublePair weight_of(DoublePair distance, double support) {
  const DoublePair t = (both(k_fade_end * support) - distance) / both((k_fade_end - 1) * support);
  const DoublePair zero = both(0), one = both(1), two = both(2);
  const DoublePair inside = select(t < zero, zero, select(t > one, one, t));
  return inside * inside * (both(3) - two * inside);
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

struct LpField::Query {
  Vec3 point;
  double unit = 1;  ///< lengths' powers are relative to it
};

LpField::LpField(const PolygonSoup& soup, const LpDistanceOptions& options)
    : options_(options),
      frame_(bounding_box(checked(soup, options))),
      support_(std::ldexp(options.support, frame_.exponent)) {
  const Surface surface = surface_of(soup, frame_);
  tree_ = LpTree(
      elements_of(surface, options.source),
      {options.p, options.expansion == LpExpansion::quadrupole, options.opening, options.error.value_or(0)});
  for (const double area : surface.areas) area_ += area;
  area_ = std::ldexp(area_, -2 * frame_.exponent);
  if (options.p != 3) nearest_ = nearest_of(surface, options.source);
}

template <bool is_cubic, bool is_weighted>
void LpField::add_triangles(const Query& query, std::size_t index, LpSums& sums) const {
  const LpTriangleBlock& block = tree_.blocks[index];
  const double* masses = &tree_.block_masses[k_lp_lanes * index];
  const Vec3Pair x = {both(query.point.x()), both(query.point.y()), both(query.point.z())};
  for (std::size_t lane = 0; lane < k_lp_lanes; lane += 2) {
    const auto load = [&](const double(&v)[3][k_lp_lanes]) {
      return Vec3Pair{pair_at(&v[0][lane]), pair_at(&v[1][lane]), pair_at(&v[2][lane])};
    };
    const Vec3Pair a = load(block.corners[0]) - x, b = load(block.corners[1]) - x,
                   c = load(block.corners[2]) - x, normal = load(block.normal);
    const DoublePair twice_area = pair_at(&block.twice_area[lane]);
    DoublePair weight = both(1);
    if constexpr (is_weighted) {
      const DoublePair third = both(1.0 / 3);
      const Vec3Pair centroid = {(a.x + b.x + c.x) * third, (a.y + b.y + c.y) * third,
                                 (a.z + b.z + c.z) * third};
      weight = weight_of(root(dot(centroid, centroid)), support_);
    }
    IntegralPair part;
    if constexpr (is_cubic) {
      part = integrate_cubic(a, b, c, normal, twice_area);
    } else {
      part = {both(0), {both(0), both(0), both(0)}};
      const double unit = query.unit;
      for (int k = 0; k < 2; ++k) {
        if (!(twice_area[k] > 0) || (is_weighted && !(weight[k] > 0))) continue;
        const auto corner = [&](const Vec3Pair& v) {
          return Vec3(v.x[k] / unit, v.y[k] / unit, v.z[k] / unit);
        };
        const TriangleIntegral one = integrate_power(corner(a), corner(b), corner(c),
                                                     Vec3(normal.x[k], normal.y[k], normal.z[k]), options_.p);
        part.value[k] = one.value * unit * unit;
        part.gradient.x[k] = one.gradient.x() * unit;
        part.gradient.y[k] = one.gradient.y() * unit;
        part.gradient.z[k] = one.gradient.z() * unit;
      }
    }
    if constexpr (is_weighted) {
      // A triangle that doesn't count may be anywhere, but not the reason for an infinity.
      const PairMask counts = weight > both(0);
      part.value = where(counts, part.value * weight);
      part.gradient = {where(counts, part.gradient.x * weight), where(counts, part.gradient.y * weight),
                       where(counts, part.gradient.z * weight)};
    }
    sums.integral += sum(part.value);
    sums.gradient += Vec3(sum(part.gradient.x), sum(part.gradient.y), sum(part.gradient.z));
    sums.area += sum(pair_at(masses + lane) * weight);
  }
}

template <bool is_weighted>
void LpField::add_points(const Query& query, std::size_t index, LpSums& sums) const {
  const LpTriangleBlock& block = tree_.blocks[index];
  for (std::size_t lane = 0; lane < k_lp_lanes; ++lane) {
    const double mass = tree_.block_masses[k_lp_lanes * index + lane];
    const Vec3 r =
        query.point - Vec3(block.corners[0][0][lane], block.corners[0][1][lane], block.corners[0][2][lane]);
    const double squared = r.squaredNorm();
    double weighted = mass;
    if constexpr (is_weighted) weighted *= weight_of(both(std::sqrt(squared)), support_)[0];
    if (!(squared > 0) || !(weighted > 0)) continue;
    const double power = weighted * std::pow(query.unit * query.unit / squared, 0.5 * options_.p);
    sums.integral += power;
    sums.gradient -= options_.p * power / squared * r;
    sums.area += weighted;
  }
}

/// What a node's far children add, pairwise.
template <bool is_cubic, bool is_weighted, bool is_bounded>
struct FarSums {
  DoublePair value = both(0), mass = both(0);
  Vec3Pair gradient = {both(0), both(0), both(0)};
  DoublePair error = both(0), gradient_error = both(0);

  struct Setting {
    Vec3Pair x;
    double p, squared_unit, support;
    bool quadrupole;
    double error_factor, gradient_error_factor;
  };

  /// The children that are neither summed up nor without weight.
  PairMask add(const Setting& setting, const LpNode& node, const LpNodeExtent& extent, std::size_t lane) {
    const double p = setting.p;
    const Vec3Pair r =
        setting.x - Vec3Pair{pair_at(node.x + lane), pair_at(node.y + lane), pair_at(node.z + lane)};
    const DoublePair squared = dot(r, r);
    PairMask is_far = squared > pair_at(node.squared_reach + lane), is_out = squared < both(0);
    DoublePair weight = both(1), distance = both(0);
    const DoublePair radius = is_weighted || is_bounded ? pair_at(extent.radius + lane) : both(0);
    if constexpr (is_weighted || is_bounded) distance = root(squared);
    if constexpr (is_weighted) {
      weight = weight_of(distance, setting.support);
      is_out = distance - radius > both(k_fade_end * setting.support);
      // The bound is for weights by triangles: where they differ, the tree is followed down to them.
      const PairMask is_full = distance + radius < both(setting.support);
      if constexpr (is_bounded) {
        is_far = is_far & is_full;
      } else {
        is_far = is_far & (is_full | (radius < both(k_fading_part * setting.support)));
      }
    }
    const PairMask counts = is_far & ~is_out;
    const DoublePair inverse = where(counts, both(1) / squared);
    const auto entry = [&](std::size_t k) { return pair_at(node.tensor[k] + lane); };
    const DoublePair xy = entry(3), xz = entry(4), yz = entry(5);
    const Vec3Pair turned = {entry(0) * r.x + xy * r.y + xz * r.z, xy * r.x + entry(1) * r.y + yz * r.z,
                             xz * r.x + yz * r.y + entry(2) * r.z};
    const DoublePair child = pair_at(node.mass + lane), inverse2 = inverse * inverse;
    const DoublePair second = dot(turned, r) * inverse2;
    const DoublePair power = power_of<is_cubic>(inverse, p, setting.squared_unit) * weight;
    value += power * (child + second);
    const DoublePair along = -power * inverse * (both(p) * child + both(p + 4) * second),
                     across = both(2) * power * inverse2;
    gradient.x += along * r.x + across * turned.x;
    gradient.y += along * r.y + across * turned.y;
    gradient.z += along * r.z + across * turned.z;
    mass += where(counts, child * weight);
    if constexpr (is_bounded) {
      const DoublePair nearest = where(counts, both(1) / (distance - radius)), nearest2 = nearest * nearest;
      const DoublePair order = setting.quadrupole ? nearest * nearest2 : nearest2;
      const DoublePair remainder =
          pair_at(extent.remainder + lane) * order * power_of<is_cubic>(nearest2, p, setting.squared_unit);
      error += both(setting.error_factor) * remainder;
      gradient_error += both(setting.gradient_error_factor) * remainder * nearest;
    }
    return ~(is_far | is_out);
  }
};

template <bool is_cubic, bool is_weighted, bool is_bounded>
LpSums LpField::integrate(const Query& query) const {
  using Far = FarSums<is_cubic, is_weighted, is_bounded>;
  const Vec3& point = query.point;
  typename Far::Setting setting{{both(point.x()), both(point.y()), both(point.z())},
                                options_.p,
                                query.unit * query.unit,
                                support_,
                                tree_.quadrupole,
                                1,
                                1};
  const int order = tree_.first_order_left_out();
  for (int k = 0; k < order; ++k) setting.error_factor *= (options_.p + k) / (k + 1);
  // One derivative more: p (p + 1) ... (p + order) / order!, by the same polynomials.
  setting.gradient_error_factor = setting.error_factor * (options_.p + order);
  Far far;
  LpSums sums;
  constexpr std::size_t k_depth =
      64;  // 3 for each level of a tree of 2^31 triangles at most, and the last four
  Index stack[k_depth];
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Index next = stack[--top];
    if ((next & k_lp_leaf_bit) != 0) {
      const std::size_t block = next & ~k_lp_leaf_bit;
      if (options_.source == LpSource::triangles) {
        add_triangles<is_cubic, is_weighted>(query, block, sums);
      } else {
        add_points<is_weighted>(query, block, sums);
      }
      continue;
    }
    const LpNode& node = tree_.nodes[next];
    const PairMask open[2] = {far.add(setting, node, tree_.extents[next], 0),
                              far.add(setting, node, tree_.extents[next], 2)};
    // Without a branch for each child, which processors would guess wrong.
    for (std::size_t lane = 0; lane < k_lp_lanes; ++lane) {
      stack[top] = node.child[lane];
      top += open[lane / 2][lane % 2] != 0 ? 1 : 0;
    }
  }
  sums.integral += sum(far.value);
  sums.gradient += Vec3(sum(far.gradient.x), sum(far.gradient.y), sum(far.gradient.z));
  sums.area += sum(far.mass);
  sums.error = sum(far.error);
  sums.gradient_error = sum(far.gradient_error);
  return sums;
}

LpSums LpField::sum_up(const Query& query) const {
  const bool is_weighted = std::isfinite(support_), is_bounded = options_.error.has_value();
  if (options_.p == 3) {
    if (is_bounded)
      return is_weighted ? integrate<true, true, true>(query) : integrate<true, false, true>(query);
    return is_weighted ? integrate<true, true, false>(query) : integrate<true, false, false>(query);
  }
  if (is_bounded)
    return is_weighted ? integrate<false, true, true>(query) : integrate<false, false, true>(query);
  return is_weighted ? integrate<false, true, false>(query) : integrate<false, false, false>(query);
}

LpValue LpField::at(const Vec3& point) const {
  if (!point.allFinite()) throw InputError("an averaged distance was asked for a point that isn't finite");
  Query query{frame_.inside(point)};
  if (nearest_) {
    query.unit = std::sqrt(nearest_->closest(query.point).squared_distance);
    // Nothing is at a distance of 0 to be relative to: on the surface, or at a point that is left out.
    if (!(query.unit > 0)) {
      if (options_.p >= 2 && options_.source == LpSource::triangles) return {};
      query.unit = 1;
    }
  }
  return value_of(sum_up(query), query.unit);
}

LpValue LpField::value_of(const LpSums& sums, double unit) const {
  const double p = options_.p;
  LpValue result;
  // Not a number: on the surface, or so near that squares overflow.
  if (std::isnan(sums.integral) || std::isinf(sums.integral) || !sums.gradient.allFinite()) return result;
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
  result.gradient = -factor * sums.gradient;
  if (options_.error && sums.error < sums.integral) {
    const double share = sums.error / sums.integral;
    result.error_bound = share / (1 - share);
    // The gradient is I^-(1 + exponent) times that of I, and both are off.
    const double off = std::pow(1 - share, -(1 + exponent)) - 1;
    result.gradient_error =
        factor * (sums.gradient_error + off * (sums.gradient.norm() + sums.gradient_error));
  }
  result.distance = frame_.outside(distance);
  return result;
}

}  // namespace recede::detail
