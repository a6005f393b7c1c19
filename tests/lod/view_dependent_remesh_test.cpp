// Diced views: no cracks, no triangle turned over, and whole meshes in hard cases.
#include "displaced_bases.h"
#include "remesh_views.h"
#include "same_bits.h"
#include "sanitized.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/detail/grid_space.h>
#include <recede/lod/simplify.h>
#include <recede/lod/view_dependent_remesh.h>

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <random>
#include <unordered_map>

namespace recede::test {
namespace {

using testing::HasSubstr;

/// Numbers of directed edges that occur twice, and of those without their reverse.
struct EdgeDefects {
  std::size_t repeated = 0, unmatched = 0;
  bool operator==(const EdgeDefects&) const = default;
  friend std::ostream& operator<<(std::ostream& out, const EdgeDefects& d) {
    return out << d.repeated << " repeated, " << d.unmatched << " unmatched";
  }
};
EdgeDefects edge_defects(const PolygonSoup& soup) {
  std::unordered_map<std::uint64_t, int> counts;
  const auto key = [](Index a, Index b) { return static_cast<std::uint64_t>(a) << 32 | b; };
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const auto face = soup.face(f);
    for (std::size_t k = 0; k < 3; ++k) ++counts[key(face[k], face[(k + 1) % 3])];
  }
  EdgeDefects defects;
  for (const auto& [edge, n] : counts) {
    if (n > 1) ++defects.repeated;
    if (counts.count(edge << 32 | edge >> 32) == 0) ++defects.unmatched;
  }
  return defects;
}

void expect_whole(const RemeshResult& result) {
  const PolygonSoup& soup = result.soup;
  EXPECT_NO_THROW(validate(soup, "diced")) << "all numbers are finite, all lists complete";
  EXPECT_EQ(result.report.triangles, soup.n_faces());
  EXPECT_EQ(result.report.corner_vertices + result.report.edge_vertices + result.report.inner_vertices,
            soup.positions.size());
  std::vector<bool> is_used(soup.positions.size(), false);
  for (const Index v : soup.corner_vertices) is_used[v] = true;
  EXPECT_EQ(std::count(is_used.begin(), is_used.end(), false), 0);
}

TEST(ViewDependentRemesh, MatchesEveryDirectedEdgeOfClosedSurfaces) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const bool one_chart : {true, false}) {
    const DisplacedBase base(sphere_base(1, one_chart), noise_map(40, 23, -0.1, 0.3));
    for (int i = 0; i < 12; ++i) {
      const Vec3 direction = Vec3(number(random), number(random), number(random)).normalized();
      RemeshView view = view_from((1 + 0.5 * (i % 4)) * direction, 90, 0.3 * direction.unitOrthogonal());
      for (const FootprintRule rule : {FootprintRule::by_side, FootprintRule::mean, FootprintRule::none}) {
        RemeshOptions options{.triangle_pixels = 1.0 + i, .footprint = rule, .cull = false};
        const RemeshResult result = remesh_for_view(base, view, options);
        expect_whole(result);
        EXPECT_EQ(edge_defects(result.soup), EdgeDefects{}) << "distance " << view.position.norm();
      }
    }
  }
}

