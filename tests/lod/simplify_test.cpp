#include "meshes.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/simplify.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <array>
#include <numbers>
#include <set>

namespace recede {
namespace {

using test::expect_sound;
using test::mesh_of;

SimplifyOptions to_ratio(double ratio, CostPolicy cost = CostPolicy::volume) {
  SimplifyOptions options;
  options.target.ratio = ratio;
  options.cost = cost;
  return options;
}

SimplifyOptions to_faces(std::size_t faces, CostPolicy cost = CostPolicy::volume) {
  SimplifyOptions options;
  options.target.faces = faces;
  options.cost = cost;
  return options;
}

constexpr CostPolicy k_policies[] = {CostPolicy::volume, CostPolicy::normal_deviation};

// A flat grid needs its four corners and nothing else: (0,0) --- (1,0) --- (1,1) --- (0,1).
TEST(Simplify, ReducesAFlatGridToItsCornersExactly) {
  for (const bool triangles : {false, true}) {
    const PolygonMesh mesh = mesh_of(test::grid(16, triangles));
    const SimplifyResult result = simplify(mesh, to_faces(2));
    expect_sound(result.mesh);
    EXPECT_LE(result.faces_after, 2u);
    const MeshDistance distance = measure_distance(mesh, result.mesh, {.bound_tolerance = 0.1});
    // The pull of 1e-7 of the weights, refined once, leaves its square, 1e-14, for each of some hundred
    // collapses.
    EXPECT_LT(*distance.max_bound, 1e-11);
  }
}

TEST(Simplify, NormalDeviationKeepsAFlatGridFlatAndItsOutline) {
  const PolygonMesh mesh = mesh_of(test::grid(16));
  SimplifyOptions options;
  options.cost = CostPolicy::normal_deviation;
  const SimplifyResult result = simplify(mesh, options);
  expect_sound(result.mesh);
  EXPECT_EQ(result.stop_reason, StopReason::no_collapse_left);
  EXPECT_LT(result.faces_after, 20u);
  EXPECT_LT(*measure_distance(mesh, result.mesh, {.bound_tolerance = 0.1}).max_bound, 1e-12);
}

TEST(Simplify, StopsAtEveryKindOfTarget) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(3000, true));
  EXPECT_EQ(simplify(mesh, to_faces(500)).faces_after, 500u);
  EXPECT_EQ(simplify(mesh, to_faces(500)).stop_reason, StopReason::face_target);
  SimplifyOptions options;
  options.target.vertices = 300;
  EXPECT_EQ(simplify(mesh, options).vertices_after, 300u);
  EXPECT_EQ(simplify(mesh, options).stop_reason, StopReason::vertex_target);
  options.target = {};
  options.target.relative_error = 0.01;
  const double limit = 0.01 * summarize(mesh).box.diagonal().norm();
  const SimplifyResult by_error = simplify(mesh, options);
  EXPECT_EQ(by_error.stop_reason, StopReason::error_target);
  ASSERT_TRUE(by_error.error_bound);
  EXPECT_LE(*by_error.error_bound, limit);
  EXPECT_GE(*by_error.error_bound, 0.5 * limit) << "coarser was possible";
  EXPECT_LT(by_error.faces_after, mesh.n_faces() / 4);
  options.prove_error = false;
  const SimplifyResult by_estimate = simplify(mesh, options);
  EXPECT_EQ(by_estimate.stop_reason, StopReason::error_target);
  EXPECT_LE(by_estimate.error_estimate, limit);
  EXPECT_FALSE(by_estimate.error_bound);
  options.target.faces = 2000;
  EXPECT_EQ(simplify(mesh, options).stop_reason, StopReason::face_target)
      << "the first that is reached stops";
}

TEST(Simplify, MakesNoUnsoundPolygonAtAnyLevel) {
  for (const CostPolicy cost : k_policies) {
    for (const auto& soup : {make_displaced_sphere(3000, true), make_displaced_sphere(3000, false),
                             make_teapot(8), test::hexagon_sheet(20), test::prism(12)}) {
      for (const double ratio : {0.5, 0.1, 0.01}) {
        SimplifyOptions options = to_ratio(ratio, cost);
        options.normal_threshold = 0.5;
        expect_sound(simplify(mesh_of(soup), options).mesh);
      }
    }
  }
}

