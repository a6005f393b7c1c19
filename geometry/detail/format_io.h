// What the readers and writers of single formats share with mesh_io.cpp: a file in memory going in, a file as
// one string coming out. Files are touched in mesh_io.cpp only, apart from what a file names (.mtl, .bin).
#pragma once

#include <recede/geometry/mesh_io.h>
#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace recede::detail {

/// A file in memory, which somebody else owns, and how to complain about it.
struct InputFile {
  std::filesystem::path path;
  std::string name;  ///< the path as it stands in messages
  std::string_view content;
  Progress* progress = nullptr;
  /// Where readers put a phrase for each kind of thing that a soup has no place for: levels, skins,
  /// animations.
  std::vector<std::string>* left_aside = nullptr;

  [[noreturn]] void fail(const std::string& reason) const;
  [[noreturn]] void fail_at_line(std::size_t line, const std::string& reason) const;
  [[noreturn]] void fail_at_byte(std::size_t offset, const std::string& reason) const;
};

/// Tells the file's `Progress` how far the reader is, at most once in some megabytes.
class ReadProgress {
 public:
  explicit ReadProgress(const InputFile& file) : file_(file) {}
  void at(std::size_t offset) {
    if (offset >= next_) report(offset);
  }

 private:
  void report(std::size_t offset);
  const InputFile& file_;
  std::size_t next_ = 0;
};

/// Throws `InputError` when `path` is a folder, or has no folder to be in.
void check_place(const std::filesystem::path& path);

/// The extension with its dot, `.PNG` as `.png`.
std::string lower_case_extension(const std::filesystem::path& path);

/// A piece of a file for a one-line message: in quotes, control characters replaced, cut where it gets long.
std::string in_quotes(std::string_view text);

/// Throws when a list of `size` elements can't be numbered by `Index`.
void check_countable(const InputFile& file, std::size_t size, std::string_view elements);

/// `value` as a position in a list of `size` elements, or `size` when it isn't one.
inline std::size_t index_or_size(double value, std::size_t size) {
  if (!(value >= 0.0 && value < static_cast<double>(size))) return size;
  const auto index = static_cast<std::size_t>(value);
  return static_cast<double>(index) == value ? index : size;
}

/// Copies attributes of vertices to the corners of faces.
template <class Attribute>
std::vector<Attribute> at_corners(const std::vector<Attribute>& of_vertices,
                                  const std::vector<Index>& corner_vertices) {
  std::vector<Attribute> of_corners;
  of_corners.reserve(corner_vertices.size());
  for (const Index vertex : corner_vertices) of_corners.push_back(of_vertices[vertex]);
  return of_corners;
}

/// A file about to be written, and what it leaves out.
struct OutputFile {
  std::string content;
  std::vector<std::pair<std::filesystem::path, std::string>> beside;  ///< further files, to be written first
  std::vector<std::string> written_without;
};

/// What a format can hold beside positions and triangles.
struct FormatAbility {
  bool polygons = true;
  bool isolated_vertices = true;
  bool corner_uvs = true;
  bool corner_normals = true;
  bool vertex_colors = true;
  bool vertex_scalars = false;
  bool materials = true;
  bool feature_edges = true;
};

/// One phrase for each thing that `soup` has and the format can't hold.
std::vector<std::string> left_out(const PolygonSoup& soup, const FormatAbility& ability);

/// The same for glTF.
std::vector<std::string> left_out_of_gltf(const PolygonSoup& soup);

/// The materials of a file at `path`, whose format holds no pictures, with textures that are found from
/// there: pictures that aren't there go beside the file, under the last part of their names, and behind the
/// file's own name where another file has that.
std::vector<Material> with_pictures_beside(const std::filesystem::path& path, std::vector<Material> materials,
                                           OutputFile& output);

/// `value` as the float that a 32-bit file holds. Throws `InputError` when it exceeds the range of floats.
float to_float(double value);

/// `value` rounded to a 32-bit float. Not inline: g++ 12 drops the pair of conversions when it vectorises
/// `vector.cast<float>().cast<double>()`.
double rounded_to_float(double value);

/// True when some position loses digits as a float.
bool loses_digits_as_float(const PolygonSoup& soup);
inline constexpr std::string_view k_rounded_positions =
    "double precision (positions rounded to 32-bit floats)";

/// Formats whose faces can be read a piece at a time: how many there are, nothing for a file of text, which
/// can't; and the pieces, each over the vertices that it uses. See `read_soup_in_pieces`.
using TakePiece = std::function<void(PolygonSoup)>;
std::optional<std::size_t> ply_faces_in_pieces(const InputFile& file);
std::optional<std::size_t> stl_faces_in_pieces(const InputFile& file);
void read_ply_pieces(const InputFile& file, std::size_t most_faces, const TakePiece& take);
void read_stl_pieces(const InputFile& file, std::size_t most_faces, const TakePiece& take);

PolygonSoup read_obj(const InputFile& file);
PolygonSoup read_ply(const InputFile& file);
/// The same, and the normals of vertices, of which a soup has only those at corners. Empty: none.
PolygonSoup read_ply(const InputFile& file, std::vector<Vec3>& vertex_normals);
PolygonSoup read_stl(const InputFile& file);
PolygonSoup read_off(const InputFile& file);
PolygonSoup read_gltf(const InputFile& file);

OutputFile format_obj(const std::filesystem::path& path, const PolygonSoup& soup,
                      const WriteOptions& options);
OutputFile format_ply(const std::filesystem::path& path, const PolygonSoup& soup,
                      const WriteOptions& options);
OutputFile format_stl(const std::filesystem::path& path, const PolygonSoup& soup,
                      const WriteOptions& options);
OutputFile format_off(const std::filesystem::path& path, const PolygonSoup& soup,
                      const WriteOptions& options);
OutputFile format_gltf(const std::filesystem::path& path, const PolygonSoup& soup,
                       const WriteOptions& options);
OutputFile format_glb(const std::filesystem::path& path, const PolygonSoup& soup,
                      const WriteOptions& options);

}  // namespace recede::detail
