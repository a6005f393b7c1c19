// Polygons as a file holds them: no connectivity, possibly non-manifold. Repair steps turn them into
// something that a half-edge mesh can represent, and say what they changed.
#pragma once

#include <recede/geometry/material.h>
#include <recede/geometry/vec.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace recede {

/// Index of a vertex, face, corner or material.
using Index = std::uint32_t;
inline constexpr Index k_no_index = 0xffffffffu;

/// A number at every vertex, by its name: a measured quantity, a weight, a temperature.
struct VertexScalar {
  std::string name;
  std::vector<double> values;  ///< V values; those that aren't finite are missing
  bool operator==(const VertexScalar&) const = default;
};

/// Polygons over shared vertices, with attributes on corners, vertices and faces.
/// A corner is one vertex of one face; corners are numbered face by face, in the face's order.
/// Attribute lists are either empty (absent) or exactly as long as said here.
struct PolygonSoup {
  std::vector<Vec3> positions;               ///< V positions
  std::vector<Index> face_offsets{0};        ///< F + 1 entries: face f has corners [offsets[f], offsets[f+1])
  std::vector<Index> corner_vertices;        ///< C vertex indices
  std::vector<Vec2> corner_uvs;              ///< C texture coordinates, or empty
  std::vector<Vec3> corner_normals;          ///< C normals, or empty; (0,0,0) where a corner has none
  std::vector<Vec4> vertex_colors;           ///< V linear colours with opacity, 0 to 1, or empty
  std::vector<VertexScalar> vertex_scalars;  ///< each with another name
  std::vector<Index> face_materials;         ///< F positions in `materials` (`k_no_index`: none), or empty
  std::vector<Material> materials;
  std::vector<std::pair<Index, Index>> feature_edges;  ///< vertex pairs that simplification must keep

  std::size_t n_faces() const { return face_offsets.size() - 1; }
  std::size_t n_corners() const { return corner_vertices.size(); }
  std::size_t face_size(std::size_t face) const { return face_offsets[face + 1] - face_offsets[face]; }
  std::span<const Index> face(std::size_t face) const {
    return {corner_vertices.data() + face_offsets[face], face_size(face)};
  }
  /// Appends a face without attributes.
  void add_face(std::span<const Index> vertices);
};

/// What one repair step did.
struct RepairStep {
  std::string name;         ///< the step's function name
  std::size_t changed = 0;  ///< elements that it merged, removed, flipped or duplicated
  std::string detail;       ///< what was changed, in words; empty when nothing was
};

/// The steps in the order in which they ran.
struct RepairReport {
  std::vector<RepairStep> steps;
  std::size_t total_changed() const;
};

/// Throws `InputError` when a list has the wrong length, an index is out of range, a face has fewer than
/// three corners, a position, normal, texture coordinate or colour isn't
/// finite (the text names it), or scalars have no name or the same one. `source` stands in front of the
/// text.
void validate(const PolygonSoup& soup, const std::string& source);

/// Gives vertices with bit-equal positions one index (-0 equals 0). Vertices that meet but differ in colour
/// or a scalar keep those of the lowest index, and the detail says how many did.
RepairStep merge_identical_vertices(PolygonSoup& soup);

/// Removes repeated neighbours from faces, splits a face that visits a vertex twice into simple loops, and
/// removes what has fewer than three corners left. Faces of zero area stay: they carry connectivity.
RepairStep remove_degenerate_faces(PolygonSoup& soup);

/// Removes every face that repeats an earlier one: the same vertices in the same cyclic order, wherever it
/// starts. A face and its reverse are two sides of a sheet, and both stay.
RepairStep remove_duplicate_faces(PolygonSoup& soup);

/// Flips faces so that neighbours over two-sided edges agree. In every connected part the larger side (by
/// number of faces) keeps its orientation. Edges of a one-sided (Moebius) part stay in disagreement.
RepairStep orient_consistently(PolygonSoup& soup);

/// Removes vertices that no face and no feature edge uses.
RepairStep remove_unreferenced_vertices(PolygonSoup& soup);

/// The signed volume's vector analogue: half the sum of cross products along the polygon. Its length is the
/// area of a planar polygon, its direction the normal of a counter-clockwise one (Newell's formula).
Vec3 vector_area(const PolygonSoup& soup, std::size_t face);

Box3 bounding_box(const PolygonSoup& soup);

/// Triangles that cover the polygons: three vertex indices each, in face order. Triangles stay as they are,
/// quads are cut along the diagonal that gives the better-shaped pair, larger polygons by ear clipping in the
/// plane of their vector area. `triangle_faces`, when given, receives the face of each triangle, and
/// `triangle_corners` the corner index of each of its three vertices.
std::vector<Index> triangulate(const PolygonSoup& soup, std::vector<Index>* triangle_faces = nullptr,
                               std::vector<Index>* triangle_corners = nullptr);

/// The same triangles as a soup over the same positions, without attributes.
PolygonSoup triangulated(const PolygonSoup& soup);

}  // namespace recede
