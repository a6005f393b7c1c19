#include "meshes.h"
#include "pictures.h"
#include <recede/geometry/displacement_map.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/detail/map_seams.h>
#include <recede/lod/detail/map_texels.h>
#include <recede/lod/displacement_bake.h>
#include <recede/lod/simplify.h>

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <random>

namespace recede::test {
namespace {

/// The unit square as one quad with texture coordinates (x, y), or (1 - x, y).
PolygonSoup square(bool mirrored = false) {
  PolygonSoup soup = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2, 3}});
  for (const Vec3& p : soup.positions) soup.corner_uvs.emplace_back(mirrored ? 1 - p.x() : p.x(), p.y());
  return soup;
}

/// A height field over the unit square and a little more.
template <typename Height>
PolygonSoup field(Index n, const Height& height) {
  PolygonSoup soup = grid(n, true);
  for (Vec3& p : soup.positions) {
    p = 1.2 * p - Vec3(0.1, 0.1, 0);
    p.z() = height(p.x(), p.y());
  }
  return soup;
}

Vec3 mapped_normal(const BakedMaps& maps, const Vec2& uv, const Vec3& tangent, double sign) {
  const Vec3 n = maps.normal_at(uv);
  return n.x() * tangent + n.y() * sign * Vec3::UnitZ().cross(tangent) + n.z() * Vec3::UnitZ();
}

TEST(DisplacementBake, APlaneAtAConstantDistanceGivesThatHeightEverywhere) {
  for (const double distance : {0.25, -0.125}) {
    const BakedMaps maps =
        bake_maps(field(4, [&](double, double) { return distance; }), square(), {.size = 16});
    EXPECT_EQ(maps.report.atlas_reason, "");
    EXPECT_EQ(maps.report.texels, 256u);
    EXPECT_EQ(maps.report.missed, 0u);
    EXPECT_EQ(maps.report.seam_edges, 0u);
    for (const double u : {0.0, 0.013, 0.5, 1.0}) EXPECT_NEAR(maps.height_at({u, 0.7}), distance, 1e-12);
    EXPECT_NEAR(maps.height_offset, distance, 1e-12);
    for (std::size_t i = 0; i < maps.normal.samples.size(); ++i)
      ASSERT_EQ(maps.normal.samples[i], i % 3 == 2 ? 255 : 128);
  }
}

TEST(DisplacementBake, FloatsHaveNoStepsAndAreWhatLookupsRead) {
  // Heights that 16 bits can't tell apart beside the slope of 1000 to 1.
  const auto height = [](double x, double y) { return (x < 0.5 ? 0.0 : 2 * (x - 0.5)) + 1e-6 * y; };
  MapOptions options{.size = 8, .search_distance = 2.0};
  const BakedMaps whole = bake_maps(field(96, height), square(), options);
  EXPECT_TRUE(whole.float_displacement.samples.empty() && whole.float_normal.samples.empty());
  options.format = MapFormat::exr;
  const BakedMaps floats = bake_maps(field(96, height), square(), options);
  EXPECT_EQ(floats.displacement, whole.displacement) << "the PNG file is the same";
  EXPECT_EQ(floats.normal, whole.normal);
  EXPECT_EQ(floats.float_displacement.channels, std::vector<std::string>{"Y"});
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 4; ++x) {
      const double expected = height((x + 0.5) / 8, 1 - (y + 0.5) / 8);
      EXPECT_NEAR(floats.float_displacement.at(x, y), expected, 1e-12) << "floats near 1e-6 keep 1e-13";
      EXPECT_EQ(whole.displacement.at(x, y), 0);
    }
  }
  EXPECT_NEAR(floats.height_at({0.25, 0.75}), 0.75e-6, 1e-12);
  EXPECT_GT(std::abs(whole.height_at({0.25, 0.75}) - 0.75e-6), 1e-7);
  // 0 of a normal lies between two of 8 bits.
  EXPECT_EQ(floats.float_normal.at(2, 2, 0), 0.5f);
  EXPECT_LT((floats.normal_at({0.25, 0.75}) - Vec3(0, -1e-6, 1)).norm(), 1e-7);
  EXPECT_GT((whole.normal_at({0.25, 0.75}) - Vec3(0, -1e-6, 1)).norm(), 1e-3);
}

