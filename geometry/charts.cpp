// `make_charts`: merging and straightening, and what is told about them.
#include <recede/geometry/detail/chart_surface.h>
#include <recede/geometry/error.h>

#include <cmath>

namespace recede {
namespace detail {

UnitSized::UnitSized(const PolygonSoup& original) : soup(original) {
  double largest = 0;
  for (const Vec3& p : soup.positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  if (!(largest > 0)) return;
  // First within 1, then from the box's corner on: differences of the largest doubles would overflow. One
  // less than the exponent, since 2^1024 is none.
  const double within = std::ldexp(1.0, std::ilogb(largest) / 2);
  const double rest = std::ldexp(1.0, std::ilogb(largest) - std::ilogb(largest) / 2);
  for (Vec3& p : soup.positions) p = p / within / rest;
  const Box3 box = bounding_box(soup);
  const double side = box.sizes().maxCoeff();
  const double box_unit = side > 0 ? std::ldexp(1.0, std::ilogb(side)) : 1.0;
  for (Vec3& p : soup.positions) p = (p - box.min()) / box_unit;
  unit = within * rest * box_unit;
}

namespace {

void number_by_lowest_face(std::vector<Index>& chart_of, std::size_t n_charts) {
  std::vector<Index> numbers(n_charts, k_no_index);
  Index next = 0;
  for (Index& chart : chart_of) {
    if (numbers[chart] == k_no_index) numbers[chart] = next++;
    chart = numbers[chart];
  }
}

}  // namespace

ChartSurface find_charts(const UnitSized& sized, const ChartOptions& options, ChartReport& report,
                         Progress* progress) {
  ChartSurface surface(sized.soup, options, report);
  ChartOptions scaled = options;
  if (scaled.cost_limit) scaled.cost_limit = *scaled.cost_limit / sized.unit / sized.unit;
  report.charts = merge_charts(surface, scaled, report, progress);
  report.largest_cost *= sized.unit * sized.unit;
  if (options.straighten) report.straightened = straighten_borders(surface, progress);
  number_by_lowest_face(surface.chart_of, report.charts);
  return surface;
}

double cut_length(const ChartSurface& surface) {
  double length = 0;
  for (Index side = 0; side < surface.opposite.size(); ++side) {
    const Index other = surface.opposite[side];
    if (other != k_no_index && side < other && !surface.is_glued(side)) length += surface.length(side);
  }
  return length;
}

std::vector<VertexPlace> vertex_places(const ChartSurface& surface) {
  const PolygonSoup& soup = *surface.soup;
  // Two different charts at each vertex are remembered; what lies beyond a border counts as one.
  struct Seen {
    Index first = k_no_index, second = k_no_index;
  };
  constexpr Index k_outside = k_no_index - 1;
  std::vector<Seen> seen(soup.positions.size());
  std::vector<VertexPlace> places(soup.positions.size(), VertexPlace::interior);
  const auto see = [&](Index v, Index chart) {
    Seen& s = seen[v];
    if (s.first == k_no_index) s.first = chart;
    if (s.first == chart || s.second == chart) return;
    places[v] = s.second == k_no_index ? VertexPlace::boundary : VertexPlace::corner;
    s.second = chart;
  };
  for (Index side = 0; side < soup.n_corners(); ++side) {
    see(surface.from(side), surface.chart_of[surface.face_of[side]]);
  }
  for (Index side = 0; side < soup.n_corners(); ++side) {
    if (surface.opposite[side] != k_no_index) continue;
    see(surface.from(side), k_outside);
    see(surface.to(side), k_outside);
  }
  return places;
}

void check(const ChartOptions& options) {
  if (!(options.compactness >= 0)) throw OptionError("the weight of compactness must not be negative");
  if (options.bend_limit && !(*options.bend_limit >= 0)) {
    throw OptionError("the bend limit must not be negative");
  }
}

}  // namespace detail

std::string_view to_string(ChartRefusal refusal) {
  switch (refusal) {
    case ChartRefusal::no_disk:
      return "no disk";
    case ChartRefusal::few_corners:
      return "too few corners";
    case ChartRefusal::bend:
      return "bend limit";
    case ChartRefusal::limit:
      return "not asked for";
    case ChartRefusal::count:
      break;
  }
  return "";
}

Charts make_charts(const PolygonSoup& soup, const ChartOptions& options, Progress* progress) {
  validate(soup, "charts");
  detail::check(options);
  Charts result;
  const detail::UnitSized sized(soup);
  const detail::ChartSurface surface = detail::find_charts(sized, options, result.report, progress);
  result.report.cut_length = detail::cut_length(surface) * sized.unit;
  result.vertex_places = detail::vertex_places(surface);
  result.face_charts = surface.chart_of;
  return result;
}

}  // namespace recede
