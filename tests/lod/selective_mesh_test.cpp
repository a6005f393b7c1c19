// Any part of a progressive mesh can be finer than the rest: what is around a split is what was there when it
// was recorded, and only splits that are wanted or needed are applied.
#include "hard_cases.h"
#include "input_errors.h"
#include "meshes.h"
#include "progressive.h"
#include "sanitized.h"
#include "soups.h"
#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/polygon_normal.h>
#include <recede/lod/detail/refined_graph.h>
#include <recede/lod/selective_mesh.h>

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace recede {
namespace {

using detail::LevelState;
using detail::LinkedLevel;
using detail::RefinedGraph;
using test::all_ways;
using test::expect_same_bits;
using test::options_for;

using Star = std::map<Index, std::vector<Index>>;  // polygons by face

Star star_of(const LinkedLevel& level, Index vertex) {
  Star star;
  if (vertex == k_no_index) return star;
  level.each_corner_at(vertex, [&](Index corner) {
    std::vector<Index>& loop = star[level.face(corner)];
    loop.clear();
    level.each_corner_of(level.face(corner),
                         [&](Index c) { loop.push_back(level.state().corner_vertices()[c]); });
  });
  return star;
}

/// What the splits need of each other, told by the faces that they touch rather than by numbers.
struct Record {
  explicit Record(const ProgressiveMesh& mesh)
      : hierarchy(detail::hierarchy_of(mesh)), n(mesh.splits.size()) {
    LinkedLevel level(mesh, LevelState(mesh));
    std::vector<Index> last(mesh.n_faces(), k_no_index), last_of_vertex(mesh.positions.size(), k_no_index);
    for (Index s = 0; s < n; ++s) {
      stars.push_back(star_of(level, mesh.splits[s].kept));
      starts.push_back(stars.back().empty());
      level.apply<true>(s);
      fine_stars.push_back(star_of(level, mesh.splits[s].kept));
      fine_stars.back().merge(star_of(level, mesh.splits[s].removed));
      std::set<Index>& needed = needs.emplace_back();
      const auto touch = [&](Index face) {
        if (last[face] != k_no_index) needed.insert(last[face]);
        last[face] = s;
      };
      // A face may come back to a vertex that was not beside the one that is split.
      for (const Index face : level.faces_of(s)) {
        level.each_corner_of(face, [&](Index c) {
          Index& made_by = last_of_vertex[level.state().corner_vertices()[c]];
          if (made_by != k_no_index) needed.insert(made_by);
        });
      }
      const VertexSplit& split = mesh.splits[s];
      if (split.kept != k_no_index) last_of_vertex[split.kept] = last_of_vertex[split.removed] = s;
      for (const auto& [face, loop] : stars.back()) touch(face);
      for (const Index face : level.faces_of(s)) touch(face);
    }
  }

  /// Of random numbers, none above that of a split that its vertex, or its part of the surface, comes from.
  std::vector<double> random_priorities(std::mt19937& random) const {
    std::vector<double> priorities, of_start;  // of_start: the least of the starts that a split needs
    for (Index s = 0; s < n; ++s) {
      double p = std::uniform_real_distribution<double>(0, 1)(random);
      if (hierarchy.preceding(s) != k_no_index) p = std::min(p, priorities[hierarchy.preceding(s)]);
      double least = 1;
      for (const Index needed : needs[s]) least = std::min(least, of_start[needed]);
      priorities.push_back(p = std::min(p, least));
      of_start.push_back(starts[s] ? p : least);
    }
    return priorities;
  }

  std::vector<bool> closure(const std::vector<double>& priorities, double threshold) const {
    std::vector<bool> applied(n);
    for (Index s = static_cast<Index>(n); s-- > 0;) {
      applied[s] = applied[s] || priorities[s] > threshold;
      if (!applied[s]) continue;
      for (const Index needed : needs[s]) applied[needed] = true;
    }
    return applied;
  }

  VertexHierarchy hierarchy;
  std::size_t n;
  std::vector<Star> stars, fine_stars;  // by split: what it took apart, and made
  std::vector<bool> starts;
  std::vector<std::set<Index>> needs;
};

/// Counts splits and merges whose surroundings aren't those of the record.
struct WatchedGraph {
  RefinedGraph graph;
  const ProgressiveMesh& mesh;
  const Record& record;
  std::size_t differ = 0;

  void apply_split(Index s) {
    differ += star_of(graph.level(), mesh.splits[s].kept) != record.stars[s];
    graph.apply_split(s);
  }
  void apply_merge(Index s) {
    Star star = star_of(graph.level(), mesh.splits[s].kept);
    star.merge(star_of(graph.level(), mesh.splits[s].removed));
    differ += star != record.fine_stars[s];
    graph.apply_merge(s);
  }
  template <typename Visit>
  void around_split(Index s, Visit&& visit) const {
    graph.around_split(s, visit);
  }
  template <typename Visit>
  void around_merge(Index s, Visit&& visit) const {
    graph.around_merge(s, visit);
  }
  bool is_ready(Index s) const { return graph.is_ready(s); }
  std::size_t size() const { return graph.size(); }
};

/// Walks from one random set of splits to the next.
void expect_exact(const ProgressiveMesh& mesh, unsigned seed) {
  const Record record(mesh);
  WatchedGraph graph{RefinedGraph(mesh), mesh, record};
  VertexFront front(record.hierarchy);
  std::mt19937 random(seed);
  for (int walk = 0; walk < 8; ++walk) {
    const std::vector<double> priorities = record.random_priorities(random);
    const double threshold = std::pow(std::uniform_real_distribution<double>(0, 1)(random), 3);
    front.adapt(graph, [&](Index s) { return priorities[s] > threshold; });
    EXPECT_EQ(graph.differ, 0u);
    const std::vector<bool> expected = record.closure(priorities, threshold);
    LevelState direct(mesh);
    std::size_t wrong = 0;
    for (Index s = 0; s < record.n; ++s) {
      wrong += front.is_applied(s) != expected[s];
      if (expected[s]) direct.apply<true>(s);
    }
    EXPECT_EQ(wrong, 0u) << "walk " << walk;
    expect_same_bits(graph.graph.state().soup(false), direct.soup(false));
    // And within a budget, where the result isn't unique but must be sound.
    const std::size_t budget = mesh.level_faces[0] + random() % (mesh.level_faces.back() + 1);
    front.adapt_within(
        graph, [&](Index s) { return priorities[s]; }, 0, budget);
    EXPECT_EQ(graph.differ, 0u);
    EXPECT_LE(graph.size(), budget);
  }
  front.adapt(graph, [](Index) { return true; });
  EXPECT_EQ(graph.differ, 0u);
  expect_same_bits(graph.graph.state().soup(false), detail::level_of_all_splits(mesh).soup(false));
  front.adapt(graph, [](Index) { return false; });
  EXPECT_EQ(graph.differ, 0u);
  expect_same_bits(graph.graph.state().soup(false), LevelState(mesh).soup(false));
}

TEST(VertexFront, MeetsWhatWasRecordedOnRandomPolygons) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    const PolygonSoup soup = test::random_soup(seed, {.scalars = true});
    for (const ProgressiveOptions& options : all_ways()) {
      expect_exact(build_progressive_mesh(soup, options), seed);
    }
  }
}

