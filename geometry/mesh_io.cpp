#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/cad_format.h>
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/detail/mapped_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/texture.h>

#include <fmt/format.h>

#include <array>
#include <new>

namespace recede {

namespace fs = std::filesystem;

namespace {

struct Format {
  std::string_view extension;
  PolygonSoup (*read)(const detail::InputFile&);
  detail::OutputFile (*write)(const fs::path&, const PolygonSoup&, const WriteOptions&);
};

constexpr std::array<Format, 6> k_formats{{{".obj", detail::read_obj, detail::format_obj},
                                           {".ply", detail::read_ply, detail::format_ply},
                                           {".stl", detail::read_stl, detail::format_stl},
                                           {".off", detail::read_off, detail::format_off},
                                           {".gltf", detail::read_gltf, detail::format_gltf},
                                           {".glb", detail::read_gltf, detail::format_glb}}};

const Format& format_of(const fs::path& path) {
  const std::string extension = detail::lower_case_extension(path);
  for (const Format& format : k_formats) {
    if (format.extension == extension) return format;
  }
  if (detail::cad_format_of(path))
    throw InputError::in_file(path.string(), "a CAD file isn't a mesh; `recede bake` makes triangles of it");
  throw InputError::in_file(path.string(),
                            "unknown kind of mesh file; known are .obj .ply .stl .off .gltf .glb");
}

// A normal that isn't a number is no normal: exporters write such ones for triangles without area.
void clear_undefined_normals(PolygonSoup& soup) {
  for (Vec3& normal : soup.corner_normals) {
    if (!normal.allFinite()) normal.setZero();
  }
}

PolygonSoup read_checked(const Format& format, const fs::path& path, Progress* progress,
                         std::vector<std::string>* left_aside) {
  PolygonSoup soup;
  {
    // The text goes as soon as it is read: it may be as large as the mesh.
    const std::string content = read_whole_file(path);
    soup = format.read({path, path.string(), content, progress, left_aside});
  }
  if (soup.positions.empty()) throw InputError::in_file(path.string(), "holds no vertices");
  clear_undefined_normals(soup);
  validate(soup, path.string());
  report_progress(progress, "read", 1.0);
  return soup;
}

PolygonSoup read_in_memory(const fs::path& path, Progress* progress, std::vector<std::string>* left_aside) {
  const Format& format = format_of(path);
  try {
    return read_checked(format, path, progress, left_aside);
  } catch (const std::bad_alloc&) {
    throw InputError::in_file(path.string(), "doesn't fit in memory");
  }
}

}  // namespace

void check_mesh_path(const fs::path& path) {
  format_of(path);
  detail::check_place(path);
}

PolygonSoup read_soup(const fs::path& path, Progress* progress) {
  return read_in_memory(path, progress, nullptr);
}

ReadSoup read_soup_with_pictures(const fs::path& path, Progress* progress) {
  std::vector<std::string> left_aside;
  ReadSoup read{read_in_memory(path, progress, &left_aside), {}};
  if (!left_aside.empty()) {
    read.report.steps.push_back(
        {"read_soup", left_aside.size(), fmt::format("leaves {} aside", fmt::join(left_aside, ", "))});
  }
  PictureLoader pictures(path.parent_path());
  pictures.load(read.soup.materials);
  read.report.steps.push_back(pictures.step());
  return read;
}

std::optional<std::size_t> faces_in_pieces(const fs::path& path) {
  const std::string_view extension = format_of(path).extension;
  if (extension != ".ply" && extension != ".stl") return {};
  const detail::MappedFile mapped(path);
  const detail::InputFile file{path, path.string(), mapped.bytes()};
  return extension == ".ply" ? detail::ply_faces_in_pieces(file) : detail::stl_faces_in_pieces(file);
}

void read_soup_in_pieces(const fs::path& path, std::size_t most_faces,
                         const std::function<void(PolygonSoup)>& take, Progress* progress) {
  if (most_faces == 0) throw OptionError("a piece needs at least one face");
  const detail::MappedFile mapped(path);
  const detail::InputFile file{path, path.string(), mapped.bytes(), progress};
  if (!faces_in_pieces(path)) file.fail("can't be read in pieces; binary PLY and binary STL can");
  const auto take_checked = [&](PolygonSoup piece) {
    clear_undefined_normals(piece);
    validate(piece, path.string());
    mapped.release();
    take(std::move(piece));
  };
  const bool is_ply = format_of(path).extension == ".ply";
  (is_ply ? detail::read_ply_pieces : detail::read_stl_pieces)(file, most_faces, take_checked);
  report_progress(progress, "read", 1.0);
}

MeshFromSoup read_mesh(const fs::path& path, Progress* progress) {
  ReadSoup read = read_soup_with_pictures(path, progress);
  MeshFromSoup repaired = repair_to_polygon_mesh(std::move(read.soup));
  std::vector<RepairStep>& steps = repaired.report.steps;
  steps.insert(steps.begin(), read.report.steps.begin(), read.report.steps.end());
  return repaired;
}

WriteResult write_soup(const fs::path& path, const PolygonSoup& soup, const WriteOptions& options) {
  const Format& format = format_of(path);
  validate(soup, path.string());
  detail::OutputFile output;
  try {
    output = format.write(path, soup, options);
  } catch (const InputError& error) {
    throw InputError::in_file(path.string(), error.what());
  }
  WriteResult result{output.content.size(), std::move(output.written_without)};
  for (const auto& [beside, content] : output.beside) {
    write_file_atomically(beside, content);
    result.bytes += content.size();
  }
  write_file_atomically(path, output.content);
  return result;
}

WriteResult write_mesh(const fs::path& path, const PolygonMesh& mesh, const WriteOptions& options) {
  return write_soup(path, to_soup(mesh), options);
}

}  // namespace recede
