#include "error_text.h"
#include "lp_shapes.h"
#include <recede/shells/detail/power_triangle.h>

#include <gmock/gmock.h>
#include <oneapi/tbb/global_control.h>

#include <random>

namespace recede {
namespace {

using namespace test;
using ::testing::HasSubstr;

TEST(LpDistance, OverAPlaneTheCalibratedOneIsTheHeight) {
  constexpr double k_half = 1e6;
  const PolygonSoup plane = square(k_half);
  for (const double p : {2.5, 3.0, 4.0, 6.0, 16.0}) {
    const LpDistance distance(plane, exact(p));
    for (const double z : {0.5, 2.0}) {
      const LpValue value = distance.at(Vec3(0, 0, z));
      // Beyond the square a share of (z / half)^(p - 2) of the integral is missing, less than that in a
      // corner's favour; roots enlarge it by 1 / (p - 2). The rest is the quadrature.
      const double missing = std::pow(z / k_half, p - 2) / (p - 2) + 1e-9;
      EXPECT_NEAR(value.distance, z, missing * z) << p;
      EXPECT_NEAR(value.gradient.z(), 1, 2 * missing) << p;
      EXPECT_LT(value.gradient.head<2>().norm(), 1e-9) << p;
    }
  }
}

TEST(LpDistance, OverASquareItIsTheSolidAngleOverTheHeight) {
  const LpDistance distance(square(1), exact());
  for (const double z : {1e-6, 0.01, 0.7, 30.0, 1e4}) {
    const double angle = 4 * std::atan(1 / (z * std::sqrt(2 + z * z)));
    // The place is on the common edge of both triangles: rounding of corners is a share of the height.
    const double rounding = 1e-14 + 1e-15 / z;
    EXPECT_NEAR(distance.at(Vec3(0, 0, z)).distance / (2 * k_pi * z / angle), 1, rounding) << z;
    EXPECT_NEAR(distance.at(Vec3(0, 0, -z)).distance / (2 * k_pi * z / angle), 1, rounding) << z;
  }
}

TEST(LpDistance, BetweenTwoPlanesItSlowsDownTowardTheMiddle) {
  constexpr double a = 1, k_half = 1e6;
  PolygonSoup planes = square(k_half);
  add_sheet(planes, Vec3(-k_half, -k_half, 2 * a), Vec3(2 * k_half, 0, 0), Vec3(0, 2 * k_half, 0));
  const LpDistance distance(planes, exact());
  for (const double z : {0.1, 0.5, 0.9, 1.0, 1.3}) {
    const LpValue value = distance.at(Vec3(0, 0, z));
    EXPECT_NEAR(value.distance, z * (2 * a - z) / (2 * a), 2e-6) << "the squares end at a million";
    EXPECT_NEAR(value.gradient.z(), 1 - z / a, 4e-6);
  }
}

TEST(LpDistance, OnTheBisectorOfADihedralTheGradientIsThatOfTheTable) {
  constexpr double k_size = 1e6;
  for (const double degrees : {30.0, 60.0, 90.0, 120.0, 150.0, 180.0}) {
    const double angle = degrees * k_pi / 180;
    const LpValue value = LpDistance(dihedral(angle, k_size), exact()).at(Vec3::UnitX());
    EXPECT_NEAR(value.gradient.x(), std::sin(0.5 * angle) / (2 - angle / k_pi), 5e-6) << degrees;
    EXPECT_LT(value.gradient.tail<2>().norm(), 1e-9);
  }
  const std::vector<std::pair<double, std::array<double, 5>>> table = {
      {4, {.1846, .3660, .5412, .7071, .8609}},
      {8, {.2306, .4457, .6326, .7857, .9065}},
      {16, {.2463, .4758, .6730, .8256, .9313}},
      {64, {.2559, .4944, .6992, .8564, .9555}}};
  for (const auto& [p, lengths] : table) {
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      const double degrees = 30.0 * static_cast<double>(i + 1);
      const LpDistance distance(dihedral(degrees * k_pi / 180, k_size), exact(p));
      // The table has four digits.
      EXPECT_NEAR(distance.at(Vec3::UnitX()).gradient.norm(), lengths[i], 5.1e-5) << p << ", " << degrees;
    }
  }
}

TEST(LpDistance, OnTheDiagonalOfACornerTheGradientIsThatOfTheClosedForm) {
  constexpr double k_size = 1e6;
  PolygonSoup octant;
  for (int k = 0; k < 3; ++k)
    add_sheet(octant, Vec3::Zero(), k_size * Vec3::Unit(k), k_size * Vec3::Unit((k + 1) % 3));
  const LpValue value = LpDistance(octant, exact()).at(Vec3::Ones());
  EXPECT_NEAR(value.gradient.norm(), 4 / (7 * std::sqrt(3.0)), 5e-6);
  EXPECT_LT(angle_between(value.gradient, Vec3::Ones()), 1e-9);
}

/// Values on three finer and finer polyhedra.
struct Convergence {
  double order;  ///< of the error in the edge length
  LpValue limit;
};
Convergence converge(const Vec3& x, const LpDistanceOptions& options) {
  LpValue values[3];
  for (int k = 0; k < 3; ++k) values[k] = LpDistance(sphere(3 + k), options).at(x);
  const double first = values[1].distance - values[0].distance,
               second = values[2].distance - values[1].distance;
  Convergence result{std::log2(first / second), values[2]};
  result.limit.distance += second / 3;
  result.limit.gradient += (values[2].gradient - values[1].gradient) / 3;
  return result;
}

TEST(LpDistance, OfFinerAndFinerSpheresConvergesToTheClosedForms) {
  const Vec3 direction = Vec3(0.3, -0.8, 0.5).normalized();
  for (const double rho : {0.2, 0.6, 1.5, 4.0}) {
    const double calibrated = std::abs(1 - rho * rho) / (2 * (rho < 1 ? 1 : 1 / rho));
    const double slope = rho < 1 ? -rho : (3 * rho * rho - 1) / (2);
    const Convergence c = converge(rho * direction, exact());
    // Edges halve, errors fall to a quarter; what is left after extrapolation is of fourth order.
    EXPECT_NEAR(c.order, 2, 0.1) << rho;
    EXPECT_NEAR(c.limit.distance, calibrated, 2e-5 * calibrated) << rho;
    EXPECT_NEAR(c.limit.gradient.dot(direction), slope, 5e-5 * (1 + std::abs(slope))) << rho;

    const Convergence mean = converge(rho * direction, exact(3, LpForm::averaged));
    const double averaged = std::cbrt(std::abs(1 - rho * rho) * (rho < 1 ? 1 : rho));
    EXPECT_NEAR(mean.limit.distance, averaged, 2e-5 * averaged) << rho;
  }
  // Inside the sphere, p = 4 gives the same as p = 3.
  const Convergence fourth = converge(0.6 * direction, exact(4));
  EXPECT_NEAR(fourth.limit.distance, 0.32, 2e-5);
}

TEST(LpDistance, FarAwayTheAveragedGradientTendsToOne) {
  const std::vector<std::pair<double, double>> table = {{2, 1.1105}, {3, 1.0416}, {5, 1.0139}, {10, 1.0034}};
  for (const auto& [rho, length] : table) {
    const Convergence c = converge(Vec3(0, 0, rho), exact(3, LpForm::averaged));
    EXPECT_NEAR(c.limit.gradient.norm(), length, 6e-5) << "four digits; " << rho;
  }
}

TEST(LpDistance, GradientsAreFiniteDifferences) {
  const PolygonSoup surface = bumpy_ellipsoid(2);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const auto& [p, form] : {std::pair(3.0, LpForm::calibrated), std::pair(3.0, LpForm::averaged),
                                std::pair(2.5, LpForm::calibrated), std::pair(1.5, LpForm::averaged),
                                std::pair(2.0, LpForm::averaged), std::pair(6.0, LpForm::calibrated)}) {
    for (const LpSource source : {LpSource::triangles, LpSource::points}) {
      LpDistanceOptions options = exact(p, form);
      options.source = source;
      const LpDistance distance(surface, options);
      for (int i = 0; i < 10; ++i) {
        const Vec3 x = 1.6 * Vec3(unit(random), unit(random), unit(random));
        const LpValue value = distance.at(x);
        if (value.distance < 0.05) continue;  // where third derivatives are large
        constexpr double h = 1e-5;
        Vec3 difference;
        for (int k = 0; k < 3; ++k) {
          difference[k] =
              (distance.at(x + h * Vec3::Unit(k)).distance - distance.at(x - h * Vec3::Unit(k)).distance) /
              (2 * h);
        }
        // h^2 times third derivatives below 1 / 0.05^2, and rounding over h.
        EXPECT_LT((difference - value.gradient).norm(), 1e-6) << p << " at " << x.transpose();
      }
    }
  }
}