TEST(VertexFront, MeetsWhatWasRecordedOnSurfaces) {
  for (const PolygonSoup& soup : {make_displaced_sphere(600, true), make_displaced_sphere(600, false),
                                  test::hexagon_sheet(8), test::grid(10)}) {
    for (const ProgressiveOptions& options : all_ways()) {
      expect_exact(build_progressive_mesh(soup, options), 5);
    }
  }
}

class FrontOfHardCases : public testing::TestWithParam<test::HardCase> {};

TEST_P(FrontOfHardCases, MeetsWhatWasRecorded) {
  if (!GetParam().refusal.empty()) return;
  const PolygonSoup& soup = GetParam().soup;
  if (test::k_sanitized && soup.n_faces() > 5000) GTEST_SKIP() << "takes minutes here";
  for (ProgressiveOptions options : all_ways()) {
    expect_exact(build_progressive_mesh(soup, options), 7);
    options.simplify.drop_parts = true;
    if (options.simplify.cost == CostPolicy::volume && soup.n_faces() > 0)
      options.simplify.join_distance = 0.01 * bounding_box(soup).diagonal().norm();
    expect_exact(build_progressive_mesh(soup, options), 9);
  }
}
INSTANTIATE_TEST_SUITE_P(All, FrontOfHardCases, testing::ValuesIn(test::hard_cases()), test::case_name);

