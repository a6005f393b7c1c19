#include <recede/geometry/detail/cad_surface.h>

#include <Convert_ParameterisationType.hxx>
#include <GeomConvert.hxx>
#include <GeomConvert_ApproxCurve.hxx>
#include <GeomConvert_ApproxSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Ellipse.hxx>
#include <Geom_Hyperbola.hxx>
#include <Geom_Line.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Parabola.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfLinearExtrusion.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array2OfPnt.hxx>

#include <cmath>

namespace recede::detail {

namespace {

constexpr int k_approximation_degree = 9, k_approximation_pieces = 200;

struct Knots {
  TColStd_Array1OfReal values;
  TColStd_Array1OfInteger multiplicities;
};

Knots clamped_knots(const std::vector<double>& ends, int degree) {
  const int n = static_cast<int>(ends.size());
  Knots knots{TColStd_Array1OfReal(1, n), TColStd_Array1OfInteger(1, n)};
  for (int i = 1; i <= n; ++i) {
    knots.values(i) = ends[static_cast<std::size_t>(i - 1)];
    knots.multiplicities(i) = i == 1 || i == n ? degree + 1 : degree;
  }
  return knots;
}

/// Control points of arcs around a centre. `at(t, scale)` is the curve's point, moved away from the centre by
/// a factor: the tangents of a span's ends meet above the middle of it.
template <typename At>
ConvertedCurve conic(const ParameterMap& map, At&& at) {
  const int n = 2 * map.spans + 1;
  TColgp_Array1OfPnt poles(1, n);
  TColStd_Array1OfReal weights(1, n);
  for (int i = 0; i < n; ++i) {
    const bool is_middle = i % 2 == 1;
    const double weight = is_middle ? map.middle_weight() : 1;
    poles(i + 1) = gp_Pnt(at(map.begin + i * map.step / 2, 1 / weight));
    weights(i + 1) = weight;
  }
  const Knots knots = clamped_knots(map.span_ends(), 2);
  return {new Geom_BSplineCurve(poles, weights, knots.values, knots.multiplicities, 2), map};
}

ConvertedCurve line(const gp_Pnt& from, const gp_Pnt& to, const ParameterRange& range) {
  TColgp_Array1OfPnt poles(1, 2);
  poles(1) = from;
  poles(2) = to;
  const Knots knots = clamped_knots({range.begin, range.end}, 1);
  return {new Geom_BSplineCurve(poles, knots.values, knots.multiplicities, 1), {}};
}

ConvertedCurve ellipse(const gp_XYZ& centre, const gp_XYZ& x, const gp_XYZ& y, const ParameterRange& range) {
  return conic(ParameterMap::angles(range),
               [&](double t, double scale) { return centre + (x * std::cos(t) + y * std::sin(t)) * scale; });
}

// Cutting a periodic B-spline may move its knots by whole periods.
Handle(Geom_BSplineCurve) cut(const Handle(Geom_BSplineCurve) & periodic, const ParameterRange& range) {
  const double period = periodic->Period();
  const Handle(Geom_BSplineCurve) curve = Handle(Geom_BSplineCurve)::DownCast(periodic->Copy());
  curve->Segment(range.begin, std::min(range.end, range.begin + period));
  TColStd_Array1OfReal knots(1, curve->NbKnots());
  curve->Knots(knots);
  const double shift = period * std::round((range.begin - knots(1)) / period);
  for (double& knot : knots) knot += shift;
  curve->SetKnots(knots);
  return curve;
}

using Ranges = std::array<ParameterRange, 2>;

ConvertedSurface plane(const gp_Pln& plane, const Ranges& ranges) {
  TColgp_Array2OfPnt poles(1, 2, 1, 2);
  const gp_XYZ origin = plane.Location().XYZ();
  const gp_XYZ x = plane.Position().XDirection().XYZ(), y = plane.Position().YDirection().XYZ();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const double u = i == 0 ? ranges[0].begin : ranges[0].end;
      const double v = j == 0 ? ranges[1].begin : ranges[1].end;
      poles(i + 1, j + 1) = gp_Pnt(origin + x * u + y * v);
    }
  }
  const Knots u = clamped_knots({ranges[0].begin, ranges[0].end}, 1);
  const Knots v = clamped_knots({ranges[1].begin, ranges[1].end}, 1);
  return {new Geom_BSplineSurface(poles, u.values, v.values, u.multiplicities, v.multiplicities, 1, 1), {}};
}

