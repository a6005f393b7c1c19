// PLY in all three encodings. Known properties of vertices, faces and edges are read whatever their types;
// other single numbers of vertices are named scalars, and the rest is skipped, which for lists means reading
// their counts.
#include <recede/geometry/detail/ply_header.h>
#include <recede/geometry/detail/text_scanner.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace recede::detail {

namespace {

// Both sources give all values as doubles, which hold every type of PLY exactly.
class AsciiSource {
 public:
  AsciiSource(const InputFile& file, const PlyHeader& header)
      : scanner_(file, header.body_offset, header.body_line) {}

  double next(PlyType) {
    scanner_.skip_space(false);
    if (scanner_.at_end()) scanner_.fail("the file ends too early");
    return scanner_.number();
  }
  void skip(std::size_t count, PlyType type) {
    for (std::size_t i = 0; i < count; ++i) next(type);
  }
  // A digit, and a blank before the next one.
  static std::size_t least_size(PlyType) { return 2; }
  std::size_t remaining() const { return scanner_.remaining() + 1; }
  std::size_t offset() const { return scanner_.offset(); }
  [[noreturn]] void fail(const std::string& reason) const { scanner_.fail(reason); }

 private:
  TextScanner scanner_;
};

template <bool swapped>
class BinarySource {
 public:
  BinarySource(const InputFile& file, const PlyHeader& header)
      : file_(file), at_(file.content.data() + header.body_offset) {}

  double next(PlyType type) {
    if (remaining() < ply_type_size(type)) fail("the file ends too early");
    switch (type) {
      case PlyType::int8:
        return take<std::int8_t>();
      case PlyType::uint8:
        return take<std::uint8_t>();
      case PlyType::int16:
        return take<std::int16_t>();
      case PlyType::uint16:
        return take<std::uint16_t>();
      case PlyType::int32:
        return take<std::int32_t>();
      case PlyType::uint32:
        return take<std::uint32_t>();
      case PlyType::float32:
        return static_cast<double>(take<float>());
      case PlyType::float64:
        return take<double>();
    }
    return 0.0;
  }
  void skip(std::size_t count, PlyType type) {
    if (count > remaining() / ply_type_size(type)) fail("the file ends too early");
    at_ += count * ply_type_size(type);
  }
  static std::size_t least_size(PlyType type) { return ply_type_size(type); }
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }
  std::size_t offset() const { return static_cast<std::size_t>(at_ - file_.content.data()); }
  /// `offset` must lie in the file.
  void seek(std::size_t offset) { at_ = file_.content.data() + offset; }
  [[noreturn]] void fail(const std::string& reason) const { file_.fail_at_byte(offset(), reason); }

 private:
  template <class Value>
  Value take() {
    std::array<char, sizeof(Value)> bytes;
    std::memcpy(bytes.data(), at_, sizeof(Value));
    at_ += sizeof(Value);
    if constexpr (swapped) std::reverse(bytes.begin(), bytes.end());
    return std::bit_cast<Value>(bytes);
  }

  const InputFile& file_;
  const char* at_;
  const char* end_ = file_.content.data() + file_.content.size();
};

// Where the value of a vertex property goes: the position, or one of the lists that exist once a property
// needs them.
enum class Target { position, normal, uv, color, scalar };

struct VertexColumn {
  PlyProperty property;
  bool known = false;
  Target target = Target::position;
  int component = 0;  ///< of a scalar: its number
  double scale = 1.0;
};

VertexColumn column_of(const PlyProperty& property) {
  struct Name {
    std::string_view name;
    Target target;
    int component;
  };
  constexpr Name k_names[] = {
      {"x", Target::position, 0},   {"y", Target::position, 1},   {"z", Target::position, 2},
      {"nx", Target::normal, 0},    {"ny", Target::normal, 1},    {"nz", Target::normal, 2},
      {"s", Target::uv, 0},         {"t", Target::uv, 1},         {"u", Target::uv, 0},
      {"v", Target::uv, 1},         {"texture_u", Target::uv, 0}, {"texture_v", Target::uv, 1},
      {"texture_s", Target::uv, 0}, {"texture_t", Target::uv, 1}, {"red", Target::color, 0},
      {"green", Target::color, 1},  {"blue", Target::color, 2},   {"alpha", Target::color, 3}};
  VertexColumn column{property};
  for (const Name& name : k_names) {
    if (property.is_list || property.name != name.name) continue;
    column.known = true;
    column.target = name.target;
    column.component = name.component;
    if (name.target == Target::color && is_ply_integer(property.type)) column.scale = 255.0;
  }
  return column;
}

