#include "input_errors.h"
#include "meshes.h"
#include "pictures.h"
#include "temp_folder.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/lod_hierarchy.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <fstream>
#include <numbers>

namespace recede {
namespace {

using test::mesh_of;
namespace fs = std::filesystem;

// The example of the source with its error corrected: 2000 pixels, 30 degrees, 1 m gives 0.268 mm a pixel.
TEST(LodHierarchy, APixelCoversWhatTheFormulaSays) {
  const ViewSettings view{2000, 30 * std::numbers::pi / 180, 1};
  EXPECT_NEAR(pixel_footprint(1.0, view), 0.268e-3, 0.0005e-3);
  EXPECT_NEAR(switch_distance(0.268e-3, view), 1.0, 0.002);
  EXPECT_DOUBLE_EQ(switch_distance(pixel_footprint(7, view), view), 7);
}

TEST(LodHierarchy, HalfThePixelErrorDoublesTheDistance) {
  ViewSettings view;
  const double whole = switch_distance(1, view);
  view.pixel_error = 0.5;
  EXPECT_DOUBLE_EQ(switch_distance(1, view), 2 * whole);
}

HierarchyOptions by_ratios(std::vector<double> ratios) {
  HierarchyOptions options;
  options.ratios = std::move(ratios);
  return options;
}

TEST(LodHierarchy, LevelsByRatioHaveGrowingErrorsAndDistances) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(6000, false));
  const LodHierarchy h = build_hierarchy(mesh, "ball", by_ratios({0.5, 0.2, 0.05}));
  ASSERT_EQ(h.levels.size(), 4u);
  EXPECT_EQ(h.levels[0].mesh.n_faces(), mesh.n_faces());
  EXPECT_EQ(h.levels[0].error.bound, 0);
  EXPECT_EQ(h.levels[0].switch_distance, 0);
  for (std::size_t i = 1; i < 4; ++i) {
    const LodLevel& level = h.levels[i];
    EXPECT_LE(level.mesh.n_faces(), std::vector<double>({1, 0.5, 0.2, 0.05})[i] * double(mesh.n_faces()));
    EXPECT_LE(level.error.rms, level.error.max);
    EXPECT_LE(level.error.max, level.error.bound);
    EXPECT_GT(level.error.rms, h.levels[i - 1].error.rms);
    EXPECT_DOUBLE_EQ(level.switch_distance, switch_distance(level.error.bound, h.view));
    EXPECT_LE(level.screen_coverage, h.levels[i - 1].screen_coverage);
  }
}

TEST(LodHierarchy, LevelsByFacesHaveNoMore) {
  HierarchyOptions options;
  options.faces = {3000, 701};
  const LodHierarchy h = build_hierarchy(mesh_of(make_displaced_sphere(6000, true)), "ball", options);
  ASSERT_EQ(h.levels.size(), 3u);
  EXPECT_EQ(h.levels[1].mesh.n_faces(), 3000u);
  EXPECT_EQ(h.levels[2].mesh.n_faces(), 700u) << "a collapse in a closed surface takes two triangles";
  options.faces = {100, 200};
  EXPECT_THROW(build_hierarchy(mesh_of(test::grid(2)), "x", options), OptionError);
  options.faces = {100, 0};
  EXPECT_THROW(build_hierarchy(mesh_of(test::grid(2)), "x", options), OptionError);
}

TEST(LodHierarchy, LevelsByErrorKeepTheirBound) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(6000, true));
  HierarchyOptions options;
  options.errors = {0.005, 0.02, 0.08};
  const LodHierarchy h = build_hierarchy(mesh, "ball", options);
  ASSERT_EQ(h.levels.size(), 4u);
  for (std::size_t i = 1; i < 4; ++i) {
    // Measured again by other samples and a finer certificate.
    const MeshDistance d =
        measure_distance(mesh, h.levels[i].mesh, {.samples = 77'777, .bound_tolerance = 0.02});
    EXPECT_LE(d.max, options.errors[i - 1]);
    EXPECT_LE(h.levels[i].error.bound, options.errors[i - 1]);
    EXPECT_GT(h.levels[i].error.bound, 0.4 * options.errors[i - 1]) << "the level could be much coarser";
    EXPECT_LT(h.levels[i].mesh.n_faces(), h.levels[i - 1].mesh.n_faces());
  }
}

TEST(LodHierarchy, LevelsByDistanceServeFromThereOn) {
  HierarchyOptions options;
  options.distances = {5, 20};
  const LodHierarchy h = build_hierarchy(mesh_of(make_displaced_sphere(6000, true)), "ball", options);
  ASSERT_EQ(h.levels.size(), 3u);
  EXPECT_LE(h.levels[1].switch_distance, 5);
  EXPECT_LE(h.levels[2].switch_distance, 20);
  EXPECT_GT(h.levels[2].switch_distance, 8);
}

TEST(LodHierarchy, AnErrorThatNothingKeepsRepeatsTheLevelBefore) {
  const PolygonMesh mesh = mesh_of(test::soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                                 {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}));
  HierarchyOptions options;
  options.errors = {1e-9};
  const LodHierarchy h = build_hierarchy(mesh, "tetrahedron", options);
  EXPECT_EQ(h.levels[1].mesh.n_faces(), 4u);
  EXPECT_LE(h.levels[1].error.bound, 1e-9);
}

