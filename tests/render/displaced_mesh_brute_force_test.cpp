#include "chart_sphere.h"
#include "displaced_rays.h"
#include "ray_leaks.h"
#include "sanitized.h"
#include <recede/render/detail/displaced_data.h>
#include <recede/render/displaced_mesh.h>

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <random>
#include <string>

namespace recede {
namespace {

using detail::DisplacedKernel;
using detail::PatchArrays;
using detail::PatchRayQuery;
using test::chart_sphere;
using test::k_sanitized;
using test::leaks;
using test::random_direction;
using test::random_ray;
using test::Ray;
using test::rough_float_map;
using test::rough_map;
using test::unit_square;

// A ray as the surface traces it.
struct SceneRay {
  PatchRayQuery query{};
  DisplacedMesh::Data::RayScale scale;
};

SceneRay scene_ray(const DisplacedMesh::Data& data, const Ray& ray, double fraction = 1) {
  SceneRay result;
  RTCRay embree{};
  EXPECT_TRUE(data.set_ray(ray.origin, ray.direction, {.fraction = fraction}, embree, result.scale));
  PatchRayQuery& query = result.query;
  const float origin[3] = {embree.org_x, embree.org_y, embree.org_z};
  const float direction[3] = {embree.dir_x, embree.dir_y, embree.dir_z};
  std::copy(origin, origin + 3, query.origin);
  std::copy(direction, direction + 3, query.direction);
  query.t_min = embree.tnear;
  query.t_max = embree.tfar;
  query.fraction = static_cast<float>(fraction);
  return result;
}

PatchRayQuery query_of(const DisplacedMesh::Data& data, const Ray& ray) { return scene_ray(data, ray).query; }

// All small triangles, one by one.
class BruteForce {
 public:
  BruteForce(const DisplacedMesh& mesh, double fraction = 1) : data_(mesh.data()), fraction_(fraction) {
    const PatchArrays arrays = data_.arrays();
    for (std::uint32_t number = 0; number < data_.n_parts(); ++number) {
      const detail::PatchPart part = arrays.parts != nullptr
                                         ? arrays.parts[number]
                                         : detail::PatchPart{number, 0, 0, arrays.patches[number].level};
      const detail::DisplacedPatch& patch = data_.patches.patches[part.patch];
      const std::uint32_t side = 1u << patch.level, size = 1u << part.level;
      const auto point = [&](std::uint32_t i, std::uint32_t j) {
        std::array<float, 3> at{};
        detail::displaced_kernel().point(arrays, part.patch, i, j, static_cast<float>(fraction), at.data());
        return at;
      };
      for (std::uint32_t j = part.j; j < part.j + size; ++j) {
        for (std::uint32_t i = part.i; i < part.i + size; ++i) {
          for (std::uint32_t upper = 0; upper < 2; ++upper) {
            if (patch.is_single && i + j + 1 + upper > side) continue;
            Triangle triangle{number, 2 * (i + side * j) + upper, {}};
            if (upper == 0) {
              triangle.corners = {point(i, j), point(i + 1, j), point(i, j + 1)};
            } else {
              triangle.corners = {point(i + 1, j + 1), point(i, j + 1), point(i + 1, j)};
            }
            triangles_.push_back(triangle);
          }
        }
      }
    }
  }

  struct Hit {
    float t = std::numeric_limits<float>::infinity();  ///< scaled scene
    std::uint64_t small = 0;
    bool found = false;
  };
  Hit first_hit(const Ray& ray) const {
    Hit best;
    const SceneRay start = scene_ray(data_, ray, fraction_);
    for (const Triangle& triangle : triangles_) {
      PatchRayQuery query = start.query;
      query.t_max = best.t;
      query.accepts_equal = !best.found;
      if (!detail::displaced_kernel().test_triangle(triangle.corners[0].data(), triangle.corners[1].data(),
                                                    triangle.corners[2].data(), query))
        continue;
      best = {query.t_max, std::uint64_t{triangle.part} << 32 | triangle.number, true};
    }
    return best;
  }

