// The search of a ray in a displaced patch: down its subdivision like a quadtree, the nearest squares first.
#pragma once

#include <recede/render/detail/kernel/patch_bounds.h>
#include <recede/render/detail/kernel/small_triangle.h>

namespace recede::detail {
namespace {

inline float dot3(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The sum of an axis' coordinates: at least its length.
inline float size_of_axis(const float* axis) {
  return (__builtin_fabsf(axis[0]) + __builtin_fabsf(axis[1])) + __builtin_fabsf(axis[2]);
}

// A ray against boxes in a patch's frame.
class BoxRay {
 public:
  RECEDE_INLINE BoxRay(const PatchRayQuery& ray, const PatchFrame& frame) {
    float origin[3], far = 0;
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = ray.origin[axis] - frame.origin[axis];
      const float size = __builtin_fabsf(origin[axis]);
      far = size > far ? size : far;
    }
    const float room = k_room * (1 + far);
    for (int axis = 0; axis < 3; ++axis) {
      const float* const along = frame.axes[axis];
      const float o = dot3(origin, along), d = dot3(ray.direction, along), size = size_of_axis(along);
      const bool is_there = size > k_no_size;
      origin_high_[axis] = all4(is_there ? o + room * size : k_far);
      origin_low_[axis] = all4(is_there ? o - room * size : -k_far);
      inverse_[axis] = all4(is_there ? inverse(d) : k_far);
    }
  }

  // Bit k: the ray meets box k with t from t_min to t_max. `enter` is where.
  RECEDE_INLINE unsigned meet(const Boxes4& boxes, float t_min, float t_max, Float4& enter) const {
    enter = all4(t_min);
    Float4 leave = all4(t_max);
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 a = (boxes.lower[axis] - origin_high_[axis]) * inverse_[axis];
      const Float4 b = (boxes.upper[axis] - origin_low_[axis]) * inverse_[axis];
      enter = largest(enter, least(a, b));
      leave = least(leave, largest(a, b));
    }
    return sign_bits(enter <= leave * k_late);
  }

  static constexpr float k_late = 1 + 6e-7f;  // t of boxes and of triangles are rounded differently
  // Some steps of float at the size of a scene: points, boxes and rays are rounded differently.
  static constexpr float k_room = 2e-6f;
  // Sides shorter than that bound nothing: with `k_far` as origins and reciprocal, their boxes are endless.
  static constexpr float k_no_size = 1e-12f, k_far = 1e30f;
  static float inverse(float direction) {
    constexpr float k_flat = 1e-20f;
    return 1 / (__builtin_fabsf(direction) > k_flat ? direction : direction < 0 ? -k_flat : k_flat);
  }

 private:
  Float4 origin_high_[3], origin_low_[3], inverse_[3];  // in all lanes
};

// The small triangles of a square of the last but one level, and rays against them.
template <typename Sample>
class Leaf {
 public:
  // Two by two squares of small triangles, or the one of a patch without subdivision.
  Leaf(const PatchPoints& points, const HeightMap<Sample>& map, const Square& square)
      : patch_(points), square_(square) {
    if (square.level == 0) {
      points.find_whole(places_);
    } else {
      points.find_leaf(square.i, square.j, places_);
    }
    if (points.exception != nullptr && points.is_at_border(square.i, square.j, 1u << square.level)) {
      for (int k = 0; k < 9; ++k) points.take_exceptions(places_.at[k], places_.i[k], places_.j[k]);
    }
    displace_leaf(places_, map, points_);
  }

  template <bool k_any>
  void test(PatchRayQuery& ray) const {
    const WatertightLine line(ray);
    const LeafCover cover(line, points_);
    const unsigned squares = square_.level == 0 ? 0b00001 : 0b11011;
    for (unsigned lower = cover.lower & squares; lower != 0; lower &= lower - 1) {
      const int k = __builtin_ctz(lower);
      test_triangle<k_any>(line, {k, k, k + 1, k + 3, 0}, ray);
    }
    for (unsigned upper = cover.upper & squares; upper != 0; upper &= upper - 1) {
      const int k = __builtin_ctz(upper);
      test_triangle<k_any>(line, {k, k + 4, k + 3, k + 1, 1}, ray);
    }
  }

 private:
  // One of the two halves of the small square at point k.
  struct Half {
    int k, a, b, c;
    std::uint32_t upper;
  };

