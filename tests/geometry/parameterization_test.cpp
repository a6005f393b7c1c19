#include "input_errors.h"
#include "meshes.h"
#include <recede/geometry/detail/simple_polygon.h>
#include <recede/geometry/error.h>
#include <recede/geometry/parameterization.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <numbers>
#include <random>

namespace recede {
namespace {

using ::testing::HasSubstr;

constexpr ParameterizationOptions k_circle = {.border = DiskBorder::circle};
constexpr ParameterizationOptions k_ellipse = {.border = DiskBorder::ellipse};

/// A cap of a sphere, from the pole to `angle`: rings of 6 k vertices, k = 1 to `rings`, around one vertex.
PolygonSoup cap(Index rings, double angle) {
  PolygonSoup soup = test::soup_of({{0, 0, 1}}, {});
  const auto vertex = [](Index ring, Index i) {
    return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + i % (6 * ring);
  };
  for (Index ring = 1; ring <= rings; ++ring) {
    const double polar = angle * ring / rings;
    for (Index i = 0; i < 6 * ring; ++i) {
      const double around = std::numbers::pi * i / (3.0 * ring);
      soup.positions.emplace_back(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                                  std::cos(polar));
      const Index inner = i - i / ring;  // where a spoke of the hexagon begins, a ring gains a vertex
      soup.add_face(std::vector<Index>{vertex(ring, i), vertex(ring, i + 1), vertex(ring - 1, inner)});
      if (i % ring != ring - 1) {
        soup.add_face(
            std::vector<Index>{vertex(ring, i + 1), vertex(ring - 1, inner + 1), vertex(ring - 1, inner)});
      }
    }
  }
  return soup;
}

Parameterization map_of(const PolygonSoup& soup, const ParameterizationOptions& options = {}) {
  return parameterize_disk(soup.positions, triangulate(soup), options);
}

/// Vertices moved by a noise, every direction alike.
PolygonSoup jittered(PolygonSoup soup, double amount, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-amount, amount);
  for (Vec3& p : soup.positions) p += Vec3(noise(random), noise(random), noise(random));
  return soup;
}

TEST(Parameterization, MeanValueWeightsReproduceTheVertex) {
  const Vec3 v(0.1, 0.1, 0);
  const std::array<Vec3, 4> ring = {Vec3(1, 0, 0), Vec3(0.2, 1, 0), Vec3(-1, 0.3, 0), Vec3(-0.4, -1, 0)};
  const std::vector<double> weights = mean_value_weights(v, ring);
  const double expected[] = {0.325153, 0.264207, 0.189564, 0.221076};
  Vec3 mean = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(weights[i], expected[i], 5e-7);
    mean += weights[i] * ring[i];
  }
  EXPECT_LT((mean - v).norm(), 1e-15);
}

