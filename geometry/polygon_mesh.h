// Half-edge mesh of polygons with any number of sides: OpenMesh's polygon kernel with double positions, and
// typed access to the attributes that Recede keeps.
#pragma once

#include <recede/geometry/polygon_soup.h>

// EigenVectorT.hh specialises a template that it doesn't include, so the order matters.
// clang-format off
#include <OpenMesh/Core/Utils/vector_traits.hh>
#include <OpenMesh/Core/Geometry/EigenVectorT.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
// clang-format on

namespace recede {

struct PolygonMeshTraits : OpenMesh::DefaultTraits {
  using Point = Vec3;
  using Normal = Vec3;
  VertexAttributes(OpenMesh::Attributes::None);
  FaceAttributes(OpenMesh::Attributes::None);
  EdgeAttributes(OpenMesh::Attributes::None);
  HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
};

/// A half-edge mesh. All of OpenMesh's navigation is there (`vertices()`, `faces()`, `point(v)`,
/// circulators). A corner is named by the half-edge that points at its vertex inside its face. Attributes
/// exist after the matching `add_` call; reading an absent one is an error that an assertion catches.
class PolygonMesh : public OpenMesh::PolyMesh_ArrayKernelT<PolygonMeshTraits> {
 public:
  using Kernel = OpenMesh::PolyMesh_ArrayKernelT<PolygonMeshTraits>;

  bool has_corner_uvs() const { return corner_uv_.is_valid(); }
  void add_corner_uvs();
  const Vec2& corner_uv(HalfedgeHandle h) const { return property(corner_uv_, h); }
  Vec2& corner_uv(HalfedgeHandle h) { return property(corner_uv_, h); }

  /// Normals as given by the input, per corner; (0,0,0) where a corner has none.
  bool has_corner_normals() const { return corner_normal_.is_valid(); }
  void add_corner_normals();
  const Vec3& corner_normal(HalfedgeHandle h) const { return property(corner_normal_, h); }
  Vec3& corner_normal(HalfedgeHandle h) { return property(corner_normal_, h); }

  bool has_vertex_colors() const { return vertex_color_.is_valid(); }
  void add_vertex_colors();
  const Vec4& vertex_color(VertexHandle v) const { return property(vertex_color_, v); }
  Vec4& vertex_color(VertexHandle v) { return property(vertex_color_, v); }

  /// Named numbers at the vertices, in the order in which they were added.
  const std::vector<std::string>& vertex_scalar_names() const { return vertex_scalar_names_; }
  /// Returns its number for `vertex_scalar`.
  std::size_t add_vertex_scalar(std::string name);
  double vertex_scalar(std::size_t number, VertexHandle v) const {
    return property(vertex_scalars_[number], v);
  }
  double& vertex_scalar(std::size_t number, VertexHandle v) { return property(vertex_scalars_[number], v); }

  bool has_face_materials() const { return face_material_.is_valid(); }
  void add_face_materials();
  /// Position in `materials`; `k_no_index` where a face has none.
  Index face_material(FaceHandle f) const { return property(face_material_, f); }
  Index& face_material(FaceHandle f) { return property(face_material_, f); }

  /// Edges that operations must keep, beside borders and seams.
  bool has_feature_edges() const { return edge_feature_.is_valid(); }
  void add_feature_edges();
  bool is_feature_edge(EdgeHandle e) const { return has_feature_edges() && property(edge_feature_, e) != 0; }
  void set_feature_edge(EdgeHandle e, bool feature) { property(edge_feature_, e) = feature ? 1 : 0; }

  std::vector<Material> materials;

 private:
  OpenMesh::HPropHandleT<Vec2> corner_uv_;
  OpenMesh::HPropHandleT<Vec3> corner_normal_;
  OpenMesh::VPropHandleT<Vec4> vertex_color_;
  std::vector<std::string> vertex_scalar_names_;
  std::vector<OpenMesh::VPropHandleT<double>> vertex_scalars_;
  OpenMesh::FPropHandleT<Index> face_material_;
  OpenMesh::EPropHandleT<unsigned char> edge_feature_;
};

/// Gives every fan of faces around a vertex a vertex of its own, so that a half-edge mesh can hold the soup:
/// edges with more than two faces, or whose two faces disagree in orientation, are opened; vertices where
/// several fans touch are duplicated. Copies stand at bit-equal positions behind the original vertices;
/// `merge_identical_vertices` undoes the step, and simplification moves the copies as one.
RepairStep split_non_manifold(PolygonSoup& soup);

/// The half-edge mesh of a soup that needs no split. Throws `InputError` for one that does (see
/// `split_non_manifold`).
PolygonMesh to_polygon_mesh(const PolygonSoup& soup);

/// All steps: merge identical vertices, remove degenerate and duplicate faces, orient, split, build.
struct MeshFromSoup {
  PolygonMesh mesh;
  RepairReport report;
};
MeshFromSoup repair_to_polygon_mesh(PolygonSoup soup);

/// The polygons of a mesh, vertices and faces in the mesh's order, each face starting at its half-edge.
PolygonSoup to_soup(const PolygonMesh& mesh);

/// Marks every edge whose faces' normals differ by more than `angle` (radians) as a feature edge. Returns
/// their number.
std::size_t mark_feature_edges(PolygonMesh& mesh, double angle);

/// Counts for people and tests.
struct MeshSummary {
  std::size_t vertices = 0, edges = 0, faces = 0;
  std::size_t triangles = 0, quads = 0, larger_polygons = 0;
  std::size_t border_edges = 0, border_loops = 0, components = 0;
  std::size_t split_vertices = 0;  ///< vertices that share their position with another one
  Box3 box;
  double area = 0;  ///< sum of the polygons' areas (lengths of their vector areas), square units
};
MeshSummary summarize(const PolygonMesh& mesh);

}  // namespace recede