TEST(ViewDependentRemesh, SmallTrianglesHaveTheMaterialsOfTheLargeOnes) {
  PolygonSoup soup = sphere_base(1, false);
  soup.materials = {{"a", Vec4::Ones(), ""}, {"b", Vec4::Ones(), ""}, {"c", Vec4::Ones(), ""}};
  for (Index f = 0; f < soup.n_faces(); ++f) soup.face_materials.push_back(f % 4 == 3 ? k_no_index : f % 4);
  const DisplacedBase base(soup, noise_map(40, 23, 0, 0));
  const PolygonSoup diced = remesh_for_view(base, view_from({0, 0, 1.4}, 100, {0, 0, 0})).soup;
  EXPECT_NO_THROW(validate(diced, "diced"));
  EXPECT_EQ(diced.materials, soup.materials);
  std::map<Index, std::size_t> counts;
  for (std::size_t f = 0; f < diced.n_faces(); ++f) {
    Vec3 middle = Vec3::Zero();
    for (const Index v : diced.face(f)) middle += diced.positions[v];
    // The large triangle that the ray from the sphere's middle meets.
    std::size_t large = 0;
    const auto is_inside = [&](std::size_t t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &a = soup.positions[soup.face(t)[k]], &b = soup.positions[soup.face(t)[(k + 1) % 3]];
        if (a.cross(b).dot(middle) < 0) return false;
      }
      return true;
    };
    while (large < soup.n_faces() && !is_inside(large)) ++large;
    ASSERT_LT(large, soup.n_faces());
    ASSERT_EQ(diced.face_materials[f], soup.face_materials[large]) << f;
    ++counts[diced.face_materials[f]];
  }
  EXPECT_EQ(counts.size(), 4u) << "all of them are seen";
}

TEST(ViewDependentRemesh, LeavesOpenOnlyWhatIsOutOfThePicture) {
  const DisplacedBase base(sphere_base(3), noise_map(64, 64, 0, 0.1));
  const RemeshView view = view_from({0, 0, 1.4}, 100, {0.3, 0.2, 0});
  const RemeshResult result = remesh_for_view(base, view);
  EXPECT_GT(result.report.culled, 100u);
  expect_whole(result);
  const detail::GridSpace space(view, 1, 1e-4, 0);
  std::map<std::pair<Index, Index>, int> counts;
  for (std::size_t f = 0; f < result.soup.n_faces(); ++f) {
    const auto face = result.soup.face(f);
    for (std::size_t k = 0; k < 3; ++k) {
      ++counts[{face[k], face[(k + 1) % 3]}];
      --counts[{face[(k + 1) % 3], face[k]}];
    }
  }
  std::size_t open = 0;
  for (const auto& [edge, n] : counts) {
    if (n == 0) continue;
    ++open;
    const detail::ViewPoint a = space.view(result.soup.positions[edge.first]),
                            b = space.view(result.soup.positions[edge.second]);
    EXPECT_TRUE(detail::GridSpace::is_unseen(0, a, b));
  }
  EXPECT_GT(open, 0u);
}

/// Along the border of a diced triangle from its first corner to the second.
std::vector<Vec3> first_side(const PolygonSoup& soup) {
  std::map<std::pair<Index, Index>, int> counts;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const auto face = soup.face(f);
    for (std::size_t k = 0; k < 3; ++k) {
      ++counts[{face[k], face[(k + 1) % 3]}];
      --counts[{face[(k + 1) % 3], face[k]}];
    }
  }
  std::map<Index, Index> next;
  for (const auto& [edge, n] : counts) {
    if (n > 0) next[edge.first] = edge.second;
  }
  std::vector<Vec3> side;
  for (Index v = 0; v != 1; v = next.at(v)) side.push_back(soup.positions[v]);
  side.push_back(soup.positions[1]);
  return side;
}

