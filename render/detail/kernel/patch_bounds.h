// What the squares of a patch hold, by bounds.
//
// On either triangle of a patch positions, directions and texel coordinates are linear, so over a square they
// lie between its first corner's plus its side times constants. With them come bounds of the heights over the
// square, and with these a box for the displaced points. Directions are made unit length only after they were
// interpolated: heights are stretched by the reciprocals of the least and largest lengths that they can have
// in the square.
#pragma once

#include <recede/render/detail/kernel/height_lanes.h>
#include <recede/render/detail/kernel/patch_points.h>

namespace recede::detail {
namespace {

// Axes for bounds, with a corner of the patch as their origin. Coordinates are products with the axes, which
// need neither be unit vectors nor at right angles, unless lengths of directions are found from them.
struct PatchFrame {
  // The scene's own axes.
  static PatchFrame of_scene() {
    PatchFrame frame;
    for (int axis = 0; axis < 3; ++axis) {
      for (int k = 0; k < 3; ++k) frame.axes[axis][k] = axis == k ? 1 : 0;
      frame.origin[axis] = 0;
    }
    frame.finish();
    return frame;
  }

  // The third axis is the mean direction, across which rough sheets are thinnest; the others are the sides.
  RECEDE_INLINE static PatchFrame of_patch(const PatchPoints& points) {
    PatchFrame frame;
    const Place* p = points.corner;
    const Float8 sum = (p[0] + p[1]) + (p[2] + p[3]), ab = p[1] - p[0], ad = p[3] - p[0];
    for (int axis = 0; axis < 3; ++axis) {
      frame.axes[0][axis] = ab[axis];
      frame.axes[1][axis] = ad[axis];
      frame.axes[2][axis] = sum[k_direction + axis];
      frame.origin[axis] = p[0][axis];
    }
    if (points.patch.most_stretch == 0) frame.straighten();
    frame.finish();
    return frame;
  }

  RECEDE_INLINE Place to_local(const Place& place) const {
    const Float8 p = place - shift_;
    const Float8 x = __builtin_shufflevector(p, p, 0, 0, 0, 0, 4, 4, 4, 4);
    const Float8 y = __builtin_shufflevector(p, p, 1, 1, 1, 1, 5, 5, 5, 5);
    const Float8 z = __builtin_shufflevector(p, p, 2, 2, 2, 2, 6, 6, 6, 6);
    const Float8 local = (x * columns_[0] + y * columns_[1]) + z * columns_[2];
    return __builtin_shufflevector(local, p, 0, 1, 2, 11, 4, 5, 6, 15);
  }

  float axes[3][3], origin[3];

