#include <recede/geometry/displacement_map.h>
#include <recede/geometry/error.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <limits>
#include <random>

namespace recede {
namespace {

constexpr MapBorder k_borders[] = {MapBorder::clamped, MapBorder::periodic};
constexpr std::pair<int, int> k_sizes[] = {{1, 1}, {1, 7}, {2, 2}, {3, 5}, {8, 8}, {13, 21}, {64, 33}};

Raster random_raster(int columns, int rows, std::mt19937& random, int bits = 16) {
  Raster raster{columns, rows, 1, bits, false, {}};
  raster.samples.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (std::uint16_t& sample : raster.samples) sample = static_cast<std::uint16_t>(random() % (1u << bits));
  return raster;
}

/// Two columns, two rows: heights 0 1 above 2 4.
DisplacementMap two_by_two(MapBorder border) { return DisplacementMap(2, 2, {0, 1, 2, 4}, border); }

TEST(DisplacementMap, IsBilinearBetweenTheMiddlesOfTexelsAndHasRowZeroOnTop) {
  const DisplacementMap map = two_by_two(MapBorder::clamped);
  EXPECT_EQ(map.height_at({.25, .75}), 0);
  EXPECT_EQ(map.height_at({.75, .75}), 1);
  EXPECT_EQ(map.height_at({.25, .25}), 2);
  EXPECT_EQ(map.height_at({.75, .25}), 4);
  EXPECT_EQ(map.height_at({.5, .5}), 1.75);
  // du: 2 texels to the unit, mean of 1 and 2; dv: upwards, mean of -2 and -3.
  EXPECT_EQ(map.derivative_at({.5, .5}), Vec2(3, -5));
  EXPECT_EQ(map.derivative_at({.5, .75}), Vec2(2, -5));
}

TEST(DisplacementMap, EndsInItsBorderTexelsOrGoesOnAtTheOppositeSide) {
  const DisplacementMap clamped = two_by_two(MapBorder::clamped), periodic = two_by_two(MapBorder::periodic);
  EXPECT_EQ(clamped.height_at({0, 1}), 0);
  EXPECT_EQ(clamped.height_at({-5, 7}), 0);
  EXPECT_EQ(clamped.height_at({1, 0}), 4);
  EXPECT_EQ(clamped.derivative_at({.1, .5}).x(), 0);
  EXPECT_EQ(periodic.height_at({0, .75}), .5);
  EXPECT_EQ(periodic.height_at({1, .75}), .5);
  EXPECT_EQ(periodic.height_at({.25, 1}), 1);
  EXPECT_EQ(periodic.height_at({0, 0}), 1.75);
  EXPECT_EQ(periodic.height_at({-2.75, 5.75}), 0);
  EXPECT_EQ(periodic.derivative_at({0, .75}), Vec2(-2, -5));
}

TEST(DisplacementMap, HasSmoothSlopesOfCentralDifferencesBetweenWhichTheyAreBilinear) {
  const DisplacementMap periodic(4, 1, {0, 1, 4, 9}, MapBorder::periodic);
  const auto slope = [](const DisplacementMap& map, double u) {
    return map.smooth_derivative_at({u, .5}).x() / 4;  // for a step of one texel
  };
  EXPECT_EQ(slope(periodic, .375), 2);   // of the second texel: from 0 to 4
  EXPECT_EQ(slope(periodic, .625), 4);   // of the third
  EXPECT_EQ(slope(periodic, .5), 3);     // between them
  EXPECT_EQ(slope(periodic, .125), -4);  // of the first: from 9 on the other side to 1
  EXPECT_EQ(slope(periodic, 1.375), 2);  // a period farther
  EXPECT_EQ(slope(periodic, -.625), 2);
  EXPECT_EQ(periodic.smooth_derivative_at({.5, .3}).y(), 0);  // one row goes on as itself
  const DisplacementMap clamped(4, 1, {0, 1, 4, 9});
  EXPECT_EQ(slope(clamped, .125), .5);  // from 0, which goes on, to 1
  EXPECT_EQ(slope(clamped, -5), .25);   // beyond the first, half of that: what lies between it and no slope
  // v grows upwards.
  EXPECT_EQ(two_by_two(MapBorder::clamped).smooth_derivative_at({.25, .75}), Vec2(1, -2));
}

TEST(DisplacementMap, HasSmoothSlopesWithoutJumps) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1, 2);
  for (const MapBorder border : k_borders) {
    const DisplacementMap map(random_raster(13, 21, random), 2, 1, border);
    for (int i = 0; i < 1000; ++i) {
      const Vec2 uv(number(random), number(random));
      const Vec2 step = map.smooth_derivative_at(uv + Vec2(1e-9, -1e-9)) - map.smooth_derivative_at(uv);
      // Slopes lie within 2 x 21, and change by twice that from texel to texel.
      EXPECT_LT(step.norm(), 1e-9 * 21 * 2 * 2 * 42);
    }
  }
}

