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

struct BrickStore {
  std::vector<const void*> bricks;       ///< texels of each brick; bricks that are alike have the same
  std::vector<std::uint8_t> is_uniform;  ///< of each brick
  std::vector<std::unique_ptr<std::byte[]>> pieces;  ///< of memory
  std::size_t texel_bytes = 0;                       ///< in all pieces

  std::size_t n_bytes() const {
    return texel_bytes + bricks.size() * sizeof(void*) + is_uniform.size() + pieces.size() * sizeof(void*);
  }
};

/// Writes the texels of a brick; called from several threads.
using FillBrick = std::function<void(std::size_t brick, std::byte* to)>;

/// Keeps what bricks are filled with, each content once, in an order that doesn't depend on threads. Works on
/// some hundred bricks at a time. Passes on what `fill` throws, and `Cancelled`.
std::shared_ptr<const BrickStore> make_brick_store(std::size_t n_bricks, std::size_t brick_texels,
                                                   std::size_t texel_bytes, const FillBrick& fill,
                                                   Progress* progress, std::string_view stage);

}  // namespace recede::detail
