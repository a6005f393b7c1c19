#include "input_errors.h"
#include "nurbs_surfaces.h"
#include "trimmed_patches.h"
#include <recede/geometry/error.h>
#include <recede/geometry/nurbs_closest_point.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

using test::RandomNurbs;

// What a search may miss, of surfaces of the size of 1 to 10.
constexpr double k_missed = 1e-9;
// Of what is found: its own point at its own distance.
constexpr double k_rounding = 1e-13;

void expect_consistent(const NurbsSurface& surface, const Vec3& from, const NearestOnSurface& found) {
  EXPECT_TRUE(surface.domain(0).contains(found.uv.x()) && surface.domain(1).contains(found.uv.y()));
  EXPECT_LT((evaluate(surface, found.uv) - found.point).norm(), k_rounding * (1 + found.point.norm()));
  EXPECT_NEAR((found.point - from).norm(), found.distance, k_rounding * (1 + found.distance));
}

TEST(NurbsClosestPoint, OfAPlaneIsTheFootInsideAndOnTheBorderOutside) {
  const NurbsSurface plane = test::parallelogram({0, 0, 1}, {4, 0, 0}, {0, 2, 0});
  const auto expect_foot = [&](const Vec3& from, const Vec3& foot, const Vec2& uv) {
    const NearestOnSurface found = closest_point(plane, from);
    EXPECT_LT((found.point - foot).norm(), k_rounding) << from.transpose();
    EXPECT_LT((found.uv - uv).norm(), k_rounding) << from.transpose();
    EXPECT_NEAR(found.distance, (from - foot).norm(), k_rounding) << from.transpose();
  };
  expect_foot({1, 1, 6}, {1, 1, 1}, {0.25, 0.5});
  expect_foot({3, 0.5, -2}, {3, 0.5, 1}, {0.75, 0.25});
  expect_foot({-3, 1, 5}, {0, 1, 1}, {0, 0.5});
  expect_foot({5, 3, 1}, {4, 2, 1}, {1, 1});
  expect_foot({2, -7, 1}, {2, 0, 1}, {0.5, 0});
}

TEST(NurbsClosestPoint, OfABallAndATubeIsAlongTheirRadii) {
  const NurbsSurface ball = test::ball(2, {10, 20, 30});
  RandomNurbs random(1);
  for (int round = 0; round < 200; ++round) {
    const Vec3 direction =
        Vec3(random.number(-1, 1), random.number(-1, 1), random.number(-1, 1)).normalized();
    const double radius = random.number(0.01, 9);
    const NearestOnSurface found = closest_point(ball, Vec3(10, 20, 30) + radius * direction);
    EXPECT_NEAR(found.distance, std::abs(radius - 2), k_missed) << round;
    // Of equal distance within rounding of squares.
    EXPECT_LT((found.point - Vec3(10, 20, 30) - 2 * direction).norm(), 1e-6) << round;
  }
  const NurbsSurface tube = test::quarter_tube(3, 5);
  const NearestOnSurface beside = closest_point(tube, {5 * 0.6, 5 * 0.8, 2});
  EXPECT_LT((beside.point - Vec3(3 * 0.6, 3 * 0.8, 2)).norm(), 1e-9);
  EXPECT_NEAR(beside.distance, 2, k_rounding);
  EXPECT_NEAR(beside.uv.y(), 0.4, 1e-9);
  // Behind the quarter its straight sides are nearest; above it the upper arc.
  EXPECT_LT((closest_point(tube, {1, -4, 2}).point - Vec3(3, 0, 2)).norm(), 1e-9);
  EXPECT_LT((closest_point(tube, {1.2, 1.6, 9}).point - Vec3(1.8, 2.4, 5)).norm(), 1e-9);
}

TEST(NurbsClosestPoint, FromTheMiddleOfABallOrOnTheAxisOfATubeIsAnyOfManyAlwaysTheSame) {
  const NurbsSurface ball = test::ball(2);
  const NearestOnSurface any = closest_point(ball, Vec3::Zero());
  EXPECT_NEAR(any.distance, 2, k_rounding);
  expect_consistent(ball, Vec3::Zero(), any);
  EXPECT_EQ(closest_point(ball, Vec3::Zero()).uv, any.uv);
  const NurbsSurface tube = test::quarter_tube(3, 5);
  const NearestOnSurface around = closest_point(tube, {0, 0, 2});
  EXPECT_NEAR(around.distance, 3, k_rounding);
  EXPECT_NEAR(around.point.z(), 2, 1e-5);
  // Two ends of a bent strip, as far to the left as to the right.
  const NurbsCurve2 arch{2, {0, 0, 0, 1, 1, 1}, {{-1, 0}, {0, 3}, {1, 0}}, {}};
  const auto end = closest_point(arch, Vec2(0, -1));
  EXPECT_NEAR(end.distance, std::sqrt(2.0), k_rounding);
  EXPECT_TRUE(end.parameter == 0 || end.parameter == 1);
}

