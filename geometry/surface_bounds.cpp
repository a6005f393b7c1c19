#include <recede/geometry/detail/net_enclosure.h>
#include <recede/geometry/surface_bounds.h>

#include <cmath>
#include <numbers>

namespace recede {

namespace {

using detail::BezierNet;
using detail::DerivativeEnclosure;
using detail::IntervalVec3;
using detail::rounded_down;
using detail::rounded_up;

constexpr double k_near_enough = 1.5;     // a bound over what was met
constexpr double k_for_rounding = 1e-12;  // added to bounds, relative
constexpr double k_float_step = 2e-7;     // more than a step of single precision
constexpr double k_most_nodes = 1 << 18;  // about, of one surface
constexpr double k_least_finest = 1e-6;   // of the size: what is looked at at all
constexpr int k_most_halvings = 12;       // of a Bezier patch

double deviation_of(const DerivativeBounds& bounds, double width, double height) {
  return (width * width * bounds.uu + 2 * width * height * bounds.uv + height * height * bounds.vv) / 8;
}

// Of the smallest circle around a triangle in the metric of second derivatives.
double half_squared_radius(const std::array<Vec2, 3>& sides, double twice_area, const Vec3& second,
                           double width, double height) {
  if (!(width > 0 && height > 0)) return deviation_of({0, 0, second[0], second[1], second[2]}, width, height);
  // Shares of the box, without a quotient of its sides, which may be as far apart as numbers are.
  std::array<double, 3> squares;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = sides[i].x(), y = sides[i].y();
    squares[i] = second[0] * x * x + second[1] * (height * x * (x / width) + width * y * (y / height)) +
                 second[2] * y * y;
  }
  std::sort(squares.begin(), squares.end());
  // 4 times the square of the area in the metric.
  const double of_sides = (second[0] * width + second[1] * height) * (second[2] * height + second[1] * width);
  const double squared_area = of_sides * (twice_area / width / height) * twice_area;
  if (squares[2] >= squares[0] + squares[1] || !(squared_area > 0)) return squares[2] / 8;
  return squares[0] * squares[1] * squares[2] / (8 * squared_area);
}

// From parameters of the piece to those of the surface.
DerivativeBounds in_domain(const DerivativeBounds& bounds, double width, double height) {
  return {bounds.u / width, bounds.v / height, bounds.uu / (width * width), bounds.uv / (width * height),
          bounds.vv / (height * height)};
}

NormalCone cone_around(const DerivativeEnclosure& enclosure) {
  const IntervalVec3 normals = cross(enclosure.du, enclosure.dv);
  const Vec3 center = 0.5 * (normals.lower + normals.upper);
  const double radius = 0.5 * (normals.upper - normals.lower).norm(), length = center.norm();
  if (!(radius < length)) return {};
  return {center / length, std::asin(radius / length)};
}

// The narrowest that holds both.
NormalCone merged(const NormalCone& a, const NormalCone& b) {
  const double between = angle_between(a.axis, b.axis);
  if (between + b.angle <= a.angle) return a;
  if (between + a.angle <= b.angle) return b;
  const double angle = (between + a.angle + b.angle) / 2;
  const Vec3 side = a.axis.cross(b.axis);
  if (!(angle < std::numbers::pi && side.norm() > 0)) return {};
  return {Eigen::AngleAxisd(angle - a.angle, side.normalized()) * a.axis, angle};
}

// The largest of a polynomial `a.xyz b.w - a.w b.xyz` of twice the degree, by its control points.
double largest_cross(const std::vector<Vec4>& a, const std::vector<Vec4>& b) {
  const std::size_t q = a.size() - 1;
  std::vector<double> choose(2 * q + 1, 1.0), choose_one(q + 1, 1.0);  // binomial coefficients
  for (std::size_t k = 1; k <= 2 * q; ++k)
    choose[k] = choose[k - 1] * static_cast<double>(2 * q + 1 - k) / static_cast<double>(k);
  for (std::size_t k = 1; k <= q; ++k)
    choose_one[k] = choose_one[k - 1] * static_cast<double>(q + 1 - k) / static_cast<double>(k);
  double largest = 0;
  for (std::size_t k = 0; k <= 2 * q; ++k) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = k > q ? k - q : 0; i <= std::min(k, q); ++i)
      sum +=
          choose_one[i] * choose_one[k - i] * (b[k - i].w() * a[i].head<3>() - a[i].w() * b[k - i].head<3>());
    largest = std::max(largest, sum.norm() / choose[k]);
  }
  return largest;
}