TEST(DisplacementMap, ScalesItsSamples) {
  const DisplacementMap map({2, 1, 1, 16, false, {0, 65535}}, 3, -1);
  EXPECT_EQ(map.texel(0, 0), -1);
  EXPECT_EQ(map.texel(1, 0), 2);
  EXPECT_EQ(map.height_at({.5, .5}), .5);
  EXPECT_EQ(map.derivative_at({.5, .5}), Vec2(6, 0));
  EXPECT_EQ(DisplacementMap({1, 1, 1, 8, false, {255}}, -2, 1).height_at({.3, .4}), -1);
}

TEST(DisplacementMap, IsRaisedAsItIsStored) {
  const DisplacementMap whole = raise_heights(DisplacementMap({2, 1, 1, 16, false, {0, 65535}}, 3, -1), 0.5);
  EXPECT_EQ(whole.bits(), 16);
  EXPECT_EQ(whole.texel(0, 0), -0.5);
  EXPECT_EQ(whole.texel(1, 0), 2.5);
  const DisplacementMap floats = raise_heights(two_by_two(MapBorder::periodic), -4);
  EXPECT_EQ(floats.bits(), 0);
  EXPECT_EQ(floats.border(), MapBorder::periodic);
  EXPECT_EQ(floats.texel(1, 1), 0);
}

TEST(DisplacementMap, HasTheDerivativesOfItsHeights) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 2);
  for (const MapBorder border : k_borders) {
    const DisplacementMap map(random_raster(13, 21, random), 2, 1, border);
    for (int i = 0; i < 1000; ++i) {
      const Vec2 uv(number(random), number(random));
      // A bilinear patch is linear along both axes: differences are exact within a cell, up to rounding.
      constexpr double k_step = 1e-6;
      const auto slope = [&](const Vec2& step) {
        return (map.height_at(uv + step) - map.height_at(uv - step)) / (2 * k_step);
      };
      if (map.column_place(uv.x() - k_step).cell != map.column_place(uv.x() + k_step).cell) continue;
      if (map.row_place(uv.y() - k_step).cell != map.row_place(uv.y() + k_step).cell) continue;
      EXPECT_NEAR(map.derivative_at(uv).x(), slope({k_step, 0}), 1e-8);  // rounding: 1e-15 / 1e-6
      EXPECT_NEAR(map.derivative_at(uv).y(), slope({0, k_step}), 1e-8);
    }
  }
}

TEST(DisplacementMap, TakesAnyTextureCoordinate) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), far = std::numeric_limits<double>::infinity();
  for (const MapBorder border : k_borders) {
    const DisplacementMap map = two_by_two(border);
    for (const double u : {nan, far, -far, 1e300, -1e300, -1e-30}) {
      const double height = map.height_at({u, .5});
      EXPECT_TRUE(height >= 0 && height <= 4) << u;
    }
  }
}

template <typename Exception, typename Make>
std::string message_of(Make&& make) {
  try {
    make();
  } catch (const Exception& error) {
    return error.what();
  }
  return "no error";
}

