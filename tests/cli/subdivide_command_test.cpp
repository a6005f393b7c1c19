// `recede subdivide` from file to file.
#include "control_meshes.h"
#include "run_recede.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/subdivision_surface.h>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string write_cube(const TempFolder& folder) {
  const std::string path = folder / "cube.obj";
  write_soup(path, charted_cube());
  return path;
}

TEST(SubdivideCommand, WritesThePointsOfTheLimitSurface) {
  const TempFolder folder;
  const std::string cube = write_cube(folder), out = folder / "smooth.obj";
  const json result =
      json_of(run_recede({"subdivide", cube, "-o", out, "--subdivision-level", "3", "--json"}));
  EXPECT_EQ(result.at("scheme"), "catmull-clark");
  EXPECT_EQ(result.at("subdivision_level"), 3);
  EXPECT_EQ(result.at("faces_before"), 6);
  EXPECT_EQ(result.at("faces"), 384);
  EXPECT_EQ(result.at("vertices"), 386);
  EXPECT_EQ(result.at("crease_edges"), 0);
  SubdivisionOptions options;
  options.level = 3;
  const SubdivisionResult expected = subdivide(charted_cube(), options);
  EXPECT_EQ(result.at("error_estimate"), expected.error_estimate);
  const PolygonSoup soup = read_soup(out);
  EXPECT_EQ(soup.positions, expected.soup.positions) << "OBJ keeps all digits";
  EXPECT_EQ(soup.corner_uvs, expected.soup.corner_uvs);
  EXPECT_EQ(soup.corner_normals.size(), soup.n_corners());
}

TEST(SubdivideCommand, ChoosesTheLevelByTheTolerance) {
  const TempFolder folder;
  const std::string cube = write_cube(folder);
  for (const char* name : {"smooth.ply", "smooth.glb"}) {
    const std::string out = folder / name;
    const json result = json_of(run_recede({"subdivide", cube, "-o", out, "--error", "0.01", "--json"}));
    EXPECT_LE(result.at("error_estimate"), 0.01);
    const json coarser =
        json_of(run_recede({"subdivide", cube, "-o", out, "--subdivision-level",
                            std::to_string(result.at("subdivision_level").get<int>() - 1), "--json"}));
    EXPECT_GT(coarser.at("error_estimate"), 0.01);
  }
}

TEST(SubdivideCommand, KeepsSharpEdgesAndBorders) {
  const TempFolder folder;
  const std::string cube = write_cube(folder), out = folder / "sharp.ply";
  const json sharp = json_of(run_recede(
      {"subdivide", cube, "-o", out, "--crease-angle", "60", "--uv-interpolation", "linear", "--json"}));
  EXPECT_EQ(sharp.at("crease_edges"), 12);
  EXPECT_LT(sharp.at("error_estimate"), 1e-12) << "it stays a cube";
  const json softer = json_of(run_recede(
      {"subdivide", cube, "-o", out, "--crease-angle", "60", "--crease-sharpness", "1.5", "--json"}));
  EXPECT_GT(softer.at("error_estimate"), 1e-3);
  const json loop = json_of(run_recede({"subdivide", cube, "-o", out, "--scheme", "loop",
                                        "--subdivision-level", "1", "--border", "edge-only", "--json"}));
  EXPECT_EQ(loop.at("triangulated"), 6);
  EXPECT_EQ(loop.at("faces"), 48);
  EXPECT_THAT(run_recede({"subdivide", cube, "-o", out, "--scheme", "loop"}).remarks,
              HasSubstr("6 polygons were cut into triangles"));
}

TEST(SubdivideCommand, PrintsWhatItMadeAndWhatReadingRepaired) {
  const TempFolder folder;
  std::string text = read_whole_file(write_cube(folder)) + "v 1 1 1\n";  // a vertex twice
  const CommandResult run = run_recede({"subdivide", folder.write("cube.obj", text), "-o", folder / "out.ply",
                                        "--subdivision-level", "2", "--crease-angle", "60"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.remarks, HasSubstr("recede: merge_identical_vertices: "));
  EXPECT_THAT(run.output,
              testing::AllOf(HasSubstr("faces        6 -> 96, level 2\n"),
                             HasSubstr("vertices     8 -> 98\n"), HasSubstr("creases      12 edges\n")));
}

TEST(SubdivideCommand, RefusesWhatItCannotDo) {
  const TempFolder folder;
  const std::string cube = write_cube(folder), out = folder / "out.ply";
  EXPECT_THAT(complaint_of(run_recede({"subdivide", cube, "-o", folder / "a.xyz"}), 1),
              HasSubstr("unknown kind"));
  EXPECT_THAT(complaint_of(run_recede({"subdivide", cube, "-o", out, "--subdivision-level", "11"}), 2),
              HasSubstr("--subdivision-level"));
  EXPECT_THAT(complaint_of(run_recede({"subdivide", cube, "-o", out, "--error", "-1"}), 2),
              HasSubstr("the error must be positive"));
  EXPECT_THAT(complaint_of(run_recede({"subdivide", "teapot", "-o", out, "--subdivision-level", "10"}), 2),
              HasSubstr("more than 50000000"));
  EXPECT_THAT(
      complaint_of(run_recede({"subdivide", cube, "-o", out, "--subdivision-level", "1", "--error", "1"}), 2),
      HasSubstr("--error"));
  EXPECT_THAT(complaint_of(run_recede({"subdivide", cube, "-o", out, "--scheme", "doo-sabin"}), 2),
              HasSubstr("catmull-clark, loop"));
  EXPECT_THAT(names_below(folder / ""), testing::ElementsAre("cube.obj"));
}

}  // namespace
}  // namespace recede::test
