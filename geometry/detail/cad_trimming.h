// Curves of a face's edges in the parameters of its NURBS surface, exact where they are NURBS there.
#pragma once

#include <recede/geometry/detail/cad_surface.h>

#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_Curve.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>

#include <functional>
#include <string>

namespace recede::detail {

/// An edge where a face uses it once, with its curve in the file's parameters of the surface.
struct EdgeUse {
  TopoDS_Edge edge;          ///< null: a side without an edge
  bool is_reversed = false;  ///< the loop runs against the edge
  bool is_point = false;     ///< a pole: the side of a surface that is one point
  Handle(Geom2d_Curve) curve;
  ParameterRange range;            ///< of `curve`
  Vec2 shift = Vec2::Zero();       ///< by whole periods
  Handle(Geom_Curve) space_curve;  ///< null: none
  ParameterRange space_range;      ///< of `space_curve`
  TopoDS_Vertex first, last;       ///< in the loop's direction
  double tolerance = 0;            ///< of the edge, model units

  /// A share of the range, in the edge's direction.
  Vec2 at(double share) const;
  Vec2 start() const { return at(is_reversed ? 1 : 0); }
  Vec2 end() const { return at(is_reversed ? 0 : 1); }
};

struct ConvertedTrim {
  Handle(Geom2d_BSplineCurve) curve;  ///< in the edge's direction
  double distance = 0;                ///< largest from the edge's curve in space at equal shares, by sampling
  bool was_projected = false;         ///< the file's curve was farther away than the edge's tolerance
};

/// Writers measure the tolerances of edges at some places only: between them, curves are this many times as
/// far apart.
inline constexpr double k_tolerance_slack = 2;

/// The use's curve in the parameters of the NURBS surface. Where the edge has a curve in space, equal shares
/// of the domains are there within the edge's tolerance, or the curve is projected again; `distance` says
/// what was reached. What isn't exact is within `fit_tolerance` of the file's curve, in space.
ConvertedTrim convert_trim(const EdgeUse& use, const ConvertedSurface& surface, double fit_tolerance);

/// Two control points.
Handle(Geom2d_BSplineCurve) straight_trim(const Vec2& from, const Vec2& to);

/// A share of the domain.
Vec2 at_share(const Geom2d_BSplineCurve& curve, double share);

}  // namespace recede::detail
