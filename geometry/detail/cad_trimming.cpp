#include <recede/geometry/detail/cad_fit.h>
#include <recede/geometry/detail/cad_trimming.h>

#include <Geom2dConvert.hxx>
#include <Geom2d_BezierCurve.hxx>
#include <Geom2d_Circle.hxx>
#include <Geom2d_Ellipse.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt2d.hxx>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace recede::detail {

namespace {

constexpr int k_samples = 24;
/// Two ranges of parameters are the same when they differ by less, relative to their length.
constexpr double k_same_range = 1e-9;
/// A projection that leaves more than this share of the distance isn't worth the file's own curve.
constexpr double k_worth_it = 0.5;

Handle(Geom2d_Curve) untrimmed(Handle(Geom2d_Curve) curve) {
  while (true) {
    const auto trimmed = Handle(Geom2d_TrimmedCurve)::DownCast(curve);
    if (trimmed.IsNull()) return curve;
    curve = trimmed->BasisCurve();
  }
}

Vec2 value(const Handle(Geom2d_Curve) & curve, double t) {
  const gp_Pnt2d point = curve->Value(t);
  return {point.X(), point.Y()};
}

/// One use of an edge on its way to a B-spline. Its parameter x has the range of the edge's curve in space,
/// and runs as that curve's NURBS form does: all uses of the edge share it.
class Trim {
 public:
  Trim(const EdgeUse& use, const ConvertedSurface& surface, double tolerance)
      : use_(use), surface_(surface), tolerance_(tolerance), domain_(use.range) {
    if (use.space_curve.IsNull()) return;
    domain_ = use.space_range;
    if (runs_by_angle(use.space_curve)) edge_map_ = ParameterMap::angles(domain_);
  }

  Handle(Geom2d_BSplineCurve) convert() const {
    const Handle(Geom2d_Curve) basis = untrimmed(use_.curve);
    if (const auto line = Handle(Geom2d_Line)::DownCast(basis); !line.IsNull()) {
      if (const auto exact = along_line(line)) return *exact;
    }
    const bool is_same = is_same_on_surface();
    if (is_same && has_same_range() && edge_map_.kind == ParameterMap::Kind::angle) {
      if (const auto exact = along_conic(basis)) return *exact;
    }
    if (is_same && edge_map_.kind == ParameterMap::Kind::same) {
      if (const auto exact = along_spline(basis)) return *exact;
    }
    return fit([this](double x) { return target(x); });
  }

  /// The places of the surface that are nearest to the edge's curve in space.
  Handle(Geom2d_BSplineCurve) project() const {
    return fit([this](double x) { return nearest(space_point(x), target(x)); });
  }

  double distance_in_space(const Geom2d_BSplineCurve& curve) const {
    if (use_.space_curve.IsNull()) return 0;
    double largest = 0;
    for (int i = 0; i <= k_samples; ++i) {
      const double share = static_cast<double>(i) / k_samples;
      const Vec3 on_surface = surface_.at(at_share(curve, share));
      const Vec3 gap = on_surface - space_point(domain_.begin + share * domain_.length());
      largest = std::max(largest, gap.norm());
    }
    return largest;
  }

 private:
  double file_share(double x) const { return (edge_map_.to_file(x) - domain_.begin) / domain_.length(); }
  Vec2 target(double x) const { return surface_.to_nurbs(use_.at(file_share(x))); }
  Vec3 space_point(double x) const {
    const gp_Pnt point = use_.space_curve->Value(edge_map_.to_file(x));
    return {point.X(), point.Y(), point.Z()};
  }
  bool has_same_range() const {
    return std::abs(use_.range.length() - domain_.length()) <= k_same_range * domain_.length();
  }
  bool is_same_on_surface() const {
    return surface_.maps[0].kind == ParameterMap::Kind::same &&
           surface_.maps[1].kind == ParameterMap::Kind::same;
  }