 private:
  static bool make_unit(float* v) {
    const float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    if (!(square > 1e-12f)) return false;
    const float factor = 1 / __builtin_sqrtf(square);
    for (int axis = 0; axis < 3; ++axis) v[axis] *= factor;
    return true;
  }
  // Unit vectors at right angles.
  __attribute__((noinline)) void straighten() {
    float *x = axes[0], *y = axes[1], *z = axes[2];
    if (!make_unit(z)) {
      z[0] = z[1] = 0;
      z[2] = 1;
    }
    const float rise = x[0] * z[0] + x[1] * z[1] + x[2] * z[2];
    for (int axis = 0; axis < 3; ++axis) x[axis] -= rise * z[axis];
    if (!make_unit(x)) {  // any across z
      const int across = __builtin_fabsf(z[0]) < 0.6f ? 0 : 1;
      const float along = z[across];
      for (int axis = 0; axis < 3; ++axis) x[axis] = (axis == across ? 1.0f : 0.0f) - along * z[axis];
      make_unit(x);
    }
    for (int axis = 0; axis < 3; ++axis) {
      const int n = (axis + 1) % 3, m = (axis + 2) % 3;
      y[axis] = z[n] * x[m] - z[m] * x[n];
    }
  }
  RECEDE_INLINE void finish() {
    for (int k = 0; k < 3; ++k)
      columns_[k] = Float8{axes[0][k], axes[1][k], axes[2][k], 0, axes[0][k], axes[1][k], axes[2][k], 0};
    shift_ = Float8{origin[0], origin[1], origin[2], 0, 0, 0, 0, 0};
  }
  Float8 columns_[3], shift_;
};

// Squares in the first triangle, in the second, and those that the diagonal between them cuts in two.
enum SquareKind { k_first, k_second, k_diagonal };

struct Square {
  Place start;  // of the place (i, j), in the patch's frame
  std::uint32_t i, j;
  int level, kind;  // 2^level steps a side
};

struct Ranges4 {
  Float8 least[4], largest[4];
};

// Boxes of four squares: a lane for each, an entry for each axis.
struct Boxes4 {
  Float4 lower[3], upper[3];
};

constexpr float k_rough_root = 5e-4f;    // more than the error of `rough_inverse_root`
constexpr float k_least_square = 0.05f;  // of lengths, below which directions say too little

template <typename Sample>
class PatchBounds {
 public:
  RECEDE_INLINE PatchBounds(const PatchPoints& points, const PatchFrame& frame, const HeightMap<Sample>& map)
      : points_(points), frame_(frame), map_(map) {
    Place local[4];
    for (int k = 0; k < 4; ++k) local[k] = frame.to_local(points.corner[k]);
    const float step = 1 / static_cast<float>(points.side);
    first_ = local[0];
    opposite_ = local[2];
    step_i_[k_first] = (local[1] - local[0]) * step;
    step_j_[k_first] = (local[3] - local[0]) * step;
    step_i_[k_second] = (local[2] - local[3]) * step;
    step_j_[k_second] = (local[2] - local[1]) * step;
    step_i_[k_diagonal] = step_i_[k_first];
    step_j_[k_diagonal] = step_j_[k_first];
    const Float8 zero = all8(0);
    for (int kind = k_first; kind <= k_second; ++kind) {
      least_[kind] = least(zero, step_i_[kind]) + least(zero, step_j_[kind]);
      largest_[kind] = largest(zero, step_i_[kind]) + largest(zero, step_j_[kind]);
    }
    least_[k_diagonal] = least(zero, least(step_i_[0], step_j_[0]));
    largest_[k_diagonal] = largest(zero, largest(step_i_[0], step_j_[0]));
    if (!points.patch.is_single) {
      const Float8 opposite = step_j_[k_first] + step_i_[k_second];
      least_[k_diagonal] = least(least_[k_diagonal], opposite);
      largest_[k_diagonal] = largest(largest_[k_diagonal], opposite);
    }
  }

  RECEDE_INLINE Square square_of(const PatchPart& part) const {
    const std::uint32_t size = 1u << part.level, sum = std::uint32_t{part.i} + part.j;
    const auto i = static_cast<float>(part.i), j = static_cast<float>(part.j);
    if (sum >= points_.side) {
      const auto side = static_cast<float>(points_.side);
      return {opposite_ + ((i - side) * step_i_[k_second] + (j - side) * step_j_[k_second]), part.i, part.j,
              part.level, k_second};
    }
    return {first_ + (i * step_i_[k_first] + j * step_j_[k_first]), part.i, part.j, part.level,
            sum + size < points_.side ? k_first : k_diagonal};
  }

  RECEDE_INLINE Square child(const Square& square, int k) const {
    const int level = square.level - 1;
    const std::uint32_t half = 1u << level;
    constexpr int k_diagonal_kinds[4] = {k_first, k_diagonal, k_diagonal, k_second};
    Place start = square.start;
    if ((k & 1) != 0) start += static_cast<float>(half) * step_i_[square.kind];
    if ((k & 2) != 0) start += static_cast<float>(half) * step_j_[square.kind];
    return {start, square.i + (k & 1 ? half : 0), square.j + (k & 2 ? half : 0), level,
            square.kind == k_diagonal ? k_diagonal_kinds[k] : square.kind};
  }

  // Boxes of a square's four children.
  RECEDE_INLINE Boxes4 boxes_of_children(const Square& square) const {
    const float half = static_cast<float>(1u << (square.level - 1));
    const Float8 i = half * step_i_[square.kind], j = half * step_j_[square.kind];
    const Place starts[4] = {square.start, square.start + i, square.start + j, (square.start + i) + j};
    Ranges4 ranges;
    if (square.kind != k_diagonal) {
      const Float8 lower = half * least_[square.kind], upper = half * largest_[square.kind];
      for (int k = 0; k < 4; ++k) {
        ranges.least[k] = starts[k] + lower;
        ranges.largest[k] = starts[k] + upper;
      }
    } else {
      constexpr int kinds[4] = {k_first, k_diagonal, k_diagonal, k_second};
      for (int k = 0; k < 4; ++k) {
        ranges.least[k] = starts[k] + half * least_[kinds[k]];
        ranges.largest[k] = starts[k] + half * largest_[kinds[k]];
      }
    }
    Range4 extra{all4(3e38f), all4(-3e38f)};
    const bool has_exception =
        points_.exception != nullptr && points_.is_at_border(square.i, square.j, 1u << square.level);
    if (has_exception) extend_children(square, ranges, extra);
    return boxes(ranges, has_exception, extra, false);
  }

