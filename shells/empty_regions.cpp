#include <recede/shells/detail/empty_regions.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {

EmptyRegions::EmptyRegions(const VolumeTexture& texture)
    : size_(texture.size), is_periodic_(texture.is_periodic) {
  std::size_t n = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    counts_[axis] = (size_[axis] - 1) / k_side + 1;
    n *= static_cast<std::size_t>(counts_[axis]);
  }
  is_empty_.assign(n, 1);
  constexpr std::uint8_t k_half = 128;
  const BrickGrid<std::uint8_t>& opacity = texture.opacity;
  for (std::size_t brick = 0; brick < opacity.n_bricks(); ++brick) {
    TexelBox full = opacity.box(brick);
    if (const std::optional<std::uint8_t> value = opacity.uniform_value(brick)) {
      if (*value >= k_half) mark(full);
      continue;
    }
    // What is inside, of the brick.
    const TexelBox box = full;
    full = {box.last, box.first};
    for_each_texel(box, [&](int i, int j, int k) {
      if (opacity.at(i, j, k) < k_half) return;
      const std::array<int, 3> texel{i, j, k};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        full.first[axis] = std::min(full.first[axis], texel[axis]);
        full.last[axis] = std::max(full.last[axis], texel[axis] + 1);
      }
    });
    if (full.first[0] < full.last[0]) mark(full);
  }
}

// Cubes that these texels are in or near to aren't empty.
void EmptyRegions::mark(const TexelBox& box) {
  const auto floor_of_share = [](int cells) {
    return cells >= 0 ? cells / k_side : -((k_side - 1 - cells) / k_side);
  };
  const int turns = is_periodic_ ? 1 : 0;
  for (int turn = 0; turn < (1 + 2 * turns) * (1 + 2 * turns); ++turn) {
    const std::array<int, 3> moved{(turn % (1 + 2 * turns) - turns) * size_[0],
                                   (turn / (1 + 2 * turns) - turns) * size_[1], 0};
    TexelBox cubes;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int first = box.first[axis] + moved[axis], last = box.last[axis] - 1 + moved[axis];
      // A cube's cells reach to the first texel behind it.
      cubes.first[axis] = std::max(floor_of_share(first - k_margin + k_side - 1) - 1, 0);
      cubes.last[axis] = std::min(floor_of_share(last + k_margin) + 1, counts_[axis]);
    }
    for_each_texel(cubes, [&](int i, int j, int k) { is_empty_[number(i, j, k)] = 0; });
  }
}

double EmptyRegions::free_length(const Vec3& place, const Vec3& move) const {
  std::array<double, 3> at{};
  std::array<int, 3> cube{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double turns = place[static_cast<int>(axis)];
    if (axis < 2 && is_periodic_) turns -= std::floor(turns);
    at[axis] = turns * size_[axis] - 0.5;
    cube[axis] = static_cast<int>(std::clamp(at[axis], 0.0, size_[axis] - 1.0)) / k_side;
  }
  if (is_empty_[number(cube[0], cube[1], cube[2])] == 0) return 0;
  double length = std::numeric_limits<double>::infinity();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double rate = move[static_cast<int>(axis)] * size_[axis];
    if (rate == 0) continue;
    const bool repeats = axis < 2 && is_periodic_, is_last = cube[axis] + 1 == counts_[axis];
    // Beyond the outermost texels nothing changes.
    if (!repeats && (rate > 0 ? is_last : cube[axis] == 0)) continue;
    double end = (cube[axis] + (rate > 0 ? 1 : 0)) * k_side;
    if (repeats && rate > 0 && is_last) end = size_[axis] - 0.5;
    if (repeats && rate < 0 && cube[axis] == 0) end = -0.5;
    length = std::min(length, (end - at[axis]) / rate);
  }
  return std::max(length, 0.0);
}

}  // namespace recede::detail