TEST(ViewDependentRemesh, TreatsNeighboursThatKnowNothingOfEachOtherAlike) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&] { return Vec3(number(random), number(random), number(random)); };
  int n_footprints = 0;
  for (const double pixels : {1.0, 5.0, 20.0, 45.0}) {
    for (int i = 0; i < 40; ++i) {
      const Vec3 a = point(), b = point(), tops[] = {point(), point()};
      const Vec3 normals[] = {point().normalized(), point().normalized()};
      for (const FootprintRule rule : {FootprintRule::none, FootprintRule::by_side, FootprintRule::mean}) {
        std::array<std::vector<Vec3>, 2> edges;
        bool is_halved = false;
        for (const std::size_t side : {0u, 1u}) {
          // The second has the edge the other way round.
          PolygonSoup soup = soup_of({side == 0 ? a : b, side == 0 ? b : a, tops[side]}, {{0, 1, 2}});
          soup.corner_uvs = {{0.1, 0.2}, {0.8, 0.5}, {0.3, 0.9}};
          soup.corner_normals = {normals[0], normals[1], Vec3::UnitX()};
          if (side == 1) {
            std::swap(soup.corner_uvs[0], soup.corner_uvs[1]);
            std::swap(soup.corner_normals[0], soup.corner_normals[1]);
          }
          const DisplacedBase base(soup, noise_map(16, 16, 0, 0.2));
          const RemeshResult result =
              remesh_for_view(base, view_from({0.5, 0.3, 3}, 500),
                              {.triangle_pixels = pixels, .footprint = rule, .cull = false});
          is_halved = is_halved || result.report.patches > 1;
          edges[side] = first_side(result.soup);
          if (side == 1) std::reverse(edges[side].begin(), edges[side].end());
        }
        ASSERT_EQ(edges[0].size(), edges[1].size()) << "a vertex on one side only";
        if (rule != FootprintRule::none) {
          // Footprints of corners count the triangles around, so neighbours have to know of each other there.
          if (is_halved) continue;
          for (auto& edge : edges) edge = {edge.begin() + 1, edge.end() - 1};
          n_footprints += edges[0].empty() ? 0 : 1;
        }
        EXPECT_EQ(edges[0], edges[1]) << "bit by bit";
      }
    }
  }
  EXPECT_GT(n_footprints, 100);
}

/// Twice the signed area on the screen.
double screen_area(const RemeshView& view, const std::array<Vec3, 3>& points) {
  std::array<Vec3, 3> seen;
  for (std::size_t k = 0; k < 3; ++k) seen[k] = on_screen(view, points[k]);
  const Vec3 ab = seen[1] - seen[0], ac = seen[2] - seen[0];
  return ab.x() * ac.y() - ac.x() * ab.y();
}

TEST(ViewDependentRemesh, TurnsNoTriangleOverOnTheScreenAndStaysInThePlaneBeforeItIsDisplaced) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&] { return Vec3(number(random), number(random), number(random)); };
  for (int i = 0; i < 300; ++i) {
    PolygonSoup soup = soup_of({point(), point(), point()}, {{0, 1, 2}});
    soup.corner_uvs = {{0, 0}, {1, 0}, {0, 1}};
    const DisplacedBase base(soup, level_map());
    const RemeshView view = view_from({0.3, 0.1, 2.5}, 200);
    const RemeshResult result = remesh_for_view(base, view, {.triangle_pixels = 1.0 + i % 7, .cull = false});
    const auto& p = result.soup.positions;
    const double whole = screen_area(view, {soup.positions[0], soup.positions[1], soup.positions[2]});
    const Vec3 normal =
        (soup.positions[1] - soup.positions[0]).cross(soup.positions[2] - soup.positions[0]).normalized();
    double sum = 0;
    for (std::size_t f = 0; f < result.soup.n_faces(); ++f) {
      const auto face = result.soup.face(f);
      const double area = screen_area(view, {p[face[0]], p[face[1]], p[face[2]]});
      // Products of some 200 pixels, each off by 1e-13 of itself.
      ASSERT_GE(area * (whole < 0 ? -1 : 1), -1e-8);
      sum += area;
    }
    EXPECT_NEAR(sum, whole, 1e-6) << "the small triangles cover the large one";
    for (const Vec3& q : p) ASSERT_NEAR(normal.dot(q - soup.positions[0]), 0, 1e-13);
    // Corners are exact although their places among the voxels are rounded.
    for (const Vec3& corner : soup.positions) EXPECT_EQ(std::count(p.begin(), p.end(), corner), 1);
  }
}

TEST(ViewDependentRemesh, GivesTheSameBytesForAnyNumberOfThreads) {
  const DisplacedBase base(sphere_base(3), noise_map(50, 50, -0.05, 0.1));
  const RemeshView view = view_from({0.5, 0.9, 1.1}, 300);
  const auto dice = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return remesh_for_view(base, view).soup;
  };
  const PolygonSoup one = dice(1);
  for (const std::size_t threads : {2U, 5U}) EXPECT_EQ(first_difference(one, dice(threads)), "");
}