TEST(Simplify, ClosedMeshesStayClosedAndKeepTheirGenus) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(6000, true));
  for (const CostPolicy cost : k_policies) {
    const MeshSummary summary = summarize(simplify(mesh, to_ratio(0.02, cost)).mesh);
    EXPECT_EQ(summary.border_edges, 0u);
    EXPECT_EQ(summary.vertices + summary.faces - summary.edges, 2u);
  }
}

// Claim 9: (removed polygons + sides lost by those that stay) / 2 = interior collapses.
TEST(Simplify, EveryInteriorCollapseTakesTwoPolygonsOrSides) {
  for (const CostPolicy cost : k_policies) {
    for (const auto& soup :
         {make_displaced_sphere(2000, false), make_displaced_sphere(2000, true), test::prism(40)}) {
      SimplifyOptions options = to_ratio(0.3, cost);
      options.normal_threshold = 0;
      const SimplifyResult result = simplify(mesh_of(soup), options);
      EXPECT_GT(result.interior_collapses, 0u);
      EXPECT_EQ(result.removed_faces + result.lost_sides, 2 * result.interior_collapses);
      EXPECT_EQ(result.collapses, result.interior_collapses) << "closed meshes have interior edges only";
      EXPECT_EQ(result.faces_before - result.faces_after, result.removed_faces);
    }
  }
}

// Claim 34: triangles appear as quads lose sides, and large polygons persist.
TEST(Simplify, LargePolygonsPersist) {
  SimplifyOptions options;
  options.cost = CostPolicy::normal_deviation;
  const SimplifyResult result = simplify(mesh_of(test::hexagon_sheet(30)), options);
  const MeshSummary summary = summarize(result.mesh);
  EXPECT_GT(summary.larger_polygons, 0u);
  EXPECT_GT(summary.triangles, 0u);
}

// Claim 10.
TEST(Simplify, HalfEdgeCollapsesKeepASubsetOfTheVertices) {
  const PolygonSoup input = make_displaced_sphere(3000, false);
  std::set<std::array<double, 3>> known;
  for (const Vec3& p : input.positions) known.insert({p.x(), p.y(), p.z()});
  for (const CostPolicy cost : k_policies) {
    SimplifyOptions options = to_ratio(0.2, cost);
    options.placement = VertexPlacement::half_edge;
    const PolygonMesh mesh = mesh_of(input);
    for (const Vec3& p : to_soup(simplify(mesh, options).mesh).positions)
      EXPECT_TRUE(known.contains({p.x(), p.y(), p.z()})) << p.transpose();
  }
}

TEST(Simplify, MostQuadsOfAQuadModelStayQuads) {
  for (const CostPolicy cost : k_policies) {
    const PolygonMesh mesh = mesh_of(make_displaced_sphere(15'000, false));
    SimplifyOptions options;
    options.cost = cost;
    options.target.vertices = mesh.n_vertices() / 4;
    const MeshSummary summary = summarize(simplify(mesh, options).mesh);
    EXPECT_GT(double(summary.quads), 0.5 * double(summary.faces));
  }
}

TEST(Simplify, NormalDeviationNeverTurnsAPolygonBeyondItsThreshold) {
  // A cylinder of 64 sides: neighbours differ by 5.6 degrees; 0.99 permits turns of 8.1 degrees, 0.999
  // of 2.6.
  const PolygonMesh mesh = mesh_of(test::prism(64));
  SimplifyOptions options;
  options.cost = CostPolicy::normal_deviation;
  options.normal_threshold = 0.9999;
  EXPECT_EQ(simplify(mesh, options).collapses, 0u);
  options.normal_threshold = 0.99;
  EXPECT_GT(simplify(mesh, options).collapses, 0u);
}

// Claim 32: what a lower threshold permits includes what a higher one does.
TEST(Simplify, ALowerThresholdGoesFurther) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(6000, true));
  SimplifyOptions options;
  options.cost = CostPolicy::normal_deviation;
  std::size_t before = mesh.n_faces();
  for (const double threshold : {0.999, 0.99, 0.9, 0.5}) {
    options.normal_threshold = threshold;
    const std::size_t after = simplify(mesh, options).faces_after;
    EXPECT_LT(after, before);
    before = after;
  }
}

