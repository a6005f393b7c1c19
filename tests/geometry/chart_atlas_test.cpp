#include "chart_checks.h"
#include "meshes.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <filesystem>

namespace recede {
namespace {

TEST(ChartAtlas, ABoxBecomesSixSquaresOfEqualSize) {
  const PolygonSoup box = test::prism(4);
  const AtlasResult atlas = make_atlas(box, {.packing = {.resolution = 256, .gutter = 2}});
  test::expect_sound(box, atlas);
  test::expect_gutter(atlas, 2);
  EXPECT_EQ(atlas.charts.size(), 6u);
  EXPECT_NEAR(atlas.stretch.l_infinity, 1, 1e-9);
  EXPECT_GT(atlas.occupancy, 0.55);
}

TEST(ChartAtlas, TexturesOfOtherCoordinatesAreDropped) {
  PolygonSoup box = test::prism(4);
  box.materials = {{"skin", Vec4::Ones(), "skin.png", "bumps.png"}};
  box.materials[0].base_color_picture = std::make_shared<const std::string>("picture");
  box.face_materials.assign(box.n_faces(), 0);
  EXPECT_EQ(make_atlas(box).soup.materials, (std::vector<Material>{{"skin", Vec4::Ones(), ""}}));
}

TEST(ChartAtlas, ChartsKeepTheirShareOfTheArea) {
  const PolygonSoup soup = make_displaced_sphere(3000, true);
  const AtlasResult atlas = make_atlas(soup);
  test::expect_sound(soup, atlas);
  std::vector<double> uv_areas(atlas.charts.size(), 0.0);
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const Vec2* uv = &atlas.soup.corner_uvs[soup.face_offsets[f]];
    const Vec2 a = uv[1] - uv[0], b = uv[2] - uv[0];
    uv_areas[atlas.face_charts[f]] += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  double sum = 0;
  for (std::size_t c = 0; c < uv_areas.size(); ++c) {
    EXPECT_NEAR(atlas.charts[c].area / uv_areas[c], atlas.units_per_uv * atlas.units_per_uv,
                1e-6 * atlas.charts[c].area / uv_areas[c]);
    sum += uv_areas[c];
  }
  EXPECT_NEAR(sum, atlas.occupancy, 1e-9);
}

TEST(ChartAtlas, NoTwoChartsComeNearerThanTheGutter) {
  for (const int gutter : {0, 1, 5}) {
    AtlasOptions options;
    options.packing = {.resolution = 512, .gutter = gutter};
    const PolygonSoup soup = make_teapot(8, 0.05);
    const AtlasResult atlas = make_atlas(soup, options);
    test::expect_sound(soup, atlas);
    test::expect_gutter(atlas, gutter);
  }
}

TEST(ChartAtlas, CornersOfOneChartAtOneVertexShareTheirTextureCoordinate) {
  const PolygonSoup soup = make_displaced_sphere(2000, false);
  const AtlasResult atlas = make_atlas(soup);
  std::map<std::pair<Index, Index>, std::set<std::pair<double, double>>> uvs;
  std::set<Index> on_seams;
  std::map<Index, std::set<Index>> charts_at;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    for (Index c = soup.face_offsets[f]; c < soup.face_offsets[f + 1]; ++c) {
      const Vec2& uv = atlas.soup.corner_uvs[c];
      uvs[{soup.corner_vertices[c], atlas.face_charts[f]}].insert({uv.x(), uv.y()});
      charts_at[soup.corner_vertices[c]].insert(atlas.face_charts[f]);
    }
  }
  for (const auto& [place, different] : uvs) EXPECT_EQ(different.size(), 1u);
}

TEST(ChartAtlas, TheStretchLimitCutsChartsUntilAllKeepIt) {
  const PolygonSoup soup = make_teapot(8, 0.02);
  AtlasOptions options;
  options.charts.charts = 10;
  options.stretch_limit = std::numeric_limits<double>::infinity();
  const AtlasResult loose = make_atlas(soup, options);
  EXPECT_EQ(loose.split_for_stretch, 0u);
  options.stretch_limit = 1.1;
  const AtlasResult tight = make_atlas(soup, options);
  test::expect_sound(soup, tight, options);
  EXPECT_GT(tight.split_for_stretch, 0u);
  EXPECT_LT(tight.stretch.l2, loose.stretch.l2);
  EXPECT_GT(tight.charts.size(), loose.charts.size());
}

TEST(ChartAtlas, AChartWhoseMapLeavesTheRangeOfNumbersIsCut) {
  const PolygonSoup soup = test::finger(600, 1);
  AtlasOptions options;
  options.charts.charts = 1;
  options.charts.least_corners = 0;
  options.stretch_limit = std::numeric_limits<double>::infinity();
  ASSERT_EQ(make_charts(soup, options.charts).report.charts, 1u);
  const AtlasResult atlas = make_atlas(soup, options);
  EXPECT_GT(atlas.split_for_flips, 0u);
  EXPECT_EQ(atlas.split_for_stretch, 0u);
  test::expect_sound(soup, atlas, options);
}

TEST(ChartAtlas, FacesThinnerThanTheAtlasResolvesStillHaveAnInside) {
  PolygonSoup soup = test::grid(2, true);
  for (Vec3& p : soup.positions) p.y() *= 1e-15;
  soup.positions.insert(soup.positions.end(), {{3, 0, 0}, {4, 0, 0}, {3.3, 1e-17, 0}});
  soup.add_face(std::vector<Index>{9, 10, 11});
  test::expect_sound(soup, make_atlas(soup));
}

TEST(ChartAtlas, ScalingByStretchGivesBadChartsMoreRoom) {
  const PolygonSoup soup = make_displaced_sphere(2000, true);
  AtlasOptions options;
  options.charts.charts = 8;
  options.map.border = DiskBorder::circle;
  options.stretch_limit = 10;
  const AtlasResult by_area = make_atlas(soup, options);
  options.scale_by_stretch = true;
  const AtlasResult by_stretch = make_atlas(soup, options);
  const auto worst =
      std::max_element(by_area.charts.begin(), by_area.charts.end(),
                       [](const auto& a, const auto& b) { return a.stretch.l2 < b.stretch.l2; }) -
      by_area.charts.begin();
  const auto share = [&](const AtlasResult& atlas) {
    const AtlasChart& chart = atlas.charts[std::size_t(worst)];
    return double(chart.width) * chart.height / atlas.occupancy / atlas.resolution / atlas.resolution;
  };
  EXPECT_GT(share(by_stretch), share(by_area));
}

TEST(ChartAtlas, SameResultForAnyNumberOfThreads) {
  const PolygonSoup soup = make_displaced_sphere(3000, true);
  const auto run = [&](std::size_t threads) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return make_atlas(soup).soup.corner_uvs;
  };
  EXPECT_EQ(run(1), run(2));
}

