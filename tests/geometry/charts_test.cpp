#include "chart_checks.h"
#include "meshes.h"
#include <recede/geometry/detail/chart_surface.h>
#include <recede/geometry/error.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace recede {
namespace {

using ::testing::ElementsAre;

std::size_t refused(const Charts& charts, ChartRefusal reason) {
  return charts.report.refused[static_cast<std::size_t>(reason)];
}

/// A box of twelve triangles.
PolygonSoup box_of_triangles() {
  PolygonSoup soup = test::soup_of(
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}, {});
  const Index quads[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                             {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  for (const auto& q : quads) {
    soup.add_face(std::vector<Index>{q[0], q[1], q[2]});
    soup.add_face(std::vector<Index>{q[0], q[2], q[3]});
  }
  return soup;
}

/// A torus of n x 2n quads.
PolygonSoup torus(Index n) {
  PolygonSoup soup;
  const double turn = 2 * std::numbers::pi;
  for (Index i = 0; i < 2 * n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double a = turn * i / (2.0 * n), b = turn * j / n;
      soup.positions.emplace_back((2 + std::cos(b)) * std::cos(a), (2 + std::cos(b)) * std::sin(a),
                                  std::sin(b));
    }
  }
  const auto at = [n](Index i, Index j) { return i % (2 * n) * n + j % n; };
  for (Index i = 0; i < 2 * n; ++i) {
    for (Index j = 0; j < n; ++j) {
      soup.add_face(std::vector<Index>{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

TEST(Charts, ABoxHasSixAndEveryVertexIsACorner) {
  const Charts charts = make_charts(box_of_triangles());
  EXPECT_THAT(charts.face_charts, ElementsAre(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5));
  EXPECT_EQ(charts.report.charts, 6u);
  EXPECT_EQ(charts.report.merges, 6u);
  // Two coplanar halves: no deviation, and the perimeter of the unit square squared.
  EXPECT_NEAR(charts.report.largest_cost, 16, 1e-12);
  EXPECT_NEAR(charts.report.cut_length, 12, 1e-12);
  EXPECT_EQ(refused(charts, ChartRefusal::bend), 12u);
  for (const VertexPlace place : charts.vertex_places) EXPECT_EQ(place, VertexPlace::corner);
}

// Erratum 19: the printed sum is least for folded charts.
TEST(Charts, CoplanarNeighboursMergeBeforeFoldedOnes) {
  PolygonSoup soup =
      test::soup_of({{0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 1}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}},
                    {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}});
  const Charts charts = make_charts(soup, {.charts = 2});
  EXPECT_THAT(charts.face_charts, ElementsAre(0, 1, 1));
  EXPECT_NEAR(charts.report.largest_cost, 36, 1e-12);
  // The fold costs its deviation more: A - |sum of vector areas| = 3 - |(1, 0, 2)|; the strip is 3 by 1.
  EXPECT_NEAR(make_charts(soup, {.charts = 1}).report.largest_cost, 64 + 3 - std::sqrt(5), 1e-12);
  EXPECT_NEAR(make_charts(soup, {.charts = 1, .compactness = 0}).report.largest_cost, 3 - std::sqrt(5),
              1e-12);
}

TEST(Charts, ATetrahedronKeepsItsFacesUnlessCornersDontMatter) {
  const PolygonSoup soup = test::soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                         {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
  const Charts corners = make_charts(soup, {.charts = 1});
  EXPECT_EQ(corners.report.charts, 4u);
  EXPECT_EQ(refused(corners, ChartRefusal::few_corners), 6u);
  const Charts any = make_charts(soup, {.charts = 1, .least_corners = 0});
  EXPECT_EQ(any.report.charts, 2u) << "closed: one disk can't cover it";
  EXPECT_EQ(refused(any, ChartRefusal::no_disk), 1u);
  test::expect_disks(soup, any.face_charts);
}

TEST(Charts, AFlatSheetIsOneChartWhoseBorderVerticesCountAsCorners) {
  for (const bool triangles : {false, true}) {
    const Charts charts = make_charts(test::grid(6, triangles));
    EXPECT_EQ(charts.report.charts, 1u);
    EXPECT_EQ(charts.report.border_edges, 24u);
    EXPECT_EQ(charts.vertex_places[0], VertexPlace::boundary);
    EXPECT_EQ(charts.vertex_places[8], VertexPlace::interior);
  }
}

TEST(Charts, ATorusIsCutIntoDisks) {
  const PolygonSoup soup = torus(12);
  for (const std::size_t wanted : {1u, 5u, 20u}) {
    const Charts charts = make_charts(soup, {.charts = wanted});
    EXPECT_GE(charts.report.charts, wanted);
    if (wanted > 10) {
      EXPECT_EQ(charts.report.charts, wanted);
    } else {
      EXPECT_GT(refused(charts, ChartRefusal::no_disk) + refused(charts, ChartRefusal::few_corners), 0u);
    }
    EXPECT_GT(charts.report.cut_length, 2 * 3.14);
    test::expect_disks(soup, charts.face_charts);
  }
}

TEST(Charts, MaterialsFeatureEdgesAndSeamsAreNotCrossed) {
  PolygonSoup soup = test::grid(4);
  soup.materials.resize(2);
  for (std::size_t f = 0; f < 16; ++f) soup.face_materials.push_back(f < 8 ? 0 : 1);
  EXPECT_EQ(make_charts(soup).report.charts, 2u);
  EXPECT_EQ(make_charts(soup).report.kept_edges, 4u);
  EXPECT_EQ(make_charts(soup, {.keep_materials = false}).report.charts, 1u);

  soup = test::grid(4);
  for (Index i = 0; i < 4; ++i) soup.feature_edges.emplace_back(11 + i, 10 + i);
  EXPECT_EQ(make_charts(soup).report.charts, 2u);
  EXPECT_EQ(make_charts(soup, {.keep_feature_edges = false}).report.charts, 1u);
  soup.feature_edges.pop_back();  // one edge is open: a chart with a slit
  EXPECT_EQ(make_charts(soup).report.charts, 1u);

  soup = test::grid(4);
  for (std::size_t c = 0; c < soup.n_corners(); ++c) soup.corner_uvs.emplace_back(c < 32 ? 0.0 : 1.0, 0.0);
  EXPECT_EQ(make_charts(soup).report.charts, 1u);
  EXPECT_EQ(make_charts(soup, {.keep_uv_seams = true}).report.charts, 2u);
}

TEST(Charts, EdgesOfThreeFacesAndFacesThatDisagreeAreBorders) {
  PolygonSoup soup = test::soup_of({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}},
                                   {{0, 2, 1}, {1, 3, 0}, {0, 4, 1}});
  EXPECT_EQ(make_charts(soup).report.charts, 3u);
  EXPECT_EQ(make_charts(soup).report.non_manifold_edges, 1u);
  soup = test::soup_of({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}}, {{0, 2, 1}, {0, 3, 1}});
  EXPECT_EQ(make_charts(soup).report.charts, 2u);
  EXPECT_EQ(make_charts(soup).report.non_manifold_edges, 1u);
}

TEST(Charts, FacesThatVisitAVertexTwiceStandAlone) {
  const PolygonSoup soup = test::soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                                         {{0, 1, 2}, {0, 0, 2}, {0, 2, 3}, {1, 2, 1, 0}});
  const Charts charts = make_charts(soup);
  EXPECT_EQ(charts.face_charts.size(), 4u);
  test::expect_disks(soup, charts.face_charts);
}

/// The whole definition, over all pairs in every step; for closed surfaces without vertices at which a chart
/// touches itself.
std::vector<Index> charts_by_brute_force(const PolygonSoup& soup, std::size_t wanted, double bend_limit) {
  const test::GluedFaces glued(soup);
  std::vector<Index> chart(soup.n_faces());
  std::iota(chart.begin(), chart.end(), Index{0});
  const auto never = [](Index) { return false; };
  for (std::size_t n = soup.n_faces(); n > wanted; --n) {
    double best = std::numeric_limits<double>::infinity();
    std::pair<Index, Index> pair;
    std::set<std::pair<Index, Index>> pairs;
    for (Index side = 0; side < soup.n_corners(); ++side) {
      const Index a = chart[glued.face_of(side)], b = chart[glued.face_of(glued.opposite(side))];
      if (a < b) pairs.emplace(a, b);
    }
    for (const auto& [a, b] : pairs) {
      std::vector<Index> faces, merged = chart;
      Vec3 normal = Vec3::Zero();
      double area = 0, perimeter = 0;
      for (Index f = 0; f < soup.n_faces(); ++f) {
        if (chart[f] != a && chart[f] != b) continue;
        merged[f] = a;
        faces.push_back(f);
        normal += vector_area(soup, f);
        area += vector_area(soup, f).norm();
      }
      double deviation = 0;
      for (const Index f : faces) {
        const Vec3 v = vector_area(soup, f);
        deviation += v.norm() - normal.normalized().dot(v);
      }
      if (deviation > bend_limit * area || !glued.is_disk(faces, never)) continue;
      std::map<Index, std::set<Index>> around;
      for (Index side = 0; side < soup.n_corners(); ++side) {
        around[soup.corner_vertices[side]].insert(merged[glued.face_of(side)]);
        if (merged[glued.face_of(side)] != a || merged[glued.face_of(glued.opposite(side))] == a) continue;
        const Index other = glued.opposite(side);
        perimeter +=
            (soup.positions[soup.corner_vertices[side]] - soup.positions[soup.corner_vertices[other]]).norm();
      }
      const auto corners = std::count_if(around.begin(), around.end(), [a = a](const auto& v) {
        return v.second.contains(a) && v.second.size() > 2;
      });
      if (corners < 3) continue;
      const double cost = deviation + perimeter * perimeter;
      if (cost < best) {
        best = cost;
        pair = {a, b};
      }
    }
    if (best == std::numeric_limits<double>::infinity()) break;
    std::replace(chart.begin(), chart.end(), pair.second, pair.first);
  }
  std::map<Index, Index> numbers;
  for (Index& c : chart) c = numbers.try_emplace(c, static_cast<Index>(numbers.size())).first->second;
  return chart;
}

TEST(Charts, AreThoseOfTheDefinition) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    PolygonSoup soup = seed % 2 == 0 ? make_displaced_sphere(90, seed % 4 == 0) : torus(7);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> noise(-0.05, 0.05);
    for (Vec3& p : soup.positions) p += Vec3(noise(random), noise(random), noise(random));
    for (const std::size_t wanted : {30u, 1u}) {
      for (const double bend : {0.1, 1.0}) {
        const Charts charts = make_charts(soup, {.charts = wanted, .bend_limit = bend, .straighten = false});
        EXPECT_EQ(charts.face_charts, charts_by_brute_force(soup, wanted, bend)) << "seed " << seed;
      }
    }
  }
}

