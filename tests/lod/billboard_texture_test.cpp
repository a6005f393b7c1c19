#include "simple_soups.h"
#include "uv_ball.h"
#include <recede/geometry/error.h>
#include <recede/lod/billboard_mipmaps.h>
#include <recede/lod/detail/masked_area.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace recede {
namespace {

using test::soup_of;
using test::uv_ball;

BillboardCloud cloud_of(const PolygonSoup& model, double error, bool is_two_sided = false) {
  return build_billboard_clouds(model, {.errors = {error}, .is_two_sided = is_two_sided}).front();
}

PolygonSoup square() { return soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2, 3}}); }

// Of a texel in the atlas.
std::size_t texel_at(const BillboardTextures& textures, std::size_t billboard, int x, int y) {
  const BillboardPlace& place = textures.places[billboard];
  return static_cast<std::size_t>((place.y + y) * textures.color.width + place.x + x);
}

double opacity_of(const BillboardTextures& textures, std::size_t texel) {
  return textures.color.samples[4 * texel + 3] / 255.0;
}

// The place in space that a texel's middle stands for.
Vec3 place_of(const BillboardTextures& textures, std::size_t b, int x, int y) {
  const Billboard& billboard = textures.billboards[b];
  const BillboardPlace& place = textures.places[b];
  const double height = 2 * textures.height.samples[texel_at(textures, b, x, y)] / 255.0 - 1;
  return billboard.center + (2 * (x + 0.5) / place.width - 1) * billboard.half_sizes.x() * billboard.axis_u +
         (1 - 2 * (y + 0.5) / place.height) * billboard.half_sizes.y() * billboard.axis_v +
         height * textures.height_range * billboard.normal();
}

TEST(BillboardTextures, ShowASquareInItsColour) {
  PolygonSoup model = square();
  model.vertex_colors.assign(4, Vec4(1, 0.5, 0, 1));
  const BillboardTextures textures = texture_billboards(model, cloud_of(model, 0.1));
  ASSERT_EQ(textures.places.size(), 1u);
  EXPECT_EQ(textures.places[0].width, 10);
  EXPECT_EQ(textures.places[0].height, 10);
  EXPECT_EQ(textures.n_texels(), 100u);
  for (int y = 0; y < 10; ++y) {
    for (int x = 0; x < 10; ++x) {
      const std::size_t texel = texel_at(textures, 0, x, y);
      EXPECT_EQ(textures.color.samples[4 * texel], 255);
      EXPECT_EQ(textures.color.samples[4 * texel + 1], std::lround(255 * encode_srgb(0.5f)));
      EXPECT_EQ(textures.color.samples[4 * texel + 2], 0);
      EXPECT_EQ(textures.color.samples[4 * texel + 3], 255);
      EXPECT_EQ(textures.normal.samples[3 * texel], 128);
      EXPECT_EQ(textures.normal.samples[3 * texel + 1], 128);
      EXPECT_EQ(textures.normal.samples[3 * texel + 2], 255);
      EXPECT_EQ(textures.height.samples[texel], 128);
    }
  }
}

TEST(BillboardTextures, DrawAsMuchAsFacesCover) {
  // Half of their rectangle.
  const PolygonSoup model = soup_of({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  const BillboardTextures textures = texture_billboards(model, cloud_of(model, 0.05), {.samples = 8});
  const BillboardPlace& place = textures.places[0];
  std::vector<float> opacity;
  for (int y = 0; y < place.height; ++y) {
    for (int x = 0; x < place.width; ++x)
      opacity.push_back(static_cast<float>(opacity_of(textures, texel_at(textures, 0, x, y))));
  }
  const Billboard& billboard = textures.billboards[0];
  const double share = detail::masked_area(opacity, place.width, place.height) / (place.width * place.height);
  // Samples of bytes and of places within texels.
  EXPECT_NEAR(share * billboard.area(), 1, 0.01);
}

TEST(BillboardTextures, HoldThePlacesOfASurface) {
  const PolygonSoup model = uv_ball(40);
  const double error = 0.01;
  const BillboardTextures textures = texture_billboards(model, cloud_of(model, error));
  std::size_t n = 0;
  for (std::size_t b = 0; b < textures.billboards.size(); ++b) {
    for (int y = 0; y < textures.places[b].height; ++y) {
      for (int x = 0; x < textures.places[b].width; ++x) {
        if (opacity_of(textures, texel_at(textures, b, x, y)) < 0.99) continue;
        ++n;
        // Half a step of 8 bits, the mean over a texel of a surface that curves by less than its side, and
        // the ball's faces inside of it.
        EXPECT_NEAR(place_of(textures, b, x, y).norm(), 0.5, 0.25 * error);
      }
    }
  }
  EXPECT_GT(n, 10'000u);  // of 31 thousand squares of that side on the ball
}

TEST(BillboardTextures, ShowNeighboursBesideTheirOwnFaces) {
  // Two strips side by side in a plane, each a billboard of its own.
  const PolygonSoup model = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}},
                                    {{0, 1, 2}, {0, 2, 3}, {1, 4, 5, 2}});
  BillboardCloud cloud = build_billboard_clouds(model, {.errors = {0.1}}).front();
  ASSERT_EQ(cloud.billboards.size(), 1u);
  const Billboard whole = cloud.billboards[0];
  Billboard lower = whole, rest = whole;
  lower.faces = {0};
  rest.faces = {1, 2};
  cloud.billboards = {lower, rest};
  const auto drawn = [&](int overlap) {
    const BillboardTextures textures = texture_billboards(model, cloud, {.overlap = overlap});
    std::size_t n = 0;
    for (int y = 0; y < textures.places[0].height; ++y) {
      for (int x = 0; x < textures.places[0].width; ++x)
        if (opacity_of(textures, texel_at(textures, 0, x, y)) >= 0.5) ++n;
    }
    return n;
  };
  // Half of the first ten columns: those on the diagonal by halves, and beyond it what is near to them.
  EXPECT_NEAR(static_cast<double>(drawn(0)), 50, 6);
  // Each row ends two texels behind the last one that its diagonal runs through, also of rows two farther.
  EXPECT_NEAR(static_cast<double>(drawn(2)), 100, 8);
  EXPECT_EQ(drawn(100), 200u);
}

