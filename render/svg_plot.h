// Line and scatter plots as SVG.
#pragma once

#include <recede/geometry/vec.h>

#include <string>
#include <vector>

namespace recede {

struct PlotAxis {
  std::string label;         ///< with its unit
  bool logarithmic = false;  ///< base 10
};

struct PlotSeries {
  std::string name;          ///< for the legend
  std::vector<Vec2> points;  ///< joined in this order
  bool line = true;          ///< false: markers only
};

struct Plot {
  std::string title = {};
  PlotAxis x = {}, y = {};
  /// Up to six are told apart by colour and marker; more repeat them.
  std::vector<PlotSeries> series = {};
  int width = 520;  ///< units of the SVG; text is 13 of them high
  int height = 360;
};

/// An `<svg>` element. Text and axes take the surrounding page's text colour (black in a file of its own),
/// the ground is transparent, and it scales to the width that it is given. Each point is a group of class
/// `point` whose title, which browsers show at the pointer, says its series and values. Points that aren't
/// finite, or not positive on a logarithmic axis, are left out; a plot without points says so. Throws
/// `OptionError` below 200 x 150 units.
std::string svg_plot(const Plot& plot);

}  // namespace recede