TEST(DisplacementBake, TexelsStandAtTheirMiddlesAndRowsRunDownwards) {
  const auto height = [](double x, double y) { return 0.1 * x + 0.03 * y; };
  const BakedMaps maps = bake_maps(field(3, height), square(), {.size = 8, .normal_bits = 16});
  const double step = maps.height_scale / 65535;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) {
      const double expected = height((x + 0.5) / 8, 1 - (y + 0.5) / 8);
      EXPECT_NEAR(maps.height_offset + step * maps.displacement.at(x, y), expected, 0.51 * step);
    }
  }
  const Vec3 expected = Vec3(-0.1, -0.03, 1).normalized();
  EXPECT_LT((maps.normal_at({0.4, 0.6}) - expected).norm(), 1e-4) << "x along u, y upwards";
}

TEST(DisplacementBake, HeightsAndNormalsOfAParaboloidAreThoseOfItsFormula) {
  const auto height = [](double x, double y) { return 0.2 * (x * x + y * y); };
  const BakedMaps maps = bake_maps(field(96, height), square(), {.size = 128, .search_distance = 1.0});
  for (const double u : {0.1, 0.37, 0.5, 0.93}) {
    for (const double v : {0.2, 0.61, 0.8}) {
      EXPECT_NEAR(maps.height_at({u, v}), height(u, v), 1e-4);
      const Vec3 expected = Vec3(-0.4 * u, -0.4 * v, 1).normalized();
      EXPECT_LT((mapped_normal(maps, {u, v}, Vec3::UnitX(), 1) - expected).norm(), 0.01);
    }
  }
}

TEST(DisplacementBake, AMapOfTheSamplesHasTheSameHeights) {
  const auto height = [](double x, double y) { return 0.1 * x * x - 0.2 * y; };
  const BakedMaps maps = bake_maps(field(16, height), square(), {.size = 24});
  const DisplacementMap map(maps.displacement, maps.height_scale, maps.height_offset);
  for (const double u : {0.0, 0.013, 0.47, 0.9, 1.0}) {
    for (const double v : {0.0, 0.21, 0.5, 0.99, 1.0}) {
      EXPECT_NEAR(map.height_at({u, v}), maps.height_at({u, v}), 1e-15);  // roundings of heights up to 0.2
    }
  }
}

TEST(DisplacementBake, MirroredTextureCoordinatesServeAndGiveTheSameNormals) {
  const auto height = [](double x, double y) { return 0.2 * x - 0.1 * y; };
  const BakedMaps maps = bake_maps(field(3, height), square(true), {.size = 32, .normal_bits = 16});
  EXPECT_EQ(maps.report.atlas_reason, "");
  for (const Vec4& tangent : maps.corner_tangents) EXPECT_LT((tangent - Vec4(-1, 0, 0, -1)).norm(), 1e-12);
  EXPECT_NEAR(maps.height_at({0.25, 0.5}), height(0.75, 0.5), 1e-4);
  const Vec3 expected = Vec3(-0.2, 0.1, 1).normalized();
  EXPECT_LT((mapped_normal(maps, {0.3, 0.3}, -Vec3::UnitX(), -1) - expected).norm(), 1e-4);
}

TEST(DisplacementBake, TextureCoordinatesThatAreNotOneToOneMakeWayForAnAtlas) {
  const PolygonSoup fine = field(3, [](double, double) { return 0.1; });
  const auto reason = [&](const std::vector<Vec2>& uvs) {
    PolygonSoup coarse = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
    coarse.corner_uvs = uvs;
    const BakedMaps maps = bake_maps(fine, coarse, {.size = 32});
    EXPECT_TRUE(maps.report.atlas_reason.empty() == (maps.surface.corner_uvs == uvs));
    EXPECT_NEAR(maps.height_at(maps.surface.corner_uvs[0]), 0.1, 1e-9);
    return maps.report.atlas_reason;
  };
  const Vec2 a(0, 0), b(1, 0), c(1, 1), d(0, 1);
  EXPECT_EQ(reason({a, b, c, a, c, d}), "");
  EXPECT_EQ(reason({}), "no texture coordinates");
  EXPECT_EQ(reason({a, b, c, a, c, 2 * d}), "outside the unit square");
  EXPECT_EQ(reason({a, b, c, a, c, 0.5 * c}), "triangles without area");
  EXPECT_EQ(reason({a, b, c, a, b, c}), "triangles overlap");
  EXPECT_EQ(reason({a, b, c, a, c, Vec2(0.9, 0.8)}), "triangles overlap");
}