TEST(Charts, StraighteningShortensCutsAndKeepsCornersAndDisks) {
  for (const PolygonSoup& soup : {make_displaced_sphere(4000, true), make_teapot(8, 0.02), torus(20)}) {
    for (const std::size_t wanted : {12u, 60u}) {
      const Charts jagged = make_charts(soup, {.charts = wanted, .straighten = false});
      const Charts straight = make_charts(soup, {.charts = wanted});
      EXPECT_GT(straight.report.straightened, 0u);
      EXPECT_LT(straight.report.cut_length, jagged.report.cut_length);
      EXPECT_EQ(straight.report.charts, jagged.report.charts);
      test::expect_disks(soup, straight.face_charts);
      Index next = 0;
      for (const Index chart : straight.face_charts) {
        EXPECT_LE(chart, next) << "numbered by the lowest face";
        if (chart == next) ++next;
      }
      for (std::size_t v = 0; v < soup.positions.size(); ++v) {
        EXPECT_EQ(straight.vertex_places[v] == VertexPlace::corner,
                  jagged.vertex_places[v] == VertexPlace::corner);
      }
    }
  }
}

TEST(Charts, AJaggedBorderBecomesTheStraightLine) {
  // Columns of cells 0-3 and 4-7 of a grid; in rows 2, 4 and 5 the border runs a column further right.
  const PolygonSoup soup = test::grid(8, true);
  ChartReport report;
  detail::ChartSurface surface(soup, {}, report);
  const auto column = [](std::size_t face) { return face / 2 / 8; };
  const auto row = [](std::size_t face) { return face / 2 % 8; };
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const std::size_t width = row(f) == 2 || row(f) == 4 || row(f) == 5 ? 5 : 4;
    surface.chart_of[f] = column(f) < width ? 0 : 1;
  }
  EXPECT_NEAR(detail::cut_length(surface), 1.5, 1e-12);
  EXPECT_EQ(detail::straighten_borders(surface, nullptr), 1u);
  EXPECT_NEAR(detail::cut_length(surface), 1, 1e-12);
  for (std::size_t f = 0; f < soup.n_faces(); ++f) EXPECT_EQ(surface.chart_of[f], column(f) < 4 ? 0u : 1u);
  EXPECT_EQ(detail::straighten_borders(surface, nullptr), 0u) << "nothing is left to do";
}

