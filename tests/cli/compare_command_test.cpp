// `recede compare` of two surfaces.
#include "run_recede.h"

#include <cmath>

namespace recede::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

TEST(CompareCommand, ReportsEveryDocumentedField) {
  const TempFolder folder;
  ASSERT_EQ(run_recede({"simplify", write_sphere(folder, 2000), "-o", folder / "small.ply", "--ratio", "0.25",
                        "--no-measure"})
                .code,
            0);
  const json result = json_of(run_recede({"compare", folder / "sphere.ply", folder / "small.ply", "--samples",
                                          "5000", "--bound-tolerance", "0.02", "--json"}));
  EXPECT_EQ(result.at("command"), "compare");
  EXPECT_EQ(result.at("first").at("input"), (folder / "sphere.ply").string());
  EXPECT_GT(result.at("first").at("faces"), result.at("second").at("faces"));
  expect_error_fields(result.at("error"), result.at("diagonal"));
  const double bound = result.at("error").at("bound"), lower = result.at("max_lower");
  EXPECT_LE(bound - lower, 0.02 * bound * (1 + 1e-12));
  EXPECT_LT(lower, bound);
  for (const char* side : {"forward", "backward"}) {
    EXPECT_GE(result.at(side).at("max"), result.at(side).at("rms"));
    EXPECT_GE(result.at(side).at("rms"), result.at(side).at("mean"));
    EXPECT_EQ(result.at(side).at("at").size(), 3u);
  }
  EXPECT_GE(result.at("samples"), 10000);
  EXPECT_GT(result.at("samples_per_unit_area"), 0);
  EXPECT_GE(result.at("seconds"), 0);
}

TEST(CompareCommand, CertifiesNothingWhenToldSo) {
  const TempFolder folder;
  const std::string sphere = write_sphere(folder, 500);
  const json error = json_of(run_recede({"compare", sphere, sphere, "--no-bound", "--json"})).at("error");
  EXPECT_TRUE(error.at("bound").is_null());
  EXPECT_TRUE(error.at("bound_relative").is_null());
  EXPECT_LT(error.at("max"), 1e-12);
}

/// The unit square with a vertex twice, and half a unit over it a rectangle that is two units longer.
struct Rectangles {
  TempFolder folder;
  std::string square =
      folder.write("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\nf 5 3 4\n");
  std::string longer = folder.write("longer.obj", "v 0 0 0.5\nv 3 0 0.5\nv 3 1 0.5\nv 0 1 0.5\nf 1 2 3 4\n");
  double farthest = std::hypot(2, 0.5);
};

TEST(CompareCommand, TellsTheTwoDirectionsApart) {
  const Rectangles r;
  const json result = json_of(run_recede({"compare", r.square, r.longer, "--json"}));
  EXPECT_NEAR(result.at("forward").at("max"), 0.5, 1e-12);
  EXPECT_NEAR(result.at("backward").at("max"), r.farthest, 1e-12);
  EXPECT_NEAR(result.at("error").at("max"), r.farthest, 1e-12);
  EXPECT_EQ(result.at("backward").at("at")[0], 3);
  EXPECT_EQ(result.at("backward").at("at")[2], 0.5);
  EXPECT_NEAR(result.at("diagonal"), std::sqrt(2), 1e-12) << "the first one's";
  EXPECT_NEAR(result.at("max_lower"), r.farthest, 0.05 * r.farthest) << "the tolerance of the bound";
}

TEST(CompareCommand, PrintsBothDirectionsAndWhatReadingRepaired) {
  const Rectangles r;
  const CommandResult run = run_recede({"compare", r.square, r.longer});
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.output,
              AllOf(HasSubstr("faces        2 and 1\n"), HasSubstr("maximum      2.062 (146 %), sampled\n"),
                    HasSubstr("1st to 2nd   max 0.5 at "), HasSubstr("2nd to 1st   max 2.062 at 3 ")));
  EXPECT_THAT(run.remarks, HasSubstr("recede: merge_identical_vertices: "));
}

}  // namespace
}  // namespace recede::test
