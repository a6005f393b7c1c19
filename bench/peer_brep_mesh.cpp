#include "cad_search.h"
#include "cad_shapes.h"
#include "child_process.h"
#include "measurement.h"
#include "work_timer.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>

#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <IMeshTools_Parameters.hxx>
#include <Poly_Triangulation.hxx>
#include <Standard_Failure.hxx>
#include <TopoDS_Compound.hxx>

#include <algorithm>

namespace recede::bench {
namespace {

/// Long runs aren't repeated.
constexpr double k_repeat_seconds = 20;

IMeshTools_Parameters parameters(double deflection, double angle) {
  IMeshTools_Parameters result;
  result.Deflection = deflection;
  result.Angle = angle;
  result.InParallel = true;
  return result;
}

/// Flags of its status.
std::size_t mesh(const CadSubject& subject, double deflection, double angle) {
  std::size_t status = 0;
  for (const CadBench& body : subject.bodies) {
    const BRepMesh_IncrementalMesh mesher(body.shape, parameters(deflection, angle));
    status |= static_cast<std::size_t>(mesher.GetStatusFlags());
  }
  return status;
}

void clean(const CadSubject& subject) {
  for (const CadBench& body : subject.bodies) BRepTools::Clean(body.shape);
}

Vec3 to_vec(const gp_Pnt& point) { return {point.X(), point.Y(), point.Z()}; }

CadFaceMesh mesh_of(const TopoDS_Face& face, std::size_t number) {
  CadFaceMesh result;
  result.face = number;
  TopLoc_Location location;
  const Handle(Poly_Triangulation) triangles = BRep_Tool::Triangulation(face, location);
  if (triangles.IsNull()) return result;
  const gp_Trsf placement = location.Transformation();
  for (int i = 1; i <= triangles->NbNodes(); ++i) {
    const gp_Pnt2d uv = triangles->UVNode(i);
    result.uvs.emplace_back(uv.X(), uv.Y());
    result.positions.push_back(to_vec(triangles->Node(i).Transformed(placement)));
  }
  for (int i = 1; i <= triangles->NbTriangles(); ++i) {
    int a = 0, b = 0, c = 0;
    triangles->Triangle(i).Get(a, b, c);
    result.triangles.push_back(
        {static_cast<Index>(a - 1), static_cast<Index>(b - 1), static_cast<Index>(c - 1)});
  }
  return result;
}

std::vector<CadBodyMesh> meshes_of(const CadSubject& subject) {
  std::vector<CadBodyMesh> meshes;
  for (const CadBench& body : subject.bodies) {
    CadBodyMesh& made = meshes.emplace_back();
    for (std::size_t face = 0; face < body.faces.size(); ++face)
      made.faces.push_back(mesh_of(body.faces[face], face));
  }
  return meshes;
}

CadFigures measure_brep_mesh(const CadSubject& subject, const CadRunOptions& options) {
  const test::Silence silence;
  CadFigures figures;
  const std::size_t resident = resident_bytes();
  forget_peak();
  const WorkTimer all;
  std::vector<double> cpu, wall;
  for (std::size_t run = 0; run < options.repeats; ++run) {
    if (run > 0 && all.wall() > k_repeat_seconds) break;
    clean(subject);
    const WorkTimer timer;
    figures.status = mesh(subject, options.deflection, options.angle);
    cpu.push_back(timer.cpu());
    wall.push_back(timer.wall());
    if (run == 0) figures.peak_bytes = peak_above(resident);
  }
  figures.total = {median(cpu), median(wall)};
  const CadJudgeOptions judging{.deflection = options.deflection};
  figures.judgement = judge(subject, meshes_of(subject), judging);
  if (!options.equal) return figures;
  figures.equal = find_equal(options.deflection, figures.judgement, [&](double setting) {
    clean(subject);
    mesh(subject, setting, options.angle);
    return judge(subject, meshes_of(subject),
                 {.deflection = options.deflection, .samples = k_search_samples});
  });
  return figures;
}

CadLevels measure_levels(const CadSubject& subject, double deflection, const std::filesystem::path& file) {
  constexpr double k_finer = 1.0 / 20, k_angle = 0.5;
  const test::Silence silence;
  CadLevels levels;
  mesh(subject, deflection, k_angle);
  for (const CadBodyMesh& made : meshes_of(subject)) levels.even += count_open_edges(made, subject.diagonal);
  for (const CadBench& body : subject.bodies) {
    TopoDS_Compound every_second;
    BRep_Builder builder;
    builder.MakeCompound(every_second);
    for (std::size_t face = 1; face < body.faces.size(); face += 2)
      builder.Add(every_second, body.faces[face]);
    const BRepMesh_IncrementalMesh mesher(every_second, parameters(k_finer * deflection, k_angle));
  }
  const std::vector<CadBodyMesh> meshes = meshes_of(subject);
  if (!file.empty()) write_soup(file, soup_of(subject, meshes));
  for (const CadBodyMesh& made : meshes) {
    levels.odd_finer += count_open_edges(made, subject.diagonal);
    for (const CadFaceMesh& face : made.faces) levels.triangles += face.triangles.size();
  }
  return levels;
}

/// Failures of OpenCASCADE aren't standard exceptions.
template <typename Work>
auto in_child(unsigned seconds_allowed, Work&& work) {
  return run_in_child(
      [&] {
        try {
          return as_bytes(work());
        } catch (const Standard_Failure& failure) {
          throw recede::Error(failure.DynamicType()->Name());
        }
      },
      seconds_allowed);
}

}  // namespace

CadAnswer run_brep_mesh(const CadSubject& subject, const CadRunOptions& options) {
  const ChildAnswer answer =
      in_child(options.seconds_allowed, [&] { return measure_brep_mesh(subject, options); });
  if (!answer.succeeded) return {{}, answer.failure};
  return {ByteReader(answer.bytes).take<CadFigures>(), {}};
}

CadLevelsAnswer run_brep_mesh_levels(const CadSubject& subject, double deflection,
                                     const std::filesystem::path& mesh) {
  const ChildAnswer answer =
      in_child(CadRunOptions{}.seconds_allowed, [&] { return measure_levels(subject, deflection, mesh); });
  if (!answer.succeeded) return {{}, answer.failure};
  return {ByteReader(answer.bytes).take<CadLevels>(), {}};
}

std::vector<std::vector<CadBodyMesh>> brep_meshes(const CadSubject& subject,
                                                  std::span<const double> deflections, double angle) {
  const test::Silence silence;
  std::vector<std::vector<CadBodyMesh>> levels;
  for (const double deflection : deflections) {
    clean(subject);
    mesh(subject, deflection, angle);
    levels.push_back(meshes_of(subject));
  }
  clean(subject);
  return levels;
}

}  // namespace recede::bench