enum class FaceList { vertices, uvs, normals, material, skipped };

FaceList face_list_of(const PlyProperty& property) {
  if (property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index")) {
    return FaceList::vertices;
  }
  if (property.is_list && property.name == "texcoord") return FaceList::uvs;
  if (property.is_list && property.name == "corner_normals") return FaceList::normals;
  if (!property.is_list && (property.name == "material_index" || property.name == "texnumber")) {
    return FaceList::material;
  }
  return FaceList::skipped;
}

template <class Source>
class PlyBody {
 public:
  PlyBody(const InputFile& file, PlyHeader& header) : file_(file), header_(header), source_(file, header) {}

  PolygonSoup read(std::vector<Vec3>& vertex_normals) {
    soup_.materials = header_.materials;
    for (const PlyElement& element : header_.elements) {
      check_count(element);
      if (element.name == "vertex") {
        read_vertices(element);
      } else if (element.name == "face") {
        read_faces(element);
      } else if (element.name == "edge" && element.has("vertex1") && element.has("vertex2")) {
        read_edges(element);
      } else if (!element.properties.empty()) {
        for (std::size_t i = 0; i < element.count; ++i) {
          for (const PlyProperty& property : element.properties) skip(property);
        }
      }
    }
    PolygonSoup soup = finish();
    vertex_normals = std::move(vertex_normals_);
    return soup;
  }

  /// The faces in turn. The vertices must come first, all of one size, so that each can be found.
  void read_pieces(std::size_t most_faces, const TakePiece& take) {
    const PlyElement &vertices = *header_.find("vertex"), &faces = *header_.find("face");
    const std::size_t vertices_offset = source_.offset(), vertex_size = row_size(vertices);
    check_count(vertices);
    source_.skip(vertices.count * vertex_size, PlyType::uint8);
    check_count(faces);
    const std::vector<FaceList> lists = face_lists(faces);
    for (std::size_t first = 0; first < faces.count; first += most_faces) {
      start_piece();
      reserve_faces(std::min(most_faces, faces.count - first), lists);
      for (std::size_t face = first; face < std::min(faces.count, first + most_faces); ++face)
        read_face(face, faces, lists);
      const std::vector<Index> used = number_anew(soup_.corner_vertices);
      const std::size_t faces_offset = source_.offset();
      const std::vector<VertexColumn> columns = vertex_columns(vertices, used.size());
      for (std::size_t i = 0; i < used.size(); ++i) {
        source_.seek(vertices_offset + used[i] * vertex_size);
        read_vertex(i, columns);
        if (!soup_.positions[i].allFinite())
          source_.fail(fmt::format("the position of vertex {} isn't finite", used[i]));
      }
      source_.seek(faces_offset);
      take(finish());
    }
  }

 private:
  void start_piece() {
    soup_ = {};
    soup_.materials = header_.materials;
    vertex_normals_.clear();
    vertex_uvs_.clear();
    corner_lists_ = false;
  }

  /// Bytes of one row of an element without lists.
  static std::size_t row_size(const PlyElement& element) {
    std::size_t size = 0;
    for (const PlyProperty& property : element.properties) size += ply_type_size(property.type);
    return size;
  }

  /// Numbers those that occur from 0 on, in their order, and returns them.
  static std::vector<Index> number_anew(std::vector<Index>& numbers) {
    std::vector<Index> used = numbers;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (Index& number : numbers)
      number = static_cast<Index>(std::lower_bound(used.begin(), used.end(), number) - used.begin());
    return used;
  }

  // The header may promise anything; memory is reserved for what the file can hold.
  void check_count(const PlyElement& element) const {
    if (element.properties.empty()) return;
    std::size_t least = 0;
    for (const PlyProperty& property : element.properties) {
      least += Source::least_size(property.is_list ? property.count_type : property.type);
    }
    if (element.count > source_.remaining() / least) {
      source_.fail(fmt::format("the header promises {} elements {}, but the file has {} bytes left",
                               element.count, in_quotes(element.name),
                               file_.content.size() - source_.offset()));
    }
    check_countable(file_, element.count, "elements");
  }