TEST(BillboardTextures, TurnNormalsToTheFront) {
  // A leaf that is seen from its back.
  PolygonSoup model = soup_of(
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1.2, 0, 0}, {2.2, 0, 0}, {2.2, 1, 0}, {1.2, 1, 0}},
      {{0, 1, 2, 3}, {4, 7, 6, 5}});
  const BillboardTextures textures = texture_billboards(model, cloud_of(model, 0.1, true));
  ASSERT_EQ(textures.places.size(), 1u);
  for (std::size_t texel = 0; texel < textures.height.samples.size(); ++texel)
    EXPECT_EQ(textures.normal.samples[3 * texel + 2], 255);
}

TEST(BillboardTextures, StandApartInTheirAtlas) {
  const PolygonSoup model = uv_ball(20);
  const BillboardTextures textures = texture_billboards(model, cloud_of(model, 0.01), {.gutter = 2});
  std::vector<int> owners(textures.height.samples.size(), 0);
  std::size_t n = 0;
  for (const BillboardPlace& place : textures.places) {
    ASSERT_LE(place.x + place.width, textures.color.width);
    ASSERT_LE(place.y + place.height, textures.color.height);
    for (int y = place.y; y < std::min(place.y + place.height + 2, textures.color.height); ++y) {
      for (int x = place.x; x < std::min(place.x + place.width + 2, textures.color.width); ++x) {
        const auto texel = static_cast<std::size_t>(y * textures.color.width + x);
        EXPECT_EQ(owners[texel]++, 0);
      }
    }
    n += static_cast<std::size_t>(place.width * place.height);
  }
  EXPECT_EQ(n, textures.n_texels());
  EXPECT_NEAR(textures.packed, static_cast<double>(n) / static_cast<double>(owners.size()), 1e-12);
}

TEST(BillboardTextures, AreTheSameWithOneThread) {
  const PolygonSoup model = uv_ball(20);
  const BillboardCloud cloud = cloud_of(model, 0.02);
  const BillboardTextures many = texture_billboards(model, cloud);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const BillboardTextures few = texture_billboards(model, cloud);
  EXPECT_EQ(many.color, few.color);
  EXPECT_EQ(many.normal, few.normal);
  EXPECT_EQ(many.height, few.height);
}

TEST(BillboardTextures, HaveSmallerVersionsOfTheSameArea) {
  const PolygonSoup model = uv_ball(40);
  const BillboardTextures textures = texture_billboards(model, cloud_of(model, 0.003));
  const auto share = [](const Raster& color) {
    std::vector<float> opacity;
    for (std::size_t i = 3; i < color.samples.size(); i += 4)
      opacity.push_back(static_cast<float>(color.samples[i]) / 255);
    return detail::masked_area(opacity, color.width, color.height) / (color.width * color.height);
  };
  const double drawn = share(textures.color);
  const std::vector<BillboardMipmap> mipmaps = billboard_mipmaps(textures, 6);
  ASSERT_EQ(mipmaps.size(), 6u);
  for (std::size_t k = 0; k < mipmaps.size(); ++k) {
    const BillboardMipmap& mipmap = mipmaps[k];
    EXPECT_EQ(mipmap.color.width, textures.color.width >> (k + 1));
    EXPECT_EQ(mipmap.normal.width, mipmap.color.width);
    EXPECT_EQ(mipmap.height.height, mipmap.color.height);
    EXPECT_NEAR(share(mipmap.color) / drawn, 1, 0.01) << "level " << k + 1;
  }
}

