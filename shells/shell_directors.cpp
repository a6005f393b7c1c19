#include <recede/geometry/closest_point.h>
#include <recede/shells/detail/front_direction.h>
#include <recede/shells/detail/lp_field.h>
#include <recede/shells/detail/near_order.h>
#include <recede/shells/detail/shell_directors.h>
#include <recede/shells/detail/shell_pieces.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <optional>

namespace recede::detail {

namespace {

// The field begins on the surface with no direction: the first step goes along the normal.
constexpr double k_first_step = 0.02;  // of the thickness
// Looks at the field, where directions jump to and fro: so many, or more for each of many steps. Few paths
// need more than 30.
constexpr std::size_t k_most_evaluations = 500, k_most_of_step = 4;
constexpr std::size_t k_neighbours = 64;  // followed together
constexpr double k_stuck = 1e-4;          // of a field as fast as that of a plane

// Of `ShellOptions::step`.
constexpr double k_largest_turn = 0.8;    // radians
constexpr double k_shortest_step = 1e-5;  // of the thickness, for the longest of a path
// Smaller steps may turn and be off by as much as this one. The field isn't as smooth as they would ask for:
// no step was short enough, and paths ended on their way.
constexpr double k_most_precise = 0.01;
constexpr double k_free = 0.97;
// Of its third power: of the thickness, what a step may be off, 0.004 of it for steps of a quarter. Twelve
// times less is what doubled steps of the second order still keep, and half of that again to spare.
constexpr double k_largest_error = 0.256, k_even = 1.0 / 12;

// What leads the way.
struct Flow {
  Vec3 velocity = Vec3::Zero();  // at most 1 long, unless of averages
  double distance = 0;
};

class FlowField {
 public:
  FlowField(const ShellSurface& surface, std::span<const double> thicknesses, const ShellOptions& options)
      : is_clamped_(options.field.form == LpForm::calibrated) {
    if (options.method == DirectorMethod::exact_distance) {
      exact_.emplace(std::vector<Vec3>(surface.positions.begin(), surface.positions.end()),
                     std::vector<Index>(surface.triangles.begin(), surface.triangles.end()));
      return;
    }
    std::vector<double> reaches;
    for (const double thickness : thicknesses) reaches.push_back(options.border_extension * thickness);
    LpDistanceOptions field = options.field;
    field.support = 2 * *std::max_element(thicknesses.begin(), thicknesses.end());
    averaged_.emplace(with_extended_borders(surface, reaches), field);
  }

  bool is_smooth() const { return !exact_ && is_clamped_; }

  // At points near to each other.
  void at_each(std::span<const Vec3> points, std::span<Flow> flows) const {
    if (exact_) {
      for (std::size_t i = 0; i < points.size(); ++i)
        flows[i] = {extended_gradient(*exact_, points[i]),
                    std::sqrt(exact_->closest(points[i]).squared_distance)};
      return;
    }
    std::array<LpValue, k_neighbours> values;
    averaged_->at_each(points, std::span(values).first(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const LpValue& value = values[i];
      const double length = value.gradient.norm();
      flows[i] = {is_clamped_ && length > 1 ? Vec3(value.gradient / length) : value.gradient, value.distance};
    }
  }

 private:
  std::optional<LpField> averaged_;
  std::optional<ClosestPointTree> exact_;
  bool is_clamped_;
};

// The way of one director. The source's steps are explicit Euler's (section 4.5), halved until they turn
// little. Here a step of Adams and Bashforth is corrected by the trapezoidal rule with the flow where it led,
// which the next step begins with as well: the second order for one look at the field a step, and how far the
// correction went says how far off it is. Besides the source's rule, no step is longer than its share of the
// thickness, or decreases the distance.
//
// Steps are halves of halves of the longest and end at multiples of themselves. So neighbours, which see much
// the same field, take the same steps and are off by the same: what differs between them would invert prisms.
class DirectorPath {
 public:
  DirectorPath() = default;
  // `is_smooth`: nothing that is near goes unnoticed in the field's speed.
  DirectorPath(const Vec3& start, const Vec3& normal, double thickness, double step, bool is_smooth)
      : at_(start),
        asked_(start + k_first_step * thickness * normal),
        thickness_(thickness),
        step_(std::max(step, k_most_precise)),
        is_smooth_(is_smooth) {
    const double n = std::ceil((1 - k_first_step) / std::max(step, k_shortest_step));
    longest_ = (1 - k_first_step) / n * thickness;
    n_ticks_ = static_cast<int>(n) * k_longest;
    most_evaluations_ = std::max(k_most_evaluations, k_most_of_step * static_cast<std::size_t>(n));
  }

