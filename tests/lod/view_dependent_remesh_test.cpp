// Diced views: no cracks, no triangle turned over, and what the source claims of them.
#include "displaced_bases.h"
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
#include <numbers>
#include <random>
#include <unordered_map>

namespace recede::test {
namespace {

using testing::HasSubstr;

RemeshView view_from(const Vec3& position, int size = 120, const Vec3& target = Vec3::Zero()) {
  RemeshView view;
  view.position = position;
  view.target = target;
  view.width = view.height = size;
  return view;
}

/// Where a point is seen, pixels from the upper left corner, and how deep. By its own formula.
Vec3 on_screen(const RemeshView& view, const Vec3& point) {
  const Vec3 forward = (view.target - view.position).normalized(),
             right = forward.cross(view.up).normalized();
  const Vec3 up = right.cross(forward), p = point - view.position;
  const double depth = p.dot(forward), pixels = view.height / (2 * std::tan(view.field_of_view / 2)) / depth;
  return {0.5 * view.width + pixels * p.dot(right), 0.5 * view.height - pixels * p.dot(up), depth};
}

/// A map of one height.
DisplacementMap level_map(float height = 0) { return {1, 1, {height}}; }

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

TEST(ViewDependentRemesh, TreatsNeighboursThatKnowNothingOfEachOtherAlike) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&] { return Vec3(number(random), number(random), number(random)); };
  for (const double pixels : {1.0, 5.0, 20.0, 45.0}) {
    for (int i = 0; i < 40; ++i) {
      const Vec3 a = point(), b = point(), tops[] = {point(), point()};
      const Vec3 normals[] = {point().normalized(), point().normalized()};
      std::vector<std::vector<Vec3>> edges;
      for (int side = 0; side < 2; ++side) {
        // The second has the edge the other way round.
        PolygonSoup soup = soup_of({side == 0 ? a : b, side == 0 ? b : a, tops[side]}, {{0, 1, 2}});
        soup.corner_uvs = {{0.1, 0.2}, {0.8, 0.5}, {0.3, 0.9}};
        soup.corner_normals = {normals[0], normals[1], Vec3::UnitX()};
        if (side == 1) {
          std::swap(soup.corner_uvs[0], soup.corner_uvs[1]);
          std::swap(soup.corner_normals[0], soup.corner_normals[1]);
        }
        const DisplacedBase base(soup, noise_map(16, 16, 0, 0.2));
        // Footprints of corners count the triangles around, so neighbours have to know of each other there.
        const RemeshResult result =
            remesh_for_view(base, view_from({0.5, 0.3, 3}, 500),
                            {.triangle_pixels = pixels, .footprint = FootprintRule::none, .cull = false});
        // The border is open: follow it from the first corner to the second.
        std::map<Index, Index> next;
        std::map<std::pair<Index, Index>, int> counts;
        for (std::size_t f = 0; f < result.soup.n_faces(); ++f) {
          const auto face = result.soup.face(f);
          for (std::size_t k = 0; k < 3; ++k) {
            ++counts[{face[k], face[(k + 1) % 3]}];
            --counts[{face[(k + 1) % 3], face[k]}];
          }
        }
        for (const auto& [edge, n] : counts) {
          if (n > 0) next[edge.first] = edge.second;
        }
        std::vector<Vec3>& edge = edges.emplace_back();
        for (Index v = 0; v != 1; v = next.at(v)) edge.push_back(result.soup.positions[v]);
        edge.push_back(result.soup.positions[1]);
        if (side == 1) std::reverse(edge.begin(), edge.end());
      }
      ASSERT_EQ(edges[0].size(), edges[1].size()) << "a vertex on one side only";
      EXPECT_EQ(edges[0], edges[1]) << "bit by bit";
    }
  }
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

TEST(ViewDependentRemesh, DicesNearPartsFinerAndAllPartsAsLargeInPixels) {
  // A plane that runs away from the eye.
  PolygonSoup soup = plane_base(2);
  for (Vec3& p : soup.positions) p = 50 * p;
  const DisplacedBase base(soup, level_map());
  RemeshView view = view_from({0, -51, 2}, 400, {0, 0, 0});
  view.up = Vec3::UnitZ();
  for (const double pixels : {1.0, 4.0}) {
    const RemeshResult result = remesh_for_view(base, view, {.triangle_pixels = pixels});
    struct Sum {
      double pixels = 0, length = 0, n = 0;
    } near, far;
    for (std::size_t f = 0; f < result.soup.n_faces(); ++f) {
      std::array<double, 3> lengths{};
      double depth = 0;
      bool is_inside = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &a = result.soup.positions[result.soup.face(f)[k]],
                   &b = result.soup.positions[result.soup.face(f)[(k + 1) % 3]];
        const Vec3 pixel = on_screen(view, a);
        is_inside = is_inside && pixel.head<2>().minCoeff() > 0 && pixel.head<2>().maxCoeff() < 400;
        depth = std::max(depth, pixel.z());
        lengths[k] = (b - a).norm();
      }
      if (!is_inside || (depth > 10 && depth < 60)) continue;
      Sum& sum = depth <= 10 ? near : far;
      // Of the two sides that are a voxel long, up to its diagonal in space.
      const double shortest = *std::min_element(lengths.begin(), lengths.end());
      sum.pixels += shortest / (depth * 2 * std::tan(view.field_of_view / 2) / view.height);
      sum.length += shortest;
      ++sum.n;
    }
    EXPECT_GT(far.length / far.n, 8 * near.length / near.n);
    // Between a voxel shortened by a depth ratio of 2 and one seen along its diagonal.
    EXPECT_NEAR(near.pixels / near.n / pixels, 1, 0.35);
    EXPECT_NEAR(far.pixels / far.n / pixels, 1, 0.35);
  }
}

