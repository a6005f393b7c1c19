// Faces of all kinds of surfaces become NURBS patches over the same points.
#include "cad_checks.h"

#include <gmock/gmock.h>

#include <numbers>

namespace recede::test {
namespace {

using testing::HasSubstr;

struct Solid {
  const char* name;
  TopoDS_Shape (*make)();
  std::size_t patches, edges;
  friend std::ostream& operator<<(std::ostream& out, const Solid& solid) { return out << solid.name; }
};

class CadSolid : public testing::TestWithParam<Solid> {};
INSTANTIATE_TEST_SUITE_P(CadImport, CadSolid,
                         testing::Values(Solid{"Box", [] { return cad_box(); }, 6, 12},
                                         Solid{"RoundedBox", [] { return cad_rounded_box(); }, 26, 48},
                                         Solid{"Cylinder", [] { return cad_cylinder(); }, 3, 3},
                                         // The seam alone: the poles have no length.
                                         Solid{"Sphere", [] { return cad_sphere(); }, 1, 1},
                                         // Six floors, six walls with a seam each, six rims on both ends, and
                                         // the sphere's seam in pieces.
                                         Solid{"BoredSphere", [] { return cad_bored_sphere(); }, 13, 22},
                                         Solid{"Torus", [] { return cad_torus(); }, 1, 2},
                                         Solid{"ConeWithItsTip", [] { return cad_cone(); }, 2, 2},
                                         Solid{"WavyBlockWithHoles", [] { return cad_wavy_block(); }, 22, 92},
                                         Solid{"Prism", [] { return cad_prism(17); }, 19, 51},
                                         Solid{"Screw", [] { return cad_screw(); }, 6, 9}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(CadSolid, IsClosedAndOfTheFilesPoints) {
  const TopoDS_Shape shape = GetParam().make();
  const CadModel model = import_shape(shape);
  expect_well_formed(model);
  ASSERT_EQ(model.parts.size(), 1u);
  EXPECT_EQ(list(model), "");
  const CadPart& part = model.parts[0];
  EXPECT_TRUE(part.is_closed);
  const std::vector<TopoDS_Face> faces = faces_of(shape);
  ASSERT_EQ(part.patches.size(), faces.size());
  EXPECT_EQ(part.patches.size(), GetParam().patches);
  EXPECT_EQ(part.n_edges, GetParam().edges);
  EXPECT_EQ(part.n_edges, count_edges(shape));
  const double size = size_of(shape);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    // 1e-9 is promised; the search for the nearest place ends sooner on some surfaces.
    EXPECT_LT(distance_from_surface(part.patches[i], faces[i]), 1e-9 * size) << "face " << i + 1;
    EXPECT_LE(tolerances_from_edges(part.patches[i], faces[i], 1e-9 * size), 1) << "face " << i + 1;
    EXPECT_EQ(part.patches[i].is_reversed, faces[i].Orientation() == TopAbs_REVERSED);
  }
}

/// Curves that are exact on both sides, where intersections by OpenCASCADE aren't among them.
TEST(CadImport, CurvesOfAnEdgeMeetAtEqualSharesToRounding) {
  for (const TopoDS_Shape& shape : {cad_box(), cad_cylinder(), cad_sphere(), cad_torus(), cad_cone(),
                                    cad_prism(5), cad_plate(3), cad_screw()}) {
    EXPECT_LT(largest_gap(import_shape(shape).parts[0]), 1e-12 * size_of(shape));
  }
  // Circles along the fillets are the edges' own, and on the flat sides fitted: within 1e-10.
  EXPECT_LT(largest_gap(import_shape(cad_rounded_box()).parts[0]), 1e-9 * size_of(cad_box()));
  for (const TopoDS_Shape& shape : {cad_bored_sphere(), cad_wavy_block()}) {
    // Four times the tolerance of 1e-7 that OpenCASCADE gives its intersections when they are good; bored
    // splines have worse ones.
    EXPECT_LT(largest_gap(import_shape(shape).parts[0]), 1e-5);
  }
}

TEST(CadImport, PatchesOfABoxFaceOutwards) {
  const CadModel model = import_shape(cad_box(30, 20, 10));
  const Vec3 middle(15, 10, 5);
  for (const TrimmedPatch& patch : model.parts[0].patches) {
    const Vec2 uv = loops_box(patch).center();
    const SurfaceDerivatives at = derivatives(patch.surface, uv);
    const double front = at.du.cross(at.dv).dot(at.point - middle);
    EXPECT_EQ(front < 0, patch.is_reversed) << patch.name;
  }
}

TEST(CadImport, ACylinderIsARationalQuadraticWithItsSeamTwice) {
  const CadModel model = import_shape(cad_cylinder(5, 12));
  const auto side = std::find_if(model.parts[0].patches.begin(), model.parts[0].patches.end(),
                                 [](const TrimmedPatch& patch) { return patch.surface.is_rational(); });
  ASSERT_NE(side, model.parts[0].patches.end());
  EXPECT_EQ(side->surface.degrees, (std::array<int, 2>{2, 1}));
  // Four quarters of a circle, of which the corners between are at the square root of 2.
  EXPECT_EQ(side->surface.points.size(), 18u);
  EXPECT_NEAR(side->surface.weights[2], std::numbers::sqrt2 / 2, 1e-15);
  ASSERT_EQ(side->loops.size(), 1u);
  ASSERT_EQ(side->loops[0].curves.size(), 4u);
  std::vector<Index> edges;
  for (const TrimmingCurve& curve : side->loops[0].curves) {
    EXPECT_EQ(curve.curve.degree, 1);
    edges.push_back(curve.edge);
  }
  std::sort(edges.begin(), edges.end());
  EXPECT_EQ(std::unique(edges.begin(), edges.end()) - edges.begin(), 3);
}

TEST(CadImport, PolesAreSidesWithoutAnEdgeBetweenOneCorner) {
  const CadModel model = import_shape(cad_sphere());
  const TrimmedPatch& patch = model.parts[0].patches[0];
  ASSERT_EQ(patch.loops.size(), 1u);
  int poles = 0;
  for (const TrimmingCurve& curve : patch.loops[0].curves) {
    if (curve.edge != k_no_index) continue;
    ++poles;
    EXPECT_EQ(curve.corners[0], curve.corners[1]);
    const Vec3 begin = by_definition(patch.surface, point_at(curve, 0));
    EXPECT_NEAR((by_definition(patch.surface, point_at(curve, 0.4)) - begin).norm(), 0, 1e-14);
  }
  EXPECT_EQ(poles, 2);
  EXPECT_EQ(patch.loops[0].curves.size(), 4u);
}

TEST(CadImport, HolesRunClockwise) {
  const CadModel model = import_shape(cad_plate(2));
  std::size_t faces_with_holes = 0;
  for (const TrimmedPatch& patch : model.parts[0].patches) {
    if (patch.loops.size() == 1) continue;
    ++faces_with_holes;
    ASSERT_EQ(patch.loops.size(), 5u);
    std::vector<double> areas;
    for (const TrimmingLoop& loop : patch.loops) areas.push_back(signed_area(loop));
    std::sort(areas.begin(), areas.end());
    EXPECT_NEAR(areas[4], 256, 1e-9);
    // A polygon of 32 corners in each circle of radius 1.6.
    const double circle = 1.6 * 1.6 * 16 * std::sin(2 * std::numbers::pi / 32);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(areas[static_cast<std::size_t>(i)], -circle, 0.01);
  }
  EXPECT_EQ(faces_with_holes, 2u);
}

TEST(CadImport, SweptConicsAreExact) {
  for (const TopoDS_Shape& shape : cad_swept_faces()) {
    const CadModel model = import_shape(shape);
    expect_well_formed(model);
    EXPECT_EQ(list(model), "");
    const TrimmedPatch& patch = model.parts[0].patches[0];
    const double rounding = 1e-9 * size_of(shape);
    EXPECT_LT(distance_from_surface(patch, faces_of(shape)[0]), rounding);
    EXPECT_LE(tolerances_from_edges(patch, faces_of(shape)[0], rounding), 1);
  }
}

TEST(CadImport, AnOffsetSurfaceIsNearAndNamed) {
  const TopoDS_Shape shape = cad_offset_face();
  const CadModel model = import_shape(shape);
  expect_well_formed(model);
  EXPECT_THAT(list(model), HasSubstr("face 1 of \"shape\": its surface is a NURBS within"));
  const double distance = distance_from_surface(model.parts[0].patches[0], faces_of(shape)[0]);
  EXPECT_LT(distance, 1e-7 * size_of(shape));
}

TEST(CadImport, APatchAcrossTheStartOfAPeriodicSplineIsInOnePiece) {
  const TopoDS_Shape shape = cad_periodic_patch();
  const CadModel model = import_shape(shape);
  expect_well_formed(model);
  const TrimmedPatch& patch = model.parts[0].patches[0];
  EXPECT_LT(distance_from_surface(patch, faces_of(shape)[0]), 1e-9 * size_of(shape));
  EXPECT_LE(tolerances_from_edges(patch, faces_of(shape)[0], 1e-9 * size_of(shape)), 1);
  // Half of the way around.
  EXPECT_NEAR(loops_box(patch).sizes()[0], patch.surface.domain(0).length(), 1e-9);
}

TEST(CadImport, LoopsOfAPeriodicSurfaceComeTogether) {
  const TopoDS_Shape shape = cad_shifted_patch();
  const CadModel model = import_shape(shape);
  expect_well_formed(model);
  ASSERT_EQ(list(model), "");
  const TrimmedPatch& patch = model.parts[0].patches[0];
  ASSERT_EQ(patch.loops.size(), 2u);
  // The hole is a ninth of the area in angles.
  const double outer = signed_area(patch.loops[0]), hole = signed_area(patch.loops[1]);
  EXPECT_NEAR(outer, 9, 0.2);
  EXPECT_NEAR(hole, -1, 0.2);
  EXPECT_LE(tolerances_from_edges(patch, faces_of(shape)[0], 1e-9 * size_of(shape)), 1);
}

TEST(CadImport, FacesWithoutWiresHaveTheirSurfacesBounds) {
  const CadModel flat = import_shape(cad_face_without_wires());
  expect_well_formed(flat);
  EXPECT_EQ(flat.parts[0].patches[0].loops[0].curves.size(), 4u);
  EXPECT_FALSE(flat.parts[0].is_closed);
  const CadModel sphere = import_shape(cad_sphere_without_wires());
  expect_well_formed(sphere);
  EXPECT_EQ(sphere.parts[0].n_edges, 1u);
  EXPECT_TRUE(sphere.parts[0].is_closed);
}

}  // namespace
}  // namespace recede::test
