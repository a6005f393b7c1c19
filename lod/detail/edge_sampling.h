// Points along an edge of a CAD model, the same for all trimming curves that run along it.
#pragma once

#include <recede/geometry/patch_surface.h>

#include <limits>
#include <span>
#include <vector>

namespace recede::detail {

/// A piece of a trimming curve that runs along an edge.
struct SeamCurve {
  const PatchSurface* surface;
  const NurbsCurve2* curve;
  ParameterRange range;  ///< of the curve
  bool runs_against;     ///< the edge
};

/// Points of a use, in the edge's direction, both ends among them.
struct SampledUse {
  std::vector<double> parameters;  ///< of the curve
  std::vector<Vec2> uvs;
  /// Between neighbours: how far the strip between curve and chord reaches in space, at most.
  std::vector<double> widths;
};

/// The tolerance of triangles for which a chord is fine enough that has a strip of a width between itself and
/// the trimming curve, and is as far from its surface as `deviation` says. Triangles beside it are no nearer
/// to the surface, and where that bends in more than one way they need some of the tolerance for themselves.
/// A share of the tolerance is left for what sewing moves.
inline constexpr double k_for_sewing = 0.05;
double seam_error(SurfaceBend bend, double strip, double deviation);

/// Samples all uses at equal shares of their ranges, so that the `seam_error` between two points is within
/// `tolerance` for each of them. At least `least_pieces` pieces. Refines at most to 2^16 pieces between
/// knots; `widths` says what was reached.
std::vector<SampledUse> sample_edge(std::span<const SeamCurve> uses, double tolerance, int least_pieces);

/// The same for uses that run along one another at speeds of their own: each one's points are projected on to
/// the first, and all of these on to the others. Points nearer to one another than `gap` / 2 become one.
std::vector<SampledUse> sample_matched_edge(std::span<const SeamCurve> uses, double tolerance, double gap,
                                            int least_pieces);

/// A piece of a curve as points in space, at rising or falling parameters.
struct Polyline {
  std::vector<double> parameters;
  std::vector<Vec3> points;
};
Polyline polyline_of(const SeamCurve& use, double tolerance, int least_pieces = 2);

/// Where a point is nearest to a poly-line.
struct Foot {
  double distance = std::numeric_limits<double>::infinity();
  double parameter = 0;
};
Foot foot_on(const Polyline& line, const Vec3& point);

/// A few steps of Newton's method from near the foot of a point on a use, within its range.
double nearest_parameter(const SeamCurve& use, double t, const Vec3& point);

/// How far the points of a poly-line are from the chord between `from` and `to` in space, at most: by the
/// lengths of derivatives of the surface over all of them, times the difference of parameters. On a flat
/// surface the distance itself.
double strip_width(const PatchSurface& surface, std::span<const Vec2> points, const Vec2& from,
                   const Vec2& to);

}  // namespace recede::detail