TEST(LodHierarchy, RelativeErrorsAreSharesOfTheDiagonal) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(2000, false));
  HierarchyOptions options;
  options.relative_errors = {0.01};
  const LodHierarchy by_shares = build_hierarchy(mesh, "ball", options);
  const double diagonal = summarize(mesh).box.diagonal().norm();
  EXPECT_LE(by_shares.levels[1].error.bound, 0.01 * diagonal);
  options.relative_errors.clear();
  options.errors = {0.01 * diagonal};
  EXPECT_EQ(build_hierarchy(mesh, "ball", options).levels[1].mesh.n_faces(),
            by_shares.levels[1].mesh.n_faces());
}

TEST(LodHierarchy, HasLevelsWithoutOptions) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(2000, false));
  const LodHierarchy h = build_hierarchy(mesh, "ball", {});
  ASSERT_EQ(h.levels.size(), 6u);
  const double shares[] = {1, 0.5, 0.25, 0.1, 0.03, 0.01};
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_LE(h.levels[i].mesh.n_faces(), std::ceil(shares[i] * static_cast<double>(mesh.n_faces()))) << i;
}

TEST(LodHierarchy, RefusesContradictingOptions) {
  const PolygonMesh mesh = mesh_of(test::grid(2));
  HierarchyOptions both = by_ratios({0.5});
  both.errors = {1};
  EXPECT_THROW(build_hierarchy(mesh, "x", both), OptionError);
  EXPECT_THROW(build_hierarchy(mesh, "x", by_ratios({0.1, 0.5})), OptionError);
  EXPECT_THROW(build_hierarchy(mesh, "x", by_ratios({1.5})), OptionError);
  EXPECT_THROW(build_hierarchy(PolygonMesh{}, "x", by_ratios({0.5})), InputError);
}

nlohmann::json json_of_glb(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::uint32_t length = 0;
  std::copy_n(bytes.data() + 12, 4, reinterpret_cast<char*>(&length));
  return nlohmann::json::parse(bytes.substr(20, length));
}

std::string picture_of_glb(const fs::path& path, std::size_t image) {
  const nlohmann::json document = json_of_glb(path), picture = document.at("images").at(image);
  const nlohmann::json view = document.at("bufferViews").at(picture.at("bufferView").get<std::size_t>());
  EXPECT_EQ(picture.at("mimeType"), "image/png");
  const std::string bytes = read_whole_file(path);
  std::uint32_t length = 0;  // of the JSON; the binary chunk's data start 8 bytes behind it
  std::copy_n(bytes.data() + 12, 4, reinterpret_cast<char*>(&length));
  return bytes.substr(20 + length + 8 + view.at("byteOffset").get<std::size_t>(),
                      view.at("byteLength").get<std::size_t>());
}

TEST(LodHierarchy, TheGlbNamesItsLevelsOnTheFirstSceneNode) {
  const test::TempFolder folder;
  const LodHierarchy h =
      build_hierarchy(mesh_of(make_displaced_sphere(3000, false)), "ball", by_ratios({0.5, 0.1}));
  const HierarchyFiles files = write_hierarchy(folder.path(), h);
  const nlohmann::json glb = json_of_glb(files.glb);
  ASSERT_EQ(glb["scenes"][0]["nodes"].size(), 1u) << "coarser levels aren't in the scene of their own";
  const auto& node = glb["nodes"][glb["scenes"][0]["nodes"][0].get<std::size_t>()];
  EXPECT_EQ(node["extensions"]["MSFT_lod"]["ids"].size(), 2u);
  const auto coverage = node["extras"]["MSFT_screencoverage"].get<std::vector<double>>();
  ASSERT_EQ(coverage.size(), 3u) << "one for each level";
  EXPECT_GE(coverage[0], coverage[1]);
  EXPECT_EQ(coverage[2], 0);
  EXPECT_THAT(glb["extensionsUsed"], ::testing::Contains("MSFT_lod"));
  // Read back, the file is its finest level, as triangles.
  EXPECT_EQ(read_soup(files.glb).n_faces(), 2 * h.levels[0].mesh.n_faces());
}

