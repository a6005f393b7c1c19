#include <recede/lod/detail/grid_sweep.h>

#include <algorithm>
#include <cstdlib>

namespace recede::detail {
std::int64_t twice_area(const std::array<GridPoint, 3>& p, std::size_t x, std::size_t y) {
  const auto d = [&](std::size_t k, std::size_t axis) {
    return static_cast<std::int64_t>(p[k][axis]) - p[0][axis];
  };
  return d(1, x) * d(2, y) - d(2, x) * d(1, y);
}

SweepPlan plan_sweep(const std::array<GridPoint, 3>& p) {
  SweepPlan plan;
  MainDirection longest{3, -1};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const MainDirection main = main_direction(p[i], p[j]);
    const auto [least, most] = std::minmax(p[i][main.axis], p[j][main.axis]);
    if (p[k][main.axis] < least || p[k][main.axis] > most) continue;
    if (main.length < longest.length || (main.length == longest.length && main.axis >= longest.axis))
      continue;
    longest = main;
    plan.a = i;
    plan.b = j;
    plan.c = k;
  }
  plan.sweep = longest.axis;
  if (p[plan.a][plan.sweep] > p[plan.b][plan.sweep]) {
    std::swap(plan.a, plan.b);
    plan.is_reversed = true;
  }
  std::int64_t largest = -1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (axis == plan.sweep) continue;
    const std::int64_t area = std::abs(twice_area(p, plan.sweep, axis));
    if (area <= largest) continue;
    largest = area;
    plan.side = axis;
  }
  plan.is_flat = largest == 0;
  const bool counter_clockwise = (twice_area(p, plan.sweep, plan.side) > 0) != plan.is_reversed;
  plan.upwards = counter_clockwise || plan.is_flat ? 1 : -1;
  return plan;
}

void GridSweep::set(const std::array<GridPoint, 3>& corners) {
  plan_ = plan_sweep(corners);
  nodes_.clear();
  const auto place = [&](const GridPoint& p) {
    nodes_.push_back(
        {static_cast<double>(p[plan_.sweep]), static_cast<double>(plan_.upwards * p[plan_.side])});
  };
  for (const GridPoint& corner : corners) place(corner);
  for (std::size_t k = 0; k < 3; ++k) place_edge(k, corners);
  n_border_ = nodes_.size();
  primary_.clear();
  append_edge(primary_, plan_.a, plan_.b);
  primary_.push_back(static_cast<std::uint32_t>(plan_.b));
  rest_.clear();
  append_edge(rest_, plan_.a, plan_.c);
  append_edge(rest_, plan_.c, plan_.b);
  rest_.push_back(static_cast<std::uint32_t>(plan_.b));
  origin_ = nodes_[plan_.a];
  to_b_ = {nodes_[plan_.b].sweep - origin_.sweep, nodes_[plan_.b].side - origin_.side};
  to_c_ = {nodes_[plan_.c].sweep - origin_.sweep, nodes_[plan_.c].side - origin_.side};
  twice_area_ = to_b_.sweep * to_c_.side - to_c_.sweep * to_b_.side;
  if (!plan_.is_flat) place_inside();
}

/// Whole numbers until the last division, so that places are the same from both ends.
void GridSweep::place_edge(std::size_t k, const std::array<GridPoint, 3>& corners) {
  const GridPoint &from = corners[k], &to = corners[(k + 1) % 3];
  const std::int64_t pieces = main_direction(from, to).length;
  first_on_edge_[k] = nodes_.size();
  on_edge_[k] = static_cast<std::size_t>(std::max<std::int64_t>(pieces, 1) - 1);
  const auto at = [&](std::size_t axis, std::int64_t i) {
    const std::int64_t sum = (pieces - i) * from[axis] + i * to[axis];
    return static_cast<double>(sum) / static_cast<double>(pieces);
  };
  for (std::int64_t i = 1; i < pieces; ++i)
    nodes_.push_back({at(plan_.sweep, i), plan_.upwards * at(plan_.side, i)});
}

