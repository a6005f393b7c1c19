#include "input_errors.h"
#include "pictures.h"
#include "simple_soups.h"
#include "soups.h"
#include <recede/geometry/detail/base64.h>
#include <recede/geometry/gltf_writer.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <set>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

int validate_gltf(const std::vector<std::filesystem::path>& files) {
  std::string command = fmt::format("node '{}' '{}'", RECEDE_VALIDATE_GLTF, RECEDE_NODE_MODULES);
  for (const auto& file : files) command += fmt::format(" '{}'", file.string());
  return std::system(command.c_str());
}

TEST(GltfRoundTrip, PicturesOfMaterialsGoWithTheFile) {
  const TempFolder folder;
  PolygonSoup soup = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  for (const Index v : soup.corner_vertices) soup.corner_uvs.push_back(soup.positions[v].head<2>());
  soup.materials.resize(3);
  for (Material& material : soup.materials) material.base_color_texture = "skins/a.png";
  soup.materials[0].name = "one";
  soup.materials[0].base_color_picture = soup.materials[1].base_color_picture = png_of(four_colors());
  soup.materials[1].normal_texture = "n.png";
  soup.materials[1].normal_picture = png_of(raster_of(1, 1, {{128, 128, 255}}));
  soup.face_materials = {0, 1};
  for (const char* name : {"a.glb", "a.gltf"}) {
    write_soup(folder / name, soup);
    const std::vector<Material> back = read_soup(folder / name).materials;
    ASSERT_EQ(back.size(), 2u);
    for (std::size_t m = 0; m < 2; ++m) {
      EXPECT_EQ(back[m].base_color_texture, "skins/a.png");
      EXPECT_EQ(*back[m].base_color_picture, *soup.materials[0].base_color_picture);
    }
    EXPECT_EQ(back[1].normal_texture, "n.png");
    EXPECT_EQ(*back[1].normal_picture, *soup.materials[1].normal_picture);
  }
  const json document = json::parse(read_whole_file(folder / "a.gltf"));
  EXPECT_EQ(document["images"].size(), 2u) << "each once";
  EXPECT_EQ(validate_gltf({folder / "a.glb", folder / "a.gltf"}), 0);
}

TEST(GltfWriter, SplitsVerticesWhereTheirCornersDiffer) {
  const TempFolder folder;
  PolygonSoup soup = two_triangles();
  EXPECT_THAT(write_soup(folder / "a.glb", soup).written_without, IsEmpty());
  EXPECT_EQ(read_soup(folder / "a.glb").positions.size(), 4u);
  soup.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0.5, 0}, {1, 1}, {0, 1}};  // the corner at the origin differs
  write_soup(folder / "a.glb", soup);
  const PolygonSoup back = read_soup(folder / "a.glb");
  EXPECT_EQ(back.positions.size(), 5u);
  EXPECT_EQ(back.corner_uvs, soup.corner_uvs);
}

TEST(GltfWriter, GivesFaceNormalsToCornersWithoutNormal) {
  const TempFolder folder;
  PolygonSoup soup = two_triangles();
  soup.corner_normals = {{0, 3, 0}, {0, 0, 0}, {0, 3, 0}, {0, 3, 0}, {0, 3, 0}, {0, 3, 0}};
  write_soup(folder / "a.glb", soup);
  EXPECT_THAT(
      read_soup(folder / "a.glb").corner_normals,
      ElementsAre(Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, 1, 0), Vec3(0, 1, 0), Vec3(0, 1, 0), Vec3(0, 1, 0)));
}

TEST(GltfWriter, KeepsTheDetailOfModelsFarFromTheOrigin) {
  const TempFolder folder;
  PolygonSoup soup = two_triangles();
  const Vec3 far(4e6, -5e6, 1e5);
  for (Vec3& position : soup.positions) position = 0.1234567 * position + far;
  write_soup(folder / "a.glb", soup);
  const PolygonSoup back = read_soup(folder / "a.glb");
  for (std::size_t i = 0; i < soup.n_corners(); ++i) {
    EXPECT_LT((back.positions[back.corner_vertices[i]] - soup.positions[soup.corner_vertices[i]]).norm(),
              1e-6);
  }
}

TEST(GltfWriter, SaysWhatIsMissing) {
  const TempFolder folder;
  PolygonSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0.1, 0}, {5, 5, 5}};
  soup.add_face(std::vector<Index>{0, 1, 2, 3});
  soup.materials = {{"wood", {1, 1, 1, 1}, "wood.png"}, {"unused", {1, 1, 1, 1}, ""}};
  soup.face_materials = {0};
  soup.feature_edges = {{0, 1}, {1, 2}};
  EXPECT_THAT(
      write_soup(folder / "a.gltf", soup).written_without,
      ElementsAre("1 polygon with more than three corners (cut into triangles)", "1 vertex that no face uses",
                  "2 feature edges", "textures (there are no texture coordinates)",
                  "1 material that no face uses", "double precision (positions rounded to 32-bit floats)"));
}

