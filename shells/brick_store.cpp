#include <recede/shells/detail/brick_store.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstring>
#include <optional>

namespace recede::detail {
namespace {

constexpr std::uint32_t k_free = 0xffffffff;

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

/// Contents of some bytes each, numbered in the order in which they appear.
class Contents {
 public:
  explicit Contents(std::size_t bytes) : bytes_(bytes), slots_(16, k_free) {}

  // A new one is looked up where it is until `settle`.
  std::uint32_t number_of(const std::byte* content, std::uint64_t hash) {
    std::uint32_t& slot = slots_[slot_of(content, hash)];
    if (slot != k_free) return slot;
    const auto number = static_cast<std::uint32_t>(contents_.size());
    slot = number;
    contents_.push_back(content);
    if (2 * contents_.size() > slots_.size()) grow();
    return number;
  }

  // Moves contents from the settled ones on to memory of their own.
  void settle() {
    const std::size_t n = contents_.size() - n_settled_;
    if (n == 0) return;
    auto piece = std::make_unique_for_overwrite<std::byte[]>(n * bytes_);
    for (std::byte* to = piece.get(); n_settled_ < contents_.size(); to += bytes_) {
      std::memcpy(to, contents_[n_settled_], bytes_);
      contents_[n_settled_++] = to;
    }
    pieces_.push_back({std::move(piece), n});
  }

  std::size_t size() const { return contents_.size(); }
  const std::byte* content(std::size_t number) const { return contents_[number]; }

  // All in one piece; there are none afterwards.
  std::unique_ptr<std::byte[]> take() {
    slots_ = {};
    contents_ = {};
    if (pieces_.size() == 1) return std::move(pieces_.front().bytes);
    auto all = std::make_unique_for_overwrite<std::byte[]>(n_settled_ * bytes_);
    std::byte* to = all.get();
    for (Piece& piece : pieces_) {
      to = std::copy_n(piece.bytes.get(), piece.n * bytes_, to);
      piece.bytes.reset();  // so that there is never much twice
    }
    return all;
  }

 private:
  struct Piece {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t n;
  };

  std::size_t slot_of(const std::byte* content, std::uint64_t hash) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash & mask;
    while (slots_[slot] != k_free && std::memcmp(contents_[slots_[slot]], content, bytes_) != 0)
      slot = (slot + 1) & mask;
    return slot;
  }
  void grow() {
    slots_.assign(2 * slots_.size(), k_free);
    for (std::size_t n = 0; n < contents_.size(); ++n)
      slots_[slot_of(contents_[n], hash_of(contents_[n], bytes_))] = static_cast<std::uint32_t>(n);
  }

  std::size_t bytes_, n_settled_ = 0;
  std::vector<const std::byte*> contents_;
  std::vector<std::uint32_t> slots_;  // by hash, or the next free one
  std::vector<Piece> pieces_;
};

// If there are few values in texels.
bool set_palette(const Contents& contents, std::size_t brick_texels, std::size_t texel_bytes,
                 BrickStore& store) {
  constexpr std::size_t k_most_values = 256;
  Contents values(texel_bytes);
  store.n_texel_bytes = contents.size() * brick_texels;
  store.texels = std::make_unique_for_overwrite<std::byte[]>(store.n_texel_bytes);
  std::byte* to = store.texels.get();
  for (std::size_t n = 0; n < contents.size(); ++n) {
    const std::byte* texel = contents.content(n);
    for (std::size_t t = 0; t < brick_texels; ++t, texel += texel_bytes)
      *to++ = static_cast<std::byte>(values.number_of(texel, hash_of(texel, texel_bytes)));
    if (values.size() > k_most_values) return false;
  }
  values.settle();
  store.palette.assign(values.content(0), values.content(0) + values.size() * texel_bytes);
  return true;
}

}  // namespace

std::shared_ptr<const BrickStore> make_brick_store(std::size_t n_bricks, std::size_t brick_texels,
                                                   std::size_t texel_bytes, const FillBrick& fill,
                                                   Progress* progress, std::string_view stage) {
  constexpr std::size_t k_at_a_time = 4096;
  const std::size_t bytes = brick_texels * texel_bytes, most = std::min(n_bricks, k_at_a_time);
  auto store = std::make_shared<BrickStore>();
  store->bricks.resize(n_bricks);
  Contents contents(bytes);
  std::vector<std::byte> filled(most * bytes);
  std::vector<std::uint64_t> hashes(most);
  for (std::size_t first = 0; first < n_bricks; first += k_at_a_time) {
    report_progress(progress, stage, static_cast<double>(first) / static_cast<double>(n_bricks));
    const std::size_t n = std::min(most, n_bricks - first);
    tbb::parallel_for(std::size_t{0}, n, [&](std::size_t b) {
      std::byte* brick = filled.data() + b * bytes;
      fill(first + b, brick);
      hashes[b] = hash_of(brick, bytes);
    });
    for (std::size_t b = 0; b < n; ++b)
      store->bricks[first + b] = contents.number_of(filled.data() + b * bytes, hashes[b]);
    contents.settle();
  }
  for (std::size_t n = 0; n < contents.size(); ++n) {
    // Each texel as the one before it.
    const std::byte* texels = contents.content(n);
    store->is_uniform.push_back(std::memcmp(texels, texels + texel_bytes, bytes - texel_bytes) == 0 ? 1 : 0);
  }
  if (texel_bytes == 1 || !set_palette(contents, brick_texels, texel_bytes, *store)) {
    store->n_texel_bytes = contents.size() * bytes;
    store->texels.reset();
    store->texels = contents.take();
  }
  report_progress(progress, stage, 1);
  return store;
}

bool is_same(const BrickStore& a, const BrickStore& b) {
  return a.bricks == b.bricks && a.palette == b.palette && a.n_texel_bytes == b.n_texel_bytes &&
         std::memcmp(a.texels.get(), b.texels.get(), a.n_texel_bytes) == 0;
}

}  // namespace recede::detail
