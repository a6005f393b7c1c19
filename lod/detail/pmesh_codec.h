// The steps that writing and reading a `.pmesh` have in common. One class does both, so that what is read is
// what was written; see docs/progressive.md for the bytes.
#pragma once

#include <recede/lod/detail/byte_streams.h>
#include <recede/lod/detail/number_lattice.h>
#include <recede/lod/detail/pmesh_table.h>
#include <recede/lod/progressive_mesh.h>

#include <limits>
#include <stdexcept>

namespace recede::detail {

/// What stands in the header of a file.
struct PmeshHeader {
  bool has_uvs = false, has_normals = false, has_colors = false, has_features = false;
  bool has_face_materials = false, keeps_order = true, errors_are_proved = false, has_numbering = false;
  NumberLattice positions, uvs, normals, colors, scalars;
  std::vector<std::string> scalar_names;
  std::vector<Material> materials;
  double quantisation_error = 0;  ///< what quantised positions add to the errors
  std::uint64_t n_splits = 0, n_batches = 0;

  bool has_wedges() const { return has_uvs || has_normals; }
};

/// The numbers of the mesh that is written by those of the file, and the contrary.
struct PmeshNumbers {
  std::vector<Index> vertex, face, corner;                             ///< of the mesh, by that of the file
  std::vector<Index> file_vertex, file_face, file_corner, file_wedge;  ///< k_no_index: not written yet
};

/// Bits of the shape of a split; none: labels follow.
enum SplitShape : std::uint8_t { k_run = 1, k_triangle_first = 2, k_triangle_last = 4, k_part = 8 };

class PmeshCodec {
 public:
  PmeshCodec(PmeshHeader header, bool writes) : header_(std::move(header)), writes_(writes) {}
  /// Writing: takes the numbers of `mesh`, which must live as long.
  void start(const ProgressiveMesh& mesh);

  static void code_header(ByteStreams& streams, PmeshHeader& header, bool writes);
  void code_base(ByteStreams& streams);
  /// Splits of one batch, by their numbers in the mesh; reading finds them in the stream. Layers, where
  /// given, hold splits that don't depend on each other, and are put into the order of the vertices that they
  /// split.
  void code_batch(ByteStreams& streams, std::vector<Index> splits = {},
                  const std::vector<std::size_t>& layer_ends = {});

  const PmeshHeader& header() const { return header_; }
  const PmeshTable& table() const { return table_; }
  const PmeshNumbers& numbers() const { return numbers_; }
  /// Reading: the mesh so far. Items and changes name corners of the table; faces have no corners yet.
  const ProgressiveMesh& read() const { return read_; }
  const std::vector<Index>& first_vertices() const { return first_vertex_; }
  const std::vector<Index>& first_wedges() const { return first_wedge_; }

 private:
  // Numbers and lists one by one: written, or read and set.
  void byte(ByteKind kind, std::uint8_t& value) {
    if (writes_)
      streams_->put(kind, value);
    else
      value = streams_->take(kind);
  }
  template <typename Number>
  void varint(ByteKind kind, Number& value) {
    if (writes_) return streams_->put_varint(kind, value);
    const std::uint64_t taken = streams_->take_varint(kind);
    require(taken <= std::numeric_limits<Number>::max(), "a number is too large");
    value = static_cast<Number>(taken);
  }
  void planes(ByteKind kind, std::uint64_t& value, std::size_t n) {
    if (writes_)
      streams_->put_planes(kind, value, n);
    else
      value = streams_->take_planes(kind, n);
  }
  void number(ByteKind kind, const NumberLattice& lattice, double predicted, double& value);
  static void require(bool condition, const char* reason) {
    if (!condition) throw std::out_of_range(reason);
  }

  void code_split(Index split);
  void code_part(Index split);
  void code_faces(const std::vector<Index>& mesh_faces);
  Index code_new_vertex(Index mesh_vertex, const Vec3& predicted, Index like);
  void code_vertex_values(Index vertex, Index mesh_vertex, const Vec3& predicted, Index like);
  void choose_shape(Index split);
  bool find_run();
  void code_shape();
  void apply_shape(Index kept, Index removed);
  void add_triangle(Index mesh_face, bool turned, Index kept, Index third, Index removed);
  void code_kept_values(Index split, Index kept, Index removed);
  void code_wedges(Index split);
  void code_wedge(Index corner, bool is_given);
  void code_wedge_values(Index wedge, Index mesh_wedge, Index like);
  void code_features(Index split, bool has_changes);
  void code_errors(const std::vector<Index>& splits);
  Vec3 predict(Index removed) const;
  void note_corner(Index corner, Index mesh_corner);
  Index mesh_face_of(Index mesh_corner) const { return mesh_corner_face_[mesh_corner]; }
  std::vector<Index> alive_corners(Index mesh_face) const;
  void note_split(Index kept, Index removed);

  PmeshHeader header_;
  bool writes_;
  PmeshTable table_;
  ByteStreams* streams_ = nullptr;

  // The level so far, by numbers of the file.
  std::vector<Vec3> positions_;
  std::vector<Vec4> colors_;
  std::vector<double> scalars_;  // vertex after vertex
  std::vector<Index> corner_wedge_;
  std::vector<Vec2> wedge_uv_;
  std::vector<Vec3> wedge_normal_;
  std::vector<unsigned char> corner_feature_;

  // Of the split at hand.
  VertexRing ring_;
  struct Triangle {
    Index mesh_face;
    bool turned;  // removed, third, kept instead of kept, third, removed
    Index third;
  };
  std::uint8_t shape_ = 0, run_first_ = 0, run_length_ = 0;
  std::vector<std::uint8_t> labels_;
  std::vector<Triangle> triangles_;
  std::vector<Index> given_, created_;  // corners
  std::vector<Index> items_;            // given, faces, added corners of larger faces
  Index n_new_faces_ = 0;
  Index previous_kept_ = 0;

  // Writing.
  const ProgressiveMesh* mesh_ = nullptr;
  PmeshNumbers numbers_;
  std::vector<unsigned char> mesh_corner_alive_;
  std::vector<Index> mesh_corner_face_;
  std::vector<Index> mesh_corner_wedge_;
  std::vector<unsigned char> is_given_;        // by corner
  std::vector<std::pair<Index, Index>> cuts_;  // faces and their corners that come back

  // Reading.
  ProgressiveMesh read_;
  std::vector<Index> first_vertex_, first_wedge_;  // by corner: as it came
};

}  // namespace recede::detail