 private:
  struct Triangle {
    std::uint32_t part, number;
    std::array<std::array<float, 3>, 3> corners;
  };
  const DisplacedMesh::Data& data_;
  double fraction_;
  std::vector<Triangle> triangles_;
};

std::vector<std::uint8_t> mixed_levels(const PolygonSoup& base, int most, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Index> faces;
  triangulate(base, &faces, nullptr);
  std::vector<std::uint8_t> levels(faces.size());
  for (std::uint8_t& level : levels)
    level = static_cast<std::uint8_t>(random() % static_cast<unsigned>(most + 1));
  return levels;
}

struct Case {
  std::string name;
  PolygonSoup base;
  DisplacementMap map;
  DisplacedMeshOptions options;
};

std::vector<Case> cases() {
  std::vector<Case> list;
  const auto add = [&](std::string name, PolygonSoup base, DisplacementMap map, std::optional<int> level) {
    DisplacedMeshOptions options;
    options.level = level;
    options.partial = true;
    list.push_back({std::move(name), std::move(base), std::move(map), options});
  };
  const Vec3 zero = Vec3::Zero();
  add("16 bits", chart_sphere(2, zero), rough_map(40, 30, 0, 0.2, MapBorder::clamped, 1), 3);
  add("downwards", chart_sphere(2, zero), rough_map(40, 30, 0.1, -0.2, MapBorder::clamped, 2), 3);
  add("floats", chart_sphere(2, zero), rough_float_map(17, 23, -0.1, 0.2, MapBorder::clamped, 3), 3);
  add("warped charts", chart_sphere(3, zero, 0.1), rough_map(64, 64, 0, 0.1, MapBorder::clamped, 4), 3);
  add("coarse base", chart_sphere(1, zero), rough_map(64, 64, 0, 0.3, MapBorder::clamped, 5), 4);
  add("few texels", chart_sphere(2, zero), rough_map(3, 2, 0, 0.3, MapBorder::clamped, 6), 4);
  add("one texel", chart_sphere(1, zero), rough_map(1, 1, 0, 0.3, MapBorder::periodic, 7), 2);
  add("no subdivision", chart_sphere(4, zero), rough_map(64, 64, 0, 0.1, MapBorder::clamped, 8), 0);
  add("parts", chart_sphere(1, zero, 0.1), rough_map(64, 64, 0, 0.2, MapBorder::clamped, 20), 6);
  list.back().options.triangle_levels = std::vector<std::uint8_t>{6, 6, 5, 6, 6, 5, 6, 4, 6, 6, 2, 6};
  add("a level of one", chart_sphere(3, zero), rough_map(64, 64, 0, 0.1, MapBorder::clamped, 9), 1);
  PolygonSoup tiled = chart_sphere(2, zero);
  for (Vec2& uv : tiled.corner_uvs) uv = 5.3 * uv - Vec2(1.7, 2.1);
  add("tiled", tiled, rough_map(16, 11, 0, 0.2, MapBorder::periodic, 10), 3);
  add("tiled floats", tiled, rough_float_map(16, 11, -0.1, 0.1, MapBorder::periodic, 11), 3);
  add("beyond the border", tiled, rough_map(16, 11, 0, 0.2, MapBorder::clamped, 12), 3);
  PolygonSoup triangles = chart_sphere(2, zero);
  std::vector<Index> corners;
  triangulate(triangles, nullptr, &corners);
  PolygonSoup lone;  // an odd number of triangles, so that one stays alone at least
  lone.positions = triangles.positions;
  for (std::size_t c = 0; c + 3 < corners.size(); c += 3) {
    std::array<Index, 3> face{};
    for (std::size_t k = 0; k < 3; ++k) {
      face[k] = triangles.corner_vertices[corners[c + k]];
      lone.corner_uvs.push_back(triangles.corner_uvs[corners[c + k]]);
    }
    lone.add_face(face);
  }
  add("lone triangles", lone, rough_map(40, 30, 0, 0.2, MapBorder::clamped, 13), 3);
  add("mixed levels", chart_sphere(2, zero), rough_map(40, 30, 0, 0.2, MapBorder::clamped, 14), std::nullopt);
  list.back().options.triangle_levels = mixed_levels(list.back().base, 4, 1);
  add("mixed levels of lone triangles", lone, rough_map(40, 30, 0, 0.2, MapBorder::clamped, 15),
      std::nullopt);
  list.back().options.triangle_levels = mixed_levels(lone, 4, 2);
  PolygonSoup creased = chart_sphere(1, zero);
  for (Vec3& p : creased.positions) p /= p.cwiseAbs().maxCoeff();
  add("a cube", creased, rough_map(64, 64, 0, 0.2, MapBorder::clamped, 16), 4);
  PolygonSoup folded = unit_square();
  folded.corner_normals = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, 0.6, -0.8}};
  add("directions that cancel out", folded, rough_map(16, 16, -0.5, 0.5, MapBorder::clamped, 17), 4);
  PolygonSoup sliver = unit_square();
  sliver.positions[2] = {0.5, 1e-7, 0};
  add("a sliver", sliver, rough_map(16, 16, 0, 0.3, MapBorder::clamped, 18), 4);
  PolygonSoup collapsed = unit_square();
  collapsed.positions[1] = collapsed.positions[0];
  add("a collapsed side", collapsed, rough_map(16, 16, 0, 0.3, MapBorder::clamped, 21), 5);
  PolygonSoup needle = unit_square();
  needle.positions[1] = {1e-20, 0, 0};
  needle.positions[0] = {0, 0, 0};
  add("a side of almost nothing", needle, rough_map(16, 16, 0, 0.3, MapBorder::clamped, 22), 5);
  add("heights far larger than the base", unit_square(), rough_map(16, 16, -80, 120, MapBorder::clamped, 23),
      5);
  PolygonSoup smeared = unit_square();
  for (Vec2& uv : smeared.corner_uvs) uv = {0.3, 0.4};
  add("one texture coordinate", smeared, rough_map(16, 16, 0, 0.3, MapBorder::clamped, 19), 3);
  return list;
}

