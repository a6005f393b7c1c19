#include "meshes.h"
#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <random>

namespace recede {
namespace {

PolygonSoup moved(PolygonSoup soup, const Vec3& by) {
  for (Vec3& p : soup.positions) p += by;
  return soup;
}

PolygonSoup random_triangles(unsigned seed, std::size_t n, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  PolygonSoup soup;
  for (Index t = 0; t < n; ++t) {
    const Vec3 center = point();
    for (int i = 0; i < 3; ++i) soup.positions.push_back(center + size * point());
    soup.add_face(std::vector<Index>{3 * t, 3 * t + 1, 3 * t + 2});
  }
  return soup;
}

double brute_force_distance(const Vec3& p, const PolygonSoup& soup) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const auto v = soup.face(f);
    const Triangle t{soup.positions[v[0]], soup.positions[v[1]], soup.positions[v[2]]};
    nearest = std::min(nearest, (closest_point_on_triangle(p, t) - p).norm());
  }
  return nearest;
}

TEST(ClosestPoint, LiesOnCornerSideOrInside) {
  const Triangle t{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  EXPECT_EQ(closest_point_on_triangle({-1, -1, 5}, t), Vec3(0, 0, 0));
  EXPECT_EQ(closest_point_on_triangle({3, -1, 5}, t), Vec3(2, 0, 0));
  EXPECT_EQ(closest_point_on_triangle({-1, 3, 5}, t), Vec3(0, 2, 0));
  EXPECT_EQ(closest_point_on_triangle({1, -1, 5}, t), Vec3(1, 0, 0));
  EXPECT_EQ(closest_point_on_triangle({2, 2, 5}, t), Vec3(1, 1, 0));
  EXPECT_EQ(closest_point_on_triangle({0.5, 0.5, -3}, t), Vec3(0.5, 0.5, 0));
}

TEST(ClosestPoint, TrianglesWithoutAreaAreSegmentsAndPoints) {
  EXPECT_EQ(closest_point_on_triangle({1, 1, 0}, {{0, 0, 0}, {3, 0, 0}, {2, 0, 0}}), Vec3(1, 0, 0));
  EXPECT_EQ(closest_point_on_triangle({2.5, 1, 0}, {{0, 0, 0}, {2, 0, 0}, {3, 0, 0}}), Vec3(2.5, 0, 0));
  EXPECT_EQ(closest_point_on_triangle({1, 1, 0}, {{5, 0, 0}, {5, 0, 0}, {5, 0, 0}}), Vec3(5, 0, 0));
}

TEST(ClosestPoint, TreeAgreesWithBruteForceWhateverTheHint) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const PolygonSoup soup = random_triangles(seed, seed * 7, seed % 3 == 0 ? 1.0 : 0.1);
    const ClosestPointTree tree(soup.positions, soup.corner_vertices);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-2, 2);
    Index hint = k_no_index;
    for (int i = 0; i < 50; ++i) {
      const Vec3 p(unit(random), unit(random), unit(random));
      const auto hit = tree.closest(p, hint);
      // The same operations on the same triangle: equal but for the square root.
      EXPECT_NEAR(std::sqrt(hit.squared_distance), brute_force_distance(p, soup), 1e-14);
      hint = static_cast<Index>(random() % soup.n_faces());
    }
  }
}

TEST(MeshDistance, EqualSurfacesAreAtNoDistance) {
  const PolygonSoup sphere = make_displaced_sphere(2000, true);
  const MeshDistance d = measure_distance(sphere, sphere, {.bound_tolerance = 0.1});
  // Nearest points are recomputed from barycentric coordinates of size 1.
  EXPECT_LT(d.max, 1e-15);
  EXPECT_LT(*d.max_bound, 1e-11) << "the floor of the search is 1e-12 of the diagonal";
}

TEST(MeshDistance, AShiftedSquareIsAtTheShift) {
  const PolygonSoup square = test::grid(1);
  const MeshDistance d =
      measure_distance(square, moved(square, {0, 0, 0.25}), {.samples = 1000, .bound_tolerance = 0.01});
  EXPECT_DOUBLE_EQ(d.max, 0.25);
  EXPECT_NEAR(d.rms, 0.25, 1e-12);
  EXPECT_NEAR(d.forward.mean, 0.25, 1e-12);
  EXPECT_GE(*d.max_bound, 0.25);
  EXPECT_LE(*d.max_bound, 0.25 / 0.99 + 1e-12);
  EXPECT_DOUBLE_EQ(d.samples_per_unit_area, 1000);
}

// A square with a needle in its middle: only the side that has the needle sees it.
TEST(MeshDistance, TakesTheLargerSide) {
  const PolygonSoup square = test::grid(2, true);
  PolygonSoup needle = square;
  needle.positions[4].z() = 3;  // the vertex in the middle
  const MeshDistance d = measure_distance(square, needle, {.bound_tolerance = 0.01});
  EXPECT_DOUBLE_EQ(d.backward.max, 3);
  EXPECT_LT(d.forward.max, 0.6);
  EXPECT_DOUBLE_EQ(d.max, 3);
  EXPECT_EQ(d.backward.at, Vec3(0.5, 0.5, 3));
  EXPECT_LE(*d.max_bound, 3 / 0.99 + 1e-12);
}

