#include <recede/geometry/error.h>
#include <recede/render/detail/markup.h>
#include <recede/render/svg_plot.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {

namespace {

using detail::escape_markup;
using detail::grouped;
using detail::short_number;

// Of middle lightness, so that they show on light and dark pages; apart for the common forms of colour
// blindness.
constexpr std::array<std::string_view, 6> k_colors{"#2f7fd6", "#e0731d", "#12936b",
                                                   "#c4478f", "#8a6fd6", "#9a8420"};
constexpr int k_left = 84, k_right = 18, k_top = 62, k_bottom = 48;

struct Tick {
  double value;
  std::string label;  // empty: a thin line only
};

// One axis: from values to places along the drawing.
struct Scale {
  bool logarithmic;
  double low, high;  // values, or their logarithms
  double from, to;   // places
  double step = 1;   // between linear ticks
  double place(double value) const {
    const double position = logarithmic ? std::log10(value) : value;
    return from + (position - low) / (high - low) * (to - from);
  }
};

bool can_show(const Plot& plot, const Vec2& point) {
  return point.allFinite() && (!plot.x.logarithmic || point.x() > 0) &&
         (!plot.y.logarithmic || point.y() > 0);
}

// Steps of 1, 2 or 5 times a power of ten, about `wanted` of them.
double nice_step(double range, int wanted) {
  const double raw = range / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  const double lead = raw / power;
  return power * (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10);
}

Scale fit(const PlotAxis& axis, std::vector<double> values, double from, double to, int wanted) {
  Scale scale{axis.logarithmic, 0, 1, from, to};
  if (values.empty()) return scale;
  if (axis.logarithmic) {
    for (double& value : values) value = std::log10(value);
  }
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  scale.low = *least;
  scale.high = *most;
  if (axis.logarithmic) {
    const double room = std::max(0.08, 0.05 * (scale.high - scale.low));
    scale.low -= room;
    scale.high += room;
    return scale;
  }
  // Amounts are read from zero when they come near it.
  if (scale.low > 0 && scale.low < 0.5 * scale.high) scale.low = 0;
  if (!(scale.high > scale.low)) {
    const double room = scale.high == 0 ? 1 : 0.5 * std::abs(scale.high);
    scale.low -= room;
    scale.high += room;
  }
  scale.step = nice_step(scale.high - scale.low, wanted);
  scale.low = std::floor(scale.low / scale.step + 1e-9) * scale.step;
  scale.high = std::ceil(scale.high / scale.step - 1e-9) * scale.step;
  return scale;
}

// Numbers on an axis have few digits already: those that matter are kept, trailing zeros are not.
std::string tick_label(double value) {
  const double size = std::abs(value);
  if (size == 0) return "0";
  if (size >= 10'000 && size < 1e6) {
    const std::string digits = grouped(static_cast<std::size_t>(std::lround(size)));
    return value < 0 ? fmt::format("-{}", digits) : digits;
  }
  if (size < 0.001 || size >= 1e6) {
    std::string text = short_number(value);
    if (const std::size_t zeros = text.find(".00"); zeros != std::string::npos) text.erase(zeros, 3);
    if (text.rfind("1×", 0) == 0) text.erase(0, std::string("1×").size());
    return text;
  }
  return fmt::format("{:.6g}", value);
}

std::vector<Tick> linear_ticks(const Scale& scale) {
  std::vector<Tick> ticks;
  const auto first = std::llround(scale.low / scale.step);
  const auto last = std::llround(scale.high / scale.step);
  for (auto i = first; i <= last; ++i) {
    const double value = static_cast<double>(i) * scale.step;
    ticks.push_back({value, tick_label(value)});
  }
  return ticks;
}

// Powers of ten; over few decades, 2 and 5 times them carry labels, too; over many, only every n-th power
// does.
std::vector<Tick> logarithmic_ticks(const Scale& scale, int wanted) {
  std::vector<Tick> ticks;
  const double decades = scale.high - scale.low;
  const int every = std::max(1, static_cast<int>(std::ceil(decades / (wanted + 1))));
  const int first = static_cast<int>(std::floor(scale.low)), last = static_cast<int>(std::ceil(scale.high));
  for (int exponent = first; exponent <= last; ++exponent) {
    for (int lead = 1; lead <= 9; ++lead) {
      const double value = lead * std::pow(10.0, exponent);
      const double position = std::log10(value);
      if (position < scale.low - 1e-9 || position > scale.high + 1e-9) continue;
      if (lead > 1 && decades > 4) continue;
      const bool power = lead == 1 && exponent % every == 0;
      const bool between = 2 * decades < wanted && (lead == 2 || lead == 5);
      const bool all = decades < 0.5;
      ticks.push_back({value, power || between || all ? tick_label(value) : std::string()});
    }
  }
  return ticks;
}

std::vector<Tick> ticks_of(const Scale& scale, int wanted) {
  return scale.logarithmic ? logarithmic_ticks(scale, wanted) : linear_ticks(scale);
}

std::string marker(std::size_t kind, double x, double y, std::string_view color) {
  switch (kind % 4) {
    case 0:
      return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>", x, y, color);
    case 1:
      return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"7\" height=\"7\" fill=\"{}\"/>", x - 3.5,
                         y - 3.5, color);
    case 2:
      return fmt::format("<path d=\"M{:.1f} {:.1f}l4.6 8h-9.2z\" fill=\"{}\"/>", x, y - 5, color);
    default:
      return fmt::format("<path d=\"M{:.1f} {:.1f}l5 5l-5 5l-5 -5z\" fill=\"{}\"/>", x, y - 5, color);
  }
}