TEST(VertexHierarchy, LinksSplitsOfAVertex) {
  // 0 -> 0, 1; 1 -> 1, 2; 0 -> 0, 3; 3 -> 3, 4.
  const VertexHierarchy hierarchy(5, {{1, 0}, {2, 1}, {3, 0}, {4, 3}});
  EXPECT_EQ(hierarchy.first(0), 0u);
  EXPECT_EQ(hierarchy.first(1), 1u);
  EXPECT_EQ(hierarchy.first(2), k_no_index);
  EXPECT_EQ(hierarchy.first(3), 3u);
  EXPECT_EQ(hierarchy.following(0), 2u);
  EXPECT_EQ(hierarchy.following(2), k_no_index);
  EXPECT_EQ(hierarchy.preceding(0), k_no_index);
  EXPECT_EQ(hierarchy.preceding(1), 0u);
  EXPECT_EQ(hierarchy.preceding(2), 0u);
  EXPECT_EQ(hierarchy.preceding(3), 2u);
}

ProgressiveMesh proved(const PolygonSoup& soup) {
  return build_progressive_mesh(soup, options_for(CostPolicy::volume, VertexPlacement::half_edge, true));
}

/// The faces around the vertices of each split, before and after it, lie in the sphere and the cone of the
/// split and of all above it.
void expect_bounds_hold(const ProgressiveMesh& mesh) {
  const detail::HierarchyBounds bounds = detail::bound_hierarchy(mesh);
  const VertexHierarchy hierarchy = detail::hierarchy_of(mesh);
  LinkedLevel level(mesh, LevelState(mesh));
  std::size_t outside = 0, n = 0;
  const auto look = [&](Index split, const Star& star) {
    for (const auto& [face, loop] : star) {
      std::vector<Vec3> points;
      for (const Index vertex : loop) points.push_back(level.state().positions()[vertex]);
      const Vec3 normal = detail::twice_vector_area(points);
      for (Index above = split; above != k_no_index; above = hierarchy.preceding(above)) {
        const detail::RefinementBounds& b = bounds.splits[above];
        const Vec3 center = bounds.origin + Vec3(b.center[0], b.center[1], b.center[2]),
                   axis(b.axis[0], b.axis[1], b.axis[2]);
        for (const Vec3& p : points) outside += (p - center).norm() > static_cast<double>(b.radius);
        ++n;
        if (b.angle > std::numbers::pi_v<float> || normal.isZero(0)) continue;
        // Of normals rounding leaves less than bounds have room for.
        const double angle = std::atan2(axis.cross(normal).norm(), axis.dot(normal));
        outside += axis.isZero(0) || angle > static_cast<double>(b.angle);
      }
    }
  };
  for (Index s = 0; s < mesh.splits.size(); ++s) {
    look(s, star_of(level, mesh.splits[s].kept));
    level.apply<true>(s);
    look(s, star_of(level, mesh.splits[s].kept));
    look(s, star_of(level, mesh.splits[s].removed));
  }
  EXPECT_GT(n, 0u);
  EXPECT_EQ(outside, 0u) << "of " << n;
}

