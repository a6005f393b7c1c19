// Surfaces and curves of OpenCASCADE as B-splines, with the map of their parameters.
#pragma once

#include <recede/geometry/detail/cad_parameters.h>

#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>

#include <array>
#include <string>

namespace recede::detail {

/// Why a face or a curve can't be used. Never leaves the import.
struct CadProblem {
  std::string reason;
};

struct ConvertedCurve {
  Handle(Geom_BSplineCurve) curve;
  ParameterMap map;
};

struct ConvertedSurface {
  Handle(Geom_BSplineSurface) surface;
  std::array<ParameterMap, 2> maps;
  bool is_exact = true;  ///< else within the tolerance: offset surfaces aren't NURBS

  Vec2 to_nurbs(const Vec2& uv) const { return {maps[0].to_nurbs(uv[0]), maps[1].to_nurbs(uv[1])}; }
  Vec3 at(const Vec2& uv) const {
    const gp_Pnt point = surface->Value(uv[0], uv[1]);
    return {point.X(), point.Y(), point.Z()};
  }
};

/// Without the trims around it.
Handle(Geom_Surface) untrimmed(Handle(Geom_Surface) surface);
Handle(Geom_Curve) untrimmed(Handle(Geom_Curve) curve);
/// Whether the curve is a circle or an ellipse, which run by their angle.
bool runs_by_angle(const Handle(Geom_Curve) & curve);

/// The curve over a range of its parameter; not periodic.
ConvertedCurve convert_curve(const Handle(Geom_Curve) & curve, const ParameterRange& range, double tolerance);

/// The surface over a rectangle of its parameters at least; not periodic. B-splines that aren't periodic stay
/// whole. Throws `CadProblem`.
ConvertedSurface convert_surface(const Handle(Geom_Surface) & surface,
                                 const std::array<ParameterRange, 2>& ranges, double tolerance);

/// The period of an axis; 0: none.
double period_of(const Handle(Geom_Surface) & surface, std::size_t axis);

}  // namespace recede::detail
