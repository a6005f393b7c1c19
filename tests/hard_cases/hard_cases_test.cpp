// Every operation on every hard case: the right result or a clear error.
#include "hard_cases.h"

#include "input_errors.h"
#include "meshes.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/simplify.h>

#include <Eigen/Geometry>

#include <random>

namespace recede {
namespace {

using test::HardCase;

SimplifyOptions to_share(double ratio, CostPolicy cost = CostPolicy::volume) {
  SimplifyOptions options;
  options.target.ratio = ratio;
  options.cost = cost;
  return options;
}

class HardCases : public testing::TestWithParam<HardCase> {
 protected:
  const PolygonSoup& soup() const { return GetParam().soup; }
};

void expect_finite(const PolygonSoup& soup) {
  for (const Vec3& p : soup.positions) ASSERT_TRUE(p.allFinite());
}

/// Faces are made by nothing, and those of the input never get worse.
void expect_no_worse(const PolygonSoup& before, const PolygonSoup& after) {
  expect_finite(after);
  EXPECT_LE(after.n_faces(), before.n_faces());
  for (std::size_t f = 0; f < after.n_faces(); ++f) {
    std::vector<Index> face(after.face(f).begin(), after.face(f).end());
    std::sort(face.begin(), face.end());
    ASSERT_EQ(std::adjacent_find(face.begin(), face.end()), face.end())
        << "face " << f << " visits a vertex twice";
  }
}

TEST_P(HardCases, RepairSimplifyAndMeasure) {
  if (!GetParam().refusal.empty()) {
    EXPECT_NE(test::error_text([&] { simplify(soup(), to_share(0.1)); }).find(GetParam().refusal),
              std::string::npos);
    EXPECT_NE(test::error_text([&] { measure_distance(soup(), soup()); }).find(GetParam().refusal),
              std::string::npos);
    return;
  }
  const PolygonMesh mesh = repair_to_polygon_mesh(soup()).mesh;
  for (const CostPolicy cost : {CostPolicy::volume, CostPolicy::normal_deviation}) {
    for (const double ratio : {0.5, 0.1, 1e-9}) {
      const SimplifyResult result = simplify(mesh, to_share(ratio, cost));
      expect_no_worse(to_soup(mesh), to_soup(result.mesh));
      EXPECT_EQ(result.faces_after, result.mesh.n_faces());
      EXPECT_TRUE(std::isfinite(result.error_estimate));
      if (mesh.n_faces() == 0) continue;
      ASSERT_GT(result.mesh.n_faces(), 0u);
      ASSERT_TRUE(result.error_bound);
      EXPECT_TRUE(std::isfinite(*result.error_bound));
      EXPECT_LE(result.error_lower, *result.error_bound);
      // By an independent evaluator with other points. Nearest points on slivers of aspect 1e9 are as
      // uncertain as those are wide.
      const MeshDistance distance = measure_distance(mesh, result.mesh, {.samples = 5000});
      EXPECT_LE(distance.max, *result.error_bound + 1e-9 * distance.diagonal);
      if (result.stop_reason == StopReason::no_collapse_left && result.faces_after > 1) {
        std::size_t refused = 0;
        for (const std::size_t count : result.refused.counts) refused += count;
        EXPECT_GT(refused, 0u) << "it says why it stopped";
      }
    }
  }
}

TEST_P(HardCases, ASoupGivesWhatItsMeshGives) {
  if (!GetParam().refusal.empty()) return;
  const PolygonMesh mesh = repair_to_polygon_mesh(soup()).mesh;
  const PolygonSoup from_mesh = to_soup(simplify(mesh, to_share(0.2)).mesh);
  const PolygonSoup from_soup = simplify(to_soup(mesh), to_share(0.2)).soup;
  EXPECT_EQ(from_mesh.n_faces(), from_soup.n_faces());
}

TEST_P(HardCases, FlatSurfacesDontChange) {
  if (!GetParam().closed_flat) return;
  const SimplifySoupResult result = simplify(soup(), to_share(0.1));
  EXPECT_EQ(result.stop_reason, StopReason::face_target);
  // Rounding of a unit-sized surface, over some hundred collapses.
  EXPECT_LT(*result.error_bound, 1e-12);
}

TEST_P(HardCases, ErrorTargetsHold) {
  if (!GetParam().refusal.empty() || soup().n_faces() == 0) return;
  SimplifyOptions options;
  options.target.relative_error = 0.02;
  const PolygonMesh mesh = repair_to_polygon_mesh(soup()).mesh;
  const SimplifyResult result = simplify(mesh, options);
  const MeshDistance distance = measure_distance(mesh, result.mesh, {.samples = 20'000});
  EXPECT_LE(distance.max, 0.02 * distance.diagonal * (1 + 1e-9));
  EXPECT_LE(*result.error_bound, 0.02 * distance.diagonal * (1 + 1e-9));
}

TEST_P(HardCases, HierarchiesAreWrittenAndReadBack) {
  const std::string& name = GetParam().name;
  if (!GetParam().refusal.empty()) return;
  const PolygonMesh mesh = repair_to_polygon_mesh(soup()).mesh;
  HierarchyOptions options;
  options.ratios = {0.5, 0.1};
  options.measure.samples = 1000;
  if (mesh.n_faces() == 0) {
    EXPECT_NE(test::error_text([&] { build_hierarchy(mesh, name, options); }).find("faces"),
              std::string::npos);
    return;
  }
  const test::TempFolder folder;
  const LodHierarchy hierarchy = build_hierarchy(mesh, name, options);
  write_hierarchy(folder.path(), hierarchy);
  EXPECT_EQ(hierarchy.levels.size(), 3u);
  for (const LodLevel& level : hierarchy.levels) EXPECT_TRUE(std::isfinite(level.error.bound));
  EXPECT_GT(read_soup(folder.path() / (name + ".glb")).n_faces(), 0u);
  const LodHierarchy read = read_hierarchy(folder.path() / (name + ".recede"));
  ASSERT_EQ(read.levels.size(), hierarchy.levels.size());
  for (std::size_t i = 0; i < read.levels.size(); ++i) {
    EXPECT_EQ(read.levels[i].mesh.n_faces(), hierarchy.levels[i].mesh.n_faces()) << i;
    EXPECT_EQ(read.levels[i].error.bound, hierarchy.levels[i].error.bound) << i;
  }
}

std::string case_name(const testing::TestParamInfo<HardCase>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(All, HardCases, testing::ValuesIn(test::hard_cases()), case_name);

// What some of them are to give.

TEST(HardCasesOneByOne, FlippedFacesAreTurnedBackAndSimplifyAsIfNothingWas) {
  const PolygonSoup ball = make_displaced_sphere(3000, true);
  const SimplifyResult right = simplify(test::mesh_of(ball), to_share(0.1));
  const SimplifyResult wrong = simplify(test::mesh_of(test::wound_wrong(ball, 1)), to_share(0.1));
  EXPECT_EQ(wrong.faces_after, right.faces_after);
  EXPECT_NEAR(*wrong.error_bound, *right.error_bound, 0.1 * *right.error_bound);
}

TEST(HardCasesOneByOne, ABookKeepsItsSpine) {
  const PolygonMesh book = test::mesh_of(test::book_of_sheets(3, 20));
  const SimplifyResult result = simplify(book, to_share(0.1));
  EXPECT_EQ(result.stop_reason, StopReason::face_target);
  test::expect_sound(result.mesh, 3);
  PolygonSoup soup = to_soup(result.mesh);
  merge_identical_vertices(soup);
  std::size_t spine = 0;
  for (const auto& [edge, count] : test::edge_counts(soup)) {
    if (count < 3) continue;
    ++spine;
    EXPECT_LT(soup.positions[edge.first].head<1>().norm() + std::abs(soup.positions[edge.first].z()), 1e-9)
        << "the spine is straight";
  }
  EXPECT_GE(spine, 1u);
}

TEST(HardCasesOneByOne, SheetsSeenFromBothSidesSimplifyAsOneSheet) {
  const SimplifySoupResult result = simplify(test::double_sided_sheet(20), to_share(0.1));
  EXPECT_EQ(result.stop_reason, StopReason::face_target);
  EXPECT_LE(result.faces_after, 160u);
  EXPECT_GE(result.faces_after, 150u);
  std::map<std::vector<Index>, int> sides;
  for (std::size_t f = 0; f < result.soup.n_faces(); ++f) {
    std::vector<Index> face(result.soup.face(f).begin(), result.soup.face(f).end());
    std::sort(face.begin(), face.end());
    ++sides[face];
  }
  for (const auto& [face, count] : sides) EXPECT_EQ(count, 2);
  EXPECT_LT(*result.error_bound, 0.02) << "a sheet 1 wide, with waves 0.1 high";
}

TEST(HardCasesOneByOne, LooseCubesSayWhyTheyStop) {
  const SimplifySoupResult result = simplify(test::loose_cubes(1500), to_share(0.1));
  EXPECT_EQ(result.stop_reason, StopReason::no_collapse_left);
  EXPECT_EQ(result.faces_after, 6000u) << "tetrahedra";
  EXPECT_GT(result.refused[Refusal::duplicate], 0u);
}

TEST(HardCasesOneByOne, WhereItStandsAndHowLargeItIsChangesNothing) {
  const PolygonSoup ball = make_displaced_sphere(3000, true);
  const SimplifySoupResult here = simplify(ball, to_share(0.1));
  const auto transformed = [&](double scale, const Vec3& offset) {
    PolygonSoup soup = ball;
    for (Vec3& p : soup.positions) p = scale * p + offset;
    return simplify(soup, to_share(0.1));
  };
  for (const double scale : {0x1p-30, 0x1p30}) {  // powers of two scale without rounding
    const SimplifySoupResult there = transformed(scale, Vec3::Zero());
    EXPECT_EQ(there.soup.corner_vertices, here.soup.corner_vertices);
    EXPECT_DOUBLE_EQ(*there.error_bound, scale * *here.error_bound);
  }
  const SimplifySoupResult far = transformed(1, Vec3(1e6, 1e6, 1e6));
  EXPECT_EQ(far.faces_after, here.faces_after);
  // Coordinates in steps of 1e-10 move some near ties.
  EXPECT_NEAR(*far.error_bound, *here.error_bound, 0.2 * *here.error_bound);
}

// The numbering of the table comes from the positions, so that of the input can't matter.
TEST(HardCasesOneByOne, TheOrderOfVerticesAndFacesDoesNotMatter) {
  for (const PolygonSoup& soup : {make_displaced_sphere(3000, true), make_displaced_sphere(3000, false)}) {
    const SimplifySoupResult first = simplify(soup, to_share(0.1));
    const SimplifySoupResult second = simplify(test::shuffled(soup, 3), to_share(0.1));
    EXPECT_EQ(first.faces_after, second.faces_after);
    EXPECT_NEAR(*first.error_bound, *second.error_bound, 0.05 * *first.error_bound)
        << "the proof's tolerance";
    auto a = first.soup.positions, b = second.soup.positions;
    const auto before = [](const Vec3& p, const Vec3& q) {
      return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
    };
    std::sort(a.begin(), a.end(), before);
    std::sort(b.begin(), b.end(), before);
    EXPECT_EQ(a, b);
  }
}

TEST(HardCasesOneByOne, TurningChangesTheErrorLittle) {
  const PolygonSoup ball = make_displaced_sphere(3000, true);
  const SimplifySoupResult upright = simplify(ball, to_share(0.1));
  PolygonSoup turned = ball;
  const Eigen::AngleAxisd turn(1, Vec3(3, 2, 1).normalized());
  for (Vec3& p : turned.positions) p = turn * p;
  const SimplifySoupResult result = simplify(turned, to_share(0.1));
  EXPECT_EQ(result.faces_after, upright.faces_after);
  // Patches and near ties fall otherwise.
  const double rms_upright = measure_distance(ball, upright.soup, {}).rms,
               rms_turned = measure_distance(turned, result.soup, {}).rms;
  EXPECT_NEAR(rms_turned, rms_upright, 0.05 * rms_upright);
}

TEST(HardCasesOneByOne, NoiseOfRoundingChangesTheErrorLittle) {
  const PolygonSoup ball = make_displaced_sphere(3000, true);
  const double rms = measure_distance(ball, simplify(ball, to_share(0.1)).soup, {}).rms;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (const double size : {1e-12, 1e-9, 1e-6}) {
    PolygonSoup noisy = ball;
    for (Vec3& p : noisy.positions) p += size * Vec3(normal(random), normal(random), normal(random));
    const SimplifySoupResult result = simplify(noisy, to_share(0.1));
    EXPECT_NEAR(measure_distance(ball, result.soup, {}).rms, rms, 0.05 * rms) << "noise of " << size;
  }
}

}  // namespace
}  // namespace recede
