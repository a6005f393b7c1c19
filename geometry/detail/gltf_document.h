// A glTF 2.0 file taken apart: its JSON, whose values complain with their place in the document, and its
// buffers, read through accessors that are checked against the bytes there are.
//
// Debian's tinygltf isn't used here: it crashes on nested extras and on images outside their buffer, and
// leaves the ranges of accessors to its callers.
#pragma once

#include <recede/geometry/detail/format_io.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace recede::detail {

/// Kinds of chunks in GLB files: "JSON" and "BIN".
inline constexpr std::uint32_t k_json_chunk = 0x4e4f534a, k_binary_chunk = 0x004e4942;

/// In the extras of a material that stands for none.
inline constexpr const char* k_no_material = "no_material";
/// Extra of images inside the file: the path by which materials of a soup name them.
inline constexpr const char* k_picture_file = "picture_file";

/// A value in the document and where it stands ("meshes[0].primitives"). Every access checks the type.
class GltfValue {
 public:
  GltfValue(const InputFile& file, const nlohmann::json* value, std::string place)
      : file_(&file), value_(value), place_(std::move(place)) {}

  /// False for a member that isn't there.
  explicit operator bool() const { return value_ != nullptr; }
  GltfValue operator[](const char* key) const;
  GltfValue at(std::size_t index) const;
  std::size_t size() const;  ///< of an array; 0 when absent

  std::size_t integer() const;  ///< from 0, below 2^53
  std::size_t integer_or(std::size_t absent) const { return value_ == nullptr ? absent : integer(); }
  double number() const;
  std::string text_or(std::string_view absent) const;
  bool is_true() const;
  template <class Vector>
  Vector vector_or(const Vector& absent) const {
    if (value_ == nullptr) return absent;
    Vector result;
    if (size() != static_cast<std::size_t>(result.size())) fail("has the wrong length");
    for (std::size_t i = 0; i < size(); ++i) result(static_cast<Eigen::Index>(i)) = at(i).number();
    return result;
  }

  const nlohmann::json& json() const { return *value_; }
  [[noreturn]] void fail(const std::string& reason) const;

 private:
  const InputFile* file_;
  const nlohmann::json* value_;
  std::string place_;
};

/// The values of an accessor, normalised integers scaled to -1..1, as doubles.
struct GltfValues {
  std::size_t count = 0;
  std::size_t components = 0;
  std::vector<double> values;
};

class GltfDocument {
 public:
  /// Reads .glb and .gltf, whatever the file is called. Throws `InputError`.
  explicit GltfDocument(const InputFile& file);

  GltfValue root() const { return {file_, &json_, ""}; }
  /// An element of a top-level list: `element("meshes", 2)`. Throws when there is none.
  GltfValue element(const char* list, std::size_t index) const;
  GltfValues read_accessor(std::size_t index);
  /// The bytes of an image that is inside of the file; nothing when it is a file of its own.
  std::optional<std::string> read_picture(const GltfValue& image);
  /// Indices of a primitive.
  std::vector<std::uint32_t> read_indices(std::size_t index);

 private:
  /// An accessor's bytes: element i starts at first + i * stride.
  struct Layout {
    const char* first = nullptr;
    std::size_t stride = 0, count = 0, components = 0, component_type = 0;
    bool normalized = false;
  };
  void split_glb();
  void parse_json(std::string_view text, std::size_t offset);
  void check_version_and_extensions() const;
  Layout layout_of(std::size_t accessor);
  std::string_view view_bytes(const GltfValue& user, std::size_t view);
  std::string_view buffer_bytes(std::size_t index);
  std::string load_buffer(const GltfValue& buffer) const;
  static std::string decode_data_uri(const GltfValue& value, std::string_view uri);

  const InputFile& file_;
  nlohmann::json json_;
  std::string_view binary_chunk_;
  bool has_binary_chunk_ = false;
  std::vector<std::optional<std::string>>
      loaded_;  // buffers that aren't the binary chunk, once they are needed
};

/// "%20" and the like turned into the characters they stand for.
std::string decode_percent(std::string_view uri);
std::string encode_percent(std::string_view path);

}  // namespace recede::detail
