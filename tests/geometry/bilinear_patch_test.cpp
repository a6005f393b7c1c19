#include "cube_sphere.h"
#include "sanitized.h"
#include <recede/geometry/bilinear_patch.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace recede {
namespace {

const BilinearPatch k_one_corner_up{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}};
const BilinearPatch k_saddle{{0, 0, 0}, {1, 0, 1}, {0, 1, 1}, {1, 1, 0}};
const BilinearPatch k_square{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};

// The specification gives ten digits.
constexpr double k_printed = 1e-10;

class RandomPatches {
 public:
  explicit RandomPatches(unsigned seed) : random_(seed) {}
  double number(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  Vec3 vector() { return {number(-1, 1), number(-1, 1), number(-1, 1)}; }
  BilinearPatch patch() { return {vector(), vector(), vector(), vector()}; }

 private:
  std::mt19937 random_;
};

void expect_on_both(const PatchHit& hit, const BilinearPatch& patch, const Vec3& origin,
                    const Vec3& direction) {
  // Coordinates and t are of the size of 1 to 10 and pass through some ten roundings of 1.1e-16; where the
  // ray touches the patch, the root that cancels loses the digits along the patch, not across it.
  EXPECT_LT((patch.point(hit.u, hit.v) - (origin + hit.t * direction)).norm(), 1e-13);
  EXPECT_TRUE(hit.u >= 0 && hit.u <= 1 && hit.v >= 0 && hit.v <= 1) << hit.u << ' ' << hit.v;
}

TEST(BilinearPatch, HasPointsDerivativesAndNormalOfItsFormula) {
  EXPECT_EQ(k_saddle.point(0.5, 0.5), Vec3(0.5, 0.5, 0.5));
  EXPECT_EQ(k_saddle.point(0, 1), Vec3(0, 1, 1));
  EXPECT_EQ(k_saddle.point(1, 0), Vec3(1, 0, 1));
  // z = u + v - 2uv
  EXPECT_EQ(k_saddle.derivative_u(0.25), Vec3(1, 0, 0.5));
  EXPECT_EQ(k_saddle.derivative_v(1), Vec3(0, 1, -1));
  EXPECT_EQ(k_saddle.normal(0.5, 0.5), Vec3(0, 0, 1));
  EXPECT_EQ((BilinearPatch{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}.normal(0.5, 0.5)), Vec3(0, 0, 0));
  EXPECT_EQ(k_one_corner_up.bounds().min(), Vec3(0, 0, 0));
  EXPECT_EQ(k_one_corner_up.bounds().max(), Vec3(1, 1, 1));
}

TEST(BilinearPatch, IsMetWhereTheSpecificationSays) {
  const auto straight = PatchRay({.5, .5, 2}, {0, 0, -1}).nearest_hit(k_one_corner_up);
  EXPECT_EQ(straight, (PatchHit{.5, .5, 1.75}));
  const auto oblique = PatchRay({.25, .5, 3}, {.1, -.05, -1}).nearest_hit(k_one_corner_up);
  ASSERT_TRUE(oblique);
  EXPECT_NEAR(oblique->u, .5309113834, k_printed);
  EXPECT_NEAR(oblique->v, .3595443083, k_printed);
  EXPECT_NEAR(oblique->t, 2.8091138339, k_printed);
  const auto sloping = PatchRay({-1, -1, .395}, {1, 1, -.01}).nearest_hit(k_saddle);
  ASSERT_TRUE(sloping);
  EXPECT_NEAR(sloping->u, .2575382683, k_printed);
  EXPECT_NEAR(sloping->t, 1.2575382683, k_printed);
}

TEST(BilinearPatch, IsMetTwiceByALevelRayThroughTheSaddle) {
  // The source eliminates by the third coordinate of the direction, which is 0 here.
  const PatchHits found = PatchRay({-1, -1, .375}, {1, 1, 0}).all_hits(k_saddle);
  ASSERT_EQ(found.count, 2);
  EXPECT_EQ(found.hits[0], (PatchHit{.25, .25, 1.25}));
  EXPECT_EQ(found.hits[1], (PatchHit{.75, .75, 1.75}));
}

TEST(BilinearPatch, GivesTheNearestHitWithinTheLimits) {
  const PatchRay ray({-1, -1, .375}, {1, 1, 0});
  EXPECT_EQ(ray.nearest_hit(k_saddle, 1.25, 2)->t, 1.25);
  EXPECT_EQ(ray.nearest_hit(k_saddle, 1.5, 2)->t, 1.75);
  EXPECT_FALSE(ray.nearest_hit(k_saddle, 1.3, 1.7));
  EXPECT_FALSE(ray.nearest_hit(k_saddle, 0, 1));
  const PatchRay backwards({-1, -1, .375}, {-1, -1, 0});
  EXPECT_FALSE(backwards.nearest_hit(k_saddle));
  ASSERT_EQ(backwards.all_hits(k_saddle).count, 2);
  EXPECT_EQ(backwards.all_hits(k_saddle).hits[0].t, -1.75);
}

TEST(BilinearPatch, CountsItsBorderAndCorners) {
  for (const double u : {0.0, 0.25, 0.5, 1.0}) {
    for (const double v : {0.0, 0.25, 0.5, 1.0}) {
      for (const BilinearPatch& patch : {k_square, k_saddle, k_one_corner_up}) {
        const Vec3 point = patch.point(u, v);
        const PatchHits found = PatchRay({u, v, 2}, {0, 0, -1}).all_hits(patch);
        ASSERT_EQ(found.count, 1) << u << ' ' << v;
        EXPECT_EQ(found.hits[0], (PatchHit{u, v, 2 - point.z()}));
      }
    }
  }
  EXPECT_EQ(PatchRay({1.0000001, .5, 1}, {0, 0, -1}).all_hits(k_square).count, 0);
  EXPECT_EQ(PatchRay({2, 0, 1}, {0, 0, -1}).all_hits(k_square).count, 0);  // above the line of a side
}

TEST(BilinearPatch, WithACollapsedSideIsATriangle) {
  const BilinearPatch triangle{{0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {1, 1, 0}};
  for (const double x : {0.1, 0.5, 0.9}) {
    for (const double y : {0.05, 0.4, 0.85}) {
      const auto hit = PatchRay({x, y, 1}, {0, 0, -1}).nearest_hit(triangle);
      EXPECT_EQ(hit.has_value(), y <= x);
      if (!hit) continue;
      expect_on_both(*hit, triangle, {x, y, 1}, {0, 0, -1});
      EXPECT_EQ(hit->t, 1);
    }
  }
  const auto at_corner = PatchRay({0, 0, 1}, {0, 0, -1}).nearest_hit(triangle);
  ASSERT_TRUE(at_corner);
  EXPECT_EQ(at_corner->u, 0);
}

TEST(BilinearPatch, WithoutAreaIsMissedByRaysThatPassBy) {
  const Vec3 a(0, 0, 0), b(1, 2, 3);
  for (const BilinearPatch& patch : {BilinearPatch{a, a, a, a}, BilinearPatch{a, b, a, b},
                                     BilinearPatch{a, a, b, b}, BilinearPatch{a, b, b, a}}) {
    EXPECT_EQ(PatchRay({.5, .5, 9}, {0, 0, -1}).all_hits(patch).count, 0);
    EXPECT_EQ(PatchRay({.5, .3, 9}, {.1, .2, -1}).all_hits(patch).count, 0);
  }
}

TEST(BilinearPatch, IsMissedByRaysParallelToItsPlane) {
  EXPECT_EQ(PatchRay({-1, .5, .1}, {1, 0, 0}).all_hits(k_square).count, 0);
  EXPECT_EQ(PatchRay({-1, .5, -1e-300}, {1, .2, 0}).all_hits(k_square).count, 0);
}

TEST(BilinearPatch, ReportsARayWithinItAtTheBorder) {
  const PatchHits plane = PatchRay({-1, .5, 0}, {1, 0, 0}).all_hits(k_square);
  ASSERT_EQ(plane.count, 2);
  EXPECT_EQ(plane.hits[0], (PatchHit{0, .5, 1}));
  EXPECT_EQ(plane.hits[1], (PatchHit{1, .5, 2}));
  // The saddle holds the straight line u = 1/4.
  const Vec3 from = k_saddle.point(.25, 0), to = k_saddle.point(.25, 1);
  const PatchHits ruling = PatchRay(from - (to - from), to - from).all_hits(k_saddle);
  ASSERT_EQ(ruling.count, 2);
  EXPECT_EQ(ruling.hits[0], (PatchHit{.25, 0, 1}));
  EXPECT_EQ(ruling.hits[1], (PatchHit{.25, 1, 2}));
}

TEST(BilinearPatch, IsMissedByRaysThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(PatchRay({.5, .5, 1}, {0, 0, 0}).all_hits(k_square).count, 0);
  EXPECT_EQ(PatchRay({.5, nan, 1}, {0, 0, -1}).all_hits(k_square).count, 0);
  EXPECT_EQ(PatchRay({.5, .5, 1}, {0, nan, -1}).all_hits(k_square).count, 0);
}

TEST(BilinearPatch, IsMetByRaysToItsPointsAlongEveryAxis) {
  RandomPatches random(5);
  for (int i = 0; i < 20'000; ++i) {
    const BilinearPatch patch = random.patch();
    const Vec3 origin = 5 * random.vector();
    Vec3 direction = patch.point(random.number(0, 1), random.number(0, 1)) - origin;
    if (i % 4 < 3) direction[i % 4] = 0;  // one coordinate vanishes; the target moves along
    const Vec3 target = origin + direction;
    BilinearPatch moved = patch;
    const Vec3 shift = target - patch.point(0.3, 0.6);
    for (Vec3* corner : {&moved.p00, &moved.p10, &moved.p01, &moved.p11}) *corner += shift;
    const PatchHits found = PatchRay(origin, direction).all_hits(moved);
    ASSERT_GE(found.count, 1);
    double off = 1;
    for (int k = 0; k < found.count; ++k) {
      const PatchHit& hit = found.hits[static_cast<std::size_t>(k)];
      expect_on_both(hit, moved, origin, direction);
      off = std::min(off, std::abs(hit.t - 1));
    }
    // The target is met up to the rounding of a root that is nearly double.
    EXPECT_LT(off, 1e-6);
  }
}

/// The roots of the source's quadratic in v, with its two ways to get u and its choice of the pivot
/// corrected, in long double. `safe` is set unless a root lies within 1e-9 of the border or of being double:
/// there, rounding decides whether it counts.
std::vector<double> distances_by_elimination(const BilinearPatch& patch, const Vec3& origin,
                                             const Vec3& direction, bool& safe) {
  using Real = long double;
  int z = 0;
  direction.cwiseAbs().maxCoeff(&z);
  const int x = (z + 1) % 3, y = (z + 2) % 3;
  const auto pair_of = [&](const Vec3& vector, int axis) {
    return Real(vector[axis]) * Real(direction[z]) - Real(vector[z]) * Real(direction[axis]);
  };
  const Vec3 a = patch.p11 - patch.p10 - patch.p01 + patch.p00, b = patch.p10 - patch.p00,
             c = patch.p01 - patch.p00, d = patch.p00 - origin;
  const Real a1 = pair_of(a, x), b1 = pair_of(b, x), c1 = pair_of(c, x), d1 = pair_of(d, x);
  const Real a2 = pair_of(a, y), b2 = pair_of(b, y), c2 = pair_of(c, y), d2 = pair_of(d, y);
  const Real k2 = a2 * c1 - a1 * c2, k1 = a2 * d1 - a1 * d2 + b2 * c1 - b1 * c2, k0 = b2 * d1 - b1 * d2;
  const Real discriminant = k1 * k1 - 4 * k2 * k0;
  constexpr Real k_margin = 1e-9L;
  safe = std::abs(discriminant) > k_margin * (k1 * k1 + std::abs(k2 * k0));
  std::vector<double> found;
  if (discriminant < 0) return found;
  const Real q = -(k1 + std::copysign(std::sqrt(discriminant), k1)) / 2;
  for (const Real v : {q / k2, k0 / q}) {
    const Real one = v * a2 + b2, other = v * (a2 - a1) + b2 - b1;
    const Real u =
        std::abs(other) >= std::abs(one) ? (v * (c1 - c2) + d1 - d2) / other : (-v * c2 - d2) / one;
    const Real outside = std::max({-u, u - 1, -v, v - 1});
    if (!(std::abs(outside) > k_margin)) safe = false;
    if (!(outside < 0)) continue;
    const Real point = u * v * Real(a[z]) + u * Real(b[z]) + v * Real(c[z]) + Real(d[z]);
    found.push_back(static_cast<double>(point / Real(direction[z])));
  }
  std::sort(found.begin(), found.end());
  return found;
}

TEST(BilinearPatch, HasTheHitsOfTheSourcesQuadraticInHigherPrecision) {
  RandomPatches random(11);
  int compared = 0, counts[3] = {0, 0, 0};
  for (int i = 0; i < 100'000; ++i) {
    const BilinearPatch patch = random.patch();
    const Vec3 origin = 2 * random.vector(), direction = 0.7 * random.vector() - origin;
    bool safe = false;
    const std::vector<double> expected = distances_by_elimination(patch, origin, direction, safe);
    const PatchHits found = PatchRay(origin, direction).all_hits(patch);
    for (int k = 0; k < found.count; ++k) {
      expect_on_both(found.hits[static_cast<std::size_t>(k)], patch, origin, direction);
    }
    if (!safe) continue;
    ++compared;
    ASSERT_EQ(found.count, static_cast<int>(expected.size()));
    ++counts[found.count];
    for (std::size_t k = 0; k < expected.size(); ++k) {
      // A root keeps at least the digits that its margin from a double root leaves: 1e-16 / sqrt(1e-9).
      EXPECT_NEAR(found.hits[k].t, expected[k], 1e-10);
    }
  }
  EXPECT_GT(compared, 99'900);
  for (const int count : counts) EXPECT_GT(count, 1'000);
}

TEST(BilinearPatch, KeepsItsHitsWhenCornersAreNamedAnotherWay) {
  RandomPatches random(13);
  for (int i = 0; i < 10'000; ++i) {
    const BilinearPatch p = random.patch();
    const BilinearPatch turned{p.p10, p.p11, p.p00, p.p01}, mirrored{p.p00, p.p01, p.p10, p.p11};
    const PatchRay ray(2 * random.vector(), random.vector());
    const int count = ray.all_hits(p).count;
    EXPECT_EQ(ray.all_hits(turned).count, count);
    EXPECT_EQ(ray.all_hits(mirrored).count, count);
  }
}

/// Rays from near the middle of closed surfaces to their edges and corners, a few steps of the last digit
/// beside them included. Returns how many meet nothing.
int escaping_rays(const Vec3& offset, int n_rays, unsigned seed) {
  const test::CubeSphere sphere = test::make_cube_sphere(6, 0.1, offset, seed);
  RandomPatches random(seed + 1);
  std::mt19937 choice(seed + 2);
  int escaped = 0;
  for (int i = 0; i < n_rays; ++i) {
    const test::CubeSphere::Edge& edge = sphere.edges[choice() % sphere.edges.size()];
    EXPECT_EQ(edge.faces.size(), 2u);
    const bool at_corner = choice() % 8 == 0;
    const double along = at_corner ? 0 : random.number(0, 1);
    const Vec3 origin = offset + (i % 2 == 0 ? Vec3(Vec3::Zero()) : Vec3(0.2 * random.vector()));
    Vec3 target =
        sphere.vertices[edge.from] + along * (sphere.vertices[edge.to] - sphere.vertices[edge.from]);
    for (int axis = 0; axis < 3; ++axis) {
      if (choice() % 2 == 0) target[axis] = std::nextafter(target[axis], random.number(-1e9, 1e9));
    }
    const PatchRay ray(origin, (i % 3 == 0 ? 1 : random.number(0.01, 100)) * (target - origin));
    const auto meets = [&](std::size_t face) { return ray.nearest_hit(sphere.patch(face)).has_value(); };
    if (meets(edge.faces[0]) || meets(edge.faces[1])) continue;
    // Near a corner, a ray may have come to the other patches around it.
    const bool near_corner = std::min(along, 1 - along) < 1e-3;
    bool met = false;
    for (std::size_t face = 0; near_corner && !met && face < sphere.faces.size(); ++face) met = meets(face);
    if (!met) ++escaped;
  }
  return escaped;
}

TEST(BilinearPatch, LetsNoRayThroughBetweenNeighbours) {
  const int n_rays = test::k_sanitized ? 50'000 : 1'000'000;
  for (const double offset : {0.0, 1e3, 1e5}) {
    EXPECT_EQ(escaping_rays(Vec3::Constant(offset), n_rays, 17), 0) << "offset " << offset;
  }
}

}  // namespace
}  // namespace recede