TEST(ViewDependentRemesh, SmoothsNormalsOverThePatches) {
  const DisplacedBase base(sphere_base(2), level_map(0.5F));
  const RemeshResult result = remesh_for_view(base, view_from({0, 0, 4}, 200), {.cull = false});
  ASSERT_EQ(result.soup.corner_normals.size(), result.soup.n_corners());
  for (std::size_t c = 0; c < result.soup.n_corners(); ++c) {
    const Vec3& normal = result.soup.corner_normals[c];
    ASSERT_NEAR(normal.norm(), 1, 1e-12);
    // The base has 128 triangles, which turn by some 20 degrees from one to the next.
    ASSERT_GT(normal.dot(result.soup.positions[result.soup.corner_vertices[c]].normalized()), 0.9);
  }
  const RemeshResult without =
      remesh_for_view(base, view_from({0, 0, 4}, 200), {.cull = false, .normals = false});
  EXPECT_TRUE(without.soup.corner_normals.empty());
  EXPECT_EQ(without.soup.positions, result.soup.positions);
}

TEST(ViewDependentRemesh, MovesPointsByTheHeightsOfTheMapWhereTrianglesAreSmallerThanTexels) {
  const DisplacementMap map = noise_map(6, 6, -0.2, 0.3);
  const DisplacedBase base(plane_base(2), map);
  const RemeshResult result = remesh_for_view(base, view_from({0, 0.1, 3}, 500));
  for (const Vec3& p : result.soup.positions) {
    ASSERT_NEAR(p.z(), map.height_at({0.5 + 0.5 * p.x(), 0.5 + 0.5 * p.y()}), 1e-12) << "rounding of uv";
  }
}

TEST(ViewDependentRemesh, TakesTheMeanOfBothSidesOfASeam) {
  // Two triangles; one sees a height of 1 along the common edge, the other a height of 3.
  PolygonSoup soup = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  soup.corner_uvs = {{0.1, 0.1}, {0.2, 0.1}, {0.2, 0.2}, {0.8, 0.8}, {0.9, 0.9}, {0.8, 0.9}};
  soup.corner_normals.assign(6, Vec3::UnitZ());
  const DisplacedBase base(soup, {2, 2, {1, 3, 1, 3}});
  const RemeshResult result = remesh_for_view(base, view_from({0.5, 0.5, 30}, 500, {0.5, 0.5, 0}));
  int on_seam = 0;
  for (const Vec3& p : result.soup.positions) {
    if (std::abs(p.x() - p.y()) > 1e-12) continue;
    EXPECT_NEAR(p.z(), 2, 1e-12);
    ++on_seam;
  }
  EXPECT_GT(on_seam, 5);
}

TEST(ViewDependentRemesh, LooksNoFartherAroundCornersOfSeamsThanTheirReach) {
  // The second triangle has many texels for a unit and the first one few, so that a voxel is larger than all
  // of the first one's part of the map. Right of that part is a ridge.
  constexpr int k_size = 256;
  std::vector<float> heights;
  for (int i = 0; i < k_size * k_size; ++i) {
    const int x = i % k_size;
    heights.push_back(x >= 64 ? 0.5F : x >= 16 && x < 32 ? 1.0F : 0.0F);
  }
  PolygonSoup soup = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  soup.corner_uvs = {{0.026, 0.05}, {0.028, 0.05}, {0.028, 0.052}, {0.7, 0.7}, {0.95, 0.95}, {0.7, 0.95}};
  const DisplacedBase base(soup, {k_size, k_size, heights});
  ASSERT_EQ(base.largest_reach(), 0.5) << "without the ridge";
  const RemeshReport report =
      remesh_for_view(base, view_from({0.5, 0.5, 3}, 60, {0.5, 0.5, 0}), {.triangle_pixels = 30}).report;
  EXPECT_LE(report.largest_move, base.largest_reach());
}

struct HardCase {
  std::string name;
  PolygonSoup soup;
  DisplacementMap map;
  RemeshView view;
};