// A bound of how much the derivative along an axis changes from a patch to the next. Both have the same
// points and weights b at the border, and derivatives of these that differ by a: what is left of the
// quotients' difference is (a.xyz b.w - a.w b.xyz) / b.w^2, nothing around circles of several pieces.
double jump_between(const BezierPatches& surface, std::size_t axis, const std::array<std::size_t, 2>& before,
                    const std::array<std::size_t, 2>& after) {
  const auto p = static_cast<std::size_t>(surface.degrees()[axis]);
  const auto q = static_cast<std::size_t>(surface.degrees()[1 - axis]);
  const std::span<const double> breaks = surface.breaks(axis);
  const double width_before = breaks[before[axis] + 1] - breaks[before[axis]];
  const double width_after = breaks[after[axis] + 1] - breaks[after[axis]];
  const std::vector<Vec4> net_before = surface.net(before[0], before[1]),
                          net_after = surface.net(after[0], after[1]);
  const auto number = [&](std::size_t along, std::size_t across) {
    return axis == 0 ? along * (q + 1) + across : across * (p + 1) + along;
  };
  std::vector<Vec4> border, jumps;
  Box3 box;
  double least_weight = 1e300;
  for (std::size_t j = 0; j <= q; ++j) {
    border.push_back(net_after[number(0, j)]);
    jumps.emplace_back(static_cast<double>(p) *
                       ((net_after[number(1, j)] - net_after[number(0, j)]) / width_after -
                        (net_before[number(p, j)] - net_before[number(p - 1, j)]) / width_before));
    box.extend(Vec3(border.back().head<3>() / border.back().w()));
    least_weight = std::min(least_weight, border.back().w());
  }
  // Seen from the middle of the border, far from the origin too.
  for (std::size_t j = 0; j <= q; ++j) {
    border[j].head<3>() -= border[j].w() * box.center();
    jumps[j].head<3>() -= jumps[j].w() * box.center();
  }
  return largest_cross(jumps, border) / (least_weight * least_weight);
}

}  // namespace

class SurfaceBounds::Builder {
 public:
  Builder(const BezierPatches& surface, SurfaceBounds& bounds, double finest)
      : surface_(surface), bounds_(bounds) {
    Box3 box;
    for (std::size_t i = 0; i < surface.n_patches(0); ++i) {
      for (std::size_t j = 0; j < surface.n_patches(1); ++j) {
        for (const Vec4& point : surface.net(i, j)) box.extend(Vec3(point.head<3>() / point.w()));
      }
    }
    bounds.origin_ = box.center();
    unimportant_ = std::max(finest, k_least_finest * box.diagonal().norm());
    const double n_patches = static_cast<double>(surface.n_patches(0) * surface.n_patches(1));
    most_halvings_ =
        std::clamp(static_cast<int>(std::log2(k_most_nodes / n_patches)) - 1, 0, k_most_halvings);
    bounds.nodes_.resize(1);
    build_grid(0, {0, 0}, {surface.n_patches(0), surface.n_patches(1)});
  }

 private:
  using Place = std::array<std::size_t, 2>;

