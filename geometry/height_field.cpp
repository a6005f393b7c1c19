#include <recede/geometry/height_field.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {
namespace {

/// The lines between cells along one axis: the borders of the square and the middles of texels.
std::vector<double> lines_of(int texels) {
  std::vector<double> lines{0};
  for (int k = 0; k < texels; ++k) lines.push_back((k + 0.5) / texels);
  lines.push_back(1);
  return lines;
}

}  // namespace

HeightField::HeightField(const DisplacementMap& map)
    : map_(&map), bounds_(map), u_(lines_of(map.columns())), v_(lines_of(map.rows())) {
  for (double& v : v_) v = 1 - v;  // row 0 is on top
}

/// Where the lines x and y cross: the height of a texel; on the border that of the mean of two or four.
double HeightField::height_at_node(int x, int y) const {
  const int columns = map_->columns(), rows = map_->rows();
  if (x > 0 && y > 0 && x <= columns && y <= rows) return map_->texel(x - 1, y - 1);
  const int left = map_->column(x - 1), upper = map_->row(y - 1);
  const int right = x == 0 ? 0 : x > columns ? columns - 1 : left;
  const int lower = y == 0 ? 0 : y > rows ? rows - 1 : upper;
  // Four samples of at most 24 bits: their mean is exact but for floats of very different size.
  const double sum = (map_->sample(left, upper) + map_->sample(right, upper)) +
                     (map_->sample(left, lower) + map_->sample(right, lower));
  return map_->height_of(sum / 4);
}

BilinearPatch HeightField::cell(int x, int y) const {
  const auto node = [&](int i, int j) {
    return Vec3(u_[static_cast<std::size_t>(i)], v_[static_cast<std::size_t>(j)], height_at_node(i, j));
  };
  return {node(x, y), node(x + 1, y), node(x, y + 1), node(x + 1, y + 1)};
}

struct HeightField::Node {
  int level = 0, x = 0, y = 0;
  double enter = 0;
};

struct HeightField::Search {
  PatchRay ray;
  ShearedLine::Range range;
  double padding = 0;
  Node cell = {};
  PatchHit hit = {};
};

/// Visits the nodes of the pyramid that the ray passes, nearest first. `search.range.leave` shrinks to the
/// nearest hit so far.
template <bool any>
bool HeightField::search(Search& search) const {
  const ShearedLine& line = search.ray.line();
  const auto clip = [&](Node& node) {
    const HeightRange heights = bounds_.node(node.level, node.x, node.y);
    const auto last = [&](int at, int count) {
      return static_cast<std::size_t>(std::min((at + 1) << node.level, count));
    };
    const Vec3 lower(u_[static_cast<std::size_t>(node.x << node.level)], v_[last(node.y, bounds_.rows(0))],
                     heights.min);
    const Vec3 upper(u_[last(node.x, bounds_.columns(0))], v_[static_cast<std::size_t>(node.y << node.level)],
                     heights.max);
    const ShearedLine::Range inside =
        line.clip_to_box(lower.array() - search.padding, upper.array() + search.padding, search.range);
    node.enter = inside.enter;
    return !inside.empty();
  };

  bool found = false;
  std::array<Node, 3 * 32 + 1> stack;  // three siblings wait on each level
  std::size_t top = 0;
  Node root{bounds_.levels() - 1, 0, 0, 0};
  if (clip(root)) stack[top++] = root;
  while (top > 0) {
    const Node node = stack[--top];
    if (node.enter > search.range.leave) continue;
    if (node.level == 0) {
      const auto hit = search.ray.nearest_hit(cell(node.x, node.y), search.range.enter, search.range.leave);
      if (!hit || (found && hit->t == search.range.leave)) continue;
      if constexpr (any) return true;
      found = true;
      search.cell = node;
      search.hit = *hit;
      search.range.leave = hit->t;
      continue;
    }
    // The farthest child comes first on the stack.
    const std::size_t first = top;
    for (int child = 0; child < 4; ++child) {
      Node at{node.level - 1, 2 * node.x + child % 2, 2 * node.y + child / 2, 0};
      if (at.x >= bounds_.columns(at.level) || at.y >= bounds_.rows(at.level) || !clip(at)) continue;
      std::size_t place = top++;
      for (; place > first && stack[place - 1].enter < at.enter; --place) stack[place] = stack[place - 1];
      stack[place] = at;
    }
  }
  return found;
}

namespace {

/// How much larger boxes are made: a patch meets rays that pass by it at the distance of the rounding of its
/// corners as the ray sees them, five steps of 1.1e-16 of their distance. Three times that.
double padding_for(const HeightBounds& bounds, const Vec3& origin) {
  const HeightRange all = bounds.node(bounds.levels() - 1, 0, 0);
  const double reach = origin.cwiseAbs().maxCoeff() + std::max({1.0, std::abs(all.min), std::abs(all.max)});
  return 8 * std::numeric_limits<double>::epsilon() * reach;
}

}  // namespace

std::optional<HeightField::Hit> HeightField::first_hit(const Vec3& origin, const Vec3& direction,
                                                       double t_min, double t_max) const {
  Search found{PatchRay(origin, direction), {t_min, t_max}, padding_for(bounds_, origin)};
  if (!search<false>(found)) return {};
  const BilinearPatch patch = cell(found.cell.x, found.cell.y);
  Hit hit;
  hit.t = found.hit.t;
  hit.uv = patch.point(found.hit.u, found.hit.v).head<2>();
  hit.normal = -patch.normal(found.hit.u, found.hit.v);  // v of the patch runs downwards in the map
  hit.cell_x = found.cell.x;
  hit.cell_y = found.cell.y;
  return hit;
}

bool HeightField::is_hit(const Vec3& origin, const Vec3& direction, double t_min, double t_max) const {
  Search found{PatchRay(origin, direction), {t_min, t_max}, padding_for(bounds_, origin)};
  return search<true>(found);
}

}  // namespace recede