/// A profile turned around an axis by angles: u is the angle, v runs along the profile (The NURBS Book, 8.5).
ConvertedSurface revolve(const ConvertedCurve& profile, const gp_Pnt& origin, const gp_Dir& axis,
                         const ParameterRange& angles) {
  const ParameterMap map = ParameterMap::angles(angles);
  const int n_u = 2 * map.spans + 1, n_v = profile.curve->NbPoles();
  TColgp_Array2OfPnt poles(1, n_u, 1, n_v);
  TColStd_Array2OfReal weights(1, n_u, 1, n_v);
  const gp_XYZ along = axis.XYZ();
  for (int j = 1; j <= n_v; ++j) {
    const gp_XYZ from_origin = profile.curve->Pole(j).XYZ() - origin.XYZ();
    const gp_XYZ foot = origin.XYZ() + along * from_origin.Dot(along);
    const gp_XYZ radius = profile.curve->Pole(j).XYZ() - foot, across = along.Crossed(radius);
    for (int i = 0; i < n_u; ++i) {
      const double angle = map.begin + i * map.step / 2, weight = i % 2 == 1 ? map.middle_weight() : 1;
      poles(i + 1, j) = gp_Pnt(foot + (radius * std::cos(angle) + across * std::sin(angle)) / weight);
      weights(i + 1, j) = weight * profile.curve->Weight(j);
    }
  }
  const Knots u = clamped_knots(map.span_ends(), 2);
  const Handle(Geom_BSplineSurface) surface =
      new Geom_BSplineSurface(poles, weights, u.values, profile.curve->Knots(), u.multiplicities,
                              profile.curve->Multiplicities(), 2, profile.curve->Degree());
  return {surface, {map, profile.map}};
}

ConvertedSurface extrude(const ConvertedCurve& profile, const gp_Dir& direction, const ParameterRange& v) {
  const int n = profile.curve->NbPoles();
  TColgp_Array2OfPnt poles(1, n, 1, 2);
  TColStd_Array2OfReal weights(1, n, 1, 2);
  for (int i = 1; i <= n; ++i) {
    poles(i, 1) = gp_Pnt(profile.curve->Pole(i).XYZ() + direction.XYZ() * v.begin);
    poles(i, 2) = gp_Pnt(profile.curve->Pole(i).XYZ() + direction.XYZ() * v.end);
    weights(i, 1) = weights(i, 2) = profile.curve->Weight(i);
  }
  const Knots knots = clamped_knots({v.begin, v.end}, 1);
  return {new Geom_BSplineSurface(poles, weights, profile.curve->Knots(), knots.values,
                                  profile.curve->Multiplicities(), knots.multiplicities,
                                  profile.curve->Degree(), 1),
          {profile.map, {}}};
}

/// Cylinders, cones, spheres and tori: their curve at u = 0, turned around their axis.
ConvertedSurface elementary(const Handle(Geom_ElementarySurface) & surface, const Ranges& ranges) {
  const gp_Ax3& position = surface->Position();
  const gp_XYZ centre = position.Location().XYZ(), x = position.XDirection().XYZ(),
               z = position.Direction().XYZ();
  ConvertedCurve profile;
  if (const auto sphere = Handle(Geom_SphericalSurface)::DownCast(surface); !sphere.IsNull()) {
    profile = ellipse(centre, x * sphere->Radius(), z * sphere->Radius(), ranges[1]);
  } else if (const auto torus = Handle(Geom_ToroidalSurface)::DownCast(surface); !torus.IsNull()) {
    profile = ellipse(centre + x * torus->MajorRadius(), x * torus->MinorRadius(), z * torus->MinorRadius(),
                      ranges[1]);
  } else {
    profile = line(surface->Value(0, ranges[1].begin), surface->Value(0, ranges[1].end), ranges[1]);
  }
  // Mirrored shapes have left-handed axes, around which u turns the other way.
  const gp_Dir axis = position.Direct() ? position.Direction() : position.Direction().Reversed();
  return revolve(profile, position.Location(), axis, ranges[0]);
}