TEST(DisplacementBake, TheNearestSideThatFacesAlongTheNormalCounts) {
  PolygonSoup layers = field(2, [](double, double) { return 0.3; });
  const PolygonSoup back = field(2, [](double, double) { return 0.1; });
  const PolygonSoup far = field(2, [](double, double) { return -0.6; });
  const auto add = [&](const PolygonSoup& other, bool reversed) {
    const auto first = static_cast<Index>(layers.positions.size());
    layers.positions.insert(layers.positions.end(), other.positions.begin(), other.positions.end());
    for (std::size_t f = 0; f < other.n_faces(); ++f) {
      std::vector<Index> face(other.face(f).begin(), other.face(f).end());
      for (Index& vertex : face) vertex += first;
      if (reversed) std::reverse(face.begin(), face.end());
      layers.add_face(face);
    }
  };
  add(back, true);
  add(far, false);
  const BakedMaps maps = bake_maps(layers, square(), {.size = 8, .search_distance = 1.0});
  EXPECT_NEAR(maps.height_at({0.5, 0.5}), 0.3, 1e-12);
  EXPECT_EQ(maps.report.missed, 0u);
}

TEST(DisplacementBake, TheClosestPointTakesOverWhereTheLineMissesAndIsCounted) {
  PolygonSoup fine = grid(2, true);
  for (Vec3& p : fine.positions) p = Vec3(0.5 * p.x(), p.y(), 0.2);
  const BakedMaps maps = bake_maps(fine, square(), {.size = 16, .search_distance = 1.0});
  EXPECT_EQ(maps.report.texels, 256u);
  EXPECT_EQ(maps.report.missed, 128u);
  EXPECT_NEAR(maps.height_at({0.9, 0.5}), 0.2, 1e-12) << "along the normal, however far the point lies";
  const BakedMaps near = bake_maps(fine, square(), {.size = 16, .search_distance = 0.1});
  EXPECT_EQ(near.report.missed, 256u);
}

TEST(DisplacementBake, ColoursAreThoseOfTheFineVerticesTimesTheMaterialsInSrgb) {
  PolygonSoup fine = field(2, [](double, double) { return 0.1; });
  EXPECT_TRUE(bake_maps(fine, square(), {.size = 8}).color.samples.empty()) << "nothing to bake";
  for (const Vec3& p : fine.positions)
    fine.vertex_colors.emplace_back(std::clamp(p.x(), 0.0, 1.0), 0.5, 1, 1);
  fine.materials = {{"half", {1, 1, 0.5, 1}, ""}};
  fine.face_materials.assign(fine.n_faces(), 0);
  const BakedMaps maps = bake_maps(fine, square(), {.displacement = false, .normal = false, .size = 16});
  EXPECT_TRUE(maps.displacement.samples.empty() && maps.normal.samples.empty());
  EXPECT_TRUE(maps.color.srgb);
  EXPECT_EQ(maps.color.at(8, 4, 1), 188) << "0.5 by the transfer function";
  EXPECT_EQ(maps.color.at(8, 4, 2), 188);
  EXPECT_LT(maps.color.at(2, 4, 0), maps.color.at(12, 4, 0));
}

