// Layers over one mesh spoilt in many ways, repaired as the command does: for each it is known what comes.
#include "excused_shells.h"
#include "torture_set.h"
#include <recede/geometry/alpha_wrap.h>
#include <recede/geometry/polygon_mesh.h>

#include <tbb/global_control.h>

#include <map>

namespace recede {
namespace {

enum class Outcome {
  valid,    // everywhere
  excused,  // but where the surface meets itself
  given_up  // but also where two sheets overlap by less than can be told
};

// Of the repair steps, `split_non_manifold` opens sides of three triangles, so that copies of vertices touch
// around fins and caps.
const std::map<std::string, Outcome>& outcomes() {
  static const std::map<std::string, Outcome> outcomes = {{"base", Outcome::valid},
                                                          {"far", Outcome::valid},
                                                          {"tiny", Outcome::valid},
                                                          {"huge", Outcome::valid},
                                                          {"overlapping_copies", Outcome::excused},
                                                          {"holes", Outcome::valid},
                                                          {"flipped", Outcome::valid},
                                                          {"duplicate_faces", Outcome::valid},
                                                          {"fins", Outcome::excused},
                                                          {"t_junctions", Outcome::given_up},
                                                          {"repeated_corners", Outcome::valid},
                                                          {"collinear_caps", Outcome::excused},
                                                          {"soup", Outcome::valid},
                                                          {"noise", Outcome::excused},
                                                          {"near_copies", Outcome::excused},
                                                          {"squashed", Outcome::valid}};
  return outcomes;
}

class ShellTorture : public testing::TestWithParam<test::TortureVariant> {};

TEST_P(ShellTorture, HasTheOutcomeThatIsKnown) {
  const PolygonSoup surface = to_soup(repair_to_polygon_mesh(GetParam().soup).mesh);
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    SCOPED_TRACE(side == ShellSide::exterior ? "exterior" : "interior");
    ShellOptions options;
    options.side = side;
    options.thickness = 0.03 * bounding_box(surface).sizes().maxCoeff();
    const Shell shell = build_shell(surface, options);
    const ShellLayer& layer = shell.exterior ? *shell.exterior : *shell.interior;
    const Outcome outcome = outcomes().at(GetParam().name);
    EXPECT_EQ(shell.is_valid(), outcome == Outcome::valid);
    EXPECT_EQ(layer.excused.empty(), outcome != Outcome::excused);
    EXPECT_EQ(layer.given_up.empty(), outcome != Outcome::given_up);
    EXPECT_EQ(layer.validity.has_valid_base(), outcome != Outcome::excused);
    test::expect_valid_elsewhere(shell, layer, side == ShellSide::interior);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Shell again = build_shell(surface, options);
    const ShellLayer& same = again.exterior ? *again.exterior : *again.interior;
    EXPECT_EQ(same.tops, layer.tops);
    EXPECT_EQ(same.given_up, layer.given_up);
  }
}

// Whatever it was: the wrap is a closed surface that doesn't meet itself.
TEST_P(ShellTorture, HasAValidExteriorAroundAWrap) {
  if (!can_alpha_wrap()) GTEST_SKIP() << "built without CGAL's GPL parts";
  const PolygonSoup surface = to_soup(repair_to_polygon_mesh(GetParam().soup).mesh);
  const Box3 box = bounding_box(surface);
  const PolygonSoup wrap = alpha_wrap(surface, {.alpha = 0.05 * box.diagonal().norm()});
  ShellOptions options;
  options.thickness = 0.03 * box.sizes().maxCoeff();
  const Shell shell = build_shell(wrap, options);
  EXPECT_TRUE(shell.exterior->excused.empty());
  EXPECT_TRUE(shell.exterior->given_up.empty());
  EXPECT_TRUE(check_shell(shell.base.positions, shell.exterior->tops, shell.base.corner_vertices).is_valid());
  // All of them are balls or plates, nearly convex; wraps have folds of their own, most around the plate.
  EXPECT_GT(reached_thickness(shell, *shell.exterior).mean, 0.7);
}

INSTANTIATE_TEST_SUITE_P(Set, ShellTorture, testing::ValuesIn(test::torture_set(600)),
                         [](const auto& variant) { return variant.param.name; });

}  // namespace
}  // namespace recede
