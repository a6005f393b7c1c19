#include "run_recede.h"
#include "temp_folder.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/shells/textured_shell_io.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <numbers>
#include <numeric>

namespace recede::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// A shell with a texture over a ball of radius 1, as `ball.shell` in `folder`.
std::string write_shell(const TempFolder& folder, const std::vector<std::string>& options) {
  const std::string out = folder / "ball.shell";
  std::vector<std::string> arguments{
      "shell", write_sphere(folder, 2000), "--relative-thickness", "0.05", "-o", out, "--quiet"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const CommandResult run = run_recede(arguments);
  EXPECT_EQ(run.code, 0) << run.remarks;
  return out;
}

TEST(ShellCommand, FillsALayerWithATexture) {
  const TempFolder folder;
  const std::string file =
      write_shell(folder, {"--texture", "weave", "--periods", "12", "--texels", "8", "--side", "interior"});
  const TexturedShell read = read_textured_shell(file);
  EXPECT_EQ(read.side, ShellSide::interior);
  EXPECT_EQ(read.coordinates.repeat.x(), 12);
  EXPECT_EQ(read.texture->surfaces[0].size[0], 8);
  EXPECT_TRUE(read.layer().validity.is_valid());
}

TEST(ShellCommand, WritesAHierarchyWithTheShellAsItsFinestLevel) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 2000);
  const nlohmann::json result =
      json_of(run_recede({"shell", sphere, "--relative-thickness", "0.05", "--texture", "chain-mail",
                          "--texels", "8", "--folder", folder / "out", "--ratios", "0.3", "--json"}));
  EXPECT_EQ(result["texture"], "chain-mail");
  const std::string levels = folder / "out/sphere.recede";
  const nlohmann::json near =
      json_of(run_recede({"render", levels, "-o", folder / "near.png", "--samples", "1", "--image-width",
                          "60", "--image-height", "60", "--json"}));
  EXPECT_EQ(near["level"], 0);
  const nlohmann::json far = json_of(
      run_recede({"render", levels, "-o", folder / "far.png", "--samples", "1", "--eye", "0", "0", "900",
                  "--field-of-view", "2", "--image-width", "60", "--image-height", "60", "--json"}));
  EXPECT_GE(far["level"], 1);
  EXPECT_GT(far["error_bound"], 0);
}

TEST(CarveCommand, TakesABallOutOfMatter) {
  const TempFolder folder;
  const std::string solid = write_shell(folder, {"--texture", "solid", "--texels", "256", "--layers", "8"});
  const std::string carved = folder / "carved.shell";
  const nlohmann::json result =
      json_of(run_recede({"carve", solid, "-o", carved, "--ball", "0", "0", "1", "0.4", "--json"}));
  EXPECT_EQ(result["size"], (std::vector<int>{256, 256, 8}));
  EXPECT_GT(result["changed"], 1000);
  EXPECT_NEAR(result["tool_volume"], 4.0 / 3 * std::numbers::pi * 0.064, 1e-9);
  // The layer is between radii of about 1 and 1.2, of which the ball has a disc of radius 0.4 or less.
  EXPECT_GT(result["volume"], 0.03);
  EXPECT_LT(result["volume"], 0.12);
  const TexturedShell read = read_textured_shell(carved, {.make_mipmap = false});
  std::size_t empty = 0;
  for (const std::uint8_t opacity : read.texture->surfaces[0].opacity.to_dense())
    empty += opacity == 0 ? 1 : 0;
  EXPECT_GT(empty, 500u);
  // What was carved can be filled again.
  const nlohmann::json filled =
      json_of(run_recede({"carve", carved, "-o", carved, "--ball", "0", "0", "1", "0.5", "--operation",
                          "unite", "--color", "1", "0.5", "0", "--json"}));
  EXPECT_GT(filled["changed"], 1000);
  EXPECT_FALSE(read_textured_shell(carved, {.make_mipmap = false}).texture->surfaces[0].colors.empty());
}

