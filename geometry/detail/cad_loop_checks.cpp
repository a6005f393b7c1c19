#include <recede/geometry/detail/cad_loop_checks.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

namespace {

constexpr int k_points_per_piece = 12;
/// Areas and crossings count when they are wider than this, model units: OpenCASCADE's own least length.
constexpr double k_least_width = 1e-7;

/// The loops as polygons, in parameters that are scaled so that lengths are about those in space.
struct Polygons {
  std::vector<std::vector<Vec2>> loops;
  std::vector<std::vector<double>> sagittas;  ///< of the chord after each point
};

double cross(const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Means over the surface.
struct PerParameter {
  Vec2 lengths = Vec2::Zero();
  double area = 0;

  /// Of areas in lengths along u and v, as if these were at right angles.
  double area_share() const { return area > 0 ? area / (lengths[0] * lengths[1]) : 0; }
};

PerParameter per_parameter(const TrimmedFace& face) {
  double u0, u1, v0, v1;
  face.surface.surface->Bounds(u0, u1, v0, v1);
  PerParameter means;
  int samples = 0;
  for (const double x : {0.1, 0.3, 0.5, 0.7, 0.9}) {
    for (const double y : {0.1, 0.3, 0.5, 0.7, 0.9}) {
      gp_Pnt point;
      gp_Vec du, dv;
      face.surface.surface->D1(u0 + x * (u1 - u0), v0 + y * (v1 - v0), point, du, dv);
      means.lengths += Vec2(du.Magnitude(), dv.Magnitude());
      means.area += du.CrossMagnitude(dv);
      ++samples;
    }
  }
  means.lengths /= samples;
  means.area /= samples;
  return means;
}

Polygons sample(const TrimmedFace& face, const Vec2& scale) {
  const auto at = [&](const Geom2d_BSplineCurve& curve, double t) {
    const gp_Pnt2d point = curve.Value(t);
    return Vec2(point.X() * scale[0], point.Y() * scale[1]);
  };
  Polygons polygons;
  for (const TrimmedLoop& loop : face.loops) {
    std::vector<Vec2>& points = polygons.loops.emplace_back();
    std::vector<double>& sagittas = polygons.sagittas.emplace_back();
    for (const TrimmedUse& use : loop) {
      const Geom2d_BSplineCurve& curve = *use.curve;
      const int steps = curve.Degree() == 1 ? 1 : k_points_per_piece;
      for (int span = 1; span < curve.NbKnots(); ++span) {
        const double from = curve.Knot(span), length = curve.Knot(span + 1) - from;
        for (int i = 0; i < steps; ++i) {
          const Vec2 begin = at(curve, from + length * i / steps);
          const Vec2 end = at(curve, from + length * (i + 1) / steps);
          points.push_back(begin);
          const Vec2 middle = at(curve, from + length * (i + 0.5) / steps);
          sagittas.push_back(steps == 1 ? 0 : (middle - (begin + end) / 2).norm());
        }
      }
    }
  }
  return polygons;
}

double signed_area(const std::vector<Vec2>& loop) {
  double doubled = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    doubled += cross(loop[i] - loop[0], loop[(i + 1) % loop.size()] - loop[0]);
  }
  return doubled / 2;
}

double perimeter(const std::vector<Vec2>& loop) {
  double length = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) length += (loop[(i + 1) % loop.size()] - loop[i]).norm();
  return length;
}

struct Segment {
  std::size_t loop, index;
  Vec2 a, b;
  double sagitta;
  double low() const { return std::min(a[0], b[0]); }
  double high() const { return std::max(a[0], b[0]); }
};