ConvertedSurface b_spline(const Handle(Geom_BSplineSurface) & original, const Ranges& ranges) {
  const Handle(Geom_BSplineSurface) surface = Handle(Geom_BSplineSurface)::DownCast(original->Copy());
  if (!surface->IsUPeriodic() && !surface->IsVPeriodic()) return {surface, {}};
  Ranges kept;
  surface->Bounds(kept[0].begin, kept[0].end, kept[1].begin, kept[1].end);
  std::array<double, 2> periods{period_of(original, 0), period_of(original, 1)};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (periods[axis] == 0) continue;
    kept[axis] = {ranges[axis].begin, std::min(ranges[axis].end, ranges[axis].begin + periods[axis])};
  }
  surface->Segment(kept[0].begin, kept[0].end, kept[1].begin, kept[1].end);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (periods[axis] == 0) continue;
    TColStd_Array1OfReal knots = axis == 0 ? surface->UKnots() : surface->VKnots();
    const double shift = periods[axis] * std::round((kept[axis].begin - knots.First()) / periods[axis]);
    for (double& knot : knots) knot += shift;
    axis == 0 ? surface->SetUKnots(knots) : surface->SetVKnots(knots);
  }
  if (surface->IsUPeriodic()) surface->SetUNotPeriodic();
  if (surface->IsVPeriodic()) surface->SetVNotPeriodic();
  return {surface, {}};
}

ConvertedSurface approximate(const Handle(Geom_Surface) & surface, const Ranges& ranges, double tolerance) {
  const Handle(Geom_Surface) trimmed = new Geom_RectangularTrimmedSurface(
      surface, ranges[0].begin, ranges[0].end, ranges[1].begin, ranges[1].end);
  const GeomConvert_ApproxSurface fit(trimmed, tolerance, GeomAbs_C1, GeomAbs_C1, k_approximation_degree,
                                      k_approximation_degree, k_approximation_pieces, 0);
  if (!fit.HasResult()) throw CadProblem{"its surface can't be made a NURBS"};
  return {fit.Surface(), {}, false};
}

}  // namespace

Handle(Geom_Surface) untrimmed(Handle(Geom_Surface) surface) {
  while (true) {
    const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface);
    if (trimmed.IsNull()) return surface;
    surface = trimmed->BasisSurface();
  }
}

Handle(Geom_Curve) untrimmed(Handle(Geom_Curve) curve) {
  while (true) {
    const auto trimmed = Handle(Geom_TrimmedCurve)::DownCast(curve);
    if (trimmed.IsNull()) return curve;
    curve = trimmed->BasisCurve();
  }
}

bool runs_by_angle(const Handle(Geom_Curve) & curve) {
  if (curve.IsNull()) return false;
  const Handle(Geom_Curve) basis = untrimmed(curve);
  return basis->IsKind(STANDARD_TYPE(Geom_Circle)) || basis->IsKind(STANDARD_TYPE(Geom_Ellipse));
}

