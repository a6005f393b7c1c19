// What `recede info` says of CAD files.
#include "cad_inputs.h"
#include "run_recede.h"

#include <cmath>
#include <set>
#include <tuple>

namespace recede::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(CadInfo, CountsPartsAndPatches) {
  const TempFolder folder;
  const nlohmann::json info = json_of(run_recede({"info", write_plate_with_screws(folder), "--json"}));
  EXPECT_EQ(info["metres_per_unit"], 1e-3);
  ASSERT_EQ(info["parts"].size(), 2u);
  EXPECT_EQ(info["parts"][0]["name"], "plate");
  EXPECT_EQ(info["parts"][0]["patches"], 10);
  EXPECT_EQ(info["parts"][0]["edges"], 24);
  EXPECT_EQ(info["parts"][0]["corners"], 16);
  EXPECT_EQ(info["instances"], 3);
  EXPECT_EQ(info["patches"], 16);
  EXPECT_EQ(info["open_edges"], 0);
  EXPECT_EQ(info["closed_parts"], 2);
  EXPECT_EQ(info["materials"].size(), 2u);
  EXPECT_EQ(info["materials"][0].get<std::string>().front(), '#');
  // The plate, and the screws' heads and tips above and below it.
  EXPECT_NEAR(info["box"]["max"][2].get<double>(), 4, 1e-9);
  EXPECT_NEAR(info["box"]["min"][2].get<double>(), -7, 1e-9);
  EXPECT_TRUE(info["left_out"].empty());
  EXPECT_TRUE(info["repairs"].empty());
}

// Control points lie outside of round parts; a sphere has no trimming curves around its middle.
TEST(CadInfo, HasTheBoxOfThePartItself) {
  const TempFolder folder;
  write_brep(folder / "sphere.brep", cad_sphere(10));
  write_brep(folder / "cylinder.brep", cad_cylinder(5, 12));
  for (const auto& [file, radius, low, high] :
       {std::tuple("sphere.brep", 10.0, -10.0, 10.0), std::tuple("cylinder.brep", 5.0, 0.0, 12.0)}) {
    const nlohmann::json info = json_of(run_recede({"info", folder / file, "--json"}));
    const nlohmann::json &least = info["box"]["min"], &most = info["box"]["max"];
    // A grid of eighths has the quarters of a circle.
    for (const unsigned axis : {0u, 1u}) {
      EXPECT_NEAR(least[axis].get<double>(), -radius, 1e-9) << file;
      EXPECT_NEAR(most[axis].get<double>(), radius, 1e-9) << file;
    }
    EXPECT_NEAR(least[2].get<double>(), low, 1e-9) << file;
    EXPECT_NEAR(most[2].get<double>(), high, 1e-9) << file;
    EXPECT_GT(info["diagonal"].get<double>(), 0);
    EXPECT_LE(info["diagonal"].get<double>(), 2 * std::hypot(radius, radius, (high - low) / 2) + 1e-9);
  }
}

TEST(CadInfo, PrintsWhatWasLeftOutAndMended) {
  const TempFolder folder;
  write_brep(folder / "bad.brep", cad_compound({cad_square_with_inner_edge(), cad_tube_without_seam()}));
  const CommandResult run = run_recede({"info", folder / "bad.brep"});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("left out     face 1 of \"bad\": 1 edges inside of it bound nothing"),
                    HasSubstr("repaired     face 2 of \"bad\": mended, because a loop doesn't close"),
                    HasSubstr("unit         0.001 m")));
}

TEST(CadInfo, RefusesBadFilesInOneLine) {
  const TempFolder folder;
  EXPECT_THAT(complaint_of(run_recede({"info", folder.write("bad.step", "no step")}), 1),
              HasSubstr("bad.step: isn't a STEP file"));
  EXPECT_THAT(complaint_of(run_recede({"info", folder / "absent.iges"}), 1), HasSubstr("absent.iges"));
}

TEST(CadInfo, IsExplainedFieldByField) {
  const TempFolder folder;
  std::set<std::string> names;
  collect_fields(json_of(run_recede({"info", write_plate_with_screws(folder), "--json"})), names);
  write_brep(folder / "bad.brep", cad_square_with_inner_edge());
  collect_fields(json_of(run_recede({"info", folder / "bad.brep", "--json"})), names);
  EXPECT_TRUE(names.contains("reason"));
  expect_explained(names);
}

}  // namespace
}  // namespace recede::test
