// What a progressive mesh is built from: the input, mended so that a corner table takes it as it is.
#pragma once

#include <recede/lod/detail/corner_table.h>
#include <recede/lod/progressive_mesh.h>

namespace recede::detail {

/// A soup in which no two vertices of faces stand at one place and no face visits a vertex twice, and how its
/// faces and corners are numbered in the progressive mesh.
class ProgressiveSource {
 public:
  /// Sets the lists of `mesh` by vertex, face and corner to the input's, mended; and its mending, but for
  /// wedges.
  ProgressiveSource(const PolygonSoup& input, ProgressiveMesh& mesh);

  const PolygonSoup& soup() const { return is_input_ ? input_ : mended_; }

  /// Finds the corners of a table built from `soup()`, and sets the wedges of the mesh.
  void match(const CornerTable& table, ProgressiveMesh& mesh);

  /// In numbers of the progressive mesh.
  Index face(Index face_of_soup) const {
    return face_number_.empty() ? face_of_soup : face_number_[face_of_soup];
  }
  Index corner(Index corner_of_table) const { return corner_number_[corner_of_table]; }
  Index face_of_corner(Index corner) const { return corner_face_[corner]; }
  bool has_twins() const { return !twin_corner_.empty(); }
  /// The same corner on the reverse of a double-sided face, or k_no_index.
  Index twin_corner(Index corner_of_table) const { return twin_corner_[corner_of_table]; }
  /// The reverse of a face of the soup, or k_no_index.
  Index twin_face(Index face_of_soup) const { return twin_face_[face_of_soup]; }

 private:
  bool weld();
  void add_mended_faces(const std::vector<Index>& faces, ProgressiveMesh& mesh);
  void find_twins(const CornerTable& table, const std::vector<Index>& offsets);
  void set_wedges(const CornerTable& table, ProgressiveMesh& mesh) const;

  const PolygonSoup& input_;
  PolygonSoup mended_;
  bool is_input_ = true;
  std::vector<Index> face_number_;    // by face of the soup; empty: the same
  std::vector<Index> corner_number_;  // by corner of the table
  std::vector<Index> corner_face_;    // by corner of the progressive mesh
  std::vector<Index> twin_corner_, twin_face_;
};

}  // namespace recede::detail
