#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/base64.h>
#include <recede/geometry/detail/gltf_document.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace recede::detail {

using nlohmann::json;

namespace {

constexpr std::uint32_t k_glb_magic = 0x46546c67;  // "glTF"

// Extensions that may be required of a reader and change nothing in positions, triangles, normals and base
// colours, or (quantization) are covered by reading every component type.
constexpr std::array k_readable_extensions{"KHR_mesh_quantization", "MSFT_lod",         "KHR_lights_punctual",
                                           "KHR_texture_basisu",    "EXT_texture_webp", "KHR_xmp_json_ld"};

std::uint32_t word_at(std::string_view content, std::size_t offset) {
  std::uint32_t word = 0;
  if (offset + sizeof word <= content.size()) std::memcpy(&word, content.data() + offset, sizeof word);
  return word;
}

template <class Value>
double load(const char* from) {
  Value value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

double load_component(const char* from, std::size_t type) {
  switch (type) {
    case 5120:
      return load<std::int8_t>(from);
    case 5121:
      return load<std::uint8_t>(from);
    case 5122:
      return load<std::int16_t>(from);
    case 5123:
      return load<std::uint16_t>(from);
    case 5125:
      return load<std::uint32_t>(from);
    default:
      return load<float>(from);
  }
}

// Section 3.11: signed integers are clamped, so that the lowest one is -1, too.
double normalize(double value, std::size_t type) {
  switch (type) {
    case 5120:
      return std::max(value / 127.0, -1.0);
    case 5121:
      return value / 255.0;
    case 5122:
      return std::max(value / 32767.0, -1.0);
    case 5123:
      return value / 65535.0;
    case 5125:
      return value / 4294967295.0;
    default:
      return value;
  }
}

std::size_t component_size(std::size_t type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

std::size_t components_of(std::string_view type) {
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4") return 4;
  return 0;
}

}  // namespace

void GltfValue::fail(const std::string& reason) const {
  file_->fail(place_.empty() ? reason : fmt::format("{} {}", place_, reason));
}

GltfValue GltfValue::operator[](const char* key) const {
  const std::string place = place_.empty() ? key : place_ + "." + key;
  if (value_ == nullptr) return {*file_, nullptr, place};
  if (!value_->is_object()) fail("isn't an object");
  const auto found = value_->find(key);
  return {*file_, found == value_->end() ? nullptr : &*found, place};
}

GltfValue GltfValue::at(std::size_t index) const {
  if (index >= size()) fail(fmt::format("has no element {} (there are {})", index, size()));
  return {*file_, &(*value_)[index], fmt::format("{}[{}]", place_, index)};
}

std::size_t GltfValue::size() const {
  if (value_ == nullptr) return 0;
  if (!value_->is_array()) fail("isn't an array");
  return value_->size();
}

std::size_t GltfValue::integer() const {
  constexpr double k_most = 9007199254740992.0;  // doubles hold all integers up to here
  const double value = number();
  if (!(value >= 0.0 && value < k_most) || value != std::floor(value)) fail("isn't a whole number from 0");
  return static_cast<std::size_t>(value);
}

double GltfValue::number() const {
  if (value_ == nullptr) fail("is missing");
  if (!value_->is_number()) fail("isn't a number");
  return value_->get<double>();
}

std::string GltfValue::text_or(std::string_view absent) const {
  if (value_ == nullptr) return std::string(absent);
  if (!value_->is_string()) fail("isn't a text");
  return value_->get<std::string>();
}

bool GltfValue::is_true() const { return value_ != nullptr && value_->is_boolean() && value_->get<bool>(); }

GltfDocument::GltfDocument(const InputFile& file) : file_(file) {
  if (word_at(file.content, 0) == k_glb_magic) {
    split_glb();
  } else {
    parse_json(file.content, 0);
  }
  if (!json_.is_object()) file_.fail("isn't a glTF file (no JSON object)");
  check_version_and_extensions();
  loaded_.resize(root()["buffers"].size());
}

void GltfDocument::split_glb() {
  const std::string_view content = file_.content;
  constexpr std::size_t k_file_header = 12, k_chunk_header = 8;
  if (content.size() < k_file_header + k_chunk_header)
    file_.fail_at_byte(content.size(), "the file ends in its header");
  if (word_at(content, 4) != 2)
    file_.fail_at_byte(4, fmt::format("GLB version {}, not 2", word_at(content, 4)));
  if (word_at(content, 8) > content.size()) {
    file_.fail_at_byte(content.size(),
                       fmt::format("the file ends before its length of {} bytes", word_at(content, 8)));
  }
  bool has_json = false;
  std::size_t offset = k_file_header;
  while (offset + k_chunk_header <= word_at(content, 8)) {
    const std::size_t length = word_at(content, offset);
    const std::uint32_t kind = word_at(content, offset + 4);
    if (length > content.size() - offset - k_chunk_header) {
      file_.fail_at_byte(offset, fmt::format("a chunk of {} bytes runs past the end", length));
    }
    const std::string_view chunk(content.data() + offset + k_chunk_header, length);
    if (!has_json) {
      if (kind != k_json_chunk) file_.fail_at_byte(offset, "the first chunk isn't JSON");
      parse_json(chunk, offset + k_chunk_header);
      has_json = true;
    } else if (kind == k_binary_chunk && !has_binary_chunk_) {
      binary_chunk_ = chunk;
      has_binary_chunk_ = true;
    }
    offset += k_chunk_header + length;
  }
  if (!has_json) file_.fail_at_byte(k_file_header, "no JSON chunk");
}

void GltfDocument::parse_json(std::string_view text, std::size_t offset) {
  try {
    json_ = json::parse(text.begin(), text.end());
  } catch (const json::parse_error& error) {
    const std::size_t at = std::min<std::size_t>(error.byte, text.size());
    if (offset > 0) file_.fail_at_byte(offset + at, "the JSON isn't well-formed");
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    file_.fail_at_line(static_cast<std::size_t>(line), "the JSON isn't well-formed");
  } catch (const json::exception&) {  // a number outside the range of doubles
    file_.fail("the JSON holds a number out of range");
  }
}

void GltfDocument::check_version_and_extensions() const {
  const std::string version = root()["asset"]["version"].text_or("");
  if (!version.starts_with("2.")) file_.fail(fmt::format("glTF version {}, not 2", in_quotes(version)));
  const GltfValue required = root()["extensionsRequired"];
  for (std::size_t i = 0; i < required.size(); ++i) {
    const std::string name = required.at(i).text_or("");
    const bool readable = name.starts_with("KHR_materials_") ||
                          std::find(k_readable_extensions.begin(), k_readable_extensions.end(), name) !=
                              k_readable_extensions.end();
    if (!readable) file_.fail(fmt::format("needs the extension {}, which isn't supported", in_quotes(name)));
  }
}

GltfValue GltfDocument::element(const char* list, std::size_t index) const { return root()[list].at(index); }

std::string GltfDocument::decode_data_uri(const GltfValue& value, std::string_view uri) {
  constexpr std::string_view k_encoding = ";base64,";
  const std::size_t comma = uri.find(k_encoding);
  if (comma == uri.npos) value.fail("has a data URI that isn't base64");
  std::optional<std::string> bytes = decode_base64(uri.substr(comma + k_encoding.size()));
  if (!bytes) value.fail("has a data URI that isn't base64");
  return std::move(*bytes);
}

std::string GltfDocument::load_buffer(const GltfValue& buffer) const {
  const std::string uri = buffer["uri"].text_or("");
  if (uri.empty()) buffer.fail("has no data");
  if (uri.starts_with("data:")) return decode_data_uri(buffer, uri);
  const std::string relative = decode_percent(uri);
  if (relative.find("://") != relative.npos) buffer.fail("isn't a local file: " + in_quotes(uri));
  if (std::any_of(relative.begin(), relative.end(), [](unsigned char c) { return c < ' '; })) {
    buffer.fail("has a malformed URI: " + in_quotes(uri));
  }
  return read_whole_file(file_.path.parent_path() / relative);
}

std::string_view GltfDocument::buffer_bytes(std::size_t index) {
  const GltfValue buffer = element("buffers", index);
  const std::size_t length = buffer["byteLength"].integer();
  std::string_view bytes = binary_chunk_;
  if (index != 0 || !has_binary_chunk_ || buffer["uri"]) {
    if (!loaded_[index]) loaded_[index] = load_buffer(buffer);
    bytes = *loaded_[index];
  }
  if (length > bytes.size()) {
    buffer.fail(fmt::format("should have {} bytes, but its data end after {}", length, bytes.size()));
  }
  return bytes.substr(0, length);
}

std::string_view GltfDocument::view_bytes(const GltfValue& user, std::size_t index) {
  const GltfValue view = element("bufferViews", index);
  for (const char* compression : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    if (!view["extensions"][compression]) continue;
    user.fail(fmt::format("needs the extension {}, which isn't supported", compression));
  }
  const std::string_view bytes = buffer_bytes(view["buffer"].integer());
  const std::size_t offset = view["byteOffset"].integer_or(0);
  const std::size_t length = view["byteLength"].integer();
  if (offset > bytes.size() || length > bytes.size() - offset) {
    view.fail(
        fmt::format("reads bytes {} to {} of a buffer of {} bytes", offset, offset + length, bytes.size()));
  }
  return bytes.substr(offset, length);
}

GltfDocument::Layout GltfDocument::layout_of(std::size_t index) {
  const GltfValue accessor = element("accessors", index);
  if (accessor["sparse"]) accessor.fail("is sparse, which isn't supported");
  if (!accessor["bufferView"]) accessor.fail("has no buffer view");
  Layout layout;
  layout.count = accessor["count"].integer();
  layout.component_type = accessor["componentType"].integer();
  layout.components = components_of(accessor["type"].text_or(""));
  layout.normalized = accessor["normalized"].is_true();
  const std::size_t size = component_size(layout.component_type) * layout.components;
  if (size == 0) accessor.fail("has an unknown type");
  const std::size_t view = accessor["bufferView"].integer();
  const std::string_view bytes = view_bytes(accessor, view);
  layout.stride = element("bufferViews", view)["byteStride"].integer_or(size);
  if (layout.stride < size || layout.stride > 252)
    accessor.fail(fmt::format("has a stride of {} bytes", layout.stride));
  const std::size_t offset = accessor["byteOffset"].integer_or(0);
  // The last element needn't be followed by a whole stride.
  const bool fits =
      offset <= bytes.size() &&
      (layout.count == 0 ||
       (size <= bytes.size() - offset && layout.count - 1 <= (bytes.size() - offset - size) / layout.stride));
  if (!fits) {
    accessor.fail(fmt::format("reads {} elements past the end of its buffer view of {} bytes", layout.count,
                              bytes.size()));
  }
  layout.first = bytes.data() + offset;
  return layout;
}

GltfValues GltfDocument::read_accessor(std::size_t index) {
  const Layout layout = layout_of(index);
  GltfValues result{layout.count, layout.components, {}};
  result.values.reserve(layout.count * layout.components);
  const std::size_t size = component_size(layout.component_type);
  for (std::size_t i = 0; i < layout.count; ++i) {
    for (std::size_t c = 0; c < layout.components; ++c) {
      const double value = load_component(layout.first + i * layout.stride + c * size, layout.component_type);
      result.values.push_back(layout.normalized ? normalize(value, layout.component_type) : value);
    }
  }
  return result;
}

std::optional<std::string> GltfDocument::read_picture(const GltfValue& image) {
  if (image["bufferView"]) return std::string(view_bytes(image, image["bufferView"].integer()));
  const std::string uri = image["uri"].text_or("");
  if (!uri.starts_with("data:")) return std::nullopt;
  return decode_data_uri(image, uri);
}

std::vector<std::uint32_t> GltfDocument::read_indices(std::size_t index) {
  const Layout layout = layout_of(index);
  const GltfValue accessor = element("accessors", index);
  const bool is_unsigned =
      layout.component_type == 5121 || layout.component_type == 5123 || layout.component_type == 5125;
  if (layout.components != 1 || !is_unsigned) accessor.fail("holds no indices");
  std::vector<std::uint32_t> indices;
  indices.reserve(layout.count);
  for (std::size_t i = 0; i < layout.count; ++i) {
    indices.push_back(
        static_cast<std::uint32_t>(load_component(layout.first + i * layout.stride, layout.component_type)));
  }
  return indices;
}

std::string decode_percent(std::string_view uri) {
  const auto digit = [](char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
  };
  std::string result;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      result += static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
      i += 2;
    } else {
      result += uri[i];
    }
  }
  return result;
}

std::string encode_percent(std::string_view path) {
  constexpr std::string_view k_plain = "-_.~/!$&'()*+,;=:@";
  std::string result;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || k_plain.find(c) != k_plain.npos) {
      result += c;
    } else {
      result += fmt::format("%{:02X}", byte);
    }
  }
  return result;
}

}  // namespace recede::detail