std::string text(double x, double y, std::string_view anchor, std::string_view content,
                 std::string_view more = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
                     escape_markup(content));
}

std::string draw_axes(const Plot& plot, const Scale& x, const Scale& y, int wanted_x, int wanted_y) {
  std::string svg;
  const auto grid = [&](double x1, double y1, double x2, double y2, bool labelled) {
    svg +=
        fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke-opacity=\"{}\"/>\n",
                    x1, y1, x2, y2, labelled ? "0.2" : "0.08");
  };
  svg += "<g stroke=\"currentColor\">\n";
  for (const Tick& tick : ticks_of(x, wanted_x)) {
    grid(x.place(tick.value), y.from, x.place(tick.value), y.to, !tick.label.empty());
  }
  for (const Tick& tick : ticks_of(y, wanted_y)) {
    grid(x.from, y.place(tick.value), x.to, y.place(tick.value), !tick.label.empty());
  }
  svg += fmt::format(
      "<path d=\"M{0:.1f} {1:.1f}V{2:.1f}H{3:.1f}\" fill=\"none\" stroke-opacity=\"0.7\"/>\n</g>\n", x.from,
      y.to, y.from, x.to);
  for (const Tick& tick : ticks_of(x, wanted_x))
    svg += text(x.place(tick.value), y.from + 17, "middle", tick.label);
  for (const Tick& tick : ticks_of(y, wanted_y))
    svg += text(x.from - 7, y.place(tick.value) + 4.5, "end", tick.label);
  svg += text((x.from + x.to) / 2, plot.height - 8.0, "middle", plot.x.label);
  const double middle = (y.from + y.to) / 2;
  svg +=
      text(16, middle, "middle", plot.y.label, fmt::format(" transform=\"rotate(-90 16 {:.1f})\"", middle));
  return svg;
}

// Whole numbers as they are, counts above all.
std::string value_text(double value) {
  if (value >= 0 && value < 1e12 && value == std::floor(value))
    return grouped(static_cast<std::size_t>(value));
  return short_number(value);
}

std::string draw_series(const Plot& plot, std::size_t index, const Scale& x, const Scale& y) {
  const std::string_view color = k_colors[index % k_colors.size()];
  std::string path, markers;
  for (const Vec2& point : plot.series[index].points) {
    if (!can_show(plot, point)) continue;
    const double at_x = x.place(point.x()), at_y = y.place(point.y());
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", at_x, at_y);
    const std::string values = fmt::format("{}: {} {}, {} {}", plot.series[index].name, plot.x.label,
                                           value_text(point.x()), plot.y.label, value_text(point.y()));
    markers += fmt::format("<g class=\"point\"><title>{}</title>{}</g>\n", escape_markup(values),
                           marker(index, at_x, at_y, color));
  }
  if (!plot.series[index].line || path.empty()) return markers;
  return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n{}", path, color,
                     markers);
}

std::string draw_legend(const Plot& plot) {
  std::string svg;
  double at = k_left;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    svg += marker(i, at + 5, 44, k_colors[i % k_colors.size()]);
    svg += text(at + 15, 48.5, "start", plot.series[i].name);
    const double text_width =
        8.2 * static_cast<double>(plot.series[i].name.size());  // wide letters at 13 units
    at += 15 + text_width + 18;
  }
  return svg;
}

}  // namespace

std::string svg_plot(const Plot& plot) {
  if (plot.width < 200 || plot.height < 150) throw OptionError("a plot needs at least 200 x 150 units");
  std::vector<double> xs, ys;
  for (const PlotSeries& series : plot.series) {
    for (const Vec2& point : series.points) {
      if (!can_show(plot, point)) continue;
      xs.push_back(point.x());
      ys.push_back(point.y());
    }
  }
  const int wanted_x = std::max(2, plot.width / 90), wanted_y = std::max(2, plot.height / 60);
  const Scale x = fit(plot.x, xs, k_left, plot.width - k_right, wanted_x);
  const Scale y = fit(plot.y, ys, plot.height - k_bottom, k_top, wanted_y);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "role=\"img\" "
      "aria-label=\"{2}\" font-family=\"system-ui, sans-serif\" font-size=\"13\" fill=\"currentColor\" "
      "style=\"max-width:100%;height:auto\">\n",
      plot.width, plot.height, escape_markup(plot.title));
  svg += text(k_left, 22, "start", plot.title, " font-size=\"15\" font-weight=\"600\"");
  if (xs.empty()) {
    svg += text(plot.width / 2.0, plot.height / 2.0, "middle", "nothing to show");
  } else {
    svg += draw_legend(plot);
    svg += draw_axes(plot, x, y, wanted_x, wanted_y);
    for (std::size_t i = 0; i < plot.series.size(); ++i) svg += draw_series(plot, i, x, y);
  }
  return svg + "</svg>\n";
}

}  // namespace recede
