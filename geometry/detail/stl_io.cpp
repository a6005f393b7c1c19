// STL, binary and text. Every facet has corners of its own: which of them are one vertex is for
// `merge_identical_vertices` to say. Facet normals only repeat what the corners tell, and aren't kept.
#include <recede/geometry/detail/text_scanner.h>
#include <recede/geometry/detail/text_writer.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>

namespace recede::detail {

namespace {

constexpr std::size_t k_header_size = 84;  // 80 bytes of anything, and the number of facets
constexpr std::size_t k_facet_size = 50;   // normal and three corners of floats, and two spare bytes

std::uint32_t promised_facets(std::string_view content) {
  std::uint32_t n = 0;
  std::memcpy(&n, content.data() + 80, sizeof n);
  return n;
}

// Binary files may start with "solid", too. Their size tells them apart, or, when they are cut, bytes that no
// text has.
bool is_text(std::string_view content) {
  const bool has_header = content.size() >= k_header_size;
  if (has_header && content.size() == k_header_size + k_facet_size * promised_facets(content)) return false;
  const std::size_t first = content.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return false;
  std::string word(content.substr(first, 5));
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return word == "solid" && content.substr(0, 512).find('\0') == content.npos;
}

void add_facet(const InputFile& file, PolygonSoup& soup, std::size_t first_vertex) {
  check_countable(file, soup.positions.size(), "vertices");
  for (std::size_t v = first_vertex; v < soup.positions.size(); ++v)
    soup.corner_vertices.push_back(static_cast<Index>(v));
  soup.face_offsets.push_back(static_cast<Index>(soup.n_corners()));
}

/// The number of facets of a binary file, all of which it holds.
std::size_t count_facets(const InputFile& file) {
  const std::string_view content = file.content;
  if (content.size() < k_header_size) {
    file.fail_at_byte(content.size(), "the file ends inside the header of a binary STL file");
  }
  const std::size_t n = promised_facets(content);
  const std::size_t held = (content.size() - k_header_size) / k_facet_size;
  if (n > held) {
    file.fail_at_byte(content.size(),
                      fmt::format("the header promises {} facets, but the file ends after {}", n, held));
  }
  return n;
}

PolygonSoup read_facets(const InputFile& file, std::size_t first, std::size_t last, ReadProgress& progress) {
  PolygonSoup soup;
  soup.positions.reserve(3 * (last - first));
  soup.corner_vertices.reserve(3 * (last - first));
  soup.face_offsets.reserve(last - first + 1);
  for (std::size_t facet = first; facet < last; ++facet) {
    const std::size_t offset = k_header_size + k_facet_size * facet;
    progress.at(offset);
    std::array<float, 9> values;
    std::memcpy(values.data(), file.content.data() + offset + 3 * sizeof(float), sizeof values);
    for (std::size_t i = 0; i < 9; i += 3) {
      soup.positions.push_back(Eigen::Vector3f(values[i], values[i + 1], values[i + 2]).cast<double>());
    }
    add_facet(file, soup, 3 * (facet - first));
  }
  return soup;
}

class StlTextReader {
 public:
  explicit StlTextReader(const InputFile& file) : file_(file), scanner_(file) {}

  PolygonSoup read() {
    ReadProgress progress(file_);
    bool inside = false;
    for (;;) {
      progress.at(scanner_.offset());
      const std::string word = next_word();
      if (word == "solid" && !inside) {
        inside = true;
        scanner_.next_line();
      } else if (word == "facet" && inside) {
        read_facet();
      } else if (word == "endsolid" && inside) {
        inside = false;
        scanner_.next_line();
      } else if (word.empty() && !inside) {
        return std::move(soup_);
      } else {
        fail_unexpected(word, inside ? "facet or endsolid" : "solid");
      }
    }
  }

 private:
  std::string next_word() {
    scanner_.skip_space(false);
    std::string word(scanner_.word());
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return word;
  }

  [[noreturn]] void fail_unexpected(std::string_view word, std::string_view expected) const {
    if (word.empty()) scanner_.fail(fmt::format("the file ends where {} should stand", expected));
    scanner_.fail(fmt::format("{} where {} should stand", in_quotes(word), expected));
  }

  void expect(std::string_view expected) {
    const std::string word = next_word();
    if (word != expected) fail_unexpected(word, expected);
  }

  Vec3 read_vector() {
    Vec3 vector;
    for (double& coordinate : vector) {
      scanner_.skip_space(false);
      coordinate = scanner_.number();
    }
    return vector;
  }