TEST(Charts, AStraightWayDoesntPassOtherBorders) {
  // Chart 2 is a wedge that pushes the border of 0 and 1 aside: the way around it stays, though it is longer.
  const PolygonSoup soup = test::grid(8, true);
  ChartReport report;
  detail::ChartSurface surface(soup, {}, report);
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const std::size_t column = f / 2 / 8, row = f / 2 % 8;
    const bool wedge = row >= 3 && row < 5 && column < 6;
    surface.chart_of[f] = wedge ? 2 : row < 4 && column < 7 ? 0 : 1;
  }
  detail::straighten_borders(surface, nullptr);
  test::expect_disks(soup, surface.chart_of);
  std::size_t in_wedge = 0;
  for (const Index chart : surface.chart_of) in_wedge += chart == 2 ? 1 : 0;
  EXPECT_GT(in_wedge, 0u);
}

TEST(Charts, SizeAndPlaceOfTheModelDontMatter) {
  const PolygonSoup soup = make_displaced_sphere(1000, true);
  const Charts charts = make_charts(soup, {.charts = 30});
  for (const double scale : {0x1p-200, 0x1p300, 0x1p-700}) {
    PolygonSoup scaled = soup;
    for (Vec3& p : scaled.positions) p *= scale;
    EXPECT_EQ(make_charts(scaled, {.charts = 30}).face_charts, charts.face_charts);
  }
}

TEST(Charts, LimitsStopMerging) {
  const PolygonSoup soup = make_displaced_sphere(1000, true);
  const Charts all = make_charts(soup, {.cost_limit = 0.5});
  EXPECT_LE(all.report.largest_cost, 0.5);
  EXPECT_GT(refused(all, ChartRefusal::limit), 0u);
  EXPECT_EQ(make_charts(soup, {.bend_limit = 0}).report.merges, 0u) << "nothing is flat";
  EXPECT_THROW(make_charts(soup, {.bend_limit = -1}), OptionError);
  EXPECT_THROW(make_charts(soup, {.compactness = std::nan("")}), OptionError);
  EXPECT_EQ(make_charts(PolygonSoup()).report.charts, 0u);
}

}  // namespace
}  // namespace recede