// Claim 30: few candidates do as well as all.
TEST(Simplify, OnePercentOfTheCandidatesIsAsGoodAsAll) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(10'000, true));
  SimplifyOptions options = to_ratio(0.25, CostPolicy::normal_deviation);
  options.candidate_share = 1;
  const double all = measure_distance(mesh, simplify(mesh, options).mesh).rms;
  options.candidate_share = 0.01;
  const double few = measure_distance(mesh, simplify(mesh, options).mesh).rms;
  EXPECT_LT(few, 1.15 * all) << "the source calls the results practically equal";
}

TEST(Simplify, BordersMoveOnlyAlongThemselves) {
  // A half sphere: the rim is a circle in the plane z = 0.
  PolygonSoup soup;
  constexpr Index n = 48, rings = 12;
  for (Index r = 0; r < rings; ++r) {
    for (Index i = 0; i < n; ++i) {
      const double polar = std::numbers::pi / 2 * (1 - double(r) / rings),
                   angle = 2 * std::numbers::pi * i / n;
      soup.positions.emplace_back(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle),
                                  r == 0 ? 0 : std::cos(polar));
    }
  }
  for (Index r = 0; r + 1 < rings; ++r) {
    for (Index i = 0; i < n; ++i) {
      const Index a = r * n + i, b = r * n + (i + 1) % n;
      soup.add_face(std::vector<Index>{a, b, b + n, a + n});
    }
  }
  const PolygonMesh mesh = mesh_of(soup);
  const PolygonMesh coarse = simplify(mesh, to_faces(100)).mesh;
  expect_sound(coarse);
  EXPECT_EQ(summarize(coarse).border_loops, 2u);
  std::size_t on_rim = 0;
  for (const auto h : coarse.halfedges()) {
    if (!coarse.is_boundary(h)) continue;
    const Vec3 p = coarse.point(coarse.to_vertex_handle(h));
    if (p.z() > 0.5) continue;  // the small opening at the top
    ++on_rim;
    EXPECT_NEAR(p.z(), 0, 1e-6) << "the pull towards the edge's middle is 1e-7 of the planes";
  }
  EXPECT_GE(on_rim, 3u);
  EXPECT_LT(on_rim, n);
}

TEST(Simplify, LockedBordersStayToTheLastBit) {
  const PolygonMesh mesh = mesh_of(test::grid(8));
  SimplifyOptions options = to_faces(1);
  options.lock_borders = true;
  const SimplifyResult result = simplify(mesh, options);
  EXPECT_EQ(summarize(result.mesh).border_edges, 32u);
  EXPECT_EQ(result.stop_reason, StopReason::no_collapse_left);
  const auto border_of = [](const PolygonMesh& of) {
    std::set<std::array<double, 3>> points;
    for (const auto v : of.vertices()) {
      if (of.is_boundary(v)) points.insert({of.point(v)[0], of.point(v)[1], of.point(v)[2]});
    }
    return points;
  };
  EXPECT_EQ(border_of(result.mesh), border_of(mesh));
}

/// A grid of two materials side by side with a straight border between them at x = 1/2.
PolygonSoup two_materials() {
  PolygonSoup soup = test::grid(16, true);
  soup.materials = {{"left", {1, 0, 0, 1}, ""}, {"right", {0, 1, 0, 1}, ""}};
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    double x = 0;
    for (const Index v : soup.face(f)) x += soup.positions[v].x() / 3;
    soup.face_materials.push_back(x < 0.5 ? 0 : 1);
  }
  return soup;
}

double area_of_material(const PolygonMesh& mesh, Index material) {
  const PolygonSoup soup = to_soup(mesh);
  double area = 0;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    if (soup.face_materials[f] == material) area += vector_area(soup, f).norm();
  }
  return area;
}