TEST(ChartAtlas, SoupsWithoutFacesOrAreaAreFine) {
  EXPECT_TRUE(make_atlas(PolygonSoup()).charts.empty());
  PolygonSoup flat = test::grid(3, true);
  for (Vec3& p : flat.positions) p = {1, 2, 3};
  test::expect_sound(flat, make_atlas(flat));
  EXPECT_THROW(make_atlas(flat, {.stretch_limit = 0.5}), OptionError);
}

TEST(ChartAtlas, StopsWhenAsked) {
  struct StopAt : Progress {
    std::string_view stage;
    bool now = false;
    explicit StopAt(std::string_view s) : stage(s) {}
    void update(std::string_view s, double) override { now = s == stage; }
    bool cancel_requested() const override { return now; }
  };
  for (const auto stage : {"merging clusters", "straightening borders", "mapping charts"}) {
    StopAt stop(stage);
    EXPECT_THROW(make_atlas(make_displaced_sphere(500, true), {}, &stop), Cancelled) << stage;
  }
}

/// Models as files hold them; `./dev data` fetches them.
class RealAtlases : public ::testing::TestWithParam<const char*> {};

TEST_P(RealAtlases, AreDisksWithoutFlipsOrOverlaps) {
  const std::filesystem::path path = std::string(RECEDE_DATA "/") + GetParam();
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no models; ./dev data fetches them";
  PolygonSoup soup = read_soup(path);
  merge_identical_vertices(soup);
  const AtlasResult atlas = make_atlas(soup);
  test::expect_sound(soup, atlas);
  test::expect_gutter(atlas, PackingOptions().gutter);
  EXPECT_LT(atlas.stretch.l2, 1.25);
  EXPECT_GT(atlas.occupancy, 0.3);
}

// A scan, genus 133, mechanical parts, open and torn surfaces, polygons and edges of more than two faces.
INSTANTIATE_TEST_SUITE_P(Models, RealAtlases,
                         ::testing::Values("meshes/bunny00.off", "meshes/cheese.off", "meshes/fandisk.off",
                                           "meshes/lion-head.off", "meshes/elephant-with-holes.off",
                                           "meshes/boeing.off", "meshes/bones.off", "meshes/b9_mesh.off",
                                           "cad/stl/motor.stl", "cad/stl/head.stl"));

}  // namespace
}  // namespace recede