TEST(CarveCommand, UsesMeshesAndTexturesThatRepeat) {
  const TempFolder folder;
  const std::string shell = write_shell(folder, {"--texture", "weave", "--periods", "10", "--texels", "16"});
  PolygonSoup tool = make_displaced_sphere(1000, true);
  for (Vec3& p : tool.positions) p = 0.5 * p + Vec3(1, 0, 0);
  write_soup(folder / "tool.ply", tool);
  const std::string out = folder / "out.shell";
  const nlohmann::json result =
      json_of(run_recede({"carve", shell, folder / "tool.ply", "-o", out, "--operation", "cut", "--json"}));
  EXPECT_EQ(result["size"][0], 160);
  EXPECT_GT(result["changed"], 500);
  const CommandResult run =
      run_recede({"carve", shell, folder / "tool.ply", "-o", out, "--size", "300", "300", "8"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.output, AllOf(HasSubstr("300 x 300 x 8"), HasSubstr("written")));
}

TEST(CarveCommand, LeavesWhatIsInABallAndColoursWhatItAdds) {
  const TempFolder folder;
  const std::string solid = write_shell(folder, {"--texture", "solid", "--texels", "128", "--layers", "4"});
  const std::string out = folder / "out.shell";
  const auto filled_share = [&](const char* operation) {
    EXPECT_EQ(
        run_recede({"carve", solid, "-o", out, "--ball", "0", "0", "1", "0.4", "--operation", operation})
            .code,
        0);
    const std::vector<std::uint8_t> opacity =
        read_textured_shell(out, {.make_mipmap = false}).texture->surfaces[0].opacity.to_dense();
    return static_cast<double>(std::count(opacity.begin(), opacity.end(), 255)) /
           static_cast<double>(opacity.size());
  };
  EXPECT_GT(filled_share("carve"), 0.8);
  EXPECT_LT(filled_share("intersect"), 0.35) << "0.29 measured: texels that are in no chart stay as they are";
  json_of(run_recede({"carve", out, "-o", out, "--ball", "0", "1", "0", "0.4", "--operation", "unite",
                      "--color", "1", "0.5", "0", "--json"}));
  const auto colors = read_textured_shell(out, {.make_mipmap = false}).texture->surfaces[0].colors.to_dense();
  EXPECT_GT(std::count(colors.begin(), colors.end(), std::array<std::uint8_t, 3>{255, 128, 0}), 50);
}

TEST(CarveCommand, SaysThatNothingChanged) {
  const TempFolder folder;
  const std::string solid = write_shell(folder, {"--texture", "solid", "--texels", "64", "--layers", "4"});
  const CommandResult run =
      run_recede({"carve", solid, "-o", folder / "out.shell", "--ball", "9", "9", "9", "0.1"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.remarks, HasSubstr("recede: " + solid + ": nothing changed\n"));
}

TEST(CarveCommand, SaysThatTrianglesAreSmallerThanTexels) {
  const TempFolder folder;
  const std::string solid = write_shell(folder, {"--texture", "solid", "--texels", "16", "--layers", "4"});
  const CommandResult run =
      run_recede({"carve", solid, "-o", folder / "out.shell", "--ball", "0", "0", "1", "0.4"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.remarks, testing::ContainsRegex("ball.shell: [0-9]+ triangles are smaller than texels"));
}

TEST(CarveCommand, TurnsMatterByDegreesAndCopiesIt) {
  const TempFolder folder;
  const std::string empty = write_shell(folder, {"--texture", "empty", "--texels", "128", "--layers", "4"});
  const std::string ball = folder / "a.shell", moved = folder / "b.shell";
  // Beside the place around which it turns.
  run_recede({"carve", empty, "-o", ball, "--ball", "0.15", "0", "1.05", "0.1", "--operation", "unite"});
  const auto moved_by = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"carve", ball, "-o", moved, "--move", "0", "0", "1", "--to", "0", "1", "0",
                               "--radius", "0.3"});
    EXPECT_EQ(run_recede(more).code, 0);
    const auto opacity =
        read_textured_shell(moved, {.make_mipmap = false}).texture->surfaces[0].opacity.to_dense();
    return std::vector<int>(opacity.begin(), opacity.end());
  };
  const auto largest_step = [](const std::vector<int>& a, const std::vector<int>& b) {
    int most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    return most;
  };
  const std::vector<int> straight = moved_by({});
  EXPECT_LE(largest_step(moved_by({"--turn", "360"}), straight), 1) << "rounding of coordinates";
  EXPECT_GT(largest_step(moved_by({"--turn", "90"}), straight), 100);
  const std::vector<int> copied = moved_by({"--copy"});
  EXPECT_GT(std::accumulate(copied.begin(), copied.end(), 0),
            1.5 * std::accumulate(straight.begin(), straight.end(), 0));
}

