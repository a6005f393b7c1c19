// A B-spline in the plane through points of a curve that is known by its values.
#pragma once

#include <recede/geometry/nurbs.h>

#include <Geom2d_BSplineCurve.hxx>

#include <functional>
#include <vector>

namespace recede::detail {

struct FitRequest {
  std::function<Vec2(double)> target;
  std::vector<double> ends;  ///< increasing; the curve is smooth between neighbours
  /// How far apart two places of the plane are, in the units of the tolerance.
  std::function<double(const Vec2&, const Vec2&)> distance;
  double tolerance = 0;
};

/// Pieces of degree 5 that interpolate, halved until points between are within the tolerance, or ten times.
Handle(Geom2d_BSplineCurve) fit_curve(const FitRequest& request);

}  // namespace recede::detail