TEST(Parameterization, MeanValueWeightsStayPositiveOnDegenerateRings) {
  const Vec3 v(0, 0, 0);
  const std::array<Vec3, 5> ring = {Vec3(1, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 0), Vec3(-1, 0, 0),
                                    Vec3(0, 1e-300, 0)};
  double sum = 0;
  for (const double weight : mean_value_weights(v, ring)) {
    EXPECT_GT(weight, 0);
    sum += weight;
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(Parameterization, ARegularHexagonMapsToItself) {
  const PolygonSoup soup = cap(1, 1e-8);
  const Parameterization map = map_of(soup, k_circle);
  EXPECT_EQ(map.flipped, 0u);
  EXPECT_LT(map.uvs[0].norm(), 1e-12);
  for (int i = 0; i < 6; ++i) {
    const double angle = std::numbers::pi * i / 3;
    EXPECT_LT((map.uvs[std::size_t(i) + 1] - Vec2(std::cos(angle), std::sin(angle))).norm(), 1e-12);
  }
  EXPECT_NEAR(map.stretch.l2, 1, 1e-9);
  EXPECT_NEAR(map.stretch.l_infinity, 1, 1e-9);
}

TEST(Parameterization, BorderArcsAreProportionalToEdgesAndTheInsideLiesInTheCircle) {
  const PolygonSoup soup = jittered(test::grid(9, true), 0.02, 5);
  const Parameterization map = map_of(soup, k_circle);
  EXPECT_EQ(map.flipped, 0u);
  const auto on_border = [](std::size_t v) { return v < 10 || v >= 90 || v % 10 == 0 || v % 10 == 9; };
  double perimeter = 0, arcs = 0;
  std::vector<std::pair<double, double>> edges;  // length, arc
  for (const auto& [edge, count] : test::edge_counts(soup)) {
    if (count != 1) continue;
    const double length = (soup.positions[edge.first] - soup.positions[edge.second]).norm();
    const double arc = std::acos(std::clamp(map.uvs[edge.first].dot(map.uvs[edge.second]), -1.0, 1.0));
    edges.emplace_back(length, arc);
    perimeter += length;
    arcs += arc;
  }
  EXPECT_NEAR(arcs, 2 * std::numbers::pi, 1e-9);
  for (const auto& [length, arc] : edges) EXPECT_NEAR(arc, arcs * length / perimeter, 1e-9);
  for (std::size_t v = 0; v < map.uvs.size(); ++v) {
    if (on_border(v)) {
      EXPECT_NEAR(map.uvs[v].norm(), 1, 1e-12);
    } else {
      EXPECT_LT(map.uvs[v].norm(), 1);
    }
  }
  EXPECT_EQ(map.uvs[0], Vec2(1, 0));
}

TEST(Parameterization, InnerVerticesAreTheWeightedMeanOfTheirRing) {
  const PolygonSoup soup = jittered(cap(1, 0.7), 0.2, 3);
  const Parameterization map = map_of(soup, k_circle);
  const std::vector<double> weights =
      mean_value_weights(soup.positions[0], std::span(soup.positions).subspan(1));
  Vec2 mean = Vec2::Zero();
  for (std::size_t i = 0; i < 6; ++i) mean += weights[i] * map.uvs[i + 1];
  EXPECT_LT((mean - map.uvs[0]).norm(), 1e-14);
}

TEST(Parameterization, StretchOfAnAffineMapIsThatOfItsSingularValues) {
  const PolygonSoup soup = test::grid(3, true);
  std::vector<Vec2> uvs;
  for (const Vec3& p : soup.positions) uvs.emplace_back(2 * p.x(), 0.5 * p.y());
  const std::vector<Index> triangles = triangulate(soup);
  // Singular values of plane to surface: 1/2 and 2, areas equal.
  const Stretch stretch = measure_stretch(soup.positions, uvs, triangles);
  EXPECT_NEAR(stretch.l2, std::sqrt((0.25 + 4) / 2), 1e-12);
  EXPECT_NEAR(stretch.l_infinity, 2, 1e-12);
  for (Vec2& uv : uvs) uv *= 7;  // scale doesn't count
  EXPECT_NEAR(measure_stretch(soup.positions, uvs, triangles).l2, stretch.l2, 1e-12);
}

TEST(Parameterization, AnEllipseStretchesALongSheetLess) {
  PolygonSoup soup = test::grid(12, true);
  for (Vec3& p : soup.positions) p.x() *= 8;
  const Parameterization circle = map_of(soup, k_circle), ellipse = map_of(soup, k_ellipse);
  EXPECT_EQ(ellipse.flipped, 0u);
  EXPECT_GT(circle.stretch.l2, 2);
  EXPECT_LT(ellipse.stretch.l2, 0.75 * circle.stretch.l2);
  // No affine map of the same area does better.
  for (int i = 0; i < 36; ++i) {
    const double angle = std::numbers::pi * i / 36;
    const Eigen::Rotation2Dd turn(angle);
    std::vector<Vec2> uvs;
    for (const Vec2& uv : ellipse.uvs) {
      uvs.push_back(turn * Vec2(1.05, 1 / 1.05).asDiagonal() * turn.inverse() * uv);
    }
    EXPECT_GT(measure_stretch(soup.positions, uvs, triangulate(soup)).l2, ellipse.stretch.l2);
  }
}

TEST(Parameterization, AFlatSurfaceKeepsItsShapeWhateverItsBorder) {
  PolygonSoup soup = test::grid(12, true);
  soup.corner_vertices.resize(soup.corner_vertices.size() - 6);  // one corner is missing
  soup.face_offsets.resize(soup.face_offsets.size() - 2);
  soup.positions.pop_back();
  const Eigen::AngleAxisd turn(1.1, Vec3(1, 2, -0.5).normalized());
  for (Vec3& p : soup.positions) p = turn * Vec3(3 * p.x(), p.y(), 0) + Vec3(5, 6, 7);
  const Parameterization map = map_of(soup);
  EXPECT_EQ(map.border, DiskBorder::natural);
  EXPECT_EQ(map.flipped, 0u);
  EXPECT_NEAR(map.stretch.l_infinity, 1, 1e-9);
}

TEST(Parameterization, ABorderThatWouldCrossItselfBecomesAnEllipse) {
  // A spiral staircase of one turn and a half, seen from above.
  PolygonSoup soup = test::grid(24, true);
  for (Vec3& p : soup.positions) {
    const double angle = 3 * std::numbers::pi * p.x();
    p = {(1 + p.y()) * std::cos(angle), (1 + p.y()) * std::sin(angle), 0.3 * p.x()};
  }
  const Parameterization map = map_of(soup);
  EXPECT_EQ(map.border, DiskBorder::ellipse);
  EXPECT_EQ(map.flipped, 0u);
}

TEST(Parameterization, StretchRoundsLowerTheStretchOfADeepCap) {
  const PolygonSoup soup = cap(12, 2.2);
  const Parameterization plain = map_of(soup, k_circle);
  const Parameterization better = map_of(soup, {.border = DiskBorder::circle, .stretch_rounds = 5});
  EXPECT_EQ(plain.flipped, 0u);
  EXPECT_EQ(better.flipped, 0u);
  EXPECT_LT(better.stretch.l2, 0.9 * plain.stretch.l2);
}

TEST(Parameterization, RandomSurfacesMapWithoutFlips) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const double noise : {0.05, 0.3, 3.0}) {
      const PolygonSoup soup = jittered(cap(8, 1.5), noise, seed);
      for (const auto weights : {ParameterizationWeights::mean_value, ParameterizationWeights::uniform}) {
        const Parameterization map = map_of(soup, {.weights = weights});
        EXPECT_EQ(map.flipped, 0u) << "seed " << seed << ", noise " << noise;
        EXPECT_LE(map.stretch.l2,
                  map_of(soup, {.weights = weights, .border = DiskBorder::ellipse}).stretch.l2);
        EXPECT_GE(map.stretch.l2, 1);
        EXPECT_GE(map.stretch.l_infinity, map.stretch.l2);
        EXPECT_TRUE(std::isfinite(map.stretch.l_infinity));
      }
    }
  }
}