  bool is_done() const { return is_done_; }
  const Vec3& end() const { return at_; }

  // Where the flow is to be known next.
  const Vec3& asked() const { return asked_; }

  void answer(const Flow& flow) {
    ++evaluations_;
    if (asks_here_) {
      at_ = asked_;
      flow_ = flow;
      asks_here_ = false;
      n_rejected_ = 0;
    } else if (const Vec3 corrected = at_ + 0.5 * length_ * (flow_.velocity + flow.velocity);
               is_accepted(flow, corrected)) {
      advance(flow, corrected);
    } else if (stride_ > 1) {
      stride_ /= 2;
      // What the flow was where the last step led doesn't get nearer to the one here with shorter steps.
      asks_here_ = ++n_rejected_ == k_patience;
    } else {
      is_done_ = true;
    }
    is_done_ = is_done_ || tick_ == n_ticks_ || !(flow_.velocity.norm() > k_stuck) ||
               evaluations_ >= most_evaluations_;
    if (is_done_) return;
    if (asks_here_) {
      asked_ = at_;
    } else {
      predict();
    }
  }

 private:
  static constexpr int k_longest = 1 << 12, k_patience = 2;

  void predict() {
    for (;; stride_ /= 2) {
      length_ = longest_ * stride_ / k_longest;
      Vec3 velocity = flow_.velocity;
      if (length_before_ > 0) velocity += length_ / (2 * length_before_) * (velocity - before_);
      // No faster than the flow, which is a distance's where it's clamped.
      const double speed = velocity.norm(), fastest = std::max(1.0, flow_.velocity.norm());
      if (speed > fastest) velocity *= fastest / speed;
      asked_ = at_ + length_ * velocity;
      // A unit vector may be a rounding longer.
      if (stride_ == 1 || length_ * fastest <= (1 + 1e-9) * longest_) return;
    }
  }

  bool is_accepted(const Flow& flow, const Vec3& corrected) {
    turn_ = angle_between(flow_.velocity, flow.velocity);
    const double correction = (corrected - asked_).norm() / thickness_;
    // The two are off by 2 + 3 r and -1 parts of the same, r the ratio of the step before to this one.
    error_ = length_before_ > 0 ? correction / (3 * (1 + length_before_ / length_)) : correction;
    return flow.distance >= flow_.distance && turn_ <= k_largest_turn * step_ &&
           error_ <= k_largest_error * step_ * step_ * step_;
  }

  void advance(const Flow& flow, const Vec3& corrected) {
    before_ = flow_.velocity;
    length_before_ = length_;
    at_ = corrected;
    flow_ = flow;
    tick_ += stride_;
    n_rejected_ = 0;
    const bool is_even =
        2 * turn_ <= k_largest_turn * step_ && error_ <= k_even * k_largest_error * step_ * step_ * step_;
    if (is_even && stride_ < k_longest && tick_ % (2 * stride_) == 0) stride_ *= 2;
    // Of two parallel planes the speed is the difference of their distances over the sum: at 0.97 the other
    // one is 66 times as far away, out of reach of a last step. So none has to look at what it can't meet.
    if (is_smooth_ && is_even && tick_ + stride_ == n_ticks_ && flow_.velocity.norm() >= k_free) {
      predict();
      at_ = asked_;
      tick_ = n_ticks_;
    }
  }

