#include "input_errors.h"
#include "pictures.h"
#include "soups.h"
#include <recede/geometry/detail/base64.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A document by hand: accessors are added one by one, all in one buffer inside the text.
class HandMade {
 public:
  json document{{"asset", {{"version", "2.0"}}}, {"scenes", json::array({{{"nodes", {0}}}})}};

  template <class Value>
  int accessor(const char* type, int component_type, std::size_t components,
               const std::vector<Value>& values) {
    buffer_.resize((buffer_.size() + 3) / 4 * 4);
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", values.size() * sizeof(Value)}});
    buffer_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", component_type},
                                     {"count", values.size() / components},
                                     {"type", type}});
    return static_cast<int>(document["accessors"].size()) - 1;
  }
  // The unit square's four corners in the order of a strip.
  int square() { return accessor<float>("VEC3", 5126, 3, {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}); }
  int indices(const std::vector<std::uint16_t>& values) { return accessor("SCALAR", 5123, 1, values); }
  void primitive(json value) { document["meshes"][0]["primitives"].push_back(std::move(value)); }
  void node(json value = json::object()) {
    value["mesh"] = 0;
    document["nodes"].push_back(std::move(value));
  }
  std::string text() const {
    json result = document;
    result["buffers"] = {{{"byteLength", buffer_.size()},
                          {"uri", "data:application/octet-stream;base64," + detail::encode_base64(buffer_)}}};
    return result.dump(1);
  }
  const std::string& buffer() const { return buffer_; }

 private:
  std::string buffer_;
};

HandMade square_with(json primitive) {
  HandMade made;
  primitive["attributes"]["POSITION"] = made.square();
  made.primitive(std::move(primitive));
  made.node();
  return made;
}

double total_area_z(const PolygonSoup& soup) {
  double area = 0.0;
  for (std::size_t face = 0; face < soup.n_faces(); ++face) area += vector_area(soup, face).z();
  return area;
}

TEST(GltfReader, ReadsTrianglesStripsAndFansWithAndWithoutIndices) {
  HandMade triangles = square_with({});
  triangles.document["meshes"][0]["primitives"][0]["indices"] = triangles.indices({0, 1, 3, 0, 3, 2});
  EXPECT_THAT(read_text("a.gltf", triangles.text()).corner_vertices, ElementsAre(0, 1, 3, 0, 3, 2));
  EXPECT_THAT(read_text("a.gltf", square_with({{"mode", 5}}).text()).corner_vertices,
              ElementsAre(0, 1, 2, 1, 3, 2));
  EXPECT_THAT(read_text("a.gltf", square_with({{"mode", 6}}).text()).corner_vertices,
              ElementsAre(0, 1, 2, 0, 2, 3));
  HandMade strip = square_with({{"mode", 5}});
  strip.document["meshes"][0]["primitives"][0]["indices"] = strip.indices({0, 1, 2, 2, 1, 1, 1, 3, 2});
  EXPECT_THAT(read_text("a.gltf", strip.text()).corner_vertices, ElementsAre(0, 1, 2, 1, 3, 2))
      << "triangles without area only lead the strip to another place";
}

