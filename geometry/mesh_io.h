// Meshes in and out: OBJ, PLY, STL, OFF, glTF and GLB, chosen by the file name's extension.
#pragma once

#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/progress.h>

#include <filesystem>
#include <functional>
#include <optional>

namespace recede {

/// What a file holds, nothing merged or dropped. Texture coordinates have v up, as in OBJ and PLY; glTF's are
/// turned. Per-vertex texture coordinates and normals of formats without corner attributes are copied to the
/// corners. Throws `InputError` with line or byte.
PolygonSoup read_soup(const std::filesystem::path& path, Progress* progress = nullptr);

struct ReadSoup {
  PolygonSoup soup;
  RepairReport report;
};

/// `read_soup` and the pictures that materials name (`PictureLoader`). The report says which of them can't be
/// read, and what else the file holds that a soup has no place for.
ReadSoup read_soup_with_pictures(const std::filesystem::path& path, Progress* progress = nullptr);

/// Files that are larger than memory are read a piece at a time: binary PLY and binary STL. How many faces
/// there will be, as the header promises; nothing for other files, which only `read_soup` reads. Throws
/// `InputError`.
std::optional<std::size_t> faces_in_pieces(const std::filesystem::path& path);

/// Calls `take` with the file's faces in turn, `most_faces` or fewer at once over the vertices that they use,
/// as `read_soup` gives them; vertices without faces aren't met. Memory is needed for a piece, not for the
/// file, which must not change meanwhile. Throws `OptionError` for pieces without faces, `InputError` also
/// for files that can't be read like this: those of which `faces_in_pieces` says nothing, and PLY in which
/// anything stands before the vertices or between them and the faces, or with feature edges.
void read_soup_in_pieces(const std::filesystem::path& path, std::size_t most_faces,
                         const std::function<void(PolygonSoup)>& take, Progress* progress = nullptr);

/// `read_soup_with_pictures`, then `repair_to_polygon_mesh`; the report says what each step changed.
MeshFromSoup read_mesh(const std::filesystem::path& path, Progress* progress = nullptr);

/// How a mesh is written. Formats that can't hold something (n-gons in STL and glTF, names in STL) write what
/// they can and `written_without` says in words what is missing.
struct WriteResult {
  std::uintmax_t bytes = 0;
  std::vector<std::string> written_without;
};

struct WriteOptions {
  bool ascii = false;            ///< PLY and STL: text instead of little-endian binary
  bool double_precision = true;  ///< binary PLY: 8-byte positions
};

/// Throws `InputError` when `path` can't become a mesh file: unknown extension, a folder of that name, or no
/// folder to be in. For programs that work long before they write.
void check_mesh_path(const std::filesystem::path& path);

/// Writes beside the target and renames, so that no half-written file is ever seen.
WriteResult write_soup(const std::filesystem::path& path, const PolygonSoup& soup,
                       const WriteOptions& options = {});
WriteResult write_mesh(const std::filesystem::path& path, const PolygonMesh& mesh,
                       const WriteOptions& options = {});

}  // namespace recede