std::vector<HardCase> hard_cases() {
  std::vector<HardCase> cases;
  const auto hills = [] { return noise_map(16, 16, -0.05, 0.1); };
  cases.push_back(
      {"camera in the surface", plane_base(1), level_map(), view_from({0.1, 0.2, 0}, 60, {1, 1, 0})});
  cases.push_back({"camera at a corner of the base", sphere_base(1), hills(), view_from({1, 0, 0}, 60)});
  cases.push_back({"camera in the shell", sphere_base(1), noise_map(16, 16, 0, 0.5),
                   view_from({0, 0.4, 1.1}, 60, {0, 3, 1})});
  cases.push_back({"camera in the middle", sphere_base(1), hills(), view_from({0, 0, 0}, 60, {1, 2, 3})});
  cases.push_back(
      {"a base through the eye plane", plane_base(1), hills(), view_from({0, 0, 0.3}, 60, {0, 1, 0.2})});
  cases.push_back({"all behind the camera", sphere_base(1), hills(), view_from({0, 0, 3}, 60, {0, 0, 9})});
  cases.push_back({"one texel", sphere_base(1), level_map(0.2F), view_from({0, 2, 3}, 60)});
  cases.push_back({"one row of texels", sphere_base(1), noise_map(300, 1, 0, 0.2), view_from({0, 2, 3}, 60)});
  cases.push_back({"large map", sphere_base(1), noise_map(2048, 1024, 0, 0.2), view_from({0, 2, 3}, 60)});
  cases.push_back(
      {"heights beyond the view", sphere_base(1), noise_map(16, 16, -1e3, 1e3), view_from({0, 2, 3}, 60)});
  cases.push_back({"far away", sphere_base(1), hills(), view_from({0, 2e6, 3e6}, 60)});
  cases.push_back({"one pixel", sphere_base(1), hills(), view_from({0, 2, 3}, 1)});
  RemeshView flat = view_from({0, 2, 3}, 60);
  flat.width = 1000;
  flat.height = 1;
  cases.push_back({"a line of pixels", sphere_base(1), hills(), flat});
  RemeshView wide = view_from({0, 0.5, 1.2}, 60);
  wide.field_of_view = 3.1;
  cases.push_back({"nearly half a turn of view", sphere_base(1), hills(), wide});
  RemeshView upright = view_from({0, 3, 0}, 60);
  cases.push_back({"view along its upward direction", sphere_base(1), hills(), upright});

  PolygonSoup no_area_in_map = sphere_base(1);
  for (Vec2& uv : no_area_in_map.corner_uvs) uv = {0.3, 0.3};
  cases.push_back({"one texture coordinate", no_area_in_map, hills(), view_from({0, 2, 3}, 60)});
  PolygonSoup outside = sphere_base(1);
  for (Vec2& uv : outside.corner_uvs) uv = 1e3 * uv;
  cases.push_back({"texture coordinates outside the map", outside, hills(), view_from({0, 2, 3}, 60)});
  PolygonSoup thin = sphere_base(1);
  for (Vec3& p : thin.positions) p.y() *= 1e-9;
  cases.push_back({"slivers", thin, hills(), view_from({0, 0.5, 3}, 60)});
  PolygonSoup line = sphere_base(1);
  for (Vec3& p : line.positions) p = {p.z(), p.z(), p.z()};
  cases.push_back({"a surface on a line", line, hills(), view_from({0, 0.5, 3}, 60)});
  PolygonSoup long_and_thin = sphere_base(1);
  for (Vec3& p : long_and_thin.positions) p.x() *= 1e5;
  cases.push_back(
      {"a needle past the camera", long_and_thin, hills(), view_from({0, 1.5, 1}, 60, {1e4, 0, 0})});
  PolygonSoup opposite = sphere_base(1);
  for (std::size_t c = 0; c < opposite.n_corners(); ++c) {
    if (opposite.positions[opposite.corner_vertices[c]].x() > 0.1) opposite.corner_normals[c] *= -1;
  }
  cases.push_back({"opposite directions", opposite, hills(), view_from({0, 2, 3}, 60)});
  PolygonSoup none = sphere_base(1);
  none.corner_normals.clear();
  cases.push_back({"no directions", none, hills(), view_from({0, 2, 3}, 60)});
  PolygonSoup tiny = sphere_base(1);
  for (Vec3& p : tiny.positions) p *= 1e-150;
  cases.push_back({"tiny", tiny, level_map(), view_from({0, 2e-150, 3e-150}, 60)});
  PolygonSoup huge = sphere_base(1);
  for (Vec3& p : huge.positions) p *= 1e100;
  cases.push_back({"huge", huge, level_map(), view_from({0, 2e100, 3e100}, 60)});
  cases.push_back({"a view from within what is huge", huge, hills(), view_from({0, 2, 3}, 60)});
  RemeshView long_upwards = view_from({0, 2, 3}, 60);
  long_upwards.up = {0, 1e200, 0};
  cases.push_back({"a very long upward direction", sphere_base(1), hills(), long_upwards});
  return cases;
}