TEST(NurbsClosestPoint, OfAPointOnTheSurfaceIsThePointItself) {
  RandomNurbs random(2);
  for (int round = 0; round < 60; ++round) {
    const NurbsSurface surface =
        random.sheet(random.integer(1, 5), random.integer(1, 5), random.integer(0, 5), round % 2 == 0, 2);
    const Vec2 uv(random.in(surface.domain(0)), random.in(surface.domain(1)));
    const Vec3 point = evaluate(surface, uv);
    const NearestOnSurface found = closest_point(surface, point);
    EXPECT_LT(found.distance, k_missed) << round;
    EXPECT_LT((found.point - point).norm(), k_missed) << round;
  }
}

TEST(NurbsClosestPoint, AtPolesIsThePole) {
  const NurbsSurface ball = test::ball(2);
  for (const double side : {-1.0, 1.0}) {
    for (const double height : {0.5, 2.0, 7.0}) {
      const NearestOnSurface found = closest_point(ball, {0, 0, side * height});
      EXPECT_NEAR(found.distance, std::abs(height - 2), k_missed);
      EXPECT_LT((found.point - Vec3(0, 0, 2 * side)).norm(), 1e-5);
    }
    // Close beside it, where a derivative is nearly nothing.
    const Vec3 beside = Vec3(1e-5, 2e-5, 2 * side).normalized();
    EXPECT_LT((closest_point(ball, 3 * beside).point - 2 * beside).norm(), 1e-6);
  }
}

// The nearest of many places, and how far from it another one may be nearer.
struct Sampled {
  double distance;
  double spacing;
};

Sampled nearest_sample(const NurbsSurface& surface, const Vec3& from, const ParameterBox& part) {
  constexpr int n = 60;
  const BezierPatches patches(surface);
  std::vector<Vec3> points;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const Vec2 share(i / static_cast<double>(n), j / static_cast<double>(n));
      points.push_back(patches.evaluate(part.min() + share.cwiseProduct(part.sizes())));
    }
  }
  Sampled result{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t k = 0; k < points.size(); ++k) {
    result.distance = std::min(result.distance, (points[k] - from).norm());
    if (k % (n + 1) > 0) result.spacing = std::max(result.spacing, (points[k] - points[k - 1]).norm());
    if (k > n) result.spacing = std::max(result.spacing, (points[k] - points[k - n - 1]).norm());
  }
  return result;
}

TEST(NurbsClosestPoint, IsNeverFartherThanTheNearestOfManySamples) {
  RandomNurbs random(3);
  for (int round = 0; round < 150; ++round) {
    const NurbsSurface surface =
        random.sheet(random.integer(1, 5), random.integer(1, 5), random.integer(0, 6), round % 2 == 0, 2);
    const NearestOnSurfaceSearch search(surface);
    const Vec2 begin(surface.domain(0).begin, surface.domain(1).begin);
    const Vec2 end(surface.domain(0).end, surface.domain(1).end);
    for (int query = 0; query < 4; ++query) {
      const Vec3 from(random.number(-2, 8), random.number(-2, 8), random.number(-2, 2));
      const NearestOnSurface found = search.closest(from);
      expect_consistent(surface, from, found);
      const Sampled sampled = nearest_sample(surface, from, ParameterBox(begin, end));
      EXPECT_LE(found.distance, sampled.distance + k_missed) << round;
      EXPECT_GE(found.distance, sampled.distance - 2 * sampled.spacing) << round;
    }
  }
}

TEST(NurbsClosestPoint, OfAPartStaysWithinIt) {
  RandomNurbs random(4);
  for (int round = 0; round < 100; ++round) {
    const NurbsSurface surface =
        random.sheet(random.integer(1, 4), random.integer(1, 4), random.integer(0, 4), round % 2 == 0);
    ParameterBox part;
    for (int i = 0; i < 2; ++i) part.extend(Vec2(random.in(surface.domain(0)), random.in(surface.domain(1))));
    const Vec3 from(random.number(-2, 6), random.number(-2, 6), random.number(-2, 2));
    const NearestOnSurface found = closest_point(surface, from, part);
    expect_consistent(surface, from, found);
    EXPECT_TRUE((found.uv.array() >= part.min().array()).all()) << round;
    EXPECT_TRUE((found.uv.array() <= part.max().array()).all()) << round;
    const Sampled sampled = nearest_sample(surface, from, part);
    EXPECT_LE(found.distance, sampled.distance + k_missed) << round;
    EXPECT_GE(found.distance, sampled.distance - 2 * sampled.spacing) << round;
    // The same as of the surface that ends there.
    const NurbsSurface cut =
        recede::part(surface, {part.min().x(), part.max().x()}, {part.min().y(), part.max().y()});
    EXPECT_NEAR(found.distance, closest_point(cut, from).distance, k_missed) << round;
  }
}

