#include "systems.h"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>
#include <vtkSmartPointer.h>
#include <vtkVersionMacros.h>

namespace recede::bench {
namespace {

vtkSmartPointer<vtkPolyData> to_mesh(const PolygonSoup& soup) {
  const auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToDouble();
  for (const Vec3& p : soup.positions) points->InsertNextPoint(p.x(), p.y(), p.z());
  const auto faces = vtkSmartPointer<vtkCellArray>::New();
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const auto face = soup.face(f);
    const vtkIdType corners[] = {face[0], face[1], face[2]};
    faces->InsertNextCell(3, corners);
  }
  auto mesh = vtkSmartPointer<vtkPolyData>::New();
  mesh->SetPoints(points);
  mesh->SetPolys(faces);
  return mesh;
}

PolygonSoup to_soup(vtkPolyData& mesh) {
  PolygonSoup soup;
  for (vtkIdType v = 0; v < mesh.GetNumberOfPoints(); ++v) {
    double p[3];
    mesh.GetPoint(v, p);
    soup.positions.emplace_back(p[0], p[1], p[2]);
  }
  const auto corners = vtkSmartPointer<vtkIdList>::New();
  std::vector<Index> face;
  for (vtkIdType f = 0; f < mesh.GetNumberOfPolys(); ++f) {
    mesh.GetPolys()->GetCellAtId(f, corners);
    face.clear();
    for (vtkIdType i = 0; i < corners->GetNumberOfIds(); ++i) {
      face.push_back(static_cast<Index>(corners->GetId(i)));
    }
    soup.add_face(face);
  }
  return soup;
}

Outcome run(const PolygonSoup& soup, const SimplifyTarget& target) {
  Outcome outcome;
  const WorkTimer setup;
  const auto decimation = vtkSmartPointer<vtkQuadricDecimation>::New();
  decimation->SetInputData(to_mesh(soup));
  const double share = static_cast<double>(target.faces.value()) / static_cast<double>(soup.n_faces());
  decimation->SetTargetReduction(1 - share);
  outcome.setup_seconds = setup.wall();
  const CallMeter meter;
  decimation->Update();
  meter.stop(outcome);
  outcome.result = to_soup(*decimation->GetOutput());
  return outcome;
}

}  // namespace

void add_vtk(std::vector<System>& systems) {
  const std::string version = std::to_string(VTK_MAJOR_VERSION) + "." + std::to_string(VTK_MINOR_VERSION);
  systems.push_back({.name = "VTK " + version + " QuadricDecimation", .label = "VTK", .run = run});
}

}  // namespace recede::bench