TEST(Simplify, MaterialBordersStay) {
  for (const CostPolicy cost : k_policies) {
    const SimplifyResult result = simplify(mesh_of(two_materials()), to_faces(8, cost));
    expect_sound(result.mesh);
    EXPECT_LE(result.faces_after, 12u);
    // What the pull towards the middle leaves; see ReducesAFlatGridToItsCornersExactly.
    EXPECT_NEAR(area_of_material(result.mesh, 0), 0.5, 1e-11);
    EXPECT_NEAR(area_of_material(result.mesh, 1), 0.5, 1e-11);
    ASSERT_EQ(result.mesh.materials.size(), 2u);
    EXPECT_EQ(result.mesh.materials[1].name, "right");
  }
}

TEST(Simplify, TextureCoordinatesSurviveOnBothSidesOfASeam) {
  PolygonSoup soup = test::grid(16, true);
  // uv = xy, but shifted by 10 on the right half: a seam at x = 1/2.
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    double x = 0;
    for (const Index v : soup.face(f)) x += soup.positions[v].x() / 3;
    for (const Index v : soup.face(f)) {
      soup.corner_uvs.emplace_back(soup.positions[v].x() + (x < 0.5 ? 0 : 10), soup.positions[v].y());
    }
  }
  for (const CostPolicy cost : k_policies) {
    const SimplifyResult result = simplify(mesh_of(soup), to_faces(10, cost));
    EXPECT_LE(result.faces_after, 14u);
    const PolygonSoup coarse = to_soup(result.mesh);
    for (std::size_t c = 0; c < coarse.n_corners(); ++c) {
      const Vec3& p = coarse.positions[coarse.corner_vertices[c]];
      const double shift = coarse.corner_uvs[c].x() > 5 ? 10 : 0;
      EXPECT_NEAR(coarse.corner_uvs[c].x() - shift, p.x(), 1e-12);
      EXPECT_NEAR(coarse.corner_uvs[c].y(), p.y(), 1e-12);
      EXPECT_TRUE(shift == 10 ? p.x() > 0.5 - 1e-12 : p.x() < 0.5 + 1e-12);
    }
  }
}

TEST(Simplify, NormalsStayUnitAndColoursInRange) {
  PolygonSoup soup = make_displaced_sphere(2000, true);
  for (const Index v : soup.corner_vertices) soup.corner_normals.push_back(soup.positions[v].normalized());
  for (const Vec3& p : soup.positions) {
    soup.vertex_colors.push_back(Vec4(0.5 + 0.25 * p.x(), 0.5 + 0.25 * p.y(), 0.5 + 0.25 * p.z(), 1));
  }
  const SimplifyResult result = simplify(mesh_of(soup), to_ratio(0.05));
  EXPECT_EQ(result.stop_reason, StopReason::face_target);
  const PolygonSoup coarse = to_soup(result.mesh);
  for (std::size_t c = 0; c < coarse.n_corners(); ++c) {
    EXPECT_NEAR(coarse.corner_normals[c].norm(), 1, 1e-12);
    EXPECT_GT(coarse.corner_normals[c].dot(coarse.positions[coarse.corner_vertices[c]]), 0);
  }
  for (std::size_t v = 0; v < coarse.positions.size(); ++v) {
    const Vec3 expected = Vec3::Constant(0.5) + 0.25 * coarse.positions[v];
    // Linear along each collapsed edge of a curved surface: off by some of the edge's length, 0.3 at this
    // level.
    EXPECT_LT((coarse.vertex_colors[v].head<3>() - expected).norm(), 0.05);
  }
}

TEST(Simplify, FeatureEdgesStay) {
  // A box of 6 x 8 x 8 quads: its twelve sharp edges, marked, keep its shape exactly down to the box itself.
  PolygonSoup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const PolygonSoup square = test::grid(8);
      const auto base = static_cast<Index>(soup.positions.size());
      for (const Vec3& p : square.positions) {
        Vec3 q;
        q[axis] = side;
        q[(axis + 1) % 3] = p.x();
        q[(axis + 2) % 3] = p.y();
        soup.positions.push_back(q);
      }
      for (std::size_t f = 0; f < square.n_faces(); ++f) {
        std::vector<Index> face;
        for (const Index v : square.face(f)) face.push_back(base + v);
        if (side == 0) std::reverse(face.begin(), face.end());
        soup.add_face(face);
      }
    }
  }
  PolygonMesh mesh = mesh_of(soup);
  EXPECT_EQ(mark_feature_edges(mesh, 1.0), 96u);
  const SimplifyResult result = simplify(mesh, to_faces(12));
  expect_sound(result.mesh);
  EXPECT_LE(result.faces_after, 12u);
  EXPECT_LT(*measure_distance(mesh, result.mesh, {.bound_tolerance = 0.1}).max_bound, 1e-9);
  std::size_t features = 0;
  for (const auto e : result.mesh.edges())
    if (result.mesh.is_feature_edge(e)) ++features;
  EXPECT_GE(features, 12u);
}

