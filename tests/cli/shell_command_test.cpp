#include "control_meshes.h"
#include "run_recede.h"
#include "temp_folder.h"
#include <recede/geometry/alpha_wrap.h>
#include <recede/geometry/mesh_io.h>

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace recede::test {
namespace {

using testing::HasSubstr;

/// Two triangles that meet in their middles, as `cross.obj`.
void write_cross(const TempFolder& folder) {
  folder.write("cross.obj", "v -1 0 0\nv 1 0 0\nv 0 2 0\nv 0 1 -1\nv 0 1 1\nv 0 3 0\nf 1 2 3\nf 4 5 6\n");
}

TEST(ShellCommand, WritesAClosedMeshAroundASurface) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 500), out = folder / "shell.ply";
  const nlohmann::json result = json_of(run_recede(
      {"shell", sphere, "-o", out, "--relative-thickness", "0.05", "--side", "envelope", "--json"}));
  EXPECT_TRUE(result["is_valid"]);
  EXPECT_EQ(result["base_contacts"], 0);
  for (const char* side : {"exterior", "interior"}) {
    EXPECT_TRUE(result[side]["is_valid"]);
    EXPECT_GT(result[side]["thickness"]["mean"], 0.8);
    EXPECT_LE(result[side]["thickness"]["max"], 1.01);
  }
  EXPECT_EQ(read_soup(out).n_faces(), 2 * result["triangles"].get<std::size_t>());
}

TEST(ShellCommand, SaysInTextWhatTheDocumentHas) {
  const TempFolder folder;
  std::vector<std::string> arguments{
      "shell",    write_sphere(folder, 500), "--relative-thickness", "0.1", "--side",
      "envelope", "--keep-directors"};
  const std::string text = run_recede(arguments).output;
  arguments.emplace_back("--json");
  const nlohmann::json result = json_of(run_recede(arguments));
  EXPECT_THAT(text,
              HasSubstr(fmt::format("thickness    {:.4g} (10 %)\n", result["thickness"].get<double>())));
  for (const char* side : {"exterior", "interior"}) {
    const nlohmann::json& layer = result[side];
    EXPECT_THAT(text, HasSubstr(fmt::format("{:<12} valid; {:.3g} % of the thickness, {:.3g} % at least\n",
                                            side, 100 * layer["thickness"]["mean"].get<double>(),
                                            100 * layer["thickness"]["min"].get<double>())));
    EXPECT_THAT(
        text, HasSubstr(fmt::format("{} prisms inverted, {} contacts; {} directors shortened in {} rounds\n",
                                    layer["inverted_before"].get<int>(), layer["contacts_before"].get<int>(),
                                    layer["shortened"].get<int>(), layer["repair_rounds"].get<int>())));
  }
  EXPECT_NE(result["exterior"]["thickness"]["mean"], result["interior"]["thickness"]["mean"]);
}

TEST(ShellCommand, KeepsDirectorsOnDemand) {
  const TempFolder folder;
  write_soup(folder / "cube.obj", control_cube());
  std::vector<std::string> arguments{"shell",  folder / "cube.obj", "--thickness", "0.2",
                                     "--side", "interior",          "--json"};
  const nlohmann::json thick = json_of(run_recede(arguments))["interior"];
  EXPECT_TRUE(thick["is_of_normals"]);
  EXPECT_NEAR(thick["thickness"]["mean"], 1, 1e-9);
  EXPECT_EQ(thick["hexahedra"], 6);
  arguments.push_back("--keep-directors");
  const nlohmann::json thin = json_of(run_recede(arguments))["interior"];
  EXPECT_FALSE(thin["is_of_normals"]);
  EXPECT_LT(thin["thickness"]["mean"], 0.4);
}

TEST(ShellCommand, PrintsWherePlainNormalsTookThePlaceOfDirectors) {
  const TempFolder folder;
  write_soup(folder / "cube.obj", control_cube());
  std::vector<std::string> arguments{"shell",  folder / "cube.obj", "--thickness", "0.2",
                                     "--side", "interior"};
  EXPECT_THAT(run_recede(arguments).output,
              HasSubstr("plain normals, which are longer on average and valid\n"));
  arguments.emplace_back("--keep-directors");
  const std::string text = run_recede(arguments).output;
  EXPECT_THAT(text, testing::Not(HasSubstr("plain normals")));
}

TEST(ShellCommand, SaysWhatIsWrongWithoutRepair) {
  const nlohmann::json result =
      json_of(run_recede({"shell", "teapot", "--relative-thickness", "0.05", "--side", "interior",
                          "--directors", "normals", "--no-repair", "--json"}));
  EXPECT_FALSE(result["is_valid"]);
  EXPECT_TRUE(result["exterior"].is_null());
  EXPECT_GT(result["interior"]["inverted"], 0);
  EXPECT_EQ(result["interior"]["inverted"], result["interior"]["inverted_before"]);
}

