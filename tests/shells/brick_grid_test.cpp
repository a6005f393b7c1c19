#include <recede/geometry/error.h>
#include <recede/shells/brick_grid.h>

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <atomic>
#include <random>

namespace {

using namespace recede;
using Bytes = BrickGrid<std::uint8_t>;

std::vector<std::uint8_t> random_texels(const std::array<int, 3>& size, int most, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> texels(TexelBox{{0, 0, 0}, size}.n_texels());
  for (auto& texel : texels)
    texel = static_cast<std::uint8_t>(std::uniform_int_distribution(0, most)(random));
  return texels;
}

std::size_t number(const std::array<int, 3>& size, int i, int j, int k) {
  return static_cast<std::size_t>(i + size[0] * (j + size[1] * k));
}

constexpr std::array<std::array<int, 3>, 9> k_sizes{{{1, 1, 1},
                                                     {4, 4, 4},
                                                     {5, 4, 3},
                                                     {1, 20, 3},
                                                     {17, 1, 8},
                                                     {16, 24, 8},
                                                     {13, 11, 19},
                                                     {2, 3, 40},
                                                     {7, 9, 1}}};

TEST(BrickGrid, HoldsWhatAListDoes) {
  for (const auto& size : k_sizes) {
    const std::vector<std::uint8_t> texels = random_texels(size, 255, 1);
    const Bytes grid = Bytes::from_dense(size, texels);
    EXPECT_EQ(grid.size(), size);
    EXPECT_EQ(grid.n_texels(), texels.size());
    EXPECT_EQ(grid.to_dense(), texels);
    for_each_texel({{0, 0, 0}, size},
                   [&](int i, int j, int k) { ASSERT_EQ(grid.at(i, j, k), texels[number(size, i, j, k)]); });
  }
  EXPECT_TRUE(Bytes().empty());
  EXPECT_EQ(Bytes().n_bytes(), 0u);
}

// Corners of cells within bricks, across their borders, and across the whole grid, as where it repeats.
TEST(BrickGrid, FindsTheTexelsAroundAPlace) {
  for (const auto& size : k_sizes) {
    const std::vector<std::uint8_t> texels = random_texels(size, 255, 2);
    const Bytes grid = Bytes::from_dense(size, texels);
    std::mt19937 random(3);
    for (int n = 0; n < 500; ++n) {
      std::array<int, 3> a{}, b{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        a[axis] = std::uniform_int_distribution(0, size[axis] - 1)(random);
        b[axis] = n % 3 == 0 ? std::uniform_int_distribution(0, size[axis] - 1)(random)
                             : (a[axis] + 1) % size[axis];
      }
      const std::array<std::uint8_t, 8> corners = grid.corners(a, b);
      for (std::size_t c = 0; c < 8; ++c) {
        EXPECT_EQ(corners[c], texels[number(size, (c & 1) != 0 ? b[0] : a[0], (c & 2) != 0 ? b[1] : a[1],
                                            (c & 4) != 0 ? b[2] : a[2])]);
      }
    }
  }
}

TEST(BrickGrid, CopiesParts) {
  const std::array<int, 3> size{21, 10, 12};
  const std::vector<std::uint8_t> texels = random_texels(size, 255, 4);
  const Bytes grid = Bytes::from_dense(size, texels);
  const TexelBox box{{5, 0, 7}, {18, 9, 9}};
  std::vector<std::uint8_t> part(box.n_texels());
  grid.copy_to(box, part.data());
  std::size_t next = 0;
  for_each_texel(box, [&](int i, int j, int k) { EXPECT_EQ(part[next++], texels[number(size, i, j, k)]); });
  EXPECT_EQ(next, 13u * 9 * 2);
}

// A slab of matter, 18 texels of 99 thick: bricks in it, above it and across its side are each kept once.
TEST(BrickGrid, KeepsWhatIsAlikeOnce) {
  const auto slab = [](int thickness) {
    return Bytes::make({64, 64, 99}, [&](Bytes::Brick& brick) {
      for_each_texel(brick.box(), [&](int i, int j, int k) {
        brick.at(i, j, k) = k < thickness ? std::uint8_t{255} : std::uint8_t{0};
      });
    });
  };
  const Bytes grid = slab(18);
  EXPECT_EQ(grid.n_bricks(), 16u * 16 * 25);
  // Three contents of 64 texels, each with a byte for whether it is uniform, and 4 bytes for each brick.
  EXPECT_EQ(grid.n_bytes(), 3 * 65u + 4 * grid.n_bricks());
  EXPECT_EQ(grid.uniform_value(0), std::uint8_t{255});
  EXPECT_EQ(grid.uniform_value(4 * 256), std::nullopt);
  EXPECT_EQ(grid.uniform_value(24 * 256), std::uint8_t{0});
  EXPECT_EQ(grid.uniform_value(TexelBox{{0, 0, 0}, {64, 64, 15}}), std::uint8_t{255});
  EXPECT_EQ(grid.uniform_value(TexelBox{{30, 0, 8}, {31, 1, 21}}), std::nullopt);
  EXPECT_EQ(grid.uniform_value(TexelBox{{63, 63, 20}, {64, 64, 99}}), std::uint8_t{0});
  EXPECT_EQ(grid, slab(18));
  EXPECT_NE(grid, slab(19));
  // With the end of a brick beyond the grid: nothing but matter.
  EXPECT_EQ(Bytes({64, 64, 99}, 7).n_bytes(), 65u + 4 * grid.n_bricks());
  EXPECT_EQ(Bytes({64, 64, 99}, 7).uniform_value(24 * 256), std::uint8_t{7});
  // Thin grids have thin bricks.
  EXPECT_EQ(Bytes::from_dense({64, 64, 1}, random_texels({64, 64, 1}, 255, 9)).n_bytes(), 64 * 64u + 256 * 5);
}

TEST(BrickGrid, IsEditedByMakingAnother) {
  const std::array<int, 3> size{30, 17, 9};
  std::vector<std::uint8_t> texels = random_texels(size, 3, 5);
  const Bytes before = Bytes::from_dense(size, texels), kept = before;
  const Bytes after = Bytes::make(size, [&](Bytes::Brick& brick) {
    brick.copy(before);
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      if (i == j) brick.at(i, j, k) = 9;
      EXPECT_EQ(before.number_of(brick), static_cast<std::size_t>(i / 4 + 8 * (j / 4 + 5 * (k / 4))));
    });
  });
  EXPECT_EQ(kept.to_dense(), texels);
  for (int k = 0; k < 9; ++k)
    for (int i = 0; i < 17; ++i) texels[number(size, i, i, k)] = 9;
  EXPECT_EQ(after.to_dense(), texels);
}