  std::size_t list_count(const PlyProperty& property) {
    const double value = source_.next(property.count_type);
    const std::size_t most = source_.remaining() / Source::least_size(property.type);
    const std::size_t count = index_or_size(value, most + 1);
    if (count > most)
      source_.fail(fmt::format("list {} of {} values runs past the end", in_quotes(property.name), value));
    return count;
  }

  void skip(const PlyProperty& property) {
    source_.skip(property.is_list ? list_count(property) : 1, property.type);
  }

  // A name that occurs twice, as no program writes it, is skipped the second time.
  void add_scalar(VertexColumn& column, std::size_t n_vertices) {
    const std::string& name = column.property.name;
    const auto same = [&](const VertexScalar& scalar) { return scalar.name == name; };
    if (std::any_of(soup_.vertex_scalars.begin(), soup_.vertex_scalars.end(), same)) return;
    column.known = true;
    column.target = Target::scalar;
    column.component = static_cast<int>(soup_.vertex_scalars.size());
    soup_.vertex_scalars.push_back({name, std::vector<double>(n_vertices)});
  }

  /// Where the properties of vertices go, and lists for so many.
  std::vector<VertexColumn> vertex_columns(const PlyElement& element, std::size_t n_vertices) {
    std::vector<VertexColumn> columns;
    for (const PlyProperty& property : element.properties) {
      columns.push_back(column_of(property));
      if (!columns.back().known && !property.is_list) add_scalar(columns.back(), n_vertices);
      if (!columns.back().known) continue;
      if (columns.back().target == Target::normal) vertex_normals_.resize(n_vertices, Vec3::Zero());
      if (columns.back().target == Target::uv) vertex_uvs_.resize(n_vertices, Vec2::Zero());
      if (columns.back().target == Target::color) soup_.vertex_colors.resize(n_vertices, Vec4::Ones());
    }
    for (const char* name : {"x", "y", "z"}) {
      if (!element.has(name)) source_.fail(fmt::format("vertices have no property '{}'", name));
    }
    soup_.positions.resize(n_vertices);
    return columns;
  }

  void read_vertices(const PlyElement& element) {
    const std::vector<VertexColumn> columns = vertex_columns(element, element.count);
    for (std::size_t vertex = 0; vertex < element.count; ++vertex) {
      progress_.at(source_.offset());
      read_vertex(vertex, columns);
    }
  }

  void read_vertex(std::size_t vertex, const std::vector<VertexColumn>& columns) {
    for (const VertexColumn& column : columns) {
      if (!column.known) {
        skip(column.property);
        continue;
      }
      const double value = source_.next(column.property.type);
      switch (column.target) {
        case Target::position:
          soup_.positions[vertex][column.component] = value;
          break;
        case Target::normal:
          vertex_normals_[vertex][column.component] = value;
          break;
        case Target::uv:
          vertex_uvs_[vertex][column.component] = value;
          break;
        case Target::color:
          soup_.vertex_colors[vertex][column.component] = value / column.scale;
          break;
        case Target::scalar:
          soup_.vertex_scalars[static_cast<std::size_t>(column.component)].values[vertex] = value;
          break;
      }
    }
  }

  Index read_vertex_index(PlyType type) {
    const double value = source_.next(type);
    const std::size_t index = index_or_size(value, n_vertices_);
    if (index == n_vertices_)
      source_.fail(fmt::format("vertex {} is out of range (there are {})", value, n_vertices_));
    return static_cast<Index>(index);
  }

  std::vector<FaceList> face_lists(const PlyElement& element) const {
    std::vector<FaceList> lists;
    for (const PlyProperty& property : element.properties) {
      const FaceList list = face_list_of(property);
      const bool repeated = std::find(lists.begin(), lists.end(), list) != lists.end();
      lists.push_back(repeated && list != FaceList::vertices ? FaceList::skipped : list);
    }
    if (element.count > 0 && std::count(lists.begin(), lists.end(), FaceList::vertices) != 1) {
      source_.fail("faces need one list property 'vertex_indices'");
    }
    return lists;
  }

  void reserve_faces(std::size_t n, const std::vector<FaceList>& lists) {
    soup_.face_offsets.reserve(n + 1);
    soup_.corner_vertices.reserve(std::min(3 * n, source_.remaining()));
    const auto reads = [&lists](FaceList list) {
      return std::find(lists.begin(), lists.end(), list) != lists.end();
    };
    if (reads(FaceList::uvs)) soup_.corner_uvs.reserve(std::min(3 * n, source_.remaining() / 4));
    if (reads(FaceList::normals)) soup_.corner_normals.reserve(std::min(3 * n, source_.remaining() / 6));
  }

