// Points and derivatives beside OpenCASCADE's own, to 1e-12.
#include "cad_bodies.h"
#include "cad_checks.h"
#include "sanitized.h"
#include <recede/geometry/bezier_patches.h>

#include <Geom_BSplineSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>

namespace recede::test {
namespace {

namespace fs = std::filesystem;

constexpr double k_relative = 1e-12;

Vec3 to_vec(const gp_XYZ& xyz) { return {xyz.X(), xyz.Y(), xyz.Z()}; }

double largest_coordinate(const NurbsSurface& surface) {
  double largest = 0;
  for (const Vec3& point : surface.points) largest = std::max(largest, point.cwiseAbs().maxCoeff());
  return largest;
}

// The degree over the shortest span of knots: what a derivative makes of differences of points.
double steepest(const NurbsSurface& surface, std::size_t axis) {
  double shortest = std::numeric_limits<double>::infinity();
  const std::vector<double>& knots = surface.knots[axis];
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (knots[i] > knots[i - 1]) shortest = std::min(shortest, knots[i] - knots[i - 1]);
  }
  return surface.degrees[axis] / shortest;
}

// Places inside of spans: at knots, either side's derivatives are right.
template <typename Visit>
void each_place(const TrimmedPatch& patch, int n, Visit&& visit) {
  const Eigen::AlignedBox2d box = loops_box(patch);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j)
      visit(Vec2(box.min() + Vec2((i + 0.437) / n, (j + 0.391) / n).cwiseProduct(box.sizes())));
  }
}

using Derivatives = std::array<Vec3, 6>;

Derivatives in_a_row(const SurfaceDerivatives& d) { return {d.point, d.du, d.dv, d.duu, d.duv, d.dvv}; }

Derivatives of_opencascade(const Geom_BSplineSurface& surface, const Vec2& uv) {
  gp_Pnt point;
  gp_Vec du, dv, duu, dvv, duv;
  surface.D2(uv[0], uv[1], point, du, dv, duu, dvv, duv);
  return {to_vec(point.XYZ()), to_vec(du.XYZ()),  to_vec(dv.XYZ()),
          to_vec(duu.XYZ()),   to_vec(duv.XYZ()), to_vec(dvv.XYZ())};
}

// Relative to what the rounding of one coordinate can do to each: the largest coordinate, times degree over
// shortest span for each time that is differentiated. A derivative itself may be nothing.
void expect_same_derivatives(const TrimmedPatch& patch, const Geom_BSplineSurface& theirs,
                             const std::string& name) {
  const BezierPatches pieces(patch.surface);
  const double size = largest_coordinate(patch.surface), u = steepest(patch.surface, 0),
               v = steepest(patch.surface, 1);
  const std::array<double, 6> scales{size, size * u, size * v, size * u * u, size * u * v, size * v * v};
  each_place(patch, 8, [&](const Vec2& uv) {
    const Derivatives expected = of_opencascade(theirs, uv);
    const Derivatives direct = in_a_row(derivatives(patch.surface, uv)),
                      by_pieces = in_a_row(pieces.derivatives(uv));
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_LE((direct[k] - expected[k]).norm(), k_relative * scales[k]) << name << ", number " << k;
      EXPECT_LE((by_pieces[k] - expected[k]).norm(), k_relative * scales[k]) << name << ", number " << k;
    }
  });
}

// By the surfaces' own equations.
double distance_from(const Geom_ElementarySurface& surface, const Vec3& point) {
  const Vec3 from = point - to_vec(surface.Position().Location().XYZ());
  const double height = from.dot(to_vec(surface.Position().Direction().XYZ()));
  const double radius =
      std::sqrt(std::max(std::pow(from.dot(to_vec(surface.Position().XDirection().XYZ())), 2) +
                             std::pow(from.dot(to_vec(surface.Position().YDirection().XYZ())), 2),
                         0.0));
  if (const auto* sphere = dynamic_cast<const Geom_SphericalSurface*>(&surface))
    return std::abs(from.norm() - sphere->Radius());
  if (const auto* cylinder = dynamic_cast<const Geom_CylindricalSurface*>(&surface))
    return std::abs(radius - cylinder->Radius());
  // Both sides of the axis: cones go on beyond their tip, and tori may meet their axis.
  double nearest = std::numeric_limits<double>::infinity();
  for (const double side : {radius, -radius}) {
    if (const auto* torus = dynamic_cast<const Geom_ToroidalSurface*>(&surface)) {
      nearest =
          std::min(nearest, std::abs(std::hypot(side - torus->MajorRadius(), height) - torus->MinorRadius()));
    } else if (const auto* cone = dynamic_cast<const Geom_ConicalSurface*>(&surface)) {
      const double angle = cone->SemiAngle();
      nearest = std::min(nearest,
                         std::abs((side - cone->RefRadius()) * std::cos(angle) - height * std::sin(angle)));
    } else {
      nearest = std::abs(height);  // a plane
    }
  }
  return nearest;
}