class DisplacedCase : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Cases, DisplacedCase, testing::Range(std::size_t{0}, cases().size()),
                         [](const auto& which) {
                           std::string name = cases()[which.param].name;
                           for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name;
                         });

TEST_P(DisplacedCase, TheFirstHitIsThatOfBruteForceOverAllSmallTriangles) {
  const Case c = cases()[GetParam()];
  const DisplacedMesh mesh(c.base, c.map, c.options);
  const int rays = k_sanitized ? 200 : 2000;
  for (const double fraction : {1.0, 0.4, 0.0}) {
    const BruteForce brute(mesh, fraction);
    std::mt19937 random(5);
    for (int k = 0; k < rays; ++k) {
      const Ray ray = random_ray(random, Vec3::Zero());
      const BruteForce::Hit expected = brute.first_hit(ray);
      const auto hit = mesh.first_hit(ray.origin, ray.direction, {.fraction = fraction});
      ASSERT_EQ(hit.has_value(), expected.found) << c.name << " ray " << k << " fraction " << fraction;
      EXPECT_EQ(mesh.is_hit(ray.origin, ray.direction, {.fraction = fraction}), expected.found);
      if (!hit) continue;
      ASSERT_EQ(hit->t, scene_ray(mesh.data(), ray, fraction).scale.t_of(expected.t))
          << c.name << " ray " << k << " fraction " << fraction;
      ASSERT_EQ(hit->small, expected.small) << c.name << " ray " << k << " fraction " << fraction;
    }
  }
}

TEST_P(DisplacedCase, RaysTogetherMeetWhatTheyMeetAlone) {
  const Case c = cases()[GetParam()];
  const DisplacedMesh mesh(c.base, c.map, c.options);
  const DisplacedMesh::Data& data = mesh.data();
  const DisplacedKernel& kernel = detail::displaced_kernel();
  std::mt19937 random(6);
  for (int k = 0; k < (k_sanitized ? 20 : 200); ++k) {
    const auto count = static_cast<unsigned>(2 + random() % 15);
    const Ray first = random_ray(random, Vec3::Zero());
    const double spread = k % 2 == 0 ? 0.02 : 1;
    std::array<PatchRayQuery, 16> alone, together, any;
    for (unsigned r = 0; r < count; ++r) {
      const Ray ray{first.origin, first.direction + spread * random_direction(random)};
      alone[r] = together[r] = any[r] = query_of(data, ray);
    }
    for (std::uint32_t part = 0; part < data.n_parts(); ++part) {
      for (unsigned r = 0; r < count; ++r) kernel.first_hit(data.arrays(), part, alone[r]);
      kernel.first_hits(data.arrays(), part, together.data(), count);
      kernel.are_hit(data.arrays(), part, any.data(), count);
    }
    for (unsigned r = 0; r < count; ++r) {
      ASSERT_EQ(together[r].is_met, alone[r].is_met);
      EXPECT_EQ(any[r].is_met, alone[r].is_met);
      if (!alone[r].is_met) continue;
      EXPECT_EQ(together[r].t_max, alone[r].t_max);
      EXPECT_EQ(together[r].triangle, alone[r].triangle);
    }
  }
}

