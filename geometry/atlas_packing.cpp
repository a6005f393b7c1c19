#include <recede/geometry/atlas_packing.h>
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace recede {
namespace {

constexpr int k_largest_resolution = 65536;

/// The upper outline of what lies in a rectangle, as steps from left to right.
class Skyline {
 public:
  Skyline(int width, int height) : width_(width), height_(height), steps_{{0, 0}} {}

  struct Spot {
    int x = 0, y = 0;
    std::size_t step = 0;
  };

  /// The lowest place for a rectangle, the leftmost of those; none when it sticks out.
  std::optional<Spot> lowest(int width, int height) const {
    std::optional<Spot> best;
    for (std::size_t i = 0; i < steps_.size() && steps_[i].x + width <= width_; ++i) {
      int y = 0;
      for (std::size_t j = i; j < steps_.size() && steps_[j].x < steps_[i].x + width; ++j) {
        y = std::max(y, steps_[j].y);
      }
      if (y + height <= height_ && (!best || y < best->y)) best = Spot{steps_[i].x, y, i};
    }
    return best;
  }

  /// Puts a rectangle where its upper side is lowest, turned or not; none when there is no room.
  std::optional<PackedRectangles::Place> take(int width, int height) {
    const auto along = lowest(width, height), turned = lowest(height, width);
    if (!along && !turned) return std::nullopt;
    const bool turn = !along || (turned && turned->y + width < along->y + height);
    const Spot& spot = turn ? *turned : *along;
    place(spot, turn ? height : width, turn ? width : height);
    return PackedRectangles::Place{spot.x, spot.y, turn};
  }

  /// Height of the highest step.
  int top() const {
    int y = 0;
    for (const Step& step : steps_) y = std::max(y, step.y);
    return y;
  }

 private:
  void place(const Spot& spot, int width, int height) {
    const int right = spot.x + width;
    std::size_t end = spot.step;
    int last_y = 0;
    while (end < steps_.size() && steps_[end].x < right) last_y = steps_[end++].y;
    const bool covered = right == (end < steps_.size() ? steps_[end].x : width_);
    const auto at = steps_.begin() + static_cast<std::ptrdiff_t>(spot.step);
    const auto next = steps_.erase(at, steps_.begin() + static_cast<std::ptrdiff_t>(end));
    const auto rest = covered ? next : steps_.insert(next, {right, last_y});
    steps_.insert(rest, {spot.x, spot.y + height});
  }

  struct Step {
    int x, y;  // the step reaches to the next one's x
  };
  int width_, height_;
  std::vector<Step> steps_;
};

class Packer {
 public:
  Packer(std::span<const Vec2> sides, int gutter) : sides_(sides), gutter_(gutter), order_(sides.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
      return sides_[a].maxCoeff() > sides_[b].maxCoeff();
    });
  }

  /// False when they don't fit at this scale.
  bool pack(int resolution, double scale, std::vector<PackedRectangles::Place>& places) const {
    Skyline skyline(resolution, resolution);
    places.resize(sides_.size());
    for (const std::size_t r : order_) {
      const Vec2 texels = scale * sides_[r];
      if (texels.maxCoeff() > resolution) return false;
      const int width = static_cast<int>(std::ceil(texels.x())) + gutter_;
      const int height = static_cast<int>(std::ceil(texels.y())) + gutter_;
      const auto place = skyline.take(width, height);
      if (!place) return false;
      places[r] = {place->x + gutter_ / 2, place->y + gutter_ / 2, place->turned};
    }
    return true;
  }

 private:
  std::span<const Vec2> sides_;
  int gutter_;
  std::vector<std::size_t> order_;
};

double sum_of_areas(std::span<const Vec2> sides) {
  double sum = 0;
  for (const Vec2& side : sides) {
    if (!side.allFinite() || !(side.minCoeff() > 0)) {
      throw InputError("rectangles to pack must have positive sides");
    }
    sum += side.prod();
  }
  return sum;
}