struct Compared {
  int splines = 0, elementary = 0;
};

void compare(const TrimmedPatch& patch, const TopoDS_Face& face, double size, const std::string& name,
             Compared& compared) {
  Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  while (const auto trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface))
    surface = trimmed->BasisSurface();
  if (const auto spline = Handle(Geom_BSplineSurface)::DownCast(surface)) {
    expect_same_derivatives(patch, *spline, name);
    ++compared.splines;
  }
  if (const auto elementary = Handle(Geom_ElementarySurface)::DownCast(surface)) {
    const double scale = size + largest_coordinate(patch.surface);
    each_place(patch, 16, [&](const Vec2& uv) {
      EXPECT_LE(distance_from(*elementary, evaluate(patch.surface, uv)), k_relative * scale) << name;
    });
    ++compared.elementary;
  }
}

Compared compare_faces(const CadModel& model, const TopoDS_Shape& shape, const std::string& name) {
  Compared compared;
  const std::vector<TopoDS_Shape> bodies = bodies_of(shape);
  EXPECT_EQ(model.instances.size(), bodies.size()) << name;
  for (std::size_t b = 0; b < std::min(bodies.size(), model.instances.size()); ++b) {
    const std::vector<TopoDS_Face> faces = faces_of(bodies[b]);
    const CadPart& part = model.parts[model.instances[b].part];
    EXPECT_EQ(part.patches.size(), faces.size()) << name;
    for (std::size_t i = 0; i < std::min(faces.size(), part.patches.size()); ++i) {
      compare(part.patches[i], face_of_body(faces[i], bodies[b]), size_of(bodies[b]),
              name + ", face " + std::to_string(i + 1), compared);
    }
  }
  return compared;
}

TEST(CadEvaluation, OfElementarySurfacesIsOnThem) {
  Compared compared;
  for (const TopoDS_Shape& shape : {cad_rounded_box(), cad_cylinder(), cad_sphere(), cad_bored_sphere(),
                                    cad_torus(), cad_cone(), cad_screw(), cad_plate(2)})
    compared.elementary += compare_faces(import_shape(shape), shape, "shape").elementary;
  EXPECT_EQ(compared.elementary, 26 + 3 + 1 + 13 + 1 + 2 + 6 + 10);
}

TEST(CadEvaluation, OfSplinesHasOpenCascadesPointsAndDerivatives) {
  for (const TopoDS_Shape& shape : {cad_wavy_block(), cad_periodic_patch()})
    EXPECT_GE(compare_faces(import_shape(shape), shape, "shape").splines, 1);
}

TEST(CadEvaluation, OfFilesHasOpenCascadesPointsAndDerivatives) {
  const fs::path folder = fs::path(RECEDE_DATA) / "cad";
  if (!fs::exists(folder)) GTEST_SKIP() << "no models; ./dev data fetches them";
  Compared compared;
  for (const char* name : {"occ/bottle.brep", "step/linkrods.step", "step/screw.step", "occ/hammer.brep",
                           "occ/Motor-c.brep", "occ/shell1.brep", "iges/bearing.iges", "iges/hammer.iges"}) {
    const Compared of_file = compare_faces(read_cad(folder / name), shape_of(folder / name), name);
    compared.splines += of_file.splines;
    compared.elementary += of_file.elementary;
    if (k_sanitized) break;  // the others are slow
  }
  if (k_sanitized) return;
  EXPECT_GT(compared.splines, 100);
  EXPECT_GT(compared.elementary, 100);
}

}  // namespace
}  // namespace recede::test
