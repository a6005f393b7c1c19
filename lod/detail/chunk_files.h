// A surface on the disk, in chunks that fit in memory one by one.
#pragma once

#include <recede/lod/detail/scratch_file.h>
#include <recede/lod/detail/space_cells.h>

#include <vector>

namespace recede::detail {

/// The faces of one cell.
struct Chunk {
  PolygonSoup soup;
  /// By vertex: 1 where faces of other chunks have it, too; also where it lies in another cell.
  std::vector<unsigned char> shared;
};

/// Every face is in the chunk of the cell in which the mean of its corners lies.
class ChunkFiles {
 public:
  /// `buffer`: bytes that wait in memory at most.
  ChunkFiles(const std::filesystem::path& folder, SpaceCells cells, std::size_t buffer);

  void add(const PolygonSoup& piece);
  /// Call it after the last `add`, before anything else.
  void finish();

  const SpaceCells& cells() const { return cells_; }
  std::size_t n_chunks() const { return chunks_.size(); }
  std::size_t n_faces(std::size_t chunk) const { return chunks_[chunk].n_faces; }
  std::size_t n_faces() const;
  const Box3& box(std::size_t chunk) const { return chunks_[chunk].box; }
  double area(std::size_t chunk) const { return chunks_[chunk].area; }  ///< of its faces' vector areas
  /// Vertices may occur more than once.
  Chunk load(std::size_t chunk) const;

 private:
  struct Stored {
    std::vector<ScratchFile::Extent> extents;
    std::string waiting;
    std::vector<Vec3> shared;  ///< places of its cell that faces of other chunks have; they wait, too
    std::size_t n_faces = 0;
    Box3 box;
    double area = 0;
  };
  void add_faces(const PolygonSoup& piece, std::span<const Index> faces, Index cell,
                 const std::vector<Index>& cell_of_vertex);
  void flush();

  SpaceCells cells_;
  ScratchFile file_;
  std::size_t buffer_, waiting_ = 0;
  std::vector<Stored> chunks_;
  std::vector<Material> materials_;
};

/// The mean of a face's corners.
Vec3 middle_of(const PolygonSoup& soup, std::size_t face);

}  // namespace recede::detail