  void read_facet() {
    expect("normal");
    // The normal isn't needed, and often it is no number either ("-nan(ind)").
    for (int i = 0; i < 3; ++i) next_word();
    expect("outer");
    expect("loop");
    const std::size_t first = soup_.positions.size();
    std::string word = next_word();
    for (; word == "vertex"; word = next_word()) {
      soup_.positions.push_back(read_vector());
      if (soup_.positions.back().allFinite()) continue;
      scanner_.fail(fmt::format("the position of vertex {} isn't finite", soup_.positions.size() - 1));
    }
    if (word != "endloop") fail_unexpected(word, "vertex or endloop");
    if (soup_.positions.size() - first < 3) {
      scanner_.fail(fmt::format("facet with {} corners", soup_.positions.size() - first));
    }
    expect("endfacet");
    add_facet(file_, soup_, first);
  }

  const InputFile& file_;
  TextScanner scanner_;
  PolygonSoup soup_;
};

struct Facet {
  std::array<Vec3, 3> corners;
  Vec3 normal;  // unit length, or zero
};

Facet facet_of(const PolygonSoup& soup, const std::vector<Index>& triangles, std::size_t triangle) {
  Facet facet;
  for (std::size_t i = 0; i < 3; ++i) facet.corners[i] = soup.positions[triangles[3 * triangle + i]];
  facet.normal = (facet.corners[1] - facet.corners[0]).cross(facet.corners[2] - facet.corners[0]);
  const double length = facet.normal.stableNorm();
  facet.normal = length > 0.0 && std::isfinite(length) ? Vec3(facet.normal / length) : Vec3::Zero();
  return facet;
}

std::string format_binary(const PolygonSoup& soup, const std::vector<Index>& triangles) {
  std::string out = "Recede binary STL";  // must not start with "solid"
  out.resize(80, ' ');
  const std::size_t n = triangles.size() / 3;
  const auto n_facets = static_cast<std::uint32_t>(n);
  out.reserve(k_header_size + k_facet_size * n);
  out.append(reinterpret_cast<const char*>(&n_facets), sizeof n_facets);
  const auto put = [&out](const Vec3& vector) {
    for (const double coordinate : vector) {
      const float value = to_float(coordinate);
      out.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  };
  for (std::size_t t = 0; t < n; ++t) {
    const Facet facet = facet_of(soup, triangles, t);
    put(facet.normal);
    for (const Vec3& corner : facet.corners) put(corner);
    out.append(2, '\0');
  }
  return out;
}

std::string format_text(const PolygonSoup& soup, const std::vector<Index>& triangles) {
  TextWriter out;
  out << "solid recede\n";
  for (std::size_t t = 0; t < triangles.size() / 3; ++t) {
    const Facet facet = facet_of(soup, triangles, t);
    (out << "facet normal ").list(facet.normal) << "\nouter loop\n";
    for (const Vec3& corner : facet.corners) (out << "vertex ").list(corner) << '\n';
    out << "endloop\nendfacet\n";
  }
  out << "endsolid recede\n";
  return out.take();
}

}  // namespace

PolygonSoup read_stl(const InputFile& file) {
  if (is_text(file.content)) return StlTextReader(file).read();
  ReadProgress progress(file);
  return read_facets(file, 0, count_facets(file), progress);
}

std::optional<std::size_t> stl_faces_in_pieces(const InputFile& file) {
  if (is_text(file.content)) return {};
  return count_facets(file);
}

void read_stl_pieces(const InputFile& file, std::size_t most_faces, const TakePiece& take) {
  ReadProgress progress(file);
  const std::size_t n = count_facets(file);
  for (std::size_t first = 0; first < n; first += most_faces) {
    PolygonSoup piece = read_facets(file, first, std::min(n, first + most_faces), progress);
    for (std::size_t v = 0; v < piece.positions.size(); ++v) {
      if (piece.positions[v].allFinite()) continue;
      file.fail_at_byte(k_header_size + k_facet_size * (first + v / 3),
                        fmt::format("the position of vertex {} isn't finite", 3 * first + v));
    }
    take(std::move(piece));
  }
}

OutputFile format_stl(const std::filesystem::path&, const PolygonSoup& soup, const WriteOptions& options) {
  const std::vector<Index> triangles = triangulate(soup);
  OutputFile output;
  output.content = options.ascii ? format_text(soup, triangles) : format_binary(soup, triangles);
  output.written_without = left_out(soup, {.polygons = false,
                                           .isolated_vertices = false,
                                           .corner_uvs = false,
                                           .corner_normals = false,
                                           .vertex_colors = false,
                                           .materials = false,
                                           .feature_edges = false});
  output.written_without.emplace_back("shared vertices (every triangle repeats its corners)");
  if (!options.ascii && loses_digits_as_float(soup)) output.written_without.emplace_back(k_rounded_positions);
  return output;
}

}  // namespace recede::detail
