// Grids of texels that are mostly the same over large parts: in bricks, each content of which is kept once.
//
// Lefebvre, Hornus and Neyret 2005, "Octree Textures on the GPU", and Crassin et al. 2009, "GigaVoxels", have
// bricks in trees; here a flat table leads to them, which costs 4 bytes for 64 texels and a single look.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/shells/detail/brick_store.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace recede {

/// Texels from `first` to before `last` along s, t and r.
struct TexelBox {
  std::array<int, 3> first{0, 0, 0}, last{0, 0, 0};

  int length(std::size_t axis) const { return last[axis] - first[axis]; }
  std::size_t n_texels() const {
    return static_cast<std::size_t>(length(0)) * static_cast<std::size_t>(length(1)) *
           static_cast<std::size_t>(length(2));
  }
};

/// `visit(i, j, k)` of all texels, i fastest.
template <typename Visit>
void for_each_texel(const TexelBox& box, Visit&& visit) {
  for (int k = box.first[2]; k < box.last[2]; ++k)
    for (int j = box.first[1]; j < box.last[1]; ++j)
      for (int i = box.first[0]; i < box.last[0]; ++i) visit(i, j, k);
}

/// Copies share what they hold, which never changes: a grid is edited by making another one.
template <typename Texel>
class BrickGrid {
  static_assert(std::is_trivially_copyable_v<Texel>);

 public:
  static constexpr int k_side = 4;  ///< texels of a brick along each axis; fewer at a grid's ends

  /// What fills a brick while a grid is made.
  class Brick {
   public:
    const TexelBox& box() const { return box_; }
    Texel& at(int i, int j, int k) {
      return texels_[static_cast<std::size_t>(i - box_.first[0] +
                                              k_side * (j - box_.first[1] + k_side * (k - box_.first[2])))];
    }
    void fill(const Texel& value) { texels_.fill(value); }
    /// With what all texels in a box of a grid are, if the bricks around the box are alike; else nothing.
    bool fill_if_alike(const BrickGrid& grid, const TexelBox& box) {
      const std::optional<Texel> value = grid.uniform_value(box);
      if (value) fill(*value);
      return value.has_value();
    }
    /// With what a grid of the same size has there.
    void copy(const BrickGrid& grid) {
      for (int k = box_.first[2]; k < box_.last[2]; ++k)
        for (int j = box_.first[1]; j < box_.last[1]; ++j)
          grid.copy_row(box_.first[0], box_.last[0], j, k, &at(box_.first[0], j, k));
    }

   private:
    friend class BrickGrid;
    TexelBox box_;
    std::array<Texel, k_side * k_side * k_side> texels_;
  };

  BrickGrid() = default;
  /// All texels alike.
  BrickGrid(const std::array<int, 3>& size, const Texel& value)
      : BrickGrid(make(size, [&](Brick& brick) { brick.fill(value); })) {}

  /// `fill` gets each brick once, with texels of no meaning, in any order and from several threads; the grid
  /// doesn't depend on these. Sizes are at least 1. Passes on what `fill` throws, and `Cancelled`.
  template <typename Fill>
  static BrickGrid make(const std::array<int, 3>& size, Fill&& fill, Progress* progress = nullptr,
                        std::string_view stage = {}) {
    BrickGrid grid;
    grid.set_size(size);
    const detail::FillBrick fill_bytes = [&](std::size_t number, std::byte* to) {
      Brick brick;
      brick.box_ = grid.box(number);
      fill(brick);
      grid.pack(brick, to);
    };
    grid.store_ = detail::make_brick_store(grid.n_bricks(), grid.brick_texels_, sizeof(Texel), fill_bytes,
                                           progress, stage);
    return grid;
  }

  /// From a list of all texels, s fastest, then t, then r, as long as the size says.
  static BrickGrid from_dense(const std::array<int, 3>& size, std::span<const Texel> texels) {
    const auto row = static_cast<std::size_t>(size[0]), layer = row * static_cast<std::size_t>(size[1]);
    return make(size, [&](Brick& brick) {
      for_each_texel(brick.box(), [&](int i, int j, int k) {
        brick.at(i, j, k) = texels[static_cast<std::size_t>(i) + row * static_cast<std::size_t>(j) +
                                   layer * static_cast<std::size_t>(k)];
      });
    });
  }
  /// All texels, s fastest, then t, then r.
  std::vector<Texel> to_dense() const {
    std::vector<Texel> texels(n_texels());
    copy_to({{0, 0, 0}, size_}, texels.data());
    return texels;
  }

