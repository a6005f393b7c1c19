#include <recede/shells/detail/brick_store.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <unordered_map>

namespace recede::detail {
namespace {

// What is alike has the same; chance makes others the same so seldom that comparing them costs nothing.
std::uint64_t hash_of(const std::byte* bytes, std::size_t n) {
  std::uint64_t hash = n;
  const auto mix = [&](std::uint64_t word) {
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  };
  std::size_t i = 0;
  for (; i + 8 <= n; i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + i, 8);
    mix(word);
  }
  for (; i < n; ++i) mix(std::to_integer<std::uint64_t>(bytes[i]));
  return hash;
}

/// Finds contents again that were there before.
class BrickContents {
 public:
  explicit BrickContents(std::size_t bytes) : bytes_(bytes) {}

  // The number of a brick's content; new ones are numbered one after the other.
  std::size_t number_of(const std::byte* brick, std::uint64_t hash) {
    const auto [first, last] = numbers_.equal_range(hash);
    for (auto it = first; it != last; ++it)
      if (std::memcmp(contents_[it->second], brick, bytes_) == 0) return it->second;
    numbers_.emplace(hash, contents_.size());
    contents_.push_back(brick);
    return contents_.size() - 1;
  }

  // Moves contents from number `first` on to memory of their own.
  std::unique_ptr<std::byte[]> settle(std::size_t first) {
    auto piece = std::make_unique_for_overwrite<std::byte[]>((contents_.size() - first) * bytes_);
    for (std::size_t n = first; n < contents_.size(); ++n) {
      std::byte* to = piece.get() + (n - first) * bytes_;
      std::memcpy(to, contents_[n], bytes_);
      contents_[n] = to;
    }
    return piece;
  }

  std::size_t size() const { return contents_.size(); }
  const std::byte* content(std::size_t number) const { return contents_[number]; }

 private:
  std::size_t bytes_;
  std::vector<const std::byte*> contents_;
  std::unordered_multimap<std::uint64_t, std::size_t> numbers_;
};

}  // namespace

std::shared_ptr<const BrickStore> make_brick_store(std::size_t n_bricks, std::size_t brick_texels,
                                                   std::size_t texel_bytes, const FillBrick& fill,
                                                   Progress* progress, std::string_view stage) {
  constexpr std::size_t k_at_a_time = 512;
  const std::size_t bytes = brick_texels * texel_bytes;
  auto store = std::make_shared<BrickStore>();
  store->bricks.resize(n_bricks);
  store->is_uniform.resize(n_bricks);
  BrickContents contents(bytes);
  std::vector<std::byte> filled(std::min(n_bricks, k_at_a_time) * bytes);
  std::vector<std::uint64_t> hashes(k_at_a_time);
  std::vector<std::size_t> numbers(k_at_a_time);
  for (std::size_t first = 0; first < n_bricks; first += k_at_a_time) {
    report_progress(progress, stage, static_cast<double>(first) / static_cast<double>(n_bricks));
    const std::size_t n = std::min(k_at_a_time, n_bricks - first), before = contents.size();
    tbb::parallel_for(std::size_t{0}, n, [&](std::size_t b) {
      std::byte* brick = filled.data() + b * bytes;
      fill(first + b, brick);
      hashes[b] = hash_of(brick, bytes);
      // Each texel as the one before it.
      store->is_uniform[first + b] = std::memcmp(brick, brick + texel_bytes, bytes - texel_bytes) == 0 ? 1 : 0;
    });
    for (std::size_t b = 0; b < n; ++b) numbers[b] = contents.number_of(filled.data() + b * bytes, hashes[b]);
    if (contents.size() > before) {
      store->pieces.push_back(contents.settle(before));
      store->texel_bytes += (contents.size() - before) * bytes;
    }
    for (std::size_t b = 0; b < n; ++b) store->bricks[first + b] = contents.content(numbers[b]);
  }
  report_progress(progress, stage, 1);
  return store;
}

}  // namespace recede::detail