/// Without the last corner.
void GridSweep::append_edge(Chain& chain, std::size_t from, std::size_t to) const {
  chain.push_back(static_cast<std::uint32_t>(from));
  const bool forwards = (from + 1) % 3 == to;
  const std::size_t k = forwards ? from : to;
  for (std::size_t i = 0; i < on_edge_[k]; ++i) {
    const std::size_t place = forwards ? i : on_edge_[k] - 1 - i;
    chain.push_back(static_cast<std::uint32_t>(first_on_edge_[k] + place));
  }
}

GridSweep::Run GridSweep::run_from(std::size_t first) const {
  const double column = rounded(nodes_[rest_[first]].sweep);
  std::size_t last = first;
  while (last + 1 < rest_.size() && rounded(nodes_[rest_[last + 1]].sweep) == column) ++last;
  return {first, last};
}

/// Grid points between the primary edge and the lower end of the other edges' run in every column.
void GridSweep::place_inside() {
  column_first_.assign(1, static_cast<std::uint32_t>(nodes_.size()));
  Run run = run_from(0);
  for (std::size_t column = 1; column + 1 < primary_.size(); ++column) {
    run = run_from(run.last + 1);
    column_first_.push_back(static_cast<std::uint32_t>(nodes_.size()));
    const double sweep = nodes_[primary_[column]].sweep, below = rounded(nodes_[primary_[column]].side);
    const double above =
        std::min(rounded(nodes_[rest_[run.first]].side), rounded(nodes_[rest_[run.last]].side));
    for (double side = below + 1; side < above; ++side) nodes_.push_back({sweep, side});
  }
  column_first_.push_back(static_cast<std::uint32_t>(nodes_.size()));
}

/// Borders of the strips on both sides of a column, and the cap between the two where the other edges' run
/// rises above both.
void GridSweep::build_column(std::size_t column, const Run& run) {
  const auto height = [&](std::size_t i) { return nodes_[rest_[i]].side; };
  std::size_t top = run.first;
  for (std::size_t i = run.first; i <= run.last; ++i) {
    if (height(i) > height(top)) top = i;
  }
  // Where one end of the run is lower, what rises from it below the other end belongs to that side's strip.
  const double low = height(run.first), high = height(run.last);
  std::size_t rise = run.first, fall = run.last;
  while (low < high && rise < top && height(rise) < high) ++rise;
  while (high < low && fall > top && height(fall) < low) --fall;

  left_.assign(1, primary_[column]);
  for (std::uint32_t v = column_first_[column]; v < column_first_[column + 1]; ++v) left_.push_back(v);
  right_ = left_;
  for (std::size_t i = run.first; i < rise; ++i) left_.push_back(rest_[i]);
  for (std::size_t i = run.last; i > fall; --i) right_.push_back(rest_[i]);
  const std::uint32_t joint = right_.size() > left_.size() ? right_.back() : left_.back();
  cap_left_.assign(1, joint);
  cap_right_.assign(1, joint);
  for (std::size_t i = rise; i <= top; ++i) cap_left_.push_back(rest_[i]);
  for (std::size_t i = fall + 1; i-- > top;) cap_right_.push_back(rest_[i]);
  left_.push_back(rest_[run.last]);
  right_.push_back(rest_[run.first]);
}

GridSweep::Weights GridSweep::weights(const Node& at) const {
  const double x = at.sweep - origin_.sweep, y = at.side - origin_.side;
  const double b = (x * to_c_.side - to_c_.sweep * y) / twice_area_;
  const double c = (to_b_.sweep * y - x * to_b_.side) / twice_area_;
  return {1 - b - c, b, c};
}

GridSweep::Steps GridSweep::steps() const {
  return {to_c_.side / twice_area_, -to_c_.sweep / twice_area_, -to_b_.side / twice_area_,
          to_b_.sweep / twice_area_};
}

}  // namespace recede::detail
