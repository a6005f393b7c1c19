#include "systems.h"
#include <recede/geometry/error.h>

#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <fmt/format.h>

namespace recede::bench {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge | OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
};
using Triangles = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Polygons = OpenMesh::PolyMesh_ArrayKernelT<Traits>;

template <class Mesh>
Mesh to_mesh(const PolygonSoup& soup, std::size_t& refused_faces) {
  Mesh mesh;
  mesh.reserve(soup.positions.size(), soup.n_corners() / 2 + 1, soup.n_faces());
  std::vector<typename Mesh::VertexHandle> vertices;
  for (const Vec3& p : soup.positions) vertices.push_back(mesh.add_vertex({p.x(), p.y(), p.z()}));
  std::vector<typename Mesh::VertexHandle> corners;
  for (std::size_t face = 0; face < soup.n_faces(); ++face) {
    corners.clear();
    for (const Index vertex : soup.face(face)) corners.push_back(vertices[vertex]);
    if (!mesh.add_face(corners).is_valid()) ++refused_faces;
  }
  mesh.update_face_normals();
  return mesh;
}

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
  const auto start = std::chrono::steady_clock::now();
  Mesh mesh = to_mesh<Mesh>(soup, outcome.refused_faces);
  outcome.setup_seconds = seconds_since(start);
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
  systems.push_back({.name = openmesh + " ModQuadric", .label = "OpenMesh", .run = run<Triangles>});
  systems.push_back({.name = openmesh + " ModQuadric, polygon mesh",
                     .label = "OpenMesh",
                     .takes_triangles = false,
                     .takes_polygons = true,
                     .run = run<Polygons>});
}

}  // namespace recede::bench