  template <bool k_any>
  void test_triangle(const WatertightLine& line, const Half& half, PatchRayQuery& ray) const {
    const std::uint32_t i = square_.i + static_cast<std::uint32_t>(half.k % 3),
                        j = square_.j + static_cast<std::uint32_t>(half.k / 3);
    if (patch_.patch.is_single && i + j + 1 + half.upper > patch_.side) return;
    const std::uint32_t number = 2 * (i + patch_.side * j) + half.upper;
    if (number == ray.left_out) return;
    const SmallTriangleHit hit = line.meet(points_.at(half.a), points_.at(half.b), points_.at(half.c));
    if (!(hit.t >= ray.t_min) || hit.t > ray.t_max) return;
    if (hit.t == ray.t_max && (ray.is_met ? number >= ray.triangle : !ray.accepts_equal)) return;
    ray.is_met = true;
    if (k_any) return;
    ray.t_max = hit.t;
    ray.triangle = number;
    const float step = 1 / static_cast<float>(patch_.side);
    const auto mean = [&](const std::uint32_t* at) {
      return hit.weights[0] * static_cast<float>(at[half.a]) +
             hit.weights[1] * static_cast<float>(at[half.b]) +
             hit.weights[2] * static_cast<float>(at[half.c]);
    };
    ray.u = step * mean(places_.i);
    ray.v = step * mean(places_.j);
    for (int axis = 0; axis < 3; ++axis) ray.normal[axis] = hit.normal[axis];
  }

  const PatchPoints& patch_;
  Square square_;
  LeafPlaces places_;
  LeafPoints points_;
};

// Of the children of a square, those on the near side of a lone triangle's diagonal.
inline unsigned children_inside(const PatchPoints& points, const Square& square) {
  if (!points.patch.is_single) return 15;
  const std::uint32_t half = 1u << (square.level - 1), sum = square.i + square.j;
  return (sum < points.side ? 1u : 0u) | (sum + half < points.side ? 6u : 0u) |
         (sum + 2 * half < points.side ? 8u : 0u);
}

template <typename Sample, bool k_any>
class PatchSearch {
 public:
  RECEDE_INLINE PatchSearch(const PatchArrays& arrays, const PatchPart& part, PatchRayQuery& ray)
      : points_(arrays, part.patch),
        frame_(PatchFrame::of_patch(points_)),
        map_(*arrays.map, ray.fraction),
        bounds_(points_, frame_, map_),
        ray_(ray),
        box_ray_(ray, frame_) {}

  void run(const PatchPart& part) {
    Square square = bounds_.square_of(part);
    if (square.level <= 1) return test_leaf(square);
    for (;;) {
      if (!go_down(square) && !take_from_stack(square)) return;
      while (square.level == 1) {
        test_leaf(square);
        if (k_any && ray_.is_met) return;
        if (!take_from_stack(square)) return;
      }
    }
  }

 private:
  struct Entry {
    Square square;
    float t;
  };

  bool take_from_stack(Square& square) {
    while (count_ > 0) {
      const Entry& entry = stack_[--count_];
      if (entry.t > ray_.t_max * BoxRay::k_late) continue;
      square = entry.square;
      return true;
    }
    return false;
  }

  // To the nearest child that the ray meets; the others go to the stack.
  RECEDE_INLINE bool go_down(Square& square) {
    Float4 enter;
    unsigned met = box_ray_.meet(bounds_.boxes_of_children(square), ray_.t_min, ray_.t_max, enter);
    met &= children_inside(points_, square);
    // Mostly there is one. Told by branches instead of by its number, the processor goes on with the child
    // that it expects while the test is under way.
    switch (met) {
      case 0:
        return false;
      case 1:
        square = bounds_.child(square, 0);
        return true;
      case 2:
        square = bounds_.child(square, 1);
        return true;
      case 4:
        square = bounds_.child(square, 2);
        return true;
      case 8:
        square = bounds_.child(square, 3);
        return true;
      default:
        push(square, met, enter);
        square = stack_[--count_].square;
        return true;
    }
  }

  __attribute__((noinline)) void push(const Square& square, unsigned met, Float4 enter) {
    const int base = count_;
    for (; met != 0; met &= met - 1) {
      const int k = __builtin_ctz(met);
      int at = count_++;
      for (; at > base && stack_[at - 1].t < enter[k]; --at) stack_[at] = stack_[at - 1];
      stack_[at] = {bounds_.child(square, k), enter[k]};
    }
  }

  void test_leaf(const Square& square) { Leaf<Sample>(points_, map_, square).template test<k_any>(ray_); }

  PatchPoints points_;
  PatchFrame frame_;
  HeightMap<Sample> map_;
  PatchBounds<Sample> bounds_;
  PatchRayQuery& ray_;
  BoxRay box_ray_;
  int count_ = 0;
  Entry stack_[3 * k_most_level + 1];
};

}  // namespace
}  // namespace recede::detail
