// Progressive meshes: the way down is that of `simplify`, the way up ends at the input, bit for bit.
#include "hard_cases.h"
#include "input_errors.h"
#include "meshes.h"
#include "progressive.h"
#include "soups.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/progressive_mesh.h>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <filesystem>
#include <random>

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

}  // namespace
}  // namespace recede