TEST(ShellCommand, NamesASurfaceThatMeetsItself) {
  const TempFolder folder;
  write_cross(folder);
  const CommandResult run = run_recede({"shell", folder / "cross.obj", "--thickness", "0.1"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.remarks, HasSubstr("meets itself"));
  EXPECT_THAT(run.output, HasSubstr("not valid over 2 triangles"));
  const nlohmann::json result =
      json_of(run_recede({"shell", folder / "cross.obj", "--thickness", "0.1", "--json"}));
  EXPECT_FALSE(result["is_valid"]);
  EXPECT_EQ(result["exterior"]["excused"], 2);
  EXPECT_TRUE(result["exterior"]["is_valid_elsewhere"]);
}

TEST(ShellCommand, WritesWhatIsNotValidOnDemandOnly) {
  const TempFolder folder;
  write_cross(folder);
  const std::string out = folder / "shell.ply";
  std::vector<std::string> arguments{"shell", folder / "cross.obj", "--thickness", "0.1", "-o", out,
                                     "--json"};
  const CommandResult refused = run_recede(arguments);
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.remarks, HasSubstr("isn't valid, so it wasn't written; --keep-invalid"));
  const nlohmann::json report = nlohmann::json::parse(refused.output);
  EXPECT_FALSE(report["is_valid"]);
  EXPECT_TRUE(report["output"].is_null());
  EXPECT_FALSE(std::filesystem::exists(out));
  arguments.push_back("--keep-invalid");
  const CommandResult kept = run_recede(arguments);
  EXPECT_THAT(kept.remarks, HasSubstr("what was written isn't valid"));
  EXPECT_EQ(json_of(kept)["output"], out);
  EXPECT_GT(read_soup(out).n_faces(), 0u);
}

TEST(ShellCommand, WrapsWhatMeetsItself) {
  const TempFolder folder;
  write_cross(folder);
  const CommandResult run =
      run_recede({"shell", folder / "cross.obj", "--thickness", "0.1", "--json", "--wrap", "0.05"});
  if (!can_alpha_wrap()) {
    EXPECT_THAT(complaint_of(run, 2), HasSubstr("RECEDE_CGAL_GPL"));
    return;
  }
  EXPECT_TRUE(json_of(run)["is_valid"]);
  EXPECT_GT(json_of(run)["triangles"], 100);
  EXPECT_THAT(complaint_of(run_recede({"shell", "sphere", "--thickness", "0.1", "--wrap", "2"}), 2),
              HasSubstr("--wrap"));
}

TEST(ShellCommand, BuildsTheShellOfALimitSurface) {
  const TempFolder folder;
  write_soup(folder / "cube.obj", control_cube());
  const std::vector<std::string> arguments{
      "shell", folder / "cube.obj", "--thickness", "0.2", "--json", "--subdivision-level", "3"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), arguments.begin(), arguments.end());
    return more;
  };
  const nlohmann::json all = json_of(run_recede(arguments));
  EXPECT_TRUE(all["is_valid"]);
  EXPECT_EQ(all["triangles"], 2 * 6 * 64);
  EXPECT_EQ(all["subdivision_level"], 3);
  EXPECT_EQ(all["traced"], 6 * 64 + 2);
  const nlohmann::json few = json_of(run_recede(with({"--interpolate-directors", "1"})));
  EXPECT_TRUE(few["is_valid"]);
  EXPECT_EQ(few["traced"], 6 * 16 + 2);
  EXPECT_LT(few["exterior"]["evaluations"], all["exterior"]["evaluations"]);
  // With creases at all edges it stays a cube from -1 to 1.
  const std::string out = folder / "creased.ply";
  EXPECT_TRUE(json_of(run_recede(with({"--crease-angle", "30", "-o", out})))["is_valid"]);
  EXPECT_NEAR(bounding_box(read_soup(out)).sizes().maxCoeff(), 2.4, 0.001);
  EXPECT_THAT(
      run_recede({"shell", folder / "cube.obj", "--thickness", "0.2", "--subdivision-level", "2"}).output,
      HasSubstr("98 traced of 98"));
  EXPECT_THAT(complaint_of(run_recede(with({"--interpolate-directors", "4"})), 2),
              HasSubstr("0 to 3 levels"));
  EXPECT_THAT(complaint_of(run_recede({"shell", "sphere", "--thickness", "0.1", "--scheme", "loop"}), 2),
              HasSubstr("--subdivision-level"));
}

TEST(ShellCommand, SaysWhatCantBe) {
  EXPECT_THAT(complaint_of(run_recede({"shell", "sphere"}), 2), HasSubstr("--thickness"));
  EXPECT_THAT(complaint_of(run_recede({"shell", "sphere", "--thickness", "-1"}), 2),
              HasSubstr("--thickness"));
  EXPECT_THAT(complaint_of(run_recede({"shell", "sphere", "--relative-thickness", "3"}), 2),
              HasSubstr("diagonal"));
  EXPECT_THAT(complaint_of(run_recede({"shell", "sphere", "--thickness", "0.1", "--power", "2"}), 2),
              HasSubstr("p must be above 2"));
  EXPECT_THAT(complaint_of(run_recede({"shell", "sphere", "--thickness", "0.1", "-o", "shell.doc"}), 1),
              HasSubstr("shell.doc"));
}

}  // namespace
}  // namespace recede::test