TEST(MeshDistance, SurfacesAtDifferentResolutionOfOnePlaneAreEqual) {
  // 7 and 16 cells share no lines but the border, so that every piece has to be cut along them.
  const MeshDistance d =
      measure_distance(test::grid(7, true), test::grid(16, true), {.bound_tolerance = 0.1});
  EXPECT_LT(*d.max_bound, 1e-11);
}

TEST(MeshDistance, TheBoundHoldsAndIsAsTightAsAsked) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const PolygonSoup a = random_triangles(seed, 30, 0.5), b = random_triangles(seed + 100, 30, 0.5);
    for (const double tolerance : {0.3, 0.05, 0.005}) {
      const MeshDistance d = measure_distance(a, b, {.samples = 300, .bound_tolerance = tolerance});
      EXPECT_LE(d.max, d.max_lower);
      EXPECT_LE(*d.max_bound - d.max_lower, tolerance * *d.max_bound * (1 + 1e-12));
      // Dense brute force is a lower bound of the true maximum, which the certified bound must not fall
      // below.
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> unit(0, 1);
      for (std::size_t f = 0; f < a.n_faces(); ++f) {
        for (int i = 0; i < 40; ++i) {
          double u = unit(random), v = unit(random);
          if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
          }
          const auto c = a.face(f);
          const Vec3 p = a.positions[c[0]] + u * (a.positions[c[1]] - a.positions[c[0]]) +
                         v * (a.positions[c[2]] - a.positions[c[0]]);
          ASSERT_LE(brute_force_distance(p, b), *d.max_bound);
        }
      }
    }
  }
}

TEST(MeshDistance, GrowsWithTheUnitAndNotWithThePlace) {
  const PolygonSoup a = make_displaced_sphere(1000, true), b = make_displaced_sphere(500, true);
  const MeshDistance here = measure_distance(a, b, {.samples = 20'000, .bound_tolerance = 0.1});
  const auto scaled = [](PolygonSoup soup, double by) {
    for (Vec3& p : soup.positions) p *= by;
    return soup;
  };
  const MeshDistance small =
      measure_distance(scaled(a, 0x1p-30), scaled(b, 0x1p-30), {.samples = 20'000, .bound_tolerance = 0.1});
  // Powers of two scale without rounding.
  EXPECT_DOUBLE_EQ(small.max, 0x1p-30 * here.max);
  EXPECT_DOUBLE_EQ(small.rms, 0x1p-30 * here.rms);
  EXPECT_NEAR(*small.max_bound, 0x1p-30 * *here.max_bound, 1e-9 * 0x1p-30);
  const MeshDistance there = measure_distance(moved(a, {1e6, 1e6, 1e6}), moved(b, {1e6, 1e6, 1e6}),
                                              {.samples = 20'000, .bound_tolerance = 0.1});
  // At 1e6, coordinates have steps of 1e-10.
  EXPECT_NEAR(there.max, here.max, 1e-8);
  EXPECT_NEAR(*there.max_bound, *here.max_bound, 0.1 * *here.max_bound);
}

// Squared lengths of these would overflow and underflow; powers of two scale without rounding.
TEST(MeshDistance, HoldsForTheLargestAndSmallestModels) {
  const PolygonSoup a = make_displaced_sphere(300, true), b = make_displaced_sphere(100, true);
  const DistanceOptions options{.samples = 1000, .bound_tolerance = 0.1};
  const MeshDistance here = measure_distance(a, b, options);
  for (const int exponent : {900, -900}) {
    PolygonSoup c = a, d = b;
    for (PolygonSoup* soup : {&c, &d}) {
      for (Vec3& p : soup->positions) p *= std::ldexp(1.0, exponent);
    }
    const MeshDistance there = measure_distance(c, d, options);
    EXPECT_EQ(there.max, std::ldexp(here.max, exponent));
    EXPECT_EQ(there.rms, std::ldexp(here.rms, exponent));
    EXPECT_EQ(*there.max_bound, std::ldexp(*here.max_bound, exponent));
  }
}

TEST(MeshDistance, SameNumbersForAnyNumberOfThreads) {
  const PolygonSoup a = make_displaced_sphere(4000, true), b = make_displaced_sphere(1000, false);
  std::vector<MeshDistance> results;
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(measure_distance(a, b, {.samples = 10'000, .bound_tolerance = 0.05}));
  }
  EXPECT_EQ(results[0].max, results[1].max);
  EXPECT_EQ(results[0].rms, results[1].rms);
  EXPECT_EQ(*results[0].max_bound, *results[1].max_bound);
}

TEST(MeshDistance, NeedsTwoSurfaces) {
  const PolygonSoup square = test::grid(1), nothing;
  EXPECT_THROW(measure_distance(square, nothing), InputError);
  EXPECT_THROW(measure_distance(nothing, square), InputError);
  EXPECT_THROW(measure_distance(square, square, {.bound_tolerance = 0.0}), OptionError);
}

}  // namespace
}  // namespace recede