  // Patches from `first` to before `end` as a tree.
  void build_grid(std::size_t node, const Place& first, const Place& end) {
    const Place count{end[0] - first[0], end[1] - first[1]};
    if (count[0] == 1 && count[1] == 1) {
      const std::span<const double> u = surface_.breaks(0), v = surface_.breaks(1);
      BezierNet piece{
          {static_cast<std::size_t>(surface_.degrees()[0]), static_cast<std::size_t>(surface_.degrees()[1])},
          surface_.is_rational(),
          {Vec2(u[first[0]], v[first[1]]), Vec2(u[first[0] + 1], v[first[1] + 1])},
          surface_.net(first[0], first[1])};
      build_piece(node, piece, most_halvings_);
      return;
    }
    const std::size_t axis = count[0] >= count[1] ? 0 : 1;
    Place middle_end = end, middle_first = first;
    middle_end[axis] = middle_first[axis] = first[axis] + count[axis] / 2;
    const std::size_t child = add_children(node, axis, surface_.breaks(axis)[middle_first[axis]]);
    build_grid(child, first, middle_end);
    build_grid(child + 1, middle_first, end);
    merge(node, child);
    bounds_.nodes_[node].jump = rounded_up(largest_jump(axis, middle_first, middle_end, end));
    bounds_.nodes_[node].jumps[axis] += bounds_.nodes_[node].jump;
  }

  // Of the derivative across the line of knots between both children.
  double largest_jump(std::size_t axis, const Place& first, const Place& middle_end, const Place& end) const {
    const std::size_t across = 1 - axis;
    double largest = 0;
    for (std::size_t k = first[across]; k < end[across]; ++k) {
      Place before, after;
      before[axis] = middle_end[axis] - 1;
      after[axis] = middle_end[axis];
      before[across] = after[across] = k;
      largest = std::max(largest, jump_between(surface_, axis, before, after));
    }
    return largest;
  }

