#include <recede/geometry/bilinear_patch.h>

#include <algorithm>
#include <cmath>

namespace recede {

Vec3 BilinearPatch::point(double u, double v) const {
  return (1 - v) * ((1 - u) * p00 + u * p10) + v * ((1 - u) * p01 + u * p11);
}

Vec3 BilinearPatch::derivative_u(double v) const { return (1 - v) * (p10 - p00) + v * (p11 - p01); }

Vec3 BilinearPatch::derivative_v(double u) const { return (1 - u) * (p01 - p00) + u * (p11 - p10); }

Vec3 BilinearPatch::normal(double u, double v) const {
  return derivative_u(v).cross(derivative_v(u)).stableNormalized();
}

Box3 BilinearPatch::bounds() const {
  Box3 box;
  return box.extend(p00).extend(p10).extend(p01).extend(p11);
}

namespace {

/// Its sign is the side on which the edge from a to b passes the line. Exactly the negative for the edge from
/// b to a.
double cross(const Vec3& a, const Vec3& b) { return a.x() * b.y() - a.y() * b.x(); }

/// How the edge from a to b adds to the turns of an outline around the line: 1 or -1 where it crosses the
/// half plane y = 0, x > 0. `side` is cross(a, b). Exactly the negative for the edge from b to a.
int turn(const Vec3& a, const Vec3& b, double side) {
  if (a.y() <= 0) return b.y() > 0 && side > 0 ? 1 : 0;
  return b.y() <= 0 && side < 0 ? -1 : 0;
}

bool opposite(double a, double b) { return (a < 0 && b > 0) || (a > 0 && b < 0); }

/// first (1-s)^2 + 2 middle s (1-s) + last s^2.
struct Quadratic {
  double first, middle, last;

  /// A root s = numerator / (numerator + denominator); in [0, 1] when both have the same sign.
  struct Root {
    double numerator, denominator;
    double value() const { return numerator / (numerator + denominator); }
    bool in_unit() const {
      return (numerator >= 0 && denominator >= 0) || (numerator <= 0 && denominator <= 0);
    }
  };
  /// The two roots, by the form that doesn't cancel; of complex ones the real part, rather.
  std::array<Root, 2> roots() const {
    const double q = -(middle + std::copysign(std::sqrt(std::max(discriminant(), 0.0)), middle));
    return {Root{q, last}, Root{first, q}};
  }
  double discriminant() const { return middle * middle - first * last; }
  bool changes_sign() const { return opposite(first, last); }
  /// Two roots in [0, 1], given that the ends have no sign change and aren't 0.
  bool has_two_roots() const {
    return opposite(first, middle) && opposite(middle, last) && discriminant() >= 0;
  }
};

/// A patch as the line sees it: corners in sheared coordinates.
class SeenPatch {
 public:
  SeenPatch(const ShearedLine& line, const BilinearPatch& patch)
      : p00_(line.sheared(patch.p00)),
        p10_(line.sheared(patch.p10)),
        p01_(line.sheared(patch.p01)),
        p11_(line.sheared(patch.p11)) {
    const double side_u0 = cross(p00_, p01_), side_u1 = cross(p10_, p11_);
    const double side_v0 = cross(p00_, p10_), side_v1 = cross(p01_, p11_);
    const double diagonal = cross(p00_, p11_), other_diagonal = cross(p10_, p01_);
    in_u_ = {side_u0, (diagonal + other_diagonal) / 2, side_u1};
    in_v_ = {side_v0, (diagonal - other_diagonal) / 2, side_v1};
    turns_ = turn(p00_, p10_, side_v0) + turn(p10_, p11_, side_u1) - turn(p01_, p11_, side_v1) -
             turn(p00_, p01_, side_u0);
    touches_ = side_u0 == 0 || side_u1 == 0 || side_v0 == 0 || side_v1 == 0;
  }

  PatchHits hits() const {
    PatchHits result;
    if (touches_) return hits_with_border();
    if (turns_ != 0) {
      // The outline encloses the line: one hit, at the one root of whichever quadratic changes its sign.
      result.count = 1;
      result.hits[0] = odd_hit();
      return result;
    }
    // No hit, or two: then both quadratics have two roots.
    if (!in_u_.has_two_roots() || !in_v_.has_two_roots()) return result;
    for (const Quadratic::Root& root : in_u_.roots()) {
      add_in_order(result, hit_at_u(root.value()));
    }
    return result;
  }

 private:
  static Quadratic::Root root_in_unit(const Quadratic& quadratic) {
    const std::array<Quadratic::Root, 2> roots = quadratic.roots();
    return roots[0].in_unit() ? roots[0] : roots[1];
  }

  PatchHit odd_hit() const {
    if (in_u_.changes_sign()) return hit_at_u(root_in_unit(in_u_).value());
    if (in_v_.changes_sign()) return hit_at_v(root_in_unit(in_v_).value());
    return nearest_to_a_hit();
  }

