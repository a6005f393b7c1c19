// Bytes of different kinds side by side, each kind compressed by itself.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace recede::detail {

/// Kinds of bytes in a batch; see docs/progressive.md.
enum class ByteKind : std::size_t {
  counts,
  kept,
  kept_high = kept + 3,  // planes of four bytes
  shape,
  first,
  length,
  labels,
  vertices,
  faces,
  moved,
  positions,
  positions_high = positions + 7,  // planes of eight
  wedges,
  flags,
  attributes,
  attributes_high = attributes + 7,
  errors,
  errors_high = errors + 3,
  numbers,
  numbers_high = numbers + 3,
  raw,
  count
};

/// Writes or reads numbers in order, kind by kind. Reading past the end or from a broken stream throws
/// `std::out_of_range`, whose text is the reason.
class ByteStreams {
 public:
  void put(ByteKind kind, std::uint8_t byte) { streams_[static_cast<std::size_t>(kind)].push_back(byte); }
  void put_varint(ByteKind kind, std::uint64_t value);
  /// Each byte of `value` goes to its own plane; `kind` is the first.
  void put_planes(ByteKind kind, std::uint64_t value, std::size_t planes);

  std::uint8_t take(ByteKind kind) {
    const auto k = static_cast<std::size_t>(kind);
    if (at_[k] >= streams_[k].size()) fail();
    return streams_[k][at_[k]++];
  }
  std::uint64_t take_varint(ByteKind kind);
  std::uint64_t take_planes(ByteKind kind, std::size_t planes);
  /// Bytes not yet taken.
  std::size_t left(ByteKind kind) const {
    const auto k = static_cast<std::size_t>(kind);
    return streams_[k].size() - at_[k];
  }
  bool all_taken() const;

  /// Compresses everything. `sizes`, when given, receives the compressed bytes of each kind.
  std::string pack(std::array<std::size_t, static_cast<std::size_t>(ByteKind::count)>* sizes = nullptr) const;
  /// The contrary. What comes out is at most `k_most_growth` times as long as what goes in.
  static ByteStreams unpack(std::string_view packed);
  static constexpr std::size_t k_most_growth = 128;

 private:
  [[noreturn]] static void fail();
  std::array<std::basic_string<std::uint8_t>, static_cast<std::size_t>(ByteKind::count)> streams_;
  std::array<std::size_t, static_cast<std::size_t>(ByteKind::count)> at_{};
};

inline std::uint64_t zigzag(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
}
inline std::int64_t unzigzag(std::uint64_t value) {
  return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

/// The checksum of zip and PNG.
std::uint32_t crc32(std::string_view bytes);

}  // namespace recede::detail
