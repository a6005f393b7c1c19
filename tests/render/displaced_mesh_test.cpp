#include "chart_sphere.h"
#include "displaced_rays.h"
#include <recede/geometry/error.h>
#include <recede/render/detail/displaced_data.h>
#include <recede/render/displaced_mesh.h>

#include <gmock/gmock.h>

#include <random>
#include <string>

namespace recede {
namespace {

using test::chart_sphere;
using test::flat_map;
using test::random_ray;
using test::Ray;
using test::rough_map;
using test::unit_square;
using testing::HasSubstr;

TEST(DisplacedMesh, AConstantHeightMovesAPlaneByIt) {
  for (const int level : {0, 1, 3}) {
    DisplacedMeshOptions options;
    options.level = level;
    const DisplacedMesh mesh(unit_square(), flat_map(0.25f), options);
    EXPECT_EQ(mesh.small_triangles(), 2u << (2 * level));
    const auto hit = mesh.first_hit({0.3, 0.6, 2}, {0, 0, -2});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->t, 0.875, 1e-6);  // a float near 1
    EXPECT_NEAR(hit->uv.x(), 0.3, 1e-6);
    EXPECT_NEAR(hit->uv.y(), 0.6, 1e-6);
    EXPECT_EQ(hit->normal, Vec3(0, 0, 1));
    EXPECT_EQ(hit->face, 0u);
    EXPECT_TRUE(mesh.is_hit({0.3, 0.6, 2}, {0, 0, -2}));
    EXPECT_FALSE(mesh.first_hit({0.3, 0.6, 2}, {0, 0, 2}));
    EXPECT_FALSE(mesh.first_hit({0.3, 0.6, 2}, {0, 0, -2}, {.t_min = 0, .t_max = 0.8}));
    EXPECT_FALSE(mesh.is_hit({0.3, 0.6, 2}, {0, 0, -2}, {.t_min = 0.9}));
    EXPECT_FALSE(mesh.first_hit({1.3, 0.6, 2}, {0, 0, -2}));
  }
}

TEST(DisplacedMesh, AHitTellsItsTriangleAndWeights) {
  DisplacedMeshOptions options;
  options.level = 2;
  const PolygonSoup base = unit_square();
  const DisplacedMesh mesh(base, flat_map(0.1f), options);
  std::vector<Index> faces, corners;
  triangulate(base, &faces, &corners);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.01, 0.99);
  for (int k = 0; k < 100; ++k) {
    const Vec2 at(place(random), place(random));
    const auto hit = mesh.first_hit({at.x(), at.y(), 1}, {0, 0, -1});
    ASSERT_TRUE(hit);
    Vec2 mean = Vec2::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
      mean += hit->weights[static_cast<Eigen::Index>(c)] * base.corner_uvs[corners[3 * hit->triangle + c]];
    }
    EXPECT_LT((mean - at).norm(), 1e-6);  // some steps of float at 1
    EXPECT_LT((hit->uv - at).norm(), 1e-6);
  }
}

TEST(DisplacedMesh, PointsBetweenTexelsAreBilinear) {
  // Heights 0 and 1 at the middles of two texels, x = 1/4 and 3/4.
  DisplacedMeshOptions options;
  options.level = 6;
  const DisplacedMesh mesh(unit_square(), DisplacementMap(2, 1, {0.0f, 1.0f}), options);
  for (const auto& [x, height] :
       {std::pair(0.125, 0.0), std::pair(0.5, 0.5), std::pair(0.625, 0.75), std::pair(0.875, 1.0)}) {
    const auto hit = mesh.first_hit({x, 0.4, 2}, {0, 0, -1});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->t, 2 - height, 1e-6) << x;
  }
}

TEST(DisplacedMesh, DirectionsAreMadeUnitLengthBetweenPoints) {
  // Directions at the two ends lean 60 degrees apart; in the middle of the side they sum to less than 1.
  PolygonSoup base = unit_square();
  const double c = std::cos(std::numbers::pi / 6), s = std::sin(std::numbers::pi / 6);
  base.corner_normals = {{-s, 0, c}, {s, 0, c}, {s, 0, c}, {-s, 0, c}};
  DisplacedMeshOptions options;
  options.level = 1;
  const DisplacedMesh mesh(base, flat_map(0.5f), options);
  const PolygonSoup small = mesh.tessellate();
  double highest = 0;
  for (const Vec3& p : small.positions) highest = std::max(highest, p.z());
  EXPECT_NEAR(highest, 0.5, 1e-6);  // interpolated without that, it were 0.433
}