  void read_faces(const PlyElement& element) {
    const std::vector<FaceList> lists = face_lists(element);
    reserve_faces(element.count, lists);
    for (std::size_t face = 0; face < element.count; ++face) read_face(face, element, lists);
  }

  void read_face(std::size_t face, const PlyElement& element, const std::vector<FaceList>& lists) {
    progress_.at(source_.offset());
    face_start_ = soup_.n_corners();
    for (std::size_t i = 0; i < lists.size(); ++i) read_face_property(face, element.properties[i], lists[i]);
    pad_corner_lists(face);
  }

  void read_face_property(std::size_t face, const PlyProperty& property, FaceList list) {
    switch (list) {
      case FaceList::vertices:
        return read_face_vertices(face, property);
      case FaceList::uvs:
        return read_corner_list(face, property, soup_.corner_uvs);
      case FaceList::normals:
        return read_corner_list(face, property, soup_.corner_normals);
      case FaceList::material:
        return read_material(property);
      case FaceList::skipped:
        return skip(property);
    }
  }

  void read_face_vertices(std::size_t face, const PlyProperty& property) {
    const std::size_t n = list_count(property);
    if (n < 3) source_.fail(fmt::format("face {} has {} {}", face, n, n == 1 ? "corner" : "corners"));
    check_countable(file_, soup_.n_corners() + n, "corners");
    for (std::size_t i = 0; i < n; ++i) soup_.corner_vertices.push_back(read_vertex_index(property.type));
    soup_.face_offsets.push_back(static_cast<Index>(soup_.n_corners()));
  }

  // The values of each corner of a face, one corner after the other; an empty list is a face without them.
  template <class Attribute>
  void read_corner_list(std::size_t face, const PlyProperty& property, std::vector<Attribute>& corners) {
    constexpr std::size_t k_size = Attribute::RowsAtCompileTime;
    const std::size_t n = list_count(property);
    if (n % k_size != 0) {
      source_.fail(fmt::format("list {} of face {} has {} values", in_quotes(property.name), face, n));
    }
    if (n > 0 && corners.empty()) corners.resize(face_start_, Attribute::Zero());
    for (std::size_t i = 0; i < n / k_size; ++i) {
      Attribute value;
      for (double& component : value) component = source_.next(property.type);
      corners.push_back(value);
    }
    corner_lists_ = true;
  }

  // Lists may stand before the face's vertices, hence the check of their lengths at the face's end.
  void pad_corner_lists(std::size_t face) {
    if (!corner_lists_) return;
    const std::size_t n = soup_.n_corners();
    const std::size_t before = face_start_;
    const auto pad = [&](auto& corners) {
      using Attribute = typename std::decay_t<decltype(corners)>::value_type;
      if (corners.size() == before) corners.resize(n, Attribute::Zero());
      if (corners.size() != n) {
        source_.fail(fmt::format("face {} has {} corners, but {} corner values", face, n - before,
                                 corners.size() - before));
      }
    };
    if (!soup_.corner_uvs.empty()) pad(soup_.corner_uvs);
    if (!soup_.corner_normals.empty()) pad(soup_.corner_normals);
  }

  void read_material(const PlyProperty& property) {
    constexpr std::size_t k_most_materials = 1u << 16;  // no file has more; a damaged one might seem to
    const double value = source_.next(property.type);
    std::size_t index = k_no_index;
    if (value != -1.0 && value != static_cast<double>(k_no_index)) {
      index = index_or_size(value, std::max(k_most_materials, soup_.materials.size()));
      if (index >= std::max(k_most_materials, soup_.materials.size())) {
        source_.fail(fmt::format("material {} is out of range", value));
      }
      n_used_materials_ = std::max(n_used_materials_, index + 1);
    }
    soup_.face_materials.push_back(static_cast<Index>(index));
  }

  void read_edges(const PlyElement& element) {
    soup_.feature_edges.reserve(element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      progress_.at(source_.offset());
      std::pair<Index, Index> edge;
      for (const PlyProperty& property : element.properties) {
        if (property.name == "vertex1" && !property.is_list) {
          edge.first = read_vertex_index(property.type);
        } else if (property.name == "vertex2" && !property.is_list) {
          edge.second = read_vertex_index(property.type);
        } else {
          skip(property);
        }
      }
      soup_.feature_edges.push_back(edge);
    }
  }