TEST(ViewDependentRemesh, StaysWholeInHardCases) {
  for (const HardCase& hard : hard_cases()) {
    SCOPED_TRACE(hard.name);
    const DisplacedBase base(hard.soup, hard.map);
    const bool is_closed = hard.soup.n_faces() != 2;
    for (const bool cull : {false, true}) {
      const RemeshResult result = remesh_for_view(base, hard.view, {.cull = cull});
      expect_whole(result);
      EXPECT_LT(result.report.triangles, 3'000'000u) << "for some 3600 pixels";
      if (!cull && is_closed) {
        EXPECT_EQ(edge_defects(result.soup), EdgeDefects{});
      }
    }
  }
}

TEST(ViewDependentRemesh, KeepsPartsThatSeveralTrianglesShareTogether) {
  // Three triangles at one edge: all of them have its vertices.
  PolygonSoup soup =
      soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}});
  for (const Index v : soup.corner_vertices) soup.corner_uvs.emplace_back(0.2 * v, 0.1 * v * v / 4);
  const DisplacedBase base(soup, noise_map(8, 8, 0, 0.1));
  const RemeshResult result = remesh_for_view(base, view_from({2, 2, 2}, 100), {.cull = false});
  std::map<std::pair<Index, Index>, int> counts;
  for (std::size_t f = 0; f < result.soup.n_faces(); ++f) {
    for (std::size_t k = 0; k < 3; ++k)
      ++counts[std::minmax(result.soup.face(f)[k], result.soup.face(f)[(k + 1) % 3])];
  }
  const auto threefold =
      std::count_if(counts.begin(), counts.end(), [](const auto& c) { return c.second == 3; });
  EXPECT_GT(threefold, 5);
  EXPECT_EQ(std::count_if(counts.begin(), counts.end(), [](const auto& c) { return c.second > 3; }), 0);
}

template <typename Error, typename Work>
void expect_error(Work&& work, const char* text) {
  try {
    work();
    ADD_FAILURE() << "no error: " << text;
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(text));
  }
}