TEST(ViewDependentRemesh, DicesATriangleWhoseSidesAreAllOutsideThePictureAsFinelyAsOthers) {
  for (const double size : {10.0, 1e3, 1e6}) {
    PolygonSoup soup = soup_of({{-size, -size, 0}, {size, -size, 0}, {0, size, 0}}, {{0, 1, 2}});
    soup.corner_uvs = {{0, 0}, {1, 0}, {0.5, 1}};
    const DisplacedBase base(soup, level_map());
    const RemeshView view = view_from({0.1, -0.2, 1}, 200, {0.3, 0.1, 0});
    const RemeshResult result = remesh_for_view(base, view, {.nearest = 0.01});
    double in_picture = 0;
    for (const Vec3& p : result.soup.positions) {
      const Vec3 pixel = on_screen(view, p);
      in_picture +=
          pixel.z() > 0 && pixel.head<2>().minCoeff() > 0 && pixel.head<2>().maxCoeff() < 200 ? 1 : 0;
    }
    // One for a pixel; fewer where perspective within patches stretches them by up to a depth ratio of 2,
    // more at edges of small patches.
    EXPECT_GT(in_picture / (200 * 200), 0.75) << "size " << size;
    EXPECT_LT(in_picture / (200 * 200), 1.6) << "size " << size;
    EXPECT_LT(static_cast<double>(result.soup.positions.size()), 3 * in_picture);
  }
}