TEST(DisplacedMesh, RaysFromWithinTheShellStartThere) {
  // Row 16 of the specification's table: the camera may stand among the bumps.
  DisplacedMeshOptions options;
  options.level = 5;
  const DisplacedMesh mesh(unit_square(), DisplacementMap(2, 1, {0.0f, 1.0f}), options);
  const auto wall = mesh.first_hit({0.3, 0.5, 0.5}, {1, 0, 0});
  ASSERT_TRUE(wall);
  EXPECT_NEAR(wall->t, 0.2, 1e-6);
  EXPECT_FALSE(mesh.first_hit({0.7, 0.5, 0.5}, {1, 0, 0}));
  const auto from_below = mesh.first_hit({0.7, 0.5, 0.5}, {0, 0, 1});
  ASSERT_TRUE(from_below);
  EXPECT_NEAR(from_below->t, 0.4, 1e-6);
}

TEST(DisplacedMesh, AnotherMapOfTheSameSizeTakesThePlaceOfTheFirst) {
  const PolygonSoup base = chart_sphere(2, Vec3::Zero());
  DisplacedMeshOptions options;
  options.level = 3;
  DisplacedMesh mesh(base, rough_map(40, 30, 0, 0.1, MapBorder::clamped, 1), options);
  const DisplacementMap other = rough_map(40, 30, -0.3, 0.4, MapBorder::clamped, 2);
  mesh.set_map(other);
  const DisplacedMesh fresh(base, other, options);
  std::mt19937 random(4);
  for (int k = 0; k < 500; ++k) {
    const Ray ray = random_ray(random, Vec3::Zero());
    const auto a = mesh.first_hit(ray.origin, ray.direction), b = fresh.first_hit(ray.origin, ray.direction);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (a) {
      EXPECT_EQ(a->small, b->small);
    }
  }
  EXPECT_THROW(mesh.set_map(rough_map(41, 30, 0, 1, MapBorder::clamped, 2)), OptionError);
}

TEST(DisplacedMesh, MemoryDoesNotGrowWithTheLevel) {
  const PolygonSoup base = chart_sphere(2, Vec3::Zero());
  const auto memory = [&](int level) {
    DisplacedMeshOptions options;
    options.level = level;
    const DisplacedMesh mesh(base, rough_map(40, 30, 0, 0.1, MapBorder::clamped, 1), options);
    const DisplacedMesh::Memory m = mesh.memory();
    return m.map + m.pyramid + m.base;
  };
  EXPECT_EQ(memory(12), memory(14));
  constexpr std::size_t k_parts = 1 << 16;  // of which Embree may hold boxes
  EXPECT_LE(memory(14), memory(2) + k_parts * sizeof(detail::PatchPart));
}

TEST(DisplacedMesh, TheLevelFollowsTheTexels) {
  // 64 x 64 texels over two triangles: 4^6 small ones each are twice as many as texels.
  const DisplacedMesh mesh(unit_square(), rough_map(64, 64, 0, 0.1, MapBorder::clamped, 1));
  EXPECT_EQ(mesh.small_triangles(), 2u * 4096u);
}

TEST(DisplacedMesh, StrangeRaysMeetNothing) {
  const DisplacedMesh mesh(unit_square(), flat_map(0));
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(mesh.first_hit({0.5, 0.5, 1}, {0, 0, 0}));
  EXPECT_FALSE(mesh.first_hit({0.5, nan, 1}, {0, 0, -1}));
  EXPECT_FALSE(mesh.first_hit({0.5, 0.5, 1}, {0, 0, -inf}));
  EXPECT_FALSE(mesh.is_hit({0.5, 0.5, nan}, {0, 0, -1}));
  EXPECT_FALSE(mesh.is_hit({0.5, 0.5, 1}, {0, 0, 0}));
  const auto tiny = mesh.first_hit({0.25, 0.5, 1}, {0, 0, -1e-30});
  ASSERT_TRUE(tiny);
  EXPECT_NEAR(tiny->t, 1e30, 1e24);
}

