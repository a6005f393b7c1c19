#include "markup_check.h"
#include "shapes.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/base64.h>
#include <recede/geometry/error.h>
#include <recede/render/detail/report_content.h>
#include <recede/render/detail/viewer_program.h>
#include <recede/render/report.h>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

namespace recede {
namespace {

using testing::HasSubstr;
using testing::Not;

// Spheres of fewer and fewer faces. The distance from a chord's middle to its arc is the error, to first
// order.
LodHierarchy sphere_levels(const std::string& name) {
  LodHierarchy hierarchy{.name = name, .view = {}, .center = Vec3(10, 0, 0), .radius = 1, .levels = {}};
  for (const Index around : {128u, 64u, 32u, 16u}) {
    LodLevel level;
    level.mesh = to_polygon_mesh(make_sphere(hierarchy.center, 1, around, around / 2));
    if (around < 128) {
      level.error.max = 1 - std::cos(std::numbers::pi / around);
      level.error.rms = level.error.max / 2;
      level.error.bound = 1.1 * level.error.max;
      level.switch_distance = switch_distance(level.error.bound, hierarchy.view);
      level.screen_coverage =
          std::min(1.0, 2 / (1080 * pixel_footprint(level.switch_distance, hierarchy.view)));
      level.simplify_seconds = 8.0 / around;
      level.measure_seconds = 0.25;
      level.stop_reason = "face target";
    }
    hierarchy.levels.push_back(std::move(level));
  }
  return hierarchy;
}

HierarchyFiles files_of(const LodHierarchy& hierarchy) {
  HierarchyFiles files{
      .glb = "out/ball.glb", .folder = "out/ball.recede", .level_files = {}, .level_bytes = {}};
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    files.level_files.push_back(files.folder / fmt::format("level_{}.ply", i));
    files.level_bytes.push_back(100'000 >> i);
  }
  return files;
}

class Report : public testing::Test {
 protected:
  Report()
      : folder_(std::filesystem::temp_directory_path() / fmt::format("recede_report_test_{}", getpid())) {
    std::filesystem::create_directories(folder_);
  }
  ~Report() override { std::filesystem::remove_all(folder_); }
  const std::filesystem::path folder_;
};

TEST_F(Report, HasARowAndASectionForEachLevelAndNoReferenceOutside) {
  const LodHierarchy hierarchy = sphere_levels("ball <& co>");
  const ReportFiles written = write_report(folder_, hierarchy, files_of(hierarchy));
  const std::string html = read_whole_file(written.html);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_THAT(html, HasSubstr(fmt::format("id=\"row-{}\"", i)));
    EXPECT_THAT(html, HasSubstr(fmt::format("alt=\"Level {} from near\"", i)));
    EXPECT_THAT(html, HasSubstr(fmt::format("id=\"level-{}\"", i)));
    // The input has no switch distance to be seen from.
    EXPECT_EQ(html.find(fmt::format("alt=\"Level {} at its switch distance\"", i)) != std::string::npos,
              i > 0);
  }
  EXPECT_THAT(html, Not(HasSubstr("row-4")));
  EXPECT_THAT(html, HasSubstr("<h1>ball &lt;&amp; co&gt;</h1>"));
  EXPECT_EQ(find_markup_error(html, {"meta", "img", "br", "input"}), "");
  for (const char* reference :
       {"src=\"http", "href=\"http", "url(", "@import", "<script src", "<link", "src=\"//"}) {
    EXPECT_THAT(html, Not(HasSubstr(reference)));
  }
}

TEST_F(Report, JsonHasTheDocumentedFields) {
  const LodHierarchy hierarchy = sphere_levels("ball");
  const ReportFiles written = write_report(folder_, hierarchy, files_of(hierarchy), {.up = Vec3::UnitZ()});
  const auto json = nlohmann::json::parse(read_whole_file(written.json));
  EXPECT_EQ(json["name"], "ball");
  EXPECT_NEAR(json["diagonal"].get<double>(), std::sqrt(12.0), 1e-12);
  EXPECT_EQ(json["view"]["image_height"], 1080);
  EXPECT_EQ(json["view"]["up"], nlohmann::json({0, 0, 1}));
  ASSERT_EQ(json["levels"].size(), 4u);
  EXPECT_TRUE(json["levels"][0]["image_difference"].is_null());
  const auto& level = json["levels"][2];
  EXPECT_EQ(level["level"], 2);
  EXPECT_EQ(level["file"], "level_2.ply");
  EXPECT_EQ(level["bytes"], 25'000);
  EXPECT_EQ(level["faces"], 32 * 16);
  EXPECT_EQ(level["triangles"], 64);
  EXPECT_EQ(level["quads"], 32 * 14);
  EXPECT_EQ(level["larger_polygons"], 0);
  EXPECT_EQ(level["vertices"], 32 * 15 + 2);
  EXPECT_EQ(level["error"]["bound"], hierarchy.levels[2].error.bound);
  EXPECT_NEAR(level["error"]["rms_relative"].get<double>(), hierarchy.levels[2].error.rms / std::sqrt(12.0),
              1e-5);
  EXPECT_EQ(level["switch_distance"], hierarchy.levels[2].switch_distance);
  EXPECT_EQ(level["seconds"]["simplify"], 0.25);
  EXPECT_EQ(level["stop_reason"], "face target");
  EXPECT_DOUBLE_EQ(level["image_difference"]["camera_distance"], hierarchy.levels[2].switch_distance + 1);
}

TEST_F(Report, AtItsSwitchDistanceALevelHardlyDiffersFromTheOriginal) {
  const LodHierarchy hierarchy = sphere_levels("ball");
  const ReportFiles written = write_report(folder_, hierarchy, files_of(hierarchy));
  const auto json = nlohmann::json::parse(read_whole_file(written.json));
  for (std::size_t i = 1; i < 4; ++i) {
    const auto& difference = json["levels"][i]["image_difference"];
    EXPECT_GT(difference["rmse"].get<double>(), 0) << i;
    // Half of black to white along a ring of one pixel, which is a 37th of the window's area for the coarsest
    // level.
    EXPECT_LT(difference["rmse"].get<double>(), std::sqrt(0.25 / 37)) << i;
  }
}

// A level of the sphere with heights, normals and a few misses that nobody baked.
void give_maps(LodLevel& level, bool displacement) {
  BakedMaps maps;
  maps.surface = to_soup(level.mesh);
  maps.surface.corner_uvs.assign(maps.surface.n_corners(), Vec2(0.5, 0.5));
  for (const Index vertex : maps.surface.corner_vertices) {
    maps.surface.corner_normals.push_back((maps.surface.positions[vertex] - Vec3(10, 0, 0)).normalized());
  }
  maps.corner_tangents.assign(maps.surface.n_corners(), Vec4(0, 0, 1, 1));
  maps.size = 600;
  maps.normal = {
      .width = 600, .height = 600, .channels = 3, .samples = std::vector<std::uint16_t>(600 * 600 * 3, 128)};
  if (displacement) {
    maps.displacement = {
        .width = 600, .height = 600, .bits = 16, .samples = std::vector<std::uint16_t>(600 * 600, 65535)};
    maps.height_scale = 0.25;
    maps.height_offset = -0.125;
    level.map_accuracy = MapAccuracy{.bare_max = 0.5, .bare_rms = 0.25, .max = 0.0625, .rms = 0.03125};
  }
  maps.report = {.atlas_reason = "triangles overlap",
                 .search_distance = 2,
                 .texels = 360'000,
                 .missed = 1234,
                 .seam_edges = 7,
                 .seam_difference = 0.0078125,
                 .seconds = 3};
  level.maps = std::move(maps);
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST_F(Report, ShowsTheMapsOfALevelWithTheirFigures) {
  LodHierarchy hierarchy = sphere_levels("ball");
  give_maps(hierarchy.levels[1], true);
  give_maps(hierarchy.levels[2], false);
  const ReportFiles written = write_report(folder_, hierarchy, files_of(hierarchy));
  const std::string html = read_whole_file(written.html);
  EXPECT_EQ(find_markup_error(html, {"meta", "img", "br", "input"}), "");
  EXPECT_EQ(count_of(html, "alt=\"Displacement of level 1\""), 1u);
  EXPECT_EQ(count_of(html, "alt=\"Displacement of level"), 1u);
  EXPECT_EQ(count_of(html, "alt=\"Normals of level"), 2u);
  EXPECT_EQ(count_of(html, "alt=\"Colours of level"), 0u);
  EXPECT_EQ(count_of(html, " with its maps\""), 2u);
  // 600 texels are shown a third as large.
  EXPECT_EQ(count_of(html, "width=\"200\" height=\"200\""), 3u);
  EXPECT_THAT(html, HasSubstr("600 × 600 texels: black -0.125, white 0.125 object units"));
  for (const char* text : {"0.0625", "0.0312", "0.00781", "triangles overlap", "RMS with maps"}) {
    EXPECT_THAT(html, HasSubstr(text));
  }
  const auto levels = nlohmann::json::parse(read_whole_file(written.json))["levels"];
  EXPECT_TRUE(levels[0]["maps"].is_null());
  EXPECT_TRUE(levels[3]["maps"].is_null());
  EXPECT_EQ(levels[1]["maps"]["size"], 600);
  EXPECT_EQ(levels[1]["maps"]["rms"], 0.03125);
  EXPECT_EQ(levels[1]["maps"]["max"], 0.0625);
  EXPECT_TRUE(levels[2]["maps"]["rms"].is_null());
  EXPECT_EQ(levels[2]["maps"]["seam_difference"], 0.0078125);
  EXPECT_EQ(levels[2]["maps"]["missed"], 1234);
  EXPECT_EQ(levels[2]["maps"]["atlas_reason"], "triangles overlap");
}

TEST_F(Report, SaysNothingOfMapsWhereThereAreNone) {
  const LodHierarchy hierarchy = sphere_levels("ball");
  const std::string html = read_whole_file(write_report(folder_, hierarchy, files_of(hierarchy)).html);
  for (const char* word : {"with maps", "with its maps", "texels"})
    EXPECT_EQ(count_of(html, word), 0u) << word;
}

TEST_F(Report, AnIdenticalLevelShowsNoDifference) {
  LodHierarchy hierarchy = sphere_levels("ball");
  hierarchy.levels[1].mesh = hierarchy.levels[0].mesh;
  hierarchy.levels[1].switch_distance = 0;  // seen from the bounding sphere itself, larger than the image
  const ReportFiles written = write_report(folder_, hierarchy, files_of(hierarchy));
  const auto json = nlohmann::json::parse(read_whole_file(written.json));
  EXPECT_EQ(json["levels"][1]["image_difference"]["rmse"], 0);
  EXPECT_EQ(json["levels"][1]["image_difference"]["max"], 0);
}

// The data of the page's viewer; null: it has none.
nlohmann::json viewer_data(const std::string& html) {
  const std::string before = "id=\"viewer-data\">";
  const std::size_t at = html.find(before);
  if (at == html.npos) return nullptr;
  const std::size_t from = at + before.size();
  return nlohmann::json::parse(html.substr(from, html.find("</script>", from) - from));
}

TEST_F(Report, SaysWhyLevelsAreNotInTheViewer) {
  if (detail::viewer_program().empty()) GTEST_SKIP() << "built without the viewer";
  LodHierarchy hierarchy = sphere_levels("ball");
  hierarchy.levels.pop_back();
  // 64 around and 32 down: triangles at both poles, and 30 rows of quads between.
  const ReportFiles written =
      write_report(folder_, hierarchy, files_of(hierarchy), {.viewer_triangles = 64 * 62});
  const std::string html = read_whole_file(written.html);
  EXPECT_EQ(find_markup_error(html, {"meta", "img", "br", "input"}), "");
  EXPECT_THAT(html,
              HasSubstr("Not in the viewer: level 0 (16\u202f128 triangles, more than 3\u202f968).</p>"));
  const nlohmann::json data = viewer_data(html),
                       levels = nlohmann::json::parse(read_whole_file(written.json))["levels"];
  const std::vector<int> triangles{0, 64 * 62, 32 * 30};
  ASSERT_EQ(data["levels"].size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(data["levels"][i].value("triangles", 0), triangles[i]) << i;
    EXPECT_EQ(data["levels"][i].contains("data"), triangles[i] > 0) << i;
    EXPECT_EQ(data["levels"][i]["switch_distance"], hierarchy.levels[i].switch_distance) << i;
    if (triangles[i] == 0) {
      EXPECT_TRUE(levels[i]["viewer"].is_null()) << i;
      continue;
    }
    EXPECT_EQ(levels[i]["viewer"]["triangles"], triangles[i]) << i;
    EXPECT_EQ(levels[i]["viewer"]["largest_distance"], data["levels"][i]["largest_distance"]) << i;
  }
}

TEST_F(Report, TheViewerHasBillboardsWithTheirTextures) {
  if (detail::viewer_program().empty()) GTEST_SKIP() << "built without the viewer";
  LodHierarchy hierarchy = sphere_levels("ball");
  const PolygonSoup ball = to_soup(hierarchy.levels[0].mesh);
  LodLevel& level = hierarchy.levels[3];
  level.billboards = texture_billboards(ball, build_billboard_clouds(ball, {.errors = {0.2}}).front());
  level.mesh = to_polygon_mesh(quads_of(*level.billboards));
  const detail::ViewerContent viewer = detail::pack_levels(hierarchy, 200'000, nullptr);
  EXPECT_EQ(viewer.levels[2].billboards, 0u);
  const detail::ViewerLevel& shown = viewer.levels[3];
  EXPECT_EQ(shown.left_out, "");
  EXPECT_EQ(shown.billboards, level.billboards->billboards.size());
  EXPECT_EQ(shown.triangles, 2 * shown.billboards);
  const Raster color = decode_png(detail::decode_base64(shown.color).value(), "color"),
               normal = decode_png(detail::decode_base64(shown.normal).value(), "normal");
  EXPECT_EQ(color.samples, level.billboards->color.samples);
  EXPECT_EQ(normal.samples, level.billboards->normal.samples);
  // Corners of rectangles stick out where nothing is drawn.
  EXPECT_GT(viewer.box.sizes().x(), viewer.seen.sizes().x());
  EXPECT_NEAR(viewer.seen.sizes().x(), 2, 1e-12);
  level.billboards->is_impostor = true;
  EXPECT_EQ(detail::pack_levels(hierarchy, 200'000, nullptr).levels[3].left_out, "an impostor");
}

TEST_F(Report, WithoutTrianglesThereIsNoViewer) {
  const LodHierarchy hierarchy = sphere_levels("ball");
  const std::string html =
      read_whole_file(write_report(folder_, hierarchy, files_of(hierarchy), {.viewer_triangles = 0}).html);
  EXPECT_TRUE(viewer_data(html).is_null());
  EXPECT_THAT(html, Not(HasSubstr("<canvas")));
}

TEST_F(Report, AHierarchyOfTheInputAloneHasAReport) {
  LodHierarchy hierarchy = sphere_levels("ball");
  hierarchy.levels.resize(1);
  const ReportFiles written = write_report(folder_, hierarchy, files_of(hierarchy));
  const std::string html = read_whole_file(written.html);
  EXPECT_THAT(html, HasSubstr("alt=\"Level 0 from near\""));
  EXPECT_THAT(html, Not(HasSubstr("id=\"slider\"")));
}

TEST_F(Report, FilesThatDoNotFitTheLevelsAreRefusedAndNothingIsWritten) {
  const LodHierarchy hierarchy = sphere_levels("ball");
  EXPECT_THROW(write_report(folder_, hierarchy, {}), OptionError);
  EXPECT_THROW(write_report(folder_, hierarchy, files_of(hierarchy), {.up = Vec3::Zero()}), OptionError);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace recede
