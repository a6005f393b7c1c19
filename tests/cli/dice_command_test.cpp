// `recede dice` on hierarchies with maps, and on meshes with a height map.
#include "run_recede.h"
#include <recede/geometry/exr.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/raster.h>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string bake_sphere(const TempFolder& folder, const std::string& maps = "displacement") {
  const auto run = run_recede({"bake", write_sphere(folder, 2000), "-o", folder / "out", "--no-report",
                               "--ratios", "0.3", "0.05", "--maps", maps, "--map-size", "64"});
  EXPECT_EQ(run.code, 0) << run.remarks;
  return folder / "out" / "sphere.recede";
}

/// The unit square with a map of two texels: black on the left, white on the right.
std::string write_square(const TempFolder& folder) {
  return folder.write(
      "square.obj",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n");
}
std::string write_map(const TempFolder& folder, int channels = 1) {
  Raster raster{2, 1, channels, 16, false, {}};
  for (const int sample : {0, 65535}) {
    for (int c = 0; c < channels; ++c) raster.samples.push_back(static_cast<std::uint16_t>(sample));
  }
  return folder.write("map.png", encode_png(raster));
}

std::vector<std::string> small(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--image-width", "60", "--image-height", "50"});
  return arguments;
}

TEST(DiceCommand, DicesTheFinestLevelWithHeightsOrTheOneThatIsNamed) {
  const TempFolder folder;
  const std::string hierarchy = bake_sphere(folder);
  const json first = json_of(run_recede(small({"dice", hierarchy, "-o", folder / "a.ply", "--json"})));
  const json second =
      json_of(run_recede(small({"dice", hierarchy, "-o", folder / "b.ply", "--level", "2", "--json"})));
  EXPECT_EQ(first.at("level"), 1);
  EXPECT_EQ(second.at("level"), 2);
  EXPECT_GT(first.at("base_triangles"), second.at("base_triangles"));
  for (const json& result : {first, second}) {
    EXPECT_GT(result.at("largest_move"), 0);
    EXPECT_EQ(result.at("corner_vertices").get<int>() + result.at("edge_vertices").get<int>() +
                  result.at("inner_vertices").get<int>(),
              result.at("vertices"));
    const PolygonSoup soup = read_soup(result.at("output").get<std::string>());
    EXPECT_EQ(soup.n_faces(), result.at("faces"));
    EXPECT_FALSE(soup.corner_uvs.empty());
  }
}

TEST(DiceCommand, ReadsHeightsOfAMeshFromPicturesOfBothKinds) {
  const TempFolder folder;
  const std::string square = write_square(folder);
  FloatRaster floats{2, 1, {"Y"}, {-0.5F, 0.5F}};
  const std::string exr = folder.write("map.exr", encode_exr(floats));
  const auto heights = [&](const std::string& map, std::vector<std::string> more) {
    std::vector<std::string> arguments =
        small({"dice", square, "-o", folder / "a.ply", "--displacement-map", map});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = run_recede(arguments);
    EXPECT_EQ(run.code, 0) << run.remarks;
    const Box3 box = bounding_box(read_soup(folder / "a.ply"));
    return std::pair(box.min().z(), box.max().z());
  };
  EXPECT_EQ(heights(write_map(folder), {}), std::pair(0.0, 1.0));
  EXPECT_EQ(heights(write_map(folder), {"--displacement-scale", "2", "--displacement-offset", "-0.5"}),
            std::pair(-0.5, 1.5));
  EXPECT_EQ(heights(exr, {"--displacement-scale", "2", "--displacement-offset", "1"}), std::pair(0.0, 2.0));
}

TEST(DiceCommand, RepeatsMapsThatAreSaidToBePeriodic) {
  const TempFolder folder;
  const std::string square = write_square(folder), map = write_map(folder);
  const auto height_of_corner = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = small({"dice", square, "-o", folder / "a.ply", "--displacement-map",
                                                map, "--footprint", "none", "--no-cull"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    EXPECT_EQ(run_recede(arguments).code, 0);
    return read_soup(folder / "a.ply").positions[0].z();
  };
  EXPECT_EQ(height_of_corner({}), 0);
  EXPECT_EQ(height_of_corner({"--periodic-map"}), 0.5) << "half way to the texel across the border";
}

TEST(DiceCommand, MakesMoreAndSmallerTrianglesForSmallerPixelsAndKeepsClosedSurfacesClosed) {
  const TempFolder folder;
  const std::string hierarchy = bake_sphere(folder);
  const auto faces = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = small({"dice", hierarchy, "-o", folder / "a.ply", "--json"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return json_of(run_recede(arguments)).at("faces").get<int>();
  };
  EXPECT_GT(faces({}), 2 * faces({"--triangle-pixels", "4"}));
  const std::vector<std::string> near{"--eye", "0", "0", "1.5", "--look-at", "0.3", "0", "0"};
  std::vector<std::string> whole = near;
  whole.push_back("--no-cull");
  const int in_picture = faces(near), everywhere = faces(whole);
  EXPECT_LT(in_picture, everywhere);
  const json info = json_of(run_recede({"info", folder / "a.ply", "--json"}));
  EXPECT_EQ(info.at("border_edges"), 0);
}

TEST(DiceCommand, SaysWhichLevelItTookAndThatColoursAreLeftOut) {
  const TempFolder folder;
  const CommandResult level =
      run_recede(small({"dice", bake_sphere(folder), "-o", folder / "a.ply", "--level", "2"}));
  EXPECT_THAT(level.output, testing::StartsWith("level        2\n"));
  const std::string colored = folder.write(
      "colored.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n");
  const CommandResult run =
      run_recede(small({"dice", colored, "-o", folder / "a.ply", "--displacement-map", write_map(folder)}));
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.remarks, HasSubstr("recede: " + colored + ": the colours of its vertices are left out\n"));
}

TEST(DiceCommand, SaysWhatItCannotDice) {
  const TempFolder folder;
  const std::string out = folder / "a.ply", square = write_square(folder), map = write_map(folder);
  const auto complaint = [&](std::vector<std::string> arguments, int code) {
    arguments.insert(arguments.begin(), "dice");
    arguments.insert(arguments.end(), {"-o", out});
    return complaint_of(run_recede(arguments), code);
  };
  EXPECT_THAT(complaint({square}, 2), HasSubstr("--displacement-map"));
  EXPECT_THAT(complaint({square, "--displacement-map", folder / "no.png"}, 1), HasSubstr("no.png"));
  EXPECT_THAT(complaint({square, "--displacement-map", square}, 1), HasSubstr("neither a .png nor an .exr"));
  EXPECT_THAT(complaint({square, "--displacement-map", map, "--level", "1"}, 2), HasSubstr("--level"));
  EXPECT_THAT(complaint({square, "--displacement-map", map, "--displacement-scale", "nan"}, 2),
              HasSubstr("finite"));
  EXPECT_THAT(complaint({square, "--displacement-map", map, "--triangle-pixels", "0"}, 2),
              HasSubstr("pixels"));
  EXPECT_THAT(complaint({square, "--displacement-map", map, "--most-triangles", "5"}, 2),
              HasSubstr("more than 5"));
  EXPECT_THAT(
      complaint({square, "--displacement-map", map, "--eye", "0", "0", "0", "--look-at", "0", "0", "0"}, 2),
      HasSubstr("apart"));
  EXPECT_THAT(
      complaint({square, "--displacement-map", map, "--eye", "0", "0", "2", "--look-at", "0", "0", "9"}, 1),
      HasSubstr("in the picture"));
  EXPECT_THAT(complaint({square, "--displacement-map", write_map(folder, 3)}, 1), HasSubstr("3 channels"));
  EXPECT_THAT(complaint({write_sphere(folder, 100), "--displacement-map", map}, 1),
              HasSubstr("recede atlas"));
  const std::string bare = bake_sphere(folder, "normal");
  EXPECT_THAT(complaint({bare}, 1), HasSubstr("--maps displacement"));
  const std::string hierarchy = bake_sphere(folder);
  EXPECT_THAT(complaint({hierarchy, "--level", "0"}, 1), HasSubstr("level 0 has no displacement map"));
  EXPECT_THAT(complaint({hierarchy, "--level", "7"}, 2), HasSubstr("no level 7"));
  EXPECT_THAT(complaint({hierarchy, "--displacement-map", map}, 2), HasSubstr("its own"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace recede::test