TEST(ViewDependentRemesh, LeavesOutNoTriangleWithAVisiblePoint) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&](double scale) {
    return Vec3(scale * Vec3(number(random), number(random), number(random)));
  };
  const DisplacementMap map = noise_map(8, 8, -0.5, 0.4);
  int culled = 0, visible = 0;
  for (int i = 0; i < 3000; ++i) {
    PolygonSoup soup = soup_of({point(4), point(4), point(4)}, {{0, 1, 2}});
    for (int k = 0; k < 3; ++k) {
      soup.corner_uvs.emplace_back(0.5 + 0.5 * number(random), 0.5 + 0.5 * number(random));
      soup.corner_normals.push_back(point(1).normalized());
    }
    const DisplacedBase base(soup, map);
    const RemeshView view = view_from(point(3), 20, point(1));
    const RemeshResult result = remesh_for_view(base, view, {.triangle_pixels = 5});
    ASSERT_LE(result.report.largest_move, base.largest_reach());
    if (result.report.culled < result.report.patches) continue;
    ++culled;
    const detail::GridSpace space(view, 1, 1e-9, 0);
    for (int k = 0; k < 300; ++k) {
      Vec3 w = point(1).cwiseAbs();
      w /= w.sum();
      Vec3 at = Vec3::Zero(), normal = Vec3::Zero();
      Vec2 uv = Vec2::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        const double weight = w[static_cast<Eigen::Index>(c)];
        at += weight * soup.positions[c];
        normal += weight * soup.corner_normals[c];
        uv += weight * soup.corner_uvs[c];
      }
      at += map.height_at(uv) * normal.normalized();
      ASSERT_TRUE(detail::GridSpace::is_unseen(0, space.view(at))) << "a point that the picture shows";
    }
  }
  EXPECT_GT(culled, 300);
  // The test can fail: with no reach, points are lost.
  for (int i = 0; i < 3000; ++i) {
    const RemeshView view = view_from(point(3), 20, point(1));
    const detail::GridSpace space(view, 1, 1e-9, 0);
    const Vec3 at = point(4), moved = at + 0.4 * point(1).normalized();
    if (detail::GridSpace::is_unseen(0, space.view(at)) &&
        !detail::GridSpace::is_unseen(0, space.view(moved)))
      ++visible;
  }
  EXPECT_GT(visible, 10);
}

TEST(ViewDependentRemesh, LeavesOutAllThatTheCorrectedLimitsOfTheSourceLeaveOut) {
  // Equation 8, with its division by the least depth: a box in pixels, larger by the displacement.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  const RemeshView view = view_from({0, 0, 0}, 200, {0, 0, -1});
  const detail::GridSpace space(view, 1, 1e-9, 0);
  const double half = std::tan(view.field_of_view / 2), reach = 0.3;
  int n = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::array<detail::ViewPoint, 3> seen;
    std::array<Vec3, 3> pixel;
    double least_depth = 1e9;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p(6 * number(random), 6 * number(random), -5.5 - 5 * number(random));
      seen[k] = space.view(p);
      pixel[k] = on_screen(view, p);
      least_depth = std::min(least_depth, pixel[k].z());
    }
    const double pixels = view.height * (reach / std::cos(view.field_of_view / 2)) / (2 * half * least_depth);
    bool out = false;
    for (const Eigen::Index axis : {0, 1}) {
      const auto all = [&](auto&& beyond) {
        return beyond(pixel[0][axis]) && beyond(pixel[1][axis]) && beyond(pixel[2][axis]);
      };
      out = out || all([&](double x) { return x < -pixels; }) ||
            all([&](double x) { return x > view.width + pixels; });
    }
    if (!out) continue;
    ++n;
    ASSERT_TRUE(detail::GridSpace::is_unseen(reach, seen[0], seen[1], seen[2]));
  }
  EXPECT_GT(n, 500);
}

/// The highest point of a surface in each of `n` columns of the picture, pixels from its lower edge.
std::vector<double> skyline(const PolygonSoup& soup, const RemeshView& view) {
  std::vector<double> heights(static_cast<std::size_t>(view.width), 0.0);
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3 a = on_screen(view, soup.positions[soup.face(f)[k]]),
           b = on_screen(view, soup.positions[soup.face(f)[(k + 1) % 3]]);
      if (a.x() > b.x()) std::swap(a, b);
      // Middles of pixels between the two.
      for (double x = std::max(0.0, std::ceil(a.x() - 0.5)); x + 0.5 <= b.x() && x < view.width; ++x) {
        const double t = b.x() > a.x() ? (x + 0.5 - a.x()) / (b.x() - a.x()) : 0;
        double& height = heights[static_cast<std::size_t>(x)];
        height = std::max(height, view.height - (a.y() + t * (b.y() - a.y())));
      }
    }
  }
  return heights;
}

