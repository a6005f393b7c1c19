#include "uv_sheet.h"
#include <recede/geometry/error.h>
#include <recede/render/renderer.h>
#include <recede/render/shell_level.h>
#include <recede/shells/procedural_volumes.h>

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace {

using namespace recede;

/// A sheet from -1 to 1 with hills, z up, of n x n quads.
PolygonSoup hills(int n, double height) {
  PolygonSoup soup = test::uv_sheet(n);
  for (Vec3& p : soup.positions) p.z() = height * std::sin(3 * p.x()) * std::cos(3 * p.y());
  return soup;
}

TexturedShell shell_over(const PolygonSoup& base, const VolumeTexture& texture, ShellSide side) {
  TexturedShell textured{
      .shell = std::make_shared<const Shell>(build_shell(base, {.thickness = 0.1, .side = side})),
      .side = side};
  textured.texture = std::make_shared<const VolumeMipmap>(make_mipmap(texture));
  textured.coordinates.repeat = {8, 8 * texture.extent.x() / texture.extent.y()};
  return textured;
}

Rgb mean_of(const Scene& scene, const Camera& camera) {
  RenderOptions options{
      .samples_per_pixel = 16, .background = Rgb::Zero(), .transport = LightTransport::direct};
  options.lighting.directionals.push_back({.toward = Vec3::UnitZ()});
  options.lighting.ambient = 0;
  const Image image = render(scene, camera, options);
  Rgb sum = Rgb::Zero();
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += image.at(x, y);
  return sum / static_cast<float>(image.width * image.height);
}

TEST(ShellLevel, IsReplacedFromWhereItsLayerIsThin) {
  const TexturedShell textured = shell_over(hills(24, 0.1), make_volume(weave(), 16), ShellSide::exterior);
  const LodHierarchy hierarchy = shell_hierarchy(textured, "hills", {.ratios = {0.5, 0.1}});
  ASSERT_EQ(hierarchy.levels.size(), 4u);
  EXPECT_EQ(hierarchy.levels[0].error.bound, 0);
  EXPECT_EQ(hierarchy.levels[0].switch_distance, 0);
  double longest = 0;
  for (std::size_t v = 0; v < textured.layer().tops.size(); ++v)
    longest = std::max(longest, (textured.layer().tops[v] - textured.shell->base.positions[v]).norm());
  EXPECT_DOUBLE_EQ(hierarchy.levels[1].error.bound, longest);
  EXPECT_DOUBLE_EQ(hierarchy.levels[1].switch_distance, switch_distance(longest, hierarchy.view));
  EXPECT_EQ(hierarchy.levels[1].mesh.n_faces(), hierarchy.levels[0].mesh.n_faces());
  for (std::size_t i = 1; i < 4; ++i) {
    const LevelError& error = hierarchy.levels[i].error;
    EXPECT_LE(error.rms, error.max);
    EXPECT_LE(error.max, error.bound);
    // Threads take more than half of the height.
    EXPECT_GT(error.max, 0.5 * longest);
    if (i > 1) {
      EXPECT_GE(error.bound, hierarchy.levels[i - 1].error.bound);
    }
  }
}

// From above, where the layer is a pixel thick: as bright and of the colour that the shell has.
TEST(ShellLevel, LooksFromAfarAsTheShellDoes) {
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    for (const bool in_color : {true, false}) {
      const VolumeTexture texture = make_volume(in_color ? weave() : chain_mail(), 32);
      const TexturedShell textured = shell_over(hills(16, 0), texture, side);
      const Rgb matter(0.3f, 0.4f, 0.5f);
      const LodHierarchy hierarchy =
          shell_hierarchy(textured, "sheet", {.ratios = {0.5}, .matter_color = matter});
      const Camera camera{.position = {0, 0, 60},
                          .target = {0, 0, 0},
                          .up = Vec3::UnitY(),
                          .field_of_view = 2 * std::atan(1.0 / 120),
                          .width = 20,
                          .height = 20};
      PlacedVolume placed{textured};
      placed.color = matter;
      PolygonSoup solid = textured.shell->base;
      if (side == ShellSide::interior) solid.positions = textured.layer().tops;
      const Rgb near =
                    mean_of(Scene(std::span(&solid, 1), std::span<const PlacedVolume>(&placed, 1)), camera),
                far = mean_of(Scene(hierarchy.levels[1].mesh), camera);
      // Four periods are seen, and light comes from the camera, too. Samples are 6400, and texels a thirtieth
      // of a period.
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(far[k] / near[k], 1, 0.03) << in_color;
    }
  }
}

TEST(ShellLevel, RefusesWhatHasNoTexture) {
  TexturedShell textured = shell_over(hills(4, 0), make_volume(weave(), 8), ShellSide::exterior);
  textured.texture = nullptr;
  EXPECT_THROW(shell_hierarchy(textured, "sheet"), InputError);
  textured = shell_over(hills(4, 0), make_volume(weave(), 8), ShellSide::exterior);
  EXPECT_THROW(shell_hierarchy(textured, "sheet", {.ratios = {0.5, 0.7}}), OptionError);
}

}  // namespace
