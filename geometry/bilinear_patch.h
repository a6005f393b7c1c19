// Bilinear patches, and where a ray meets them: without gaps between patches that share an edge.
#pragma once

#include <recede/geometry/sheared_line.h>
#include <recede/geometry/vec.h>

#include <array>
#include <limits>
#include <optional>

namespace recede {

/// The surface (1-u)(1-v) p00 + u(1-v) p10 + (1-u)v p01 + uv p11 with u and v from 0 to 1. The corners need
/// not lie in a plane, and may coincide.
struct BilinearPatch {
  Vec3 p00 = Vec3::Zero(), p10 = Vec3::Zero(), p01 = Vec3::Zero(), p11 = Vec3::Zero();

  Vec3 point(double u, double v) const;
  /// Derivatives of the point, for a step of 1 in u or in v.
  Vec3 derivative_u(double v) const;
  Vec3 derivative_v(double u) const;
  /// Unit length, along derivative_u x derivative_v; (0,0,0) where these are parallel.
  Vec3 normal(double u, double v) const;
  /// The box of the corners, which holds the whole patch.
  Box3 bounds() const;
};

/// Where a ray meets a patch: at point(u, v) = origin + t direction.
struct PatchHit {
  double u = 0, v = 0;
  double t = 0;  ///< in lengths of the direction
  bool operator==(const PatchHit&) const = default;
};

/// Up to two hits, in order along the ray.
struct PatchHits {
  int count = 0;
  std::array<PatchHit, 2> hits{};
};

/// A ray prepared to be traced against many patches.
///
/// A line meets a bilinear patch at no, one or two points (Ramsey, Potter and Hansen 2004, "Ray bilinear
/// patch intersections"). Here the patch is looked at along the line, with the coordinate along which the
/// direction is largest as the depth: the source fails where its fixed one vanishes. The quadratics for u and
/// v are taken as Bernstein polynomials, whose end coefficients are cross products along the patch's sides.
/// The turns of the outline around the line say whether the number of hits is odd.
///
/// Each of these depends on the two corners of a side alone, bit for bit, so that patches with a side in
/// common agree on which of them a line meets: none slips through between them, and no tolerance is needed.
/// A point of the border counts as a hit of every patch that has it, as far as it can be told in double
/// precision. A line within the surface is reported where it crosses the border.
class PatchRay {
 public:
  /// `direction` has any length. A ray without direction, or with numbers that aren't finite, meets nothing.
  PatchRay(const Vec3& origin, const Vec3& direction);

  /// All points in which the whole line, also behind the origin, meets the patch; of more than two, where the
  /// line runs within the patch, the first and the last.
  PatchHits all_hits(const BilinearPatch& patch) const;
  /// The first with t from `t_min` to `t_max`.
  std::optional<PatchHit> nearest_hit(const BilinearPatch& patch, double t_min = 0,
                                      double t_max = std::numeric_limits<double>::infinity()) const;

  const ShearedLine& line() const { return line_; }

 private:
  ShearedLine line_;
};

}  // namespace recede