TEST(DisplacementBake, ColoursOfTexturesAreThoseOfTheirPlacesAndNewAtlasesHaveNone) {
  PolygonSoup fine = field(4, [](double, double) { return 0.1; });
  for (const Index v : fine.corner_vertices) fine.corner_uvs.push_back(fine.positions[v].head<2>());
  fine.materials = {{"half blue", {1, 1, 0.5, 1}, "skin.png"}};
  fine.materials[0].base_color_picture = png_of(four_quarters());
  fine.face_materials.assign(fine.n_faces(), 0);
  PolygonSoup coarse = square();
  coarse.materials = fine.materials;
  coarse.face_materials = {0};
  const BakedMaps maps = bake_maps(fine, coarse, {.displacement = false, .normal = false, .size = 32});
  const auto color = [&](int x, int y) {
    return std::array{maps.color.at(x, y, 0), maps.color.at(x, y, 1), maps.color.at(x, y, 2)};
  };
  using Color = std::array<std::uint16_t, 3>;
  EXPECT_EQ(color(8, 8), (Color{255, 0, 0}));
  EXPECT_EQ(color(24, 8), (Color{0, 255, 0}));
  EXPECT_EQ(color(8, 24), (Color{0, 0, 188})) << "times the material's colour";
  EXPECT_EQ(color(24, 24), (Color{255, 255, 188}));
  EXPECT_EQ(maps.surface.materials, coarse.materials) << "its own texture coordinates serve";
  // A picture of fine lines is averaged where texels of the map are wider.
  std::vector<std::array<std::uint16_t, 3>> lines;
  for (std::uint16_t i = 0; i < 256; ++i) lines.push_back(i % 2 == 0 ? Color{0, 0, 0} : Color{255, 255, 255});
  fine.materials[0] = {"lines", Vec4::Ones(), "lines.png"};
  fine.materials[0].base_color_picture = png_of(raster_of(256, 1, lines));
  const BakedMaps grey = bake_maps(fine, coarse, {.displacement = false, .normal = false, .size = 8});
  for (const std::uint16_t sample : grey.color.samples) ASSERT_NEAR(sample, 188, 1) << "rounded twice";
  coarse.corner_uvs.assign(coarse.n_corners(), Vec2::Zero());
  const BakedMaps anew = bake_maps(fine, coarse, {.displacement = false, .color = false, .size = 8});
  EXPECT_EQ(anew.surface.materials[0].base_color_texture, "");
  EXPECT_FALSE(anew.surface.materials[0].base_color_picture);
}

TEST(DisplacementBake, DicedSurfacesHaveTheColoursOfTheMapOrElseOfTheCoarseSurface) {
  PolygonSoup coarse = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  for (const Index v : coarse.corner_vertices) coarse.corner_uvs.push_back(coarse.positions[v].head<2>());
  coarse.materials = {{"a", {1, 0, 0, 1}, ""}, {"b", {0, 1, 0, 1}, ""}};
  coarse.face_materials = {1, k_no_index};
  for (const Vec3& p : coarse.positions) coarse.vertex_colors.emplace_back(p.x(), p.y(), 0.5, 1);
  const BakedMaps without = bake_maps(coarse, coarse, {.normal = false, .color = false, .size = 8});
  const PolygonSoup diced = dice_surface(without, {.parts = 3});
  EXPECT_NO_THROW(validate(diced, "diced"));
  EXPECT_EQ(diced.materials, coarse.materials);
  for (std::size_t f = 0; f < 18; ++f) EXPECT_EQ(diced.face_materials[f], f < 9 ? 1u : k_no_index);
  for (std::size_t v = 0; v < diced.positions.size(); ++v) {
    const Vec3& p = diced.positions[v];
    EXPECT_LT((diced.vertex_colors[v] - Vec4(p.x(), p.y(), 0.5, 1)).norm(), 1e-12) << "rounding";
  }
  const BakedMaps with = bake_maps(coarse, coarse, {.normal = false, .size = 8});
  const PolygonSoup textured = dice_surface(with, {.parts = 3});
  EXPECT_NO_THROW(validate(textured, "diced"));
  ASSERT_EQ(textured.materials.size(), 1u);
  EXPECT_EQ(textured.materials[0].base_color, Vec4::Ones());
  EXPECT_EQ(decode_png(*textured.materials[0].base_color_picture, "color").samples, with.color.samples);
  EXPECT_TRUE(textured.vertex_colors.empty());
}

TEST(DisplacementBake, PolygonsOfAnySizeStandForTheirTriangles) {
  const PolygonSoup fine = prism(8);
  const BakedMaps maps = bake_maps(fine, fine, {.size = 256, .search_distance = 0.1});
  EXPECT_EQ(maps.report.missed, 0u);
  EXPECT_EQ(maps.report.atlas_reason, "no texture coordinates");
  EXPECT_GT(maps.report.seam_edges, 0u);
  const PolygonSoup diced = dice_surface(maps, {.parts = 8});
  EXPECT_EQ(diced.n_faces(), 64u * triangulate(fine).size() / 3);
  EXPECT_LT(measure_distance(fine, diced).max, 1e-12) << "a surface over itself, up to rounding";
}