TEST(LodHierarchy, MapsOfEveryCoarserLevelAreFilesAndInTheGlb) {
  const test::TempFolder folder;
  HierarchyOptions options = by_ratios({0.3, 0.1});
  options.maps = MapOptions{.size = 128};
  PolygonSoup soup = make_displaced_sphere(3000, false);
  for (const Vec3& p : soup.positions) soup.vertex_colors.emplace_back(p.x() * p.x(), 0.5, 1, 1);
  const LodHierarchy h = build_hierarchy(mesh_of(soup), "red ball", options);
  EXPECT_FALSE(h.levels[0].maps.has_value());
  const HierarchyFiles files = write_hierarchy(folder.path(), h);
  const nlohmann::json glb = json_of_glb(files.glb);
  for (std::size_t i = 1; i < 3; ++i) {
    const BakedMaps& maps = h.levels[i].maps.value();
    EXPECT_DOUBLE_EQ(maps.report.search_distance, MapOptions::k_reach * h.levels[i].error.bound);
    EXPECT_LT(h.levels[i].map_accuracy->rms, h.levels[i].map_accuracy->bare_rms);
    EXPECT_EQ(read_whole_file(files.map_files[i].displacement), encode_png(maps.displacement));
    EXPECT_EQ(read_whole_file(files.map_files[i].normal), encode_png(maps.normal));
    EXPECT_EQ(read_whole_file(files.map_files[i].color), encode_png(maps.color));
    EXPECT_EQ(read_soup(files.level_files[i]).corner_uvs.size(), maps.surface.n_corners());

    const nlohmann::json& mesh = glb.at("meshes")[i];
    const nlohmann::json& heights = mesh.at("extras").at("recede_displacement");
    EXPECT_EQ(picture_of_glb(files.glb, heights.at("image")), encode_png(maps.displacement));
    EXPECT_EQ(heights.at("scale"), maps.height_scale);
    EXPECT_EQ(heights.at("offset"), maps.height_offset);
    ASSERT_EQ(mesh.at("primitives").size(), 1u);
    const nlohmann::json& primitive = mesh.at("primitives")[0];
    EXPECT_TRUE(primitive.at("attributes").contains("TANGENT"));
    EXPECT_FALSE(primitive.at("attributes").contains("COLOR_0")) << "colours are in the map";
    const nlohmann::json& material = glb.at("materials")[primitive.at("material").get<std::size_t>()];
    const auto picture = [&](const nlohmann::json& texture) {
      return picture_of_glb(files.glb,
                            glb.at("textures")[texture.at("index").get<std::size_t>()].at("source"));
    };
    EXPECT_EQ(picture(material.at("normalTexture")), encode_png(maps.normal));
    EXPECT_EQ(picture(material.at("pbrMetallicRoughness").at("baseColorTexture")), encode_png(maps.color));
  }
  for (const nlohmann::json& image : glb.at("images")) EXPECT_FALSE(image.contains("uri"));
  EXPECT_FALSE(glb.at("meshes")[0].contains("extras"));
  const LodHierarchy back = read_hierarchy(files.folder);
  ASSERT_EQ(back.levels.size(), 3u);
  EXPECT_FALSE(back.levels[0].maps.has_value());
  for (std::size_t i = 1; i < 3; ++i) {
    const BakedMaps &written = *h.levels[i].maps, &read = back.levels[i].maps.value();
    EXPECT_EQ(read.size, written.size);
    EXPECT_EQ(read.displacement, written.displacement);
    EXPECT_EQ(read.height_scale, written.height_scale);
    EXPECT_EQ(read.height_offset, written.height_offset);
    EXPECT_EQ(read.normal, written.normal);
    EXPECT_EQ(read.color.samples, written.color.samples);
    EXPECT_EQ(read.surface.corner_uvs, written.surface.corner_uvs);
    EXPECT_EQ(read.surface.corner_normals, written.surface.corner_normals);
    EXPECT_EQ(read.corner_tangents, written.corner_tangents);
    EXPECT_EQ(read.report.atlas_reason, written.report.atlas_reason);
    EXPECT_EQ(dice_surface(read).positions, dice_surface(written).positions);
  }
  // Maps that don't fit are refused.
  write_file_atomically(files.map_files[2].normal, encode_png(back.levels[1].maps->displacement));
  EXPECT_THAT(test::error_text([&] { read_hierarchy(files.folder); }),
              testing::HasSubstr("square map of 3 channels"));
  Raster bytes = back.levels[1].maps->displacement;
  bytes.bits = 8;
  for (std::uint16_t& sample : bytes.samples) sample = static_cast<std::uint16_t>(sample / 257);
  write_file_atomically(files.map_files[1].displacement, encode_png(bytes));
  EXPECT_THAT(test::error_text([&] { read_hierarchy(files.folder); }),
              testing::HasSubstr("level_1_displacement.png: isn't a map of heights, which has 16 bits"));
}

