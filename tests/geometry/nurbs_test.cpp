#include "input_errors.h"
#include "nurbs_surfaces.h"
#include <recede/geometry/bezier_patches.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

using test::RandomNurbs;

// Coordinates are of the size of 1 to 10 and pass through some twenty roundings of 1.1e-16.
constexpr double k_rounding = 1e-13;

// By the recursion that defines the basis functions, with 0/0 = 0.
double basis(const std::vector<double>& knots, std::size_t i, int degree, double t) {
  if (degree == 0) return knots[i] <= t && t < knots[i + 1] ? 1 : 0;
  const auto p = static_cast<std::size_t>(degree);
  double sum = 0;
  if (knots[i + p] > knots[i])
    sum += (t - knots[i]) / (knots[i + p] - knots[i]) * basis(knots, i, degree - 1, t);
  if (knots[i + p + 1] > knots[i + 1])
    sum += (knots[i + p + 1] - t) / (knots[i + p + 1] - knots[i + 1]) * basis(knots, i + 1, degree - 1, t);
  return sum;
}

template <int Dimension>
Eigen::Matrix<double, Dimension, 1> by_definition(const NurbsCurve<Dimension>& curve, double t) {
  Eigen::Matrix<double, Dimension, 1> sum = Eigen::Matrix<double, Dimension, 1>::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const double factor =
        basis(curve.knots, i, curve.degree, t) * (curve.is_rational() ? curve.weights[i] : 1);
    sum += factor * curve.points[i];
    weights += factor;
  }
  return sum / weights;
}

Vec3 by_definition(const NurbsSurface& surface, const Vec2& uv) {
  Vec3 sum = Vec3::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < surface.n_points(0); ++i) {
    for (std::size_t j = 0; j < surface.n_points(1); ++j) {
      const std::size_t k = i * surface.n_points(1) + j;
      const double factor = basis(surface.knots[0], i, surface.degrees[0], uv.x()) *
                            basis(surface.knots[1], j, surface.degrees[1], uv.y()) *
                            (surface.is_rational() ? surface.weights[k] : 1);
      sum += factor * surface.points[k];
      weights += factor;
    }
  }
  return sum / weights;
}

TEST(NurbsCurve, OfQuartersIsACircle) {
  const NurbsCurve2 circle = test::unit_circle();
  for (double t = 0; t <= 4; t += 0.125) EXPECT_NEAR(evaluate(circle, t).norm(), 1, 1e-15) << t;
  EXPECT_EQ(evaluate(circle, 0), Vec2(1, 0));
  EXPECT_EQ(evaluate(circle, 4), Vec2(1, 0));
  EXPECT_LT((evaluate(circle, 0.5) - Vec2(1, 1).normalized()).norm(), 1e-15);
  // At the joints the speed is degree / span width * weight ratio * distance of the points.
  EXPECT_LT((derivatives(circle, 1).first - Vec2(-std::numbers::sqrt2, 0)).norm(), 1e-14);
}

TEST(NurbsCurve, IsTheSumOfItsDefinition) {
  RandomNurbs random(1);
  for (int round = 0; round < 200; ++round) {
    const NurbsCurve3 curve = random.curve<3>(random.integer(1, 6), random.integer(0, 9), round % 2 == 0);
    const double t = random.in(curve.domain());
    EXPECT_LT((evaluate(curve, t) - by_definition(curve, t)).norm(), k_rounding) << round;
  }
}

TEST(NurbsCurve, HasTheDerivativesThatDifferencesShow) {
  RandomNurbs random(2);
  constexpr double k_step = 1e-4;
  for (int round = 0; round < 100; ++round) {
    const NurbsCurve2 curve = random.curve<2>(random.integer(1, 5), 0, round % 2 == 0);
    const double t = random.in(curve.domain());
    const Vec2 before = evaluate(curve, t - k_step), here = evaluate(curve, t),
               after = evaluate(curve, t + k_step);
    const CurveDerivatives<2> result = derivatives(curve, t);
    EXPECT_EQ(result.point, here);
    // The third and fourth derivative reach some 1e3 over domains as short as 0.2; rounding is divided by the
    // step's square.
    EXPECT_LT((result.first - (after - before) / (2 * k_step)).norm(), 1e-3 * (1 + result.first.norm()))
        << round;
    EXPECT_LT((result.second - (after - 2 * here + before) / (k_step * k_step)).norm(),
              1e-2 * (1 + result.second.norm()))
        << round;
  }
}

