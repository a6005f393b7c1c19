#include "trimmed_patches.h"
#include <recede/geometry/patch_surface.h>
#include <recede/lod/detail/edge_sampling.h>

#include <gtest/gtest.h>

#include <numbers>

namespace recede::detail {
namespace {

using test::parallelogram;
using test::RandomNurbs;

NurbsCurve2 straight(const Vec2& from, const Vec2& to) { return test::line(from, to).curve; }

NurbsCurve2 circle_of(const Vec2& center, double radius) {
  return test::circle(center, radius, false).curves[0].curve;
}

Vec3 point_on(const SeamCurve& use, double t) { return use.surface->shape.evaluate(evaluate(*use.curve, t)); }

double distance_to_chord(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double squared = along.squaredNorm();
  const double share = squared > 0 ? std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

// Promises of `SampledUse`: ends, order and matching lists.
void expect_well_formed(const SeamCurve& use, const SampledUse& sampled, double apart = 1e-12) {
  ASSERT_GE(sampled.parameters.size(), 2u);
  ASSERT_EQ(sampled.uvs.size(), sampled.parameters.size());
  ASSERT_EQ(sampled.widths.size() + 1, sampled.parameters.size());
  EXPECT_EQ(sampled.parameters.front(), use.runs_against ? use.range.end : use.range.begin);
  EXPECT_EQ(sampled.parameters.back(), use.runs_against ? use.range.begin : use.range.end);
  for (std::size_t i = 0; i < sampled.parameters.size(); ++i) {
    // 1e-12: uvs come from halving nets, not from the parameter; both are good to some ulps of about ten.
    // Knots that mean the same place make it more.
    EXPECT_LT((evaluate(*use.curve, sampled.parameters[i]) - sampled.uvs[i]).norm(), apart);
    if (i == 0) continue;
    const double step = sampled.parameters[i] - sampled.parameters[i - 1];
    EXPECT_GT(use.runs_against ? -step : step, 0);
  }
}

// The curve is within its strip beside the chord, and the surface along the chord near to it.
void expect_within(const SeamCurve& use, const SampledUse& sampled, double tolerance) {
  for (std::size_t i = 0; i + 1 < sampled.uvs.size(); ++i) {
    const Vec2 &a = sampled.uvs[i], &b = sampled.uvs[i + 1];
    const Vec3 from = use.surface->shape.evaluate(a), to = use.surface->shape.evaluate(b);
    EXPECT_LE(sampled.widths[i], tolerance);
    for (int k = 1; k < 8; ++k) {
      const double share = k / 8.0;
      const double t = sampled.parameters[i] + share * (sampled.parameters[i + 1] - sampled.parameters[i]);
      const Vec3 on_curve = point_on(use, t);
      EXPECT_LE(distance_to_chord(on_curve, from, to), tolerance * (1 + 1e-9));
      // From the curve to the surface along the chord of parameters.
      double nearest = INFINITY;
      constexpr int k_places = 64;
      double spacing = 0;
      Vec3 last = from;
      for (int place = 0; place <= k_places; ++place) {
        const Vec3 on_strip_end = use.surface->shape.evaluate(a + place / double{k_places} * (b - a));
        nearest = std::min(nearest, (on_curve - on_strip_end).norm());
        spacing = std::max(spacing, (on_strip_end - last).norm());
        last = on_strip_end;
      }
      // Between places of the chord nothing is looked at; 1e-14 for rounding where all is one point.
      EXPECT_LE(nearest, sampled.widths[i] + spacing + 1e-14);
      EXPECT_LE((use.surface->shape.evaluate(a + share * (b - a)) - (from + share * (to - from))).norm(),
                tolerance * (1 + 1e-9));
    }
  }
}

TEST(EdgeSampling, OfAStraightLineOnAPlaneIsItsEnds) {
  const PatchSurface plane(parallelogram({0, 0, 0}, {3, 0, 0}, {0, 2, 0}));
  const NurbsCurve2 curve = straight({0, 0.5}, {1, 0.5});
  const SeamCurve use{&plane, &curve, curve.domain(), false};
  const auto sampled = sample_edge({&use, 1}, 1e-9, 1);
  ASSERT_EQ(sampled.size(), 1u);
  EXPECT_EQ(sampled[0].parameters, (std::vector<double>{0, 1}));
  EXPECT_EQ(sampled[0].uvs, (std::vector<Vec2>{{0, 0.5}, {1, 0.5}}));
  EXPECT_EQ(sampled[0].widths, (std::vector<double>{0}));
  // As many as asked for.
  EXPECT_EQ(sample_edge({&use, 1}, 1e-9, 4)[0].parameters, (std::vector<double>{0, 0.25, 0.5, 0.75, 1}));
}

TEST(EdgeSampling, TakesTheFewestOfEqualParts) {
  const PatchSurface plane(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  // Over a step of s, y = x^2 / 100 is s^2 / 400 above its chord: one part in 0.95 of 1.1e-4 at s < 0.2045.
  const NurbsCurve2 curve{2, {0, 0, 0, 1, 1, 1}, {{0, 0}, {0.5, 0}, {1, 0.01}}, {}};
  const SeamCurve use{&plane, &curve, curve.domain(), false};
  const SampledUse sampled = sample_edge({&use, 1}, 1.1e-4, 1)[0];
  ASSERT_EQ(sampled.parameters.size(), 6u);
  for (std::size_t i = 0; i <= 5; ++i) {
    EXPECT_DOUBLE_EQ(sampled.parameters[i], static_cast<double>(i) / 5);
    // Chords are as long as a 20000th more than their share of the x axis.
    if (i == 0) continue;
    EXPECT_NEAR(sampled.widths[i - 1], 1e-4, 1e-7);
  }
  expect_well_formed(use, sampled);
}

TEST(EdgeSampling, HalvesWhereOnlyAPartOfACurveBends) {
  const PatchSurface plane(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  // Almost straight, with a sharp bend at its end.
  const NurbsCurve2 curve{
      4, {0, 0, 0, 0, 0, 1, 1, 1, 1, 1}, {{0, 0}, {0.3, 0}, {0.6, 0}, {1, 0}, {1, 0.05}}, {}};
  const SeamCurve use{&plane, &curve, curve.domain(), false};
  const SampledUse sampled = sample_edge({&use, 1}, 1e-4, 1)[0];
  expect_well_formed(use, sampled);
  expect_within(use, sampled, 1e-4);
  const double first = sampled.parameters[1], last = 1 - sampled.parameters[sampled.parameters.size() - 2];
  EXPECT_GE(first, 4 * last);
}

TEST(EdgeSampling, LeavesTheInsideWhatItNeeds) {
  // All but a 20th where the surface is flat, three fourths along the only bend, three fifths otherwise.
  EXPECT_DOUBLE_EQ(seam_error(SurfaceBend::none, 0.95, 0), 1);
  EXPECT_DOUBLE_EQ(seam_error(SurfaceBend::one_way, 0, 0.75), 1);
  EXPECT_DOUBLE_EQ(seam_error(SurfaceBend::both, 0, 0.6), 1);
  EXPECT_DOUBLE_EQ(seam_error(SurfaceBend::both, 0.35, 0.6), 1);
}

TEST(EdgeSampling, RunsAgainstTheEdgeWhereAUseDoes) {
  const PatchSurface plane(parallelogram({0, 0, 0}, {3, 0, 0}, {0, 2, 0}));
  const NurbsCurve2 along = circle_of({0.5, 0.5}, 0.25), back = reversed(along);
  const std::vector<SeamCurve> uses{{&plane, &along, along.domain(), false},
                                    {&plane, &back, back.domain(), true}};
  const auto sampled = sample_edge(uses, 1e-3, 1);
  ASSERT_EQ(sampled.size(), 2u);
  ASSERT_EQ(sampled[0].uvs.size(), sampled[1].uvs.size());
  for (std::size_t i = 0; i < sampled[0].uvs.size(); ++i) {
    EXPECT_EQ(sampled[0].parameters[i] + sampled[1].parameters[i], 4);
    EXPECT_LT((sampled[0].uvs[i] - sampled[1].uvs[i]).norm(), 1e-15);
  }
  expect_well_formed(uses[0], sampled[0]);
  expect_well_formed(uses[1], sampled[1]);
}

// A chord of n in a circle of radius r is r (1 - cos(pi / n)) away.
TEST(EdgeSampling, OfACircleHasAboutAsManyPointsAsItNeeds) {
  const PatchSurface plane(parallelogram({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
  const NurbsCurve2 curve = circle_of({0.5, 0.5}, 0.25);
  const SeamCurve use{&plane, &curve, curve.domain(), false};
  for (const double tolerance : {0.1, 1e-2, 1e-4, 1e-6}) {
    const SampledUse sampled = sample_edge({&use, 1}, tolerance, 1)[0];
    expect_well_formed(use, sampled);
    expect_within(use, sampled, tolerance);
    const double n = static_cast<double>(sampled.widths.size());
    const double needed = std::numbers::pi / std::acos(1 - tolerance);
    EXPECT_GE(n, needed);
    // Sewing's share of the tolerance makes it 1.03 times; the arc of parts of equal parameters is longest in
    // the middle of a quarter, 1.06 times; each of the four quarters has a whole number of parts.
    EXPECT_LE(n, 1.09 * needed + 4);
  }
}

TEST(EdgeSampling, StaysWithinItsToleranceOnRandomSurfaces) {
  RandomNurbs random(9);
  for (int round = 0; round < 40; ++round) {
    const PatchSurface surface(
        random.sheet(random.integer(1, 3), random.integer(1, 3), random.integer(0, 3), round % 2 == 0, 1));
    NurbsCurve2 curve = random.curve<2>(random.integer(1, 3), random.integer(0, 3), round % 3 == 0);
    const ParameterBox domain = surface.shape.domain();
    for (Vec2& point : curve.points)
      point = domain.min() + (0.25 * (point + Vec2(2, 2))).cwiseProduct(domain.sizes());
    ParameterRange range = curve.domain();
    if (round % 4 == 0) range = {range.begin + 0.2 * range.length(), range.end - 0.3 * range.length()};
    const SeamCurve use{&surface, &curve, range, round % 2 == 1};
    for (const double tolerance : {0.1, 1e-3}) {
      const SampledUse sampled = sample_edge({&use, 1}, tolerance, 1)[0];
      expect_well_formed(use, sampled);
      expect_within(use, sampled, tolerance);
    }
  }
}

TEST(EdgeSampling, HasAPointAtEachKnotOfEachUse) {
  const PatchSurface plane(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const NurbsCurve2 bent{1, {0, 0, 0.3, 1, 1}, {{0, 0}, {0.3, 0}, {1, 0}}, {}};
  const NurbsCurve2 other{1, {0, 0, 0.2, 0.7, 1, 1}, {{0, 0}, {0.2, 0}, {0.7, 0}, {1, 0}}, {}};
  const std::vector<SeamCurve> uses{{&plane, &bent, bent.domain(), false},
                                    {&plane, &other, other.domain(), true}};
  // At 0.3 of both there is one point.
  const auto sampled = sample_edge(uses, 1, 1);
  EXPECT_EQ(sampled[0].parameters.size(), 4u);
  EXPECT_EQ(sampled[0].parameters[1], 0.3);
  EXPECT_EQ(sampled[1].parameters[1], 0.7);
  EXPECT_NEAR(sampled[0].parameters[2], 0.8, 1e-15);
  EXPECT_NEAR(sampled[1].parameters[2], 0.2, 1e-15);
}

// As files have them whose curves were put together from pieces: the second knot is beside the first.
TEST(EdgeSampling, HoldsKnotsThatAreBesideOneAnother) {
  const PatchSurface plane(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  for (const double apart : {1e-15, 1e-12, 0.9e-9, 1.3e-9, 1.9e-9, 2.1e-9, 1e-8}) {
    NurbsCurve2 curve{2, {0, 0, 0, 0.5, 0.5, 0.5 + apart, 0.5 + apart, 1, 1, 1}, {}, {}};
    curve.points = {{0, 0}, {0.25, 0.2}, {0.5, 0.2}, {0.5, 0.2}, {0.5, 0.2}, {0.75, 0.2}, {1, 0}};
    const NurbsCurve2 back = reversed(curve);
    // And one with a knot in between.
    NurbsCurve2 other = curve;
    other.knots[5] = other.knots[6] = 0.5 + apart / 2;
    const std::vector<SeamCurve> uses{{&plane, &curve, curve.domain(), false},
                                      {&plane, &back, back.domain(), true},
                                      {&plane, &other, other.domain(), false}};
    for (const double tolerance : {0.5, 1e-2, 1e-4}) {
      const auto sampled = sample_edge(uses, tolerance, 1);
      for (std::size_t k = 0; k < uses.size(); ++k) {
        expect_well_formed(uses[k], sampled[k], 1e-8);
        expect_within(uses[k], sampled[k], tolerance);
      }
    }
  }
}

// A curve against the bend of a tube, and the same one drawn on the plane that touches nothing: both get the
// points that the worse of them needs.
TEST(EdgeSampling, RefinesAllUsesWhereOneNeedsIt) {
  const PatchSurface plane(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})), tube(test::quarter_tube(1, 1));
  const NurbsCurve2 curve = straight({0, 0}, {1, 0});
  const std::vector<SeamCurve> uses{{&plane, &curve, curve.domain(), false},
                                    {&tube, &curve, curve.domain(), false}};
  const auto sampled = sample_edge(uses, 1e-3, 1);
  const auto alone = sample_edge({&uses[1], 1}, 1e-3, 1);
  EXPECT_GT(sampled[0].parameters.size(), 8u);
  EXPECT_EQ(sampled[0].parameters, sampled[1].parameters);
  EXPECT_EQ(sampled[1].parameters, alone[0].parameters);
}

TEST(EdgeSampling, EndsWhereNoToleranceCanBeReached) {
  const PatchSurface tube(test::quarter_tube(1, 1));
  const NurbsCurve2 curve = straight({0, 0.2}, {1, 0.7});
  const SeamCurve use{&tube, &curve, curve.domain(), false};
  const SampledUse sampled = sample_edge({&use, 1}, 0, 1)[0];
  EXPECT_EQ(sampled.widths.size(), 65536u);
}

// A circle in a plane, and one that starts elsewhere, runs the other way and is of another speed.
TEST(MatchedEdgeSampling, BringsPointsTogetherThatAreTogetherInSpace) {
  const PatchSurface plane(parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0})),
      swapped(parallelogram({-2, -2, 0}, {0, 4, 0}, {4, 0, 0})), tube(test::quarter_tube(1, 1));
  const NurbsCurve2 circle = circle_of({0.5, 0.5}, 0.25);
  const NurbsCurve2 quarter = part(circle, {0, 1});
  const NurbsCurve2 on_tube = straight({0, 0}, {1, 0});
  // The same points on the plane with u and v swapped, as a polynomial curve with other speed.
  NurbsCurve2 other = reversed(quarter);
  for (Vec2& point : other.points) std::swap(point.x(), point.y());
  const std::vector<SeamCurve> uses{{&plane, &quarter, quarter.domain(), false},
                                    {&tube, &on_tube, on_tube.domain(), false},
                                    {&swapped, &other, other.domain(), true}};
  for (const double tolerance : {0.1, 1e-3}) {
    const auto sampled = sample_matched_edge(uses, tolerance, tolerance, 1);
    ASSERT_EQ(sampled.size(), 3u);
    for (std::size_t k = 0; k < 3; ++k) {
      expect_well_formed(uses[k], sampled[k]);
      ASSERT_EQ(sampled[k].uvs.size(), sampled[0].uvs.size());
      for (std::size_t i = 0; i < sampled[0].uvs.size(); ++i) {
        const Vec3 here = uses[k].surface->shape.evaluate(sampled[k].uvs[i]);
        const Vec3 there = uses[0].surface->shape.evaluate(sampled[0].uvs[i]);
        // Newton's method ends at rounding; four steps from a chord away are enough for that.
        EXPECT_LT((here - there).norm(), 1e-9);
      }
      // Projected points fall beside those that were sampled: pieces may be wider than each use alone.
      expect_within(uses[k], sampled[k], tolerance);
    }
    for (std::size_t i = 0; i + 1 < sampled[0].uvs.size(); ++i) {
      EXPECT_GT(
          (plane.shape.evaluate(sampled[0].uvs[i + 1]) - plane.shape.evaluate(sampled[0].uvs[i])).norm(),
          tolerance / 2);
    }
  }
}

TEST(MatchedEdgeSampling, HoldsCurvesThatTurnBackBesideOneAnother) {
  // One use goes to and fro a little on its way; the points still rise on both.
  const PatchSurface plane(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const NurbsCurve2 even = straight({0, 0}, {1, 0});
  const NurbsCurve2 uneven{
      1, {0, 0, 1, 2, 3, 4, 4}, {{0, 1e-3}, {0.5, 1e-3}, {0.48, 1e-3}, {0.7, 1e-3}, {1, 1e-3}}, {}};
  const std::vector<SeamCurve> uses{{&plane, &even, even.domain(), false},
                                    {&plane, &uneven, uneven.domain(), false}};
  const auto sampled = sample_matched_edge(uses, 1e-2, 1e-2, 4);
  expect_well_formed(uses[0], sampled[0]);
  expect_well_formed(uses[1], sampled[1]);
}

TEST(FootOn, IsTheNearestPointOfAPolyline) {
  const Polyline line{{0, 1, 3}, {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}}};
  const Foot beside = foot_on(line, {0.25, 0.5, 0});
  EXPECT_EQ(beside.distance, 0.5);
  EXPECT_EQ(beside.parameter, 0.25);
  const Foot at_corner = foot_on(line, {2, -1, 0});
  EXPECT_EQ(at_corner.distance, std::numbers::sqrt2);
  EXPECT_EQ(at_corner.parameter, 1);
  const Foot above = foot_on(line, {1, 1, 3});
  EXPECT_EQ(above.distance, 3);
  EXPECT_EQ(above.parameter, 2);
  const Foot past = foot_on(line, {1, 7, 0});
  EXPECT_EQ(past.parameter, 3);
}

TEST(NearestParameter, IsWhereACurveIsNearestAndStaysInItsRange) {
  const PatchSurface tube(test::quarter_tube(1, 1));
  const NurbsCurve2 curve = straight({0, 0.5}, {1, 0.5});
  const SeamCurve use{&tube, &curve, curve.domain(), false};
  const Vec3 at = point_on(use, 0.3);
  // A thousandth of the radius outside: each step leaves a thousandth of what was wrong.
  EXPECT_NEAR(nearest_parameter(use, 0.4, 1.001 * at - 0.001 * Vec3(0, 0, at.z())), 0.3, 1e-9);
  EXPECT_EQ(nearest_parameter(use, 0.9, {-1, 1.2, 0.5}), 1);
  const SeamCurve part_of{&tube, &curve, {0.5, 0.75}, false};
  EXPECT_EQ(nearest_parameter(part_of, 0.6, at), 0.5);
}

}  // namespace
}  // namespace recede::detail
