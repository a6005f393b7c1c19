// Progressive meshes in files and streams: `.pmesh`. The format is described byte by byte in
// docs/progressive.md.
#pragma once

#include <recede/lod/progressive_mesh.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace recede {

struct PmeshOptions {
  /// Bits for each coordinate along the longest side of the bounding box, 1 to 30. Unset: positions are kept
  /// bit for bit.
  std::optional<int> position_bits{};
  /// Bits for each number over the range that the model uses of it, 1 to 30. Unset: kept bit for bit.
  std::optional<int> uv_bits{}, normal_bits{}, color_bits{}, scalar_bits{};
  /// Also write which vertex and face of the input each one is, and where faces start, so that reading gives
  /// back the very same lists. Off: the same polygons in another order. On in any case where the input had to
  /// be mended (see `ProgressiveMesh::mending`) and nothing is quantised.
  bool keep_numbering = false;
  /// Keep the order of splits, and with it every level and its error. Unset: unless positions are quantised.
  /// Off: splits are put into another order within each batch, which saves some 15 bits for each; levels at
  /// the ends of batches stay the same, those inside get the error of the batch's coarse end, and errors
  /// count as estimates. Kept in any case where splits move vertices (another placement than `half_edge`).
  std::optional<bool> keep_order{};
};

/// What a file's bytes are spent on.
struct PmeshReport {
  std::size_t bytes = 0;  ///< of the whole file
  std::size_t base_bytes = 0, connectivity_bytes = 0, position_bytes = 0, attribute_bytes = 0,
              error_bytes = 0;
  std::size_t numbering_bytes = 0;  ///< of numbers and starts of the input, with what mending needs
  std::size_t batches = 0;
  std::string positions;    ///< how they are held: "floats", "doubles", "decimals" or "quantised"
  double largest_move = 0;  ///< how far quantisation moves a vertex at most, object units
};

/// The file's bytes. Same mesh and options, same bytes. Throws `OptionError` for options out of range.
std::string encode_pmesh(const ProgressiveMesh& mesh, const PmeshOptions& options = {},
                         PmeshReport* report = nullptr);

/// Writes the file whole or not at all, and the pictures of base colours beside it.
PmeshReport write_pmesh(const std::filesystem::path& path, const ProgressiveMesh& mesh,
                        const PmeshOptions& options = {});

/// Reads a whole file, and the pictures that its materials name (`PictureLoader`) as far as they are there.
/// Throws `InputError` with the byte where it went wrong.
ProgressiveMesh read_pmesh(const std::filesystem::path& path);

/// Reads a stream as its bytes arrive. After every batch there is a mesh, whose finest level is what has
/// come.
class PmeshReader {
 public:
  /// `name` stands in front of error texts.
  explicit PmeshReader(std::string name);
  ~PmeshReader();
  PmeshReader(const PmeshReader&) = delete;
  PmeshReader& operator=(const PmeshReader&) = delete;

  /// Takes the next bytes, as many or few as there are. Returns how many batches (the base counts as one)
  /// they complete. Throws `InputError`; the reader is then of no more use.
  std::size_t feed(std::string_view bytes);

  std::size_t n_batches() const;
  /// True once the last byte has come.
  bool is_complete() const;
  /// The mesh as far as it has come. Throws `InputError` before the base is there.
  ProgressiveMesh mesh() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace recede
