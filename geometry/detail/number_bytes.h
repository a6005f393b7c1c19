// Numbers as little-endian bytes of files.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace recede::detail {

template <class Unsigned>
void append_bytes(std::string& bytes, Unsigned number) {
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i)
    bytes.push_back(static_cast<char>(static_cast<unsigned char>(number >> (8 * i) & 0xff)));
}

/// The bytes must be there.
template <class Unsigned>
Unsigned number_at(std::string_view bytes, std::size_t offset) {
  Unsigned number = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i)
    number = static_cast<Unsigned>(
        number | static_cast<Unsigned>(static_cast<unsigned char>(bytes[offset + i])) << (8 * i));
  return number;
}

}  // namespace recede::detail
