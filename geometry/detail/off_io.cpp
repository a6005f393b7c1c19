// Geomview's OFF: [ST][C][N]OFF in text. Colours of faces are read past, they have no place in a soup.
#include <recede/geometry/detail/text_scanner.h>
#include <recede/geometry/detail/text_writer.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

namespace {

class OffReader {
 public:
  explicit OffReader(const InputFile& file) : file_(file), scanner_(file) {}

  PolygonSoup read() {
    read_header();
    ReadProgress progress(file_);
    for (std::size_t v = 0; v < n_vertices_; ++v) {
      progress.at(scanner_.offset());
      start_line("vertex", v);
      read_vertex();
      end_vertex_line();
    }
    for (std::size_t f = 0; f < n_faces_; ++f) {
      progress.at(scanner_.offset());
      start_line("face", f);
      read_face(f);
    }
    return finish();
  }

 private:
  void read_header() {
    scanner_.skip_space(true);
    // Some files have the counts right behind the keyword, without a blank.
    const std::string_view word = TextScanner(scanner_).word();
    const std::size_t found = word.find("OFF");
    const std::string_view prefix = word.substr(0, std::min(found, word.size()));
    if (found == word.npos) scanner_.fail("isn't an OFF file (it doesn't start with OFF)");
    for (std::size_t i = 0; i < found + 3; ++i) scanner_.take(word[i]);
    read_prefix(prefix);
    if (TextScanner(scanner_).word() == "BINARY")
      scanner_.fail("binary OFF isn't supported; write the file as text");
    scanner_.skip_space(true);
    n_vertices_ = scanner_.count("the number of vertices");
    n_faces_ = scanner_.count("the number of faces");
    scanner_.next_line();                     // the number of edges, which few programs fill in
    check_count("vertices", n_vertices_, 6);  // "0 0 0" and a line end
    check_count("faces", n_faces_, 8);        // "3 0 1 2" and a line end
  }

  void read_prefix(std::string_view prefix) {
    const std::string_view all = prefix;
    if (prefix.starts_with("ST")) {
      has_uvs_ = true;
      prefix.remove_prefix(2);
    }
    for (const char c : prefix) {
      if (c == '4' || c == 'n')
        scanner_.fail(fmt::format("{}OFF: vertices in other than three dimensions", all));
      if (c != 'C' && c != 'N') scanner_.fail("unknown kind of OFF file " + in_quotes(all));
      (c == 'C' ? has_colors_ : has_normals_) = true;
    }
  }

  void check_count(std::string_view what, std::size_t count, std::size_t least_size) const {
    const std::size_t most = (scanner_.remaining() + 1) / least_size;
    if (count <= most) return;
    scanner_.fail(
        fmt::format("the header promises {} {}, but the file has room for {} at most", count, what, most));
  }

  void start_line(std::string_view what, std::size_t index) {
    scanner_.skip_space(true);
    if (scanner_.at_end()) scanner_.fail(fmt::format("the file ends before {} {}", what, index));
  }

  template <class Vector>
  Vector read_vector() {
    Vector vector;
    for (double& component : vector) component = scanner_.number();
    return vector;
  }

  // x y z [nx ny nz] [r g b [a]] [s t]
  void read_vertex() {
    const Vec3 position = read_vector<Vec3>();
    if (!position.allFinite()) {
      scanner_.fail(fmt::format("the position of vertex {} isn't finite", soup_.positions.size()));
    }
    soup_.positions.push_back(position);
    if (has_normals_) normals_.push_back(read_vector<Vec3>());
    if (!has_colors_) {
      if (has_uvs_) uvs_.push_back(read_vector<Vec2>());
      return;
    }
    // The number of colour components isn't said anywhere but by the line's length.
    std::array<double, 6> values{};
    std::size_t n = 0;
    for (; n < values.size() && !scanner_.at_line_end(); ++n) values[n] = scanner_.number();
    const std::size_t n_color = n - std::min<std::size_t>(n, has_uvs_ ? 2 : 0);
    if (n_color != 3 && n_color != 4) scanner_.fail(fmt::format("colour with {} components", n_color));
    // An opacity that isn't given is opaque whatever the scale of the colours turns out to be.
    soup_.vertex_colors.emplace_back(values[0], values[1], values[2], n_color == 4 ? values[3] : -1.0);
    if (has_uvs_) uvs_.emplace_back(values[n_color], values[n_color + 1]);
  }