TEST(LodHierarchy, PicturesOfTheInputAreInTheGlbAndTheFolder) {
  const test::TempFolder folder;
  PolygonSoup soup = make_atlas(make_displaced_sphere(1500, true)).soup;
  soup.materials = {{"skin", Vec4::Ones(), "scans/skin.png"}};
  soup.materials[0].base_color_picture = test::png_of(test::four_quarters());
  soup.face_materials.assign(soup.n_faces(), 0);
  const LodHierarchy h = build_hierarchy(mesh_of(soup), "ball", by_ratios({0.3}));
  const HierarchyFiles files = write_hierarchy(folder.path() / "out", h);
  const nlohmann::json glb = json_of_glb(files.glb);
  ASSERT_EQ(glb.at("images").size(), 1u) << "one for both levels";
  EXPECT_EQ(picture_of_glb(files.glb, 0), *soup.materials[0].base_color_picture);
  EXPECT_EQ(read_whole_file(files.folder / "skin.png"), *soup.materials[0].base_color_picture);
  const LodHierarchy back = read_hierarchy(files.folder);
  for (const LodLevel& level : back.levels) {
    ASSERT_TRUE(level.mesh.materials.at(0).base_color_picture);
    EXPECT_EQ(*level.mesh.materials[0].base_color_picture, *soup.materials[0].base_color_picture);
  }
}

TEST(LodHierarchy, FloatMapsLieBesideTheOthersAndAreNamed) {
  const test::TempFolder folder;
  HierarchyOptions options = by_ratios({0.3});
  options.maps = MapOptions{.size = 64, .format = MapFormat::exr};
  const LodHierarchy h = build_hierarchy(mesh_of(make_displaced_sphere(1500, true)), "ball", options);
  const HierarchyFiles files = write_hierarchy(folder.path(), h);
  const BakedMaps& maps = h.levels[1].maps.value();
  EXPECT_EQ(read_exr(files.map_files[1].displacement_exr), maps.float_displacement) << "bit for bit";
  const FloatRaster normal = read_exr(files.map_files[1].normal_exr);
  EXPECT_EQ(normal.channels, (std::vector<std::string>{"R", "G", "B"}));
  for (std::size_t i = 0; i < normal.samples.size(); ++i)
    ASSERT_NEAR(normal.samples[i], maps.float_normal.samples[i], 1.0 / 4096)
        << "half a step of halves below 1";
  EXPECT_TRUE(std::filesystem::exists(files.map_files[1].displacement)) << "what the GLB has";
  const auto document = nlohmann::json::parse(read_whole_file(files.folder / "hierarchy.json"));
  EXPECT_EQ(document.at("levels")[1].at("displacement").at("exr"), "level_1_displacement.exr");
  EXPECT_EQ(document.at("levels")[1].at("normal").at("exr"), "level_1_normal.exr");
}

TEST(LodHierarchy, ANormalMapKeepsTheMaterialsOfTheInput) {
  const test::TempFolder folder;
  HierarchyOptions options = by_ratios({0.3});
  options.maps = MapOptions{.displacement = false, .color = false, .size = 64};
  PolygonSoup soup = make_displaced_sphere(1500, true);
  soup.materials = {{"red", {1, 0, 0, 1}, "old.png"}};
  for (const Index v : soup.corner_vertices) soup.corner_uvs.emplace_back(soup.positions[v].head<2>());
  for (std::size_t f = 0; f < soup.n_faces(); ++f) soup.face_materials.push_back(f % 2 == 0 ? 0 : k_no_index);
  const LodHierarchy h = build_hierarchy(mesh_of(soup), "ball", options);
  EXPECT_FALSE(h.levels[1].map_accuracy.has_value());
  const nlohmann::json glb = json_of_glb(write_hierarchy(folder.path(), h).glb);
  std::size_t with_normals = 0;
  for (const nlohmann::json& material : glb.at("materials")) {
    if (!material.contains("normalTexture")) continue;
    ++with_normals;
    EXPECT_FALSE(material.at("pbrMetallicRoughness").contains("baseColorTexture")) << "made for other uvs";
  }
  EXPECT_EQ(with_normals, 2u) << "red, and that of faces without one";
}

