// What brick grids hold, as bytes.
#pragma once

#include <recede/geometry/progress.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

namespace recede::detail {

/// The same for the same texels, byte by byte.
struct BrickStore {
  std::vector<std::uint32_t> bricks{};     ///< number of each brick's content, in the order of appearance
  std::vector<std::uint8_t> is_uniform{};  ///< of contents: all texels are alike
  std::unique_ptr<std::byte[]> texels{};   ///< of contents, one after the other
  std::size_t n_texel_bytes = 0;
  /// Where no more than 256 values occur in texels of several bytes: these values, which texels are numbers
  /// of, a byte each.
  std::vector<std::byte> palette{};

  std::size_t n_bytes() const {
    return n_texel_bytes + palette.size() + bricks.size() * sizeof(std::uint32_t) + is_uniform.size();
  }
};

/// Writes the texels of a brick; called from several threads.
using FillBrick = std::function<void(std::size_t brick, std::byte* to)>;

/// Keeps what bricks are filled with, each content once. Works on some thousand bricks at a time. Passes on
/// what `fill` throws, and `Cancelled`.
std::shared_ptr<const BrickStore> make_brick_store(std::size_t n_bricks, std::size_t brick_texels,
                                                   std::size_t texel_bytes, const FillBrick& fill,
                                                   Progress* progress, std::string_view stage);

bool is_same(const BrickStore& a, const BrickStore& b);

}  // namespace recede::detail
