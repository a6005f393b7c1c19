// Keys by J. Skilling: Programming the Hilbert Curve (AIP Conference Proceedings 707, 2004), without
// branches, as no processor would guess them.
#include <recede/shells/detail/near_order.h>

#include <array>

namespace recede::detail {
namespace {

constexpr unsigned k_bits = 10;
constexpr std::uint32_t k_cells = 1u << k_bits;

/// Place along the curve, of the cell `x`.
std::uint32_t hilbert_key(std::array<std::uint32_t, 3> x) {
  for (std::uint32_t bit = k_cells / 2; bit > 1; bit /= 2) {
    for (std::uint32_t& coordinate : x) {
      // Where the bit is set the lower ones of the first coordinate are inverted, else exchanged with it.
      const std::uint32_t set = 0u - static_cast<std::uint32_t>((coordinate & bit) != 0), below = bit - 1;
      const std::uint32_t exchanged = (x[0] ^ coordinate) & below & ~set;
      x[0] ^= exchanged | (below & set);
      coordinate ^= &coordinate == x.data() ? 0u : exchanged;
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t flips = 0;
  for (std::uint32_t bit = k_cells / 2; bit > 1; bit /= 2)
    flips ^= (bit - 1) & (0u - static_cast<std::uint32_t>((x[2] & bit) != 0));
  std::uint32_t key = 0;
  for (unsigned bit = k_bits; bit-- > 0;) {
    for (const std::uint32_t coordinate : x) key = 2 * key + ((coordinate ^ flips) >> bit & 1u);
  }
  return key;
}

/// By counting, one digit of the keys at a time, the lowest first.
void sort_by_keys(const std::vector<std::uint32_t>& keys, std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> sorted(order.size());
  for (unsigned shift = 0; shift < 3 * k_bits; shift += k_bits) {
    std::array<std::uint32_t, k_cells + 1> first{};
    for (const std::uint32_t key : keys) ++first[(key >> shift) % k_cells + 1];
    for (std::size_t digit = 1; digit <= k_cells; ++digit) first[digit] += first[digit - 1];
    for (const std::uint32_t i : order) sorted[first[(keys[i] >> shift) % k_cells]++] = i;
    order.swap(sorted);
  }
}

}  // namespace

std::vector<std::uint32_t> near_order(std::span<const Vec3> points) {
  Box3 box;
  for (const Vec3& x : points) {
    if (x.allFinite()) box.extend(x);
  }
  const double scale = box.isEmpty() ? 0 : (k_cells - 1) / box.sizes().maxCoeff();
  std::vector<std::uint32_t> keys(points.size()), order(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::array<std::uint32_t, 3> cell{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      const double place = scale * (points[i][axis] - box.min()[axis]);
      // Neither holds for what isn't a number.
      if (place > 0 && place < k_cells) cell[k] = static_cast<std::uint32_t>(place);
    }
    keys[i] = hilbert_key(cell);
    order[i] = static_cast<std::uint32_t>(i);
  }
  sort_by_keys(keys, order);
  return order;
}

}  // namespace recede::detail
