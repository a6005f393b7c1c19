#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/sample_models.h>

#include <gtest/gtest.h>

#include <algorithm>

namespace recede {
namespace {

std::size_t n_of_material(const PolygonSoup& tree, Index material) {
  return static_cast<std::size_t>(
      std::count(tree.face_materials.begin(), tree.face_materials.end(), material));
}

TEST(SampleTree, StandsUprightInItsCrownWithTheLeavesThatWereAskedFor) {
  const PolygonSoup tree = make_tree();
  validate(tree, "tree");
  ASSERT_EQ(tree.materials.size(), 2u);
  EXPECT_EQ(tree.materials[0].name, "bark");
  EXPECT_EQ(tree.materials[1].name, "leaves");
  EXPECT_EQ(n_of_material(tree, 1), 4 * TreeOptions{}.leaves);
  const std::size_t n_triangles = triangulate(tree).size() / 3;
  EXPECT_GT(n_triangles, 12'500u);
  EXPECT_LT(n_triangles, 13'500u);
  // Leaves at the crown's border are a little outside of it.
  const Box3 box = bounding_box(tree);
  EXPECT_NEAR(box.sizes().y(), 10, 1);
  EXPECT_NEAR(box.min().y(), 0, 0.2);
  EXPECT_LT(std::max(box.sizes().x(), box.sizes().z()), 9);
  // Higher than the first bough it is broader than its trunk.
  EXPECT_GT(box.sizes().x(), 5);
  EXPECT_GT(box.sizes().z(), 5);
}

TEST(SampleTree, HasNoFaceWithoutAreaAndNothingToRepair) {
  for (const std::size_t leaves : {std::size_t{0}, std::size_t{7}, std::size_t{2400}, std::size_t{20'000}}) {
    const PolygonSoup tree = make_tree({.leaves = leaves});
    EXPECT_EQ(n_of_material(tree, 1), 4 * leaves);
    for (std::size_t face = 0; face < tree.n_faces(); ++face)
      ASSERT_GT(vector_area(tree, face).norm(), 1e-7) << face << " of " << leaves << " leaves";
    EXPECT_EQ(repair_to_polygon_mesh(tree).report.total_changed(), 0u);
  }
}

TEST(SampleTree, IsTheSameForASeedAndAnotherOneForAnother) {
  EXPECT_EQ(make_tree().positions, make_tree().positions);
  EXPECT_NE(make_tree().positions, make_tree({.seed = 2}).positions);
}

}  // namespace
}  // namespace recede
