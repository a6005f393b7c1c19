// The meshes on which OpenMesh's decimaters work.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

#include <vector>

namespace recede::bench {

struct OpenMeshTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge | OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
};
using OpenMeshTriangles = OpenMesh::TriMesh_ArrayKernelT<OpenMeshTraits>;
using OpenMeshPolygons = OpenMesh::PolyMesh_ArrayKernelT<OpenMeshTraits>;

/// `refused_faces` counts those that a half-edge mesh can't hold.
template <class Mesh>
Mesh to_openmesh(const PolygonSoup& soup, std::size_t& refused_faces) {
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

}  // namespace recede::bench
