#include "displaced_planes.h"
#include "tiled_surfaces.h"
#include <recede/geometry/error.h>
#include <recede/render/map_stretch.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

TEST(MapStretch, IsTheLengthOfAStepAlongEachCoordinate) {
  PolygonSoup soup;
  soup.positions = {{0, 0, 5}, {2, 0, 5}, {2, 3, 5}, {0, 3, 5}};
  soup.add_face(std::array<Index, 4>{0, 1, 2, 3});
  soup.corner_uvs = {{0, 0}, {4, 0}, {4, 1}, {0, 1}};
  const MapStretch stretch = measure_stretch(soup);
  EXPECT_NEAR(stretch.sides.x(), 0.5, 1e-15);
  EXPECT_NEAR(stretch.sides.y(), 3, 1e-15);
  EXPECT_NEAR(stretch.spread.norm(), 0, 1e-7);  // the root of a difference of rounded squares
}

TEST(MapStretch, TellsHowItVariesByArea) {
  PolygonSoup soup;  // a square of area 1 with steps of 1, and one of area 3 with steps of 3 along u
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {4, 0, 0}, {4, 1, 0}};
  soup.add_face(std::array<Index, 4>{0, 1, 2, 3});
  soup.add_face(std::array<Index, 4>{1, 4, 5, 2});
  soup.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const MapStretch stretch = measure_stretch(soup);
  EXPECT_NEAR(stretch.sides.x(), (1 * 1 + 3 * 3) / 4.0, 1e-15);
  EXPECT_NEAR(stretch.sides.y(), 1, 1e-15);
  const double variance = (1 * 1.5 * 1.5 + 3 * 0.5 * 0.5) / 4;
  EXPECT_NEAR(stretch.spread.x(), std::sqrt(variance) / 2.5, 1e-12);
}

TEST(MapStretch, RefusesSurfacesWithoutAnArea) {
  PolygonSoup soup = test::tiled_square(1);
  for (Vec2& uv : soup.corner_uvs) uv.y() = 0.5;
  EXPECT_THROW(measure_stretch(soup), InputError);
  soup.corner_uvs.clear();
  EXPECT_THROW(measure_stretch(soup), InputError);
  soup = test::tiled_square(1);
  soup.corner_uvs[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(measure_stretch(soup), InputError);
}

TEST(MeanWavelength, IsThatOfASine) {
  for (const int waves : {1, 4, 9}) {
    const DisplacementMap map =
        test::map_of(256, [&](double u, double v) { return 7 + 0.3 * std::sin(2 * k_pi * waves * (u + v)); });
    // Steps between texels are chords: sin(x) / x of half a step's angle, 0.9980 for 9 waves of 28 texels.
    EXPECT_NEAR(mean_wavelength(map, {2, 2}), 2 / (waves * std::sqrt(2)), 0.003 / waves);
  }
}

TEST(MeanWavelength, OfAFlatMapIsNothing) {
  EXPECT_EQ(mean_wavelength(DisplacementMap(3, 2, std::vector<float>(6, 1e6f)), {1, 1}), 0);
  EXPECT_EQ(mean_wavelength(DisplacementMap(1, 1, {3}), {1, 1}), 0);
}

TEST(CoveredTexels, AreThoseWhoseMiddlesLieOnTheSurface) {
  PolygonSoup soup = test::tiled_square(1);
  for (Vec2& uv : soup.corner_uvs) uv = Vec2(0.5 * uv.x(), 0.25 + 0.5 * uv.y());
  // Of 4 x 4 texels: the left half, without the upper and the lower row.
  const std::vector<bool> covered = covered_texels(soup, 4, 4);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x)
      EXPECT_EQ(covered[static_cast<std::size_t>(4 * y + x)], x < 2 && (y == 1 || y == 2)) << x << ' ' << y;
  }
  for (Vec2& uv : soup.corner_uvs) uv.x() -= 3;
  for (const bool texel : covered_texels(soup, 4, 4)) EXPECT_FALSE(texel);
}

}  // namespace
}  // namespace recede