  void build_piece(std::size_t node, const BezierNet& piece, int halvings_left) {
    const DerivativeEnclosure enclosure = enclose(piece);
    const DerivativeBounds lengths = in_domain(enclosure.lengths, piece.width(), piece.height());
    if (halvings_left > 0 && !is_near_enough(piece, lengths)) {
      const std::size_t axis = axis_to_halve(piece, lengths);
      const std::array<BezierNet, 2> parts = halves(piece, axis);
      const std::size_t child = add_children(node, axis, parts[1].part.min()[static_cast<int>(axis)]);
      build_piece(child, parts[0], halvings_left - 1);
      build_piece(child + 1, parts[1], halvings_left - 1);
      merge(node, child);
      return;
    }
    Node& leaf = bounds_.nodes_[node];
    Box3 box;
    for (const Vec4& point : piece.points) box.extend(Vec3(point.head<3>() / point.w()));
    const double slack = k_for_rounding * (box.diagonal().norm() + bounds_.origin_.norm());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<int>(axis);
      leaf.lower[axis] = rounded_down(box.min()[i] - bounds_.origin_[i] - slack);
      leaf.upper[axis] = rounded_up(box.max()[i] - bounds_.origin_[i] + slack);
    }
    const std::array<double, 5> all{lengths.u, lengths.v, lengths.uu, lengths.uv, lengths.vv};
    for (std::size_t i = 0; i < 5; ++i) leaf.derivatives[i] = rounded_up(all[i] * (1 + k_for_rounding));
    set_cone(leaf, cone_around(enclosure));
    leaf.first_child = 0;
    leaf.jump = 0;
    leaf.jumps = {};
  }

  // The one along which the surface bends more; but where that fades along the other, as toward a pole, it
  // would be as bad for long triangles after any number of halves.
  std::size_t axis_to_halve(const BezierNet& piece, const DerivativeBounds& lengths) const {
    std::array<std::array<double, 4>, 2> bends;  // along u and v, at the corners, v fastest
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 share(i < 2 ? 0.01 : 0.99, i % 2 == 0 ? 0.01 : 0.99);
      const SurfaceDerivatives there =
          surface_.derivatives(piece.part.min() + share.cwiseProduct(piece.part.sizes()));
      bends[0][i] = piece.width() * piece.width() * there.duu.norm();
      bends[1][i] = piece.height() * piece.height() * there.dvv.norm();
    }
    const auto fades = [&](double a, double b) {
      return std::max(a, b) > 8 * unimportant_ && std::min(a, b) < std::max(a, b) / 4;
    };
    const bool fades_along_v = fades(bends[0][0], bends[0][1]) && fades(bends[0][2], bends[0][3]);
    const bool fades_along_u = fades(bends[1][0], bends[1][2]) && fades(bends[1][1], bends[1][3]);
    if (fades_along_u != fades_along_v) return fades_along_v ? 1 : 0;
    return piece.width() * piece.width() * lengths.uu >= piece.height() * piece.height() * lengths.vv ? 0 : 1;
  }

  // Compares with the least deviation met at a few places, so that the bound is near everywhere.
  bool is_near_enough(const BezierNet& piece, const DerivativeBounds& lengths) const {
    const double bound = deviation_of(lengths, piece.width(), piece.height());
    if (bound <= unimportant_) return true;
    for (const Vec2& share :
         {Vec2(0.5, 0.5), Vec2(0.01, 0.01), Vec2(0.99, 0.01), Vec2(0.01, 0.99), Vec2(0.99, 0.99)}) {
      const SurfaceDerivatives there =
          surface_.derivatives(piece.part.min() + share.cwiseProduct(piece.part.sizes()));
      const double met = deviation_of({0, 0, there.duu.norm(), there.duv.norm(), there.dvv.norm()},
                                      piece.width(), piece.height());
      if (bound > k_near_enough * met) return false;
    }
    return true;
  }

  std::size_t add_children(std::size_t node, std::size_t axis, double split) {
    const std::size_t child = bounds_.nodes_.size();
    bounds_.nodes_.resize(child + 2);
    bounds_.nodes_[node].first_child = static_cast<std::uint32_t>(child);
    bounds_.nodes_[node].axis = static_cast<std::uint32_t>(axis);
    bounds_.nodes_[node].split = split;
    return child;
  }

  void merge(std::size_t node, std::size_t child) {
    const Node &a = bounds_.nodes_[child], &b = bounds_.nodes_[child + 1];
    Node& result = bounds_.nodes_[node];
    for (std::size_t i = 0; i < 3; ++i) {
      result.lower[i] = std::min(a.lower[i], b.lower[i]);
      result.upper[i] = std::max(a.upper[i], b.upper[i]);
    }
    for (std::size_t i = 0; i < 5; ++i) result.derivatives[i] = std::max(a.derivatives[i], b.derivatives[i]);
    set_cone(result, merged(cone_of(a), cone_of(b)));
    result.jump = 0;
    for (std::size_t axis = 0; axis < 2; ++axis) result.jumps[axis] = a.jumps[axis] + b.jumps[axis];
  }

  static void set_cone(Node& node, const NormalCone& cone) {
    node.cone = {static_cast<float>(cone.axis.x()), static_cast<float>(cone.axis.y()),
                 static_cast<float>(cone.axis.z()), rounded_up(cone.angle + k_float_step)};
  }

 public:
  static NormalCone cone_of(const Node& node) {
    const Vec3 axis(node.cone[0], node.cone[1], node.cone[2]);
    return {axis.normalized(), node.cone[3]};
  }

 private:
  const BezierPatches& surface_;
  SurfaceBounds& bounds_;
  double unimportant_ = 0;
  int most_halvings_ = 0;
};

SurfaceBounds::SurfaceBounds(const BezierPatches& surface, double finest) : domain_(surface.domain()) {
  const Builder builder(surface, *this, finest);
}

// Calls `visit(node, is_last)` for nodes whose parts meet `part`; it says whether their children are wanted.
// `is_last`: the node has none, or lies within the part.
template <typename Visit>
void SurfaceBounds::visit(const ParameterBox& part, Visit&& visit) const {
  struct Entry {
    std::uint32_t node;
    ParameterBox box;
  };
  std::array<Entry, 64> stack;  // as deep as the tree at most: a patch's number and its halvings
  std::size_t size = 0;
  stack[size++] = {0, domain_};
  while (size > 0) {
    const Entry entry = stack[--size];
    const Node& node = nodes_[entry.node];
    const bool is_last = node.first_child == 0 || part.contains(entry.box);
    if (!visit(node, is_last) || node.first_child == 0) continue;
    const auto axis = static_cast<int>(node.axis);
    if (part.min()[axis] <= node.split) {
      stack[size] = {node.first_child, entry.box};
      stack[size++].box.max()[axis] = node.split;
    }
    if (part.max()[axis] >= node.split) {
      stack[size] = {node.first_child + 1, entry.box};
      stack[size++].box.min()[axis] = node.split;
    }
  }
}