  /// The parameter at which the segment from a to b is nearest to the line, in [0, 1].
  static double parameter_on(const Vec3& a, const Vec3& b) {
    const double dx = b.x() - a.x(), dy = b.y() - a.y();
    const double parameter = std::abs(dx) > std::abs(dy) ? -a.x() / dx : -a.y() / dy;
    return parameter > 0 ? std::min(parameter, 1.0) : 0;  // 0 also where both points are one
  }

  PatchHit hit_at_u(double u) const {
    const Vec3 a = (1 - u) * p00_ + u * p10_, b = (1 - u) * p01_ + u * p11_;
    const double v = parameter_on(a, b);
    return {u, v, (1 - v) * a.z() + v * b.z()};
  }

  PatchHit hit_at_v(double v) const {
    const Vec3 a = (1 - v) * p00_ + v * p01_, b = (1 - v) * p10_ + v * p11_;
    const double u = parameter_on(a, b);
    return {u, v, (1 - u) * a.z() + u * b.z()};
  }

  /// The best of all candidates where rounding leaves no sign change although the outline encloses the line.
  PatchHit nearest_to_a_hit() const {
    const std::array<PatchHit, 4> sides{hit_at_u(0), hit_at_u(1), hit_at_v(0), hit_at_v(1)};
    return *std::min_element(sides.begin(), sides.end(), [this](const PatchHit& a, const PatchHit& b) {
      return squared_miss(a) < squared_miss(b);
    });
  }

  double squared_miss(const PatchHit& hit) const {
    const Vec3 point = BilinearPatch{p00_, p10_, p01_, p11_}.point(hit.u, hit.v);
    return point.head<2>().squaredNorm();
  }

  /// The line passes some side at distance 0: hits of the border are looked for one by one.
  PatchHits hits_with_border() const {
    PatchHits result;
    const auto add = [&result](const PatchHit& hit) { add_in_order(result, hit); };
    if (lies_on(p00_, p01_, in_u_.first)) add(hit_at_u(0));
    if (lies_on(p10_, p11_, in_u_.last)) add(hit_at_u(1));
    if (lies_on(p00_, p10_, in_v_.first)) add(hit_at_v(0));
    if (lies_on(p01_, p11_, in_v_.last)) add(hit_at_v(1));
    if (in_u_.first != 0 || in_u_.middle != 0 || in_u_.last != 0) {
      for (const Quadratic::Root& root : in_u_.roots()) add_inside(root, &SeenPatch::hit_at_u, add);
    } else {
      for (const Quadratic::Root& root : in_v_.roots()) add_inside(root, &SeenPatch::hit_at_v, add);
    }
    if (result.count == 0 && turns_ != 0) add(odd_hit());
    return result;
  }

  /// Keeps the first and the last; a corner that two sides find counts once.
  static void add_in_order(PatchHits& result, const PatchHit& hit) {
    PatchHit &first = result.hits[0], &last = result.hits[1];
    if (result.count == 0) {
      first = last = hit;
      result.count = 1;
    } else if (hit != first && hit != last) {
      if (hit.t < first.t) {
        first = hit;
      } else if (result.count == 1 || hit.t > last.t) {
        last = hit;
      }
      result.count = 2;
    }
  }

  static bool lies_on(const Vec3& a, const Vec3& b, double side) {
    if (side != 0 || a.head<2>() == b.head<2>()) return false;
    return a.head<2>().dot(b.head<2>()) <= 0;
  }

  template <typename Add>
  void add_inside(const Quadratic::Root& root, PatchHit (SeenPatch::*hit_at)(double) const, Add&& add) const {
    const double parameter = root.value();
    if (!(parameter > 0 && parameter < 1)) return;
    const PatchHit hit = (this->*hit_at)(parameter);
    if (hit.u > 0 && hit.u < 1 && hit.v > 0 && hit.v < 1) add(hit);
  }

  Vec3 p00_, p10_, p01_, p11_;
  Quadratic in_u_{}, in_v_{};
  int turns_ = 0;
  bool touches_ = false;
};

}  // namespace

PatchRay::PatchRay(const Vec3& origin, const Vec3& direction) : line_(origin, direction) {}

PatchHits PatchRay::all_hits(const BilinearPatch& patch) const { return SeenPatch(line_, patch).hits(); }

std::optional<PatchHit> PatchRay::nearest_hit(const BilinearPatch& patch, double t_min, double t_max) const {
  const PatchHits found = all_hits(patch);
  for (int i = 0; i < found.count; ++i) {
    const PatchHit& hit = found.hits[static_cast<std::size_t>(i)];
    if (hit.t >= t_min && hit.t <= t_max) return hit;
  }
  return {};
}

}  // namespace recede