// Both halves of a sheet have vertices of their own along a line between them, which is marked on those of
// one. A face that visits a point twice, of which nothing is left, doesn't change what that means.
TEST(Simplify, FeatureEdgesOfVerticesThatMeetStayBesideAFaceWithoutArea) {
  constexpr Index n = 8, half = n / 2;
  PolygonSoup soup = test::grid(n, true);
  const Index first_copy = static_cast<Index>(soup.positions.size());
  for (Index j = 0; j <= n; ++j) soup.positions.push_back(soup.positions[half * (n + 1) + j]);
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    double x = 0;
    for (const Index v : soup.face(f)) x += soup.positions[v].x() / 3;
    for (Index c = soup.face_offsets[f]; c < soup.face_offsets[f + 1] && x > 0.5; ++c) {
      Index& v = soup.corner_vertices[c];
      if (v / (n + 1) == half && v < first_copy) v = first_copy + v % (n + 1);
    }
  }
  for (Index j = 0; j < n; ++j) soup.feature_edges.emplace_back(first_copy + j, first_copy + j + 1);
  soup.add_face(std::vector<Index>{half * (n + 1), half * (n + 1) + 1, first_copy});
  for (const CostPolicy cost : k_policies) {
    const PolygonSoup coarse = simplify(soup, to_faces(4, cost)).soup;
    double length = 0;
    for (const auto& [a, b] : coarse.feature_edges) {
      EXPECT_EQ(coarse.positions[a].x(), 0.5);
      EXPECT_EQ(coarse.positions[b].x(), 0.5);
      length += (coarse.positions[a] - coarse.positions[b]).norm();
    }
    EXPECT_DOUBLE_EQ(length, 1);
  }
}

// Three sheets that share a spine along z, like an open book seen from above:  \|/
TEST(Simplify, SheetsOnACommonSpineStayTogether) {
  constexpr Index n = 12;
  PolygonSoup soup;
  for (Index i = 0; i <= n; ++i) soup.positions.emplace_back(0, 0, double(i) / n);
  for (int sheet = 0; sheet < 3; ++sheet) {
    const double angle = 2.0 * sheet;
    const auto base = static_cast<Index>(soup.positions.size());
    for (Index j = 1; j <= n; ++j) {
      for (Index i = 0; i <= n; ++i) {
        soup.positions.emplace_back(std::cos(angle) * j / n, std::sin(angle) * j / n, double(i) / n);
      }
    }
    for (Index j = 0; j < n; ++j) {
      for (Index i = 0; i < n; ++i) {
        const auto vertex = [&](Index jj, Index ii) { return jj == 0 ? ii : base + (jj - 1) * (n + 1) + ii; };
        soup.add_face(
            std::vector<Index>{vertex(j, i), vertex(j + 1, i), vertex(j + 1, i + 1), vertex(j, i + 1)});
      }
    }
  }
  for (const CostPolicy cost : k_policies) {
    const PolygonMesh mesh = mesh_of(soup);
    const SimplifyResult result = simplify(mesh, to_faces(6, cost));
    expect_sound(result.mesh, 3);
    EXPECT_LE(result.faces_after, 20u);
    PolygonSoup coarse = to_soup(result.mesh);
    merge_identical_vertices(coarse);
    double spine = 0;
    for (const auto& [edge, count] : test::edge_counts(coarse)) {
      if (count == 3) spine += (coarse.positions[edge.first] - coarse.positions[edge.second]).norm();
    }
    EXPECT_NEAR(spine, 1, 1e-9) << "the spine keeps its length and its three sheets";
    EXPECT_LT(*measure_distance(mesh, result.mesh, {.bound_tolerance = 0.1}).max_bound, 1e-9);
  }
}

