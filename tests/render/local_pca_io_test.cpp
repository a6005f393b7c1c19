#include "temp_folder.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/detail/half_numbers.h>
#include <recede/render/local_pca.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace recede {
namespace {

using testing::HasSubstr;

/// Two vectors of three numbers: (1, 2, 3) + w (0.5, 0, -1), w = 1 and -0.25.
LocalPca small() {
  return {.dimension = 3,
          .components = 1,
          .scale = 0.5F,
          .parts = {1, 0.5F, 2, 0, 3, -1},
          .clusters = {0, 0},
          .weights = {1, -0.25F}};
}

std::string bytes_of_small() {
  using namespace std::string_literals;
  return "recede local pca 1\n"
         "\3\0\0\0\0\0\0\0\1\0\0\0\0\0\0\0\2\0\0\0\0\0\0\0\1\0\0\0\0\0\0\x3f"  // counts and scale
         "\x00\x40\x00\x3c\x00\x44\x00\x00\x00\x46\x00\xc0"                    // 2 1 4 0 6 -2
         "\0\x00\x3c\0\x00\xb4"s;                                              // 0: 1, 0: -0.25
}

std::vector<float> all_vectors(const LocalPca& pca) {
  std::vector<float> all(pca.vector_count() * pca.dimension);
  for (std::size_t i = 0; i < pca.vector_count(); ++i)
    reconstruct(pca, i, std::span(all).subspan(i * pca.dimension, pca.dimension));
  return all;
}

void expect_same(const LocalPca& a, const LocalPca& b) {
  EXPECT_EQ(a.dimension, b.dimension);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.scale, b.scale);
  EXPECT_EQ(a.parts, b.parts);
  EXPECT_EQ(a.clusters, b.clusters);
  EXPECT_EQ(a.weights, b.weights);
}

TEST(LocalPcaFile, HasTheBytesThatItsHeaderSays) {
  const test::TempFolder folder;
  write_local_pca(folder / "small", small());
  EXPECT_EQ(read_whole_file(folder / "small"), bytes_of_small());
  EXPECT_EQ(bytes(small()), bytes_of_small().size());
  const LocalPca back = read_local_pca(folder / "small");
  expect_same(back, small());
  EXPECT_THAT(all_vectors(back), testing::ElementsAre(1.5F, 2, 2, 0.875F, 2, 3.25F));
}

TEST(LocalPcaFile, KeepsWhatWasMadeBitForBit) {
  std::mt19937 random(1);
  std::normal_distribution<float> number(0, 1);
  const test::TempFolder folder;
  // Clusters take two bytes from 257 on, and components may be none.
  struct Case {
    std::size_t vectors;
    int clusters, components;
    float size;
  };
  for (const Case& c : {Case{40, 5, 3, 1e-9F}, Case{700, 300, 0, 1e9F}, Case{700, 300, 1, 1}}) {
    std::vector<float> values(c.vectors * 30);
    for (float& value : values) value = c.size * number(random);
    const LocalPca pca =
        make_local_pca(vectors_in(values, 30), {.clusters = c.clusters, .components = c.components});
    ASSERT_EQ(pca.cluster_count(), static_cast<std::size_t>(c.clusters));
    write_local_pca(folder / "pca", pca);
    expect_same(read_local_pca(folder / "pca"), pca);
    EXPECT_EQ(bytes(pca), std::filesystem::file_size(folder / "pca"));
    const std::size_t parts = 30 * static_cast<std::size_t>(c.clusters * (c.components + 1));
    const std::size_t of_vector = (c.clusters > 256 ? 2 : 1) + 2 * static_cast<std::size_t>(c.components);
    EXPECT_EQ(bytes(pca), 51 + 2 * parts + c.vectors * of_vector);
  }
}

TEST(LocalPcaFile, KeepsTheSmallestNumbers) {
  const test::TempFolder folder;
  for (const float size : {1e-35F, 1e-37F}) {
    const std::vector<float> values{size, -0.3F * size, 0, 0.7F * size};
    const LocalPca pca = make_local_pca(vectors_in(values, 4));
    write_local_pca(folder / "pca", pca);
    const LocalPca back = read_local_pca(folder / "pca");
    expect_same(back, pca);
    // Halves of the smallest scale, 2^-126, have steps of 2^-150.
    const std::vector<float> all = all_vectors(back);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(all[i], values[i], 0.001F * size) << size;
  }
}