TEST(GltfWriter, RefusesMeshesWithoutTriangles) {
  const TempFolder folder;
  PolygonSoup soup;
  soup.positions = {{0, 0, 0}};
  EXPECT_THROW(write_soup(folder / "a.glb", soup), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.glb"));
}

TEST(GltfRoundTrip, KeepsCornersAttributesAndMaterials) {
  const TempFolder folder;
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const PolygonSoup soup = random_soup(seed, {.floats = true});
    const char* name = seed % 2 == 0 ? "a.glb" : "a.gltf";
    write_soup(folder / name, soup);
    const PolygonSoup back = read_soup(folder / name);
    // Primitives are sorted by material: compare what stands at each corner as a sorted list.
    const auto corners = [](const PolygonSoup& s, const std::vector<Index>& faces,
                            const std::vector<Index>& list) {
      std::vector<std::array<float, 9>> result;
      for (std::size_t i = 0; i < list.size(); ++i) {
        const Vec3 p = s.positions[s.corner_vertices[list[i]]], n = s.corner_normals[list[i]].normalized();
        const Index m = s.face_materials[faces[i / 3]];
        const double red = m == k_no_index ? -1.0 : s.materials[m].base_color[0];
        result.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
                          static_cast<float>(s.corner_uvs[list[i]].x()),
                          static_cast<float>(1.0 - s.corner_uvs[list[i]].y()),
                          std::round(static_cast<float>(n.x()) * 1e5f), static_cast<float>(red),
                          static_cast<float>(s.vertex_colors[s.corner_vertices[list[i]]][0]), 0.0f});
      }
      std::sort(result.begin(), result.end());
      return result;
    };
    std::vector<Index> faces, list, back_faces, back_list;
    triangulate(soup, &faces, &list);
    triangulate(back, &back_faces, &back_list);
    EXPECT_EQ(corners(back, back_faces, back_list), corners(soup, faces, list));
  }
}

TEST(GltfBuilder, SharesMaterialsAndTakesExtensionsOfNodes) {
  const TempFolder folder;
  PolygonSoup soup = two_triangles();
  soup.materials = {{"wood", {1, 0.5, 0, 1}, ""}};
  soup.face_materials = {0, 0};
  GltfBuilder builder;
  const auto fine = static_cast<std::size_t>(builder.add_node(builder.add_mesh(soup, "fine"), "fine"));
  const int coarse = builder.add_node(builder.add_mesh(soup, "coarse"), "coarse");
  builder.add_to_scene(static_cast<int>(fine));
  json& document = builder.document();
  document["nodes"][fine]["extensions"]["MSFT_lod"]["ids"] = {coarse};
  document["nodes"][fine]["extras"]["MSFT_screencoverage"] = {0.5, 0.1};
  document["extensionsUsed"] = {"MSFT_lod"};
  EXPECT_EQ(document["materials"].size(), 1u);
  EXPECT_EQ(document["meshes"].size(), 2u);
  EXPECT_EQ(read_soup(folder.write("a.glb", builder.to_glb())).n_faces(), 2u) << "the finest level only";
  EXPECT_EQ(read_soup(folder.write("a.gltf", builder.to_gltf())).n_faces(), 2u);
}

