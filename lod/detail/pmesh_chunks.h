// The frame of a `.pmesh`: a magic number and a version, then parts that each have a kind, a length and a
// checksum.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace recede::detail {

inline constexpr std::string_view k_pmesh_magic = "RCDPMESH";
inline constexpr std::uint32_t k_pmesh_version = 1;
inline constexpr std::size_t k_pmesh_start = 12;   ///< bytes of magic and version
inline constexpr std::size_t k_chunk_header = 12;  ///< bytes of kind, length and checksum

/// Four letters each.
inline constexpr std::string_view k_chunk_head = "HEAD", k_chunk_base = "BASE", k_chunk_splits = "SPLT",
                                  k_chunk_numbering = "NUMB", k_chunk_end = "END ";

inline void append_u32(std::string& bytes, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> (8 * i)));
}
inline std::uint32_t read_u32(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(bytes[i])) << (8 * i);
  }
  return value;
}

}  // namespace recede::detail