  std::optional<Handle(Geom2d_BSplineCurve)> along_line(const Handle(Geom2d_Line) & line) const;
  std::optional<Handle(Geom2d_BSplineCurve)> along_arcs(std::size_t axis) const;
  std::optional<Handle(Geom2d_BSplineCurve)> along_conic(const Handle(Geom2d_Curve) & basis) const;
  std::optional<Handle(Geom2d_BSplineCurve)> along_spline(const Handle(Geom2d_Curve) & basis) const;
  Handle(Geom2d_BSplineCurve) fit(std::function<Vec2(double)> curve) const;
  std::vector<double> smooth_pieces() const;
  void add_crossings(std::size_t axis, double level, std::vector<double>& ends) const;
  Vec2 nearest(const Vec3& point, Vec2 uv) const;

  const EdgeUse& use_;
  const ConvertedSurface& surface_;
  double tolerance_;
  ParameterRange domain_;
  ParameterMap edge_map_;
};

std::optional<Handle(Geom2d_BSplineCurve)> Trim::along_line(const Handle(Geom2d_Line) & line) const {
  const gp_Dir2d direction = line->Direction();
  const bool moves[2] = {direction.X() != 0, direction.Y() != 0};
  bool is_straight = edge_map_.kind == ParameterMap::Kind::same;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (moves[axis] && surface_.maps[axis].kind != ParameterMap::Kind::same) is_straight = false;
  }
  if (is_straight) {
    const Handle(Geom2d_BSplineCurve) curve = straight_trim(target(domain_.begin), target(domain_.end));
    TColStd_Array1OfReal knots(1, 2);
    knots(1) = domain_.begin;
    knots(2) = domain_.end;
    curve->SetKnots(knots);
    return curve;
  }
  if (moves[0] == moves[1]) return {};
  const std::size_t axis = moves[0] ? 0 : 1;
  if (edge_map_.kind != ParameterMap::Kind::angle || surface_.maps[axis].kind != ParameterMap::Kind::angle ||
      !has_same_range()) {
    return {};
  }
  return along_arcs(axis);
}

/// Angles of two rational arcs are rational functions of degree 1 of each other, between the ends of their
/// spans: a circle along a round surface is exact on it.
std::optional<Handle(Geom2d_BSplineCurve)> Trim::along_arcs(std::size_t axis) const {
  const std::vector<double> ends = smooth_pieces();
  const int n = static_cast<int>(ends.size());
  TColgp_Array1OfPnt2d poles(1, n);
  TColStd_Array1OfReal weights(1, n), knots(1, n);
  TColStd_Array1OfInteger multiplicities(1, n);
  multiplicities.Init(1);
  multiplicities(1) = multiplicities(n) = 2;
  double weight = 1;
  for (int i = 1; i <= n; ++i) {
    const double x = ends[static_cast<std::size_t>(i - 1)];
    const Vec2 here = target(x);
    if (i > 1) {
      const double before = ends[static_cast<std::size_t>(i - 2)];
      const double from = target(before)[static_cast<Eigen::Index>(axis)];
      const double middle = target((before + x) / 2)[static_cast<Eigen::Index>(axis)];
      weight *= (middle - from) / (here[static_cast<Eigen::Index>(axis)] - middle);
      if (!(weight > 0) || !std::isfinite(weight)) return {};
    }
    poles(i) = gp_Pnt2d(here[0], here[1]);
    weights(i) = weight;
    knots(i) = x;
  }
  return new Geom2d_BSplineCurve(poles, weights, knots, multiplicities, 1);
}

std::optional<Handle(Geom2d_BSplineCurve)> Trim::along_conic(const Handle(Geom2d_Curve) & basis) const {
  Vec2 centre;
  if (const auto circle = Handle(Geom2d_Circle)::DownCast(basis); !circle.IsNull()) {
    centre = {circle->Location().X(), circle->Location().Y()};
  } else if (const auto oval = Handle(Geom2d_Ellipse)::DownCast(basis); !oval.IsNull()) {
    centre = {oval->Location().X(), oval->Location().Y()};
  } else {
    return {};
  }
  const ParameterMap map = ParameterMap::angles(domain_);
  const int n = 2 * map.spans + 1, n_ends = map.spans + 1;
  TColgp_Array1OfPnt2d poles(1, n);
  TColStd_Array1OfReal weights(1, n), knots(1, n_ends);
  TColStd_Array1OfInteger multiplicities(1, n_ends);
  for (int i = 0; i < n; ++i) {
    const double weight = i % 2 == 1 ? map.middle_weight() : 1;
    const double t = use_.range.begin + i * map.step / 2;
    const Vec2 point = centre + (value(basis, t) - centre) / weight + use_.shift;
    poles(i + 1) = gp_Pnt2d(point[0], point[1]);
    weights(i + 1) = weight;
  }
  for (int i = 1; i <= n_ends; ++i) {
    knots(i) = map.span_ends()[static_cast<std::size_t>(i - 1)];
    multiplicities(i) = i == 1 || i == n_ends ? 3 : 2;
  }
  return new Geom2d_BSplineCurve(poles, weights, knots, multiplicities, 2);
}