TEST(NurbsClosestPoint, OfAPartWithoutWidthIsThatOfACurveAndOfOneWithoutSizeAPoint) {
  const NurbsSurface tube = test::quarter_tube(3, 5);
  const Vec3 from(4, 1, 2);
  const NearestOnSurface on_line = closest_point(tube, from, ParameterBox(Vec2(1, 0), Vec2(1, 1)));
  EXPECT_LT((on_line.point - Vec3(0, 3, 2)).norm(), 1e-9);
  EXPECT_EQ(on_line.uv.x(), 1);
  const NearestOnSurface at = closest_point(tube, from, ParameterBox(Vec2(0, 0.5), Vec2(0, 0.5)));
  EXPECT_LT((at.point - Vec3(3, 0, 2.5)).norm(), k_rounding);
  EXPECT_EQ(at.uv, Vec2(0, 0.5));
}

TEST(NurbsClosestPoint, OfCurvesIsNeverFartherThanTheNearestOfManySamples) {
  RandomNurbs random(5);
  for (int round = 0; round < 300; ++round) {
    const NurbsCurve3 curve = random.curve<3>(random.integer(1, 7), random.integer(0, 9), round % 2 == 0);
    double a = random.in(curve.domain()), b = random.in(curve.domain());
    if (a > b) std::swap(a, b);
    const bool is_whole = round % 3 == 0;
    const ParameterRange range = is_whole ? curve.domain() : ParameterRange{a, b};
    const Vec3 from(random.number(-3, 3), random.number(-3, 3), random.number(-3, 3));
    const auto found = is_whole ? closest_point(curve, from) : closest_point(curve, from, range);
    EXPECT_TRUE(range.contains(found.parameter));
    EXPECT_LT((evaluate(curve, found.parameter) - found.point).norm(), 1e-12);
    EXPECT_NEAR((found.point - from).norm(), found.distance, k_rounding * (1 + found.distance));
    double sampled = std::numeric_limits<double>::infinity(), spacing = 0;
    Vec3 before = evaluate(curve, range.begin);
    for (int i = 0; i <= 4000; ++i) {
      const Vec3 here = evaluate(curve, std::min(range.begin + i / 4000.0 * range.length(), range.end));
      sampled = std::min(sampled, (here - from).norm());
      spacing = std::max(spacing, (here - before).norm());
      before = here;
    }
    EXPECT_LE(found.distance, sampled + k_missed) << round;
    EXPECT_GE(found.distance, sampled - spacing) << round;
  }
}

TEST(NurbsClosestPoint, OfACircleIsAlongTheRadius) {
  const NurbsCurve2 circle = test::unit_circle();
  for (double angle = 0.1; angle < 6.2; angle += 0.3) {
    const Vec2 direction(std::cos(angle), std::sin(angle));
    for (const double radius : {0.2, 0.9, 1.0, 4.0}) {
      const auto found = closest_point(circle, Vec2(radius * direction));
      EXPECT_NEAR(found.distance, std::abs(radius - 1), k_missed);
      EXPECT_LT((found.point - direction).norm(), 1e-7);
    }
  }
}

TEST(NurbsClosestPoint, WorksInAnyUnitsAndFarFromTheOrigin) {
  for (const double scale : {1e-9, 1e-3, 1e3, 1e9}) {
    for (const double away : {0.0, 1e4}) {
      const Vec3 center = scale * away * Vec3(1, -1, 2);
      const NurbsSurface ball = test::ball(2 * scale, center);
      const NearestOnSurface found = closest_point(ball, center + scale * Vec3(0.6, 2.4, 3.2));
      // Coordinates 1e4 of the radius take four digits.
      EXPECT_NEAR(found.distance / scale, Vec3(0.6, 2.4, 3.2).norm() - 2, 1e-9);
    }
  }
  // From afar only rounding of the distance is left.
  const NearestOnSurface far = closest_point(test::ball(2), Vec3(0.6e9, 0, 0.8e9));
  EXPECT_NEAR(far.distance, 1e9 - 2, 1e-3);
}

TEST(NurbsClosestPoint, RefusesPointsThatAreNoneAndPartsOutside) {
  const NurbsSurface ball = test::ball(2);
  EXPECT_THROW(closest_point(ball, Vec3(NAN, 0, 0)), OptionError);
  EXPECT_THROW(closest_point(ball, Vec3::Zero(), ParameterBox(Vec2(5, 0), Vec2(6, 1))), OptionError);
  EXPECT_THROW(closest_point(ball, Vec3::Zero(), ParameterBox(Vec2(NAN, 0), Vec2(1, 1))), OptionError);
  EXPECT_THROW(closest_point(ball, Vec3::Zero(), ParameterBox(Vec2(1, 1), Vec2(0, 0))), OptionError);
  EXPECT_THROW(closest_point(test::unit_circle(), Vec2(0, 0), ParameterRange{5, 6}), OptionError);
  NurbsSurface broken = ball;
  broken.points.pop_back();
  EXPECT_THROW(closest_point(broken, Vec3::Zero()), InputError);
}

}  // namespace
}  // namespace recede
