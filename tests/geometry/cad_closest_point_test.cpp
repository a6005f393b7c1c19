// Nearest points of the surfaces of CAD models beside those that OpenCASCADE finds.
#include "cad_checks.h"
#include "sanitized.h"
#include <recede/geometry/nurbs_closest_point.h>

#include <GeomAPI_ProjectPointOnSurf.hxx>
#include <Geom_BSplineSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColStd_Array2OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>

#include <random>

namespace recede::test {
namespace {

namespace fs = std::filesystem;

struct Multiple {
  TColStd_Array1OfReal knots;
  TColStd_Array1OfInteger times;
};

Multiple multiple_knots(const std::vector<double>& knots) {
  std::vector<std::pair<double, int>> found;
  for (const double knot : knots) {
    if (found.empty() || knot != found.back().first) found.emplace_back(knot, 0);
    ++found.back().second;
  }
  const int n = static_cast<int>(found.size());
  Multiple result{TColStd_Array1OfReal(1, n), TColStd_Array1OfInteger(1, n)};
  for (int i = 1; i <= n; ++i) {
    result.knots(i) = found[static_cast<std::size_t>(i - 1)].first;
    result.times(i) = found[static_cast<std::size_t>(i - 1)].second;
  }
  return result;
}

Handle(Geom_BSplineSurface) to_opencascade(const NurbsSurface& surface) {
  const int n_u = static_cast<int>(surface.n_points(0)), n_v = static_cast<int>(surface.n_points(1));
  TColgp_Array2OfPnt poles(1, n_u, 1, n_v);
  TColStd_Array2OfReal weights(1, n_u, 1, n_v);
  for (int i = 0; i < n_u; ++i) {
    for (int j = 0; j < n_v; ++j) {
      const auto k = static_cast<std::size_t>(i * n_v + j);
      const Vec3& point = surface.points[k];
      poles(i + 1, j + 1) = gp_Pnt(point.x(), point.y(), point.z());
      weights(i + 1, j + 1) = surface.is_rational() ? surface.weights[k] : 1;
    }
  }
  const Multiple u = multiple_knots(surface.knots[0]), v = multiple_knots(surface.knots[1]);
  return new Geom_BSplineSurface(poles, weights, u.knots, v.knots, u.times, v.times, surface.degrees[0],
                                 surface.degrees[1]);
}

// From points around the surface. OpenCASCADE knows feet inside only, and doesn't find them all.
void expect_nearest(const NurbsSurface& surface, const std::string& name, int n_points, int& n_compared) {
  const Handle(Geom_BSplineSurface) theirs = to_opencascade(surface);
  const NearestOnSurfaceSearch search(surface);
  Eigen::AlignedBox3d box;
  for (const Vec3& point : surface.points) box.extend(point);
  const double size = box.diagonal().norm();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(-0.5, 0.5);
  for (int i = 0; i < n_points; ++i) {
    const Vec3 from = box.center() + size * Vec3(share(random), share(random), share(random));
    const NearestOnSurface found = search.closest(from);
    EXPECT_NEAR((by_definition(surface, found.uv) - from).norm(), found.distance, 1e-12 * size) << name;
    const GeomAPI_ProjectPointOnSurf projection(gp_Pnt(from.x(), from.y(), from.z()), theirs);
    if (projection.NbPoints() == 0) continue;
    // 1e-10 of the size is what may be missed.
    EXPECT_LE(found.distance, projection.LowerDistance() + 1e-10 * size) << name << ", point " << i;
    ++n_compared;
  }
}

TEST(CadClosestPoint, IsNeverFartherThanOpenCascadesOnShapes) {
  int n_compared = 0;
  for (const TopoDS_Shape& shape :
       {cad_wavy_block(), cad_torus(), cad_cone(), cad_bored_sphere(), cad_offset_face(),
        cad_periodic_patch(), cad_compound(cad_swept_faces())}) {
    for (const CadPart& part : import_shape(shape).parts) {
      for (const TrimmedPatch& patch : part.patches)
        expect_nearest(patch.surface, patch.name, k_sanitized ? 1 : 6, n_compared);
    }
  }
  EXPECT_GT(n_compared, k_sanitized ? 10 : 100);
}

TEST(CadClosestPoint, IsNeverFartherThanOpenCascadesOnFacesOfFiles) {
  if (!fs::exists(RECEDE_DATA "/cad")) GTEST_SKIP() << "no models; ./dev data fetches them";
  if (k_sanitized) GTEST_SKIP() << "slow under sanitizers";
  for (const char* name : {"occ/bottle.brep", "step/linkrods.step", "occ/wing.brep", "occ/shell1.brep"}) {
    int n_compared = 0;
    for (const CadPart& part : read_cad(fs::path(RECEDE_DATA) / "cad" / name).parts) {
      for (const TrimmedPatch& patch : part.patches)
        expect_nearest(patch.surface, std::string(name) + ", " + patch.name, 3, n_compared);
    }
    EXPECT_GT(n_compared, 0) << name;
  }
}

}  // namespace
}  // namespace recede::test
