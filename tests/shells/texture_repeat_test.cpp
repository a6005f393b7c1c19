#include "simple_soups.h"
#include <recede/geometry/error.h>
#include <recede/shells/texture_repeat.h>

#include <gtest/gtest.h>

namespace {

using namespace recede;

/// A square of sides of 1. A texture coordinate of 1 is 6 long, and along s 6 / `across`.
Shell square(double thickness, double across) {
  PolygonSoup base = test::grid(6);
  for (const Index v : base.corner_vertices)
    base.corner_uvs.emplace_back(base.positions[v].x() / 6 * across, base.positions[v].y() / 6);
  return build_shell(base, {.thickness = thickness, .thicknesses = {}, .method = DirectorMethod::normals});
}

TEST(TextureRepeat, KeepsTheProportionsOfATexture) {
  // A layer of half a unit under periods of 2 x 4 x 1: a period is 1 x 2 units, so that 6 x 3 fit.
  EXPECT_EQ(proportionate_repeat(square(0.5, 1), ShellSide::exterior, {2, 4, 1}), Vec2(6, 3));
  EXPECT_EQ(proportionate_repeat(square(0.25, 1), ShellSide::exterior, {2, 4, 1}), Vec2(12, 6));
  // Coordinates that go to 3 need a third of the periods for each.
  EXPECT_EQ(proportionate_repeat(square(0.5, 3), ShellSide::exterior, {2, 4, 1}), Vec2(2, 3));
  // Of periods wider than the surface there is one.
  EXPECT_EQ(proportionate_repeat(square(0.5, 1), ShellSide::exterior, {200, 400, 1}), Vec2(1, 1));
}

TEST(TextureRepeat, IsThatOfVerticesWithTriangles) {
  PolygonSoup base = square(0.5, 1).base;
  base.positions.insert(base.positions.end(), 500, Vec3(3, 3, 0));  // no face has them
  const Shell shell = build_shell(base, {.thickness = 0.5, .method = DirectorMethod::normals});
  EXPECT_EQ(proportionate_repeat(shell, ShellSide::exterior, {2, 4, 1}), Vec2(6, 3));
}

TEST(TextureRepeat, NeedsTheLayerAndCoordinates) {
  Shell shell = square(0.5, 1);
  EXPECT_THROW(proportionate_repeat(shell, ShellSide::interior, {1, 1, 1}), InputError);
  shell.base.corner_uvs.clear();
  EXPECT_THROW(proportionate_repeat(shell, ShellSide::exterior, {1, 1, 1}), InputError);
}

}  // namespace
