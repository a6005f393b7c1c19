#include <recede/shells/detail/empty_regions.h>

#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace {

using namespace recede;
using detail::EmptyRegions;
using Bytes = BrickGrid<std::uint8_t>;

VolumeTexture texture_of(const std::array<int, 3>& size, bool is_periodic,
                         const std::vector<std::array<int, 3>>& full) {
  VolumeTexture texture{.size = size, .is_periodic = is_periodic};
  std::vector<std::uint8_t> texels(texture.n_texels(), 0);
  for (const auto& [i, j, k] : full) texels[texture.texel(i, j, k)] = 255;
  texture.opacity = Bytes::from_dense(size, texels);
  return texture;
}

// Cells go from texels' middles on: along s the third cube's from 16.5 to 24.5, in 32nds.
TEST(EmptyRegions, EndWhereTheirCubesDo) {
  const EmptyRegions empty(texture_of({32, 32, 32}, false, {{20, 20, 20}}));
  const auto at = [](double i, double j, double k) { return Vec3(i / 32, j / 32, k / 32); };
  EXPECT_EQ(empty.free_length(at(18, 18, 18), at(1, 0, 0)), 0);
  EXPECT_NEAR(empty.free_length(at(10, 18, 18), at(1, 0, 0)), 6.5, 1e-12);
  EXPECT_NEAR(empty.free_length(at(10, 18, 18), at(-0.5, 0, 0)), 3, 1e-12);
  EXPECT_NEAR(empty.free_length(at(10, 12, 18), at(2, -1, 0)), 3.25, 1e-12);
  // Beyond the outermost texels nothing changes.
  EXPECT_EQ(empty.free_length(at(30, 18, 18), at(1, 0, 0)), INFINITY);
  EXPECT_EQ(empty.free_length(at(3, 3, 3), at(-1, -1, -1)), INFINITY);
  // Two texels beside a cube there is nothing, either: that at 23 is within two of the cells behind 24.
  const EmptyRegions near(texture_of({32, 32, 32}, false, {{22, 20, 20}, {4, 4, 9}}));
  EXPECT_EQ(near.free_length(at(26, 18, 18), at(1, 0, 0)), 0);
  EXPECT_EQ(near.free_length(at(4, 4, 4), at(1, 0, 0)), 0);
  EXPECT_EQ(near.free_length(at(4, 4, 20), at(0, 0, 1)) > 0, true);
}

// Random specks: as far as it says, and up to two texels beside that, opacity is below a half.
TEST(EmptyRegions, HoldNothing) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> number(-1, 1);
  int found = 0;
  for (const std::array<int, 3>& size : {std::array{40, 33, 29}, {13, 50, 7}, {8, 64, 30}, {1, 20, 41}}) {
    for (const bool is_periodic : {false, true}) {
      std::vector<std::array<int, 3>> specks;
      for (int n = 0; n < 5; ++n) {
        std::array<int, 3> speck{};
        for (std::size_t axis = 0; axis < 3; ++axis)
          speck[axis] = std::uniform_int_distribution(0, size[axis] - 1)(random);
        specks.push_back(speck);
      }
      const VolumeTexture texture = texture_of(size, is_periodic, specks);
      const EmptyRegions empty(texture);
      const Vec3 texel(1.0 / size[0], 1.0 / size[1], 1.0 / size[2]);
      for (int n = 0; n < 4000; ++n) {
        const Vec3 place = Vec3(0.5 + number(random), 0.5 + number(random), 0.5 + 0.5 * number(random));
        const Vec3 move = Vec3(number(random), number(random), number(random)).cwiseProduct(texel);
        // Of what never ends, some.
        const double length = std::min(empty.free_length(place, move), 100.0);
        if (!(length > 0)) continue;
        ++found;
        for (int step = 0; step <= 8; ++step) {
          const Vec3 beside(number(random), number(random), number(random));
          const Vec3 at = place + step / 8.0 * length * move + 2 * beside.cwiseProduct(texel);
          ASSERT_LT(opacity_at(texture, at), 0.5) << at.transpose();
        }
      }
    }
  }
  EXPECT_GT(found, 2000);
}

}  // namespace
