// `recede info` of meshes, and of what holds levels or layers instead.
#include "run_recede.h"

namespace recede::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

json info_of(const std::string& input) { return json_of(run_recede({"info", input, "--json"})); }

TEST(InfoCommand, CountsTheFacesOfATeapotOfQuads) {
  const CommandResult run = run_recede({"info", "teapot", "--json"});
  const json result = json_of(run);
  EXPECT_EQ(result.at("faces"), 51200);
  EXPECT_EQ(result.at("triangles").get<int>() + result.at("quads").get<int>(), 51200);
  EXPECT_EQ(result.at("larger_polygons"), 0);
  EXPECT_GT(result.at("border_loops"), 0);
  EXPECT_GT(result.at("area"), 0);
  EXPECT_LT(result.at("box").at("min").at(2), result.at("box").at("max").at(2));
  for (const char* name : {"edges", "border_edges", "split_vertices"})
    EXPECT_TRUE(result.at(name).is_number()) << name;
  for (const char* name : {"corner_uvs", "corner_normals", "vertex_colors"})
    EXPECT_EQ(result.at(name), false) << name;
  EXPECT_THAT(result.at("materials"), IsEmpty());
}

TEST(InfoCommand, SaysWhatReadingRepaired) {
  const TempFolder folder;
  const std::string file =
      folder.write("fan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
  const CommandResult run = run_recede({"info", file, "--json"});
  const json result = json_of(run);
  EXPECT_THAT(run.remarks, HasSubstr("recede: merge_identical_vertices: "));
  EXPECT_EQ(result.at("repairs").at(0).at("step"), "load_pictures") << "reading comes first";
  EXPECT_EQ(result.at("repairs").at(1).at("step"), "merge_identical_vertices");
  EXPECT_EQ(result.at("repairs").at(1).at("changed"), 1);
}

/// A square of one material, and two triangles of another that share a side with each other and with it.
std::string write_three_faces(const TempFolder& folder) {
  folder.write("two.mtl", "newmtl skin\nKd 1 0 0\nnewmtl bone\nKd 0 1 0\n");
  return folder.write(
      "three.obj",
      "mtllib two.mtl\nv 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 0 1 0\nv 0 1 0 0 1 0\nv 2 0 0 0 0 1\n"
      "v 0 0 2 0 0 1\nvt 0 0\nvn 0 0 1\nusemtl skin\nf 1/1/1 2/1/1 3/1/1 4/1/1\nusemtl bone\n"
      "f 2/1/1 5/1/1 3/1/1\nf 2/1/1 3/1/1 6/1/1\n");
}

TEST(InfoCommand, TellsWhatAMeshHoldsBesideItsFaces) {
  const TempFolder folder;
  const json info = info_of(write_three_faces(folder));
  EXPECT_EQ(info["triangles"], 2);
  EXPECT_EQ(info["quads"], 1);
  EXPECT_EQ(info["split_vertices"], 4) << "three faces at one side";
  EXPECT_THAT(info["materials"], ElementsAre("skin", "bone"));
  for (const char* name : {"corner_uvs", "corner_normals", "vertex_colors"})
    EXPECT_EQ(info[name], true) << name;
}

TEST(InfoCommand, PrintsWhatAMeshHolds) {
  const TempFolder folder;
  EXPECT_THAT(run_recede({"info", write_three_faces(folder)}).output,
              AllOf(HasSubstr("(4 of them copies at non-manifold places)"),
                    HasSubstr("faces        3 (2 triangles, 1 quads, 0 larger)\n"),
                    HasSubstr("box          0 0 0 to 2 1 2\ndiagonal     3\n"),
                    HasSubstr("attributes   texture coordinates, normals, vertex colours, materials\n"),
                    HasSubstr("material     skin\nmaterial     bone\n")));
}

TEST(InfoCommand, TellsTheLevelsOfAHierarchy) {
  const TempFolder folder;
  const json baked =
      json_of(run_recede({"bake", write_sphere(folder, 500), "-o", folder / "out", "--ratios", "0.5",
                          "--maps", "normal", "--map-size", "32", "--no-report", "--json"}));
  const std::string hierarchy = baked["folder"];
  const json info = info_of(hierarchy);
  EXPECT_EQ(info["kind"], "hierarchy");
  EXPECT_EQ(info["name"], "sphere");
  EXPECT_NEAR(info["view"]["field_of_view"], 45, 1e-9);
  EXPECT_EQ(info["diagonal"], baked["diagonal"]);
  ASSERT_EQ(info["levels"].size(), baked["levels"].size());
  for (std::size_t i = 0; i < info["levels"].size(); ++i) {
    for (const char* field : {"faces", "vertices", "error", "switch_distance", "stop_reason"})
      EXPECT_EQ(info["levels"][i][field], baked["levels"][i][field]) << field;
  }
  EXPECT_THAT(info["levels"][1]["also_holds"], ElementsAre("normal"));
  // The same from its list and from the folder around it.
  for (const std::string& input : {hierarchy + "/hierarchy.json", (folder / "out").string()}) {
    json other = info_of(input);
    EXPECT_EQ(other["input"], input);
    other["input"] = info["input"];
    EXPECT_EQ(other, info);
  }
  EXPECT_THAT(run_recede({"info", hierarchy}).output,
              AllOf(HasSubstr("hierarchy    sphere, 2 levels"),
                    HasSubstr("1080 pixels high, 45 degrees, pixel error 1"), HasSubstr("from distance"),
                    HasSubstr("normal")));
  EXPECT_THAT(complaint_of(run_recede({"info", folder.path()}), 1), HasSubstr("holds no hierarchy"));
}

TEST(InfoCommand, TellsBaseAndSplitsOfAProgressiveMesh) {
  const TempFolder folder;
  const std::string file = folder / "sphere.pmesh";
  const json built = json_of(run_recede({"progressive", write_sphere(folder, 500), "-o", file, "--json"}));
  const json info = info_of(file);
  EXPECT_EQ(info["kind"], "progressive");
  for (const char* field : {"faces", "base_faces", "splits", "errors_are_proved", "diagonal"})
    EXPECT_EQ(info[field], built[field]) << field;
  // The file keeps errors with few bits, rounded up.
  EXPECT_GE(info["base_error"], built["base_error"]);
  EXPECT_NEAR(info["base_error"], built["base_error"], 0.01 * built["base_error"].get<double>());
  EXPECT_THAT(run_recede({"info", file}).output,
              AllOf(HasSubstr(built["faces"].dump() + " in all"), HasSubstr("certified")));
}

TEST(InfoCommand, TellsLayerAndTextureOfAShell) {
  const TempFolder folder;
  const std::string file = folder / "sphere.shell";
  const json built = json_of(
      run_recede({"shell", write_sphere(folder, 500), "-o", file, "--thickness", "0.1", "--side", "interior",
                  "--texture", "chain-mail", "--texels", "16", "--periods", "3", "--json"}));
  const json info = info_of(file);
  EXPECT_EQ(info["kind"], "shell");
  EXPECT_EQ(info["side"], "interior");
  EXPECT_EQ(info["triangles"], built["triangles"]);
  EXPECT_TRUE(info["is_valid"]);
  EXPECT_NEAR(info["thickness"]["max"], 0.1 * built["interior"]["thickness"]["max"].get<double>(), 1e-9);
  EXPECT_EQ(info["repeat"][0], 3);
  EXPECT_TRUE(info["is_periodic"]);
  EXPECT_FALSE(info["has_colors"]);
  EXPECT_THAT(run_recede({"info", file}).output, AllOf(HasSubstr("interior layer"), HasSubstr("texels")));
}

}  // namespace
}  // namespace recede::test