TEST(DisplacedMesh, DirectionsOfAnyLengthAndOriginsFromAfarMeetTheSame) {
  const DisplacedMesh mesh(chart_sphere(2, {5, 6, 7}), rough_map(40, 30, 0, 0.2, MapBorder::clamped, 1));
  std::mt19937 random(8);
  for (int k = 0; k < 200; ++k) {
    const Ray ray = random_ray(random, {5, 6, 7});
    const auto hit = mesh.first_hit(ray.origin, ray.direction);
    for (const double length : {1e-30, 1e-3, 1e20}) {
      const auto other = mesh.first_hit(ray.origin, length * ray.direction);
      ASSERT_EQ(other.has_value(), hit.has_value());
      if (hit) {
        EXPECT_NEAR(other->t * length, hit->t, 1e-6);  // some steps of float at the size of the scene
      }
    }
    // A thousand radii away, float would round the origin by half a hundredth of a texel's side.
    const double away = 1000 / ray.direction.norm();
    const auto afar = mesh.first_hit(ray.origin - away * ray.direction, ray.direction);
    ASSERT_EQ(afar.has_value(), hit.has_value());
    if (hit) {
      EXPECT_NEAR(afar->t - away, hit->t, 2e-6);
    }
  }
}

TEST(DisplacedMesh, AMapOfLargerHeightsMayFollow) {
  DisplacedMeshOptions options;
  options.level = 5;
  DisplacedMesh mesh(unit_square(), flat_map(0.1f), options);
  mesh.set_map(flat_map(50));
  const auto hit = mesh.first_hit({0.3, 0.6, 60}, {0, 0, -1});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->t, 10, 1e-4);  // some steps of float at 60
  DisplacedMesh one(unit_square(), DisplacementMap(1, 1, {0.25f}), options);
  one.set_map(DisplacementMap(1, 1, {0.5f}));
  EXPECT_NEAR(one.first_hit({0.3, 0.6, 1}, {0, 0, -1})->t, 0.5, 1e-6);
}

TEST(DisplacedMesh, BadInputIsNamed) {
  const auto message = [](const auto& make) {
    try {
      make();
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  PolygonSoup bare = unit_square();
  bare.corner_uvs.clear();
  EXPECT_THAT(message([&] { DisplacedMesh(bare, flat_map(0)); }), HasSubstr("texture coordinates"));
  PolygonSoup strange = unit_square();
  strange.corner_uvs[2].x() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message([&] { DisplacedMesh(strange, flat_map(0)); }), HasSubstr("finite"));
  EXPECT_THAT(message([&] { DisplacedMesh(PolygonSoup{}, flat_map(0)); }), HasSubstr("faces"));
  PolygonSoup distant = unit_square();
  distant.corner_uvs[3].y() = 1e9;
  EXPECT_THAT(message([&] { DisplacedMesh(distant, flat_map(0)); }), HasSubstr("corner 3 lies more than"));
  DisplacedMeshOptions options;
  options.level = 15;
  EXPECT_THAT(message([&] { DisplacedMesh(unit_square(), flat_map(0), options); }), HasSubstr("0 and 14"));
  options.level = {};
  options.triangle_levels = {1};
  EXPECT_THAT(message([&] { DisplacedMesh(unit_square(), flat_map(0), options); }),
              HasSubstr("1 levels for 2 triangles"));
  options.triangle_levels = {};
  options.level = 14;
  EXPECT_THAT(
      message([&] { DisplacedMesh(chart_sphere(2, Vec3::Zero()), flat_map(0), options).tessellate(); }),
      HasSubstr("small triangles can't be tessellated"));
  const DisplacedMesh mesh(unit_square(), flat_map(0.1f));
  EXPECT_THAT(message([&] {
                mesh.first_hit({0.5, 0.5, 1}, {0, 0, -1}, {.fraction = 0.5});
              }),
              HasSubstr("partial"));
  EXPECT_THAT(message([&] {
                mesh.first_hit({0.5, 0.5, 1}, {0, 0, -1}, {.fraction = 1.5});
              }),
              HasSubstr("between 0 and 1"));
}

}  // namespace
}  // namespace recede
