// How parameters of a CAD file's curves and surfaces become those of their NURBS form. A circle that runs by
// its angle is no NURBS; the rational form has the same points in other places of its domain.
#pragma once

#include <recede/geometry/nurbs.h>

#include <vector>

namespace recede::detail {

/// A monotone map of one parameter. Both sides share their values at the ends of the spans.
struct ParameterMap {
  enum class Kind {
    same,       ///< the file's parameter is the NURBS parameter
    angle,      ///< of circular or elliptic arcs, each a rational quadratic span
    hyperbolic  ///< of one branch of a hyperbola, in one such span
  };
  Kind kind = Kind::same;
  double begin = 0, step = 1;
  int spans = 1;

  /// Arcs of at most a quarter turn each over a range of angles.
  static ParameterMap angles(const ParameterRange& range);
  static ParameterMap hyperbola(const ParameterRange& range);

  double to_nurbs(double t) const;
  double to_file(double x) const;
  /// Where spans begin and end; nothing for `same`.
  std::vector<double> span_ends() const;
  /// Weight of the control point in the middle of a span.
  double middle_weight() const;
};

}  // namespace recede::detail
