#include <recede/lod/detail/byte_streams.h>

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <stdexcept>

namespace recede::detail {
namespace {

/// Streams are small: the slowest setting costs little.
constexpr int k_level = 19;
/// How a stream is held: not at all, one byte many times, as it is, compressed.
enum Form : std::uint8_t { k_empty, k_constant, k_plain, k_compressed };

void append_varint(std::string& bytes, std::uint64_t value) {
  for (; value >= 128; value >>= 7) bytes.push_back(static_cast<char>(value | 128));
  bytes.push_back(static_cast<char>(value));
}

std::uint64_t read_varint(std::string_view& bytes) {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    if (bytes.empty()) throw std::out_of_range("a batch ends too early");
    const auto byte = static_cast<std::uint8_t>(bytes.front());
    bytes.remove_prefix(1);
    value |= static_cast<std::uint64_t>(byte & 127) << shift;
    if (byte < 128) return value;
  }
  throw std::out_of_range("a number in a batch is too long");
}

std::string_view take_bytes(std::string_view& bytes, std::size_t n) {
  if (n > bytes.size()) throw std::out_of_range("a batch ends too early");
  const std::string_view result = bytes.substr(0, n);
  bytes.remove_prefix(n);
  return result;
}

}  // namespace

void ByteStreams::fail() { throw std::out_of_range("a batch has too few bytes of one kind"); }

void ByteStreams::put_varint(ByteKind kind, std::uint64_t value) {
  for (; value >= 128; value >>= 7) put(kind, static_cast<std::uint8_t>(value | 128));
  put(kind, static_cast<std::uint8_t>(value));
}

void ByteStreams::put_planes(ByteKind kind, std::uint64_t value, std::size_t planes) {
  for (std::size_t i = 0; i < planes; ++i) {
    put(static_cast<ByteKind>(static_cast<std::size_t>(kind) + i),
        static_cast<std::uint8_t>(value >> (8 * i)));
  }
}

std::uint64_t ByteStreams::take_varint(ByteKind kind) {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    const std::uint8_t byte = take(kind);
    value |= static_cast<std::uint64_t>(byte & 127) << shift;
    if (byte < 128) return value;
  }
  throw std::out_of_range("a number in a batch is too long");
}

std::uint64_t ByteStreams::take_planes(ByteKind kind, std::size_t planes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < planes; ++i) {
    value |= static_cast<std::uint64_t>(take(static_cast<ByteKind>(static_cast<std::size_t>(kind) + i)))
             << (8 * i);
  }
  return value;
}

bool ByteStreams::all_taken() const {
  for (std::size_t k = 0; k < streams_.size(); ++k) {
    if (at_[k] != streams_[k].size()) return false;
  }
  return true;
}

std::string ByteStreams::pack(
    std::array<std::size_t, static_cast<std::size_t>(ByteKind::count)>* sizes) const {
  std::string packed;
  std::size_t total = 0;
  for (std::size_t k = 0; k < streams_.size(); ++k) {
    const auto& stream = streams_[k];
    const std::size_t before = packed.size();
    total += stream.size();
    if (stream.empty()) {
      packed.push_back(k_empty);
    } else if (std::all_of(stream.begin(), stream.end(), [&](std::uint8_t b) { return b == stream[0]; })) {
      packed.push_back(k_constant);
      append_varint(packed, stream.size());
      packed.push_back(static_cast<char>(stream[0]));
    } else {
      std::string compressed(ZSTD_compressBound(stream.size()), '\0');
      const std::size_t size =
          ZSTD_compress(compressed.data(), compressed.size(), stream.data(), stream.size(), k_level);
      const bool is_smaller = ZSTD_isError(size) == 0 && size + 3 < stream.size();
      packed.push_back(static_cast<char>(is_smaller ? k_compressed : k_plain));
      append_varint(packed, stream.size());
      if (is_smaller) {
        append_varint(packed, size);
        packed.append(compressed, 0, size);
      } else {
        packed.append(reinterpret_cast<const char*>(stream.data()), stream.size());
      }
    }
    if (sizes != nullptr) (*sizes)[k] += packed.size() - before;
  }
  // Readers take no more than this growth for honest.
  packed.append(std::max(packed.size(), total / k_most_growth + 1) - packed.size(), '\0');
  return packed;
}

ByteStreams ByteStreams::unpack(std::string_view packed) {
  ByteStreams result;
  std::size_t allowed = k_most_growth * packed.size();
  for (auto& stream : result.streams_) {
    const auto form = static_cast<std::uint8_t>(take_bytes(packed, 1)[0]);
    if (form == k_empty) continue;
    if (form > k_compressed) throw std::out_of_range("a batch holds bytes in an unknown form");
    const std::uint64_t size = read_varint(packed);
    if (size > allowed) throw std::out_of_range("a batch is larger than its bytes allow");
    allowed -= size;
    if (form == k_constant) {
      stream.assign(size, static_cast<std::uint8_t>(take_bytes(packed, 1)[0]));
    } else if (form == k_plain) {
      const std::string_view bytes = take_bytes(packed, size);
      stream.assign(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    } else {
      const std::string_view bytes = take_bytes(packed, read_varint(packed));
      stream.resize(size);
      const std::size_t got = ZSTD_decompress(stream.data(), stream.size(), bytes.data(), bytes.size());
      if (ZSTD_isError(got) != 0 || got != size) throw std::out_of_range("a batch can't be decompressed");
    }
  }
  return result;
}

std::uint32_t crc32(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      ::crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

}  // namespace recede::detail
