#include <recede/geometry/atlas_packing.h>
#include <recede/geometry/error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace recede {
namespace {

/// Inside, and apart by the gutter.
void expect_apart(const std::vector<Vec2>& sides, const PackedRectangles& packed, int gutter) {
  std::vector<Eigen::AlignedBox2i> boxes;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const PackedRectangles::Place& place = packed.places[i];
    Vec2 texels = packed.texels_per_unit * sides[i];
    if (place.turned) std::swap(texels.x(), texels.y());
    const Eigen::Vector2i lower(place.x, place.y);
    const Eigen::Vector2i upper =
        lower + Eigen::Vector2i(int(std::ceil(texels.x())), int(std::ceil(texels.y())));
    EXPECT_GE(lower.minCoeff(), gutter / 2);
    EXPECT_LE(upper.maxCoeff(), packed.resolution - gutter / 2);
    for (const auto& other : boxes) {
      const bool apart = (lower.array() >= other.max().array() + gutter).any() ||
                         (other.min().array() >= upper.array() + gutter).any();
      EXPECT_TRUE(apart) << "rectangle " << i;
    }
    boxes.emplace_back(lower, upper);
  }
}

TEST(AtlasPacking, FourSquaresFillASquare) {
  const std::vector<Vec2> sides(4, Vec2(3, 3));
  const PackedRectangles packed = pack_rectangles(sides, {.resolution = 64, .gutter = 0});
  EXPECT_NEAR(packed.texels_per_unit, 32.0 / 3, 0.02);
  EXPECT_GT(packed.occupancy, 0.99);
  expect_apart(sides, packed, 0);
}

TEST(AtlasPacking, TurnsWhatFitsBetterTheOtherWay) {
  const std::vector<Vec2> sides = {{4, 1}, {1, 4}, {4, 1}, {1, 4}};
  EXPECT_GT(pack_rectangles(sides, {.resolution = 256, .gutter = 0}).occupancy, 0.98);
}

TEST(AtlasPacking, RandomRectanglesAreApartAndDense) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    std::mt19937 random(seed);
    std::lognormal_distribution<double> side(0, 0.7);
    std::vector<Vec2> sides(1 + random() % 200);
    for (Vec2& s : sides) s = {side(random), side(random)};
    const int gutter = static_cast<int>(random() % 4);
    const PackedRectangles packed = pack_rectangles(sides, {.resolution = 1024, .gutter = gutter});
    EXPECT_EQ(packed.resolution, 1024);
    expect_apart(sides, packed, gutter);
    if (sides.size() > 50) {
      EXPECT_GT(packed.occupancy, 0.7) << "seed " << seed;
    }
  }
}

TEST(AtlasPacking, TooManyForTheGuttersGetALargerAtlas) {
  const std::vector<Vec2> sides(500, Vec2(1, 2));
  const PackedRectangles packed = pack_rectangles(sides, {.resolution = 16, .gutter = 3});
  EXPECT_EQ(packed.resolution, 128);
  expect_apart(sides, packed, 3);
}

TEST(AtlasPacking, RefusesWhatIsNoRectangleOrNoAtlas) {
  const std::vector<Vec2> one(1, Vec2(1, 1)), flat(1, Vec2(1, 0));
  EXPECT_THROW(pack_rectangles(flat), InputError);
  EXPECT_THROW(pack_rectangles(one, {.resolution = 0}), OptionError);
  EXPECT_THROW(pack_rectangles(one, {.gutter = -1}), OptionError);
  EXPECT_TRUE(pack_rectangles({}).places.empty());
}

TEST(AtlasPacking, TheSmallestRectangleOfATurnedRectangleIsItself) {
  const Eigen::Rotation2Dd turn(0.4);
  std::vector<Vec2> points;
  for (const Vec2& p : {Vec2(0, 0), Vec2(5, 0), Vec2(5, 2), Vec2(0, 2), Vec2(3, 1)})
    points.push_back(turn * p);
  const BoundingRectangle box = smallest_rectangle(points);
  EXPECT_NEAR(box.sides.prod(), 10, 1e-12);
  EXPECT_NEAR(box.sides.maxCoeff(), 5, 1e-12);
}