TEST(LpDistance, ScalesWithTheSurfaceAndMovesWithIt) {
  const PolygonSoup surface = bumpy_ellipsoid(2);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, -3).normalized()).toRotationMatrix();
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1, 1);
  struct Place {
    double scale;
    Vec3 by;
  };
  for (const Place& place : {Place{1e-9, Vec3::Zero()}, Place{1e9, Vec3::Zero()},
                             Place{1, Vec3(1e6, -1e6, 2e6)}, Place{1e9, Vec3(1e9, 0, 0)}}) {
    const PolygonSoup other = moved(surface, place.scale, turn, place.by);
    // Input positions far away are rounded by 1e-16 of their offset; next to the surface that is a share of
    // the distance.
    const double rounding = 1e-11 + 1e-14 * place.by.norm() / place.scale;
    for (const double p : {3.0, 5.0}) {
      for (const LpForm form : {LpForm::calibrated, LpForm::averaged}) {
        const LpDistance before(surface, exact(p, form)), after(other, exact(p, form));
        for (int i = 0; i < 20; ++i) {
          const Vec3 x = 1.6 * Vec3(unit(random), unit(random), unit(random));
          const LpValue a = before.at(x), b = after.at(place.scale * (turn * x) + place.by);
          EXPECT_NEAR(b.distance / place.scale / a.distance, 1, rounding / std::min(1.0, a.distance));
          EXPECT_LT((b.gradient - turn * a.gradient).norm(),
                    10 * rounding / std::min(1.0, a.distance) * a.gradient.norm());
        }
      }
    }
  }
}