TEST(CarveCommand, MovesMatter) {
  const TempFolder folder;
  const std::string empty = write_shell(folder, {"--texture", "empty", "--texels", "256", "--layers", "8"});
  const std::string with_ball = folder / "a.shell", moved = folder / "b.shell";
  run_recede(
      {"carve", empty, "-o", with_ball, "--ball", "0", "0", "1.05", "0.1", "--operation", "unite", "-q"});
  const nlohmann::json result =
      json_of(run_recede({"carve", with_ball, "-o", moved, "--move", "0", "0", "1", "--to", "1", "0", "0",
                          "--radius", "0.3", "--turn", "30", "--json"}));
  EXPECT_GT(result["changed"], 100);
  EXPECT_EQ(result["move"]["without_source"], 0);
  EXPECT_LT(result["move"]["stretch"], 1.3);
  // Where it is now something is in the way of another ball.
  const nlohmann::json cut = json_of(run_recede(
      {"carve", moved, "-o", moved, "--ball", "1.05", "0", "0", "0.15", "--operation", "cut", "--json"}));
  EXPECT_GT(cut["changed"], 50);
}

TEST(CarveCommand, SaysWhatCantBe) {
  const TempFolder folder;
  const std::string shell = write_shell(folder, {"--texture", "solid", "--texels", "64", "--layers", "4"});
  const std::string out = folder / "out.shell";
  EXPECT_THAT(complaint_of(run_recede({"carve", shell, "-o", out}), 2), HasSubstr("--ball"));
  EXPECT_THAT(
      complaint_of(run_recede({"carve", shell, "-o", folder / "out.ply", "--ball", "0", "0", "0", "1"}), 2),
      HasSubstr(".shell"));
  EXPECT_THAT(complaint_of(run_recede({"carve", shell, "-o", out, "--ball", "0", "0", "0", "-1"}), 2),
              HasSubstr("radius"));
  EXPECT_THAT(complaint_of(run_recede({"carve", shell, "-o", out, "--move", "0", "0", "0"}), 2),
              HasSubstr("--to"));
  folder.write("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_THAT(complaint_of(run_recede({"carve", shell, folder / "open.obj", "-o", out}), 1),
              AllOf(HasSubstr("open.obj"), HasSubstr("closed")));
  EXPECT_THAT(
      complaint_of(run_recede({"carve", folder / "open.obj", "-o", out, "--ball", "0", "0", "0", "1"}), 1),
      HasSubstr("no textured shell"));
  EXPECT_FALSE(std::filesystem::exists(out));
  const std::string sphere = write_sphere(folder, 500);
  EXPECT_THAT(complaint_of(run_recede({"shell", sphere, "--thickness", "0.1", "--texture", "weave"}), 2),
              HasSubstr("--folder"));
  EXPECT_THAT(
      complaint_of(run_recede({"shell", sphere, "--thickness", "0.1", "--texture", "weave", "-o", "a.ply"}),
                   2),
      HasSubstr(".shell"));
  EXPECT_THAT(complaint_of(run_recede({"shell", sphere, "--thickness", "0.1", "-o", "a.shell"}), 2),
              HasSubstr("--texture"));
  EXPECT_THAT(complaint_of(run_recede({"shell", sphere, "--thickness", "0.1", "--texture", "weave", "-o", out,
                                       "--side", "envelope"}),
                           2),
              HasSubstr("one layer"));
}

}  // namespace
}  // namespace recede::test