  Vec3 at_ = Vec3::Zero(), asked_ = Vec3::Zero(), before_ = Vec3::Zero();
  Flow flow_{};
  double thickness_ = 0, longest_ = 0;
  double step_ = 0;  // that its precision is for
  double length_ = 0, length_before_ = 0, turn_ = 0, error_ = 0;
  int stride_ = k_longest / 2, tick_ = 0, n_ticks_ = 0;  // a step, and time, in shares of the longest step
  std::size_t evaluations_ = 0, most_evaluations_ = 0;
  int n_rejected_ = 0;
  bool is_smooth_ = false, asks_here_ = true, is_done_ = false;
};

// Follows the paths of some of all `ends` side by side, `path_of` each; returns the number of evaluations.
// Those that take the same steps stay near to each other.
template <typename PathOf>
std::size_t trace_neighbours(const FlowField& field, std::span<const std::size_t> which, PathOf&& path_of,
                             std::vector<Vec3>& ends) {
  std::array<DirectorPath, k_neighbours> paths;
  std::array<std::size_t, k_neighbours> owners{};
  std::array<Vec3, k_neighbours> asked;
  std::array<Flow, k_neighbours> flows;
  std::size_t n = which.size(), evaluations = 0;
  for (std::size_t i = 0; i < n; ++i) {
    owners[i] = which[i];
    paths[i] = path_of(which[i]);
  }
  while (n > 0) {
    for (std::size_t i = 0; i < n; ++i) asked[i] = paths[i].asked();
    field.at_each(std::span(asked).first(n), std::span(flows).first(n));
    evaluations += n;
    std::size_t left = 0;
    for (std::size_t i = 0; i < n; ++i) {
      paths[i].answer(flows[i]);
      if (paths[i].is_done()) {
        ends[owners[i]] = paths[i].end();
        continue;
      }
      paths[left] = paths[i];
      owners[left++] = owners[i];
    }
    n = left;
  }
  return evaluations;
}

// Where in `vertices` those are that have a normal, the next one near.
std::vector<std::size_t> order_in_space(const ShellSurface& surface, std::span<const Index> vertices) {
  std::vector<std::size_t> places;
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (surface.normals[vertices[i]].isZero()) continue;
    places.push_back(i);
    points.push_back(surface.positions[vertices[i]]);
  }
  std::vector<std::size_t> order;
  order.reserve(places.size());
  for (const std::uint32_t i : near_order(points)) order.push_back(places[i]);
  return order;
}

}  // namespace

ShellSurface shell_surface_of(std::span<const Vec3> positions, std::span<const Index> triangles) {
  ShellSurface surface{positions, triangles, std::vector<Vec3>(positions.size(), Vec3::Zero())};
  std::vector<Vec3> of_triangles(triangles.size() / 3, Vec3::Zero());
  std::vector<std::size_t> starts(positions.size() + 1, 0);
  for (std::size_t t = 0; t < of_triangles.size(); ++t) {
    const Index* const corners = &triangles[3 * t];
    const Vec3 across =
        (positions[corners[1]] - positions[corners[0]]).cross(positions[corners[2]] - positions[corners[0]]);
    if (!(across.norm() > 0)) continue;
    of_triangles[t] = across.normalized();
    for (int k = 0; k < 3; ++k) {
      ++starts[corners[k] + 1];
      const Vec3 &at = positions[corners[k]], one = positions[corners[(k + 1) % 3]] - at,
                 other = positions[corners[(k + 2) % 3]] - at;
      surface.normals[corners[k]] += angle_between(one, other) * of_triangles[t];
    }
  }
  for (std::size_t v = 0; v < positions.size(); ++v) starts[v + 1] += starts[v];
  std::vector<Vec3> around(starts.back());
  std::vector<std::size_t> next(starts.begin(), starts.end() - 1);
  for (std::size_t t = 0; t < of_triangles.size(); ++t) {
    if (of_triangles[t].isZero()) continue;
    for (int k = 0; k < 3; ++k)
      around[next[triangles[3 * t + static_cast<std::size_t>(k)]]++] = of_triangles[t];
  }
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t v) {
    const std::span<const Vec3> own(around.data() + starts[v], starts[v + 1] - starts[v]);
    if (own.empty()) return;
    Vec3& normal = surface.normals[v];
    normal = normal.norm() > 0 ? normal.normalized() : own.front();
    constexpr double k_clearly = 0.5;
    if (least_cosine(own, normal) >= k_clearly) return;
    const Vec3 axis = axis_of_normals(own, normal);
    if (least_cosine(own, axis) > least_cosine(own, normal)) normal = axis;
  });
  return surface;
}

