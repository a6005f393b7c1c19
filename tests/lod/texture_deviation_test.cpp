#include "meshes.h"
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/detail/texture_deviation.h>
#include <recede/lod/simplify.h>

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace recede {
namespace {

SimplifyOptions by_texture(double ratio) {
  SimplifyOptions options;
  options.cost = CostPolicy::texture_deviation;
  options.target.ratio = ratio;
  return options;
}

/// Texture coordinates from a function of the position.
template <typename Function>
void set_uvs(PolygonSoup& soup, Function&& uv_of) {
  soup.corner_uvs.clear();
  for (const Index v : soup.corner_vertices) soup.corner_uvs.push_back(uv_of(soup.positions[v]));
}

double signed_area(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

std::size_t flipped_triangles(const PolygonSoup& soup) {
  std::size_t flipped = 0;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const Vec2* const uv = soup.corner_uvs.data() + soup.face_offsets[f];
    flipped += signed_area(uv[0], uv[1], uv[2]) > 0 ? 0u : 1u;
  }
  return flipped;
}

/// The point of a mapped surface with these texture coordinates, if there is one.
std::optional<Vec3> lift(const std::vector<std::array<Vec3, 3>>& triangles,
                         const std::vector<std::array<Vec2, 3>>& uvs, const Vec2& at) {
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const double area = signed_area(uvs[t][0], uvs[t][1], uvs[t][2]);
    const double a = signed_area(at, uvs[t][1], uvs[t][2]) / area,
                 b = signed_area(uvs[t][0], at, uvs[t][2]) / area, c = 1 - a - b;
    if (a < 0 || b < 0 || c < 0) continue;
    return a * triangles[t][0] + b * triangles[t][1] + c * triangles[t][2];
  }
  return std::nullopt;
}

TEST(TextureDeviation, IsTheLargestDistanceBetweenPointsOfTheSameTexture) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  int measured = 0;
  for (int round = 0; round < 60; ++round) {
    // A star of n triangles around the origin, crooked in space.
    const Index n = 4 + static_cast<Index>(random() % 5);
    PolygonSoup soup;
    soup.positions.emplace_back(0.2 * unit(random), 0.2 * unit(random), unit(random));
    for (Index i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.3 * unit(random)) / n,
                   radius = 1 + 0.3 * unit(random);
      soup.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), unit(random));
    }
    for (Index i = 0; i < n; ++i) soup.add_face(std::vector<Index>{0, 1 + i, 1 + (i + 1) % n});
    std::vector<Vec2> uv;
    for (const Vec3& p : soup.positions) uv.push_back(p.head<2>());
    for (const Index v : soup.corner_vertices) soup.corner_uvs.push_back(uv[v]);
    const detail::CornerTable table = detail::build_corner_table(soup, {});
    Index removed = 0, kept = 0;
    for (Index p = 0; p < table.n_points(); ++p) {
      if (table.source_vertex[p] == 0) removed = p;
      if (table.source_vertex[p] == 1) kept = p;
    }
    detail::EdgeRings rings;
    rings.gather(table, removed, kept);
    detail::TextureDeviation deviation(table);
    const auto result = deviation.measure(rings.removed, removed, kept);
    std::vector<std::array<Vec3, 3>> before, after;
    std::vector<std::array<Vec2, 3>> before_uv, after_uv;
    bool flips = false;
    for (Index i = 0; i < n; ++i) {
      const Index a = 1 + i, b = 1 + (i + 1) % n;
      before.push_back({soup.positions[0], soup.positions[a], soup.positions[b]});
      before_uv.push_back({uv[0], uv[a], uv[b]});
      if (a == 1 || b == 1) continue;
      after.push_back({soup.positions[1], soup.positions[a], soup.positions[b]});
      after_uv.push_back({uv[1], uv[a], uv[b]});
      flips = flips || !(signed_area(uv[1], uv[a], uv[b]) > 0);
    }
    EXPECT_EQ(result.has_value(), !flips);
    if (!result) continue;
    ++measured;
    double sampled = 0;
    const auto look = [&](const Vec2& at) {
      const auto was = lift(before, before_uv, at), is = lift(after, after_uv, at);
      if (was && is) sampled = std::max(sampled, (*was - *is).norm() / table.scale);
    };
    look(uv[0]);
    for (int i = 0; i < 4000; ++i) look({1.3 * unit(random), 1.3 * unit(random)});
    EXPECT_LE(sampled, *result * (1 + 1e-9));
    EXPECT_GE(sampled, 0.8 * *result) << "samples come near the corner where it is found";
  }
  EXPECT_GT(measured, 20);
}