/// How far the segments reach across each other; 0 when they don't cross inside of both.
double crossing_depth(const Segment& s, const Segment& t) {
  const Vec2 along_s = s.b - s.a, along_t = t.b - t.a;
  const double ta = cross(along_s, t.a - s.a), tb = cross(along_s, t.b - s.a);
  const double sa = cross(along_t, s.a - t.a), sb = cross(along_t, s.b - t.a);
  if (!(ta * tb < 0 && sa * sb < 0)) return 0;
  const double across_s = std::min(std::abs(ta), std::abs(tb)) / along_s.norm();
  const double across_t = std::min(std::abs(sa), std::abs(sb)) / along_t.norm();
  return std::min(across_s, across_t);
}

bool are_neighbours(const Segment& s, const Segment& t, std::size_t n) {
  if (s.loop != t.loop) return false;
  const std::size_t apart = s.index > t.index ? s.index - t.index : t.index - s.index;
  return apart <= 1 || apart == n - 1;
}

bool cross_anywhere(const Polygons& polygons, double least_depth) {
  std::vector<Segment> segments;
  for (std::size_t l = 0; l < polygons.loops.size(); ++l) {
    const std::vector<Vec2>& loop = polygons.loops[l];
    for (std::size_t i = 0; i < loop.size(); ++i) {
      segments.push_back({l, i, loop[i], loop[(i + 1) % loop.size()], polygons.sagittas[l][i]});
    }
  }
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.low() < b.low(); });
  for (std::size_t i = 0; i < segments.size(); ++i) {
    for (std::size_t j = i + 1; j < segments.size() && segments[j].low() <= segments[i].high(); ++j) {
      const Segment &s = segments[i], &t = segments[j];
      if (are_neighbours(s, t, polygons.loops[s.loop].size())) continue;
      if (crossing_depth(s, t) > least_depth + 4 * (s.sagitta + t.sagitta)) return true;
    }
  }
  return false;
}

bool is_inside(const Vec2& point, const std::vector<Vec2>& loop) {
  bool inside = false;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 &a = loop[i], &b = loop[(i + 1) % loop.size()];
    if ((a[1] > point[1]) == (b[1] > point[1])) continue;
    if (point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
  }
  return inside;
}

/// Whether most of a loop's edges lie in another: loops may touch.
bool lies_in(const std::vector<Vec2>& inner, const std::vector<Vec2>& outer) {
  std::size_t inside = 0;
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (is_inside((inner[i] + inner[(i + 1) % inner.size()]) / 2, outer)) ++inside;
  }
  return 2 * inside > inner.size();
}

void check_directions(const Polygons& polygons) {
  for (std::size_t i = 0; i < polygons.loops.size(); ++i) {
    std::size_t around = 0;
    for (std::size_t j = 0; j < polygons.loops.size(); ++j) {
      if (i != j && lies_in(polygons.loops[i], polygons.loops[j])) ++around;
    }
    const double area = signed_area(polygons.loops[i]);
    // Slits have no direction.
    if (std::abs(area) <= k_least_width * perimeter(polygons.loops[i]) / 2) continue;
    const bool is_counter_clockwise = area > 0;
    if (is_counter_clockwise != (around % 2 == 0)) throw CadProblem{"a loop runs the wrong way around"};
  }
}

double widest_tolerance(const TrimmedFace& face) {
  double tolerance = k_least_width;
  for (const TrimmedLoop& loop : face.loops) {
    for (const TrimmedUse& use : loop) tolerance = std::max(tolerance, use.use.tolerance);
  }
  return tolerance;
}

}  // namespace

void check_loops(const TrimmedFace& face) {
  const PerParameter means = per_parameter(face);
  const Polygons polygons = sample(face, means.lengths);
  double area = 0, length = 0;
  for (const std::vector<Vec2>& loop : polygons.loops) {
    area += signed_area(loop);
    length += perimeter(loop);
  }
  // A surface that runs along the same lines in u and in v has none, whatever its loops have.
  area *= means.area_share();
  if (std::abs(area) <= k_least_width * length / 2) throw CadProblem{"it has no area"};
  if (cross_anywhere(polygons, 2 * widest_tolerance(face))) throw CadProblem{"its loops cross"};
  check_directions(polygons);
}

}  // namespace recede::detail