PolygonSoup with_extended_borders(const ShellSurface& surface, std::span<const double> reaches) {
  PolygonSoup soup;
  soup.positions.assign(surface.positions.begin(), surface.positions.end());
  for (std::size_t t = 0; t + 2 < surface.triangles.size(); t += 3)
    soup.add_face(surface.triangles.subspan(t, 3));
  const std::vector<Index> open = find_open_sides(surface.positions.size(), surface.triangles);
  const auto ends = [&](Index corner) {
    return std::array<Index, 2>{surface.triangles[corner], surface.triangles[next_in_triangle(corner)]};
  };
  std::vector<Vec3> outwards(surface.positions.size(), Vec3::Zero());
  for (const Index corner : open) {
    const auto [a, b] = ends(corner);
    const Vec3 along = (surface.positions[b] - surface.positions[a]).stableNormalized();
    for (const Index v : {a, b}) outwards[v] += along.cross(surface.normals[v]);
  }
  std::vector<Index> beyond(surface.positions.size(), k_no_index);
  for (const Index corner : open) {
    const auto [a, b] = ends(corner);
    for (const Index v : {a, b}) {
      if (beyond[v] != k_no_index) continue;
      beyond[v] = static_cast<Index>(soup.positions.size());
      soup.positions.push_back(surface.positions[v] + reaches[v] * outwards[v].stableNormalized());
    }
    soup.add_face(std::array<Index, 3>{b, a, beyond[a]});
    soup.add_face(std::array<Index, 3>{b, beyond[a], beyond[b]});
  }
  return soup;
}

TracedDirectors trace_directors(const ShellSurface& surface, std::span<const Index> vertices,
                                std::span<const double> thicknesses, double side, const ShellOptions& options,
                                Progress* progress) {
  TracedDirectors result;
  result.ends.reserve(vertices.size());
  for (const Index v : vertices) result.ends.push_back(surface.positions[v]);
  if (options.method == DirectorMethod::normals) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Index v = vertices[i];
      result.ends[i] = surface.positions[v] + side * thicknesses[v] * surface.normals[v];
    }
    return result;
  }
  report_progress(progress, "averaged distance", 0);
  const FlowField field(surface, thicknesses, options);
  const std::vector<std::size_t> order = order_in_space(surface, vertices);
  std::atomic<std::size_t> evaluations{0};
  constexpr std::size_t k_at_once = 4096;
  for (std::size_t first = 0; first < order.size(); first += k_at_once) {
    report_progress(progress, "directors", static_cast<double>(first) / static_cast<double>(order.size()));
    const std::size_t last = std::min(first + k_at_once, order.size());
    tbb::parallel_for(first, last, k_neighbours, [&](std::size_t begin) {
      evaluations += trace_neighbours(
          field, std::span(order).subspan(begin, std::min(k_neighbours, last - begin)),
          [&](std::size_t i) {
            const Index v = vertices[i];
            return DirectorPath(surface.positions[v], side * surface.normals[v], thicknesses[v], options.step,
                                field.is_smooth());
          },
          result.ends);
    });
  }
  result.evaluations = evaluations;
  return result;
}

}  // namespace recede::detail