TEST(NurbsCurve, StaysTheSameThroughKnotsPartsAndReversal) {
  RandomNurbs random(3);
  for (int round = 0; round < 100; ++round) {
    const NurbsCurve2 curve = random.curve<2>(random.integer(1, 5), random.integer(0, 6), round % 2 == 0);
    double a = random.in(curve.domain()), b = random.in(curve.domain());
    if (a > b) std::swap(a, b);
    const NurbsCurve2 finer = insert_knot(curve, a, random.integer(1, 7));
    const NurbsCurve2 piece = part(curve, {a, b}), back = reversed(curve);
    validate(finer, "finer");
    validate(piece, "piece");
    validate(back, "back");
    EXPECT_EQ(piece.domain(), (ParameterRange{a, b}));
    EXPECT_EQ(back.domain(), curve.domain());
    for (int i = 0; i < 10; ++i) {
      const double t = random.in(curve.domain());
      EXPECT_LT((evaluate(finer, t) - evaluate(curve, t)).norm(), k_rounding);
      EXPECT_LT((evaluate(back, curve.domain().begin + curve.domain().end - t) - evaluate(curve, t)).norm(),
                k_rounding);
      const double inside = random.number(a, b);
      // Short pieces divide by their length.
      EXPECT_LT((evaluate(piece, inside) - evaluate(curve, inside)).norm(), k_rounding) << a << ' ' << b;
    }
    EXPECT_LT((piece.points.front() - evaluate(curve, a)).norm(), k_rounding);
    EXPECT_LT((piece.points.back() - evaluate(curve, b)).norm(), k_rounding);
  }
}

TEST(NurbsCurve, TakesNoMoreKnotsThanItsDegree) {
  const NurbsCurve2 circle = test::unit_circle();
  EXPECT_EQ(insert_knot(circle, 1, 3).knots, circle.knots);
  EXPECT_EQ(insert_knot(circle, 0.5, 9).knots.size(), circle.knots.size() + 2);
}

TEST(NurbsSurface, OfCirclesIsABall) {
  const NurbsSurface ball = test::ball(2, {10, 20, 30});
  for (double u = 0; u <= 4; u += 0.25) {
    for (double v = 0; v <= 2; v += 0.25) {
      EXPECT_NEAR((evaluate(ball, {u, v}) - Vec3(10, 20, 30)).norm(), 2, 1e-14);
      const SurfaceDerivatives here = derivatives(ball, {u, v});
      if (v == 0 || v == 2) continue;
      EXPECT_GT(here.du.cross(here.dv).normalized().dot(here.point - Vec3(10, 20, 30)), 2 - 1e-13);
    }
  }
}

TEST(NurbsSurface, IsTheSumOfItsDefinitionAndSoAreItsBezierPatches) {
  RandomNurbs random(4);
  for (int round = 0; round < 60; ++round) {
    const NurbsSurface surface =
        random.sheet(random.integer(1, 5), random.integer(1, 5), random.integer(0, 5), round % 2 == 0, 2);
    const BezierPatches patches(surface);
    for (int i = 0; i < 10; ++i) {
      const Vec2 uv(random.in(surface.domain(0)), random.in(surface.domain(1)));
      const Vec3 expected = by_definition(surface, uv);
      EXPECT_LT((evaluate(surface, uv) - expected).norm(), k_rounding);
      EXPECT_LT((patches.evaluate(uv) - expected).norm(), k_rounding);
    }
  }
}

TEST(NurbsSurface, HasTheDerivativesThatDifferencesShow) {
  RandomNurbs random(5);
  constexpr double k_step = 1e-4;
  for (int round = 0; round < 60; ++round) {
    const NurbsSurface surface = random.sheet(random.integer(1, 4), random.integer(1, 4), 0, round % 2 == 0);
    const Vec2 uv(random.in(surface.domain(0)), random.in(surface.domain(1)));
    const auto at = [&](double u, double v) { return evaluate(surface, uv + k_step * Vec2(u, v)); };
    const SurfaceDerivatives result = derivatives(surface, uv);
    const auto expect_near = [&](const Vec3& value, const Vec3& expected) {
      // As for curves.
      EXPECT_LT((value - expected).norm(), 1e-2 * (1 + value.norm())) << round;
    };
    const double square = k_step * k_step;
    expect_near(result.du, (at(1, 0) - at(-1, 0)) / (2 * k_step));
    expect_near(result.dv, (at(0, 1) - at(0, -1)) / (2 * k_step));
    expect_near(result.duu, (at(1, 0) - 2 * at(0, 0) + at(-1, 0)) / square);
    expect_near(result.dvv, (at(0, 1) - 2 * at(0, 0) + at(0, -1)) / square);
    expect_near(result.duv, (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * square));
  }
}

TEST(NurbsSurface, StaysTheSameThroughKnotsAndParts) {
  RandomNurbs random(6);
  for (int round = 0; round < 40; ++round) {
    const NurbsSurface surface =
        random.sheet(random.integer(1, 4), random.integer(1, 4), random.integer(0, 4), round % 2 == 0, 2);
    const auto sorted = [&](std::size_t axis) {
      const double a = random.in(surface.domain(axis)), b = random.in(surface.domain(axis));
      return ParameterRange{std::min(a, b), std::max(a, b)};
    };
    const ParameterRange u = sorted(0), v = sorted(1);
    const NurbsSurface finer = insert_knot(insert_knot(surface, 0, u.begin, 2), 1, v.begin);
    const NurbsSurface piece = part(surface, u, v);
    validate(finer, "finer");
    validate(piece, "piece");
    EXPECT_EQ(piece.domain(0), u);
    EXPECT_EQ(piece.domain(1), v);
    for (int i = 0; i < 10; ++i) {
      const Vec2 uv(random.in(u), random.in(v));
      EXPECT_LT((evaluate(finer, uv) - evaluate(surface, uv)).norm(), k_rounding);
      EXPECT_LT((evaluate(piece, uv) - evaluate(surface, uv)).norm(), k_rounding);
    }
  }
}