TEST(ViewDependentRemesh, RefusesWhatItCannotDice) {
  BakedMaps maps;
  maps.surface = plane_base(1);
  expect_error<InputError>([&] { DisplacedBase{maps}; }, "no displacement map");
  PolygonSoup bare = plane_base(1);
  bare.corner_uvs.clear();
  expect_error<InputError>([&] { DisplacedBase(bare, level_map()); }, "no texture coordinates");
  PolygonSoup nothing;
  expect_error<InputError>([&] { DisplacedBase(nothing, level_map()); }, "no faces");
  PolygonSoup broken = plane_base(1);
  broken.positions[0].x() = std::nan("");
  expect_error<InputError>([&] { DisplacedBase(broken, level_map()); }, "finite");
  expect_error<InputError>([&] { DisplacedBase(plane_base(1), level_map(std::nanf(""))); }, "finite");
  expect_error<InputError>([&] { DisplacedBase(plane_base(1), {2, 2, {0, 0, 0}}); }, "4 heights");
  PolygonSoup huge = plane_base(1);
  huge.positions[0].x() = 1e121;
  expect_error<InputError>([&] { DisplacedBase(huge, level_map()); }, "positions beyond 1e+120");
  PolygonSoup far_in_map = plane_base(1);
  far_in_map.corner_uvs[1].y() = -1e121;
  expect_error<InputError>([&] { DisplacedBase(far_in_map, level_map()); }, "coordinates beyond 1e+120");
  const DisplacementMap high({1, 1, 1, 8, false, {255}}, 1e121, 0);
  expect_error<InputError>([&] { DisplacedBase(plane_base(1), high); }, "heights beyond 1e+120");

  const DisplacedBase base(plane_base(1), level_map());
  const RemeshView view = view_from({0, 0, 2}, 1000);
  const auto dice = [&](const RemeshView& seen, const RemeshOptions& options) {
    return [&base, seen, options] { remesh_for_view(base, seen, options); };
  };
  RemeshView no_pixels = view, no_direction = view;
  no_pixels.width = 0;
  no_direction.target = no_direction.position;
  expect_error<OptionError>(dice(no_pixels, {}), "at least one pixel");
  expect_error<OptionError>(dice(no_direction, {}), "apart");
  RemeshView far_away = view;
  far_away.position.x() = 1e200;
  expect_error<OptionError>(dice(far_away, {}), "1e150 from the origin");
  expect_error<OptionError>(dice(view, {.triangle_pixels = 0}), "positive");
  expect_error<OptionError>(dice(view, {.triangle_pixels = std::nan("")}), "positive");
  expect_error<OptionError>(dice(view, {.triangle_pixels = 1e-7}), "too small");
  expect_error<OptionError>(dice(view, {.triangle_pixels = 0.005}), "more than 50000000");
  expect_error<OptionError>(dice(view, {.largest_depth_ratio = 1}), "depth ratio");
  expect_error<OptionError>(dice(view, {.nearest = -1.0}), "nearest");
  expect_error<OptionError>(dice(view, {.most_triangles = 100}), "more than 100");
}

TEST(ViewDependentRemesh, StopsWhenItIsAsked) {
  class Stop final : public Progress {
   public:
    void update(std::string_view, double) override {}
    bool cancel_requested() const override { return true; }
  } stop;
  const DisplacedBase base(plane_base(1), level_map());
  EXPECT_THROW(remesh_for_view(base, view_from({0, 0, 2}), {}, &stop), Cancelled);
  EXPECT_THROW(DisplacedBase(plane_base(1), level_map(), {}, &stop), Cancelled);
}

TEST(ViewDependentRemesh, OfAScanWithBakedMapsIsClosedAndAsNearToItAsAFineMesh) {
  const std::filesystem::path file = RECEDE_DATA "/meshes/bunny00.off";
  if (!std::filesystem::exists(file) || k_sanitized) GTEST_SKIP() << "./dev data fetches the model";
  PolygonSoup fine = read_soup(file);
  SimplifyOptions coarser;
  coarser.target.ratio = 0.02;
  const SimplifySoupResult coarse = simplify(fine, coarser);
  const BakedMaps maps = bake_maps(
      fine, coarse.soup, {.normal = false, .size = 512, .search_distance = 2 * coarse.error_bound.value()});
  const DisplacedBase base(maps);
  const Box3 box = bounding_box(fine);
  const RemeshView view = view_from(
      box.center() + 1.5 * box.diagonal().norm() * Vec3(0.3, 0.4, 1).normalized(), 900, box.center());
  const RemeshResult result = remesh_for_view(base, view, {.cull = false});
  expect_whole(result);
  EXPECT_EQ(edge_defects(result.soup), EdgeDefects{}) << "the bunny is closed, and its atlas has many seams";
  const MeshDistance distance = measure_distance(fine, result.soup);
  const MapAccuracy accuracy = measure_maps(fine, maps);
  EXPECT_LT(distance.rms, 1.3 * accuracy.rms) << "of `dice_surface`, whose triangles are as large as texels";
  EXPECT_LT(distance.rms, 0.25 * accuracy.bare_rms);
}

}  // namespace
}  // namespace recede::test
