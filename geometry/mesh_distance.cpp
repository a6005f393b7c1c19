#include <recede/geometry/detail/one_sided_distance.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>

#include <cmath>

namespace recede {
namespace {

using detail::Frame;
using detail::Interval;
using detail::SampledSide;
using detail::Surface;

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