std::optional<Handle(Geom2d_BSplineCurve)> Trim::along_spline(const Handle(Geom2d_Curve) & basis) const {
  Handle(Geom2d_BSplineCurve) curve;
  if (basis->IsKind(STANDARD_TYPE(Geom2d_BSplineCurve))) {
    curve = Handle(Geom2d_BSplineCurve)::DownCast(basis->Copy());
  } else if (basis->IsKind(STANDARD_TYPE(Geom2d_BezierCurve))) {
    curve = Geom2dConvert::CurveToBSplineCurve(basis);
  } else {
    return {};
  }
  const double slack = k_same_range * use_.range.length();
  const bool is_inside =
      curve->FirstParameter() <= use_.range.begin + slack && use_.range.end <= curve->LastParameter() + slack;
  if (curve->IsPeriodic() || !is_inside) return {};
  const double first = std::max(curve->FirstParameter(), use_.range.begin);
  const double last = std::min(curve->LastParameter(), use_.range.end);
  curve->Segment(first, last);
  if (use_.shift != Vec2::Zero()) curve->Translate(gp_Vec2d(use_.shift[0], use_.shift[1]));
  return curve;
}

Handle(Geom2d_BSplineCurve) Trim::fit(std::function<Vec2(double)> curve) const {
  const auto distance = [this](const Vec2& a, const Vec2& b) {
    return (surface_.at(a) - surface_.at(b)).norm();
  };
  return fit_curve({std::move(curve), smooth_pieces(), distance, tolerance_});
}

/// Where the curve may have kinks or jumps of its higher derivatives: at knots of its own, of the edge's
/// arcs, and where it crosses those of the surface's arcs.
std::vector<double> Trim::smooth_pieces() const {
  std::vector<double> ends{domain_.begin, domain_.end};
  for (const double end : edge_map_.span_ends()) ends.push_back(end);
  if (const auto spline = Handle(Geom2d_BSplineCurve)::DownCast(untrimmed(use_.curve)); !spline.IsNull()) {
    for (int i = 1; i <= spline->NbKnots(); ++i) {
      const double share = (spline->Knot(i) - use_.range.begin) / use_.range.length();
      if (0 < share && share < 1)
        ends.push_back(edge_map_.to_nurbs(domain_.begin + share * domain_.length()));
    }
  }
  for (std::size_t axis = 0; axis < 2; ++axis) {
    for (const double level : surface_.maps[axis].span_ends()) add_crossings(axis, level, ends);
  }
  std::sort(ends.begin(), ends.end());
  const double least = k_same_range * domain_.length();
  std::vector<double> distinct{domain_.begin};
  for (const double end : ends) {
    if (end > distinct.back() + least && end < domain_.end - least) distinct.push_back(end);
  }
  distinct.push_back(domain_.end);
  return distinct;
}

void Trim::add_crossings(std::size_t axis, double level, std::vector<double>& ends) const {
  const auto above = [&](double x) { return target(x)[static_cast<Eigen::Index>(axis)] - level; };
  double before = domain_.begin;
  for (int i = 1; i <= k_samples; ++i) {
    const double x = domain_.begin + domain_.length() * i / k_samples;
    double low = before, high = x;
    before = x;
    if ((above(low) < 0) == (above(high) < 0)) continue;
    const bool starts_below = above(low) < 0;
    for (int step = 0; step < 60; ++step) {
      const double middle = (low + high) / 2;
      ((above(middle) < 0) == starts_below ? low : high) = middle;
    }
    ends.push_back((low + high) / 2);
  }
}

