// Progressive meshes: the way down is that of `simplify`, the way up ends at the input, bit for bit.
#include "different_models.h"
#include "hard_cases.h"
#include "input_errors.h"
#include "meshes.h"
#include "progressive.h"
#include "sanitized.h"
#include "soups.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/pmesh.h>
#include <recede/lod/progressive_mesh.h>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <filesystem>
#include <random>
#include <set>

namespace recede {
namespace {

using test::all_ways;
using test::expect_same_bits;
using test::options_for;

/// Walks up and down at random: every level is the same whenever it is met, has as many faces as it says, and
/// the last is the input.
void expect_consistent(const PolygonSoup& input, const ProgressiveMesh& mesh, unsigned seed) {
  ProgressiveCursor cursor(mesh);
  std::mt19937 random(seed);
  for (int walk = 0; walk < 4; ++walk) {
    const std::size_t level = random() % mesh.n_levels();
    ProgressiveCursor direct(mesh);
    direct.move_to(level);
    cursor.move_to(mesh.n_splits());
    cursor.move_to(level);
    const PolygonSoup soup = cursor.soup();
    EXPECT_EQ(soup.n_faces(), mesh.level_faces[level]);
    validate(soup, "level");
    expect_same_bits(direct.soup(), soup);
    cursor.move_to(random() % mesh.n_levels());
  }
  cursor.move_to(mesh.n_splits());
  expect_same_bits(cursor.soup(), input);
  EXPECT_TRUE(std::is_sorted(mesh.level_faces.begin(), mesh.level_faces.end() - 1));
  EXPECT_TRUE(std::is_sorted(mesh.level_errors.rbegin(), mesh.level_errors.rend()));
}

TEST(ProgressiveMesh, RestoresRandomPolygonsWithAllAttributes) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const PolygonSoup soup = test::random_soup(seed, {.scalars = true});
    for (const ProgressiveOptions& options : all_ways()) {
      SCOPED_TRACE(seed);
      expect_consistent(soup, build_progressive_mesh(soup, options), seed);
    }
  }
}

// Claim 8.
TEST(ProgressiveMesh, RestoresGridsPrismsAndHexagons) {
  for (const PolygonSoup& soup :
       {test::grid(12), test::grid(12, true), test::prism(12), test::hexagon_sheet(10), make_teapot()}) {
    for (const ProgressiveOptions& options : all_ways()) {
      expect_consistent(soup, build_progressive_mesh(soup, options), 7);
    }
  }
}

class ProgressiveHardCases : public testing::TestWithParam<test::HardCase> {};

TEST_P(ProgressiveHardCases, RestoreTheInput) {
  const PolygonSoup& soup = GetParam().soup;
  for (ProgressiveOptions options : all_ways()) {
    if (!GetParam().refusal.empty()) {
      EXPECT_NE(test::error_text([&] { build_progressive_mesh(soup, options); }).find(GetParam().refusal),
                std::string::npos);
      continue;
    }
    expect_consistent(soup, build_progressive_mesh(soup, options), 11);
    options.simplify.drop_parts = true;
    options.simplify.keep_normal_seams = options.simplify.keep_uv_seams = false;
    if (options.simplify.cost == CostPolicy::volume && soup.n_faces() > 0)
      options.simplify.join_distance = 0.01 * bounding_box(soup).diagonal().norm();
    expect_consistent(soup, build_progressive_mesh(soup, options), 13);
  }
}

INSTANTIATE_TEST_SUITE_P(All, ProgressiveHardCases, testing::ValuesIn(test::hard_cases()), test::case_name);

TEST(ProgressiveMesh, HasTheBaseThatSimplifyGives) {
  for (const PolygonSoup& soup : {make_displaced_sphere(3000, true), make_displaced_sphere(3000, false),
                                  test::hexagon_sheet(12), test::double_sided_sheet(8)}) {
    for (ProgressiveOptions options : all_ways()) {
      options.simplify.target.ratio = 0.2;
      const ProgressiveMesh mesh = build_progressive_mesh(soup, options);
      const PolygonSoup base = ProgressiveCursor(mesh).soup();
      EXPECT_EQ(test::polygons_of(base), test::polygons_of(simplify(soup, options.simplify).soup));
    }
  }
}

// Claim 9, on a closed surface: every collapse takes two polygons or sides.
TEST(ProgressiveMesh, SplitsOfAClosedSurfaceBringTwoPolygonsOrSidesBack) {
  for (const bool triangles : {true, false}) {
    const ProgressiveMesh mesh = build_progressive_mesh(
        make_displaced_sphere(2000, triangles), options_for(CostPolicy::volume, VertexPlacement::half_edge));
    ASSERT_GT(mesh.splits.size(), 500u);
    for (std::size_t s = 0; s < mesh.splits.size(); ++s) {
      EXPECT_EQ(mesh.items_of(s).size() - mesh.splits[s].n_corners, 2u);
    }
  }
}

