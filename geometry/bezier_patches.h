// A NURBS surface cut at its knots into rational Bezier patches: evaluated fast, and bounded.
#pragma once

#include <recede/geometry/nurbs.h>

#include <span>

namespace recede {

/// A rectangle of parameters.
using ParameterBox = Eigen::AlignedBox2d;

/// Evaluates a surface at many places. May be used from several threads.
class BezierPatches {
 public:
  /// Throws `InputError` as `validate` does.
  explicit BezierPatches(const NurbsSurface& surface);

  /// As the functions of the same names do for the surface itself.
  Vec3 evaluate(const Vec2& uv) const;
  SurfaceDerivatives derivatives(const Vec2& uv) const;

  /// Unit length, along du x dv, or its limit from inside of the domain where that has no length; (0,0,0)
  /// where there is no limit.
  Vec3 normal(const Vec2& uv) const;

  ParameterBox domain() const;
  std::array<int, 2> degrees() const { return degrees_; }
  bool is_rational() const { return is_rational_; }

  /// Patches along an axis, and where they begin and end: one number more.
  std::size_t n_patches(std::size_t axis) const { return breaks_[axis].size() - 1; }
  std::span<const double> breaks(std::size_t axis) const { return breaks_[axis]; }
  /// The control points of a patch, v fastest. Those of rational surfaces are times their weights, with
  /// these as the fourth coordinate; otherwise the fourth is 1.
  std::vector<Vec4> net(std::size_t patch_u, std::size_t patch_v) const;

 private:
  struct Place {
    std::size_t first;  // of the patch's numbers
    double u, v;        // within it, 0 to 1
    double width, height;
  };
  Place place(const Vec2& uv) const;

  std::array<int, 2> degrees_;
  bool is_rational_;
  std::array<std::vector<double>, 2> breaks_;
  std::vector<double> numbers_;  // patch by patch, point by point, 3 or 4 coordinates
};

}  // namespace recede