  const std::array<int, 3>& size() const { return size_; }
  bool empty() const { return !store_; }
  std::size_t n_texels() const { return TexelBox{{0, 0, 0}, size_}.n_texels(); }
  /// Memory of texels and of the table of bricks. Texels of several bytes take one where no more than 256
  /// values occur in the grid.
  std::size_t n_bytes() const { return store_ ? store_->n_bytes() : 0; }

  Texel at(int i, int j, int k) const { return texel(place_of(i, j, k)); }
  Texel at(const std::array<int, 3>& cell) const { return at(cell[0], cell[1], cell[2]); }
  /// Of the places that two texels span: bit 0 of a corner says which i is whose, bit 1 which j, bit 2 which
  /// k.
  std::array<Texel, 8> corners(const std::array<int, 3>& a, const std::array<int, 3>& b) const {
    std::array<Texel, 8> texels;
    const bool is_in_one = (((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) & ~k_low) == 0;
    if (is_in_one) {
      const std::ptrdiff_t at = place_of(a[0], a[1], a[2]), s = b[0] - a[0], t = row_ * (b[1] - a[1]),
                           r = layer_ * (b[2] - a[2]);
      texels = {texel(at),     texel(at + s),     texel(at + t),     texel(at + s + t),
                texel(at + r), texel(at + s + r), texel(at + t + r), texel(at + s + t + r)};
    } else {
      const auto brick = [](int i) { return static_cast<unsigned>(i) / static_cast<unsigned>(k_side); };
      const std::array<std::size_t, 2> s{brick(a[0]), brick(b[0])},
          t{counts_[0] * brick(a[1]), counts_[0] * brick(b[1])},
          r{counts_[0] * counts_[1] * brick(a[2]), counts_[0] * counts_[1] * brick(b[2])};
      const std::array<std::ptrdiff_t, 2> in_s{a[0] & k_low, b[0] & k_low},
          in_t{row_ * (a[1] & k_low), row_ * (b[1] & k_low)},
          in_r{layer_ * (a[2] & k_low), layer_ * (b[2] & k_low)};
      const std::uint32_t* bricks = store_->bricks.data();
      for (std::size_t c = 0; c < 8; ++c) {
        const std::size_t x = c & 1, y = (c >> 1) & 1, z = c >> 2;
        texels[c] = texel(static_cast<std::ptrdiff_t>(bricks[s[x] + t[y] + r[z]] * brick_texels_) + in_s[x] +
                          in_t[y] + in_r[z]);
      }
    }
    return texels;
  }
  /// Copies a part of the grid, i fastest, then j, then k.
  void copy_to(const TexelBox& box, Texel* to) const {
    for (int k = box.first[2]; k < box.last[2]; ++k)
      for (int j = box.first[1]; j < box.last[1]; ++j, to += box.length(0))
        copy_row(box.first[0], box.last[0], j, k, to);
  }

  /// Bricks are numbered along s, then t, then r.
  std::size_t n_bricks() const { return counts_[0] * counts_[1] * counts_[2]; }
  std::size_t number_of(const Brick& brick) const {
    const std::array<int, 3>& first = brick.box().first;
    return brick_number(first[0] / k_side, first[1] / k_side, first[2] / k_side);
  }
  TexelBox box(std::size_t brick) const {
    const std::array<std::size_t, 3> at{brick % counts_[0], brick / counts_[0] % counts_[1],
                                        brick / counts_[0] / counts_[1]};
    TexelBox box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.first[axis] = static_cast<int>(at[axis]) * k_side;
      box.last[axis] = std::min(size_[axis] - box.first[axis], k_side) + box.first[axis];
    }
    return box;
  }
  /// What all texels of a brick are, if they are alike.
  std::optional<Texel> uniform_value(std::size_t brick) const {
    const std::uint32_t content = store_->bricks[brick];
    if (store_->is_uniform[content] == 0) return std::nullopt;
    return texel(static_cast<std::ptrdiff_t>(content * brick_texels_));
  }
  /// What all texels in a box are, if the bricks around it are alike.
  std::optional<Texel> uniform_value(const TexelBox& box) const {
    std::optional<Texel> value;
    for (int k = box.first[2] / k_side; k <= (box.last[2] - 1) / k_side; ++k) {
      for (int j = box.first[1] / k_side; j <= (box.last[1] - 1) / k_side; ++j) {
        for (int i = box.first[0] / k_side; i <= (box.last[0] - 1) / k_side; ++i) {
          const std::optional<Texel> here = uniform_value(brick_number(i, j, k));
          if (!here || (value && !(*here == *value))) return std::nullopt;
          value = here;
        }
      }
    }
    return value;
  }