#if defined(__x86_64__)
TEST_P(DisplacedCase, BothVersionsOfTheKernelGiveTheSameBits) {
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "only one version runs here";
  const DisplacedKernel &plain = detail::k_displaced_kernel_baseline, &fast = detail::displaced_kernel();
  ASSERT_NE(&plain, &fast);
  const Case c = cases()[GetParam()];
  const DisplacedMesh mesh(c.base, c.map, c.options);
  const DisplacedMesh::Data& data = mesh.data();
  std::mt19937 random(7);
  for (int k = 0; k < (k_sanitized ? 30 : 300); ++k) {
    PatchRayQuery a = query_of(data, random_ray(random, Vec3::Zero())), b = a;
    for (std::uint32_t part = 0; part < data.n_parts(); ++part) {
      plain.first_hit(data.arrays(), part, a);
      fast.first_hit(data.arrays(), part, b);
    }
    ASSERT_EQ(a.is_met, b.is_met);
    if (!a.is_met) continue;
    EXPECT_EQ(a.t_max, b.t_max);
    EXPECT_EQ(a.triangle, b.triangle);
    EXPECT_EQ(a.u, b.u);
    EXPECT_EQ(std::memcmp(a.normal, b.normal, sizeof(a.normal)), 0);
  }
}
#endif

class ClosedCase : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Offsets, ClosedCase, testing::Values(0.0, 1e3, 1e5));

TEST_P(ClosedCase, NoRayGetsOutAcrossSeamsCornersAndLevels) {
  const Vec3 center = GetParam() * Vec3(1, -0.7, 0.4);
  const int rays = k_sanitized ? 20000 : 400000;
  const PolygonSoup base = chart_sphere(4, center, 0.05);
  DisplacedMeshOptions same;
  same.level = 4;
  const DisplacedMesh uniform(base, rough_map(128, 96, 0, 0.3, MapBorder::clamped, 3), same);
  EXPECT_GT(uniform.data().patches.exceptions.size(), 0u);
  EXPECT_EQ(leaks(uniform, center, rays), 0u);
  DisplacedMeshOptions mixed;
  mixed.triangle_levels = mixed_levels(base, 5, 9);
  const DisplacedMesh various(base, rough_map(128, 96, -0.2, 0.2, MapBorder::periodic, 4), mixed);
  EXPECT_EQ(leaks(various, center, rays), 0u);
}

TEST(DisplacedMesh, NeighboursHaveTheSamePointsAlongTheirSides) {
  const PolygonSoup base = chart_sphere(3, Vec3::Zero(), 0.05);
  for (const bool is_mixed : {false, true}) {
    DisplacedMeshOptions options;
    options.level = 3;
    if (is_mixed) options.triangle_levels = mixed_levels(base, 4, 21);
    const DisplacedMesh mesh(base, rough_map(64, 48, 0, 0.3, MapBorder::clamped, 3), options);
    PolygonSoup small = mesh.tessellate();
    merge_identical_vertices(small);
    std::map<std::pair<Index, Index>, int> balance;
    for (Index f = 0; f < small.n_faces(); ++f) {
      for (Index k = 0; k < 3; ++k) {
        const Index from = small.corner_vertices[3 * f + k], to = small.corner_vertices[3 * f + (k + 1) % 3];
        if (from == to) continue;  // sides that closed up towards a coarser neighbour
        balance[std::minmax(from, to)] += from < to ? 1 : -1;
      }
    }
    for (const auto& [ends, sum] : balance)
      ASSERT_EQ(sum, 0) << small.positions[ends.first].transpose() << " to "
                        << small.positions[ends.second].transpose();
  }
}