TEST(Simplify, AClosedTetrahedronCannotShrink) {
  const PolygonMesh mesh = mesh_of(test::soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                                 {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}));
  for (const CostPolicy cost : k_policies) {
    SimplifyOptions options = to_faces(1, cost);
    options.normal_threshold = -1;
    const SimplifyResult result = simplify(mesh, options);
    EXPECT_EQ(result.faces_after, 4u);
    EXPECT_EQ(result.stop_reason, StopReason::no_collapse_left);
  }
}

TEST(Simplify, CountsRefusalsByReason) {
  const SimplifyResult result = simplify(mesh_of(make_displaced_sphere(1000, true)), to_faces(1));
  EXPECT_EQ(result.stop_reason, StopReason::no_collapse_left);
  EXPECT_GT(
      result.refused[Refusal::topology] + result.refused[Refusal::duplicate] + result.refused[Refusal::flip],
      0u);
}

TEST(Simplify, SameBytesForAnyNumberOfThreads) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(20'000, false));
  for (const CostPolicy cost : k_policies) {
    std::vector<PolygonSoup> results;
    for (const std::size_t threads : {1u, 2u}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      results.push_back(to_soup(simplify(mesh, to_ratio(0.1, cost)).mesh));
    }
    EXPECT_EQ(results[0].positions, results[1].positions);
    EXPECT_EQ(results[0].corner_vertices, results[1].corner_vertices);
  }
}

TEST(Simplify, FarFromTheOriginNothingChangesButRounding) {
  PolygonSoup soup = make_displaced_sphere(5000, true);
  const PolygonMesh near = mesh_of(soup);
  const double here = measure_distance(near, simplify(near, to_ratio(0.1)).mesh).rms;
  for (Vec3& p : soup.positions) p += Vec3(1e5, -1e5, 1e5);
  const PolygonMesh far = mesh_of(soup);
  const double there = measure_distance(far, simplify(far, to_ratio(0.1)).mesh).rms;
  // Positions keep 1e-11 of their digits, which may change the order of near ties but not the quality.
  EXPECT_NEAR(there, here, 0.02 * here);
}

TEST(Simplify, LevelsOfOneRunAreThoseOfTheirTargets) {
  const PolygonMesh mesh = mesh_of(make_displaced_sphere(5000, true));
  std::vector<SimplifyTarget> targets(3);
  targets[0].ratio = 0.5;
  targets[1].ratio = 0.25;
  targets[2].faces = 100;
  const std::vector<SimplifyResult> results = simplify_levels(mesh, targets);
  ASSERT_EQ(results.size(), 3u);
  // A closed triangle mesh has an even number of faces and loses two at a time.
  EXPECT_EQ(results[0].faces_after, mesh.n_faces() / 2 / 2 * 2);
  EXPECT_EQ(results[1].faces_after, mesh.n_faces() / 4 / 2 * 2);
  EXPECT_EQ(results[2].faces_after, 100u);
  EXPECT_LT(results[0].error_estimate, results[2].error_estimate);
}

TEST(Simplify, RefusesOptionsOutOfRange) {
  const PolygonMesh mesh = mesh_of(test::grid(2));
  SimplifyOptions options = to_ratio(1.5);
  EXPECT_THROW(simplify(mesh, options), OptionError);
  options = to_ratio(0.5, CostPolicy::normal_deviation);
  options.placement = VertexPlacement::optimal;
  EXPECT_THROW(simplify(mesh, options), OptionError);
  options = {};
  options.normal_threshold = 2;
  EXPECT_THROW(simplify(mesh, options), OptionError);
}

TEST(Simplify, AnEmptyMeshStaysEmpty) {
  const SimplifyResult result = simplify(PolygonMesh{}, to_ratio(0.5));
  EXPECT_EQ(result.faces_after, 0u);
  EXPECT_EQ(result.collapses, 0u);
}

class CancelAtOnce final : public Progress {
 public:
  void update(std::string_view, double) override {}
  bool cancel_requested() const override { return true; }
};

TEST(Simplify, CanBeCancelled) {
  CancelAtOnce progress;
  EXPECT_THROW(simplify(mesh_of(test::grid(8)), to_ratio(0.5), &progress), Cancelled);
}

}  // namespace
}  // namespace recede
