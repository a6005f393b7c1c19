#include <recede/geometry/closest_point.h>
#include <recede/shells/detail/front_direction.h>
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
constexpr int k_most_halvings = 12;
constexpr std::size_t k_most_evaluations = 500;  // where directions jump to and fro; few need more than 60
constexpr double k_stuck = 1e-4;                 // of a field as fast as that of a plane

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

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

  Flow at(const Vec3& point) const {
    if (exact_)
      return {extended_gradient(*exact_, point), std::sqrt(exact_->closest(point).squared_distance)};
    const LpValue value = averaged_->at(point);
    const double length = value.gradient.norm();
    return {is_clamped_ && length > 1 ? Vec3(value.gradient / length) : value.gradient, value.distance};
  }

 private:
  std::optional<LpDistance> averaged_;
  std::optional<ClosestPointTree> exact_;
  bool is_clamped_;
};

// Explicit Euler steps (section 4.5), restarted at the longest and halved until they turn little. Besides the
// source's rule, no step is longer than its share of the thickness, or decreases the distance.
class DirectorTracer {
 public:
  DirectorTracer(const FlowField& field, const ShellOptions& options) : field_(field), options_(options) {}

  Vec3 trace(const Vec3& start, const Vec3& normal, double thickness, std::size_t& evaluations) const {
    double time = k_first_step * thickness;
    Vec3 at = start + time * normal;
    Flow flow = field_.at(at);
    ++evaluations;
    while (time < thickness && flow.velocity.norm() > k_stuck && evaluations < k_most_evaluations) {
      const double longest = options_.step * thickness / std::max(1.0, flow.velocity.norm());
      double step = std::min(longest, thickness - time);
      std::optional<Flow> next;
      for (int halving = 0; halving <= k_most_halvings && !next; ++halving, step /= 2) {
        const Flow there = field_.at(at + step * flow.velocity);
        ++evaluations;
        if (there.distance >= flow.distance &&
            angle_between(flow.velocity, there.velocity) <= options_.step) {
          next = there;
          break;
        }
      }
      if (!next) break;
      at += step * flow.velocity;
      // What is left of a thickness may be less than a step of rounding.
      time = step < longest && step >= thickness - time ? thickness : time + step;
      flow = *next;
    }
    return at;
  }

 private:
  const FlowField& field_;
  const ShellOptions& options_;
};

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
  result.ends.resize(vertices.size());
  if (options.method == DirectorMethod::normals) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Index v = vertices[i];
      result.ends[i] = surface.positions[v] + side * thicknesses[v] * surface.normals[v];
    }
    return result;
  }
  report_progress(progress, "averaged distance", 0);
  const FlowField field(surface, thicknesses, options);
  const DirectorTracer tracer(field, options);
  std::atomic<std::size_t> evaluations{0};
  constexpr std::size_t k_at_once = 4096;
  for (std::size_t first = 0; first < vertices.size(); first += k_at_once) {
    report_progress(progress, "directors", static_cast<double>(first) / static_cast<double>(vertices.size()));
    tbb::parallel_for(first, std::min(first + k_at_once, vertices.size()), [&](std::size_t i) {
      const Index v = vertices[i];
      if (surface.normals[v].isZero()) {
        result.ends[i] = surface.positions[v];
        return;
      }
      std::size_t n = 0;
      result.ends[i] = tracer.trace(surface.positions[v], side * surface.normals[v], thicknesses[v], n);
      evaluations += n;
    });
  }
  result.evaluations = evaluations;
  return result;
}

}  // namespace recede::detail