TEST(AtlasPacking, NoOtherDirectionGivesASmallerRectangle) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 20; ++round) {
    std::vector<Vec2> points(3 + random() % 40);
    for (Vec2& p : points) p = {normal(random), 0.3 * normal(random)};
    const BoundingRectangle box = smallest_rectangle(points);
    const Vec2 across(-box.axis.y(), box.axis.x());
    for (const Vec2& p : points) {
      const Vec2 local((p - box.corner).dot(box.axis), (p - box.corner).dot(across));
      EXPECT_GE(local.minCoeff(), -1e-12);
      EXPECT_LE((local - box.sides).maxCoeff(), 1e-12);
    }
    for (int i = 0; i < 180; ++i) {
      const Eigen::Rotation2Dd turn(std::numbers::pi * i / 360);
      Eigen::AlignedBox2d other;
      for (const Vec2& p : points) other.extend(turn * p);
      EXPECT_GE(other.sizes().prod(), box.sides.prod() * (1 - 1e-12));
    }
  }
}

TEST(AtlasPacking, PointsOnALineOrAPointHaveAFlatRectangle) {
  for (const std::vector<Vec2>& points : {std::vector<Vec2>{{1, 2}}, std::vector<Vec2>(3, Vec2(1, 2))}) {
    EXPECT_EQ(smallest_rectangle(points).sides, Vec2(0, 0));
    EXPECT_EQ(smallest_rectangle(points).corner, Vec2(1, 2));
  }
  EXPECT_NEAR(smallest_rectangle(std::vector<Vec2>{{0, 0}, {1, 1}, {2, 2}}).sides.maxCoeff(), std::sqrt(8),
              1e-12);
}

TEST(TexelPacking, KeepsRectanglesApartInASmallAtlas) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> side(1, 30);
  std::vector<Eigen::Vector2i> sizes;
  int area = 0;
  for (int i = 0; i < 200; ++i) {
    sizes.emplace_back(side(random), side(random));
    area += sizes.back().prod();
  }
  const PackedTexels packed = pack_texels(sizes, 1);
  EXPECT_EQ(packed.width % 4, 0);
  EXPECT_EQ(packed.height % 4, 0);
  EXPECT_GT(area, 0.75 * packed.width * packed.height);  // the gutters alone take a tenth
  std::vector<int> owners(static_cast<std::size_t>(packed.width * packed.height), 0);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const PackedRectangles::Place& place = packed.places[i];
    const int width = place.turned ? sizes[i].y() : sizes[i].x(),
              height = place.turned ? sizes[i].x() : sizes[i].y();
    ASSERT_LE(place.x + width, packed.width);
    ASSERT_LE(place.y + height, packed.height);
    for (int y = place.y; y < std::min(place.y + height + 1, packed.height); ++y) {
      for (int x = place.x; x < std::min(place.x + width + 1, packed.width); ++x)
        EXPECT_EQ(owners[static_cast<std::size_t>(y * packed.width + x)]++, 0) << "rectangle " << i;
    }
  }
}

TEST(TexelPacking, TakesOneRectangleAsItIs) {
  const std::vector<Eigen::Vector2i> sizes{{8, 4}};
  const PackedTexels packed = pack_texels(sizes, 0);
  EXPECT_EQ(packed.width * packed.height, 32);
  EXPECT_EQ(pack_texels({}, 1).places.size(), 0u);
}

TEST(TexelPacking, RefusesWhatHasNoMeaning) {
  const std::vector<Eigen::Vector2i> none{{0, 4}}, endless{{70'000, 1}};
  EXPECT_THROW(pack_texels(none, 1), InputError);
  EXPECT_THROW(pack_texels(endless, 1), InputError);
  EXPECT_THROW(pack_texels({}, -1), OptionError);
}

}  // namespace
}  // namespace recede
