// `recede info` of what holds levels or layers instead of a mesh.
#include "run_recede.h"

namespace recede::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

json info_of(const std::string& input) { return json_of(run_recede({"info", input, "--json"})); }

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
  EXPECT_THAT(run_recede({"info", hierarchy}).output, AllOf(HasSubstr("hierarchy    sphere, 2 levels"),
                                                            HasSubstr("from distance"), HasSubstr("normal")));
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
  EXPECT_THAT(run_recede({"info", file}).output, AllOf(HasSubstr("interior layer"), HasSubstr("texels")));
}

}  // namespace
}  // namespace recede::test
