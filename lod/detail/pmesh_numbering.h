// The last part of a `.pmesh`: which vertex and face of the input each one of the file is, and what only the
// input has.
#pragma once

#include <recede/lod/detail/pmesh_codec.h>

namespace recede::detail {

struct PmeshNumbering {
  std::vector<Index> vertex, face;  ///< of the input, by that of the file
  std::vector<Index> first;  ///< by face of the file: how many corners after its first one the input's is
  std::size_t n_vertices = 0, n_faces = 0;  ///< of the mesh
  // What the file has nowhere else; vertices and faces in ascending order.
  std::vector<Vec3> positions;
  std::vector<Vec4> colors;
  std::vector<double> scalars;
  std::vector<Vec2> wedge_uvs;
  std::vector<Vec3> wedge_normals;
  std::vector<Index> face_sizes, face_materials, corner_vertices, corner_wedges;  ///< of the further faces
  ProgressiveMesh::Mending mending;
  std::vector<std::pair<Index, Index>> feature_edges;
};

/// `numbers` are those of a codec that has written everything else.
PmeshNumbering find_numbering(const ProgressiveMesh& mesh, const PmeshHeader& header, const PmeshTable& table,
                              PmeshNumbers numbers);

template <bool writes>
void code_numbering(ByteStreams& streams, const PmeshHeader& header, const PmeshTable& table,
                    PmeshNumbering& numbering);

/// The mesh that a codec has read so far, in the numbers of the input when there is a numbering.
ProgressiveMesh assemble(const PmeshCodec& codec, const PmeshNumbering* numbering);

}  // namespace recede::detail
