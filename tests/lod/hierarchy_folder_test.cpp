#include "error_text.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/lod/hierarchy_folder.h>

#include <gmock/gmock.h>

namespace recede {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

TEST(HierarchyFolder, IsFoundFromItselfItsListAndTheFolderAround) {
  const test::TempFolder folder;
  fs::create_directories(folder / "out/ball.recede");
  folder.write("out/ball.recede/hierarchy.json", "{}");
  folder.write("out/ball.glb", "");
  // Of a run that was killed.
  fs::create_directories(folder / "out/ball.recede.part17");
  folder.write("out/ball.recede.part17/hierarchy.json", "{}");
  EXPECT_EQ(hierarchy_folder(folder / "out/ball.recede"), folder / "out/ball.recede");
  EXPECT_EQ(hierarchy_folder(folder / "out/ball.recede/hierarchy.json"), folder / "out/ball.recede");
  EXPECT_EQ(hierarchy_folder(folder / "out"), folder / "out/ball.recede");
}

TEST(HierarchyFolder, IsNoneOfMeshesAndWhatIsNotThere) {
  const test::TempFolder folder;
  EXPECT_TRUE(hierarchy_folder(folder.write("ball.ply", "")).empty());
  EXPECT_TRUE(hierarchy_folder(folder / "hierarchy.json").empty());
  EXPECT_TRUE(hierarchy_folder("teapot").empty());
}

TEST(HierarchyFolder, ThatIsNotTheOnlyOneHasToBeNamed) {
  const test::TempFolder folder;
  EXPECT_THAT(test::error_text([&] { hierarchy_folder(folder.path()); }),
              AllOf(HasSubstr(folder.path().string()), HasSubstr("NAME.recede")));
  for (const char* name : {"b.recede", "a.recede"}) {
    fs::create_directories(folder / name);
    folder.write(std::string(name) + "/hierarchy.json", "{}");
  }
  EXPECT_THAT(test::error_text([&] { hierarchy_folder(folder.path()); }),
              HasSubstr((folder / "a.recede").string() + ", " + (folder / "b.recede").string()));
}

}  // namespace
}  // namespace recede