  // Attributes of corners win over those of vertices. Materials without a comment get the name of a texture,
  // or a number.
  PolygonSoup finish() {
    const std::size_t n = soup_.n_corners();
    if (soup_.corner_uvs.empty() && !vertex_uvs_.empty())
      soup_.corner_uvs = at_corners(vertex_uvs_, soup_.corner_vertices);
    if (soup_.corner_normals.empty() && !vertex_normals_.empty()) {
      soup_.corner_normals = at_corners(vertex_normals_, soup_.corner_vertices);
    }
    if (!soup_.corner_uvs.empty()) soup_.corner_uvs.resize(n, Vec2::Zero());
    if (!soup_.corner_normals.empty()) soup_.corner_normals.resize(n, Vec3::Zero());
    if (soup_.materials.empty() && !header_.texture_files.empty()) {
      for (const std::string& texture : header_.texture_files) {
        soup_.materials.push_back({texture, Vec4::Ones(), texture});
      }
      if (soup_.face_materials.empty()) soup_.face_materials.assign(soup_.n_faces(), 0);
    }
    while (soup_.materials.size() < n_used_materials_) {
      soup_.materials.emplace_back();
      soup_.materials.back().name = fmt::format("material_{}", soup_.materials.size() - 1);
    }
    return std::move(soup_);
  }

  const InputFile& file_;
  PlyHeader& header_;
  Source source_;
  ReadProgress progress_{file_};
  PolygonSoup soup_;
  std::vector<Vec3> vertex_normals_;
  std::vector<Vec2> vertex_uvs_;
  std::size_t n_vertices_ = header_.find("vertex")->count;
  std::size_t n_used_materials_ = 0;
  std::size_t face_start_ = 0;  // the first corner of the face that is being read
  bool corner_lists_ = false;   // some face had a list of corner values
};

}  // namespace

bool has_own_meaning(std::string_view vertex_property) {
  return column_of({.name = std::string(vertex_property)}).known;
}

PolygonSoup read_ply(const InputFile& file) {
  std::vector<Vec3> vertex_normals;
  return read_ply(file, vertex_normals);
}

namespace {

PlyHeader checked_header(const InputFile& file) {
  PlyHeader header = read_ply_header(file);
  if (header.find("tristrips") != nullptr) {
    file.fail("triangle strips (element 'tristrips') aren't supported; write the file with faces");
  }
  if (header.find("vertex") == nullptr) file.fail("the header names no element 'vertex'");
  return header;
}

}  // namespace

std::optional<std::size_t> ply_faces_in_pieces(const InputFile& file) {
  const PlyHeader header = checked_header(file);
  if (header.encoding == PlyHeader::Encoding::ascii) return {};
  const PlyElement* const faces = header.find("face");
  return faces == nullptr ? 0 : faces->count;
}

void read_ply_pieces(const InputFile& file, std::size_t most_faces, const TakePiece& take) {
  PlyHeader header = checked_header(file);
  if (header.find("face") == nullptr) return;
  const auto& elements = header.elements;
  const auto has_list = [](const PlyProperty& property) { return property.is_list; };
  if (elements.size() < 2 || elements[0].name != "vertex" || elements[1].name != "face" ||
      std::any_of(elements[0].properties.begin(), elements[0].properties.end(), has_list)) {
    file.fail("can't be read in pieces: vertices without lists have to come first, and then the faces");
  }
  const PlyElement* const edges = header.find("edge");
  if (edges != nullptr && edges->count > 0 && edges->has("vertex1") && edges->has("vertex2"))
    file.fail("can't be read in pieces: it has feature edges");
  if (header.encoding == PlyHeader::Encoding::big_endian)
    return PlyBody<BinarySource<true>>(file, header).read_pieces(most_faces, take);
  PlyBody<BinarySource<false>>(file, header).read_pieces(most_faces, take);
}

PolygonSoup read_ply(const InputFile& file, std::vector<Vec3>& vertex_normals) {
  PlyHeader header = checked_header(file);
  switch (header.encoding) {
    case PlyHeader::Encoding::ascii:
      return PlyBody<AsciiSource>(file, header).read(vertex_normals);
    case PlyHeader::Encoding::little_endian:
      return PlyBody<BinarySource<false>>(file, header).read(vertex_normals);
    case PlyHeader::Encoding::big_endian:
      return PlyBody<BinarySource<true>>(file, header).read(vertex_normals);
  }
  return {};
}

}  // namespace recede::detail
