#include "simple_soups.h"
#include <recede/geometry/alpha_wrap.h>
#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/sample_models.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace recede {
namespace {

double volume_of(const PolygonSoup& soup) {
  const std::vector<Index> triangles = triangulate(soup);
  double volume = 0;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    volume += soup.positions[triangles[t]].dot(
                  soup.positions[triangles[t + 1]].cross(soup.positions[triangles[t + 2]])) /
              6;
  }
  return volume;
}

void expect_closed(const PolygonSoup& soup) {
  const MeshFromSoup mesh = repair_to_polygon_mesh(soup);
  EXPECT_EQ(mesh.report.total_changed(), 0u) << "nothing is to be repaired";
  for (const auto edge : mesh.mesh.edges()) EXPECT_FALSE(mesh.mesh.is_boundary(edge));
}

TEST(AlphaWrap, EnclosesABallWithHoles) {
  if (!can_alpha_wrap()) GTEST_SKIP() << "built without CGAL's GPL parts";
  PolygonSoup ball = make_displaced_sphere(1000, true), open;
  open.positions = ball.positions;
  for (std::size_t f = 0; f < ball.n_faces(); ++f) {
    if (f % 10 != 0) open.add_face(ball.face(f));
  }
  constexpr double k_alpha = 0.3, k_offset = 0.02;
  for (const double scale : {1.0, 1e-9, 1e9}) {
    PolygonSoup scaled = open;
    for (Vec3& p : scaled.positions) p *= scale;
    const PolygonSoup wrap = alpha_wrap(scaled, {.alpha = k_alpha * scale, .offset = k_offset * scale});
    expect_closed(wrap);
    // Larger than the ball, but by little more than the offset: it didn't go in through the holes. Its own
    // triangles cut corners.
    const double volume = volume_of(wrap) / std::pow(scale, 3), of_ball = volume_of(ball);
    EXPECT_GT(volume, of_ball);
    EXPECT_LT(volume, of_ball * std::pow(1 + 2 * k_offset, 3));
    const ClosestPointTree tree(wrap.positions, wrap.corner_vertices);
    // Strictly inside, which is all that the wrap promises: 1e-4 is far above rounding.
    for (const Vec3& p : scaled.positions) {
      const ClosestPointTree::Hit hit = tree.closest(p);
      EXPECT_GT(std::sqrt(hit.squared_distance), 1e-4 * k_offset * scale);
      EXPECT_LT((p - hit.point).dot(vector_area(wrap, hit.triangle)), 0);
    }
  }
}

TEST(AlphaWrap, OfASheetIsABodyAroundIt) {
  if (!can_alpha_wrap()) GTEST_SKIP() << "built without CGAL's GPL parts";
  const PolygonSoup wrap = alpha_wrap(test::grid(4), {.alpha = 0.2, .offset = 0.01});
  expect_closed(wrap);
  // Of a square of side 1, one offset on either side and around it; half of that and twice as much for what
  // triangles of this size leave.
  EXPECT_GT(volume_of(wrap), 0.5 * 0.02);
  EXPECT_LT(volume_of(wrap), 2 * 0.02 * 1.02 * 1.02);
}

TEST(AlphaWrap, RefusesWhatHasNoMeaning) {
  const PolygonSoup sheet = test::grid(2);
  if (!can_alpha_wrap()) {
    EXPECT_THROW(alpha_wrap(sheet, {.alpha = 0.1}), OptionError);
    return;
  }
  for (const double alpha : {0.0, -1.0, 1e-6, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(alpha_wrap(sheet, {.alpha = alpha}), OptionError) << alpha;
  EXPECT_THROW(alpha_wrap(sheet, {.alpha = 0.1, .offset = -1}), OptionError);
  EXPECT_THROW(alpha_wrap({}, {.alpha = 0.1}), InputError);
  const PolygonSoup line = test::soup_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}});
  EXPECT_THROW(alpha_wrap(line, {.alpha = 0.1}), InputError);
  PolygonSoup broken = sheet;
  broken.positions[0].x() = std::nan("");
  EXPECT_THROW(alpha_wrap(broken, {.alpha = 0.1}), InputError);
}

}  // namespace
}  // namespace recede
