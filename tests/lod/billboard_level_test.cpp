#include "simple_soups.h"
#include "temp_folder.h"
#include "uv_ball.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/raster.h>
#include <recede/lod/billboard_budget.h>
#include <recede/lod/billboard_level.h>
#include <recede/lod/octahedral_impostor.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <random>

namespace recede {
namespace {

using test::uv_ball;

BillboardTextures textures_of(const PolygonSoup& model, double error) {
  return texture_billboards(model, build_billboard_clouds(model, {.errors = {error}}).front());
}

PolygonSoup colored_ball() {
  PolygonSoup model = uv_ball(20);
  for (const Vec3& position : model.positions)
    model.vertex_colors.emplace_back(position.x() + 0.5, position.y() + 0.5, 0.5, 1);
  return model;
}

TEST(BillboardLevel, SaysHowFarTexelsAreFromTheModel) {
  const PolygonSoup model = uv_ball(40);
  const LodLevel level = billboard_level(model, textures_of(model, 0.02), "because");
  EXPECT_EQ(level.stop_reason, "because");
  EXPECT_EQ(level.mesh.n_faces(), level.billboards->billboards.size());
  EXPECT_GT(level.error.rms, 0);
  EXPECT_LT(level.error.rms, 0.004);  // a texel's mean lies off a curved surface by little
  EXPECT_LE(level.error.rms, level.error.max);
  EXPECT_LT(level.error.max, 0.02);
  EXPECT_EQ(level.error.bound, std::max(level.error.max, 0.02));
}

TEST(BillboardLevel, SeesWhatBillboardsDontShow) {
  // A cloud that stands for one of two squares.
  const PolygonSoup both =
      test::soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 3}, {1, 0, 3}, {1, 1, 3}, {0, 1, 3}},
                    {{0, 1, 2, 3}, {4, 5, 6, 7}});
  PolygonSoup one = both;
  one.face_offsets.pop_back();
  one.corner_vertices.resize(4);
  const LodLevel level = billboard_level(both, textures_of(one, 0.1), "");
  // Half of the area is 3 away, less what a texel spans.
  EXPECT_NEAR(level.error.max, 3, 0.1);
  EXPECT_NEAR(level.error.rms, 3 / std::sqrt(3), 0.1);  // one of three areas: two of the model, one drawn
}

// As of hairs that all rays of the samples miss.
TEST(BillboardLevel, ThatShowsNothingIsAsFarOffAsTheModelIsWide) {
  const PolygonSoup hair = test::soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1e-3, 0}}, {{0, 1, 2}});
  BillboardTextures textures = textures_of(hair, 0.1);
  ASSERT_GT(billboard_level(hair, textures, "").error.bound, 0);
  for (std::size_t i = 3; i < textures.color.samples.size(); i += 4) textures.color.samples[i] = 0;
  const LevelError error = billboard_level(hair, textures, "").error;
  EXPECT_NEAR(error.max, 1, 1e-6);  // the diagonal
  EXPECT_EQ(error.rms, error.max);
  EXPECT_EQ(error.bound, error.max);
}

TEST(BillboardLevel, ComesBackFromItsFiles) {
  const test::TempFolder folder;
  const PolygonSoup model = colored_ball();
  std::vector<BillboardTextures> clouds{textures_of(model, 0.02), textures_of(model, 0.05)};
  const LodHierarchy hierarchy = billboard_hierarchy(model, "ball", clouds);
  ASSERT_EQ(hierarchy.levels.size(), 2u);
  EXPECT_EQ(hierarchy.levels[0].switch_distance, 0);
  EXPECT_GT(hierarchy.levels[1].switch_distance, 0);
  const HierarchyFiles files = write_hierarchy(folder.path(), hierarchy);
  EXPECT_TRUE(std::filesystem::exists(files.map_files[1].height));
  const LodHierarchy back = read_hierarchy(files.folder);
  ASSERT_EQ(back.levels.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(back.levels[i].billboards.has_value());
    const BillboardTextures &a = clouds[i], &b = *back.levels[i].billboards;
    EXPECT_EQ(a.color, b.color);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.error, b.error);
    EXPECT_EQ(a.texel, b.texel);
    EXPECT_EQ(a.height_range, b.height_range);
    ASSERT_EQ(a.places.size(), b.places.size());
    for (std::size_t k = 0; k < a.places.size(); ++k) {
      EXPECT_EQ(a.places[k].x, b.places[k].x);
      EXPECT_EQ(a.places[k].y, b.places[k].y);
      EXPECT_EQ(a.places[k].width, b.places[k].width);
      EXPECT_EQ(a.places[k].height, b.places[k].height);
      EXPECT_LT((a.billboards[k].center - b.billboards[k].center).norm(), 1e-12);
      EXPECT_GT(a.billboards[k].axis_u.dot(b.billboards[k].axis_u), 1 - 1e-12);
      EXPECT_GT(a.billboards[k].axis_v.dot(b.billboards[k].axis_v), 1 - 1e-12);
    }
  }
}