TEST(LpDistance, FallsWithPAndIsAtLeastTheDistance) {
  const PolygonSoup surface = bumpy_ellipsoid(2);
  const ClosestPointTree nearest(surface.positions, triangulate(surface));
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 10; ++i) {
    const Vec3 x = 1.5 * Vec3(unit(random), unit(random), unit(random));
    const double least = std::sqrt(nearest.closest(x).squared_distance);
    double before = std::numeric_limits<double>::infinity();
    for (const double p : {1.2, 1.9, 2.0, 2.1, 3.0, 5.0, 12.0, 60.0, 300.0}) {
      const double value = LpDistance(surface, exact(p, LpForm::averaged)).at(x).distance;
      EXPECT_LT(value, before) << p;
      EXPECT_GT(value, least) << p;
      before = value;
    }
    // The integral reaches as far as the part of the surface within d (1 + 1 / p): (area / part)^(1 / p).
    EXPECT_LT(before / least, 1.1);
  }
}

/// The direction away from the surface with p = 1, which `LpDistance` refuses.
Vec3 direction_of_first_power(const PolygonSoup& surface, const Vec3& x) {
  Vec3 gradient = Vec3::Zero();
  for (std::size_t f = 0; f < surface.n_faces(); ++f) {
    const Vec3 a = surface.positions[surface.face(f)[0]], b = surface.positions[surface.face(f)[1]],
               c = surface.positions[surface.face(f)[2]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    gradient -= detail::integrate_power(a - x, b - x, c - x, normal, 1).gradient;
  }
  return gradient.normalized();
}

TEST(LpDistance, NearAWallItPointsAlongTheNormalForPAboveOne) {
  // A sphere with a round hole of half-angle 20 degrees, 76 places near the wall: with p = 1 the field leads
  // back into the wall near the hole's rim. How far from the rim the source's places are isn't known; these
  // are from half of a nineteenth of the arc on.
  const double hole = k_pi / 9;
  const PolygonSoup cup = part_of_sphere(4, [&](const Vec3& at) { return at.z() < std::cos(hole); });
  const std::vector<double> powers = {1, 1.2, 1.5, 2, 3, 4}, least = {-1, -0.1, 0.5, 0.8, 0.9, 0.95};
  double before = -1;
  for (std::size_t k = 0; k < powers.size(); ++k) {
    const double p = powers[k];
    LpDistanceOptions options{.p = std::max(p, 1.2), .form = LpForm::averaged};
    const LpDistance distance(cup, options);
    double worst = 1;
    for (const double off : {0.02, 0.05, 0.1, 0.2}) {
      for (int i = 0; i < 19; ++i) {
        const double polar = hole + (k_pi - hole) * (i + 0.5) / 19;
        const Vec3 outward(0.8 * std::sin(polar), 0.6 * std::sin(polar), std::cos(polar));
        const Vec3 x = (1 - off) * outward;
        const Vec3 g = p == 1 ? direction_of_first_power(cup, x) : distance.at(x).gradient.normalized();
        worst = std::min(worst, -g.dot(outward));
      }
    }
    EXPECT_GT(worst, least[k]) << p;
    EXPECT_GT(worst, before) << p;
    if (p == 1) {
      EXPECT_LT(worst, -0.2);
    }
    before = worst;
  }
}

TEST(LpDistance, IsSmoothAcrossTheMedialAxis) {
  // Between two planes the exact gradient jumps by 2; this one changes by the step over the half width.
  PolygonSoup planes = square(100);
  add_sheet(planes, Vec3(-100, -100, 2), Vec3(200, 0, 0), Vec3(0, 200, 0));
  const LpDistance distance(planes, exact());
  constexpr double h = 1e-3;
  const Vec3 below = distance.at(Vec3(0, 0, 1 - h)).gradient, at = distance.at(Vec3(0, 0, 1)).gradient,
             above = distance.at(Vec3(0, 0, 1 + h)).gradient;
  EXPECT_NEAR((above - below).z(), -2 * h, 0.1 * h);
  EXPECT_LT((above - 2 * at + below).norm(), h * h) << "of order h^2, where a kink gives order h";
}

TEST(LpDistance, PointsLetAPathThroughWhereTrianglesDoNot) {
  // A path that crosses a coarse sheet: with triangles the distance falls to nothing, with points it doesn't.
  const PolygonSoup sheet = square(1);
  for (const LpSource source : {LpSource::triangles, LpSource::points}) {
    LpDistanceOptions options = exact();
    options.source = source;
    const LpDistance distance(sheet, options);
    double least = std::numeric_limits<double>::infinity();
    for (int i = -100; i <= 100; ++i) least = std::min(least, distance.at(Vec3(0.2, 0, 0.01 * i)).distance);
    if (source == LpSource::triangles) {
      EXPECT_LT(least, 1e-12);
    } else {
      EXPECT_GT(least, 0.5);
    }
  }
  LpDistanceOptions points = exact();
  points.source = LpSource::points;
  // Four corners, two of them with two triangles: 4/3, 2/3, 4/3, 2/3 of the area 4.
  const double r = std::hypot(std::sqrt(2.0), 0.5);
  EXPECT_NEAR(LpDistance(sheet, points).at(Vec3(0, 0, 0.5)).distance, 2 * k_pi * r * r * r / 4, 1e-12);
  EXPECT_TRUE(std::isfinite(LpDistance(sheet, points).at(sheet.positions[0]).distance)) << "left out";
}

TEST(LpDistance, NothingBeyondTheSupportCounts) {
  PolygonSoup near = square(0.5), both_parts = near;
  add_sheet(both_parts, Vec3(0, 0, 8), Vec3(1, 0, 0), Vec3(0, 1, 0));
  for (const double p : {3.0, 4.0}) {
    LpDistanceOptions options = exact(p, LpForm::averaged);
    const Vec3 x(0.1, 0.1, 1);
    const LpValue whole = LpDistance(near, options).at(x);
    for (const double opening : {0.5, std::numeric_limits<double>::infinity()}) {
      options.support = 5;
      options.opening = opening;
      // Both parts make one node that may be summed up at half its diagonal, but not across the fading.
      const LpValue with = LpDistance(both_parts, options).at(x);
      EXPECT_NEAR(with.distance, whole.distance, 1e-13) << "kept in another frame";
      EXPECT_LT((with.gradient - whole.gradient).norm(), 1e-13);
    }
    options.support = 0.1;
    EXPECT_TRUE(std::isinf(LpDistance(near, options).at(Vec3(0, 0, 3)).distance));
    EXPECT_EQ(LpDistance(near, options).at(Vec3(0, 0, 3)).gradient, Vec3::Zero());
  }
}

TEST(LpDistance, TheSupportFadesByASmoothstepOfTheCentroidsDistance) {
  // Its radius is below an eighth of each support.
  const PolygonSoup triangle = one_triangle(Vec3(-0.04, -0.04, 0), Vec3(0.04, -0.04, 0), Vec3(0, 0.08, 0));
  const LpValue whole = LpDistance(triangle, exact()).at(Vec3(0, 0, 1));
  for (const double end : {1.0 / 1.25, 1.0 / 1.125, 1.0 / 1.0625, 1.0}) {
    LpDistanceOptions options = exact();
    options.support = end;
    // The centroid is at 1: at 5/4, 9/8 and 17/16 of the support, and at it.
    const double t = (1.25 * end - 1) / (0.25 * end), weight = t * t * (3 - 2 * t);
    const LpValue value = LpDistance(triangle, options).at(Vec3(0, 0, 1));
    if (weight < 1e-12) {
      EXPECT_GT(value.distance, 1e12);
    } else {
      EXPECT_NEAR(value.distance, whole.distance / weight, 1e-12 * value.distance);
    }
    options.form = LpForm::averaged;
    if (weight > 0.1) {
      EXPECT_NEAR(LpDistance(triangle, options).at(Vec3(0, 0, 1)).distance,
                  LpDistance(triangle, exact(3, LpForm::averaged)).at(Vec3(0, 0, 1)).distance, 1e-12)
          << "area and integral are weighted alike";
    }
  }
}

TEST(LpDistance, ALargeTriangleCountsWhereItComesNear) {
  // Of radius 2 around the origin.
  const PolygonSoup triangle = one_triangle(Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 2, 0));
  for (const double p : {3.0, 4.0}) {
    LpDistanceOptions options = exact(p);
    options.support = 0.1;
    const LpValue near_a_corner = LpDistance(triangle, options).at(Vec3(0, 1.9, 0.05));
    EXPECT_NEAR(near_a_corner.distance, LpDistance(triangle, exact(p)).at(Vec3(0, 1.9, 0.05)).distance,
                1e-13);
    EXPECT_GT(near_a_corner.gradient.z(), 0);
    EXPECT_TRUE(std::isinf(LpDistance(triangle, options).at(Vec3(0, 0, 2.2)).distance));
  }
}

