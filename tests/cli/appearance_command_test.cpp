#include "run_recede.h"
#include "sanitized.h"
#include "tiled_surfaces.h"
#include <recede/geometry/mesh_io.h>
#include <recede/render/appearance.h>
#include <recede/render/image_difference.h>
#include <recede/render/image_io.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// A torus with texture coordinates over which a map of waves repeats.
struct WavyTorus {
  TempFolder folder;
  std::string mesh = folder / "torus.obj", map = folder / "waves.png";

  WavyTorus() {
    write_soup(mesh, tiled_torus(48, 24, 15, 6));
    Raster waves;
    waves.width = waves.height = 32;
    for (int k = 0; k < 32 * 32; ++k)
      waves.samples.push_back(
          static_cast<std::uint16_t>(std::lround(127.5 + 127 * std::sin(k / 32 * 0.785))));
    folder.write("waves.png", encode_png(waves));
  }
  CommandResult draw(const std::string& input, std::vector<std::string> more) const {
    std::vector<std::string> arguments{
        "render", input,  "-o", folder / "a.png", "--image-width", "96", "--image-height", "96",
        "--json", "--up", "z"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_recede(arguments);
  }
  /// With the map.
  json draw_waves(const std::string& input, std::vector<std::string> more) const {
    more.insert(more.end(), {"--displacement-map", map, "--displacement-scale", "0.03", "--periodic-map"});
    return json_of(draw(input, more));
  }
  Image picture() const { return read_image(folder / "a.png"); }
};

TEST(AppearanceCommand, DrawsWavesByWhatTheDistanceNeeds) {
  if (k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const WavyTorus torus;
  const json near = torus.draw_waves(torus.mesh, {"--appearance", "auto", "--transition-distance", "1000"});
  EXPECT_GT(near.at("methods").at("displacement"), 0.1);
  EXPECT_EQ(near.at("methods").at("brdf"), 0);
  const Image displaced = torus.picture();
  const json far = torus.draw_waves(torus.mesh, {"--appearance", "auto", "--transition-distance", "0.01"});
  EXPECT_GT(far.at("methods").at("brdf"), 0.1);
  EXPECT_EQ(far.at("methods").at("displacement"), 0);
  const Image table = torus.picture();
  torus.draw_waves(torus.mesh, {"--appearance", "brdf"});
  EXPECT_EQ(torus.picture().pixels, table.pixels);
  EXPECT_GT(compare_images(displaced, table).rmse, 0.01);
  // Waves are 0.1 long, and a pixel is so at 12 away: twice as near is where two are.
  const json by_itself = torus.draw_waves(torus.mesh, {"--appearance", "auto", "--eye", "0", "-6", "4"});
  EXPECT_GT(by_itself.at("methods").at("bump"), 0.0);
  EXPECT_TRUE(torus.draw_waves(torus.mesh, {}).at("methods").is_null());
}

TEST(AppearanceCommand, FalseColoursShowTheMethod) {
  if (k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const WavyTorus torus;
  torus.draw_waves(torus.mesh, {"--appearance", "brdf", "--false-color", "method", "--samples", "1"});
  const Image picture = torus.picture();
  int red = 0;
  for (const Rgb& pixel : picture.pixels) red += pixel.x() > 0.2f && pixel.y() == 0 && pixel.z() == 0;
  EXPECT_GT(red, 500);
}

TEST(AppearanceCommand, DrawsAMapOverALevelOfAHierarchy) {
  if (k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const WavyTorus torus;
  ASSERT_EQ(
      run_recede({"bake", torus.mesh, "-o", torus.folder / "out", "--no-report", "--ratios", "0.3"}).code, 0);
  const std::string hierarchy = torus.folder / "out" / "torus.recede";
  const json drawn = torus.draw_waves(hierarchy, {"--appearance", "bump", "--level", "1"});
  EXPECT_EQ(drawn.at("displacement"), "traced");
  EXPECT_GT(drawn.at("methods").at("bump"), 0.1);
}

TEST(AppearanceCommand, BakesAppearancesThatRenderTakes) {
  if (k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 4000);
  const json baked =
      json_of(run_recede({"bake", sphere, "-o", folder / "out", "--no-report", "--ratios", "0.05", "--maps",
                          "displacement,normal", "--map-size", "64", "--appearance", "--json"}));
  const json& levels = baked.at("levels");
  EXPECT_TRUE(levels[0].at("appearance").is_null());
  const json& appearance = levels[1].at("appearance");
  const std::string file = appearance.at("file");
  EXPECT_EQ(read_appearance(file)->wavelength(), appearance.at("wavelength"));
  EXPECT_GT(appearance.at("wavelength"), 0.0);
  const auto draw = [&] {
    const auto drawn = run_recede({"render", folder / "out" / "sphere.recede", "-o", folder / "a.png",
                                   "--level", "1", "--image-width", "40", "--appearance", "brdf"});
    return std::pair(drawn.code, drawn.remarks);
  };
  EXPECT_EQ(draw().first, 0);
  const Image picture = read_image(folder / "a.png");
  // Without the file it is found again, and comes out the same.
  std::filesystem::remove(file);
  EXPECT_EQ(draw().first, 0);
  EXPECT_EQ(read_image(folder / "a.png").pixels, picture.pixels);
  write_file_atomically(file, "nonsense");
  const auto [code, complaint] = draw();
  EXPECT_EQ(code, 1);
  EXPECT_THAT(complaint, HasSubstr("level_1.appearance: this is no appearance"));
}

TEST(AppearanceCommand, SaysWhatCantBe) {
  const WavyTorus torus;
  const auto complaint = [&](std::vector<std::string> more, int code) {
    const auto result = torus.draw(torus.mesh, std::move(more));
    EXPECT_EQ(result.code, code) << result.remarks;
    return result.remarks;
  };
  EXPECT_THAT(complaint({"--appearance", "auto"}, 2), HasSubstr("has no heights"));
  EXPECT_THAT(complaint({"--appearance", "magic"}, 2), HasSubstr("--appearance"));
  EXPECT_THAT(complaint({"--transition-distance", "3"}, 2), HasSubstr("needs --appearance"));
  const std::vector<std::string> with_map{"--displacement-map", torus.map, "--appearance", "auto"};
  const auto and_more = [&](std::vector<std::string> more) {
    more.insert(more.begin(), with_map.begin(), with_map.end());
    return more;
  };
  EXPECT_THAT(complaint(and_more({"--displacement", "diced"}), 2), HasSubstr("traced only"));
  EXPECT_THAT(complaint(and_more({"--transition-distance", "-1"}), 2), HasSubstr("--transition-distance"));
  EXPECT_THAT(complaint(and_more({"--transition-distance", "inf"}), 2),
              HasSubstr("inf isn't a finite number"));
  // Not periodic, and texture coordinates that go on beyond it: only its own part of the surface counts.
  if (!k_sanitized) {
    EXPECT_EQ(complaint(with_map, 0), "");
  }
  const auto without_maps = run_recede({"bake", torus.mesh, "-o", torus.folder / "out", "--appearance"});
  EXPECT_EQ(without_maps.code, 2);
  EXPECT_THAT(without_maps.remarks, HasSubstr("--maps displacement"));
}

}  // namespace
}  // namespace recede::test
