// A geomorph is the coarse level at one end, the fine one at the other, and nothing jumps between.
#include "hard_cases.h"
#include "meshes.h"
#include "progressive.h"
#include "soups.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/geomorph.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

using test::all_ways;
using test::expect_same_bits;
using test::options_for;

/// The polygons without corners that repeat the one before, and without those of fewer than three corners.
std::vector<std::vector<std::array<double, 3>>> polygons_with_area(PolygonSoup soup) {
  PolygonSoup result;
  merge_identical_vertices(soup);
  result.positions = soup.positions;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    std::vector<Index> loop(soup.face(f).begin(), soup.face(f).end());
    loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
    while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
    if (loop.size() > 2) result.add_face(loop);
  }
  return test::polygons_of(result);
}

void expect_blends(const ProgressiveMesh& mesh, std::size_t coarse_level, std::size_t fine_level) {
  ProgressiveCursor coarse(mesh), fine(mesh);
  coarse.move_to(coarse_level);
  fine.move_to(fine_level);
  const Geomorph morph = make_geomorph(mesh, coarse_level, fine_level);
  expect_same_bits(morph.at(1), fine.soup());
  const PolygonSoup coarse_soup = coarse.soup();
  // A face of the input that visits a vertex twice is several polygons in all other levels.
  if (fine_level < mesh.n_splits() || mesh.mending.fine_faces.empty()) {
    EXPECT_EQ(polygons_with_area(morph.at(0)), polygons_with_area(coarse_soup));
  }
  ASSERT_EQ(morph.parents.size(), morph.fine.positions.size());
  for (std::size_t v = 0; v < morph.parents.size(); ++v) {
    if (morph.parents[v] == k_no_index) continue;
    ASSERT_LT(morph.parents[v], coarse_soup.positions.size());
    EXPECT_EQ(morph.coarse.positions[v], coarse_soup.positions[morph.parents[v]]);
  }
}

TEST(Geomorph, JoinsRandomLevelsOfRandomPolygons) {
  std::mt19937 random(4);
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    const PolygonSoup soup = test::random_soup(seed, {.scalars = true});
    for (const ProgressiveOptions& options : all_ways()) {
      const ProgressiveMesh mesh = build_progressive_mesh(soup, options);
      const auto [coarse, fine] = std::minmax({random() % mesh.n_levels(), random() % mesh.n_levels()});
      expect_blends(mesh, coarse, fine);
      expect_blends(mesh, 0, mesh.n_splits());
    }
  }
}

class GeomorphOfHardCases : public testing::TestWithParam<test::HardCase> {};

TEST_P(GeomorphOfHardCases, JoinsLevels) {
  if (!GetParam().refusal.empty()) return;
  for (ProgressiveOptions options : all_ways()) {
    options.simplify.drop_parts = true;
    const ProgressiveMesh mesh = build_progressive_mesh(GetParam().soup, options);
    expect_blends(mesh, mesh.n_splits() / 3, mesh.n_splits());
    expect_blends(mesh, mesh.n_splits() / 2, mesh.n_splits() - mesh.n_splits() / 5);
  }
}
INSTANTIATE_TEST_SUITE_P(All, GeomorphOfHardCases, testing::ValuesIn(test::hard_cases()), test::case_name);

TEST(Geomorph, MovesPointsOnStraightLines) {
  const ProgressiveMesh mesh = build_progressive_mesh(
      make_displaced_sphere(2000, false), options_for(CostPolicy::volume, VertexPlacement::optimal));
  const Geomorph morph = make_geomorph(mesh, mesh.n_splits() / 4, mesh.n_splits());
  ASSERT_NE(morph.fine.positions, morph.coarse.positions);
  // In eight steps every point moves by an eighth of its way: nothing pops.
  PolygonSoup before = morph.at(0);
  for (int step = 1; step <= 8; ++step) {
    const PolygonSoup now = morph.at(step / 8.0);
    for (std::size_t v = 0; v < now.positions.size(); ++v) {
      const Vec3 way = morph.fine.positions[v] - morph.coarse.positions[v];
      // Rounding of two sums.
      EXPECT_LE((now.positions[v] - before.positions[v] - way / 8).norm(), 1e-15);
    }
    before = now;
  }
}

