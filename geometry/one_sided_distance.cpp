#include <recede/geometry/detail/one_sided_distance.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace recede::detail {
namespace {

/// `count` points spread evenly by area: point i stands at share (i + 1/2) / count of the running area, and
/// its place inside the triangle comes from Roberts' R2 sequence, so that points of one triangle fill it
/// evenly.
std::vector<Vec3> sample_points(const Surface& surface, std::size_t count) {
  constexpr double k_alpha1 = 0.7548776662466927, k_alpha2 = 0.5698402909980532;
  std::vector<Vec3> points;
  if (!(surface.area > 0)) return points;
  points.reserve(count);
  std::size_t t = 0;
  double before = 0;  // area of the triangles before t
  for (std::size_t i = 0; i < count; ++i) {
    const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * surface.area;
    while (t + 1 < surface.n_triangles() && before + surface.areas[t] < at) before += surface.areas[t++];
    double u = std::fmod(0.5 + k_alpha1 * static_cast<double>(i), 1.0);
    double v = std::fmod(0.5 + k_alpha2 * static_cast<double>(i), 1.0);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Triangle corners = surface.triangle(t);
    points.push_back(corners.a + u * (corners.b - corners.a) + v * (corners.c - corners.a));
  }
  return points;
}

/// Squared distance of each point to the surface. Neighbouring points are asked in one block, so that the
/// answer to one is a good guess for the next. `nearest`, when given, receives the nearest triangles.
std::vector<double> squared_distances(const std::vector<Vec3>& points, const ClosestPointTree& tree,
                                      std::vector<Index>* nearest = nullptr) {
  std::vector<double> result(points.size());
  if (nearest) nearest->resize(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 1024), [&](const auto& range) {
    Index hint = k_no_index;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const auto hit = tree.closest(points[i], hint);
      result[i] = hit.squared_distance;
      hint = hit.triangle;
      if (nearest) (*nearest)[i] = hit.triangle;
    }
  });
  return result;
}

void keep_largest(const std::vector<Vec3>& points, const std::vector<double>& squared,
                  OneSidedDistance& side) {
  double largest = side.max * side.max;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (squared[i] <= largest) continue;
    largest = squared[i];
    side.max = std::sqrt(largest);
    side.at = points[i];
  }
}

}  // namespace

SampledSide sampled_distance(const Surface& from, const Surface& to, std::size_t samples) {
  SampledSide result;
  OneSidedDistance& side = result.distance;
  const std::vector<Vec3> points = sample_points(from, samples);
  const std::vector<double> squared = squared_distances(points, to.tree);
  double sum = 0, sum_of_squares = 0;
  for (const double value : squared) {
    sum += std::sqrt(value);
    sum_of_squares += value;
  }
  if (!points.empty()) {
    side.mean = sum / static_cast<double>(points.size());
    side.rms = std::sqrt(sum_of_squares / static_cast<double>(points.size()));
  }
  keep_largest(points, squared, side);
  keep_largest(from.positions, squared_distances(from.positions, to.tree, &result.nearest), side);
  result.evaluated = points.size() + from.positions.size();
  return result;
}

}  // namespace recede::detail