TEST(LpDistance, IsNothingOnTheSurface) {
  const PolygonSoup surface = bumpy_ellipsoid(1);
  for (const double p : {3.0, 4.0}) {
    const LpDistance distance(surface, exact(p));
    for (std::size_t f = 0; f < surface.n_faces(); ++f) {
      const Vec3 a = surface.positions[surface.face(f)[0]], b = surface.positions[surface.face(f)[1]],
                 c = surface.positions[surface.face(f)[2]];
      for (const Vec3& x : {a, Vec3(0.5 * (a + b)), Vec3((a + b + c) / 3)}) {
        const LpValue value = distance.at(x);
        EXPECT_LT(value.distance, 1e-7) << "but for rounding of the place";
        EXPECT_TRUE(value.gradient.allFinite());
      }
    }
  }
}

void expect_same(const LpValue& a, const LpValue& b) {
  EXPECT_EQ(a.distance, b.distance);
  EXPECT_EQ(a.gradient, b.gradient);
}

/// Sums of the same some hundred parts in another order, each off by a few units in the last place. Gradients
/// are sums of vectors that may cancel, near the surface of longer ones than their sum.
void expect_same_up_to_rounding(const LpValue& a, const LpValue& b) {
  if (std::isinf(b.distance)) {
    EXPECT_EQ(a.distance, b.distance);
    return;
  }
  EXPECT_NEAR(a.distance, b.distance, 1e-12 * b.distance);
  EXPECT_LT((a.gradient - b.gradient).norm(), 1e-11 * (1 + b.gradient.norm()));
}

