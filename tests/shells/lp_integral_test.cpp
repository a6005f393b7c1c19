// Integrals over single triangles, by other means than the library's.
#include "lp_shapes.h"
#include <recede/shells/detail/power_triangle.h>

#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

using namespace test;

CubicIntegral operator+(const CubicIntegral& a, const CubicIntegral& b) {
  return {a.value + b.value, a.gradient + b.gradient};
}

/// The integral of |x - y|^-3 over the infinite wedge with its apex at `apex` between two directions, by the
/// closed form of the thesis's appendix A with the arc tangent of two arguments.
CubicIntegral wedge(const Vec3& x, const Vec3& apex, const Vec3& first, const Vec3& second) {
  const double beta = angle_between(first, second);
  const Vec3 e = first.normalized(), n = first.cross(second).normalized(), f = n.cross(e);
  const double u = (x - apex).dot(e), v = (x - apex).dot(f), w = (x - apex).dot(n);
  const double q = std::sqrt(u * u + v * v + w * w), sine = std::sin(beta), cosine = std::cos(beta);
  const double k = q - (u * cosine + v * sine);
  const double h = 2 / std::abs(w) * std::atan2(std::abs(w), (q - u) / std::tan(0.5 * beta) - v);
  const double by_u = sine / (q * k), by_v = 1 / (q * (q - u)) - cosine / (q * k);
  const double by_w =
      -h / w + ((u * u + v * v - q * u) * sine - q * v * (1 - cosine)) / (q * w * (q - u) * k);
  return {h, by_u * e + by_v * f + by_w * n};
}

CubicIntegral by_wedges(const Vec3& x, const Triangle& t) {
  const CubicIntegral last = wedge(x, t.c, t.b - t.c, t.c - t.a);
  return wedge(x, t.a, t.b - t.a, t.c - t.a) + wedge(x, t.b, t.b - t.c, t.b - t.a) +
         CubicIntegral{-last.value, -last.gradient};
}

/// Seven points of degree 5 (Radon 1948), and halves of edges until two levels agree.
CubicIntegral by_points(const Vec3& x, const Triangle& t, double p) {
  const double area = 0.5 * (t.b - t.a).cross(t.c - t.a).norm(), s = std::sqrt(15.0);
  CubicIntegral sum{0, Vec3::Zero()};
  const auto add = [&](double weight, double a, double b, double c) {
    const Vec3 r = x - (a * t.a + b * t.b + c * t.c);
    const double value = area * weight * std::pow(r.norm(), -p);
    sum.value += value;
    sum.gradient -= p * value / r.squaredNorm() * r;
  };
  add(9.0 / 40, 1.0 / 3, 1.0 / 3, 1.0 / 3);
  for (const double sign : {-1.0, 1.0}) {
    const double small = (6 + sign * s) / 21, large = 1 - 2 * small, weight = (155 + sign * s) / 1200;
    add(weight, large, small, small);
    add(weight, small, large, small);
    add(weight, small, small, large);
  }
  return sum;
}

CubicIntegral by_adaptive_points(const Vec3& x, const Triangle& t, double p, double tolerance,
                                 int depth = 0) {
  const Vec3 ab = 0.5 * (t.a + t.b), bc = 0.5 * (t.b + t.c), ca = 0.5 * (t.c + t.a);
  const std::array<Triangle, 4> parts = {Triangle{t.a, ab, ca}, {ab, t.b, bc}, {ca, bc, t.c}, {ab, bc, ca}};
  const CubicIntegral whole = by_points(x, t, p);
  CubicIntegral sum{0, Vec3::Zero()};
  for (const Triangle& part : parts) sum = sum + by_points(x, part, p);
  if (depth > 12 || (depth > 1 && std::abs(sum.value - whole.value) < tolerance)) return sum;
  sum = {0, Vec3::Zero()};
  for (const Triangle& part : parts) sum = sum + by_adaptive_points(x, part, p, 0.5 * tolerance, depth + 1);
  return sum;
}

struct Case {
  Triangle triangle;
  Vec3 x;
};
Case random_case(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  Case result{{point(), point(), point()}, Vec3::Zero()};
  while ((result.triangle.b - result.triangle.a).cross(result.triangle.c - result.triangle.a).norm() < 0.2)
    result.triangle = {point(), point(), point()};
  result.x = 2 * point();
  return result;
}