Box3 SurfaceBounds::box(const ParameterBox& part) const {
  Box3 box;
  visit(part, [&](const Node& node, bool is_last) {
    if (is_last) {
      box.extend(Vec3(node.lower[0], node.lower[1], node.lower[2]) + origin_);
      box.extend(Vec3(node.upper[0], node.upper[1], node.upper[2]) + origin_);
    }
    return !is_last;
  });
  return box;
}

double SurfaceBounds::distance(const ParameterBox& part, const Vec3& point) const {
  const Vec3 from = point - origin_;
  double least = std::numeric_limits<double>::infinity();
  visit(part, [&](const Node& node, bool) {
    const Box3 box(Vec3(node.lower[0], node.lower[1], node.lower[2]),
                   Vec3(node.upper[0], node.upper[1], node.upper[2]));
    const double squared = box.squaredExteriorDistance(from);
    // Down to the smallest boxes, which are nearest to the surface.
    if (squared >= least) return false;
    if (node.first_child == 0) least = squared;
    return true;
  });
  return std::sqrt(least);
}

DerivativeBounds SurfaceBounds::derivatives(const ParameterBox& part) const {
  std::array<float, 5> largest{};
  visit(part, [&](const Node& node, bool is_last) {
    if (is_last) {
      for (std::size_t i = 0; i < 5; ++i) largest[i] = std::max(largest[i], node.derivatives[i]);
    }
    return !is_last;
  });
  return {largest[0], largest[1], largest[2], largest[3], largest[4]};
}

NormalCone SurfaceBounds::normal_cone(const ParameterBox& part) const {
  NormalCone cone;
  bool is_first = true;
  visit(part, [&](const Node& node, bool is_last) {
    if (is_last) {
      cone = is_first ? Builder::cone_of(node) : merged(cone, Builder::cone_of(node));
      is_first = false;
    }
    return !is_last;
  });
  return cone;
}

DeviationBound SurfaceBounds::deviation(const std::array<Vec2, 3>& triangle, double enough) const {
  ParameterBox part;
  for (const Vec2& corner : triangle) part.extend(corner);
  const double width = part.sizes().x(), height = part.sizes().y();
  const std::array<Vec2, 3> sides{triangle[2] - triangle[1], triangle[0] - triangle[2],
                                  triangle[1] - triangle[0]};
  const double area = sides[0].x() * sides[1].y() - sides[0].y() * sides[1].x();
  double largest = 0, of_jumps = 0;
  visit(part, [&](const Node& node, bool is_last) {
    const auto& [u, v, uu, uv, vv] = node.derivatives;
    const double here = half_squared_radius(sides, area, {uu, uv, vv}, width, height);
    const double jumps = (width * node.jumps[0] + height * node.jumps[1]) / 4;
    if (!is_last && here + jumps > enough) {
      const auto axis = static_cast<int>(node.axis);
      if (part.min()[axis] < node.split && node.split < part.max()[axis])
        of_jumps += (axis == 0 ? width : height) * node.jump / 4;
      return true;
    }
    largest = std::max(largest, here);
    of_jumps += jumps;
    return false;
  });
  // Where it stopped early, jumps of all of a node were added up.
  if (enough > 0 && of_jumps > 0 && largest + of_jumps > enough) return deviation(triangle);
  return {largest, of_jumps};
}

double SurfaceBounds::deviation(const Vec2& from, const Vec2& to, double enough) const {
  return deviation({from, to, to}, enough).total();
}

}  // namespace recede
