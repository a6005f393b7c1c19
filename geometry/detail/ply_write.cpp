// PLY with everything that a soup holds, in text or little-endian binary.
#include <recede/geometry/detail/ply_header.h>
#include <recede/geometry/detail/text_writer.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace recede::detail {

namespace {

static_assert(std::endian::native == std::endian::little, "binary files are written as memory has them");

class AsciiSink {
 public:
  explicit AsciiSink(TextWriter& out) : out_(out) {}
  template <class Value>
  void put(Value value) {
    if (!first_) out_ << ' ';
    first_ = false;
    out_ << value;
  }
  void end_element() {
    out_ << '\n';
    first_ = true;
  }

 private:
  TextWriter& out_;
  bool first_ = true;
};

class BinarySink {
 public:
  explicit BinarySink(TextWriter& out) : out_(out) {}
  template <class Value>
  void put(Value value) {
    std::array<char, sizeof(Value)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(Value));
    out_ << std::string_view(bytes.data(), bytes.size());
  }
  void end_element() {}

 private:
  TextWriter& out_;
};

// The types of the file: the smallest that hold the soup.
struct Layout {
  bool double_reals = true;   // positions, normals, texture coordinates, and colours that aren't whole 255ths
  bool byte_colors = false;   // every component is a whole 255th, as most programs expect it
  bool wide_counts = false;   // some list is longer than 255
  bool wide_indices = false;  // some vertex index exceeds 2^31
};

bool are_255ths(const std::vector<Vec4>& colors) {
  return std::all_of(colors.begin(), colors.end(), [](const Vec4& color) {
    return std::all_of(color.begin(), color.end(),
                       [](double c) { return c >= 0.0 && c <= 1.0 && std::round(c * 255.0) / 255.0 == c; });
  });
}

Layout layout_of(const PolygonSoup& soup, const WriteOptions& options) {
  std::size_t largest = 0;
  for (std::size_t face = 0; face < soup.n_faces(); ++face) largest = std::max(largest, soup.face_size(face));
  const std::size_t values = !soup.corner_normals.empty() ? 3 : !soup.corner_uvs.empty() ? 2 : 1;
  return {options.ascii || options.double_precision, are_255ths(soup.vertex_colors), values * largest > 255,
          soup.positions.size() > (std::size_t{1} << 31)};
}

void write_header(TextWriter& out, const PolygonSoup& soup, const std::vector<Material>& materials,
                  const Layout& layout, bool ascii) {
  const std::string_view real = layout.double_reals ? "double" : "float";
  const std::string_view color = layout.byte_colors ? "uchar" : real;
  const std::string_view count = layout.wide_counts ? "uint" : "uchar";
  const std::string_view index = layout.wide_indices ? "uint" : "int";
  const auto properties = [&out](std::string_view type, std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names) out << "property " << type << ' ' << name << '\n';
  };
  const auto list = [&](std::string_view type, std::string_view name) {
    out << "property list " << count << ' ' << type << ' ' << name << '\n';
  };
  out << "ply\nformat " << (ascii ? "ascii" : "binary_little_endian") << " 1.0\ncomment Written by Recede\n";
  for (std::size_t i = 0; i < materials.size(); ++i)
    out << "comment " << format_material_comment(i, materials[i]) << '\n';
  out << "element vertex " << soup.positions.size() << '\n';
  properties(real, {"x", "y", "z"});
  if (!soup.vertex_colors.empty()) properties(color, {"red", "green", "blue", "alpha"});
  for (const VertexScalar& scalar : soup.vertex_scalars) properties(real, {scalar.name});
  out << "element face " << soup.n_faces() << '\n';
  list(index, "vertex_indices");
  if (!soup.corner_uvs.empty()) list(real, "texcoord");
  if (!soup.corner_normals.empty()) list(real, "corner_normals");
  if (!soup.face_materials.empty()) properties("int", {"material_index"});
  if (!soup.feature_edges.empty()) {
    out << "element edge " << soup.feature_edges.size() << '\n';
    properties(index, {"vertex1", "vertex2"});
  }
  out << "end_header\n";
}

/// A name that reads back as that of a scalar: one word with another meaning to none.
bool is_scalar_name(const std::string& name) {
  return !has_own_meaning(name) &&
         std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c <= '~'; });
}