/// Mountains seen from the side.
RemeshView mountain_view() {
  RemeshView view = view_from({0, -4, 0.35}, 800, {0, 0, 0.2});
  view.up = Vec3::UnitZ();
  view.field_of_view = 0.5;
  return view;
}

double mean_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] - b[i];
  return sum / static_cast<double>(a.size());
}

TEST(ViewDependentRemesh, KeepsTheSkylineOfMountainsWithTrianglesOfTwentyPixels) {
  const RemeshView view = mountain_view();
  for (const unsigned seed : {7U, 8U}) {
    for (const LevelRule rule : {LevelRule::mean, LevelRule::least_volume}) {
      if (rule == LevelRule::least_volume && k_sanitized) continue;
      const DisplacedBase base(plane_base(2), mountain_map(8, 0.6, seed), {.rule = rule, .steps = 20});
      const auto sky = [&](double pixels, FootprintRule footprint) {
        return skyline(remesh_for_view(base, view, {.triangle_pixels = pixels, .footprint = footprint}).soup,
                       view);
      };
      const auto original = sky(0.5, FootprintRule::none);
      const double unfiltered = mean_difference(sky(20, FootprintRule::none), original);
      const double means = mean_difference(sky(20, FootprintRule::mean), original);
      const double by_side = mean_difference(sky(20, FootprintRule::by_side), original);
      // Pixels. Mountains are some 150 high.
      EXPECT_LT(unfiltered, -1) << "clearly too low";
      EXPECT_LT(means, unfiltered) << "means shrink more than no filter does";
      EXPECT_GT(by_side, 0.4 * unfiltered) << "close to the original, or slightly above";
      EXPECT_LT(by_side, -unfiltered);
    }
  }
}

TEST(ViewDependentRemesh, OfLevelsOfLeastVolumeShrinksAHeadHalfAsMuchAsOfMeans) {
  if (k_sanitized) GTEST_SKIP() << "no memory is used here that the other tests don't use";
  // Bumps on a sphere like noses and chins, smooth at the size of a triangle; whole levels, no peaks sought.
  std::vector<float> heights;
  constexpr int k_size = 128;
  for (int y = 0; y < k_size; ++y) {
    for (int x = 0; x < k_size; ++x) {
      const double u = (x + 0.5) / k_size, v = (y + 0.5) / k_size;
      heights.push_back(static_cast<float>(0.1 * std::sin(20 * u) * std::sin(20 * v)));
    }
  }
  const DisplacementMap map(k_size, k_size, heights);
  const RemeshView view = view_from({0.4, -4, 0.3}, 400);
  const auto radius = [&](LevelRule rule, double pixels, FootprintRule footprint) {
    const DisplacedBase base(sphere_base(2), map, {.rule = rule});
    return skyline(remesh_for_view(base, view, {.triangle_pixels = pixels, .footprint = footprint}).soup,
                   view);
  };
  const auto original = radius(LevelRule::mean, 1, FootprintRule::none);
  const double means = mean_difference(radius(LevelRule::mean, 10, FootprintRule::mean), original);
  const double least_volume =
      mean_difference(radius(LevelRule::least_volume, 10, FootprintRule::mean), original);
  EXPECT_LT(means, -0.5) << "pixels of 400";
  EXPECT_GT(least_volume, 0.5 * means);
}

