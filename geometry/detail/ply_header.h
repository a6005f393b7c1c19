// The header of a PLY file: its encoding, its elements with their properties, and the comments that carry
// materials.
#pragma once

#include <recede/geometry/detail/format_io.h>

#include <cstddef>
#include <string>
#include <vector>

namespace recede::detail {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

inline constexpr std::size_t ply_type_size(PlyType type) {
  constexpr std::size_t k_sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return k_sizes[static_cast<int>(type)];
}
inline constexpr bool is_ply_integer(PlyType type) { return type < PlyType::float32; }

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;  ///< of the value, or of a list's items
  bool is_list = false;
  PlyType count_type = PlyType::uint8;
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;

  bool has(std::string_view property) const;
};

struct PlyHeader {
  enum class Encoding { ascii, little_endian, big_endian } encoding = Encoding::ascii;
  std::vector<PlyElement> elements;
  std::vector<Material> materials;         ///< from comments, see `format_material_comment`
  std::vector<std::string> texture_files;  ///< MeshLab's "comment TextureFile name"
  std::size_t body_offset = 0;             ///< bytes
  std::size_t body_line = 1;

  const PlyElement* find(std::string_view element) const;
};

/// True for a property of vertices that is part of a position, normal, texture coordinate or colour.
bool has_own_meaning(std::string_view vertex_property);

/// Throws `InputError` with the line.
PlyHeader read_ply_header(const InputFile& file);

/// `material 0 "name" red green blue opacity "texture"`, with backslashes before quotes and backslashes in
/// the texts. Line ends become blanks.
std::string format_material_comment(std::size_t index, const Material& material);

}  // namespace recede::detail