// The recursion of the dissertation as it is printed, which makes directions unit length at every step.
void recurse(const DisplacementMap& map, const std::array<Vec3, 3>& p, const std::array<Vec2, 3>& uv,
             const std::array<Vec3, 3>& n, int level, double fraction, PolygonSoup& soup, int& tests) {
  const auto moved = [&](const Vec3& at, const Vec2& texel, const Vec3& direction) {
    return Vec3(at + direction * map.height_at(texel) * fraction);
  };
  if (level == 0) {
    std::array<Index, 3> face{};
    for (std::size_t k = 0; k < 3; ++k) {
      face[k] = static_cast<Index>(soup.positions.size());
      soup.positions.push_back(moved(p[k], uv[k], n[k]));
    }
    soup.add_face(face);
    ++tests;
    return;
  }
  std::array<Vec3, 3> q, m;
  std::array<Vec2, 3> w;
  for (std::size_t k = 0; k < 3; ++k) {
    q[k] = (p[k] + p[(k + 1) % 3]) / 2;
    w[k] = (uv[k] + uv[(k + 1) % 3]) / 2;
    m[k] = ((n[k] + n[(k + 1) % 3]) / 2).normalized();
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t before = (k + 2) % 3;
    recurse(map, {p[k], q[k], q[before]}, {uv[k], w[k], w[before]}, {n[k], m[k], m[before]}, level - 1,
            fraction, soup, tests);
  }
  recurse(map, {q[0], q[1], q[2]}, {w[0], w[1], w[2]}, {m[0], m[1], m[2]}, level - 1, fraction, soup, tests);
}

TEST(DisplacedMesh, TheDissertationsRecursionFindsTheSameSurface) {
  PolygonSoup base = chart_sphere(4, Vec3::Zero());
  for (const Index v : base.corner_vertices) base.corner_normals.push_back(base.positions[v].normalized());
  const DisplacementMap map = rough_map(16, 12, 0, 0.1, MapBorder::clamped, 3);
  std::vector<Index> corners;
  triangulate(base, nullptr, &corners);
  for (const int level : {1, 2, 4}) {
    DisplacedMeshOptions options;
    options.level = level;
    options.partial = true;
    const DisplacedMesh mesh(base, map, options);
    for (const double fraction : {1.0, 0.5}) {
      PolygonSoup small;
      int tests = 0;
      for (std::size_t c = 0; c < corners.size(); c += 3) {
        std::array<Vec3, 3> p, n;
        std::array<Vec2, 3> uv;
        for (std::size_t k = 0; k < 3; ++k) {
          p[k] = base.positions[base.corner_vertices[corners[c + k]]];
          n[k] = base.corner_normals[corners[c + k]];
          uv[k] = base.corner_uvs[corners[c + k]];
        }
        recurse(map, p, uv, n, level, fraction, small, tests);
      }
      EXPECT_EQ(tests, static_cast<int>(corners.size() / 3) << (2 * level));
      EXPECT_EQ(mesh.small_triangles(), small.n_faces());
      // Away from seams, every point of one is near one of the other: the two ways of making directions unit
      // length differ by the cube of the angle between corners, 1e-3 here, times the height.
      const PolygonSoup ours = mesh.tessellate(fraction);
      std::vector<Vec3> points = ours.positions;
      std::sort(points.begin(), points.end(), [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
      std::size_t far = 0;
      for (const Vec3& p : small.positions) {
        const auto near = [&](double reach) {
          auto it = std::lower_bound(points.begin(), points.end(), p.x() - reach,
                                     [](const Vec3& a, double x) { return a.x() < x; });
          for (; it != points.end() && it->x() < p.x() + reach; ++it) {
            if ((*it - p).norm() < reach) return true;
          }
          return false;
        };
        if (!near(1.5e-4)) ++far;
      }
      // Along the twelve seams of the cube the recursion has two heights, and one of them is ours.
      EXPECT_LT(static_cast<double>(far), 0.12 * static_cast<double>(small.positions.size())) << level;
    }
  }
}

}  // namespace
}  // namespace recede