  // The box of a square, in all lanes; with `partial` for all fractions of the displacement.
  Boxes4 box_of(const Square& square, bool partial) const {
    const std::uint32_t steps = 1u << square.level;
    const float size = static_cast<float>(steps);
    Ranges4 ranges;
    Range4 extra{all4(3e38f), all4(-3e38f)};
    for (int k = 0; k < 4; ++k) {
      ranges.least[k] = square.start + size * least_[square.kind];
      ranges.largest[k] = square.start + size * largest_[square.kind];
      if (points_.exception != nullptr) extend(square.i, square.j, steps, k, ranges, extra);
    }
    return boxes(ranges, points_.exception != nullptr, extra, partial);
  }

 private:
  // Squared lengths of directions between these bounds of their coordinates.
  static void squares(Float4 least_x, Float4 largest_x, Float4& least_square, Float4& largest_square) {
    const Float4 inner = largest(all4(0), largest(least_x, -largest_x)), outer = largest(largest_x, -least_x);
    least_square += inner * inner;
    largest_square += outer * outer;
  }

  RECEDE_INLINE Boxes4 boxes(Ranges4& ranges, bool has_extra, const Range4& extra, bool partial) const {
    transpose(ranges.least[0], ranges.least[1], ranges.least[2], ranges.least[3]);
    transpose(ranges.largest[0], ranges.largest[1], ranges.largest[2], ranges.largest[3]);
    Range4 samples = map_.ranges(lower_half(ranges.least[k_texel_x]), lower_half(ranges.largest[k_texel_x]),
                                 upper_half(ranges.least[k_texel_x]), upper_half(ranges.largest[k_texel_x]));
    if (has_extra) samples = {least(samples.low, extra.low), largest(samples.high, extra.high)};
    Range4 heights = map_.heights(samples);
    heights = {heights.low - map_.room(), heights.high + map_.room()};
    if (partial) heights = {least(heights.low, all4(0)), largest(heights.high, all4(0))};
    Float4 most = all4(points_.patch.most_stretch), fewest = all4(points_.patch.least_stretch);
    Int4 is_vague = {0, 0, 0, 0};
    if (points_.patch.most_stretch == 0) {
      Float4 least_square = all4(0), largest_square = all4(0);
      for (int axis = 0; axis < 3; ++axis)
        squares(upper_half(ranges.least[axis]), upper_half(ranges.largest[axis]), least_square,
                largest_square);
      is_vague = least_square < k_least_square;
      most = rough_inverse_root(least_square) * (1 + k_rough_root);
      fewest = rough_inverse_root(largest_square) * (1 - k_rough_root);
    }
    const Float4 low = least(heights.low * most, heights.low * fewest);
    const Float4 high = largest(heights.high * most, heights.high * fewest);
    Boxes4 result = moved(ranges, join(low, low), join(high, high));
    if (sign_bits(is_vague) != 0) grow(ranges, heights, is_vague, result);
    return result;
  }

  // Positions and directions each lie between their least and largest coordinates.
  static RECEDE_INLINE Boxes4 moved(const Ranges4& ranges, Float8 low, Float8 high) {
    Boxes4 result;
    for (int axis = 0; axis < 3; ++axis) {
      const Float8 directions =
          __builtin_shufflevector(ranges.least[axis], ranges.largest[axis], 4, 5, 6, 7, 12, 13, 14, 15);
      const Float8 a = directions * low, b = directions * high;
      const Float8 least_moves = least(a, b), largest_moves = largest(a, b);
      result.lower[axis] =
          lower_half(ranges.least[axis]) + least(lower_half(least_moves), upper_half(least_moves));
      result.upper[axis] =
          lower_half(ranges.largest[axis]) + largest(lower_half(largest_moves), upper_half(largest_moves));
    }
    return result;
  }