std::vector<Vec2> convex_hull(std::span<const Vec2> points) {
  std::vector<Vec2> sorted(points.begin(), points.end()), hull;
  std::sort(sorted.begin(), sorted.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  for (int half = 0; half < 2; ++half) {  // the lower chain, then the upper one (Andrew 1979)
    const std::size_t first = hull.size();
    for (const Vec2& p : sorted) {
      while (hull.size() >= first + 2 && detail::orientation(hull[hull.size() - 2], hull.back(), p) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(sorted.begin(), sorted.end());
  }
  return hull;
}

}  // namespace

PackedRectangles pack_rectangles(std::span<const Vec2> sides, const PackingOptions& options) {
  if (options.resolution < 1 || options.resolution > k_largest_resolution) {
    throw OptionError(fmt::format("an atlas of {} texels", options.resolution));
  }
  if (options.gutter < 0 || options.gutter > k_largest_resolution) {
    throw OptionError(fmt::format("a gutter of {} texels", options.gutter));
  }
  PackedRectangles result;
  result.resolution = options.resolution;
  if (sides.empty()) return result;
  const double area = sum_of_areas(sides);
  const Packer packer(sides, options.gutter);
  std::vector<PackedRectangles::Place> places;
  double longest = 0;
  for (const Vec2& side : sides) longest = std::max(longest, side.maxCoeff());
  // Below this scale every rectangle takes one texel and its gutter, and less helps nothing.
  while (!packer.pack(result.resolution, 1 / longest, result.places)) {
    if (2 * result.resolution > k_largest_resolution) {
      throw InputError(fmt::format("{} rectangles don't fit {} x {} texels", sides.size(), result.resolution,
                                   result.resolution));
    }
    result.resolution *= 2;
  }
  double fits = 1 / longest;
  double too_large = std::min(result.resolution / std::sqrt(area), (result.resolution + 1.0) / longest);
  constexpr int k_bisections = 16;
  for (int i = 0; i < k_bisections && too_large > fits * 1.001; ++i) {
    const double scale = i < 4 ? fits + 0.7 * (too_large - fits) : 0.5 * (fits + too_large);
    if (packer.pack(result.resolution, scale, places)) {
      fits = scale;
      result.places.swap(places);
    } else {
      too_large = scale;
    }
  }
  result.texels_per_unit = fits;
  result.occupancy = area * fits * fits / result.resolution / result.resolution;
  return result;
}

PackedTexels pack_texels(std::span<const Eigen::Vector2i> sizes, int gutter) {
  if (gutter < 0 || gutter > k_largest_resolution)
    throw OptionError(fmt::format("a gutter of {} texels", gutter));
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sizes[a].maxCoeff() > sizes[b].maxCoeff(); });
  double area = 0;
  int longest = 1;
  for (const Eigen::Vector2i& size : sizes) {
    if (size.minCoeff() < 1) throw InputError("rectangles to pack must have positive sides");
    if (size.maxCoeff() > k_largest_resolution)
      throw InputError(fmt::format("a rectangle of {} x {} texels is larger than {}", size.x(), size.y(),
                                   k_largest_resolution));
    area += (size.x() + gutter) * static_cast<double>(size.y() + gutter);
    longest = std::max(longest, size.maxCoeff());
  }
  const auto up_to_four = [](double x) { return 4 * static_cast<int>(std::ceil(x / 4)); };
  PackedTexels best;
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  constexpr int k_widths = 24;
  for (int i = 0; i < k_widths && !sizes.empty(); ++i) {
    const double ratio = std::pow(4.0, static_cast<double>(i) / (k_widths - 1) - 0.5);  // of width to height
    const int width = up_to_four(std::max<double>(std::sqrt(ratio * area), longest + gutter));
    if (width > k_largest_resolution || area / width > k_largest_resolution) continue;
    Skyline skyline(width, std::numeric_limits<int>::max() / 2);
    std::vector<PackedRectangles::Place> places(sizes.size());
    for (const std::size_t r : order) places[r] = *skyline.take(sizes[r].x() + gutter, sizes[r].y() + gutter);
    const int height = up_to_four(skyline.top());
    const std::int64_t texels = std::int64_t{width} * height;
    if (texels >= least || height > k_largest_resolution) continue;
    least = texels;
    best = {std::move(places), width, height};
  }
  if (best.width == 0 && !sizes.empty())
    throw InputError(fmt::format("{} rectangles don't fit {} x {} texels", sizes.size(), k_largest_resolution,
                                 k_largest_resolution));
  return best;
}

BoundingRectangle smallest_rectangle(std::span<const Vec2> points) {
  const std::vector<Vec2> hull = convex_hull(points);
  // A round hull of very many sides: some of them serve as well.
  constexpr std::size_t k_most_directions = 720;
  const std::size_t stride = 1 + hull.size() / k_most_directions;
  BoundingRectangle best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::max<std::size_t>(hull.size(), 1); i += stride) {
    const Vec2 side = hull.size() < 2 ? Vec2(1, 0) : Vec2(hull[(i + 1) % hull.size()] - hull[i]);
    if (!(side.norm() > 0)) continue;
    const Vec2 x = side.normalized(), y(-x.y(), x.x());
    Eigen::AlignedBox2d box;
    for (const Vec2& p : hull) box.extend(Vec2(p.dot(x), p.dot(y)));
    if (hull.empty()) box.extend(Vec2(points[0].dot(x), points[0].dot(y)));
    const double area = box.sizes().prod();
    if (!(area < least)) continue;
    least = area;
    best = {box.min().x() * x + box.min().y() * y, x, box.sizes()};
  }
  return best;
}

}  // namespace recede