CubicIntegral by_library(const Vec3& x, const Triangle& t) {
  return cubic_integral(LpDistance(one_triangle(t.a, t.b, t.c), exact()).at(x));
}

TEST(LpIntegral, ByEdgesIsThatByWedges) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const auto [t, x] = random_case(random);
    const CubicIntegral edges = by_library(x, t), wedges = by_wedges(x, t);
    const Vec3 normal = (t.b - t.a).cross(t.c - t.a).normalized();
    const double height = std::abs((x - t.a).dot(normal));
    if (height < 0.05) continue;  // wedges divide by it, and cancel
    // Wedges reach to infinity: their sum cancels, and the closer x is to one of them, the more.
    double largest = 0;
    for (const CubicIntegral& part :
         {wedge(x, t.a, t.b - t.a, t.c - t.a), wedge(x, t.b, t.b - t.c, t.b - t.a)}) {
      largest = std::max({largest, part.value, part.gradient.norm()});
    }
    const double rounding = 1e-13 * (1 + largest) / height;
    EXPECT_NEAR(edges.value, wedges.value, rounding);
    EXPECT_LT((edges.gradient - wedges.gradient).norm(), 10 * rounding / height);
  }
}

TEST(LpIntegral, ByEdgesIsThatOfQuadratureOverTheTriangle) {
  std::mt19937 random(2);
  for (int i = 0; i < 60; ++i) {
    const auto [t, x] = random_case(random);
    const double near = (closest_point_on_triangle(x, t) - x).norm();
    if (near < 0.05) continue;  // quadrature over triangles gets too long
    const CubicIntegral cubic = by_library(x, t);
    for (const double p : {1.5, 2.0, 2.2, 3.0, 4.0, 6.0, 20.0}) {
      const CubicIntegral points = by_adaptive_points(x, t, p, 1e-10 * by_points(x, t, p).value);
      const Vec3 normal = (t.b - t.a).cross(t.c - t.a).normalized();
      const detail::TriangleIntegral power = detail::integrate_power(t.a - x, t.b - x, t.c - x, normal, p);
      // The error of quadrature over triangles, above all in the gradient, whose error isn't looked at.
      EXPECT_NEAR(power.value / points.value, 1, 1e-8) << p;
      EXPECT_LT((power.gradient - points.gradient).norm(), 1e-6 * points.gradient.norm()) << p;
      if (p != 3) continue;
      EXPECT_NEAR(power.value / cubic.value, 1, 1e-10);
      EXPECT_LT((power.gradient - cubic.gradient).norm(), 1e-9 * cubic.gradient.norm());
    }
  }
}

