#include <recede/shells/detail/power_triangle.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

// Gauss-Legendre quadrature of ten points on [-1, 1].
constexpr std::array<double, 5> k_places = {0.1488743389816312, 0.4333953941292472, 0.6794095682990244,
                                            0.8650633666889845, 0.9739065285171717};
constexpr std::array<double, 5> k_weights = {0.2955242247147529, 0.2692667193099964, 0.2190863625159820,
                                             0.1494513491505806, 0.0666713443086881};

/// An edge in the triangle's plane: the foot of the point of interest is `distance` inside of it, and its
/// ends are at `from` and `to` along it.
struct Edge {
  Vec3 outward;
  double distance, from, to;

  double squared_distance_to_foot() const {
    const double along = from > 0 ? from : std::min(to, 0.0);
    return distance * distance + along * along;
  }
};

Edge edge_of(const Vec3& a, const Vec3& b, const Vec3& normal) {
  const Vec3 direction = (b - a).normalized();
  const Vec3 outward = direction.cross(normal);
  return {outward, a.dot(outward), a.dot(direction), b.dot(direction)};
}

struct EdgeIntegrals {
  double value = 0;   ///< what the edge adds to I_p, over its distance
  double second = 0;  ///< the same of p + 2
  double along = 0;   ///< of |y|^-p along the edge
};

/// The integral of r / (r^2 + w^2)^(p / 2) up to the radius `rho`, over rho^2. It starts at 0 or, where the
/// foot is outside of the triangle and the part about it cancels between the edges, wherever the powers are
/// simplest.
double radial(double rho2, double w, double p, bool from_center) {
  const double r2 = rho2 + w * w;
  constexpr double k_near_logarithm = 0.5;
  if (!from_center) {
    if (p == 2) return 0.5 * std::log(r2) / rho2;
    if (std::abs(p - 2) < k_near_logarithm)
      return -std::expm1((1 - 0.5 * p) * std::log(r2)) / ((p - 2) * rho2);
    return -std::pow(r2, 1 - 0.5 * p) / ((p - 2) * rho2);
  }
  if (w > 0 && (rho2 < 4 * w * w || std::abs(p - 2) < k_near_logarithm)) {
    const double logarithm = 0.5 * std::log1p(rho2 / (w * w));
    const double part = p == 2 ? logarithm : -std::expm1(-(p - 2) * logarithm) / (p - 2);
    return std::pow(w, 2 - p) * part / rho2;
  }
  return (std::pow(w, 2 - p) - std::pow(r2, 1 - 0.5 * p)) / ((p - 2) * rho2);
}

/// In u with s = c sinh(u), c the distance of the edge's line: integrands are smooth on a scale of about 1
/// there, however near the line is, and fall like a bell of width p^-1/2 about 0.
EdgeIntegrals integrate(const Edge& edge, double w, double p, bool from_center) {
  EdgeIntegrals sums;
  constexpr double k_least = 1e-100;  // of the edge's length: the line goes through the point
  const double c = std::max(std::hypot(edge.distance, w), k_least * (edge.to - edge.from));
  const double first = std::asinh(edge.from / c), last = std::asinh(edge.to / c);
  const double longest = std::min(1.0, 1.5 / std::sqrt(p - 1));
  const auto n = static_cast<int>(std::ceil((last - first) / longest));
  const double half = 0.5 * (last - first) / n;
  for (int panel = 0; panel < n; ++panel) {
    const double middle = first + (2 * panel + 1) * half;
    for (int k = 0; k < 10; ++k) {
      const auto i = static_cast<std::size_t>(k / 2);
      const double u = middle + (k % 2 == 0 ? half : -half) * k_places[i];
      const double s = c * std::sinh(u), r = c * std::cosh(u);
      const double rho2 = edge.distance * edge.distance + s * s;
      const double weight = half * k_weights[i] * r;
      sums.along += weight * std::pow(r, -p);
      sums.value += weight * radial(rho2, w, p, from_center);
      if (w > 0) sums.second += weight * radial(rho2, w, p + 2, from_center);
    }
  }
  return sums;
}

}  // namespace

TriangleIntegral integrate_power(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal, double p) {
  const double height = -a.dot(normal), w = std::abs(height);
  const std::array<Edge, 3> edges = {edge_of(a, b, normal), edge_of(b, c, normal), edge_of(c, a, normal)};
  bool is_inside = true;
  double to_border = std::numeric_limits<double>::infinity();
  for (const Edge& edge : edges) {
    is_inside = is_inside && edge.distance >= 0;
    to_border = std::min(to_border, edge.squared_distance_to_foot());
  }
  if (is_inside && w == 0 && p >= 2) return {std::numeric_limits<double>::infinity(), Vec3::Zero()};
  // From the centre integrands stay bounded at edges near the foot, but what cancels between the edges is
  // (1 + to_border / w^2)^(p / 2) times the result.
  const bool from_center = is_inside || to_border < w * w * std::min(1.0, 4 / (p - 1));
  TriangleIntegral result;
  double second = 0;
  for (const Edge& edge : edges) {
    const EdgeIntegrals sums = integrate(edge, w, p, from_center);
    result.value += edge.distance * sums.value;
    second += edge.distance * sums.second;
    result.gradient -= sums.along * edge.outward;
  }
  // The derivative by the height is -p w I_(p + 2): nothing cancels.
  result.gradient -= p * height * second * normal;
  return result;
}

}  // namespace recede::detail
