#include "plot_sheet.h"

#include <fmt/format.h>

#include <algorithm>

namespace recede::bench {
namespace {

// Six short names fit into the legend.
constexpr int k_width = 720, k_height = 400;
constexpr std::size_t k_columns = 2;

bool has_points(const Plot& plot) {
  return std::any_of(plot.series.begin(), plot.series.end(),
                     [](const PlotSeries& series) { return !series.points.empty(); });
}

}  // namespace

Plot log_plot(const std::string& title, const std::string& x, const std::string& y) {
  return {.title = title, .x = {x, true}, .y = {y, true}, .width = k_width, .height = k_height};
}

void add_point(Plot& plot, const std::string& series, double x, double y) {
  auto found = std::find_if(plot.series.begin(), plot.series.end(),
                            [&](const PlotSeries& there) { return there.name == series; });
  if (found == plot.series.end()) found = plot.series.insert(found, PlotSeries{series, {}});
  found->points.emplace_back(x, y);
}

std::string plot_sheet(std::span<const Plot> plots) {
  std::string drawn;
  std::size_t n = 0;
  for (const Plot& plot : plots) {
    if (!has_points(plot)) continue;
    drawn += fmt::format("<g transform=\"translate({} {})\">\n{}</g>\n",
                         static_cast<std::size_t>(k_width) * (n % k_columns),
                         static_cast<std::size_t>(k_height) * (n / k_columns), svg_plot(plot));
    ++n;
  }
  if (n == 0) return {};
  const std::size_t width = k_width * std::min(n, k_columns),
                    height = k_height * ((n + k_columns - 1) / k_columns);
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\">\n"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n{2}</svg>\n",
      width, height, drawn);
}

}  // namespace recede::bench
