// Subdivision surfaces as bases of displaced ones.
#include "chart_sphere.h"
#include "control_meshes.h"
#include "ray_leaks.h"
#include "sanitized.h"
#include <recede/geometry/closest_point.h>
#include <recede/geometry/subdivision_surface.h>
#include <recede/render/displaced_mesh.h>

#include <gmock/gmock.h>

namespace recede {
namespace {

using test::charted_cube;
using test::k_sanitized;

class DisplacedLimit : public testing::TestWithParam<SubdivisionScheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, DisplacedLimit,
                         testing::Values(SubdivisionScheme::catmull_clark, SubdivisionScheme::loop),
                         [](const auto& tested) {
                           return tested.param == SubdivisionScheme::loop ? "loop" : "catmull_clark";
                         });

SubdivisionOptions creased(SubdivisionScheme scheme, int level) {
  SubdivisionOptions options;
  options.scheme = scheme;
  options.level = level;
  options.creases = {{4, 5, 10}, {5, 7, 10}, {7, 6, 10}, {6, 4, 10}, {0, 1, 2.5}, {2, 3, 10}};
  return options;
}

TEST_P(DisplacedLimit, NoRayGetsOutAcrossSeamsAndCreases) {
  const int rays = k_sanitized ? 5000 : 200000;
  for (const int level : {0, 2, 3}) {
    const PolygonSoup base = subdivide(charted_cube(), creased(GetParam(), level)).soup;
    DisplacedMeshOptions options;
    options.level = 3;
    // Heights differ along all seams.
    const DisplacedMesh mesh(base, test::rough_map(64, 64, 0, 0.2, MapBorder::clamped, 3), options);
    EXPECT_EQ(test::leaks(mesh, Vec3::Zero(), rays, 0.1), 0u) << level;
  }
}

// Waves that are 0 along the borders of the charts of `charted_cube`, whatever chart one looks at.
double wave_height(const Vec2& uv) {
  const auto along = [](double x, int charts) {
    const double within = (x * charts - std::floor(x * charts) - 0.1) / 0.8;
    return std::sin(std::numbers::pi * std::clamp(within, 0.0, 1.0));
  };
  return 0.1 * along(uv.x(), 3) * along(uv.y(), 2);
}

DisplacementMap wave_map(int size) {
  std::vector<float> heights;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x)
      heights.push_back(static_cast<float>(wave_height({(x + 0.5) / size, 1 - (y + 0.5) / size})));
  }
  return DisplacementMap(size, size, std::move(heights));
}

TEST_P(DisplacedLimit, IsApproachedAsTheLevelGrows) {
  // Points of the displaced limit surface: those of a fine level, moved along the limit's normals.
  const PolygonSoup fine = subdivide(charted_cube(), creased(GetParam(), 6)).soup;
  std::vector<Vec3> points;
  for (std::size_t c = 0; c < fine.n_corners(); c += 7) {
    points.push_back(fine.positions[fine.corner_vertices[c]] +
                     wave_height(fine.corner_uvs[c]) * fine.corner_normals[c]);
  }
  std::vector<double> distances;
  for (const int level : {0, 1, 2, 3}) {
    const PolygonSoup base = subdivide(charted_cube(), creased(GetParam(), level)).soup;
    DisplacedMeshOptions options;
    options.level = 6 - level;  // small triangles of one size, much finer than what is measured
    const PolygonSoup small = DisplacedMesh(base, wave_map(1024), options).tessellate();
    const ClosestPointTree tree(small.positions, small.corner_vertices);
    double largest = 0;
    for (const Vec3& point : points) largest = std::max(largest, tree.closest(point).squared_distance);
    distances.push_back(std::sqrt(largest));
  }
  // Places, directions and texture coordinates between points are off by the square of the level's step;
  // along the endless crease, where directions turn from one side's to the mean within a facet, by the step.
  for (std::size_t level = 1; level < distances.size(); ++level)
    EXPECT_LT(distances[level], distances[level - 1] / 2) << level;
  EXPECT_LT(distances.back(), 0.03);
}

}  // namespace
}  // namespace recede