TEST(DisplacementMap, SaysWhatIsWrongWithItsInput) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), far = std::numeric_limits<float>::infinity();
  EXPECT_EQ(message_of<InputError>([&] {
              DisplacementMap(2, 2, {0, 1, 2, nan});
            }),
            "displacement map: the height of texel (1, 1) is not finite");
  EXPECT_EQ(message_of<InputError>([&] {
              DisplacementMap(3, 1, {far, 1, 2});
            }),
            "displacement map: the height of texel (0, 0) is not finite");
  EXPECT_EQ(message_of<InputError>([&] { DisplacementMap(0, 2, {}); }),
            "a displacement map needs at least one texel");
  EXPECT_EQ(message_of<InputError>([&] {
              DisplacementMap(3, 2, {1, 2, 3});
            }),
            "a displacement map of 3 x 2 texels needs 6 heights, not 3");
  EXPECT_EQ(message_of<InputError>([&] {
              DisplacementMap({1, 1, 3, 8, false, {0, 0, 0}}, 1, 0);
            }),
            "a displacement map needs one channel of 8 or 16 bits");
  EXPECT_EQ(message_of<InputError>([&] {
              DisplacementMap({2, 1, 1, 8, false, {0, 256}}, 1, 0);
            }),
            "displacement map: the height of texel (1, 0) has more bits than the map");
  EXPECT_EQ(message_of<OptionError>([&] {
              DisplacementMap({1, 1, 1, 16, false, {0}}, 1, nan);
            }),
            "displacement map: scale and offset must be finite");
}

DisplacementMap random_map(int kind, int columns, int rows, MapBorder border, std::mt19937& random) {
  if (kind < 2) return {random_raster(columns, rows, random), kind == 0 ? 0.37 : -0.37, 1.3, border};
  std::vector<float> heights(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  std::normal_distribution<float> any;
  for (float& height : heights) height = any(random);
  return {columns, rows, std::move(heights), border};
}

template <typename Check>
void for_all_maps(Check&& check) {
  std::mt19937 random(5);
  for (const auto& [columns, rows] : k_sizes) {
    for (const MapBorder border : k_borders) {
      for (int kind = 0; kind < 3; ++kind) check(random_map(kind, columns, rows, border, random), random);
    }
  }
}

HeightRange of_cells_by_brute_force(const DisplacementMap& map, int x0, int y0, int x1, int y1) {
  HeightRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      for (const int column : {map.column(x - 1), map.column(x)}) {
        for (const int row : {map.row(y - 1), map.row(y)}) {
          range.min = std::min(range.min, map.texel(column, row));
          range.max = std::max(range.max, map.texel(column, row));
        }
      }
    }
  }
  return range;
}

TEST(HeightBounds, OfANodeAreThoseOfItsCells) {
  for_all_maps([](const DisplacementMap& map, std::mt19937&) {
    const HeightBounds bounds(map);
    EXPECT_EQ(bounds.columns(bounds.levels() - 1), 1);
    EXPECT_EQ(bounds.rows(bounds.levels() - 1), 1);
    for (int level = 0; level < bounds.levels(); ++level) {
      for (int y = 0; y < bounds.rows(level); ++y) {
        for (int x = 0; x < bounds.columns(level); ++x) {
          const HeightRange expected = of_cells_by_brute_force(
              map, x << level, y << level, std::min((x + 1) << level, map.columns() + 1) - 1,
              std::min((y + 1) << level, map.rows() + 1) - 1);
          ASSERT_EQ(bounds.node(level, x, y), expected) << level << ": " << x << ' ' << y;
        }
      }
    }
  });
}

TEST(HeightBounds, OfRectanglesAreThoseOfBruteForce) {
  for_all_maps([](const DisplacementMap& map, std::mt19937& random) {
    const HeightBounds bounds(map);
    const auto interval = [&random](int count) {
      const auto pick = [&] { return static_cast<int>(random() % static_cast<unsigned>(count)); };
      return std::minmax({pick(), pick()});
    };
    for (int i = 0; i < 200; ++i) {
      const auto [x0, x1] = interval(map.columns() + 1);
      const auto [y0, y1] = interval(map.rows() + 1);
      const HeightRange expected = of_cells_by_brute_force(map, x0, y0, x1, y1);
      EXPECT_EQ(bounds.of_cells(x0, y0, x1, y1), expected);
      const HeightRange quick = bounds.quick(x0, y0, x1, y1);
      EXPECT_TRUE(quick.min <= expected.min && quick.max >= expected.max);
    }
  });
}

