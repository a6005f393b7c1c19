#include "meshes.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/simplify.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

void append(PolygonSoup& to, const PolygonSoup& what, const Vec3& offset, double size = 1) {
  const auto base = static_cast<Index>(to.positions.size());
  for (const Vec3& p : what.positions) to.positions.push_back(offset + size * p);
  for (std::size_t f = 0; f < what.n_faces(); ++f) {
    std::vector<Index> face;
    for (const Index v : what.face(f)) face.push_back(base + v);
    to.add_face(face);
  }
}

PolygonSoup cube() {
  return test::soup_of(
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}, {{0, 2, 1},
                                                                                                 {0, 3, 2},
                                                                                                 {4, 5, 6},
                                                                                                 {4, 6, 7},
                                                                                                 {0, 1, 5},
                                                                                                 {0, 5, 4},
                                                                                                 {1, 2, 6},
                                                                                                 {1, 6, 5},
                                                                                                 {2, 3, 7},
                                                                                                 {2, 7, 6},
                                                                                                 {3, 0, 4},
                                                                                                 {3, 4, 7}});
}

//   ________ z = 0.1, half as wide
// ________________ z = 0
PolygonSoup two_sheets() {
  PolygonSoup soup;
  append(soup, test::grid(8, true), Vec3::Zero());
  append(soup, test::grid(8, true), Vec3(0.25, 0.25, 0.1), 0.5);
  return soup;
}

SimplifyOptions dropping(const SimplifyTarget& target) {
  SimplifyOptions options;
  options.target = target;
  options.drop_parts = true;
  return options;
}

TEST(DropParts, APartGoesOnceTheLimitAllowsItsDistanceFromTheRest) {
  const SimplifySoupResult near = simplify(two_sheets(), dropping({.error = 0.09}));
  EXPECT_EQ(near.dropped_parts, 0u);
  EXPECT_EQ(near.faces_after, 4u);
  const SimplifySoupResult far = simplify(two_sheets(), dropping({.error = 0.11}));
  EXPECT_EQ(far.dropped_parts, 1u);
  EXPECT_EQ(far.faces_after, 2u);
  EXPECT_NEAR(*far.error_bound, 0.1, 0.006) << "the proof's tolerance";
  EXPECT_GE(*far.error_bound, 0.1 - 1e-12);
  for (const Vec3& p : far.soup.positions) EXPECT_NEAR(p.z(), 0, 1e-12) << "the larger sheet stays";
}

TEST(DropParts, NothingIsDroppedUnasked) {
  SimplifyOptions options;
  options.target.faces = 1;
  const SimplifySoupResult result = simplify(two_sheets(), options);
  EXPECT_EQ(result.dropped_parts, 0u);
  EXPECT_EQ(result.stop_reason, StopReason::no_collapse_left);
  EXPECT_EQ(summarize(test::mesh_of(result.soup)).components, 2u);
}

TEST(DropParts, LooseCubesReachTheirTargetAndSayWhatIsGone) {
  PolygonSoup soup;
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j < 10; ++j) {
      for (int k = 0; k < 10; ++k) append(soup, cube(), Vec3(2 * i, 2 * j, 2 * k));
    }
  }
  ASSERT_EQ(soup.n_faces(), 18000u);
  for (const CostPolicy cost : {CostPolicy::volume, CostPolicy::normal_deviation}) {
    SimplifyOptions options = dropping({.faces = 1800});
    options.cost = cost;
    const SimplifySoupResult result = simplify(soup, options);
    EXPECT_EQ(result.stop_reason, StopReason::face_target);
    EXPECT_LE(result.faces_after, 1800u);
    EXPECT_GT(result.faces_after, 1500u);
    EXPECT_EQ(result.faces_before, result.faces_after + result.removed_faces + result.dropped_faces);
    EXPECT_EQ(result.soup.n_faces(), result.faces_after);
    EXPECT_EQ(result.soup.positions.size(), result.vertices_after);
    // Every cube that is gone has one that stays beside it: no farther than two steps and a diagonal.
    EXPECT_LT(*result.error_bound, 2 * 2 + std::sqrt(3.0));
    const MeshDistance distance = measure_distance(soup, result.soup, {.bound_tolerance = 0.05});
    EXPECT_LE(distance.max_lower, *result.error_bound);
  }
}