Vec2 Trim::nearest(const Vec3& point, Vec2 uv) const {
  double u0, u1, v0, v1;
  surface_.surface->Bounds(u0, u1, v0, v1);
  for (int step = 0; step < 30; ++step) {
    gp_Pnt at;
    gp_Vec du, dv;
    surface_.surface->D1(uv[0], uv[1], at, du, dv);
    const Vec3 gap(point.x() - at.X(), point.y() - at.Y(), point.z() - at.Z());
    Eigen::Matrix<double, 3, 2> tangents;
    tangents << du.X(), dv.X(), du.Y(), dv.Y(), du.Z(), dv.Z();
    const Eigen::Matrix2d normal = tangents.transpose() * tangents;
    // At poles one direction goes nowhere; it stays.
    const double least = 1e-14 * normal.trace();
    const Vec2 move = (normal + Eigen::Matrix2d::Identity() * least).inverse() * (tangents.transpose() * gap);
    if (!move.allFinite()) break;
    const Vec2 next{std::clamp(uv[0] + move[0], u0, u1), std::clamp(uv[1] + move[1], v0, v1)};
    const double moved = (next - uv).norm();
    uv = next;
    if (moved <= std::numeric_limits<double>::epsilon() * (1 + uv.norm())) break;
  }
  return uv;
}

/// Readers give circles along round surfaces curves of many pieces. Where a straight line is as near to the
/// edge, it is the better curve.
std::optional<ConvertedTrim> straightened(const EdgeUse& use, const ConvertedSurface& surface,
                                          double tolerance) {
  if (use.space_curve.IsNull() || untrimmed(use.curve)->IsKind(STANDARD_TYPE(Geom2d_Line))) return {};
  const Vec2 from = use.at(0);
  Vec2 way = use.at(1) - from;
  // The ends of such curves are off by rounding.
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    if (std::abs(way[axis]) <= k_same_range * way.norm()) way[axis] = 0;
  }
  if (!(way.norm() > 0)) return {};
  EdgeUse line = use;
  line.curve = new Geom2d_Line(gp_Pnt2d(from[0], from[1]), gp_Dir2d(way[0], way[1]));
  line.range = {0, way.norm()};
  line.shift.setZero();
  const Trim trim(line, surface, tolerance);
  ConvertedTrim converted{trim.convert()};
  converted.distance = trim.distance_in_space(*converted.curve);
  if (converted.distance > tolerance) return {};
  return converted;
}

}  // namespace

Vec2 EdgeUse::at(double share) const {
  const double t = share == 1 ? range.end : range.begin + share * range.length();
  return value(curve, t) + shift;
}

Vec2 at_share(const Geom2d_BSplineCurve& curve, double share) {
  const double first = curve.FirstParameter(), last = curve.LastParameter();
  const gp_Pnt2d point = curve.Value(share == 1 ? last : first + share * (last - first));
  return {point.X(), point.Y()};
}

Handle(Geom2d_BSplineCurve) straight_trim(const Vec2& from, const Vec2& to) {
  TColgp_Array1OfPnt2d poles(1, 2);
  poles(1) = gp_Pnt2d(from[0], from[1]);
  poles(2) = gp_Pnt2d(to[0], to[1]);
  TColStd_Array1OfReal knots(1, 2);
  knots(1) = 0;
  knots(2) = 1;
  TColStd_Array1OfInteger multiplicities(1, 2);
  multiplicities.Init(2);
  return new Geom2d_BSplineCurve(poles, knots, multiplicities, 1);
}

ConvertedTrim convert_trim(const EdgeUse& use, const ConvertedSurface& surface, double fit_tolerance) {
  if (use.is_point || use.edge.IsNull()) {
    return {straight_trim(surface.to_nurbs(use.at(0)), surface.to_nurbs(use.at(1)))};
  }
  if (const auto straight = straightened(use, surface, fit_tolerance)) return *straight;
  const Trim trim(use, surface, fit_tolerance);
  ConvertedTrim converted{trim.convert()};
  converted.distance = trim.distance_in_space(*converted.curve);
  if (converted.distance <= use.tolerance) return converted;
  const Handle(Geom2d_BSplineCurve) projected = trim.project();
  const double distance = trim.distance_in_space(*projected);
  if (distance < k_worth_it * converted.distance) return {projected, distance, true};
  return converted;
}

}  // namespace recede::detail