// Claim 10.
TEST(ProgressiveMesh, WithHalfEdgesEveryLevelHasVerticesOfTheInput) {
  const PolygonSoup soup = make_displaced_sphere(2000, false);
  const ProgressiveMesh mesh =
      build_progressive_mesh(soup, options_for(CostPolicy::normal_deviation, VertexPlacement::half_edge));
  std::set<std::array<double, 3>> known;
  for (const Vec3& p : soup.positions) known.insert({p.x(), p.y(), p.z()});
  ProgressiveCursor cursor(mesh);
  for (const std::size_t level : {std::size_t{0}, mesh.n_splits() / 2}) {
    cursor.move_to(level);
    for (const Vec3& p : cursor.soup().positions) EXPECT_TRUE(known.contains({p.x(), p.y(), p.z()}));
  }
}

std::vector<Index> loop_of(const ProgressiveMesh& mesh, const ProgressiveCursor& cursor, Index face) {
  std::vector<Index> loop;
  for (Index c = mesh.face_offsets[face]; c < mesh.face_offsets[face + 1]; ++c) {
    if (cursor.is_corner_alive(c)) loop.push_back(cursor.corner_vertices()[c]);
  }
  return loop;
}

// The context of the source: (v4, v2, v1, v3) collapses to (v4, v0, v3), and v2, v1 go back between v4 and v3
// in this order.
TEST(ProgressiveMesh, CornersComeBackBetweenTheNeighboursThatTheyHad) {
  const PolygonSoup soup = test::grid(8);
  const ProgressiveMesh mesh =
      build_progressive_mesh(soup, options_for(CostPolicy::volume, VertexPlacement::midpoint));
  ProgressiveCursor cursor(mesh);
  std::size_t seen = 0;
  for (std::size_t s = 0; s < mesh.splits.size(); ++s) {
    const VertexSplit& split = mesh.splits[s];
    for (const Index corner : mesh.items_of(s).subspan(split.n_corners + split.n_faces)) {
      const auto face =
          static_cast<Index>(std::upper_bound(mesh.face_offsets.begin(), mesh.face_offsets.end(), corner) -
                             mesh.face_offsets.begin() - 1);
      const std::vector<Index> before = loop_of(mesh, cursor, face);
      cursor.move_to(s + 1);
      std::vector<Index> after = loop_of(mesh, cursor, face);
      cursor.move_to(s);
      const auto removed = std::find(after.begin(), after.end(), split.removed);
      ASSERT_NE(removed, after.end());
      const auto n = static_cast<std::size_t>(after.size()),
                 at = static_cast<std::size_t>(removed - after.begin());
      EXPECT_TRUE(after[(at + 1) % n] == split.kept || after[(at + n - 1) % n] == split.kept);
      after.erase(removed);
      EXPECT_EQ(after, before);
      ++seen;
    }
    cursor.move_to(s + 1);
  }
  EXPECT_GT(seen, 20u);
}

