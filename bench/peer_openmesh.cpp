#include "openmesh_mesh.h"
#include "systems.h"
#include <recede/geometry/error.h>

#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <fmt/format.h>

namespace recede::bench {
namespace {

template <class Mesh>
PolygonSoup to_soup(const Mesh& mesh) {
  PolygonSoup soup;
  for (const auto vertex : mesh.vertices()) {
    const auto& p = mesh.point(vertex);
    soup.positions.emplace_back(p[0], p[1], p[2]);
  }
  std::vector<Index> corners;
  for (const auto face : mesh.faces()) {
    corners.clear();
    for (const auto vertex : mesh.fv_range(face)) corners.push_back(static_cast<Index>(vertex.idx()));
    soup.add_face(corners);
  }
  return soup;
}

template <class Mesh>
Outcome run(const PolygonSoup& soup, const SimplifyTarget& target) {
  Outcome outcome;
  // It would name every face that it refuses; they are counted.
  omerr().disable();
  const WorkTimer setup;
  Mesh mesh = to_openmesh<Mesh>(soup, outcome.refused_faces);
  outcome.setup_seconds = setup.wall();
  const CallMeter meter;
  OpenMesh::Decimater::DecimaterT<Mesh> decimater(mesh);
  typename OpenMesh::Decimater::ModQuadricT<Mesh>::Handle quadric;
  typename OpenMesh::Decimater::ModNormalFlippingT<Mesh>::Handle flipping;
  decimater.add(quadric);
  decimater.add(flipping);
  decimater.module(quadric).unset_max_err();
  if (!decimater.initialize()) throw Error("the decimater can't be initialised");
  if (target.faces) {
    decimater.decimate_to_faces(0, *target.faces);
  } else {
    decimater.decimate_to(target.vertices.value());
  }
  meter.stop(outcome);
  mesh.garbage_collection();
  outcome.result = to_soup(mesh);
  return outcome;
}

}  // namespace

void add_openmesh(std::vector<System>& systems) {
  const std::string openmesh =
      fmt::format("OpenMesh {}.{}", (OM_VERSION >> 16) & 0xf, (OM_VERSION >> 8) & 0xff);
  systems.push_back({.name = openmesh + " ModQuadric", .label = "OpenMesh", .run = run<OpenMeshTriangles>});
  systems.push_back({.name = openmesh + " ModQuadric, polygon mesh",
                     .label = "OpenMesh",
                     .takes_triangles = false,
                     .takes_polygons = true,
                     .run = run<OpenMeshPolygons>});
}

}  // namespace recede::bench