TEST(BezierPatches, HaveTheDerivativesOfTheSurface) {
  RandomNurbs random(7);
  for (int round = 0; round < 60; ++round) {
    const NurbsSurface surface =
        random.sheet(random.integer(1, 6), random.integer(1, 6), random.integer(0, 4), round % 2 == 0);
    const BezierPatches patches(surface);
    const Vec2 uv(random.in(surface.domain(0)), random.in(surface.domain(1)));
    const SurfaceDerivatives a = derivatives(surface, uv), b = patches.derivatives(uv);
    // Second derivatives take differences of neighbours twice and divide by the square of spans down to 0.2.
    for (const auto& [x, y] :
         {std::pair(a.du, b.du), {a.dv, b.dv}, {a.duu, b.duu}, {a.duv, b.duv}, {a.dvv, b.dvv}})
      EXPECT_LT((x - y).norm(), 1e-11 * (1 + x.norm()));
  }
}

TEST(BezierPatches, OfAnUnclampedSplineCoverItsDomain) {
  RandomNurbs random(8);
  NurbsSurface surface{{3, 2}, {random.knots(3, 4, false, 1), random.knots(2, 1, false, 1)}, {}, {}};
  for (std::size_t i = 0; i < surface.n_points(0) * surface.n_points(1); ++i)
    surface.points.emplace_back(random.number(-1, 1), random.number(-1, 1), random.number(-1, 1));
  const BezierPatches patches(surface);
  EXPECT_EQ(patches.n_patches(0), 5u);
  EXPECT_EQ(patches.n_patches(1), 2u);
  EXPECT_EQ(patches.domain().min(), Vec2(surface.domain(0).begin, surface.domain(1).begin));
  EXPECT_EQ(patches.domain().max(), Vec2(surface.domain(0).end, surface.domain(1).end));
  // A corner of the first net is a corner of the surface.
  EXPECT_LT((patches.net(0, 0).front().head<3>() - evaluate(surface, patches.domain().min())).norm(),
            k_rounding);
}

TEST(BezierPatches, HaveNormalsAtPolesThatAreTheLimitFromInside) {
  const BezierPatches ball(test::ball(2));
  for (double u = 0; u <= 4; u += 0.5) {
    // The limit is taken a millionth of the domain away.
    EXPECT_LT((ball.normal({u, 0}) - Vec3(0, 0, -1)).norm(), 1e-4) << u;
    EXPECT_LT((ball.normal({u, 2}) - Vec3(0, 0, 1)).norm(), 1e-4) << u;
    EXPECT_LT((ball.normal({u, 0.7}) - ball.evaluate({u, 0.7}) / 2).norm(), 1e-12);
  }
}

TEST(Nurbs, ThatDontFitAreRefusedByName) {
  const auto refused = [](auto change, const std::string& reason) {
    NurbsCurve2 curve = test::unit_circle();
    change(curve);
    EXPECT_EQ(test::error_text([&] { validate(curve, "arc"); }), "arc: " + reason);
  };
  validate(test::unit_circle(), "circle");
  refused([](NurbsCurve2& c) { c.degree = 0; }, "the degree is 0, not between 1 and 25");
  refused([](NurbsCurve2& c) { c.knots.pop_back(); }, "11 knots don't fit to 9 points and degree 2");
  refused([](NurbsCurve2& c) { c.knots[4] = 0.5; }, "knot 4 is below the one before");
  refused([](NurbsCurve2& c) { c.knots[5] = NAN; }, "knot 5 isn't a finite number");
  refused([](NurbsCurve2& c) { c.knots[5] = 1; }, "knot 3 is there more often than the degree");
  refused([](NurbsCurve2& c) { c.points[1].x() = INFINITY; }, "control point 1 isn't finite");
  refused([](NurbsCurve2& c) { c.weights[8] = 0; }, "weight 8 isn't above 0");
  refused([](NurbsCurve2& c) { c.weights.pop_back(); }, "8 weights for 9 points");
  refused([](NurbsCurve2& c) { std::fill(c.knots.begin(), c.knots.end(), 1.0); },
          "the knots leave no domain");
  NurbsSurface surface = test::ball(1);
  surface.points.pop_back();
  EXPECT_EQ(test::error_text([&] { BezierPatches patches(surface); }),
            "surface: 44 control points where knots need 45");
}

}  // namespace
}  // namespace recede