std::vector<Vec3> random_places(std::size_t n, double reach) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-reach, reach);
  std::vector<Vec3> places(n);
  for (Vec3& x : places) x = Vec3(number(random), number(random), number(random));
  return places;
}

TEST(LpDistance, ManyPointsAreAnsweredAsOneByOneWithAnyNumberOfThreads) {
  const std::vector<Vec3> points = random_places(1000, 2);
  for (const LpDistanceOptions& options :
       {LpDistanceOptions{}, LpDistanceOptions{.support = 0.8}, LpDistanceOptions{.error = 0.01},
        LpDistanceOptions{.source = LpSource::points}, LpDistanceOptions{.form = LpForm::averaged},
        LpDistanceOptions{.expansion = LpExpansion::monopole}}) {
    const LpDistance distance(bumpy_ellipsoid(3), options);
    std::vector<LpValue> before;
    for (const std::size_t threads : {1u, 4u}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const std::vector<LpValue> values = distance.at(points);
      ASSERT_EQ(values.size(), points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        expect_same_up_to_rounding(values[i], distance.at(points[i]));
        if (!before.empty()) expect_same(values[i], before[i]);
      }
      before = values;
    }
  }
}

TEST(LpDistance, OfManyPointsEachHasTheSameBitsWhateverTheOthersAre) {
  const LpDistance distance(bumpy_ellipsoid(3));
  const std::vector<Vec3> points = random_places(101, 2);
  const std::vector<LpValue> together = distance.at(points);
  std::vector<Vec3> backward(points.rbegin(), points.rend());
  const std::vector<LpValue> values = distance.at(backward);
  for (std::size_t i = 0; i < points.size(); ++i) {
    expect_same(values[points.size() - 1 - i], together[i]);
    expect_same(distance.at(std::span(points).subspan(i, 1)).front(), together[i]);
  }
  for (std::size_t n = 0; n <= 20; ++n) {
    const std::vector<LpValue> few = distance.at(std::span(points).first(n));
    ASSERT_EQ(few.size(), n);
    for (std::size_t i = 0; i < n; ++i) expect_same(few[i], together[i]);
  }
}

