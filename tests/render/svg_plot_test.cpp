#include "markup_check.h"
#include <recede/geometry/error.h>
#include <recede/render/detail/markup.h>
#include <recede/render/svg_plot.h>

#include <gmock/gmock.h>

#include <limits>

namespace recede {
namespace {

using detail::grouped;
using detail::short_number;

using testing::HasSubstr;
using testing::Not;

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

Plot log_plot() {
  return {.title = "Error <of> \"A & B\"",
          .x = {"faces", true},
          .y = {"error (m)", true},
          .series = {{"a<b", {Vec2(100, 1e-3), Vec2(1000, 1e-4), Vec2(10000, 1e-5)}},
                     {"rms", {Vec2(100, 1e-4)}}}};
}

TEST(SvgPlot, IsWellFormedAndEscapesItsText) {
  const std::string svg = svg_plot(log_plot());
  EXPECT_EQ(find_markup_error(svg), "");
  EXPECT_THAT(svg, HasSubstr("Error &lt;of&gt; &quot;A &amp; B&quot;"));
  EXPECT_THAT(svg, HasSubstr("a&lt;b"));
  EXPECT_THAT(svg, HasSubstr("error (m)"));
}

TEST(SvgPlot, EachPointSaysItsValues) {
  const std::string svg = svg_plot(log_plot());
  EXPECT_EQ(count(svg, "<g class=\"point\"><title>"), 4u);
  EXPECT_THAT(svg, HasSubstr("<title>a&lt;b: faces 10\u202f000, error (m) 1.00×10⁻⁵</title>"));
}

TEST(SvgPlot, LogarithmicAxesLabelPowersOfTen) {
  const std::string svg = svg_plot(log_plot());
  for (const char* label : {">100<", ">1000<", ">0.001<", ">10⁻⁴<", ">10⁻⁵<"})
    EXPECT_THAT(svg, HasSubstr(label));
}

TEST(SvgPlot, EqualFactorsAreEqualStepsOnALogarithmicAxis) {
  Plot plot{.x = {"x", true}, .y = {"y", false}, .series = {{"s", {Vec2(1, 1), Vec2(10, 1), Vec2(100, 1)}}}};
  const std::string svg = svg_plot(plot);
  std::vector<double> places;
  for (std::size_t at = svg.find("cx=\""); at != std::string::npos; at = svg.find("cx=\"", at + 1)) {
    places.push_back(std::stod(svg.substr(at + 4)));
  }
  // The legend's marker comes first.
  ASSERT_EQ(places.size(), 4u);
  EXPECT_NEAR(places[2] - places[1], places[3] - places[2], 0.11);
}

TEST(SvgPlot, LinearAxesHaveRoundTicksThatHoldAllPoints) {
  Plot plot{
      .x = {"level", false}, .y = {"seconds", false}, .series = {{"s", {Vec2(1, 0.13), Vec2(4, 0.87)}}}};
  const std::string svg = svg_plot(plot);
  for (const char* label : {">0<", ">0.2<", ">0.4<", ">1<", ">2<", ">4<"}) EXPECT_THAT(svg, HasSubstr(label));
}

TEST(SvgPlot, LinearAxesLabelLargeNumbersOfBothSigns) {
  const std::string svg = svg_plot(
      {.x = {"x", false}, .y = {"y", false}, .series = {{"s", {Vec2(0, -25'000), Vec2(1, 15'000)}}}});
  for (const char* label : {">-20\u202f000<", ">-10\u202f000<", ">0<", ">10\u202f000<"})
    EXPECT_THAT(svg, HasSubstr(label));
}

TEST(SvgPlot, PointsThatALogarithmicAxisCannotShowAreLeftOut) {
  Plot plot = log_plot();
  const std::size_t before = count(svg_plot(plot), "<circle");
  plot.series[0].points.emplace_back(0, 1);
  plot.series[0].points.emplace_back(10, std::numeric_limits<double>::quiet_NaN());
  plot.series[0].points.emplace_back(10, std::numeric_limits<double>::infinity());
  const std::string svg = svg_plot(plot);
  EXPECT_EQ(count(svg, "<circle"), before);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(SvgPlot, EqualAndMissingValuesStillMakeAPlot) {
  Plot plot{.x = {"x", false}, .y = {"y", false}, .series = {{"s", {Vec2(3, 0), Vec2(3, 0)}}}};
  EXPECT_THAT(svg_plot(plot), Not(HasSubstr("nan")));
  plot.series[0].points.clear();
  EXPECT_THAT(svg_plot(plot), HasSubstr("nothing to show"));
  EXPECT_THROW(svg_plot({.width = 10}), OptionError);
}

TEST(Markup, NumbersKeepThreeDigits) {
  EXPECT_EQ(short_number(0), "0");
  EXPECT_EQ(short_number(0.0123456), "0.0123");
  EXPECT_EQ(short_number(1), "1.00");
  EXPECT_EQ(short_number(99.96), "100");
  EXPECT_EQ(short_number(123456), "123000");
  EXPECT_EQ(short_number(4.2e-7), "4.20×10⁻⁷");
  EXPECT_EQ(short_number(-1.5e12), "-1.50×10¹²");
  EXPECT_EQ(grouped(75408), "75\u202f408");
  EXPECT_EQ(grouped(999), "999");
}

}  // namespace
}  // namespace recede
