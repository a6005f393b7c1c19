// Plots of measurements, all alike.
#pragma once

#include <recede/render/svg_plot.h>

#include <span>
#include <string>

namespace recede::bench {

/// Without points yet. Axes are logarithmic, labels with their units.
Plot log_plot(const std::string& title, const std::string& x, const std::string& y);

/// To the series of that name, which begins with its first point.
void add_point(Plot& plot, const std::string& series, double x, double y);

/// An SVG of its own: plots that have points, two beside each other, on white. Empty without any.
std::string plot_sheet(std::span<const Plot> plots);

}  // namespace recede::bench