TEST(LpDistance, ManyPointsSeeTheSumOverAllTriangles) {
  const PolygonSoup surface = bumpy_ellipsoid(2);
  const std::vector<Vec3> points = random_places(30, 2);
  const std::vector<LpValue> values = LpDistance(surface, exact()).at(points);
  std::vector<CubicIntegral> sums(points.size(), CubicIntegral{0, Vec3::Zero()});
  for (std::size_t f = 0; f < surface.n_faces(); ++f) {
    const LpDistance triangle(
        one_triangle(surface.positions[surface.face(f)[0]], surface.positions[surface.face(f)[1]],
                     surface.positions[surface.face(f)[2]]),
        exact());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const CubicIntegral part = cubic_integral(triangle.at(points[i]));
      sums[i].value += part.value;
      sums[i].gradient += part.gradient;
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const CubicIntegral whole = cubic_integral(values[i]);
    // Each triangle has a frame of its own, so other rounding of its place; inside gradients cancel.
    EXPECT_NEAR(whole.value / sums[i].value, 1, 1e-11);
    EXPECT_LT((whole.gradient - sums[i].gradient).norm(), 1e-10 * sums[i].value * sums[i].value);
  }
}

TEST(LpDistance, ManyPointsAreAnsweredAtAnyScaleAndPlace) {
  // From 1 triangle, a root of one leaf, to 8192; sheets, edges, needles.
  std::vector<PolygonSoup> shapes = {bumpy_ellipsoid(5), sphere(2), square(1), dihedral(0.3, 1),
                                     one_triangle(Vec3::Zero(), Vec3(1, 0, 0), Vec3(0.5, 1e-7, 0))};
  for (const PolygonSoup& shape : shapes) {
    for (const auto& [scale, offset] : {std::pair(1.0, 0.0), std::pair(1e-9, 0.0), std::pair(1e9, 0.0),
                                        std::pair(1.0, 1e6), std::pair(1e9, 1e15)}) {
      PolygonSoup placed = shape;
      for (Vec3& x : placed.positions) x = scale * x + Vec3::Constant(offset);
      std::vector<Vec3> points = random_places(37, 1.5);
      for (Vec3& x : points) x = scale * x + Vec3::Constant(offset);
      // Far away, and on the surface.
      for (const double far : {1e3, 1e8, 1e30}) points.push_back(scale * far * Vec3(1, -2, 0.5));
      points.push_back(placed.positions[0]);
      points.push_back(0.5 * placed.positions[placed.face(0)[0]] + 0.5 * placed.positions[placed.face(0)[1]]);
      const std::size_t on_surface = points.size() - 2;
      const LpDistance distance(placed);
      const std::vector<LpValue> values = distance.at(points);
      for (std::size_t i = 0; i < on_surface; ++i)
        expect_same_up_to_rounding(values[i], distance.at(points[i]));
      for (std::size_t i = on_surface; i < points.size(); ++i) {
        EXPECT_LT(values[i].distance, 1e-7 * scale) << "but for rounding of the place";
        EXPECT_TRUE(values[i].gradient.allFinite());
      }
    }
  }
}