TEST(Parameterization, UniformWeightsTakeOverWhereNumbersFlipTriangles) {
  // In far apart rings a vertex hardly feels the ones above and below.
  const PolygonSoup soup = test::finger(20, 30);
  const Parameterization map = map_of(soup);
  EXPECT_EQ(map.weights, ParameterizationWeights::uniform);
  EXPECT_EQ(map.flipped, 0u);
  // Where the range of numbers ends there is nothing to be done, and it is said.
  const Parameterization longer = map_of(test::finger(300, 30));
  EXPECT_GT(longer.flipped, 0u);
  for (const Vec2& uv : longer.uvs) EXPECT_TRUE(uv.allFinite());
}

TEST(Parameterization, FacesWithoutAreaDoNoHarm) {
  PolygonSoup soup = test::grid(10, true);
  for (Vec3& p : soup.positions) p = {std::floor(3 * p.x()) / 3, std::floor(2 * p.y()) / 2, 0};
  const Parameterization map = map_of(soup);
  EXPECT_EQ(map.flipped, 0u);
  for (const Vec2& uv : map.uvs) EXPECT_TRUE(uv.allFinite());
}

TEST(Parameterization, WhatIsNoDiskIsRefusedByName) {
  const auto refusal = [](const PolygonSoup& soup) {
    return test::error_text([&] { parameterize_disk(soup.positions, triangulate(soup)); });
  };
  EXPECT_THAT(refusal(make_displaced_sphere(100, true)), HasSubstr("no border"));
  PolygonSoup ring = test::prism(6);
  ring.corner_vertices.resize(24);  // without its ends
  ring.face_offsets.resize(7);
  EXPECT_THAT(refusal(ring), HasSubstr("more than one border"));
  PolygonSoup two = test::grid(1, true);
  for (int i = 0; i < 3; ++i) two.positions.emplace_back(5 + i, i * i, 0);
  EXPECT_THAT(refusal(two), HasSubstr("no triangle uses vertex 4"));
  two.add_face(std::vector<Index>{4, 5, 6});
  EXPECT_THAT(refusal(two), HasSubstr("more than one piece"));
  PolygonSoup wrong = test::grid(1, true);
  std::swap(wrong.corner_vertices[0], wrong.corner_vertices[1]);
  EXPECT_THAT(refusal(wrong), HasSubstr("disagree in orientation"));
}

TEST(SimplePolygon, DoesntTouchItself) {
  using detail::is_simple_polygon;
  EXPECT_TRUE(is_simple_polygon({{0, 0}, {2, 0}, {1, 0.5}, {2, 1}, {0, 1}}));
  EXPECT_FALSE(is_simple_polygon({{0, 0}, {1, 1}, {1, 0}, {0, 1}})) << "crosses";
  EXPECT_FALSE(is_simple_polygon({{0, 0}, {2, 0}, {2, 1}, {1, 0}, {0, 1}})) << "a corner on a side";
  EXPECT_FALSE(is_simple_polygon({{0, 0}, {2, 0}, {1, 0}, {1, 1}})) << "runs back";
  EXPECT_FALSE(is_simple_polygon({{0, 0}, {1, 0}, {1, 0}, {1, 1}})) << "a side without length";
  EXPECT_FALSE(is_simple_polygon({{0, 0}, {1, 0}}));
}

}  // namespace
}  // namespace recede