TEST(BillboardTextures, MipmapsEndWithATexel) {
  const PolygonSoup model = square();
  const std::vector<BillboardMipmap> mipmaps =
      billboard_mipmaps(texture_billboards(model, cloud_of(model, 0.25)), 20);
  ASSERT_FALSE(mipmaps.empty());
  EXPECT_EQ(mipmaps.back().color.width, 1);
  EXPECT_EQ(mipmaps.back().color.height, 1);
  EXPECT_TRUE(billboard_mipmaps(texture_billboards(model, cloud_of(model, 0.25)), 0).empty());
}

TEST(BillboardTextures, BecomeRectanglesWithTextureCoordinates) {
  const PolygonSoup model = uv_ball(20);
  const BillboardTextures textures = texture_billboards(model, cloud_of(model, 0.02));
  const PolygonSoup quads = quads_of(textures);
  ASSERT_EQ(quads.n_faces(), textures.billboards.size());
  for (std::size_t b = 0; b < textures.billboards.size(); ++b) {
    const Billboard& billboard = textures.billboards[b];
    const Vec3 area = vector_area(quads, b);
    EXPECT_NEAR(area.norm(), billboard.area(), 1e-12);
    EXPECT_NEAR(area.normalized().dot(billboard.normal()), 1, 1e-12);
    // Rows run along its first axis, downwards.
    const BillboardPlace& place = textures.places[b];
    const Vec2 lower_left = quads.corner_uvs[4 * b];
    EXPECT_NEAR(lower_left.x() * textures.color.width, place.x, 1e-9);
    EXPECT_NEAR((1 - lower_left.y()) * textures.color.height, place.y + place.height, 1e-9);
  }
}

TEST(BillboardTextures, AreNotPlacedOnOtherQuadsThanRectangles) {
  const PolygonSoup model = uv_ball(20);
  BillboardTextures textures = texture_billboards(model, cloud_of(model, 0.02));
  PolygonSoup quads = quads_of(textures);
  textures.billboards.clear();
  textures.places.clear();
  EXPECT_TRUE(place_billboards(quads, textures));
  // Still a right angle at the first corner.
  quads.positions[2] += 0.1 * (quads.positions[2] - quads.positions[0]);
  EXPECT_FALSE(place_billboards(quads, textures));
}

TEST(BillboardTextures, RefuseWhatHasNoMeaning) {
  const PolygonSoup model = square();
  const BillboardCloud cloud = cloud_of(model, 0.1);
  EXPECT_THROW(texture_billboards(model, cloud, {.texels_per_error = 0}), OptionError);
  EXPECT_THROW(texture_billboards(model, cloud, {.samples = 0}), OptionError);
  EXPECT_THROW(texture_billboards(model, cloud, {.overlap = -1}), OptionError);
  EXPECT_THROW(texture_billboards(model, cloud, {.gutter = -1}), OptionError);
  EXPECT_THROW(texture_billboards(model, cloud_of(model, 1e-6)), OptionError);  // 10^12 texels
}

TEST(MaskedArea, IsWhereOpacityIsAHalfAndMore) {
  EXPECT_EQ(detail::masked_area({1, 1, 1, 1}, 2, 2), 4);
  EXPECT_EQ(detail::masked_area({0, 0, 0, 0}, 2, 2), 0);
  // Bilinear, so that it ends half-way between the middles.
  // At places of which there are 16 along a side.
  EXPECT_NEAR(detail::masked_area({1, 0}, 2, 1), 1, 1.0 / 16);
  EXPECT_NEAR(detail::masked_area({1, 1, 0, 0}, 4, 1), 2, 1.0 / 16);
}

TEST(MaskedArea, IsKeptForThinParts) {
  // A line a tenth as wide as a texel covers a tenth of each that it runs through.
  std::vector<float> opacity(400, 0.0f);
  for (std::size_t i = 0; i < 20; ++i) opacity[20 * i + 7] = 0.1f + 0.001f * static_cast<float>(i % 5);
  detail::keep_thin_parts(opacity, 20, 20);
  double sum = 0;
  for (std::size_t i = 0; i < 20; ++i) sum += 0.1 + 0.001 * static_cast<double>(i % 5);
  EXPECT_NEAR(detail::masked_area(opacity, 20, 20), sum, 0.05);
}

}  // namespace
}  // namespace recede