/// Largest difference across edges that are apart in the atlas, by an evaluator of its own at 64 places each.
double difference_across_seams(const BakedMaps& maps) {
  const auto texel = [&](double x, double y) {
    const auto in_map = [&](double value) { return std::clamp(static_cast<int>(value), 0, maps.size - 1); };
    return maps.displacement.at(in_map(x), in_map(y)) / 65535.0 * maps.height_scale + maps.height_offset;
  };
  const auto height = [&](const Vec2& uv) {
    const double x = uv.x() * maps.size - 0.5, y = (1 - uv.y()) * maps.size - 0.5;
    const double left = std::floor(x), top = std::floor(y);
    const double upper = std::lerp(texel(left, top), texel(left + 1, top), x - left);
    const double lower = std::lerp(texel(left, top + 1), texel(left + 1, top + 1), x - left);
    return std::lerp(upper, lower, y - top);
  };
  std::map<std::pair<Index, Index>, std::vector<std::pair<Vec2, Vec2>>> sides;
  const PolygonSoup& soup = maps.surface;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    for (Index i = 0; i < soup.face_size(f); ++i) {
      Index a = soup.face_offsets[f] + i,
            b = soup.face_offsets[f] + (i + 1) % static_cast<Index>(soup.face_size(f));
      if (soup.corner_vertices[a] > soup.corner_vertices[b]) std::swap(a, b);
      sides[{soup.corner_vertices[a], soup.corner_vertices[b]}].emplace_back(soup.corner_uvs[a],
                                                                             soup.corner_uvs[b]);
    }
  }
  double largest = 0;
  for (const auto& [edge, uvs] : sides) {
    for (std::size_t s = 1; s < uvs.size(); ++s) {
      for (int i = 0; i <= 64; ++i) {
        const double t = i / 64.0;
        largest = std::max(largest, std::abs(height(uvs[0].first + t * (uvs[0].second - uvs[0].first)) -
                                             height(uvs[s].first + t * (uvs[s].second - uvs[s].first))));
      }
    }
  }
  return largest;
}

SimplifySoupResult simplified(const PolygonSoup& fine, double ratio) {
  SimplifyOptions options;
  options.target.ratio = ratio;
  return simplify(fine, options);
}

TEST(DisplacementBake, BothSidesOfEverySeamAgree) {
  const PolygonSoup fine = make_displaced_sphere(20000, true);
  const PolygonSoup coarse = simplified(fine, 0.02).soup;
  const BakedMaps maps = bake_maps(fine, coarse, {.normal = false, .size = 512});
  EXPECT_GT(maps.report.seam_edges, 20u);
  EXPECT_EQ(maps.report.missed, 0u);
  const double measured = difference_across_seams(maps);
  EXPECT_LE(measured, maps.report.seam_difference * (1 + 1e-9))
      << "the report is exact, so nothing exceeds it";
  EXPECT_GT(measured, 0.3 * maps.report.seam_difference);
  EXPECT_LE(maps.report.seam_difference, maps.height_scale / 65535) << "a step of the map";
  EXPECT_GT(maps.report.seam_difference_before, 100 * maps.height_scale / 65535);
}

TEST(DisplacementBake, ASeamWeightKeepsMoreOfTheHeightsAndClosesLess) {
  const PolygonSoup fine = make_displaced_sphere(20000, true);
  const PolygonSoup coarse = simplified(fine, 0.02).soup;
  const auto bake = [&](std::optional<double> weight) {
    return bake_maps(fine, coarse, {.normal = false, .size = 256, .seam_weight = weight});
  };
  const BakedMaps open = bake(0), soft = bake(1e4), closed = bake({});
  EXPECT_EQ(open.report.seam_difference_before, closed.report.seam_difference_before);
  // Rounding moves each side by half a step.
  EXPECT_NEAR(open.report.seam_difference, open.report.seam_difference_before, open.height_scale / 65535);
  EXPECT_LT(soft.report.seam_difference, 0.1 * open.report.seam_difference);
  EXPECT_LT(closed.report.seam_difference, 0.1 * soft.report.seam_difference);
  const double open_rms = measure_maps(fine, open).rms, closed_rms = measure_maps(fine, closed).rms;
  EXPECT_LT(open_rms, measure_maps(fine, soft).rms);
  EXPECT_LT(measure_maps(fine, soft).rms, closed_rms);
  EXPECT_LT(closed_rms, 2 * open_rms) << "1.6 was measured";
}

