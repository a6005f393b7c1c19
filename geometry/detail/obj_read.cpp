// Wavefront OBJ. Polygons, corner texture coordinates and normals, vertex colours, materials and polylines
// are read; groups and smoothing say nothing that Recede keeps; free-form surfaces are refused rather than
// dropped.
#include <recede/geometry/detail/mtl_io.h>
#include <recede/geometry/detail/text_scanner.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace recede::detail {

namespace {

// Statements that carry no geometry: grouping, display, and the surroundings of free-form elements, which are
// refused where the element itself stands.
constexpr std::array k_ignored_statements{
    "o",     "g",        "s",        "mg",         "p",         "vp",    "cstype", "deg",    "bmat",
    "step",  "parm",     "trim",     "hole",       "scrv",      "sp",    "end",    "con",    "lod",
    "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "ctech", "stech",  "usemap", "maplib"};
constexpr std::array k_free_form_statements{"curv", "curv2", "surf", "bsp", "bzp", "cdc", "cdp", "res"};

template <std::size_t n>
bool is_one_of(std::string_view word, const std::array<const char*, n>& list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

// What a corner can refer to: how many there are, and the furthest reference ahead of them so far.
struct Numbering {
  const char* what;
  std::size_t furthest = 0;
  std::size_t furthest_line = 0;
};

class ObjReader {
 public:
  explicit ObjReader(const InputFile& file) : file_(file), scanner_(file) {}

  PolygonSoup read() {
    reserve_lists();
    ReadProgress progress(file_);
    for (; !scanner_.at_end(); scanner_.next_line()) {
      progress.at(scanner_.offset());
      if (!scanner_.at_line_end()) read_statement(scanner_.word());
    }
    return finish();
  }

 private:
  // Counting lines costs a hundredth of reading them, and lists that grow cost a third.
  void reserve_lists() {
    const std::string_view text = file_.content;
    std::size_t n_vertices = 0, n_uvs = 0, n_normals = 0, n_faces = 0;
    for (std::size_t at = 0; at + 2 < text.size(); ++at) {
      if (text[at] == 'v') {
        ++(text[at + 1] == 't' ? n_uvs : text[at + 1] == 'n' ? n_normals : n_vertices);
      } else if (text[at] == 'f') {
        ++n_faces;
      }
      at = std::min(text.find('\n', at), text.size() - 1);
    }
    soup_.positions.reserve(n_vertices);
    uvs_.reserve(n_uvs);
    normals_.reserve(n_normals);
    soup_.face_offsets.reserve(n_faces + 1);
    soup_.corner_vertices.reserve(3 * n_faces);
    if (n_uvs > 0) corner_uvs_.reserve(3 * n_faces);
    if (n_normals > 0) corner_normals_.reserve(3 * n_faces);
  }

  void read_statement(std::string_view word) {
    if (word == "v") return read_vertex();
    if (word == "f" || word == "fo") return read_face();
    if (word == "vt") return read_uv();
    if (word == "vn") return read_normal();
    if (word == "l") return read_polyline();
    if (word == "usemtl") return use_material(scanner_.rest_of_line());
    if (word == "mtllib") return read_material_library(scanner_.rest_of_line());
    if (is_one_of(word, k_ignored_statements)) return;
    if (is_one_of(word, k_free_form_statements)) {
      scanner_.fail(fmt::format("free-form geometry ({}) isn't supported", word));
    }
    scanner_.fail("unknown statement " + in_quotes(word));
  }

  // x y z, x y z w, x y z r g b or x y z r g b a
  void read_vertex() {
    std::array<double, 7> value{};
    std::size_t n = 0;
    while (!scanner_.at_line_end()) {
      if (n == value.size()) scanner_.fail("vertex with more than 7 numbers");
      value[n++] = scanner_.number();
    }
    if (n < 3 || n == 5) scanner_.fail(fmt::format("vertex with {} {}", n, n == 1 ? "number" : "numbers"));
    const Vec3 position(value[0], value[1], value[2]);
    if (!position.allFinite()) {
      scanner_.fail(fmt::format("the position of vertex {} isn't finite", soup_.positions.size() + 1));
    }
    if (n >= 6 || !soup_.vertex_colors.empty()) {
      soup_.vertex_colors.resize(soup_.positions.size(), Vec4::Ones());
      if (n >= 6) {
        soup_.vertex_colors.emplace_back(value[3], value[4], value[5], n == 7 ? value[6] : 1.0);
      } else {
        soup_.vertex_colors.emplace_back(Vec4::Ones());
      }
    }
    soup_.positions.push_back(position);
  }

  void read_uv() {
    const double u = scanner_.number();
    uvs_.emplace_back(u, scanner_.at_line_end() ? 0.0 : scanner_.number());
  }

  void read_normal() {
    Vec3 normal;
    for (double& coordinate : normal) coordinate = scanner_.number();
    normals_.push_back(normal);
  }

  // A reference as a position in its list. Positive ones may point ahead; `finish` sees whether that gets
  // filled.
  Index read_reference(Numbering& numbering, std::size_t size) {
    std::int64_t value = 0;
    if (!scanner_.integer(value)) scanner_.fail("malformed reference " + in_quotes(scanner_.word()));
    if (value > 0 && value < std::int64_t{k_no_index}) {
      const auto number = static_cast<std::size_t>(value);
      if (number > size && number > numbering.furthest) {
        numbering.furthest = number;
        numbering.furthest_line = scanner_.line();
      }
      return static_cast<Index>(number - 1);
    }
    if (value >= 0 || value < -static_cast<std::int64_t>(size)) fail_reference(numbering, value, size);
    return static_cast<Index>(static_cast<std::int64_t>(size) + value);
  }

  [[noreturn]] void fail_reference(const Numbering& numbering, std::int64_t value, std::size_t size) const {
    scanner_.fail(fmt::format("{} {} is out of range (there are {})", numbering.what, value, size));
  }

  // v, v/vt, v//vn or v/vt/vn
  void read_corner() {
    const std::size_t corner = soup_.corner_vertices.size();
    soup_.corner_vertices.push_back(read_reference(vertices_, soup_.positions.size()));
    if (scanner_.take('/')) {
      if (!scanner_.at_word_end() && !next_is_slash())
        append(corner_uvs_, corner, read_reference(uv_numbers_, uvs_.size()));
      if (scanner_.take('/') && !scanner_.at_word_end()) {
        append(corner_normals_, corner, read_reference(normal_numbers_, normals_.size()));
      }
    }
    if (!scanner_.at_word_end())
      scanner_.fail("malformed reference: unexpected " + in_quotes(scanner_.word()));
  }

  bool next_is_slash() const { return TextScanner(scanner_).take('/'); }

  // Corners before the first that has the attribute get none.
  static void append(std::vector<Index>& list, std::size_t corner, Index value) {
    list.resize(corner, k_no_index);
    list.push_back(value);
  }

  void read_face() {
    const std::size_t first = soup_.corner_vertices.size();
    while (!scanner_.at_line_end()) read_corner();
    const std::size_t n = soup_.corner_vertices.size() - first;
    if (n < 3) scanner_.fail(fmt::format("face with {} {}", n, n == 1 ? "corner" : "corners"));
    check_countable(file_, soup_.corner_vertices.size(), "corners");
    soup_.face_offsets.push_back(static_cast<Index>(soup_.corner_vertices.size()));
    if (!soup_.materials.empty()) {
      soup_.face_materials.resize(soup_.n_faces() - 1, k_no_index);
      soup_.face_materials.push_back(material_);
    }
  }

  void read_polyline() {
    Index previous = k_no_index;
    std::size_t n = 0;
    for (; !scanner_.at_line_end(); ++n) {
      const Index vertex = read_reference(vertices_, soup_.positions.size());
      if (scanner_.take('/') && !scanner_.at_word_end()) read_reference(uv_numbers_, uvs_.size());
      if (!scanner_.at_word_end())
        scanner_.fail("malformed reference: unexpected " + in_quotes(scanner_.word()));
      if (n > 0 && vertex != previous) soup_.feature_edges.emplace_back(previous, vertex);
      previous = vertex;
    }
    if (n < 2) scanner_.fail(fmt::format("polyline with {} {}", n, n == 1 ? "vertex" : "vertices"));
  }

  // "(null)" and an empty name end the use of a material; Recede and others write the former.
  void use_material(std::string_view name) {
    material_ = k_no_index;
    if (name.empty() || name == "(null)") return;
    const auto [found, inserted] =
        material_numbers_.try_emplace(std::string(name), static_cast<Index>(soup_.materials.size()));
    material_ = found->second;
    if (!inserted) return;
    soup_.materials.emplace_back();
    soup_.materials.back().name = name;
  }

  // One file name with blanks, or several names. A file that isn't there leaves materials with their names
  // only.
  void read_material_library(std::string_view names) {
    if (read_library_file(names)) return;
    while (!names.empty()) {
      const std::size_t blank = std::min(names.find_first_of(" \t"), names.size());
      read_library_file(names.substr(0, blank));
      names.remove_prefix(std::min(blank + 1, names.size()));
    }
  }

  bool read_library_file(std::string_view name) {
    std::string slashed(name);
    std::replace(slashed.begin(), slashed.end(), '\\', '/');
    const std::filesystem::path path = file_.path.parent_path() / slashed;
    std::error_code ignored;
    if (name.find('\0') != name.npos || !std::filesystem::is_regular_file(path, ignored)) return false;
    for (Material& material : read_mtl(path)) library_.try_emplace(material.name, material);
    return true;
  }

  void check_furthest(const Numbering& numbering, std::size_t size) const {
    if (numbering.furthest <= size) return;
    file_.fail_at_line(numbering.furthest_line, fmt::format("{} {} is out of range (there are {})",
                                                            numbering.what, numbering.furthest, size));
  }

  template <class Attribute>
  static std::vector<Attribute> resolve(std::vector<Index>& corners, std::size_t n_corners,
                                        const std::vector<Attribute>& values) {
    std::vector<Attribute> result;
    if (corners.empty()) return result;
    corners.resize(n_corners, k_no_index);
    result.reserve(n_corners);
    for (const Index index : corners) {
      result.push_back(index == k_no_index ? Attribute(Attribute::Zero()) : values[index]);
    }
    return result;
  }

  PolygonSoup finish() {
    check_countable(file_, soup_.positions.size(), "vertices");
    check_furthest(vertices_, soup_.positions.size());
    check_furthest(uv_numbers_, uvs_.size());
    check_furthest(normal_numbers_, normals_.size());
    soup_.corner_uvs = resolve(corner_uvs_, soup_.n_corners(), uvs_);
    soup_.corner_normals = resolve(corner_normals_, soup_.n_corners(), normals_);
    for (Material& material : soup_.materials) {
      const auto found = library_.find(material.name);
      if (found != library_.end()) material = found->second;
    }
    if (!soup_.materials.empty()) soup_.face_materials.resize(soup_.n_faces(), k_no_index);
    return std::move(soup_);
  }

  const InputFile& file_;
  TextScanner scanner_;
  PolygonSoup soup_;
  std::vector<Vec2> uvs_;
  std::vector<Vec3> normals_;
  std::vector<Index> corner_uvs_;      // positions in uvs_; empty as long as no corner has one
  std::vector<Index> corner_normals_;  // positions in normals_, likewise
  Numbering vertices_{"vertex"};
  Numbering uv_numbers_{"texture coordinate"};
  Numbering normal_numbers_{"normal"};
  Index material_ = k_no_index;
  std::unordered_map<std::string, Index> material_numbers_;
  std::unordered_map<std::string, Material> library_;
};

}  // namespace

PolygonSoup read_obj(const InputFile& file) { return ObjReader(file).read(); }

}  // namespace recede::detail