TEST(BrickGrid, HoldsNumbersOfSeveralBytes) {
  using Color = std::array<std::uint8_t, 3>;
  std::vector<Color> colors;
  for (int n = 0; n < 20 * 9 * 3; ++n)
    colors.push_back({static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n / 7), 1});
  EXPECT_EQ(BrickGrid<Color>::from_dense({20, 9, 3}, colors).to_dense(), colors);
  // The same bytes, moved by one, aren't the same texels.
  EXPECT_EQ(BrickGrid<Color>({9, 9, 9}, {1, 1, 2}).uniform_value(0), (Color{1, 1, 2}));
  // Of two colours there are numbers of a byte, and both once.
  const BrickGrid<Color> stripes = BrickGrid<Color>::make({9, 8, 8}, [](BrickGrid<Color>::Brick& brick) {
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      brick.at(i, j, k) = i % 2 == 0 ? Color{1, 2, 3} : Color{255, 0, 4};
    });
  });
  EXPECT_EQ(stripes.n_bytes(), 2 * 65u + 6 + 4 * 12);
  EXPECT_EQ(stripes.at(7, 3, 5), (Color{255, 0, 4}));
  EXPECT_EQ(stripes.at(8, 7, 7), (Color{1, 2, 3}));
  const BrickGrid<double> numbers({4, 4, 4}, 0.1);
  EXPECT_EQ(numbers.at(3, 3, 3), 0.1);
}

TEST(BrickGrid, IsTheSameForAnyNumberOfThreads) {
  const auto make = [] {
    return Bytes::make({100, 90, 80}, [](Bytes::Brick& brick) {
      for_each_texel(brick.box(), [&](int i, int j, int k) {
        brick.at(i, j, k) = static_cast<std::uint8_t>((i / 16 + j / 16) * (k / 8) + (i & j) % 3);
      });
    });
  };
  const Bytes many = make();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(make(), many);
  EXPECT_EQ(make().n_bytes(), many.n_bytes());
}

/// Cancels at the second call.
class Impatient : public Progress {
 public:
  void update(std::string_view stage, double) override { EXPECT_EQ(stage, "bricks"); }
  bool cancel_requested() const override { return ++calls_ > 1; }

 private:
  mutable int calls_ = 0;
};

TEST(BrickGrid, StopsWhenItIsCancelled) {
  Impatient impatient;
  std::atomic<int> filled = 0;
  const auto fill = [&](Bytes::Brick& brick) {
    brick.fill(0);
    ++filled;
  };
  EXPECT_THROW(Bytes::make({128, 128, 128}, fill, &impatient, "bricks"), Cancelled);
  EXPECT_GT(filled, 0);
  EXPECT_LT(filled, 32 * 32 * 32);
  EXPECT_THROW(Bytes::make({8, 8, 8}, [](Bytes::Brick&) { throw InputError("no"); }), InputError);
}

}  // namespace
