// Files that can't be read or written: one line that names the place, exit code 1, and nothing left behind.
#include "run_recede.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>

namespace recede::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Runs every command on the file and expects the same complaint from each; returns it without `recede: `.
/// Nothing but the file itself may be in the folder afterwards.
std::string complaint_about(const TempFolder& folder, const std::string& file) {
  const std::vector<std::string> before = names_below(folder / "");
  const std::string path = folder / file, out = folder / "out";
  const std::string complaint = complaint_of(run_recede({"info", path}), 1);
  EXPECT_EQ(complaint_of(run_recede({"simplify", path, "-o", out + ".ply", "--ratio", "0.5"}), 1), complaint);
  EXPECT_EQ(complaint_of(run_recede({"bake", path, "-o", out}), 1), complaint);
  EXPECT_EQ(complaint_of(run_recede({"compare", path, path, "--json"}), 1), complaint);
  EXPECT_EQ(names_below(folder / ""), before);
  EXPECT_THAT(complaint, HasSubstr("recede: " + path));
  return complaint.substr(std::string("recede: ").size() + path.size());
}

TEST(BadInput, MissingFileIsNamed) {
  const TempFolder folder;
  EXPECT_EQ(complaint_about(folder, "nothing.ply"), ": No such file or directory");
}

TEST(BadInput, FolderInPlaceOfAFileIsNamed) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "folder.obj");
  const std::string path = folder / "folder.obj";
  EXPECT_EQ(complaint_of(run_recede({"simplify", path, "-o", folder / "out.ply", "--ratio", "0.5"}), 1),
            "recede: " + path + ": is a folder");
  EXPECT_EQ(complaint_of(run_recede({"compare", path, path}), 1), "recede: " + path + ": is a folder");
  EXPECT_THAT(complaint_of(run_recede({"compare", path}), 2),
              HasSubstr("compare needs second: the other mesh"));
  EXPECT_THAT(complaint_of(run_recede({"info", path}), 1),
              HasSubstr(path + ": holds no hierarchy, which is a folder"));
}

TEST(BadInput, UnknownExtensionNamesTheKnownOnes) {
  const TempFolder folder;
  folder.write("mesh.blend", "BLENDER");
  EXPECT_THAT(complaint_about(folder, "mesh.blend"), AllOf(HasSubstr(".obj"), HasSubstr(".glb")));
}

TEST(BadInput, EmptyFileOfAnyFormatIsRefused) {
  const TempFolder folder;
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.off", "a.gltf", "a.glb"}) {
    SCOPED_TRACE(name);
    folder.write(name, "");
    complaint_about(folder, name);
  }
}

TEST(BadInput, TruncatedBinaryPlyNamesTheByte) {
  const TempFolder folder;
  const std::string whole = read_whole_file(write_sphere(folder, 200));
  folder.write("cut.ply", whole.substr(0, whole.size() / 2));
  EXPECT_THAT(complaint_about(folder, "cut.ply"), testing::ContainsRegex(": byte [0-9]+: "));
}

TEST(BadInput, TruncatedGlbIsRefused) {
  const TempFolder folder;
  write_soup(folder / "whole.glb", make_displaced_sphere(200, true));
  const std::string whole = read_whole_file(folder / "whole.glb");
  folder.write("cut.glb", whole.substr(0, whole.size() - 100));
  complaint_about(folder, "cut.glb");
}

TEST(BadInput, MalformedObjNamesTheLine) {
  const TempFolder folder;
  folder.write("word.obj", "v 0 0 0\nv 1 0 0\nv 0 one 0\nf 1 2 3\n");
  EXPECT_THAT(complaint_about(folder, "word.obj"), testing::StartsWith(":3: "));
  folder.write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n");
  EXPECT_THAT(complaint_about(folder, "index.obj"),
              AllOf(testing::StartsWith(":5: "), HasSubstr("vertex 4")));
}

TEST(BadInput, PositionThatIsNoNumberNamesTheVertex) {
  const TempFolder folder;
  folder.write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");  // OBJ counts from 1
  EXPECT_THAT(complaint_about(folder, "nan.obj"), HasSubstr("vertex 3"));
  folder.write("inf.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 inf 0\n3 0 1 2\n");  // OFF from 0
  EXPECT_THAT(complaint_about(folder, "inf.off"), HasSubstr("vertex 2"));
}

TEST(BadInput, MeshWithoutFacesCanBeNeitherBakedNorCompared) {
  const TempFolder folder;
  const std::string points = folder.write("points.obj", "v 0 0 0\nv 1 0 0\n");
  const std::string complaint = "recede: " + points + ": holds no faces";
  EXPECT_EQ(complaint_of(run_recede({"bake", points, "-o", folder / "out"}), 1), complaint);
  EXPECT_EQ(complaint_of(run_recede({"compare", points, points}), 1), complaint);
  EXPECT_THAT(names_below(folder / ""), ElementsAre("points.obj"));
}

TEST(BadOutput, UnknownExtensionIsRefused) {
  const TempFolder folder;
  const std::string out = folder / "out.blend";
  EXPECT_THAT(
      complaint_of(run_recede({"simplify", write_sphere(folder, 200), "-o", out, "--ratio", "0.5"}), 1),
      HasSubstr("out.blend: unknown kind of mesh file"));
  EXPECT_THAT(names_below(folder / ""), ElementsAre("sphere.ply"));
}

TEST(BadOutput, FileInTheWayOfTheFolderIsNamed) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 200), file = folder.write("file", "x");
  const auto complaint = [&](const std::string& out) {
    return complaint_of(run_recede({"bake", sphere, "-o", out, "--ratios", "0.5", "--no-report"}), 1);
  };
  EXPECT_EQ(complaint(file), "recede: " + file + ": isn't a folder");
  EXPECT_EQ(complaint(file + "/below"), "recede: " + file + "/below: " + file + " isn't a folder");
  const std::string ply = file + "/small.ply";
  EXPECT_EQ(complaint_of(run_recede({"simplify", sphere, "-o", ply, "--ratio", "0.5"}), 1),
            "recede: " + ply + ": there is no folder " + file);
  EXPECT_THAT(names_below(folder / ""), ElementsAre("file", "sphere.ply"));
}

TEST(BadOutput, FolderInTheWayOfTheFileIsNamed) {
  const TempFolder folder;
  const std::string out = folder / "folder.ply";
  std::filesystem::create_directory(out);
  EXPECT_EQ(complaint_of(run_recede({"simplify", write_sphere(folder, 200), "-o", out, "--ratio", "0.5"}), 1),
            "recede: " + out + ": is a folder");
  EXPECT_THAT(names_below(out), IsEmpty());
}

TEST(BadOutput, EarlierFileSurvivesAFailure) {
  const TempFolder folder;
  const std::string out = folder.write("out.ply", "precious");
  const std::string bad = folder.write("bad.obj", "f 1 2 3\n");
  complaint_of(run_recede({"simplify", bad, "-o", out, "--ratio", "0.5"}), 1);
  EXPECT_EQ(read_whole_file(out), "precious");
}

}  // namespace
}  // namespace recede::test