TEST(LocalPcaFile, HasTheSizesKnownOfBidirectionalTextureFunctions) {
  const auto size = [](std::size_t dimension, std::size_t clusters, std::size_t vectors) {
    LocalPca pca{.dimension = dimension, .components = 8};
    pca.parts.resize(clusters * dimension * 9);
    pca.clusters.resize(vectors);
    pca.weights.resize(vectors * 8);
    return static_cast<double>(bytes(pca)) / (1 << 20);
  };
  // 81 x 81 directions in three colours, 32 clusters: three sizes of the texture, in MiB to three digits.
  EXPECT_NEAR(size(19'683, 32, 128 * 128), 11.1, 0.05);
  EXPECT_NEAR(size(19'683, 32, 256 * 256), 11.9, 0.05);
  EXPECT_NEAR(size(19'683, 32, 512 * 512), 15.1, 0.05);
  // A billboard cloud of 60 000 texels, 49 x 98 directions and 64 clusters: about 17 MB are reported.
  EXPECT_NEAR(size(49 * 98 * 3, 64, 60'000), 16.8, 0.05);
}

TEST(LocalPcaFile, RefusesAnythingElse) {
  const test::TempFolder folder;
  const std::string good = bytes_of_small();
  const auto complaint = [&](const std::string& content) -> std::string {
    try {
      read_local_pca(folder.write("bad", content));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto changed = [&](std::size_t at, char byte) {
    std::string bytes = good;
    bytes[at] = byte;
    return bytes;
  };
  ASSERT_EQ(complaint(good), "");
  for (std::size_t size = 0; size < good.size(); ++size)
    ASSERT_NE(complaint(good.substr(0, size)), "") << size << " bytes of it";
  EXPECT_THAT(complaint(good + '\0'), HasSubstr("longer or shorter"));
  EXPECT_THAT(complaint(changed(17, '2')), HasSubstr("this is no local PCA"));
  EXPECT_THAT(complaint(changed(19, 0)), HasSubstr("byte 19: a count out of range"));   // dimension 0
  EXPECT_THAT(complaint(changed(26, 1)), HasSubstr("byte 19: a count out of range"));   // dimension 2^56
  EXPECT_THAT(complaint(changed(23, 64)), HasSubstr("longer or shorter"));              // dimension 2^38
  EXPECT_THAT(complaint(changed(27, 0)), HasSubstr("byte 27: a count out of range"));   // no cluster
  EXPECT_THAT(complaint(changed(29, 2)), HasSubstr("byte 27: a count out of range"));   // 131 073
  EXPECT_THAT(complaint(changed(35, 0)), HasSubstr("byte 35: a count out of range"));   // no vector
  EXPECT_THAT(complaint(changed(43, 65)), HasSubstr("byte 43: a count out of range"));  // components
  EXPECT_THAT(complaint(changed(49, 1)), HasSubstr("byte 47: the scale"));              // no power of two
  EXPECT_THAT(complaint(changed(50, '\xbf')), HasSubstr("byte 47: the scale"));         // less than 0
  EXPECT_THAT(complaint(changed(52, 0x7c)), HasSubstr("byte 51: a number isn't finite"));
  EXPECT_THAT(complaint(changed(63, 1)), HasSubstr("byte 63: a cluster that isn't there"));
  EXPECT_THAT(complaint(changed(65, 0x7e)), HasSubstr("byte 64: a number isn't finite"));
  EXPECT_THROW(read_local_pca(folder / "none"), InputError);

  LocalPca without = small();
  without.weights.pop_back();
  EXPECT_THROW(write_local_pca(folder / "without", without), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "without"));
}

TEST(HalfNumbers, AreTheNearestOnes) {
  const std::pair<float, std::uint16_t> known[] = {
      {0.0F, 0x0000},    {1.0F, 0x3c00},       {-2.0F, 0xc000},      {65504.0F, 0x7bff},
      {0x1p-24F, 0x001}, {0x1.004p0F, 0x3c01}, {0x1.002p0F, 0x3c00},  // half-way: to the even one
      {0x1p-14F, 0x400}, {0x1.006p0F, 0x3c02}};
  for (const auto& [number, bits] : known) EXPECT_EQ(detail::to_half(number), bits) << number;
  for (std::uint32_t bits = 0; bits < 0x7c00; ++bits) {
    const auto half = static_cast<std::uint16_t>(bits);
    ASSERT_EQ(detail::to_half(detail::from_half(half)), half);
  }
}

}  // namespace
}  // namespace recede