TEST(BillboardLevel, IsMaskedInGlb) {
  const test::TempFolder folder;
  const PolygonSoup model = colored_ball();
  const LodHierarchy hierarchy = billboard_hierarchy(model, "ball", {textures_of(model, 0.05)});
  const HierarchyFiles files = write_hierarchy(folder.path(), hierarchy);
  const PolygonSoup quads = read_soup(files.glb);
  EXPECT_EQ(quads.n_faces(), 2 * hierarchy.levels[0].mesh.n_faces());
  ASSERT_EQ(quads.materials.size(), 1u);
  EXPECT_EQ(quads.materials[0].alpha_cutoff, 0.5);
  EXPECT_EQ(quads.materials[0].base_color_texture, "ball.recede/level_0_color.png");
  EXPECT_EQ(quads.materials[0].normal_texture, "ball.recede/level_0_normal.png");
  EXPECT_EQ(quads.corner_uvs.size(), quads.n_corners());
}

TEST(BillboardLevel, OfDamagedFilesIsRefused) {
  const test::TempFolder folder;
  const PolygonSoup model = colored_ball();
  const HierarchyFiles files =
      write_hierarchy(folder.path(), billboard_hierarchy(model, "ball", {textures_of(model, 0.05)}));
  const std::string ply = (files.folder / "level_0.ply").string();
  write_soup(ply, model);
  EXPECT_THROW(read_hierarchy(files.folder), InputError);
  write_soup(ply, quads_of(textures_of(model, 0.05)));
  EXPECT_NO_THROW(read_hierarchy(files.folder));
  std::filesystem::copy_file(files.map_files[0].height, files.map_files[0].color,
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THROW(read_hierarchy(files.folder), InputError);
}

TEST(BillboardLevel, NeedsACloudAndAView) {
  const PolygonSoup model = uv_ball(4);
  EXPECT_THROW(billboard_hierarchy(model, "none", {}), OptionError);
  const std::vector<BillboardTextures> clouds{textures_of(model, 0.1)};
  EXPECT_NO_THROW(billboard_hierarchy(model, "ball", clouds));
  EXPECT_THROW(billboard_hierarchy(model, "ball", clouds, {.pixel_error = 0}), OptionError);
  EXPECT_THROW(billboard_hierarchy(model, "ball", clouds, {.image_height = 0}), OptionError);
  EXPECT_THROW(billboard_hierarchy(model, "ball", clouds, {.field_of_view = 4}), OptionError);
}

TEST(BillboardBudget, IsKeptAndUsed) {
  const PolygonSoup model = uv_ball(20);
  double last = 1e9;
  for (const std::size_t bytes : {4'000u, 30'000u, 200'000u}) {
    const BillboardTextures textures = billboards_within(model, bytes);
    EXPECT_LE(textures.bytes(), bytes);
    EXPECT_GT(textures.bytes(), bytes / 2);
    EXPECT_LT(textures.error, last);
    last = textures.error;
  }
  const BillboardTextures planes = billboards_within(model, 30'000, {.method = BillboardMethod::plane_cover});
  EXPECT_LE(planes.bytes(), 30'000u);
}

TEST(BillboardBudget, OfTooFewBytesIsRefused) {
  EXPECT_THROW(billboards_within(uv_ball(20), 8), OptionError);
  PolygonSoup point;
  EXPECT_THROW(billboards_within(point, 1000), InputError);
}

TEST(BillboardBudget, CountsWhatTexturesTake) {
  const PolygonSoup model = uv_ball(20);
  const BillboardCloud cloud = build_billboard_clouds(model, {.errors = {0.02}}).front();
  EXPECT_EQ(texture_bytes(cloud), texture_billboards(model, cloud).bytes());
}

TEST(OctahedralImpostor, HasAPictureForEachDirection) {
  const PolygonSoup model = uv_ball(20);
  const BillboardCloud cloud = octahedral_impostor(model, 6);
  ASSERT_EQ(cloud.billboards.size(), 36u);
  for (std::size_t i = 0; i < 36; ++i) {
    const std::size_t nearest = octahedral_view(cloud.billboards[i].normal(), 6);
    // The same direction; at the border of the square nodes stand for it more than once.
    EXPECT_GT(cloud.billboards[nearest].normal().dot(cloud.billboards[i].normal()), 1 - 1e-12);
    EXPECT_EQ(cloud.billboards[i].faces.size(), model.n_faces());
    EXPECT_NEAR(cloud.billboards[i].axis_u.cross(cloud.billboards[i].axis_v).norm(), 1, 1e-12);
  }
  EXPECT_NEAR(cloud.error, 0.5, 1e-12);
}

TEST(OctahedralImpostor, ChoosesAViewThatIsNear) {
  const BillboardCloud cloud = octahedral_impostor(uv_ball(6), 8);
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
    const Billboard& chosen = cloud.billboards[octahedral_view(3 * direction, 8)];
    double best = -1;
    for (const Billboard& billboard : cloud.billboards)
      best = std::max(best, billboard.normal().dot(direction));
    // Cells of the octahedron are askew on the sphere, so that a node of another one may be nearer.
    EXPECT_GT(chosen.normal().dot(direction), best - 0.02);
  }
}

TEST(OctahedralImpostor, FillsItsBytes) {
  const PolygonSoup model = uv_ball(10);
  const BillboardTextures textures = octahedral_impostor_within(model, 100'000, 4);
  EXPECT_LE(textures.bytes(), 100'000u);
  EXPECT_GT(textures.bytes(), 50'000u);
  EXPECT_TRUE(textures.is_impostor);
  // A disc in each square.
  EXPECT_NEAR(textures.covered / textures.packed, 0.785, 0.04);
  EXPECT_THROW(octahedral_impostor_within(model, 100, 4), OptionError);
  EXPECT_THROW(octahedral_impostor(model, 1), OptionError);
}

}  // namespace
}  // namespace recede