  // Whatever the directions are, points move by no more than the height.
  __attribute__((noinline)) static void grow(const Ranges4& ranges, const Range4& heights, Int4 is_vague,
                                             Boxes4& boxes) {
    const Float4 most = largest(heights.high, -heights.low);
    for (int k = 0; k < 4; ++k) {
      if (is_vague[k] == 0) continue;
      for (int axis = 0; axis < 3; ++axis) {
        boxes.lower[axis][k] = ranges.least[axis][k] - most[k];
        boxes.upper[axis][k] = ranges.largest[axis][k] + most[k];
      }
    }
  }

  __attribute__((noinline)) void extend_children(const Square& square, Ranges4& ranges, Range4& extra) const {
    const std::uint32_t half = 1u << (square.level - 1);
    for (int k = 0; k < 4; ++k)
      extend(square.i + (k & 1 ? half : 0), square.j + (k & 2 ? half : 0), half, k, ranges, extra);
  }

  // Adds what exceptions along a square bring: points of lines that lie further along them, and heights by
  // other texel coordinates.
  void extend(std::uint32_t i, std::uint32_t j, std::uint32_t size, int lane, Ranges4& ranges,
              Range4& extra) const {
    const std::uint32_t side = points_.side, i1 = i + size, j1 = j + size;
    const auto add = [&](int line, std::uint32_t m0, std::uint32_t m1) {
      if (points_.is_exceptional(line)) extend_by_line(line, m0, m1, lane, ranges, extra);
    };
    if (j == 0) add(k_line_ab, i, i1);
    if (i1 == side) add(k_line_bc, j, j1);
    if (j1 == side) add(k_line_dc, i, i1);
    if (i == 0) add(k_line_ad, j, j1);
    if (i + j1 == side) add(k_line_bd, j, j1);
    if (i1 + j1 == side) add(k_line_bd, j1, j1);
    const bool at[4] = {i == 0 && j == 0, i1 == side && j == 0, i1 == side && j1 == side,
                        i == 0 && j1 == side};
    for (int k = 0; k < 4; ++k) {
      if (!at[k] || (points_.exception->foreign_corners >> k & 1) == 0) continue;
      const float x = points_.exception->corner_x[k], y = points_.exception->corner_y[k];
      extend_heights(x, x, y, y, lane, extra);
    }
  }

  // Points between the steps m0 and m1 stay on the line between the nearest ones that are kept around them.
  void extend_by_line(int line, std::uint32_t m0, std::uint32_t m1, int lane, Ranges4& ranges,
                      Range4& extra) const {
    const std::uint32_t step = 1u << points_.exception->coarsening[line];
    const Place from = points_.line_point(line, m0 / step * step);
    const Place to = points_.line_point(line, (m1 + step - 1) / step * step);
    const Float8 lower = least(from, to), upper = largest(from, to);
    extend_heights(lower[k_texel_x], upper[k_texel_x], lower[k_texel_y], upper[k_texel_y], lane, extra);
    const Float8 a = frame_.to_local(from), b = frame_.to_local(to);
    Float8 low = least(ranges.least[lane], least(a, b)), high = largest(ranges.largest[lane], largest(a, b));
    low[k_texel_x] = ranges.least[lane][k_texel_x];
    low[k_texel_y] = ranges.least[lane][k_texel_y];
    high[k_texel_x] = ranges.largest[lane][k_texel_x];
    high[k_texel_y] = ranges.largest[lane][k_texel_y];
    ranges.least[lane] = low;
    ranges.largest[lane] = high;
  }

  void extend_heights(float x_min, float x_max, float y_min, float y_max, int lane, Range4& extra) const {
    float low = extra.low[lane], high = extra.high[lane];
    map_.extend(x_min, x_max, y_min, y_max, low, high);
    extra.low[lane] = low;
    extra.high[lane] = high;
  }

  const PatchPoints& points_;
  const PatchFrame& frame_;
  const HeightMap<Sample>& map_;
  Place first_, opposite_;  // corners a and c
  // A step along i and along j; where a square of side 1 begins and ends from its first corner. By kind.
  Float8 step_i_[3], step_j_[3], least_[3], largest_[3];
};

}  // namespace
}  // namespace recede::detail