TEST(HeightBounds, OfABoxHoldAllHeightsThereAndNoOthers) {
  for_all_maps([](const DisplacementMap& map, std::mt19937& random) {
    const HeightBounds bounds(map);
    std::uniform_real_distribution<double> corner(-1.5, 2.5), unit(0, 1), small(0, 0.3);
    for (int i = 0; i < 200; ++i) {
      const Vec2 least(corner(random), corner(random));
      const Vec2 size(i % 5 == 0 ? corner(random) + 1.5 : small(random), i % 7 == 0 ? 0 : small(random));
      const Vec2 largest = least + size;
      const HeightRange range = bounds.of_box(least, largest);
      // Cells that the box touches: their corners alone may be outside it, by a texel at most.
      HeightRange around{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
      for (int k = 0; k < 100; ++k) {
        const Vec2 inside = least + Vec2(k % 3 == 0 ? k % 2 : unit(random), k % 5 == 0 ? k % 2 : unit(random))
                                        .cwiseProduct(size)
                                        .eval();
        const double height = map.height_at(inside.cwiseMin(largest));
        EXPECT_TRUE(height >= range.min && height <= range.max) << height;
      }
      const Vec2 texel(1.0 / map.columns(), 1.0 / map.rows());
      const Vec2 from = least - texel, to = largest + texel;
      for (int y = 0; y < map.rows(); ++y) {
        for (int x = 0; x < map.columns(); ++x) {
          const Vec2 middle((x + .5) * texel.x(), 1 - (y + .5) * texel.y());
          const auto touched = [&](Eigen::Index axis) {
            if (map.border() == MapBorder::periodic) {
              return std::floor(to[axis] - middle[axis]) >= std::ceil(from[axis] - middle[axis]);
            }
            const double low = std::clamp(from[axis], 0.0, 1.0), high = std::clamp(to[axis], 0.0, 1.0);
            return (middle[axis] >= low - texel[axis] && middle[axis] <= high + texel[axis]);
          };
          if (!touched(0) || !touched(1)) continue;
          around = {std::min(around.min, map.texel(x, y)), std::max(around.max, map.texel(x, y))};
        }
      }
      EXPECT_TRUE(range.min >= around.min && range.max <= around.max);
    }
  });
}

TEST(HeightBounds, OfAPeriodicMapGoOnAcrossTheBorder) {
  const DisplacementMap map(4, 1, {5, 1, 2, 7}, MapBorder::periodic);
  const HeightBounds bounds(map);
  EXPECT_EQ(bounds.of_box({.2, 0}, {.3, 0}), (HeightRange{1, 5}));
  EXPECT_EQ(bounds.of_box({.4, 0}, {.6, 0}), (HeightRange{1, 2}));
  EXPECT_EQ(bounds.of_box({.9, 0}, {1.1, 0}), (HeightRange{5, 7}));
  EXPECT_EQ(bounds.of_box({-.1, 0}, {.1, 0}), (HeightRange{5, 7}));
  EXPECT_EQ(bounds.of_box({.9, 0}, {1.2, 0}), (HeightRange{1, 7}));
  EXPECT_EQ(bounds.of_box({.9, 0}, {1e30, 0}), (HeightRange{1, 7}));
}

TEST(HeightBounds, TakeTwoThirdsOfTheMapAndAreTheSameForAnyNumberOfThreads) {
  std::mt19937 random(7);
  const DisplacementMap map(random_raster(1023, 700, random), 1, 0, MapBorder::periodic);
  const HeightBounds bounds(map);
  // Rows and columns are one more than texels, and every level rounds up.
  EXPECT_LT(static_cast<double>(bounds.bytes()), (2.0 / 3 + 0.01) * static_cast<double>(map.bytes()));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const HeightBounds alone(map);
  for (int level = 1; level < bounds.levels(); ++level) {
    for (int y = 0; y < bounds.rows(level); ++y) {
      for (int x = 0; x < bounds.columns(level); ++x) {
        ASSERT_EQ(alone.node(level, x, y), bounds.node(level, x, y));
      }
    }
  }
}

}  // namespace
}  // namespace recede