TEST(RefinementBounds, HoldTheFacesOfASplitAndOfAllBelowIt) {
  for (const PolygonSoup& soup :
       {make_displaced_sphere(600, true), make_displaced_sphere(600, false), test::hexagon_sheet(8),
        test::double_sided_sheet(8), test::book_of_sheets(3, 6), test::grid(6, true)}) {
    for (const ProgressiveOptions& options : all_ways())
      expect_bounds_hold(build_progressive_mesh(soup, options));
  }
}

RefinementView random_view(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  RefinementView view;
  view.position = 2.5 * Vec3(unit(random), unit(random), unit(random));
  view.target = Vec3(unit(random), unit(random), unit(random));
  view.up = Vec3(unit(random), unit(random), unit(random));
  view.view.pixel_error = std::exp(2 * unit(random) + 1);
  return view;
}

TEST(SelectiveMesh, WithOneErrorEverywhereIsALevel) {
  const ProgressiveMesh mesh = proved(make_displaced_sphere(1000, true));
  SelectiveMesh selective(mesh);
  ProgressiveCursor cursor(mesh);
  for (const std::size_t level :
       {mesh.n_splits() / 2, mesh.n_splits(), mesh.n_splits() / 9, std::size_t{0}}) {
    const double error = mesh.level_errors[level];
    const RefinementReport report = selective.update(error);
    cursor.move_to(mesh.level_for_error(error));
    EXPECT_EQ(report.faces, cursor.n_faces());
    EXPECT_EQ(report.faces, selective.n_faces());
    expect_same_bits(selective.soup(), cursor.soup());
  }
}

TEST(SelectiveMesh, DependsOnTheViewAlone) {
  const ProgressiveMesh mesh = proved(make_displaced_sphere(2000, false));
  SelectiveMesh walking(mesh);
  std::mt19937 random(3);
  for (int i = 0; i < 60; ++i) {
    RefinementView view = random_view(random);
    view.cull = i % 2 == 0;
    if (i % 3 == 0) view.back_pixel_error = 4 * view.view.pixel_error;
    if (i % 3 == 1) view.silhouette_pixel_error = 0.3 * view.view.pixel_error;
    SelectiveMesh direct(mesh);
    const RefinementReport of_walk = walking.update(view), of_direct = direct.update(view);
    EXPECT_EQ(of_walk.faces, of_direct.faces);
    EXPECT_EQ(of_direct.merges, 0u);
    expect_same_bits(walking.soup(), direct.soup());
    const RefinementReport again = walking.update(view);
    EXPECT_EQ(again.splits + again.merges, 0u);
  }
}

/// Every corner and middle of a face lies as near to the input as the view asks there.
TEST(SelectiveMesh, NoFaceIsFartherFromTheInputThanTheViewPermits) {
  const PolygonSoup soup = make_displaced_sphere(4000, true);
  const ClosestPointTree tree(soup.positions, soup.corner_vertices);
  const ProgressiveMesh mesh = proved(soup);
  SelectiveMesh selective(mesh);
  std::mt19937 random(9);
  std::size_t fewest = soup.n_faces();
  for (int i = 0; i < 30; ++i) {
    RefinementView view = random_view(random);
    view.cull = false;
    fewest = std::min(fewest, selective.update(view).faces);
    for (const Index face : selective.faces()) {
      Vec3 middle = Vec3::Zero();
      for (Index c = 3 * face; c < 3 * face + 3; ++c) {
        middle += selective.positions()[selective.corner_vertices()[c]] / 3;
      }
      const double distance = std::sqrt(tree.closest(middle).squared_distance);
      const double pixels = distance / pixel_footprint((middle - view.position).norm(), view.view);
      // Bounds are held in single precision.
      EXPECT_LE(pixels, view.view.pixel_error * (1 + 1e-5));
    }
  }
  EXPECT_LT(fewest, soup.n_faces() / 2);
}

