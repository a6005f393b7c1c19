#include <recede/geometry/detail/bound_search.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <cmath>

namespace recede {
namespace {

using detail::Interval;
using detail::Surface;

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

struct SampledSide {
  OneSidedDistance distance;
  std::size_t evaluated = 0;
  std::vector<Index> nearest;  ///< for each position of the source surface, the nearest triangle of the other
};

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

void check(const PolygonSoup& soup, const std::string& which) {
  if (soup.n_faces() == 0) {
    throw InputError("the distance needs two surfaces, but the " + which + " one has no faces");
  }
  validate(soup, which + " surface");
}

void check(const DistanceOptions& options) {
  if (options.bound_tolerance && !(*options.bound_tolerance > 0 && *options.bound_tolerance < 1)) {
    throw OptionError("bound_tolerance must lie between 0 and 1");
  }
}

/// Where both surfaces are measured: their box's centre goes to the origin and its larger extent to about 1.
/// Squares of lengths then neither overflow nor underflow, and what is far from the origin loses no digits.
/// Scaling is by a power of two and rounds nothing.
struct Frame {
  explicit Frame(const Box3& box) {
    if (box.isEmpty()) return;
    // Halves first: sums and differences of the largest numbers overflow.
    center = 0.5 * box.min() + 0.5 * box.max();
    const double largest = (0.5 * box.max() - 0.5 * box.min()).maxCoeff();
    if (largest > 0) exponent = -std::ilogb(largest);
  }

  double inside(double length) const { return std::ldexp(length, exponent); }
  double outside(double length) const { return std::ldexp(length, -exponent); }
  Vec3 outside(const Vec3& p) const { return center + Vec3(outside(p.x()), outside(p.y()), outside(p.z())); }
  Surface inside(const PolygonSoup& soup) const {
    PolygonSoup moved;
    moved.face_offsets = soup.face_offsets;
    moved.corner_vertices = soup.corner_vertices;
    moved.positions.reserve(soup.positions.size());
    for (const Vec3& p : soup.positions) {
      const Vec3 d = p - center;
      moved.positions.emplace_back(inside(d.x()), inside(d.y()), inside(d.z()));
    }
    return Surface(std::move(moved));
  }

  Vec3 center = Vec3::Zero();
  int exponent = 0;
};

void leave(const Frame& frame, OneSidedDistance& side) {
  side.max = frame.outside(side.max);
  side.rms = frame.outside(side.rms);
  side.mean = frame.outside(side.mean);
  side.at = frame.outside(side.at);
}

MeshDistance measure_inside(const Surface& first, const Surface& second, const DistanceOptions& options,
                            double floor, Progress* progress) {
  MeshDistance distance;
  const SampledSide forward = sampled_distance(first, second, options.samples);
  report_progress(progress, "measure", 0.5);
  const SampledSide backward = sampled_distance(second, first, options.samples);
  distance.forward = forward.distance;
  distance.backward = backward.distance;
  distance.samples = forward.evaluated + backward.evaluated;
  distance.max = distance.max_lower = std::max(distance.forward.max, distance.backward.max);
  const double area = first.area + second.area;
  if (area > 0) {
    distance.rms = std::sqrt((first.area * distance.forward.rms * distance.forward.rms +
                              second.area * distance.backward.rms * distance.backward.rms) /
                             area);
    distance.samples_per_unit_area = 2 * static_cast<double>(options.samples) / area;
  }
  if (!options.bound_tolerance) return distance;
  report_progress(progress, "bound", 0);
  const double limit = options.limit.value_or(0);
  // With a limit, each triangle by itself is to be told apart from it.
  const detail::BoundGoal goal{options.limit ? 0 : distance.max, *options.bound_tolerance,
                               std::max(floor, limit)};
  double bound = distance.max;
  const auto take = [&](const std::vector<Interval>& intervals) {
    for (const Interval& interval : intervals) {
      distance.max_lower = std::max(distance.max_lower, interval.lower);
      bound = std::max(bound, interval.upper);
      if (options.limit && interval.upper > limit) distance.beyond.push_back(interval.at);
    }
  };
  take(certified_intervals(first, second, forward.nearest, goal));
  report_progress(progress, "bound", 0.5);
  take(certified_intervals(second, first, backward.nearest, goal));
  distance.max_bound = std::max(bound, distance.max_lower);
  report_progress(progress, "bound", 1);
  return distance;
}

MeshDistance measure_in_frame(const Frame& frame, const Surface& first, const Surface& second,
                              double diagonal, double floor, DistanceOptions options, Progress* progress) {
  if (options.limit) options.limit = frame.inside(*options.limit);
  MeshDistance distance = measure_inside(first, second, options, frame.inside(floor), progress);
  for (Vec3& place : distance.beyond) place = frame.outside(place);
  leave(frame, distance.forward);
  leave(frame, distance.backward);
  distance.max = frame.outside(distance.max);
  distance.rms = frame.outside(distance.rms);
  if (distance.max_bound) distance.max_bound = frame.outside(*distance.max_bound);
  distance.max_lower = frame.outside(distance.max_lower);
  distance.diagonal = diagonal;
  distance.samples_per_unit_area = std::ldexp(distance.samples_per_unit_area, 2 * frame.exponent);
  return distance;
}

/// The length of a box's diagonal, also where its square would overflow.
double diagonal_of(const Box3& box) {
  if (box.isEmpty()) return 0;
  const Vec3 half = 0.5 * box.max() - 0.5 * box.min();
  const double largest = half.maxCoeff();
  return largest > 0 ? 2 * largest * (half / largest).norm() : 0;
}

}  // namespace

struct DistanceMeter::Measured {
  explicit Measured(const PolygonSoup& soup)
      : box(bounding_box(soup)), frame(box), surface(frame.inside(soup)) {}
  Box3 box;
  Frame frame;
  Surface surface;
};

DistanceMeter::DistanceMeter(const PolygonSoup& reference) {
  check(reference, "first");
  measured_ = std::make_unique<Measured>(reference);
}
DistanceMeter::~DistanceMeter() = default;

MeshDistance DistanceMeter::to(const PolygonSoup& other, const DistanceOptions& options,
                               Progress* progress) const {
  check(other, "second");
  check(options);
  report_progress(progress, "measure", 0);
  const Frame& frame = measured_->frame;
  Box3 both = measured_->box;
  both.extend(bounding_box(other));
  return measure_in_frame(frame, measured_->surface, frame.inside(other), diagonal_of(measured_->box),
                          options.relative_floor * diagonal_of(both), options, progress);
}

MeshDistance measure_distance(const PolygonSoup& a, const PolygonSoup& b, const DistanceOptions& options,
                              Progress* progress) {
  check(a, "first");
  check(b, "second");
  check(options);
  report_progress(progress, "measure", 0);
  Box3 both = bounding_box(a);
  both.extend(bounding_box(b));
  const Frame frame(both);
  return measure_in_frame(frame, frame.inside(a), frame.inside(b), diagonal_of(bounding_box(a)),
                          options.relative_floor * diagonal_of(both), options, progress);
}

MeshDistance measure_distance(const PolygonMesh& a, const PolygonMesh& b, const DistanceOptions& options,
                              Progress* progress) {
  return measure_distance(to_soup(a), to_soup(b), options, progress);
}

}  // namespace recede