TEST(DropParts, BoltsGoBeforeTheHousing) {
  PolygonSoup soup = make_displaced_sphere(8000, true);
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.1 * i;
    append(soup, cube(), 1.1 * Vec3(std::cos(angle), std::sin(angle), 0), 0.01);
  }
  const SimplifySoupResult result = simplify(soup, dropping({.ratio = 0.01}));
  // Those on which others relied stay for another round.
  EXPECT_GT(result.dropped_parts, 40u);
  EXPECT_EQ(result.stop_reason, StopReason::face_target);
  EXPECT_LE(measure_distance(soup, result.soup).max, *result.error_bound);
  SimplifyOptions keeping;
  keeping.target.ratio = 0.01;
  keeping.prove_error = false;
  // Sixty tetrahedra are more than the target: the ball itself is eaten away.
  EXPECT_GT(measure_distance(soup, simplify(soup, keeping).soup).rms,
            measure_distance(soup, result.soup).rms);
}

// |~~~~~~~| |~~~~~~~|  with a gap of 0.01
PolygonSoup two_tiles() {
  PolygonSoup soup;
  append(soup, test::grid(10, true), Vec3::Zero());
  append(soup, test::grid(10, true), Vec3(1.01, 0, 0));
  for (Vec3& p : soup.positions) p.z() = 0.1 * std::sin(5 * p.x()) * std::sin(5 * p.y());
  return soup;
}

TEST(JoinParts, BordersThatMeetGrowTogether) {
  SimplifyOptions options;
  options.target.faces = 20;
  options.join_distance = 0.02;
  const SimplifySoupResult joined = simplify(two_tiles(), options);
  EXPECT_GT(joined.joined, 1u);
  const MeshSummary summary = summarize(test::mesh_of(joined.soup));
  EXPECT_EQ(summary.components, 1u);
  EXPECT_EQ(summary.border_loops, 1u);
  test::expect_sound(test::mesh_of(joined.soup));
  options.join_distance = 0;
  EXPECT_EQ(summarize(test::mesh_of(simplify(two_tiles(), options).soup)).components, 2u);
}

TEST(JoinParts, GapsThatAreWiderThanTheErrorStay) {
  SimplifyOptions options;
  options.join_distance = 0.02;
  options.target.error = 0.001;
  const SimplifySoupResult apart = simplify(two_tiles(), options);
  EXPECT_EQ(apart.joined, 0u);
  EXPECT_LE(*apart.error_bound, 0.001);
  options.target.error = 0.02;
  const SimplifySoupResult together = simplify(two_tiles(), options);
  EXPECT_GT(together.joined, 0u);
  EXPECT_LE(*together.error_bound, 0.02);
}

TEST(JoinParts, SolidsTouchAtPointsAndLinesAndStaySound) {
  PolygonSoup soup;
  for (int i = 0; i < 20; ++i) append(soup, cube(), Vec3(1.05 * i, 0, 0));
  SimplifyOptions options;
  options.target.faces = 100;
  options.join_distance = 0.1;
  const SimplifySoupResult result = simplify(soup, options);
  EXPECT_GT(result.joined, 0u);
  test::expect_sound(test::mesh_of(result.soup), 4);
  EXPECT_LE(measure_distance(soup, result.soup).max, *result.error_bound);
}

TEST(JoinParts, OnlyTheVolumeCostKnowsThem) {
  SimplifyOptions options;
  options.cost = CostPolicy::normal_deviation;
  options.join_distance = 0.1;
  EXPECT_THROW(simplify(two_tiles(), options), OptionError);
  options.cost = CostPolicy::volume;
  options.join_distance = -1;
  EXPECT_THROW(simplify(two_tiles(), options), OptionError);
}

}  // namespace
}  // namespace recede
