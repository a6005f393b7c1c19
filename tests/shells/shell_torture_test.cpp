// Layers over one mesh spoilt in many ways, repaired as the command does: for each it is known what comes.
#include "excused_shells.h"
#include "torture_set.h"
#include <recede/geometry/polygon_mesh.h>

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
  }
}

INSTANTIATE_TEST_SUITE_P(Set, ShellTorture, testing::ValuesIn(test::torture_set(600)),
                         [](const auto& variant) { return variant.param.name; });

}  // namespace
}  // namespace recede