TEST(LpIntegral, InThePlaneOfATriangleItIsTheLimitFromAbove) {
  const Triangle t{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  for (const Vec3& x : {Vec3(0.6, 0.6, 0), Vec3(-0.01, 0.3, 0), Vec3(2, 0, 0), Vec3(-0.3, -0.2, 0),
                        Vec3(0.5001, 0.5001, 0), Vec3(0, 7, 0)}) {
    const CubicIntegral at = by_library(x, t);
    const CubicIntegral points = by_adaptive_points(x, t, 3, 1e-11 * by_points(x, t, 3).value);
    EXPECT_NEAR(at.value / points.value, 1, 1e-6) << "as good as twelve halvings are next to an edge";
    EXPECT_EQ(at.gradient.z(), 0);
    for (const double p : {2.5, 3.0, 5.0}) {
      const auto power = detail::integrate_power(t.a - x, t.b - x, t.c - x, Vec3::UnitZ(), p);
      const auto above = detail::integrate_power(t.a - x - Vec3(0, 0, 1e-7), t.b - x - Vec3(0, 0, 1e-7),
                                                 t.c - x - Vec3(0, 0, 1e-7), Vec3::UnitZ(), p);
      EXPECT_NEAR(above.value / power.value, 1, 1e-5) << "a height of 1e-7 beside a distance of 1e-4";
      EXPECT_LT((above.gradient - power.gradient).norm(), 1e-2 * power.gradient.norm());
      if (p == 3) {
        EXPECT_NEAR(power.value / at.value, 1, 1e-9);
      }
    }
    // Heights over which the plane's form passes to the other one.
    double before = at.value;
    for (double z = 1e-12; z < 0.1; z *= 1.5) {
      const CubicIntegral above = by_library(x + Vec3(0, 0, z), t);
      EXPECT_LT(above.value, before * (1 + 1e-11));
      EXPECT_LE(above.gradient.z(), 0);
      before = above.value;
    }
  }
}

TEST(LpIntegral, FarAwayItIsThatOfAPointAndNoDigitIsLost) {
  const Triangle t{Vec3(0.1, 0, 0.2), Vec3(1, 0.3, 0), Vec3(0, 1, -0.4)};
  const double area = 0.5 * (t.b - t.a).cross(t.c - t.a).norm();
  for (const double far : {1e4, 1e5, 1e6}) {
    const Vec3 r = far * Vec3(1, -2, 0.5).normalized();
    const CubicIntegral at = by_library((t.a + t.b + t.c) / 3 + r, t);
    // What is left out is (size / distance)^2.
    const double bound = 10 / (far * far) + 1e-13;
    EXPECT_NEAR(at.value * far * far * far / area, 1, bound);
    // The sides' parts cancel by size / distance.
    EXPECT_LT((at.gradient * std::pow(far, 4) / area + 3 * r.normalized()).norm(), bound + 1e-15 * far);
  }
}

TEST(LpIntegral, OfAClosedSurfaceSolidAnglesAreAFullSphereInsideAndNothingOutside) {
  const PolygonSoup surface = bumpy_ellipsoid(2);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  int inside = 0;
  for (int i = 0; i < 20; ++i) {
    const Vec3 x = 1.4 * Vec3(unit(random), unit(random), unit(random));
    double angle = 0;
    for (std::size_t f = 0; f < surface.n_faces(); ++f) {
      const Vec3 a = surface.positions[surface.face(f)[0]], b = surface.positions[surface.face(f)[1]],
                 c = surface.positions[surface.face(f)[2]];
      angle += (a - x).dot((b - a).cross(c - a).normalized()) * by_library(x, {a, b, c}).value;
    }
    const bool is_inside = angle > 2 * k_pi;
    inside += is_inside ? 1 : 0;
    EXPECT_NEAR(angle, is_inside ? 4 * k_pi : 0, 1e-11);
  }
  EXPECT_GT(inside, 2);
  EXPECT_LT(inside, 18);
}

TEST(LpIntegral, SliversAndTrianglesFarFromTheOriginAreWhatTheyAreElsewhere) {
  for (const double width : {1e-3, 1e-6, 1e-9}) {
    const Triangle t{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.3, width, 0)};
    const Vec3 x(0.4, 0.1, 0.2);
    // Nearly a line of a linearly growing and falling density: width (s / 0.3 or (1 - s) / 0.7) |x - y|^-3.
    double sum = 0;
    constexpr int k_steps = 20000;
    for (int i = 0; i < k_steps; ++i) {
      const double s = (i + 0.5) / k_steps;
      sum += width * std::min(s / 0.3, (1 - s) / 0.7) * std::pow((Vec3(s, 0, 0) - x).norm(), -3) / k_steps;
    }
    // The line is off by the width over the distance; the sum by 1e-8; a normal by 1e-16 over the width.
    EXPECT_NEAR(by_library(x, t).value / sum, 1, 5 * width + 1e-7) << width;
  }
}

TEST(LpIntegral, WithPOfOneASphereHasNoFieldInside) {
  double before = 0;
  for (const int levels : {3, 4}) {
    const PolygonSoup ball = sphere(levels);
    double value = 0;
    Vec3 gradient = Vec3::Zero();
    const Vec3 x(0.3, 0.4, -0.2);
    for (std::size_t f = 0; f < ball.n_faces(); ++f) {
      const Vec3 a = ball.positions[ball.face(f)[0]], b = ball.positions[ball.face(f)[1]],
                 c = ball.positions[ball.face(f)[2]];
      const auto part = detail::integrate_power(a - x, b - x, c - x, (b - a).cross(c - a).normalized(), 1);
      value += part.value;
      gradient += part.gradient;
    }
    // The polyhedron is off by the square of its edges.
    EXPECT_NEAR(value / (4 * k_pi), 1, levels == 3 ? 2e-2 : 5e-3);
    if (levels == 4) {
      EXPECT_LT(gradient.norm(), 0.3 * before);
    }
    before = gradient.norm();
  }
}

}  // namespace
}  // namespace recede