TEST(SelectiveMesh, IsFineInTheImageAndOnSilhouettesOnly) {
  const ProgressiveMesh mesh = proved(make_displaced_sphere(8000, true));
  SelectiveMesh selective(mesh);
  RefinementView view;
  view.position = {0, 0, 4};
  view.view.pixel_error = 0.5;
  const auto count = [&](auto&& is_counted) {
    std::size_t n = 0;
    for (const Index face : selective.faces()) {
      n += is_counted(selective.positions()[selective.corner_vertices()[3 * face]]);
    }
    return n;
  };
  const std::size_t whole = selective.update(view).faces;
  // Away from the surface only the spheres of the coarsest splits reach into the image.
  view.target = {0, 0, 8};
  EXPECT_LT(selective.update(view).faces, 20u);
  // Its right half alone.
  view.position = {0, 0, 1.5};
  view.target = {1.5, 0, 0.5};
  selective.update(view);
  const std::size_t right = count([](const Vec3&p) { return p.x() > 0.1; }),
                    left = count([](const Vec3&p) { return p.x() < -0.1; });
  EXPECT_GT(right, 3 * left);
  // Faces that look away may be coarse, but for what finer ones beside them need.
  const auto is_behind = [](const Vec3& p) { return p.z() < -0.6; };
  view.position = {0, 0, 4};
  view.target = Vec3::Zero();
  selective.update(view);
  const std::size_t behind = count(is_behind);
  view.back_pixel_error = 50;
  EXPECT_LT(selective.update(view).faces, whole);
  EXPECT_LT(count(is_behind), behind / 2);
  // With a coarse front the rim, at right angles to the view, has most of the faces: cones of normals are
  // some 20 degrees wide.
  view.back_pixel_error = view.view.pixel_error = 20;
  view.silhouette_pixel_error = 0.5;
  selective.update(view);
  const auto is_rim = [](const Vec3& p) { return std::abs(p.normalized().z() - 0.25) < 0.5; };
  EXPECT_GT(count(is_rim), selective.n_faces() / 2);
}

class ViewsOfHardCases : public testing::TestWithParam<test::HardCase> {};

TEST_P(ViewsOfHardCases, DependOnThemselvesAlone) {
  if (!GetParam().refusal.empty()) return;
  const PolygonSoup& soup = GetParam().soup;
  ProgressiveOptions options = options_for(CostPolicy::volume, VertexPlacement::optimal);
  options.simplify.drop_parts = true;
  const ProgressiveMesh mesh = build_progressive_mesh(soup, options);
  const Box3 box = bounding_box(soup);
  const double size = box.isEmpty() || box.diagonal().norm() == 0 ? 1 : box.diagonal().norm();
  const Vec3 middle = box.isEmpty() ? Vec3(Vec3::Zero()) : Vec3(box.center());
  SelectiveMesh walking(mesh);
  std::mt19937 random(6);
  for (int i = 0; i < 6; ++i) {
    RefinementView view = random_view(random);
    view.position = middle + size * view.position;
    view.target = middle + 0.3 * size * view.target;
    if (i % 2 == 1) view.back_pixel_error = 3 * view.view.pixel_error;
    SelectiveMesh direct(mesh);
    const RefinementReport report = direct.update(view);
    EXPECT_EQ(walking.update(view).faces, report.faces);
    expect_same_bits(walking.soup(), direct.soup());
    EXPECT_FALSE(std::isnan(report.pixel_error));
    validate(direct.soup(), "view");
  }
}
INSTANTIATE_TEST_SUITE_P(All, ViewsOfHardCases, testing::ValuesIn(test::hard_cases()), test::case_name);