TEST(LodHierarchy, TheInputHasNormalsInTheGlbFileWhereLevelsWithMapsHave) {
  const test::TempFolder folder;
  HierarchyOptions options = by_ratios({0.3});
  const PolygonMesh ball = mesh_of(make_displaced_sphere(1500, true));
  const auto has_normals = [&](std::size_t level) {
    const nlohmann::json glb =
        json_of_glb(write_hierarchy(folder.path(), build_hierarchy(ball, "ball", options)).glb);
    return glb.at("meshes")[level].at("primitives")[0].at("attributes").contains("NORMAL");
  };
  EXPECT_FALSE(has_normals(0));
  EXPECT_FALSE(has_normals(1));
  options.maps = MapOptions{.color = false, .size = 64};
  EXPECT_TRUE(has_normals(0));
  EXPECT_TRUE(has_normals(1));
  EXPECT_TRUE(read_soup(folder / "ball.recede/level_0.ply").corner_normals.empty()) << "as it was given";
}

TEST(LodHierarchy, PolygonsAndNumbersComeBackFromTheFolder) {
  const test::TempFolder folder;
  PolygonSoup soup = make_displaced_sphere(2000, false);
  soup.materials = {{"stone", {0.5, 0.5, 0.4, 1}, ""}};
  soup.face_materials.assign(soup.n_faces(), 0);
  const LodHierarchy h = build_hierarchy(mesh_of(soup), "ball", by_ratios({0.3, 0.1}));
  const HierarchyFiles files = write_hierarchy(folder.path(), h);
  const LodHierarchy back = read_hierarchy(files.folder);
  EXPECT_EQ(back.name, "ball");
  EXPECT_EQ(back.view.image_height, h.view.image_height);
  EXPECT_EQ(back.radius, h.radius);
  ASSERT_EQ(back.levels.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const PolygonSoup a = to_soup(h.levels[i].mesh), b = to_soup(back.levels[i].mesh);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.face_offsets, b.face_offsets);
    EXPECT_EQ(a.corner_vertices, b.corner_vertices);
    EXPECT_EQ(a.materials, b.materials);
    EXPECT_EQ(back.levels[i].error.bound, h.levels[i].error.bound);
    EXPECT_EQ(back.levels[i].switch_distance, h.levels[i].switch_distance);
    EXPECT_EQ(back.levels[i].stop_reason, h.levels[i].stop_reason);
    EXPECT_EQ(files.level_bytes[i], fs::file_size(files.level_files[i]));
  }
}

TEST(LodHierarchy, WritingAgainReplacesTheFolder) {
  const test::TempFolder folder;
  const PolygonMesh mesh = mesh_of(test::grid(8));
  write_hierarchy(folder.path(), build_hierarchy(mesh, "grid", by_ratios({0.5, 0.2})));
  const HierarchyFiles files =
      write_hierarchy(folder.path(), build_hierarchy(mesh, "grid", by_ratios({0.5})));
  EXPECT_EQ(read_hierarchy(files.folder).levels.size(), 2u);
  EXPECT_FALSE(fs::exists(files.folder / "level_2.ply"));
  std::size_t entries = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder.path())) ++entries;
  EXPECT_EQ(entries, 2u) << "the GLB and the folder";
}

TEST(LodHierarchy, ADamagedFolderIsAnErrorThatNamesTheFile) {
  const test::TempFolder folder;
  const HierarchyFiles files =
      write_hierarchy(folder.path(), build_hierarchy(mesh_of(test::grid(8)), "grid", by_ratios({0.5})));
  const std::string whole = read_whole_file(files.folder / "hierarchy.json");
  fs::remove(files.level_files[1]);
  EXPECT_THROW(read_hierarchy(files.folder), InputError);
  std::ofstream(files.folder / "hierarchy.json") << "{\"format\": \"recede hierarchy\", \"version\": 1";
  EXPECT_THROW(read_hierarchy(files.folder), InputError);
  EXPECT_THROW(read_hierarchy(folder.path() / "nothing"), InputError);
  nlohmann::json list = nlohmann::json::parse(whole);
  list["levels"] = nlohmann::json::array();
  std::ofstream(files.folder / "hierarchy.json") << list;
  EXPECT_THAT(test::error_text([&] { read_hierarchy(files.folder); }),
              testing::HasSubstr("hierarchy.json: names no levels"));
}

}  // namespace
}  // namespace recede