  /// Whether they hold the same.
  friend bool operator==(const BrickGrid& a, const BrickGrid& b) {
    if (a.size_ != b.size_ || a.empty() != b.empty()) return false;
    return a.store_ == b.store_ || detail::is_same(*a.store_, *b.store_);
  }

 private:
  static constexpr int k_low = k_side - 1;
  static_assert((k_side & k_low) == 0);

  void set_size(const std::array<int, 3>& size) {
    size_ = size;
    for (std::size_t axis = 0; axis < 3; ++axis)
      counts_[axis] = (static_cast<std::size_t>(size[axis]) + k_low) / k_side;
    // Of thin grids bricks are as thin.
    row_ = std::min(size[0], k_side);
    layer_ = row_ * std::min(size[1], k_side);
    brick_texels_ = static_cast<std::size_t>(layer_ * std::min(size[2], k_side));
  }
  std::size_t brick_number(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           counts_[0] * (static_cast<std::size_t>(j) + counts_[1] * static_cast<std::size_t>(k));
  }
  // Among the texels that are kept.
  std::ptrdiff_t place_of(int i, int j, int k) const {
    const auto side = static_cast<unsigned>(k_side);
    const std::size_t brick =
        static_cast<unsigned>(i) / side +
        counts_[0] * (static_cast<unsigned>(j) / side + counts_[1] * (static_cast<unsigned>(k) / side));
    return static_cast<std::ptrdiff_t>(store_->bricks[brick] * brick_texels_) + (i & k_low) +
           row_ * (j & k_low) + layer_ * (k & k_low);
  }
  Texel texel(std::ptrdiff_t place) const {
    if constexpr (sizeof(Texel) > 1) {
      if (!store_->palette.empty())
        return reinterpret_cast<const Texel*>(store_->palette.data())[std::to_integer<std::size_t>(
            store_->texels[static_cast<std::size_t>(place)])];
    }
    return reinterpret_cast<const Texel*>(store_->texels.get())[place];
  }
  void copy_row(int first, int last, int j, int k, Texel* to) const {
    for (int i = first; i < last;) {
      const int end = std::min(last, (i | k_low) + 1);
      for (std::ptrdiff_t place = place_of(i, j, k); i < end; ++i) *to++ = texel(place++);
    }
  }
  // Beyond the grid's end a brick goes on as there, so that what is alike in the grid is alike in memory.
  void pack(Brick& brick, std::byte* to) const {
    const TexelBox& box = brick.box_;
    for (int k = 0; k < std::min(size_[2], k_side); ++k) {
      for (int j = 0; j < std::min(size_[1], k_side); ++j) {
        const int from_j = std::min(box.first[1] + j, box.last[1] - 1),
                  from_k = std::min(box.first[2] + k, box.last[2] - 1);
        const Texel* row = &brick.at(box.first[0], from_j, from_k);
        for (int i = 0; i < row_; ++i, to += sizeof(Texel))
          std::memcpy(to, row + std::min(i, box.length(0) - 1), sizeof(Texel));
      }
    }
  }

  std::array<int, 3> size_{0, 0, 0};
  std::array<std::size_t, 3> counts_{0, 0, 0};
  int row_ = 0, layer_ = 0;  // texels from a row and a layer of a brick to the next
  std::size_t brick_texels_ = 0;
  std::shared_ptr<const detail::BrickStore> store_;
};

}  // namespace recede