TEST(LpDistance, PolygonsCountAsTrianglesAndThoseWithoutAreaNotAtAll) {
  PolygonSoup soup = square(1);
  const LpValue before = LpDistance(soup, exact()).at(Vec3(0.3, 0.1, 0.4));
  EXPECT_NEAR(LpDistance(soup).area(), 4, 1e-14);
  soup.positions.push_back(Vec3(5, 5, 5));
  soup.positions.push_back(Vec3::Constant(1e200));  // no face has it
  soup.add_face(std::array<Index, 3>{0, 1, 1});
  soup.add_face(std::array<Index, 3>{4, 4, 4});
  const LpValue after = LpDistance(soup, exact()).at(Vec3(0.3, 0.1, 0.4));
  EXPECT_NEAR(after.distance, before.distance, 1e-14) << "another frame, so other rounding";
}

TEST(LpDistance, BadInputIsNamed) {
  const auto complaint = [](const PolygonSoup& soup, const LpDistanceOptions& options = {}) {
    return error_text([&] { LpDistance(soup, options); });
  };
  const PolygonSoup good = square(1);
  EXPECT_THAT(complaint(PolygonSoup()), HasSubstr("no area"));
  EXPECT_THAT(complaint(one_triangle(Vec3::Zero(), Vec3::UnitX(), 2 * Vec3::UnitX())), HasSubstr("no area"));
  PolygonSoup infinite = good;
  infinite.positions[1].x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(LpDistance{infinite}, InputError);
  for (const double p : {2.0, 1.0, -3.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(complaint(good, {.p = p}), HasSubstr("p must be above")) << p;
  EXPECT_THAT(complaint(good, {.p = 1, .form = LpForm::averaged}), HasSubstr("p must be above 1"));
  EXPECT_EQ(complaint(good, {.p = 1.5, .form = LpForm::averaged}), "");
  EXPECT_THAT(complaint(good, {.opening = -1}), HasSubstr("opening"));
  EXPECT_THAT(complaint(good, {.error = 0}), HasSubstr("error"));
  EXPECT_THAT(complaint(good, {.support = 0}), HasSubstr("support"));
  EXPECT_TRUE(std::isfinite(LpDistance(good).at(Vec3(1e49, 0, 0)).distance));
  EXPECT_THROW(LpDistance(good).at(Vec3(1e51, 0, 0)), InputError);
  EXPECT_THROW(LpDistance(good).at(Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0)), InputError);
  for (const double wrong :
       {1e51, -1e51, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<Vec3> points(20, Vec3::UnitZ());
    points[13].y() = wrong;
    EXPECT_THROW(LpDistance(good).at(points), InputError);
  }
  EXPECT_TRUE(LpDistance(good).at(std::span<const Vec3>()).empty());
}

}  // namespace
}  // namespace recede