TEST(TextureDeviation, FlatSheetsKeepTheirTextureExactly) {
  PolygonSoup sheet = test::grid(16, true);
  set_uvs(sheet, [](const Vec3& p) { return Vec2(3 * p.x() + p.y(), 2 * p.y() - p.x()); });
  const SimplifySoupResult result = simplify(sheet, by_texture(0.004));
  EXPECT_EQ(result.faces_after, 2u);
  EXPECT_LT(*result.error_bound, 1e-12);
  for (std::size_t c = 0; c < result.soup.n_corners(); ++c) {
    const Vec3& p = result.soup.positions[result.soup.corner_vertices[c]];
    EXPECT_EQ(result.soup.corner_uvs[c], Vec2(3 * p.x() + p.y(), 2 * p.y() - p.x()));
  }
}

TEST(TextureDeviation, NothingTurnsOverInTheTextureAtAnyLevel) {
  const AtlasResult atlas = make_atlas(make_displaced_sphere(6000, true));
  ASSERT_EQ(flipped_triangles(atlas.soup), 0u);
  const std::array targets{SimplifyTarget{.ratio = 0.5}, SimplifyTarget{.ratio = 0.2},
                           SimplifyTarget{.ratio = 0.05}};
  for (const SimplifySoupResult& level : simplify_levels(atlas.soup, targets, by_texture(1))) {
    EXPECT_EQ(flipped_triangles(level.soup), 0u);
    EXPECT_LE(measure_distance(atlas.soup, level.soup).max, *level.error_bound);
  }
}

// On a closed surface without seams every edge may go by its place; half of all turn over in this texture.
TEST(TextureDeviation, CountsWhatItRefusesAsTurnedOver) {
  PolygonSoup ball = make_displaced_sphere(1000, true);
  set_uvs(ball, [](const Vec3& p) { return Vec2(p.x(), p.y()); });
  const SimplifySoupResult result = simplify(ball, by_texture(0.9));
  EXPECT_GT(result.refused[Refusal::flip], 0u);
  EXPECT_EQ(result.refused[Refusal::border], 0u);
}

TEST(TextureDeviation, ATextureThatSlidesCountsAndAVolumeDoesNot) {
  // A flat sheet with a bent texture: no shape is lost, but texture is.
  PolygonSoup sheet = test::grid(24, true);
  const auto bent = [](const Vec3& p) {
    return Vec2(p.x() + 0.3 * p.x() * p.y(), p.y() + 0.2 * p.x() * p.x());
  };
  set_uvs(sheet, bent);
  const auto error = [&](const SimplifyOptions& options) {
    const PolygonSoup coarse = simplify(sheet, options).soup;
    double largest = 0;
    for (std::size_t f = 0; f < coarse.n_faces(); ++f) {
      Vec3 middle = Vec3::Zero();
      Vec2 uv = Vec2::Zero();
      for (Index c = coarse.face_offsets[f]; c < coarse.face_offsets[f + 1]; ++c) {
        middle += coarse.positions[coarse.corner_vertices[c]] / 3;
        uv += coarse.corner_uvs[c] / 3;
      }
      largest = std::max(largest, (uv - bent(middle)).norm());
    }
    return largest;
  };
  SimplifyOptions blind = by_texture(0.05);
  blind.cost = CostPolicy::volume;
  blind.weights = {.uv = 0};
  EXPECT_LT(error(by_texture(0.05)), 0.5 * error(blind));
}

TEST(TextureDeviation, NeedsTextureCoordinatesTheirSeamsAndHalfEdges) {
  PolygonSoup sheet = test::grid(4, true);
  EXPECT_THROW(simplify(sheet, by_texture(0.5)), OptionError);
  set_uvs(sheet, [](const Vec3& p) { return Vec2(p.x(), p.y()); });
  SimplifyOptions options = by_texture(0.5);
  options.placement = VertexPlacement::midpoint;
  EXPECT_THROW(simplify(sheet, options), OptionError);
  options.placement = VertexPlacement::half_edge;
  options.keep_uv_seams = false;
  EXPECT_THROW(simplify(sheet, options), OptionError);
  options.keep_uv_seams = true;
  EXPECT_NO_THROW(simplify(sheet, options));
}

}  // namespace
}  // namespace recede