ConvertedCurve convert_curve(const Handle(Geom_Curve) & curve, const ParameterRange& range,
                             double tolerance) {
  const Handle(Geom_Curve) basis = untrimmed(curve);
  if (basis->IsKind(STANDARD_TYPE(Geom_Line))) {
    return line(basis->Value(range.begin), basis->Value(range.end), range);
  }
  if (const auto circle = Handle(Geom_Circle)::DownCast(basis); !circle.IsNull()) {
    const gp_Ax2& axes = circle->Position();
    return ellipse(axes.Location().XYZ(), axes.XDirection().XYZ() * circle->Radius(),
                   axes.YDirection().XYZ() * circle->Radius(), range);
  }
  if (const auto oval = Handle(Geom_Ellipse)::DownCast(basis); !oval.IsNull()) {
    const gp_Ax2& axes = oval->Position();
    return ellipse(axes.Location().XYZ(), axes.XDirection().XYZ() * oval->MajorRadius(),
                   axes.YDirection().XYZ() * oval->MinorRadius(), range);
  }
  if (const auto branch = Handle(Geom_Hyperbola)::DownCast(basis); !branch.IsNull()) {
    const gp_Ax2& axes = branch->Position();
    return conic(ParameterMap::hyperbola(range), [&](double t, double scale) {
      return axes.Location().XYZ() + (axes.XDirection().XYZ() * branch->MajorRadius() * std::cosh(t) +
                                      axes.YDirection().XYZ() * branch->MinorRadius() * std::sinh(t)) *
                                         scale;
    });
  }
  if (const auto spline = Handle(Geom_BSplineCurve)::DownCast(basis); !spline.IsNull()) {
    if (spline->IsPeriodic()) return {cut(spline, range), {}};
    return {Handle(Geom_BSplineCurve)::DownCast(spline->Copy()), {}};
  }
  if (basis->IsKind(STANDARD_TYPE(Geom_BezierCurve))) return {GeomConvert::CurveToBSplineCurve(basis), {}};
  const Handle(Geom_Curve) piece = new Geom_TrimmedCurve(basis, range.begin, range.end);
  if (basis->IsKind(STANDARD_TYPE(Geom_Parabola))) return {GeomConvert::CurveToBSplineCurve(piece), {}};
  const GeomConvert_ApproxCurve fit(piece, tolerance, GeomAbs_C1, k_approximation_pieces,
                                    k_approximation_degree);
  if (!fit.HasResult()) throw CadProblem{"a curve of its surface can't be made a NURBS"};
  return {fit.Curve(), {}};
}

ConvertedSurface convert_surface(const Handle(Geom_Surface) & surface,
                                 const std::array<ParameterRange, 2>& ranges, double tolerance) {
  const Handle(Geom_Surface) basis = untrimmed(surface);
  if (const auto flat = Handle(Geom_Plane)::DownCast(basis); !flat.IsNull())
    return plane(flat->Pln(), ranges);
  if (const auto round = Handle(Geom_ElementarySurface)::DownCast(basis); !round.IsNull()) {
    return elementary(round, ranges);
  }
  if (const auto spline = Handle(Geom_BSplineSurface)::DownCast(basis); !spline.IsNull()) {
    return b_spline(spline, ranges);
  }
  if (basis->IsKind(STANDARD_TYPE(Geom_BezierSurface))) {
    return {GeomConvert::SurfaceToBSplineSurface(basis), {}};
  }
  if (const auto turned = Handle(Geom_SurfaceOfRevolution)::DownCast(basis); !turned.IsNull()) {
    const gp_Ax1 axis = turned->Axis();
    return revolve(convert_curve(turned->BasisCurve(), ranges[1], tolerance), axis.Location(),
                   axis.Direction(), ranges[0]);
  }
  if (const auto pulled = Handle(Geom_SurfaceOfLinearExtrusion)::DownCast(basis); !pulled.IsNull()) {
    return extrude(convert_curve(pulled->BasisCurve(), ranges[0], tolerance), pulled->Direction(), ranges[1]);
  }
  if (const auto moved = Handle(Geom_OffsetSurface)::DownCast(basis); !moved.IsNull()) {
    // Offsets of planes and round surfaces are such surfaces themselves, with the same parameters.
    const Handle(Geom_Surface) same = moved->Surface();
    if (!same.IsNull() && !untrimmed(same)->IsKind(STANDARD_TYPE(Geom_OffsetSurface))) {
      return convert_surface(same, ranges, tolerance);
    }
  }
  return approximate(basis, ranges, tolerance);
}

double period_of(const Handle(Geom_Surface) & surface, std::size_t axis) {
  const Handle(Geom_Surface) basis = untrimmed(surface);
  if (axis == 0) return basis->IsUPeriodic() ? basis->UPeriod() : 0;
  return basis->IsVPeriodic() ? basis->VPeriod() : 0;
}

}  // namespace recede::detail