/// Two sides of one edge in a map of 16 texels, far from each other and at different angles.
std::vector<detail::Seam> slanted_seam() {
  return {{{Vec2(0.12, 0.15), Vec2(0.33, 0.81)}, {Vec2(0.61, 0.2), Vec2(0.93, 0.83)}}};
}

TEST(DisplacementBake, SamplesAreRepairedByFewUnits) {
  std::mt19937 random(5);
  for (int round = 0; round < 50; ++round) {
    std::vector<std::uint16_t> samples(256);
    // Differences of up to 4 units; the lowest and highest samples can't go any further.
    for (std::uint16_t& sample : samples)
      sample = static_cast<std::uint16_t>((round % 2 == 0 ? 0 : 65535 - 4) + random() % 5);
    const std::vector<std::uint16_t> before = samples;
    const auto difference = [&](const std::vector<std::uint16_t>& map) {
      return detail::largest_difference(slanted_seam(), 16, [&](Index texel) { return double(map[texel]); });
    };
    EXPECT_GT(difference(before), 1);
    detail::repair_samples(slanted_seam(), 16, samples);
    EXPECT_LE(difference(samples), 1);
    for (std::size_t i = 0; i < samples.size(); ++i)
      EXPECT_LE(std::abs(samples[i] - before[i]), 2 * 4) << "twice the spread";
  }
}

TEST(DisplacementBake, ClosingAlongASeamReachesTheToleranceAndLeavesTheRest) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> height(-1, 1);
  std::vector<double> heights(256);
  for (double& value : heights) value = height(random);
  const std::vector<double> before = heights, costs(256, 1.0);
  const auto difference = [&] {
    return detail::largest_difference(slanted_seam(), 16, [&](Index texel) { return heights[texel]; });
  };
  constexpr double k_tolerance = 1e-4;
  detail::close_seams_within(slanted_seam(), 16, k_tolerance, costs, heights);
  EXPECT_LE(difference(), 1.5 * k_tolerance) << "1.2 at the places compared, and a quadratic between them";
  EXPECT_GT(difference(), 0.1 * k_tolerance) << "no more is given up than needed";
  EXPECT_EQ(heights[0], before[0]);
  EXPECT_EQ(heights[8], before[8]);
  // Heights that agree stay: a constant everywhere.
  heights.assign(256, 0.3);
  detail::close_seams_within(slanted_seam(), 16, k_tolerance, costs, heights);
  for (const double value : heights) EXPECT_NEAR(value, 0.3, 1e-12);
}

TEST(DisplacementBake, MapsBringACoarseSurfaceTenTimesNearer) {
  const PolygonSoup fine = make_displaced_sphere(20000, true);
  const BakedMaps maps = bake_maps(fine, simplified(fine, 0.02).soup, {.size = 512, .seam_weight = 1e4});
  const MapAccuracy accuracy = measure_maps(fine, maps);
  EXPECT_LT(accuracy.rms, 0.1 * accuracy.bare_rms);
  EXPECT_LT(accuracy.max, 0.5 * accuracy.bare_max);
}

TEST(DisplacementBake, TheBunnysMapsAreNearAndTheirSeamsClosed) {
  const std::filesystem::path path = std::filesystem::path(RECEDE_DATA) / "meshes/bunny00.off";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "./dev data fetches the models";
  PolygonSoup fine = read_soup(path);
  merge_identical_vertices(fine);
  const SimplifySoupResult coarse = simplified(fine, 0.02);
  const BakedMaps maps = bake_maps(fine, coarse.soup, {.search_distance = 2 * coarse.error_bound.value()});
  EXPECT_LT(maps.report.missed, maps.report.texels / 1000);
  EXPECT_LE(maps.report.seam_difference, maps.height_scale / 65535) << "a step of the map";
  const MapAccuracy accuracy = measure_maps(fine, maps);
  EXPECT_LT(accuracy.rms, 0.1 * accuracy.bare_rms);
}