/// Takes the scalars out that PLY can't name. Returns a phrase for each.
std::vector<std::string> leave_out_unnameable_scalars(PolygonSoup& soup) {
  std::vector<std::string> left_out;
  std::erase_if(soup.vertex_scalars, [&](const VertexScalar& scalar) {
    if (is_scalar_name(scalar.name)) return false;
    left_out.push_back("the scalar " + in_quotes(scalar.name) + " of the vertices (PLY has no such name)");
    return true;
  });
  return left_out;
}

template <class Sink>
class BodyWriter {
 public:
  BodyWriter(TextWriter& out, const Layout& layout) : sink_(out), layout_(layout) {}

  void write(const PolygonSoup& soup) {
    for (std::size_t vertex = 0; vertex < soup.positions.size(); ++vertex) {
      put_reals(soup.positions[vertex]);
      if (!soup.vertex_colors.empty()) put_color(soup.vertex_colors[vertex]);
      for (const VertexScalar& scalar : soup.vertex_scalars) put_real(scalar.values[vertex]);
      sink_.end_element();
    }
    for (std::size_t face = 0; face < soup.n_faces(); ++face) write_face(soup, face);
    for (const auto& [from, to] : soup.feature_edges) {
      put_index(from);
      put_index(to);
      sink_.end_element();
    }
  }

 private:
  void write_face(const PolygonSoup& soup, std::size_t face) {
    const Index first = soup.face_offsets[face];
    const Index last = soup.face_offsets[face + 1];
    put_count(last - first);
    for (Index corner = first; corner < last; ++corner) put_index(soup.corner_vertices[corner]);
    if (!soup.corner_uvs.empty()) {
      put_count(2 * (last - first));
      for (Index corner = first; corner < last; ++corner) put_reals(soup.corner_uvs[corner]);
    }
    if (!soup.corner_normals.empty()) {
      put_count(3 * (last - first));
      for (Index corner = first; corner < last; ++corner) put_reals(soup.corner_normals[corner]);
    }
    // No material is -1, which is what `k_no_index` gives as a signed number.
    if (!soup.face_materials.empty()) sink_.put(static_cast<std::int32_t>(soup.face_materials[face]));
    sink_.end_element();
  }

  template <class Vector>
  void put_reals(const Vector& values) {
    for (const double value : values) put_real(value);
  }
  void put_real(double value) {
    if (layout_.double_reals) {
      sink_.put(value);
    } else {
      sink_.put(to_float(value));
    }
  }
  void put_color(const Vec4& color) {
    for (const double component : color) {
      if (layout_.byte_colors) {
        sink_.put(static_cast<std::uint8_t>(std::lround(component * 255.0)));
      } else {
        put_real(component);
      }
    }
  }
  void put_count(Index count) {
    if (layout_.wide_counts) {
      sink_.put(count);
    } else {
      sink_.put(static_cast<std::uint8_t>(count));
    }
  }
  void put_index(Index index) {
    if (layout_.wide_indices) {
      sink_.put(index);
    } else {
      sink_.put(static_cast<std::int32_t>(index));
    }
  }

  Sink sink_;
  Layout layout_;
};

}  // namespace

OutputFile format_ply(const std::filesystem::path& path, const PolygonSoup& soup,
                      const WriteOptions& options) {
  const bool nameable = std::all_of(soup.vertex_scalars.begin(), soup.vertex_scalars.end(),
                                    [](const VertexScalar& scalar) { return is_scalar_name(scalar.name); });
  if (!nameable) {
    PolygonSoup rest = soup;
    const std::vector<std::string> left_out = leave_out_unnameable_scalars(rest);
    OutputFile output = format_ply(path, rest, options);
    output.written_without.insert(output.written_without.end(), left_out.begin(), left_out.end());
    return output;
  }
  const Layout layout = layout_of(soup, options);
  OutputFile output;
  TextWriter out;
  write_header(out, soup, with_pictures_beside(path, soup.materials, output), layout, options.ascii);
  if (options.ascii) {
    BodyWriter<AsciiSink>(out, layout).write(soup);
  } else {
    BodyWriter<BinarySink>(out, layout).write(soup);
  }
  output.content = out.take();
  if (!layout.double_reals && loses_digits_as_float(soup))
    output.written_without.emplace_back(k_rounded_positions);
  return output;
}

}  // namespace recede::detail
