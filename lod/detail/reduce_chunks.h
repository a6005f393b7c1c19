// Fewer faces for a surface that doesn't fit in memory.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/lod/detail/chunk_files.h>
#include <recede/lod/simplify.h>

namespace recede::detail {

/// What work in chunks may take.
struct ChunkLimits {
  std::filesystem::path folder;  ///< for scratch files
  std::size_t faces = 0;         ///< of a chunk
  std::size_t buffer = 0;        ///< bytes that wait to be written
};

/// Some of the faces' middles, at most `k_most_middles`, evenly over the order in which they come.
class MiddleSample {
 public:
  static constexpr std::size_t k_most_middles = 400'000;
  explicit MiddleSample(std::size_t n_faces) : stride_(n_faces / k_most_middles + 1) {}

  void add(const PolygonSoup& piece);
  const std::vector<Vec3>& points() const { return points_; }
  /// Cells of at most about `most_faces` faces.
  SpaceCells cells(std::size_t most_faces, double share) const;

 private:
  std::size_t stride_, seen_ = 0;
  std::vector<Vec3> points_;
};

struct ReducedSurface {
  PolygonSoup soup;
  std::size_t passes = 0;
};

/// The surface with at most `most_faces` faces, where they are fewest for the costs of all collapses. Chunks
/// are simplified one by one and meet where they met before; in several passes, borders of chunks lie
/// elsewhere in each. `side`: the longest of the surface's box. Throws `InputError` when no pass gets on.
ReducedSurface reduce_chunks(const ChunkFiles& input, std::size_t most_faces, double side,
                             const ChunkLimits& limits, const SimplifyOptions& options, Progress* progress);

}  // namespace recede::detail
