#include "plot_sheet.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

namespace recede::bench {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(PlotSheet, PointsGoToTheSeriesOfTheirName) {
  Plot plot = log_plot("title", "x", "y");
  add_point(plot, "ours", 1, 2);
  add_point(plot, "theirs", 3, 4);
  add_point(plot, "ours", 5, 6);
  ASSERT_EQ(plot.series.size(), 2u);
  EXPECT_EQ(plot.series[0].name, "ours");
  EXPECT_THAT(plot.series[0].points, ElementsAre(Vec2(1, 2), Vec2(5, 6)));
  EXPECT_THAT(plot.series[1].points, ElementsAre(Vec2(3, 4)));
  EXPECT_TRUE(plot.x.logarithmic);
  EXPECT_TRUE(plot.y.logarithmic);
}

TEST(PlotSheet, PlotsWithoutPointsAreLeftOut) {
  Plot full = log_plot("full", "x", "y");
  add_point(full, "ours", 1, 2);
  const std::string sheet = plot_sheet(std::vector{log_plot("bare", "x", "y"), full});
  EXPECT_THAT(sheet, HasSubstr("full"));
  EXPECT_THAT(sheet, Not(HasSubstr("bare")));
  EXPECT_THAT(plot_sheet(std::vector{log_plot("bare", "x", "y")}), "");
}

TEST(PlotSheet, TheThirdPlotBeginsASecondRow) {
  Plot plot = log_plot("plot", "x", "y");
  add_point(plot, "ours", 1, 2);
  const std::string sheet = plot_sheet(std::vector{plot, plot, plot});
  const std::string below = fmt::format("translate(0 {})", plot.height),
                    beside = fmt::format("translate({} 0)", plot.width);
  EXPECT_THAT(sheet, HasSubstr(below));
  EXPECT_THAT(sheet, HasSubstr(beside));
  EXPECT_THAT(sheet, HasSubstr(fmt::format("viewBox=\"0 0 {} {}\"", 2 * plot.width, 2 * plot.height)));
}

}  // namespace
}  // namespace recede::bench
