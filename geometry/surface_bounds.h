// What a NURBS surface can't exceed: boxes, derivatives and normals over any rectangle of its parameters.
//
// Over a polynomial patch, derivatives stay within the hull of their control points (The NURBS Book, 1.3);
// those of rational patches are bounded by interval arithmetic on such hulls. Patches are halved until the
// bounds are near to what they bound.
#pragma once

#include <recede/geometry/bezier_patches.h>

#include <cstdint>

namespace recede {

/// Upper bounds of the lengths of derivatives.
struct DerivativeBounds {
  double u = 0, v = 0, uu = 0, uv = 0, vv = 0;
};

/// All unit normals are within the angle of the axis. Normals point along du x dv.
struct NormalCone {
  Vec3 axis = Vec3::UnitZ();
  double angle = 4;  ///< radians; above pi: nothing is known, as where a side of the surface is one point
};

/// A bound of a deviation, and how it shrinks: to a fourth of `bend` and a half of `kink` over triangles of
/// half the size in the same place.
struct DeviationBound {
  double bend = 0, kink = 0;
  double total() const { return bend + kink; }
};

class SurfaceBounds {
 public:
  /// Deviations below `finest`, in units of the surface, aren't looked at more closely. 0: a millionth of its
  /// size.
  explicit SurfaceBounds(const BezierPatches& surface, double finest = 0);

  /// Holds the surface over a part of its domain.
  Box3 box(const ParameterBox& part) const;
  /// At most the distance of any point of that part.
  double distance(const ParameterBox& part, const Vec3& point) const;
  DerivativeBounds derivatives(const ParameterBox& part) const;
  NormalCone normal_cone(const ParameterBox& part) const;

  /// At least the distance of any point of the surface from the point of equal parameters on a triangle
  /// with corners on the surface. Second derivatives over the triangle's box, with sides w and h, are taken
  /// as a metric `(uu + uv h/w) du^2 + (vv + uv w/h) dv^2`; half of the squared radius of the smallest circle
  /// around the triangle in it bounds the distance. That is an eighth of `w^2 uu + 2 w h uv + h^2 vv` for
  /// triangles with a right angle (Filip, Magedson and Markot 1986, "Surface algorithms using bounds on
  /// derivatives"), and less for acute ones. Where a derivative jumps at a line of knots, a fourth of the
  /// jump times the side is added. Stops to look closer when below `enough`.
  DeviationBound deviation(const std::array<Vec2, 3>& triangle, double enough = 0) const;
  /// The same for a chord.
  double deviation(const Vec2& from, const Vec2& to, double enough = 0) const;

 private:
  struct Node {
    std::array<float, 3> lower, upper;
    std::array<float, 5> derivatives;  // u, v, uu, uv, vv
    std::array<float, 4> cone;         // axis and angle
    float jump;                        // of the derivative along `axis` where its children meet
    std::array<float, 2> jumps;        // along u and v: all of those in it
    double split;                      // where its children meet
    std::uint32_t first_child;         // the other one follows; 0: it has none
    std::uint32_t axis;                // along which they lie
  };
  class Builder;

  template <typename Visit>
  void visit(const ParameterBox& part, Visit&& visit) const;

  std::vector<Node> nodes_;
  ParameterBox domain_;
  Vec3 origin_;  // of the boxes
};

}  // namespace recede
