// The Lp-averaged distance of a surface: smooth away from it, with a gradient that points away from it and
// gets shorter where there is less room, instead of jumping where several points are nearest.
//
// Peng 2004, "Thick Surfaces" (thesis, New York University), chapter 4: equations 4.3 and 4.4. Integrals over
// triangles are by their edges, which is exact where the source's wedges lose digits; far parts of the
// surface are summed up with a term more than the source's.
#pragma once

#include <recede/geometry/closest_point.h>
#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace recede {

/// What becomes of the integral I_p, of |x - y|^-p over the surface's points y.
enum class LpForm {
  /// ((p - 2) / 2 pi I_p)^(-1 / (p - 2)), p > 2: over a plane it is the distance, for every p.
  calibrated,
  /// (A / I_p)^(1 / p), A the area that was integrated (equation 4.3): a mean of the distances to all points
  /// of the surface, at least the distance to the nearest. Near it the gradient may be much longer than 1.
  averaged
};

/// What is integrated.
enum class LpSource {
  triangles,  ///< exactly; from p = 2 on the distance is 0 on the whole surface
  /// A sum over the vertices, each with a third of the area of the triangles around it. The distance is 0
  /// nowhere between vertices, so that a path of growing distance may slip through the surface.
  points
};

/// How a part of the surface enters that is summed up.
enum class LpExpansion {
  monopole,   ///< as a point with its area at its centroid (the source)
  quadrupole  ///< and its second moments: an order more in size over distance
};

struct LpDistanceOptions {
  /// Above 1, above 2 for `LpForm::calibrated`, at most 1000. 3 has closed forms, others take 50 times as
  /// long.
  double p = 3;
  LpForm form = LpForm::calibrated;
  LpSource source = LpSource::triangles;
  LpExpansion expansion = LpExpansion::quadrupole;
  /// A part of the surface is summed up where its centroid is farther away than this times the diagonal of
  /// its box; infinity: never. On a scan of 75 000 triangles, from 0.5 to 10 % of its diagonal away, the
  /// gradient of I_p was off by at most 1.6 % of its length at 1.25, 8 % at 1 (99 of 100 places: 1.8 %),
  /// 0.2 % at 2 and 0.05 % at 2.5; with monopoles by 4.4 % at 2. Costs grow with the square.
  double opening = 1.25;
  /// Instead of the opening: what summing up adds to I_p is at most this, relative to it; up to rounding.
  std::optional<double> error{};
  /// The surface counts fully up to this far from the point of interest, not at all from 5/4 of it on, and by
  /// a smoothstep of the distance between. Distances are those of triangles' centroids, or of the centroids
  /// of parts that are summed up; triangles with a radius above an eighth of the support are nearer by what
  /// it is more, so that they count as a whole where they come near. The gradient leaves out that these
  /// weights move with the point.
  double support = std::numeric_limits<double>::infinity();
};

struct LpValue {
  double distance = 0;  ///< object units; infinity where nothing is within the support
  /// Of the distance, without unit. Zero where it's infinite and on the surface, where rounding may turn it
  /// into the normal of either side.
  Vec3 gradient = Vec3::Zero();
  double error_bound = 0;     ///< when `error` was given: of I_p, relative; what was reached
  double gradient_error = 0;  ///< when `error` was given: how far off the gradient may be, absolute
};

namespace detail {
class LpField;
}

/// Answers for any point of space. The surface may be open, in several parts and of any orientation. Queries
/// may run in parallel, and the same point has the same answer on every call.
class LpDistance {
 public:
  /// Polygons count as the triangles of `triangulate`; those of zero area are left out. Keeps a copy. Throws
  /// `InputError` when no area is left or `validate` finds the surface wrong, `OptionError` for options out
  /// of their range.
  explicit LpDistance(const PolygonSoup& surface, const LpDistanceOptions& options = {});
  ~LpDistance();
  LpDistance(LpDistance&&) noexcept;
  LpDistance& operator=(LpDistance&&) noexcept;

  /// Throws `InputError` for a point that isn't finite, or farther away than 1e50 times the surface's size.
  /// Of a source of points, those that are bit for bit the point asked for are left out.
  LpValue at(const Vec3& point) const;
  /// The same for many points, in parallel, and in an order of their own in which the next is near. For p = 3
  /// over triangles without `error`, values are those above up to rounding, as parts are summed up in another
  /// order; else they have the same bits. A point's value doesn't depend on the others. With AVX-512, at 4000
  /// points around a scan of 75 000 triangles, half a million a second and core. Throws `InputError` as
  /// above, and `Cancelled`.
  std::vector<LpValue> at(std::span<const Vec3> points, Progress* progress = nullptr) const;

  double area() const;  ///< of all triangles, object units squared

 private:
  std::unique_ptr<const detail::LpField> field_;
};

struct ExtendedGradientOptions {
  /// Points of the surface count as nearest that are farther than the nearest by at most this, relative to
  /// its distance.
  double tolerance = 1e-6;
};

/// The extended gradient of the exact distance: (x - c) / d, with d the distance of `x` and c the centre of
/// the smallest ball around all nearest points. It is the gradient where there is one nearest point, and
/// where there are several it points to where the distance grows fastest, or is zero where it grows nowhere.
/// (The source takes zero for all places with three nearest points or more, against its own example of a
/// box's corner.) Zero on the surface, too. Throws `OptionError` for a negative tolerance.
Vec3 extended_gradient(const ClosestPointTree& surface, const Vec3& x,
                       const ExtendedGradientOptions& options = {});

}  // namespace recede
