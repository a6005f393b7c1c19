#include "control_meshes.h"
#include "subdivided.h"
#include <recede/geometry/error.h>

#include <algorithm>
#include <cmath>

namespace recede {
namespace {

using test::control_cube;
using test::control_icosahedron;
using test::k_rounding;
using test::nearest_point;
using test::soup_of;
using test::with_level;

std::size_t n_coarse(const LevelInterpolation& interpolation) {
  std::size_t n = 0;
  for (std::size_t k = 0; k < interpolation.n_points(); ++k)
    if (interpolation.is_coarse(k)) ++n;
  return n;
}

// How far the points of the level are at most from where they would stand between those of the coarser one.
double largest_deviation(const PolygonSoup& soup, const LevelInterpolation& interpolation) {
  double largest = 0;
  for (std::size_t k = 0; k < interpolation.n_points(); ++k) {
    Vec3 mean = Vec3::Zero();
    for (std::size_t i = interpolation.starts[k]; i < interpolation.starts[k + 1]; ++i)
      mean += interpolation.weights[i] * soup.positions[interpolation.points[i]];
    largest = std::max(largest, (mean - soup.positions[k]).norm());
  }
  return largest;
}

TEST(LevelInterpolation, ALoneQuadIsBilinearFromAnyLevel) {
  // No plane; all of its rules are means of edges and faces.
  const PolygonSoup quad = soup_of({{0, 0, 0}, {2, 0, 1}, {3, 2, 0}, {0, 1, 1}}, {{0, 1, 2, 3}});
  for (int level = 0; level <= 4; ++level) {
    const PolygonSoup soup = subdivide(quad, with_level(level)).soup;
    for (int coarse = 0; coarse <= level; ++coarse) {
      const LevelInterpolation interpolation = interpolate_level(quad, with_level(level), coarse);
      ASSERT_EQ(interpolation.n_points(), soup.positions.size());
      const std::size_t side = (std::size_t{1} << coarse) + 1;
      EXPECT_EQ(n_coarse(interpolation), side * side);
      EXPECT_LT(largest_deviation(soup, interpolation), k_rounding) << level << " from " << coarse;
    }
  }
}

TEST(LevelInterpolation, ALoneTriangleIsLinearFromAnyLevel) {
  const PolygonSoup triangle = soup_of({{0, 0, 0}, {2, 0, 1}, {0, 1, 1}}, {{0, 1, 2}});
  for (int level = 0; level <= 4; ++level) {
    const SubdivisionOptions options = with_level(level, SubdivisionScheme::loop);
    // Borders are splines, so that the limit isn't flat; where all points of the level are coarse, it counts.
    const PolygonSoup soup = subdivide(triangle, options).soup;
    for (int coarse = 0; coarse <= level; ++coarse) {
      const LevelInterpolation interpolation = interpolate_level(triangle, options, coarse);
      ASSERT_EQ(interpolation.n_points(), soup.positions.size());
      const std::size_t side = (std::size_t{1} << coarse) + 1;
      EXPECT_EQ(n_coarse(interpolation), side * (side + 1) / 2);
      EXPECT_LT(largest_deviation(soup, interpolation), coarse == level ? k_rounding : 1.0);
    }
  }
}

TEST(LevelInterpolation, OfTheCoarserLevelAreItsPointsAndNoOthers) {
  const PolygonSoup house = soup_of({{0, 0, 0},
                                     {2, 0, 0},
                                     {2, 1, 0},
                                     {1, 2, 0},
                                     {0, 1, 0},
                                     {0, 0, 1},
                                     {2, 0, 1},
                                     {2, 1, 1},
                                     {1, 2, 1},
                                     {0, 1, 1}},
                                    {{4, 3, 2, 1, 0},
                                     {5, 6, 7, 8, 9},
                                     {0, 1, 6, 5},
                                     {1, 2, 7, 6},
                                     {2, 3, 8, 7},
                                     {3, 4, 9, 8},
                                     {4, 0, 5, 9}});
  struct Case {
    PolygonSoup control;
    SubdivisionScheme scheme;
  };
  for (const Case& c :
       {Case{control_cube(), SubdivisionScheme::catmull_clark}, Case{house, SubdivisionScheme::catmull_clark},
        Case{control_icosahedron(), SubdivisionScheme::loop}}) {
    const PolygonSoup fine = subdivide(c.control, with_level(3, c.scheme)).soup;
    for (int coarse = 0; coarse <= 3; ++coarse) {
      const PolygonSoup points = subdivide(c.control, with_level(coarse, c.scheme)).soup;
      const LevelInterpolation interpolation = interpolate_level(c.control, with_level(3, c.scheme), coarse);
      EXPECT_EQ(n_coarse(interpolation), points.positions.size());
      for (std::size_t k = 0; k < interpolation.n_points(); ++k) {
        double sum = 0;
        for (std::size_t i = interpolation.starts[k]; i < interpolation.starts[k + 1]; ++i) {
          EXPECT_TRUE(interpolation.is_coarse(interpolation.points[i]));
          EXPECT_GT(interpolation.weights[i], 0);
          sum += interpolation.weights[i];
        }
        EXPECT_NEAR(sum, 1, 1e-15 * 2) << "a fifth isn't dyadic";
        if (!interpolation.is_coarse(k)) continue;
        EXPECT_EQ(interpolation.points[interpolation.starts[k]], k);
        const Vec3& near = points.positions[nearest_point(points.positions, fine.positions[k])];
        EXPECT_LT((near - fine.positions[k]).norm(), k_rounding);
      }
    }
  }
}

TEST(LevelInterpolation, OfAnEdgeKnowsItsEndsOnly) {
  const LevelInterpolation interpolation = interpolate_level(control_cube(), with_level(3), 1);
  // 8 vertices and 7 points on each of 12 edges, of which the middles are points of level 1.
  for (std::size_t k = 8; k < 8 + 7 * 12; ++k) {
    const std::size_t step = (k - 8) % 7;
    EXPECT_EQ(interpolation.starts[k + 1] - interpolation.starts[k], step == 3 ? 1u : 2u);
  }
}

TEST(LevelInterpolation, OfAPentagonGoesThroughTheMeansOfItsSidesAndCorners) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 5; ++k) corners.emplace_back(std::cos(1.25 * k), std::sin(1.25 * k), 0.1 * k);
  const PolygonSoup pentagon = soup_of(corners, {{0, 1, 2, 3, 4}});
  const LevelInterpolation interpolation = interpolate_level(pentagon, with_level(2), 0);
  // Corners, three points on each side, and the centre first of those inside.
  const auto weights_of = [&](std::size_t k) {
    std::vector<double> weights(
        interpolation.weights.begin() + static_cast<std::ptrdiff_t>(interpolation.starts[k]),
        interpolation.weights.begin() + static_cast<std::ptrdiff_t>(interpolation.starts[k + 1]));
    std::sort(weights.begin(), weights.end());
    return weights;
  };
  EXPECT_EQ(weights_of(5), (std::vector<double>{0.25, 0.75}));
  EXPECT_EQ(weights_of(6), (std::vector<double>{0.5, 0.5}));
  EXPECT_EQ(weights_of(5 + 15), (std::vector<double>(5, 0.2)));
}

TEST(LevelInterpolation, RefusesLevelsThatThereArent) {
  EXPECT_THROW(interpolate_level(control_cube(), with_level(2), 3), OptionError);
  // 24 4^9 facets are 6 million; of ten cubes they are too many, as `subdivide` says.
  const PolygonSoup cube = control_cube();
  PolygonSoup many = cube;
  for (int k = 1; k < 10; ++k) {
    const auto first = static_cast<Index>(many.positions.size());
    for (const Vec3& position : cube.positions) many.positions.push_back(position + Vec3(3 * k, 0, 0));
    for (std::size_t f = 0; f < cube.n_faces(); ++f) {
      std::vector<Index> face;
      for (const Index v : cube.face(f)) face.push_back(first + v);
      many.add_face(face);
    }
  }
  EXPECT_THROW(interpolate_level(many, with_level(10), 0), OptionError);
  EXPECT_THROW(interpolate_level(control_cube(), with_level(2), -1), OptionError);
  EXPECT_THROW(interpolate_level(control_cube(), with_level(11), 0), OptionError);
  EXPECT_THROW(interpolate_level({}, with_level(2), 0), InputError);
}

}  // namespace
}  // namespace recede
