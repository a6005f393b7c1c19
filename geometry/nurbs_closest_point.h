// The nearest point of a NURBS curve or surface, of all of it: not only of what is near to a first guess.
//
// Squared distances from a point are rational in the parameters too, and lie between the quotients of their
// Bernstein coefficients (The NURBS Book, 1.3 and 6.1). Pieces whose least coefficient is farther than what
// was found are done; the others are halved. Newton's method polishes what is found.
#pragma once

#include <recede/geometry/bezier_patches.h>

#include <optional>

namespace recede {

template <int Dimension>
struct NearestOnCurve {
  double parameter = 0;
  Eigen::Matrix<double, Dimension, 1> point;
  double distance = 0;
};

struct NearestOnSurface {
  Vec2 uv = Vec2::Zero();
  Vec3 point = Vec3::Zero();
  double distance = 0;
};

/// Answers nearest-point queries on one surface. Queries may run in parallel.
class NearestOnSurfaceSearch {
 public:
  /// Throws `InputError` as `validate` does.
  explicit NearestOnSurfaceSearch(const NurbsSurface& surface);

  /// The nearest point of the surface over its domain, or over a part of it, which may have no width or no
  /// height; the surface is closed where the part ends. Nothing is nearer by more than 1e-10 of the size of
  /// the surface and, by rounding, 1e-13 of the distance and of the surface's coordinates. One of several
  /// that are equally near, the same on every call. Throws `OptionError` when `point` isn't finite or `part`
  /// doesn't meet the domain.
  NearestOnSurface closest(const Vec3& point, const std::optional<ParameterBox>& part = {}) const;

 private:
  BezierPatches patches_;
  std::vector<Box3> boxes_;  // of control points, patch by patch as in `patches_`
  double size_ = 0;          // the diagonal of all
  double rounding_ = 0;      // of its coordinates
};

/// The same for a single query: a surface is prepared each time.
NearestOnSurface closest_point(const NurbsSurface& surface, const Vec3& point,
                               const std::optional<ParameterBox>& part = {});
/// As for surfaces, over the curve's domain or a part of it.
template <int Dimension>
NearestOnCurve<Dimension> closest_point(const NurbsCurve<Dimension>& curve,
                                        const Eigen::Matrix<double, Dimension, 1>& point,
                                        const std::optional<ParameterRange>& part = {});

}  // namespace recede