TEST(DisplacementBake, NormalsOfTheMapAreThoseOfTheFineSurfaceAcrossSeams) {
  PolygonSoup fine = make_displaced_sphere(20000, true);
  const PolygonSoup coarse = simplified(fine, 0.05).soup;
  for (const Index v : fine.corner_vertices) fine.corner_normals.push_back(fine.positions[v].normalized());
  const BakedMaps maps = bake_maps(fine, coarse, {.size = 512});
  const PolygonSoup diced = dice_surface(maps, {.parts = 6});
  std::vector<double> differences;
  for (std::size_t c = 0; c < diced.n_corners(); ++c) {
    const Vec3 expected = diced.positions[diced.corner_vertices[c]].normalized();
    differences.push_back((diced.corner_normals[c] - expected).norm());
  }
  // A wrong frame or a seam would be off by tenths in many places. Points of triangles about as thin as a
  // texel are so singly.
  std::sort(differences.begin(), differences.end());
  EXPECT_LT(differences[differences.size() * 99 / 100], 0.01);
}

TEST(DisplacementBake, TakesSurfacesThatAreNoManifoldsOrHaveFacesWithoutArea) {
  const PolygonSoup fan = soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0.5}, {0, 0, 1}},
                                  {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}, {0, 0, 1}, {0, 1, 1}});
  const PolygonSoup sheet = soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}});
  PolygonSoup apart = grid(3, true);  // every face by itself
  for (Index& vertex : apart.corner_vertices) {
    apart.positions.push_back(apart.positions[vertex]);
    vertex = static_cast<Index>(apart.positions.size() - 1);
  }
  for (const PolygonSoup& soup : {fan, sheet, apart}) {
    const BakedMaps maps = bake_maps(soup, soup, {.size = 64});
    // Surfaces over themselves, up to rounding.
    EXPECT_LT(std::abs(maps.height_offset) + std::abs(maps.height_scale), 1e-12);
    for (const Vec3& normal : maps.surface.corner_normals) EXPECT_NEAR(normal.norm(), 1, 1e-12);
    for (const Vec4& tangent : maps.corner_tangents) EXPECT_NEAR(tangent.head<3>().norm(), 1, 1e-12);
    for (const Vec3& p : dice_surface(maps).positions) ASSERT_TRUE(p.allFinite());
  }
  EXPECT_EQ(bake_maps(apart, apart, {.size = 64}).report.seam_edges, 0u) << "one chart";
}

TEST(DisplacementBake, GivesTheSameBytesForAnyNumberOfThreads) {
  PolygonSoup fine = make_displaced_sphere(5000, true);
  for (const Vec3& p : fine.positions) fine.vertex_colors.emplace_back(p.x() * p.x(), p.y() * p.y(), 0.5, 1);
  const PolygonSoup coarse = simplified(fine, 0.05).soup;
  const auto bake = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return bake_maps(fine, coarse, {.size = 200});
  };
  const BakedMaps one = bake(1), several = bake(4);
  EXPECT_TRUE(one.displacement == several.displacement && one.normal == several.normal &&
              one.color == several.color);
  EXPECT_EQ(one.height_scale, several.height_scale);
  EXPECT_EQ(one.surface.corner_uvs, several.surface.corner_uvs);
  EXPECT_EQ(one.corner_tangents, several.corner_tangents);
}

TEST(DisplacementBake, HolesAreFilledWithoutChangingMeansOfSmallerMaps) {
  std::vector<double> values{1, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8};
  std::vector<char> known(16, 0);
  known[0] = known[4] = known[15] = 1;
  detail::fill_holes(values, known, 4, 4);
  EXPECT_THAT(values, testing::ElementsAre(1, 2, 5, 5, 3, 2, 5, 5, 5, 5, 8, 8, 5, 5, 8, 8));
}

TEST(DisplacementBake, RefusesOptionsOutOfRangeAndSurfacesWithoutFaces) {
  const PolygonSoup soup = square();
  EXPECT_THROW(bake_maps(soup, soup, {.displacement = false, .normal = false, .color = false}), OptionError);
  EXPECT_THROW(bake_maps(soup, soup, {.size = 3}), OptionError);
  EXPECT_THROW(bake_maps(soup, soup, {.search_distance = 0.0}), OptionError);
  EXPECT_THROW(bake_maps(soup, soup, {.seam_weight = -1}), OptionError);
  EXPECT_THROW(bake_maps(soup, soup, {.normal_bits = 12}), OptionError);
  EXPECT_THROW(bake_maps(PolygonSoup{}, soup), InputError);
  EXPECT_THROW(bake_maps(soup, PolygonSoup{}), InputError);
}

}  // namespace
}  // namespace recede::test
