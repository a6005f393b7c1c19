// Subdivision surfaces against OpenSubdiv's uniform refinement, which has limit masks and no patches, and
// against patches much deeper than the level.
#include "control_meshes.h"
#include "meshes.h"
#include "same_bits.h"
#include "subdivided.h"
#include "uniform_refinement.h"
#include <recede/geometry/closest_point.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/subdivision_surface.h>

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <tbb/global_control.h>

#include <cmath>
#include <filesystem>

namespace recede {
namespace {

using test::control_cube;
using test::control_icosahedron;
using test::expect_one_unit_normal_per_point;
using test::grid;
using test::k_rounding;
using test::nearest_point;
using test::shaken;
using test::vertex_normals;
using test::with_level;

struct RefinedCase {
  const char* name;
  PolygonSoup control;
  SubdivisionOptions options;
  friend std::ostream& operator<<(std::ostream& out, const RefinedCase& c) { return out << c.name; }
};

RefinedCase refined_case(const char* name, PolygonSoup control, SubdivisionScheme scheme,
                         std::vector<SubdivisionCrease> creases = {},
                         SubdivisionBoundary boundary = SubdivisionBoundary::edge_and_corner,
                         Creasing creasing = Creasing::uniform) {
  RefinedCase c{name, std::move(control), with_level(4, scheme)};
  c.options.creases = std::move(creases);
  c.options.boundary = boundary;
  c.options.creasing = creasing;
  return c;
}

std::vector<RefinedCase> refined_cases() {
  const auto catmull_clark = SubdivisionScheme::catmull_clark, loop = SubdivisionScheme::loop;
  const std::vector<SubdivisionCrease> mixed{{4, 5, 2.3}, {5, 7, 3.6}, {7, 3, 1}, {0, 2, 0.4}};
  const std::vector<SubdivisionCrease> ring{{4, 5, 10}, {5, 7, 10}, {7, 6, 10}, {6, 4, 10}, {0, 1, 1.5}};
  const PolygonSoup cube = shaken(control_cube(), 0.3, 1);
  return {
      refined_case("cube", cube, catmull_clark),
      refined_case("prism", shaken(test::prism(7), 0.1, 2), catmull_clark),
      refined_case("many_sides", shaken(test::prism(23), 0.02, 2), catmull_clark),
      refined_case("open_hexagons", shaken(test::hexagon_sheet(3), 0.1, 3), catmull_clark),
      refined_case("triangles_by_catmull_clark", shaken(control_icosahedron(), 0.2, 3), catmull_clark),
      refined_case("semi_sharp_cube", cube, catmull_clark, mixed),
      refined_case("chaikin_cube", cube, catmull_clark, mixed, SubdivisionBoundary::edge_and_corner,
                   Creasing::chaikin),
      refined_case("creased_cube", cube, catmull_clark, ring),
      refined_case("rounded_border", shaken(grid(3), 0.1, 4), catmull_clark, {},
                   SubdivisionBoundary::edge_only),
      refined_case("icosahedron", shaken(control_icosahedron(), 0.2, 5), loop),
      refined_case("creased_icosahedron", shaken(control_icosahedron(), 0.2, 5), loop,
                   {{0, 1, 10}, {1, 5, 10}, {5, 0, 10}, {3, 2, 2.5}}),
      refined_case("open_triangles", shaken(grid(3, true), 0.1, 6), loop),
      refined_case("finger", test::finger(4, 0.7), loop),
  };
}

class RefinedMesh : public testing::TestWithParam<RefinedCase> {};
INSTANTIATE_TEST_SUITE_P(Subdivision, RefinedMesh, testing::ValuesIn(refined_cases()),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(RefinedMesh, HasThePointsAndNormalsOfRefinementAndLimitMasks) {
  const RefinedCase& c = GetParam();
  const PolygonSoup soup = subdivide(c.control, c.options).soup;
  const test::LimitPoints limit = test::uniform_limit(c.control, c.options, c.options.level);
  ASSERT_EQ(limit.positions.size(), soup.positions.size());
  const std::vector<Vec3> normals = vertex_normals(soup);
  for (std::size_t k = 0; k < limit.positions.size(); ++k) {
    const std::size_t found = nearest_point(soup.positions, limit.positions[k]);
    ASSERT_LT((soup.positions[found] - limit.positions[k]).norm(), k_rounding * 10);
    if (limit.normals[k].isZero()) continue;
    // Next to vertices that were semi-sharp, patches are near the limit surface's tangents only.
    ASSERT_LT((normals[found] - limit.normals[k]).norm(), 1e-4) << soup.positions[found].transpose();
  }
  expect_one_unit_normal_per_point(soup);
}

TEST_P(RefinedMesh, IsWeldedLikeItsControlMesh) {
  const RefinedCase& c = GetParam();
  const PolygonSoup soup = subdivide(c.control, c.options).soup;
  std::size_t control_borders = 0, borders = 0;
  for (const auto& [edge, count] : test::edge_counts(c.control)) control_borders += count == 1 ? 1 : 0;
  for (const auto& [edge, count] : test::edge_counts(soup)) {
    ASSERT_LE(count, 2);
    borders += count == 1 ? 1 : 0;
  }
  EXPECT_EQ(borders, control_borders << c.options.level);
  PolygonSoup merged = soup;
  EXPECT_EQ(merge_identical_vertices(merged).changed, 0u);
  EXPECT_EQ(orient_consistently(merged).changed, 0u);
}

// OpenSubdiv's patches, taken deeper than the levels that are compared with them.
class DeepPatches {
 public:
  DeepPatches(const PolygonSoup& control, const SubdivisionOptions& options)
      : control_(control), refiner_(test::make_refiner(control, options)), factory_(*refiner_, depth()) {}

  /// Calls `visit(coordinate, point_at)` for a raster of every square (triangle) of a face, from so many
  /// steps inside of its border on.
  template <typename Visit>
  void for_each_point(std::size_t face, int parts, int border, Visit&& visit) const {
    namespace Bfr = OpenSubdiv::Bfr;
    Bfr::Surface<double> surface;
    ASSERT_TRUE(factory_.InitVertexSurface(static_cast<int>(face), &surface));
    std::vector<double> points(static_cast<std::size_t>(3 * surface.GetNumPatchPoints()));
    surface.PreparePatchPoints(control_.positions[0].data(), 3, points.data(), 3);
    const auto point_at = [&](const Vec2& at) {
      Vec3 point;
      surface.Evaluate(at.data(), points.data(), 3, point.data());
      return point;
    };
    const Bfr::Parameterization parameters = surface.GetParameterization();
    const int squares = parameters.HasSubFaces() ? parameters.GetFaceSize() : 1;
    for (int square = 0; square < squares; ++square) {
      for (int i = border; i <= parts - border; ++i) {
        for (int j = border; j <= parts - border; ++j) {
          if (parameters.GetType() == Bfr::Parameterization::TRI && i + j > parts - border) continue;
          Vec2 at(double(i) / parts, double(j) / parts);
          if (parameters.HasSubFaces()) {
            const Vec2 within = at;
            parameters.ConvertNormalizedSubFaceToCoord(square, within.data(), at.data());
          }
          visit(at, point_at);
        }
      }
    }
  }

 private:
  static OpenSubdiv::Bfr::SurfaceFactory::Options depth() {
    OpenSubdiv::Bfr::SurfaceFactory::Options options;
    return options.SetApproxLevelSmooth(9).SetApproxLevelSharp(9);
  }
  const PolygonSoup& control_;
  std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> refiner_;
  OpenSubdiv::Bfr::RefinerSurfaceFactory<> factory_;
};

// The largest distance from the limit surface to its facets over a fine raster.
double sampled_error(const PolygonSoup& control, const SubdivisionOptions& options, const PolygonSoup& facets,
                     int parts) {
  const DeepPatches patches(control, options);
  const ClosestPointTree tree(facets.positions, triangulate(facets));
  double largest = 0;
  for (std::size_t f = 0; f < control.n_faces(); ++f) {
    patches.for_each_point(f, parts, 0, [&](const Vec2& at, auto&& point) {
      largest = std::max(largest, tree.closest(point(at)).squared_distance);
    });
  }
  return std::sqrt(largest);
}

TEST_P(RefinedMesh, IsAsFarFromItsFacetsAsDenseSamplingFinds) {
  const RefinedCase& c = GetParam();
  double last = std::numeric_limits<double>::infinity();
  for (const int level : {0, 1, 2, 3}) {
    SubdivisionOptions options = c.options;
    options.level = level;
    const SubdivisionResult result = subdivide(c.control, options);
    // 48 isn't a power of two: the points are others than those of the estimate.
    const double sampled = sampled_error(c.control, options, result.soup, 48);
    // The estimate looks at 4 by 4 points of a facet.
    EXPECT_LT(sampled, 1.1 * result.error_estimate) << level;
    EXPECT_GT(sampled, (level > 0 ? 0.8 : 0.5) * result.error_estimate) << level;
    EXPECT_LT(result.error_estimate, last);
    last = result.error_estimate;
  }
}

TEST_P(RefinedMesh, HasTheSameBytesForAnyNumberOfThreads) {
  const RefinedCase& c = GetParam();
  const SubdivisionResult many = subdivide(c.control, c.options);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const SubdivisionResult alone = subdivide(c.control, c.options);
  EXPECT_EQ(test::first_difference(many.soup, alone.soup), "");
  EXPECT_EQ(many.error_estimate, alone.error_estimate);
}

TEST_P(RefinedMesh, HasNormalsAcrossDifferencesOfThePatches) {
  const RefinedCase& c = GetParam();
  const PolygonSoup soup = subdivide(c.control, c.options).soup;
  const std::vector<Vec3> normals = vertex_normals(soup);
  const DeepPatches patches(c.control, c.options);
  constexpr double k_step = 1e-5;  // its square is what differences miss, its inverse what rounding adds
  for (std::size_t f = 0; f < c.control.n_faces(); ++f) {
    patches.for_each_point(f, 8, 1, [&](const Vec2& at, auto&& point) {
      const Vec3 here = point(at);
      const std::size_t found = nearest_point(soup.positions, here);
      ASSERT_LT((soup.positions[found] - here).norm(), 1e-12);
      const Vec3 along_u = point(at + Vec2(k_step, 0)) - point(at - Vec2(k_step, 0));
      const Vec3 along_v = point(at + Vec2(0, k_step)) - point(at - Vec2(0, k_step));
      ASSERT_LT((along_u.cross(along_v).normalized() - normals[found]).norm(), 1e-7);
    });
  }
}

TEST(Subdivision, TheEndOfAnEndlessCreaseIsNearItsLimit) {
  // OpenSubdiv's mask there is that of a smooth vertex, and what it misses halves with every level: at 8,
  // where refinement ends here, it is four times that of the patches, and 1e-3 of edges of length 2.
  SubdivisionOptions options = with_level(4);
  options.creases = {{4, 5, k_infinite_sharpness}};
  const PolygonSoup soup = subdivide(control_cube(), options).soup;
  const test::LimitPoints limit = test::uniform_limit(control_cube(), options, 8);
  for (const Index end : {4u, 5u}) {
    const Vec3& at = soup.positions[end];
    EXPECT_LT((limit.positions[nearest_point(limit.positions, at)] - at).norm(), 2e-3);
  }
  expect_one_unit_normal_per_point(soup);
}

TEST(Subdivision, ARealModelOfPolygonsIsRefinedToItsTolerance) {
  const std::filesystem::path path = std::filesystem::path(RECEDE_DATA) / "meshes/double-torus-example.off";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no models; ./dev data fetches them";
  PolygonSoup control = to_soup(read_mesh(path).mesh);
  SubdivisionOptions options;
  options.error = 1e-3 * bounding_box(control).diagonal().norm();
  const SubdivisionResult result = subdivide(control, options);
  EXPECT_LE(result.error_estimate, *options.error);
  EXPECT_LE(sampled_error(control, options, result.soup, 24), 1.1 * *options.error);
  const MeshSummary before = summarize(to_polygon_mesh(control)),
                    after = summarize(to_polygon_mesh(result.soup));
  EXPECT_EQ(after.border_edges, before.border_edges << result.level);
  EXPECT_EQ(after.vertices + after.faces - after.edges, before.vertices + before.faces - before.edges)
      << "the same surface by Euler's number";
  expect_one_unit_normal_per_point(result.soup);
}

}  // namespace
}  // namespace recede