// Attributes at the coarse end are those of the coarse level.
TEST(Geomorph, BlendsAttributes) {
  PolygonSoup soup = test::grid(10);
  for (const Vec3& p : soup.positions) soup.vertex_colors.emplace_back(p.x(), p.y(), 0, 1);
  for (const Index v : soup.corner_vertices) {
    soup.corner_uvs.push_back(soup.positions[v].head<2>());
    soup.corner_normals.push_back(Vec3(soup.positions[v].x(), 0, 1).normalized());
  }
  const ProgressiveMesh mesh =
      build_progressive_mesh(soup, options_for(CostPolicy::volume, VertexPlacement::half_edge));
  ASSERT_GT(mesh.n_splits(), 10u);
  const Geomorph morph = make_geomorph(mesh, 0, mesh.n_splits());
  std::size_t n_moved = 0;
  const PolygonSoup half = morph.at(0.5);
  for (std::size_t f = 0; f < morph.coarse.n_faces(); ++f) {
    // Half-edge collapses move whole vertices, so that a polygon's texture coordinates stay its positions.
    if (vector_area(morph.coarse, f).norm() == 0) continue;
    for (Index c = morph.coarse.face_offsets[f]; c < morph.coarse.face_offsets[f + 1]; ++c) {
      const Index v = morph.coarse.corner_vertices[c];
      EXPECT_EQ(morph.coarse.corner_uvs[c], morph.coarse.positions[v].head<2>());
      EXPECT_EQ(morph.coarse.vertex_colors[v].x(), morph.coarse.positions[v].x());
      EXPECT_NEAR(half.corner_normals[c].norm(), 1, 1e-15);  // rounding
      EXPECT_LT((half.corner_uvs[c] - half.positions[v].head<2>()).norm(), 1e-15);
      n_moved += morph.coarse.positions[v] != morph.fine.positions[v];
    }
  }
  EXPECT_GT(n_moved, 0u);
}

TEST(Geomorph, FilesSayWhatTheyLeaveOut) {
  const test::TempFolder folder;
  PolygonSoup soup = test::grid(6);
  for (const Index v : soup.corner_vertices) soup.corner_uvs.push_back(soup.positions[v].head<2>());
  const ProgressiveMesh mesh =
      build_progressive_mesh(soup, options_for(CostPolicy::volume, VertexPlacement::half_edge));
  const Geomorph morph = make_geomorph(mesh, 0, mesh.n_splits());
  ASSERT_NE(morph.fine.corner_uvs, morph.coarse.corner_uvs);
  EXPECT_THAT(write_geomorph(folder / "a.ply", morph).written_without,
              testing::ElementsAre("the coarse level's texture coordinates"));
  EXPECT_THAT(write_geomorph(folder / "A.GLB", morph).written_without,
              testing::Contains(testing::HasSubstr("more than three corners")));
  EXPECT_THROW(write_geomorph(folder / "a.stl", morph), InputError);
  const PolygonSoup back = read_soup(folder / "a.ply");
  ASSERT_EQ(back.vertex_scalars.size(), 4u);
  for (std::size_t v = 0; v < back.positions.size(); ++v) {
    EXPECT_EQ(back.vertex_scalars[0].values[v], morph.parents[v]);
    EXPECT_EQ(back.vertex_scalars[1].values[v], morph.coarse.positions[v].x());
  }
}

TEST(Geomorph, RefusesWhatIsOutOfRange) {
  const ProgressiveMesh mesh =
      build_progressive_mesh(test::grid(4), options_for(CostPolicy::volume, VertexPlacement::half_edge));
  EXPECT_THROW(make_geomorph(mesh, 2, 1), OptionError);
  EXPECT_THROW(make_geomorph(mesh, 0, mesh.n_splits() + 1), OptionError);
  EXPECT_THROW(make_geomorph(mesh, 0, 1).at(1.5), OptionError);
  EXPECT_THROW(make_geomorph(mesh, 0, 1).at(NAN), OptionError);
}

}  // namespace
}  // namespace recede