// Viewers draw what has no material as dark metal.
TEST(GltfBuilder, PaintsWhatHasNoMaterialAndReadsNoneBack) {
  const TempFolder folder;
  PolygonSoup bare = two_triangles(), colored = bare, half = bare;
  colored.vertex_colors.assign(colored.positions.size(), Vec4(1, 0, 0, 1));
  half.materials = {{"wood", {1, 0.5, 0, 1}, ""}};
  half.face_materials = {0, k_no_index};
  for (const PolygonSoup& soup : {bare, colored, half}) {
    GltfBuilder builder;
    builder.add_to_scene(builder.add_node(builder.add_mesh(soup, "a"), "a"));
    const json document = json::parse(builder.to_gltf());
    for (const json& primitive : document["meshes"][0]["primitives"]) {
      const json& surface = document["materials"].at(primitive.at("material").get<std::size_t>());
      EXPECT_EQ(surface["pbrMetallicRoughness"]["metallicFactor"], 0.0);
      EXPECT_EQ(surface["doubleSided"], true);
    }
    const PolygonSoup back = read_soup(folder.write("a.gltf", builder.to_gltf()));
    EXPECT_EQ(back.materials, soup.materials);
    EXPECT_EQ(back.face_materials, soup.face_materials);
  }
  GltfBuilder builder;
  builder.add_mesh(bare, "bare");
  builder.add_mesh(colored, "colored");
  builder.add_mesh(bare, "bare again");
  const json document = json::parse(builder.to_gltf());
  ASSERT_EQ(document["materials"].size(), 2u);
  EXPECT_LT(document["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][0], 1.0);
  EXPECT_EQ(document["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"][0], 1.0);
}

TEST(GltfBuilder, PutsAMeshInSeveralPlacesAndColoursWithOneCopyOfItsData) {
  const TempFolder folder;
  PolygonSoup soup;
  soup.positions = {{1e7, 0, 0}, {1e7 + 1, 0, 0}, {1e7, 2, 0}};
  soup.add_face(std::array<Index, 3>{0, 1, 2});
  soup.corner_normals.assign(3, Vec3::UnitZ());
  GltfBuilder builder;
  const int plain = builder.add_mesh(soup, "part"), red = builder.copy_mesh(plain);
  builder.paint_mesh(red, {"red", {1, 0, 0, 1}, ""});
  const int all = builder.add_node(-1, "all");
  Eigen::Affine3d turned = Eigen::Affine3d::Identity(), mirrored = turned, moved = turned;
  turned.linear() << 0, -3, 0, 3, 0, 0, 0, 0, 3;
  mirrored.linear().diagonal() = Vec3(1, 1, -1);
  moved.translation() = Vec3(0, 0, 7);
  builder.add_child(all, builder.add_node(plain, "turned", turned));
  builder.add_child(all, builder.add_node(red, "mirrored", mirrored));
  builder.add_child(all, builder.add_node(plain, "moved", moved));
  builder.add_to_scene(all);
  EXPECT_EQ(builder.document()["accessors"].size(), 3u) << "positions, normals and indices once";
  EXPECT_FALSE(builder.document()["nodes"][3].contains("matrix")) << "a translation says less";
  const PolygonSoup back = read_soup(folder.write("parts.glb", builder.to_glb()));
  // The file has coordinates near its middle, of which floats keep all of these.
  EXPECT_THAT(back.positions, ElementsAre(Vec3(0, 3e7, 0), Vec3(0, 3e7 + 3, 0), Vec3(-6, 3e7, 0),
                                          Vec3(1e7, 0, 0), Vec3(1e7 + 1, 0, 0), Vec3(1e7, 2, 0),
                                          Vec3(1e7, 0, 7), Vec3(1e7 + 1, 0, 7), Vec3(1e7, 2, 7)));
  EXPECT_EQ(vector_area(back, 0), Vec3(0, 0, 9));
  EXPECT_EQ(vector_area(back, 1), Vec3(0, 0, -1)) << "turned as its normals are";
  EXPECT_EQ(back.corner_normals[3], -Vec3::UnitZ());
  EXPECT_THAT(back.face_materials, ElementsAre(k_no_index, 0, k_no_index));
}

TEST(GltfBuilder, WritesTangentsAndSplitsVerticesWhereTheyDiffer) {
  PolygonSoup soup = test::two_triangles();
  for (const Index v : soup.corner_vertices) {
    soup.corner_uvs.emplace_back(soup.positions[v].head<2>());
    soup.corner_normals.push_back(Vec3::UnitZ());
  }
  soup.materials = {{"", {1, 1, 1, 1}, "", "bumps of stone.png"}};
  soup.face_materials = {0, 0};
  std::vector<Vec4> tangents(6, Vec4(1, 0, 0, 1));
  tangents[0].w() = -1;
  GltfBuilder builder;
  builder.add_to_scene(
      builder.add_node(builder.add_mesh(soup, "sheet", {.corner_tangents = tangents}), "sheet"));
  const json& document = builder.document();
  const json& attributes = document.at("meshes")[0].at("primitives")[0].at("attributes");
  const json& accessor = document.at("accessors")[attributes.at("TANGENT").get<std::size_t>()];
  EXPECT_EQ(accessor.at("type"), "VEC4");
  EXPECT_EQ(accessor.at("count"), 5);
  EXPECT_EQ(document.at("images")[0].at("uri"), "bumps%20of%20stone.png");
  const test::TempFolder folder;
  EXPECT_EQ(read_soup(folder.write("sheet.glb", builder.to_glb())).materials[0].normal_texture,
            "bumps of stone.png");
}

std::vector<float> values_of(GltfBuilder& builder, const json& attributes, const char* name) {
  const json& document = builder.document();
  const json& accessor = document.at("accessors")[attributes.at(name).get<std::size_t>()];
  const json& view = document.at("bufferViews")[accessor.at("bufferView").get<std::size_t>()];
  const json text = json::parse(builder.to_gltf());
  const std::string uri = text.at("buffers")[0].at("uri").get<std::string>();
  const std::string buffer = detail::decode_base64(uri.substr(uri.find(',') + 1)).value();
  std::vector<float> values(view.at("byteLength").get<std::size_t>() / sizeof(float));
  std::memcpy(values.data(), buffer.data() + view.at("byteOffset").get<std::size_t>(),
              values.size() * sizeof(float));
  return values;
}

TEST(GltfBuilder, WritesAMorphTargetAndParents) {
  PolygonSoup soup = test::two_triangles();
  for (const Index v : soup.corner_vertices) soup.corner_uvs.emplace_back(soup.positions[v].head<2>());
  PolygonSoup target = soup;
  target.positions[3] += Vec3(0, 0, 0.5);
  target.corner_uvs[1] += Vec2(0.25, 0.5);
  const std::vector<Index> parents{7, 1, 0, k_no_index};
  GltfBuilder builder;
  builder.add_to_scene(builder.add_node(
      builder.add_mesh(soup, "sheet", {.morph_target = &target, .morph_name = "coarse", .parents = parents}),
      "sheet"));
  json& mesh = builder.document()["meshes"][0];
  EXPECT_EQ(mesh.at("weights"), json({0.0}));
  EXPECT_EQ(mesh.at("extras").at("targetNames"), json({"coarse"}));
  const json& primitive = mesh.at("primitives")[0];
  const std::vector<float> moved = values_of(builder, primitive.at("targets")[0], "POSITION");
  EXPECT_EQ(std::count(moved.begin(), moved.end(), 0.5f), 1);
  EXPECT_EQ(std::count(moved.begin(), moved.end(), 0.0f) + 1, static_cast<std::ptrdiff_t>(moved.size()));
  // glTF's v points down.
  EXPECT_THAT(values_of(builder, primitive.at("targets")[0], "TEXCOORD_0"), testing::Contains(-0.5f));
  const std::vector<float> parent = values_of(builder, primitive.at("attributes"), "_PARENT");
  EXPECT_EQ(std::set<float>(parent.begin(), parent.end()), (std::set<float>{7, 1, 0, -1}));
}

TEST(GltfWriter, PassesTheKhronosValidator) {
  if (!std::filesystem::exists(std::filesystem::path(RECEDE_NODE_MODULES) / "gltf-validator")) {
    GTEST_SKIP() << "the glTF validator isn't installed; ./dev test fetches it";
  }
  const TempFolder folder;
  std::vector<std::filesystem::path> files;
  const auto write = [&](const PolygonSoup& soup, const char* extension) {
    files.push_back(folder / fmt::format("{}{}", files.size(), extension));
    write_soup(files.back(), soup);
  };
  for (unsigned seed = 0; seed < 10; ++seed) {
    write(random_soup(seed), ".glb");
    write(random_soup(seed, {.attributes = false}), ".gltf");
  }
  PolygonSoup far = two_triangles();
  for (Vec3& position : far.positions) position += Vec3(1e7, 0, 0);
  write(far, ".glb");
  PolygonSoup no_area = two_triangles();
  no_area.corner_normals.assign(6, Vec3::Zero());
  no_area.positions[2] = no_area.positions[1];
  write(no_area, ".glb");
  constexpr const char* k_pixel =
      "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==";
  folder.write("oak planks.png", detail::decode_base64(k_pixel).value());
  for (unsigned seed = 0; seed < 4; ++seed) {
    const PolygonSoup soup = random_soup(seed);
    PolygonSoup target = soup;
    for (Vec3& position : target.positions) position *= 0.5;
    const std::vector<Index> parents(soup.positions.size(), 3);
    GltfBuilder builder;
    builder.add_to_scene(builder.add_node(
        builder.add_mesh(soup, "a", {.morph_target = &target, .morph_name = "b", .parents = parents}), "a"));
    files.push_back(folder.write(fmt::format("morph{}.glb", seed), builder.to_glb()));
  }
  EXPECT_EQ(validate_gltf(files), 0);
  std::string damaged = read_whole_file(files.front());
  damaged.resize(damaged.size() - 4);
  EXPECT_NE(validate_gltf({folder.write("damaged.glb", damaged)}), 0)
      << "the validator complains when it should";
}

}  // namespace
}  // namespace recede::test