TEST(ViewDependentRemesh, NeedsASixthOfTheMemoryOfTheSurfaceInStrips) {
  // The source's head: 512 x 512 heights of 16 bits on a cylinder with a strip of 34 vertices of 12 bytes.
  const DisplacementMap map(Raster{512, 512, 1, 16, false, std::vector<std::uint16_t>(512 * 512)}, 1, 0);
  const double whole = static_cast<double>(map.bytes()) + 34 * 12;
  EXPECT_NEAR(whole / 1024, 512.4, 0.05);
  // Every vertex is in two strips, with three coordinates of two bytes.
  EXPECT_NEAR(512.0 * 512 * 6 * 2 / whole, 6, 0.01);
}

/// The highest point of a mesh.
double top_of(const PolygonSoup& soup) {
  double top = -1e9;
  for (const Vec3& p : soup.positions) top = std::max(top, p.z());
  return top;
}

TEST(ViewDependentRemesh, LosesSpikesBetweenVerticesUnlessTheirFootprintIsLookedAt) {
  // A known weakness: vertices depend on the view and the base, not on the heights. A spike of one texel.
  std::vector<float> heights(256 * 256, 0.0F);
  heights[100 * 256 + 130] = 1;
  const DisplacedBase base(plane_base(1), {256, 256, heights});
  std::vector<double> unfiltered, by_side;
  for (int i = 0; i < 8; ++i) {
    RemeshView view = view_from({0.02 * i, -4, 3}, 200);
    view.up = Vec3::UnitZ();
    const auto top = [&](FootprintRule footprint) {
      return top_of(remesh_for_view(base, view, {.triangle_pixels = 8, .footprint = footprint}).soup);
    };
    unfiltered.push_back(top(FootprintRule::none));
    by_side.push_back(top(FootprintRule::by_side));
  }
  EXPECT_EQ(*std::min_element(unfiltered.begin(), unfiltered.end()), 0) << "gone in some picture";
  EXPECT_GT(*std::min_element(by_side.begin(), by_side.end()), 0) << "lower, but there";
}

TEST(ViewDependentRemesh, LetsSilhouettesWagWithLargeTrianglesMoreThanWithSmallOnes) {
  // A known weakness: voxels stand still in the picture while the object moves through them.
  const DisplacedBase base(plane_base(2), mountain_map(7, 0.6));
  // How much the error of the skyline changes while the camera goes on by half a large voxel in all.
  const auto wag = [&](double pixels) {
    std::vector<std::vector<double>> errors;
    for (int i = 0; i < 6; ++i) {
      RemeshView view = mountain_view();
      view.width = view.height = 400;
      view.position.y() -= 0.006 * i;
      const auto sky = [&](double size) {
        return skyline(remesh_for_view(base, view, {.triangle_pixels = size}).soup, view);
      };
      std::vector<double>& error = errors.emplace_back(sky(pixels));
      const std::vector<double> original = sky(0.5);
      for (std::size_t x = 0; x < error.size(); ++x) error[x] -= original[x];
    }
    double sum = 0;
    for (std::size_t x = 0; x < errors[0].size(); ++x) {
      double least = 1e9, most = -1e9;
      for (const auto& error : errors) {
        least = std::min(least, error[x]);
        most = std::max(most, error[x]);
      }
      sum += most - least;
    }
    return sum / static_cast<double>(errors[0].size());
  };
  const double small = wag(1), large = wag(12);
  EXPECT_LT(small, 0.5) << "pixels";
  EXPECT_GT(large, 3 * small);
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

TEST(ViewDependentRemesh, LeavesOutEverythingBehindTheCamera) {
  const DisplacedBase base(sphere_base(1), noise_map(16, 16, -0.05, 0.1));
  const RemeshResult result = remesh_for_view(base, view_from({0, 0, 3}, 60, {0, 0, 9}));
  EXPECT_EQ(result.report.triangles, 0u);
  EXPECT_EQ(result.report.culled, result.report.patches);
  EXPECT_TRUE(result.soup.positions.empty());
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