void expect_errors_hold(const PolygonSoup& soup, ProgressiveOptions options) {
  options.simplify.prove_error = true;
  const ProgressiveMesh mesh = build_progressive_mesh(soup, options);
  ASSERT_TRUE(mesh.errors_are_proved);
  EXPECT_TRUE(std::is_sorted(mesh.level_errors.rbegin(), mesh.level_errors.rend()));
  EXPECT_EQ(mesh.level_errors.back(), 0);
  ProgressiveCursor cursor(mesh);
  for (std::size_t i = 0; i <= 8; ++i) {
    cursor.move_to(i * mesh.n_splits() / 8);
    // Cut once, before measuring moves them into a frame of its own where equally good diagonals may trade
    // places.
    const MeshDistance d = measure_distance(triangulated(soup), triangulated(cursor.soup()),
                                            {.samples = 20'000, .bound_tolerance = 0.05});
    EXPECT_GE(cursor.error() * (1 + 1e-9) + 1e-12 * d.diagonal, d.max_lower)
        << "level " << cursor.level() << " of " << soup.n_faces() << " faces, "
        << static_cast<int>(options.simplify.cost) << static_cast<int>(options.simplify.placement);
  }
}

TEST(ProgressiveMesh, NoLevelIsFartherFromTheInputThanItSays) {
  for (const PolygonSoup& soup :
       {make_displaced_sphere(800, true), make_displaced_sphere(800, false), test::hexagon_sheet(10),
        test::collapsed_grid(10), test::wound_wrong(test::grid(10), 3), test::book_of_sheets(3, 8),
        test::double_sided_sheet(8)}) {
    for (const ProgressiveOptions& options : all_ways()) {
      expect_errors_hold(soup, options);
      if (test::k_sanitized) break;
    }
  }
  ProgressiveOptions dropping;
  dropping.simplify.drop_parts = true;
  expect_errors_hold(test::loose_cubes(40), dropping);
}

TEST(ProgressiveMesh, LevelsAreChosenByFacesAndByError) {
  ProgressiveMesh mesh;
  mesh.splits.resize(3);
  mesh.level_faces = {4, 6, 6, 8};
  mesh.level_errors = {0.5, 0.25, 0.25, 0};
  EXPECT_EQ(mesh.level_for_faces(3), 0u);
  EXPECT_EQ(mesh.level_for_faces(5), 0u);
  EXPECT_EQ(mesh.level_for_faces(7), 2u);
  EXPECT_EQ(mesh.level_for_faces(100), 3u);
  EXPECT_EQ(mesh.level_for_error(1), 0u);
  EXPECT_EQ(mesh.level_for_error(0.3), 1u);
  EXPECT_EQ(mesh.level_for_error(0.1), 3u);
  EXPECT_EQ(mesh.level_for_error(-1), 3u);
}

TEST(ProgressiveMesh, RefusesWhatIsOutOfRange) {
  const ProgressiveMesh mesh =
      build_progressive_mesh(test::grid(4), options_for(CostPolicy::volume, VertexPlacement::half_edge));
  ProgressiveCursor cursor(mesh);
  EXPECT_THROW(cursor.move_to(mesh.n_splits() + 1), OptionError);
  EXPECT_THROW(build_progressive_mesh(test::grid(4),
                                      options_for(CostPolicy::normal_deviation, VertexPlacement::optimal)),
               OptionError);
}

class CancelInStage final : public Progress {
 public:
  CancelInStage(std::string stage, int report) : stage_(std::move(stage)), reports_left_(report) {}
  void update(std::string_view stage, double) override {
    if (stage == stage_) --reports_left_;
  }
  bool cancel_requested() const override { return reports_left_ < 0; }

 private:
  std::string stage_;
  int reports_left_;
};

TEST(ProgressiveMesh, CanBeCancelledWhileFacesAreMeasured) {
  const PolygonSoup soup = make_displaced_sphere(4000, true);
  for (const int report : {0, 1, 2}) {
    CancelInStage progress("prove", report);
    EXPECT_THROW(build_progressive_mesh(soup, {}, &progress), Cancelled) << report;
  }
}

class ProgressiveModels : public testing::TestWithParam<test::DifferentModel> {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(RECEDE_DATA "/meshes")) GTEST_SKIP() << "no models; ./dev data fetches them";
    soup_ = GetParam().load(RECEDE_DATA);
  }
  PolygonSoup soup_;
};

TEST_P(ProgressiveModels, AreRestoredAndGiveTheSameBytesFromOneAndFromTwoThreads) {
  if (test::k_sanitized && !GetParam().small) GTEST_SKIP() << "takes minutes here; small models do the same";
  for (const CostPolicy cost : {CostPolicy::volume, CostPolicy::normal_deviation}) {
    if (cost == CostPolicy::normal_deviation && !GetParam().small) continue;
    ProgressiveOptions options = options_for(cost, VertexPlacement::automatic, soup_.n_faces() < 17'000);
    options.simplify.target.ratio = 0.05;
    std::array<std::string, 2> bytes;
    for (const std::size_t threads : {1u, 2u}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const ProgressiveMesh mesh = build_progressive_mesh(soup_, options);
      bytes[threads - 1] = encode_pmesh(mesh);
      if (threads == 2) expect_consistent(soup_, mesh, 3);
    }
    EXPECT_TRUE(bytes[0] == bytes[1]);
  }
}
INSTANTIATE_TEST_SUITE_P(TenModels, ProgressiveModels, testing::ValuesIn(test::different_models()),
                         [](const auto& tested) { return tested.param.name; });

// Ears of a border go without changing any other face.
TEST(ProgressiveErrors, OpenSheetsHaveABoundAtEveryLevel) {
  PolygonSoup sheet = test::grid(20, true);
  for (Vec3& p : sheet.positions) p.z() = 0.2 * std::sin(5 * p.x()) * std::cos(4 * p.y());
  const ProgressiveMesh mesh = build_progressive_mesh(sheet);
  ProgressiveCursor cursor(mesh);
  for (std::size_t level = 0; level < mesh.n_levels(); level += 1 + level / 4) {
    EXPECT_TRUE(std::isfinite(mesh.level_errors[level])) << level;
    cursor.move_to(level);
    EXPECT_LE(measure_distance(sheet, cursor.soup()).max, mesh.level_errors[level] * (1 + 1e-12)) << level;
  }
}

}  // namespace
}  // namespace recede