TEST(SelectiveMesh, SeesTheSameFarFromTheOriginAndAtAnyScale) {
  const PolygonSoup soup = make_displaced_sphere(3000, true);
  const auto faces = [&](const Vec3& offset, double scale) {
    PolygonSoup moved = soup;
    for (Vec3& p : moved.positions) p = offset + scale * p;
    const ProgressiveMesh mesh = proved(moved);
    RefinementView view;
    view.position = offset + scale * Vec3(0, 0.3, 1.6);
    view.target = offset + scale * Vec3(0.3, 0, 0);
    return static_cast<double>(SelectiveMesh(mesh).update(view).faces);
  };
  const double here = faces(Vec3::Zero(), 1);
  // Positions at the offset are rounded by 1e-9, which changes a few collapses.
  EXPECT_NEAR(faces({1e6, -2e6, 3e6}, 1), here, 0.02 * here);
  EXPECT_NEAR(faces(Vec3::Zero(), 1e9), here, 0.02 * here);
  EXPECT_NEAR(faces(Vec3::Zero(), 1e-9), here, 0.02 * here);
}

TEST(SelectiveMesh, KeepsABudgetOfFaces) {
  const ProgressiveMesh mesh = proved(make_displaced_sphere(6000, true));
  SelectiveMesh selective(mesh);
  RefinementView view;
  view.position = {0, 0.4, 2};
  view.view.pixel_error = 0.2;
  const RefinementReport free = selective.update(view);
  double before = 0;
  for (const std::size_t budget : {free.faces + 100, free.faces / 2, free.faces / 4, std::size_t{0}}) {
    view.faces = budget;
    const RefinementReport report = selective.update(view);
    EXPECT_LE(report.faces, std::max<std::size_t>(budget, mesh.level_faces[0]));
    EXPECT_GE(report.pixel_error, before);
    if (budget > free.faces) {
      EXPECT_EQ(report.faces, free.faces);
    } else if (budget > 0) {
      EXPECT_GT(report.faces, budget * 9 / 10) << "it is used";
      // The whole surface with as many faces would show this at its nearest point, one unit away. A view
      // leaves the far side and what is outside the image coarse: 0.6 of it was measured.
      const double level_error = mesh.level_errors[mesh.level_for_faces(report.faces)];
      EXPECT_LT(report.pixel_error, 0.8 * level_error / pixel_footprint(1, view.view));
    }
    before = report.pixel_error;
  }
  view.faces.reset();
  EXPECT_EQ(selective.update(view).faces, free.faces);
}

TEST(SelectiveMesh, RefusesWhatIsOutOfRange) {
  const ProgressiveMesh mesh = proved(test::grid(6));
  SelectiveMesh selective(mesh);
  const auto refuses = [&](auto&& change) {
    RefinementView view;
    change(view);
    EXPECT_THROW(selective.update(view), OptionError);
  };
  refuses([](RefinementView& v) { v.position = v.target; });
  refuses([](RefinementView& v) { v.position.x() = NAN; });
  refuses([](RefinementView& v) { v.up.x() = INFINITY; });
  refuses([](RefinementView& v) { v.view.pixel_error = 0; });
  refuses([](RefinementView& v) { v.view.image_height = -1; });
  refuses([](RefinementView& v) { v.view.field_of_view = 4; });
  refuses([](RefinementView& v) { v.aspect_ratio = 0; });
  refuses([](RefinementView& v) { v.back_pixel_error = -1; });
  refuses([](RefinementView& v) { v.silhouette_pixel_error = 2; });
  EXPECT_THROW(selective.update(-1.0), OptionError);
  EXPECT_EQ(selective.n_faces(), mesh.level_faces[0]);
}

TEST(SelectiveMesh, OfNothingHasNoFaces) {
  const ProgressiveMesh mesh = proved({});
  SelectiveMesh selective(mesh);
  EXPECT_EQ(selective.update(RefinementView{}).faces, 0u);
}

}  // namespace
}  // namespace recede
