#include <recede/geometry/height_field.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

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
  ShearedLine::Range range;  ///< its end shrinks to the nearest hit so far
  double padding = 0;
  bool any = false;  ///< one hit is enough
  bool found = false;
  Node cell = {};
  PatchHit hit = {};

  ShearedLine::Range clip(Eigen::Index axis, double lower, double upper, const ShearedLine::Range& to) const {
    return ray.line().clip_to_slab(axis, lower - padding, upper + padding, to);
  }
};

void HeightField::test_cell(const Node& node, Search& search) const {
  const auto hit = search.ray.nearest_hit(cell(node.x, node.y), search.range.enter, search.range.leave);
  if (!hit || (search.found && hit->t == search.range.leave)) return;
  search.found = true;
  search.cell = node;
  search.hit = *hit;
  search.range.leave = hit->t;
}

/// Puts those children of a node that the ray passes in `children`, the farthest first. Returns how many.
std::size_t HeightField::open(const Node& node, const Search& search, Node* children) const {
  const int level = node.level - 1;
  ShearedLine::Range across[2], down[2];
  for (int half = 0; half < 2; ++half) {
    const auto lines = [&](int at, int cells) {
      const int first = std::min((2 * at + half) << level, cells);
      const int last = std::min((2 * at + half + 1) << level, cells);
      return std::pair(static_cast<std::size_t>(first), static_cast<std::size_t>(last));
    };
    const auto [left, right] = lines(node.x, bounds_.columns(0));
    const auto [top, bottom] = lines(node.y, bounds_.rows(0));
    constexpr ShearedLine::Range k_none{1, 0};
    across[half] = left < right ? search.clip(0, u_[left], u_[right], search.range) : k_none;
    down[half] = top < bottom ? search.clip(1, v_[bottom], v_[top], search.range) : k_none;
  }
  std::size_t count = 0;
  for (int child = 0; child < 4; ++child) {
    const ShearedLine::Range &a = across[child % 2], &b = down[child / 2];
    const ShearedLine::Range above{std::max(a.enter, b.enter), std::min(a.leave, b.leave)};
    if (above.empty()) continue;
    Node at{level, 2 * node.x + child % 2, 2 * node.y + child / 2, 0};
    const HeightRange heights = bounds_.node(level, at.x, at.y);
    const ShearedLine::Range inside = search.clip(2, heights.min, heights.max, above);
    if (inside.empty()) continue;
    at.enter = inside.enter;
    std::size_t place = count++;
    for (; place > 0 && children[place - 1].enter < at.enter; --place) children[place] = children[place - 1];
    children[place] = at;
  }
  return count;
}

/// Visits the nodes of the pyramid that the ray passes, nearest first.
void HeightField::search(Search& search) const {
  const ShearedLine& line = search.ray.line();
  if (!line.origin().allFinite() || !line.direction().allFinite()) return;
  // Three siblings wait on each level. The root's own bounds aren't tested: its children's are.
  std::array<Node, 3 * 32 + 1> stack;
  std::size_t top = 0;
  stack[top++] = {bounds_.levels() - 1, 0, 0, search.range.enter};
  while (top > 0) {
    const Node node = stack[--top];
    if (node.enter > search.range.leave) continue;
    if (node.level > 0) {
      top += open(node, search, stack.data() + top);
      continue;
    }
    test_cell(node, search);
    if (search.any && search.found) return;
  }
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
  search(found);
  if (!found.found) return {};
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
  Search found{PatchRay(origin, direction), {t_min, t_max}, padding_for(bounds_, origin), true};
  search(found);
  return found.found;
}

}  // namespace recede