  void end_vertex_line() {
    if (scanner_.at_line_end()) return;
    scanner_.fail("more numbers for a vertex than the keyword OFF, COFF, NOFF... at the top announces");
  }

  void read_face(std::size_t face) {
    const std::size_t n = scanner_.count("the number of corners");
    if (n < 3) scanner_.fail(fmt::format("face {} has {} {}", face, n, n == 1 ? "corner" : "corners"));
    if (n > scanner_.remaining())
      scanner_.fail(fmt::format("face {} with {} corners runs past the end", face, n));
    for (std::size_t i = 0; i < n; ++i) {
      if (scanner_.at_line_end()) scanner_.fail(fmt::format("face {} has {} of its {} corners", face, i, n));
      const std::size_t vertex = scanner_.count("a corner");
      if (vertex >= n_vertices_) {
        scanner_.fail(fmt::format("vertex {} is out of range (there are {})", vertex, n_vertices_));
      }
      soup_.corner_vertices.push_back(static_cast<Index>(vertex));
    }
    check_countable(file_, soup_.n_corners(), "corners");
    soup_.face_offsets.push_back(static_cast<Index>(soup_.n_corners()));
    scanner_.next_line();
  }

  // Colours are whole numbers to 255 or fractions of 1; a file of zeros and ones means fractions.
  void scale_colors() {
    bool whole = true;
    double largest = 0.0;
    for (const Vec4& color : soup_.vertex_colors) {
      for (const double component : color) {
        whole = whole && component == std::floor(component);
        largest = std::max(largest, component);
      }
    }
    const double scale = whole && largest > 1.0 ? 255.0 : 1.0;
    for (Vec4& color : soup_.vertex_colors) {
      const bool has_opacity = color[3] >= 0.0;
      color /= scale;
      if (!has_opacity) color[3] = 1.0;
    }
  }

  PolygonSoup finish() {
    check_countable(file_, soup_.positions.size(), "vertices");
    scale_colors();
    if (has_uvs_) soup_.corner_uvs = at_corners(uvs_, soup_.corner_vertices);
    if (has_normals_) soup_.corner_normals = at_corners(normals_, soup_.corner_vertices);
    return std::move(soup_);
  }

  const InputFile& file_;
  TextScanner scanner_;
  PolygonSoup soup_;
  std::size_t n_vertices_ = 0;
  std::size_t n_faces_ = 0;
  bool has_colors_ = false;
  bool has_normals_ = false;
  bool has_uvs_ = false;
  std::vector<Vec2> uvs_;
  std::vector<Vec3> normals_;
};

}  // namespace

PolygonSoup read_off(const InputFile& file) { return OffReader(file).read(); }

OutputFile format_off(const std::filesystem::path&, const PolygonSoup& soup, const WriteOptions&) {
  TextWriter out;
  out << (soup.vertex_colors.empty() ? "OFF\n" : "COFF\n") << soup.positions.size() << ' ' << soup.n_faces()
      << " 0\n";
  for (std::size_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
    out.list(soup.positions[vertex]);
    if (!soup.vertex_colors.empty()) (out << ' ').list(soup.vertex_colors[vertex]);
    out << '\n';
  }
  for (std::size_t face = 0; face < soup.n_faces(); ++face) {
    out << soup.face_size(face);
    for (const Index vertex : soup.face(face)) out << ' ' << vertex;
    out << '\n';
  }
  OutputFile output;
  output.content = out.take();
  output.written_without = left_out(
      soup, {.corner_uvs = false, .corner_normals = false, .materials = false, .feature_edges = false});
  return output;
}

}  // namespace recede::detail