TEST(GltfReader, AppliesTransformsOfNestedNodes) {
  HandMade made = square_with({{"mode", 5}});
  made.document["nodes"] = json::array();
  made.document["nodes"].push_back({{"translation", {10, 0, 0}}, {"scale", {2, 2, 2}}, {"children", {1}}});
  // A quarter turn about z.
  made.node({{"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}}});
  const PolygonSoup soup = read_text("a.gltf", made.text());
  EXPECT_NEAR((soup.positions[1] - Vec3(10, 2, 0)).norm(), 0.0, 1e-14);
  EXPECT_NEAR(total_area_z(soup), 4.0, 1e-12);
  made.document["nodes"][0] = {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}},
                               {"children", {1}}};
  EXPECT_NEAR((read_text("a.gltf", made.text()).positions[1] - Vec3(5, 7, 7)).norm(), 0.0, 1e-14);
}

TEST(GltfReader, TurnsTrianglesThatATransformMirrors) {
  HandMade made = square_with({{"mode", 5}});
  made.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      made.accessor<float>("VEC3", 5126, 3, {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
  made.document["nodes"][0]["scale"] = {-1, 1, 1};
  const PolygonSoup soup = read_text("a.gltf", made.text());
  EXPECT_NEAR(total_area_z(soup), 1.0, 1e-12);
  for (const Vec3& normal : soup.corner_normals) EXPECT_EQ(normal, Vec3(0, 0, 1));
  EXPECT_EQ(soup.positions[1], Vec3(-1, 0, 0));
}

TEST(GltfReader, ReadsAttributesOfAllComponentTypes) {
  HandMade made = square_with({{"mode", 5}});
  json& attributes = made.document["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_0"] =
      made.accessor<std::uint16_t>("VEC2", 5123, 2, {0, 65535, 65535, 0, 13107, 0, 0, 0});
  attributes["COLOR_0"] =
      made.accessor<std::uint8_t>("VEC4", 5121, 4, {255, 0, 51, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  for (const std::size_t i : {1u, 2u}) made.document["accessors"][i]["normalized"] = true;
  const PolygonSoup soup = read_text("a.gltf", made.text());
  EXPECT_EQ(soup.corner_uvs[0], Vec2(0, 0)) << "v counts from the bottom";
  EXPECT_EQ(soup.corner_uvs[1], Vec2(1, 1));
  EXPECT_EQ(soup.corner_uvs[2], Vec2(0.2, 1));
  EXPECT_EQ(soup.vertex_colors[0], Vec4(1, 0, 0.2, 1));
}

TEST(GltfReader, GivesFacesTheMaterialsOfTheirPrimitives) {
  HandMade made = square_with({{"mode", 5}});
  made.document["materials"] = {
      {{"name", "plain"}},
      {{"name", "oak"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.5, 0.25, 0.125, 0.5}}, {"baseColorTexture", {{"index", 0}}}}}}};
  made.document["textures"] = {{{"source", 0}}};
  made.document["images"] = {{{"uri", "oak%20planks.png"}}};
  made.primitive({{"attributes", {{"POSITION", 0}}}, {"mode", 5}, {"material", 1}});
  made.primitive({{"attributes", {{"POSITION", 0}}}, {"mode", 5}});
  made.primitive({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
  const PolygonSoup soup = read_text("a.gltf", made.text());
  EXPECT_THAT(soup.face_materials, ElementsAre(k_no_index, k_no_index, 1, 1, k_no_index, k_no_index));
  ASSERT_EQ(soup.materials.size(), 2u);
  EXPECT_EQ(soup.materials[0], (Material{"plain", {1, 1, 1, 1}, ""}));
  EXPECT_EQ(soup.materials[1], (Material{"oak", {0.5, 0.25, 0.125, 0.5}, "oak planks.png"}));
}

/// A square with a texture, whose image is as said.
HandMade textured_square(json image) {
  HandMade made = square_with({{"mode", 5}, {"material", 0}});
  made.document["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  made.document["textures"] = {{{"source", 0}}};
  made.document["images"] = json::array({std::move(image)});
  return made;
}

TEST(GltfReader, TakesPicturesThatAreInsideAndNamesThoseBesideIt) {
  const std::string png = encode_png(four_colors());
  const TempFolder folder;
  const auto material = [&](const HandMade& made) {
    return read_soup(folder.write("a.gltf", made.text())).materials.at(0);
  };
  const Material beside = material(textured_square({{"uri", "my%20skin.png"}}));
  EXPECT_EQ(beside.base_color_texture, "my skin.png");
  EXPECT_FALSE(beside.base_color_picture);
  const Material in_text =
      material(textured_square({{"uri", "data:image/png;base64," + detail::encode_base64(png)}}));
  EXPECT_EQ(in_text.base_color_texture, "image_0.png");
  EXPECT_EQ(*in_text.base_color_picture, png);
  HandMade in_buffer = textured_square({{"bufferView", 1}, {"mimeType", "image/png"}});
  in_buffer.accessor<char>("SCALAR", 5121, 1, {png.begin(), png.end()});
  EXPECT_EQ(*material(in_buffer).base_color_picture, png);
  EXPECT_THAT(test::error_text([&] {
                material(textured_square({{"bufferView", 7}}));
              }),
              HasSubstr("bufferViews has no element 7"));
  EXPECT_THAT(test::error_text([&] {
                material(textured_square({{"uri", "data:image/png,1234"}}));
              }),
              HasSubstr("images[0] has a data URI that isn't base64"));
}

TEST(GltfReader, ReadsOnlyTheFinestOfSeveralLevels) {
  HandMade made = square_with({{"mode", 5}});
  made.document["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = {1, 2};
  made.node();
  made.node();
  made.document["scenes"][0]["nodes"] = {0, 1, 2};
  EXPECT_EQ(read_text("a.gltf", made.text()).n_faces(), 2u);
  made.document.erase("scenes");
  EXPECT_EQ(read_text("a.gltf", made.text()).n_faces(), 2u);
}

TEST(GltfReader, CountsWhatItLeavesAside) {
  const TempFolder folder;
  HandMade made = square_with({{"mode", 5}});
  EXPECT_EQ(read_mesh(folder.write("a.gltf", made.text())).report.steps.front().name, "load_pictures");
  made.document["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}};
  made.primitive({{"mode", 1}, {"attributes", {{"POSITION", 0}}}});
  made.document["animations"] = {json::object(), json::object()};
  made.document["nodes"][0]["extensions"]["MSFT_lod"]["ids"] = {1, 1};
  made.node();
  made.document["textures"] = {{{"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}}};
  made.document["materials"] = {{{"normalTexture", {{"index", 0}}}}};
  const RepairStep step = read_mesh(folder.write("a.gltf", made.text())).report.steps.front();
  EXPECT_EQ(step.name, "read_soup");
  EXPECT_EQ(
      step.detail,
      "leaves 1 coarser level of detail, 2 animations, 1 surface's morph targets, 1 texture that is neither "
      "PNG nor JPEG, 1 list of points or lines aside");
}

TEST(GltfReader, VisitsEveryNodeOnceWhateverTheGraph) {
  HandMade made = square_with({{"mode", 5}});
  made.document["nodes"][0]["children"] = {0};
  made.document["scenes"].push_back({{"nodes", {0}}});
  EXPECT_EQ(read_text("a.gltf", made.text()).n_faces(), 2u);
}

TEST(GltfReader, ReadsBuffersBesideTheFile) {
  const TempFolder folder;
  const HandMade made = square_with({{"mode", 5}});
  json document = made.document;
  document["buffers"] = {{{"byteLength", made.buffer().size()}, {"uri", "my%20data.bin"}}};
  folder.write("my data.bin", made.buffer());
  EXPECT_EQ(read_soup(folder.write("a.gltf", document.dump())).n_faces(), 2u);
}

TEST(GltfReader, NamesThePlaceAndReasonOfEveryDefect) {
  const auto complaint_after = [](json::json_pointer place, const json& value) {
    HandMade made = square_with({{"mode", 5}});
    made.document[place] = value;
    return complaint("a.gltf", made.text());
  };
  using Place = json::json_pointer;
  EXPECT_EQ(complaint("a.gltf", "{\n\"asset\": {\n,"), "a.gltf:3: the JSON isn't well-formed");
  EXPECT_EQ(complaint("a.gltf", "[]"), "a.gltf: isn't a glTF file (no JSON object)");
  EXPECT_EQ(complaint("a.gltf", "{\"asset\":{\"version\":1e999}}"),
            "a.gltf: the JSON holds a number out of range");
  EXPECT_EQ(complaint_after(Place("/asset/version"), "1.0"), "a.gltf: glTF version '1.0', not 2");
  EXPECT_EQ(complaint_after(Place("/accessors/0/count"), 5),
            "a.gltf: accessors[0] reads 5 elements past the end of its buffer view of 48 bytes");
  EXPECT_EQ(
      complaint_after(Place("/accessors/0/count"), 4e15),
      "a.gltf: accessors[0] reads 4000000000000000 elements past the end of its buffer view of 48 bytes");
  EXPECT_EQ(complaint_after(Place("/accessors/0/count"), -1),
            "a.gltf: accessors[0].count isn't a whole number from 0");
  EXPECT_EQ(complaint_after(Place("/accessors/0/componentType"), 5124),
            "a.gltf: accessors[0] has an unknown type");
  EXPECT_EQ(complaint_after(Place("/accessors/0/sparse"), json::object()),
            "a.gltf: accessors[0] is sparse, which isn't supported");
  EXPECT_EQ(complaint_after(Place("/bufferViews/0/byteLength"), 49),
            "a.gltf: bufferViews[0] reads bytes 0 to 49 of a buffer of 48 bytes");
  EXPECT_EQ(complaint_after(Place("/bufferViews/0/buffer"), 1),
            "a.gltf: buffers has no element 1 (there are 1)");
  EXPECT_EQ(complaint_after(Place("/bufferViews/0/extensions/EXT_meshopt_compression"), json::object()),
            "a.gltf: accessors[0] needs the extension EXT_meshopt_compression, which isn't supported");
  EXPECT_EQ(
      complaint_after(Place("/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression"), json::object()),
      "a.gltf: meshes[0].primitives[0] needs the extension KHR_draco_mesh_compression, which isn't "
      "supported");
  EXPECT_EQ(complaint_after(Place("/extensionsRequired"), {"EXT_other"}),
            "a.gltf: needs the extension 'EXT_other', which isn't supported");
  EXPECT_EQ(complaint_after(Place("/meshes/0/primitives/0/mode"), 1), "a.gltf: holds no triangles");
  EXPECT_EQ(complaint_after(Place("/meshes/0/primitives/0/material"), 0),
            "a.gltf: meshes[0].primitives[0].material names material 0, which isn't there");
  EXPECT_EQ(complaint_after(Place("/nodes/0/scale"), {1, 1}), "a.gltf: nodes[0].scale has the wrong length");
  EXPECT_EQ(complaint_after(Place("/nodes/0/mesh"), "x"), "a.gltf: nodes[0].mesh isn't a number");
  EXPECT_EQ(complaint_after(Place("/scenes/0/nodes"), {7}), "a.gltf: nodes has no element 7 (there are 1)");
  HandMade made = square_with({});
  made.document["meshes"][0]["primitives"][0]["indices"] = made.indices({0, 1, 4});
  EXPECT_EQ(complaint("a.gltf", made.text()), "a.gltf: meshes[0].primitives[0] uses vertex 4 (there are 4)");
  made = square_with({});
  EXPECT_EQ(complaint("a.gltf", made.text()),
            "a.gltf: meshes[0].primitives[0] has 4 indices, which make no triangles");
}

TEST(GltfReader, SurvivesDeepNesting) {
  const std::string deep(300000, '[');
  EXPECT_EQ(complaint("a.gltf", "{\"extras\":" + deep), "a.gltf:1: the JSON isn't well-formed");
  HandMade made = square_with({{"mode", 5}});
  std::string text = made.text();
  text.insert(1, "\"extras\":" + deep + std::string(deep.size(), ']') + ",");
  EXPECT_EQ(complaint("a.gltf", text), "");
}

TEST(GltfReader, SaysWithByteWhereAGlbIsDamaged) {
  const TempFolder folder;
  write_soup(folder / "a.glb", two_triangles());
  const std::string whole = read_whole_file(folder / "a.glb");
  EXPECT_THAT(complaint("a.glb", whole.substr(0, 15)),
              HasSubstr("a.glb: byte 15: the file ends in its header"));
  EXPECT_THAT(complaint("a.glb", whole.substr(0, whole.size() - 1)),
              HasSubstr(fmt::format("a.glb: byte {}: the file ends before", whole.size() - 1)));
  std::string damaged = whole;
  damaged[25] = '\1';
  EXPECT_THAT(complaint("a.glb", damaged), HasSubstr("a.glb: byte 2"));
}

}  // namespace
}  // namespace recede::test
