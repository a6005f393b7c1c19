// Points of a displaced patch on its virtual subdivision, before they are displaced.
#pragma once

#include <recede/render/detail/displaced_kernel.h>
#include <recede/render/detail/kernel/float_lanes.h>

namespace recede::detail {
namespace {

// A point: position and texel column, then direction and texel row.
using Place = Float8;
constexpr int k_texel_x = 3, k_direction = 4, k_texel_y = 7;

inline Place middle(const Place& a, const Place& b) { return (a + b) * 0.5f; }

inline PatchPart part_of(const PatchArrays& arrays, std::uint32_t number) {
  if (arrays.parts != nullptr) return arrays.parts[number];
  return {number, 0, 0, arrays.patches[number].level};
}

// Nine points of two by two squares, row by row from a.
struct LeafPlaces {
  Place at[9];
  std::uint32_t i[9], j[9];  // where in the patch; those that moved along a line are where they moved to
};

// Points come from halving again and again: every one is the middle of a side of one of the triangles around
// it, so that along a common line two patches find the same points bit for bit, at any level.
class PatchPoints {
 public:
  RECEDE_INLINE PatchPoints(const PatchArrays& arrays, std::uint32_t number)
      : patch(arrays.patches[number]),
        exception(patch.exception == k_no_exception ? nullptr : &arrays.exceptions[patch.exception]),
        side(1u << patch.level) {
    for (int k = 0; k < 4; ++k) {
      const DisplacedVertex& vertex = arrays.vertices[patch.vertices[k]];
      __builtin_memcpy(&corner[k], &vertex, sizeof(Place));
      corner[k][k_texel_x] = patch.x[k];
      corner[k][k_texel_y] = patch.y[k];
    }
  }

  // Two by two squares from the place (i, j), both even, without exceptions; level at least 1.
  void find_leaf(std::uint32_t i, std::uint32_t j, LeafPlaces& leaf) const {
    Place* p = leaf.at;
    Place a = corner[0], b = corner[1], c = corner[2], d = corner[3];
    for (int level = patch.level;; --level) {
      p[0] = a;
      p[1] = middle(a, b);
      p[2] = b;
      p[3] = middle(a, d);
      p[4] = middle(b, d);
      p[5] = middle(b, c);
      p[6] = d;
      p[7] = middle(d, c);
      p[8] = c;
      if (level == 1) break;
      const Place* q = p + (i >> (level - 1) & 1) + 3 * (j >> (level - 1) & 1);
      a = q[0];
      b = q[1];
      d = q[3];
      c = q[4];
    }
    for (std::uint32_t k = 0; k < 9; ++k) {
      leaf.i[k] = i + k % 3;
      leaf.j[k] = j + k / 3;
    }
  }

  // The only square of a patch without subdivision; the other three have no area.
  void find_whole(LeafPlaces& leaf) const {
    constexpr int corners[9] = {0, 1, 1, 3, 2, 2, 3, 2, 2};
    for (int k = 0; k < 9; ++k) {
      leaf.at[k] = corner[corners[k]];
      leaf.i[k] = k % 3 != 0;
      leaf.j[k] = k / 3 != 0;
    }
  }

  // The place (i, j), with the border's exceptions.
  Place point(std::uint32_t i, std::uint32_t j) const {
    Place result = corner[j == 0 ? i & 1 : 3 - (i & 1)];
    if (patch.level > 0) {
      LeafPlaces leaf;
      const std::uint32_t i0 = i == side ? side - 2 : i & ~1u, j0 = j == side ? side - 2 : j & ~1u;
      find_leaf(i0, j0, leaf);
      result = leaf.at[i - i0 + 3 * (j - j0)];
    }
    if (exception != nullptr) take_exceptions(result, i, j);
    return result;
  }

  // Only squares along the border may have exceptions; and where there is one triangle, along its diagonal.
  bool is_at_border(std::uint32_t i, std::uint32_t j, std::uint32_t size) const {
    return i == 0 || j == 0 || i + size == side || j + size == side ||
           (patch.is_single && i + j + 2 * size >= side);
  }

  bool is_exceptional(int line) const {
    return (exception->foreign_lines >> line & 1) != 0 || exception->coarsening[line] != 0;
  }

  // A point on the border becomes what all patches around it agree on.
  void take_exceptions(Place& point, std::uint32_t& i, std::uint32_t& j) const {
    const int number = corner_at(i, j);
    if (number >= 0) {
      if ((exception->foreign_corners >> number & 1) == 0) return;
      point[k_texel_x] = exception->corner_x[number];
      point[k_texel_y] = exception->corner_y[number];
      return;
    }
    const int line = line_at(i, j);
    if (line < 0 || !is_exceptional(line)) return;
    const std::uint32_t step = 1u << exception->coarsening[line];
    std::uint32_t& along = line == k_line_ab || line == k_line_dc ? i : j;
    along = (along + step / 2) / step * step;
    if (line == k_line_bd) i = side - j;
    point = line_point(line, along);
    if (corner_at(i, j) >= 0) take_exceptions(point, i, j);
  }

  // The point at step m of a line, with texel coordinates as the line's owner has them.
  Place line_point(int line, std::uint32_t m) const {
    constexpr int from[k_patch_lines] = {0, 1, 3, 0, 1}, to[k_patch_lines] = {1, 2, 2, 3, 3};
    Place a = corner[from[line]], b = corner[to[line]];
    if ((exception->foreign_lines >> line & 1) != 0) {
      a[k_texel_x] = exception->line_x[line][0];
      a[k_texel_y] = exception->line_y[line][0];
      b[k_texel_x] = exception->line_x[line][1];
      b[k_texel_y] = exception->line_y[line][1];
    }
    if (m == side) return b;
    for (std::uint32_t half = side >> 1, at = 0; m != at; half >>= 1) {
      const Place c = middle(a, b);
      if (m < at + half) {
        b = c;
      } else {
        a = c;
        at += half;
      }
    }
    return a;
  }

  const DisplacedPatch& patch;
  const PatchException* exception;
  std::uint32_t side;
  Place corner[4];  // a, b, c, d

 private:
  int corner_at(std::uint32_t i, std::uint32_t j) const {
    if (j == 0) return i == 0 ? 0 : i == side ? 1 : -1;
    if (j == side) return i == 0 ? 3 : i == side && patch.is_single == 0 ? 2 : -1;
    return -1;
  }
  int line_at(std::uint32_t i, std::uint32_t j) const {
    if (j == 0) return k_line_ab;
    if (i == 0) return k_line_ad;
    if (patch.is_single) return i + j == side ? k_line_bd : -1;
    return i == side ? k_line_bc : j == side ? k_line_dc : -1;
  }
};

}  // namespace
}  // namespace recede::detail
