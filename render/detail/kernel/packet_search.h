// The search of several rays at once in a displaced patch: what a square holds is found once for all of them.
#pragma once

#include <recede/render/detail/kernel/patch_search.h>

namespace recede::detail {
namespace {

// Lane k of half h is ray 8 h + k.
struct Lanes16 {
  Float8 halves[2];
};

// Rays against boxes in a patch's frame.
class BoxRays {
 public:
  BoxRays(const PatchRayQuery* rays, unsigned count, const PatchFrame& frame) {
    for (int h = 0; h < 2; ++h) {
      float origins[3][8], directions[3][8];
      for (int k = 0; k < 8; ++k) {
        // Lanes without a ray repeat the first one.
        const unsigned at = static_cast<unsigned>(8 * h + k);
        const PatchRayQuery& ray = rays[at < count ? at : 0];
        for (int axis = 0; axis < 3; ++axis) {
          origins[axis][k] = ray.origin[axis];
          directions[axis][k] = ray.direction[axis];
        }
        t_min_.halves[h][k] = ray.t_min;
        t_max_.halves[h][k] = ray.t_max;
      }
      Float8 origin[3], direction[3], far = all8(0);
      for (int axis = 0; axis < 3; ++axis) {
        __builtin_memcpy(&direction[axis], directions[axis], sizeof(Float8));
        __builtin_memcpy(&origin[axis], origins[axis], sizeof(Float8));
        origin[axis] -= frame.origin[axis];
        far = largest(far, largest(origin[axis], -origin[axis]));
      }
      set_axes(h, frame, origin, direction, BoxRay::k_room * (1 + far));
    }
  }

  // Bits of the rays among `active` that meet box k; the least t at which one of them does.
  RECEDE_INLINE unsigned meet(const Boxes4& boxes, int k, unsigned active, float& enter) const {
    unsigned met = 0;
    enter = 3e38f;
    for (int h = 0; h < 2; ++h) {
      const unsigned of_half = active >> (8 * h) & 255;
      if (of_half == 0) continue;
      Float8 from = t_min_.halves[h], to = t_max_.halves[h];
      for (int axis = 0; axis < 3; ++axis) {
        const Float8 a = (boxes.lower[axis][k] - origin_high_[axis].halves[h]) * inverse_[axis].halves[h];
        const Float8 b = (boxes.upper[axis][k] - origin_low_[axis].halves[h]) * inverse_[axis].halves[h];
        from = largest(from, least(a, b));
        to = least(to, largest(a, b));
      }
      const Int8 is_met = from <= to * BoxRay::k_late;
      const unsigned bits = sign_bits(is_met) & of_half;
      if (bits == 0) continue;
      met |= bits << (8 * h);
      // Lanes that aren't active may take part: that only makes it less.
      const float first = least_lane(is_met ? from : all8(3e38f));
      enter = first < enter ? first : enter;
    }
    return met;
  }

  void set_t_max(int ray, float t) { t_max_.halves[ray >> 3][ray & 7] = t; }
  // Rays of `active` whose hit doesn't lie before t.
  unsigned not_before(unsigned active, float t) const {
    const unsigned low = sign_bits(t <= t_max_.halves[0] * BoxRay::k_late);
    const unsigned high = sign_bits(t <= t_max_.halves[1] * BoxRay::k_late);
    return active & (low | high << 8);
  }

 private:
  void set_axes(int h, const PatchFrame& frame, const Float8* origin, const Float8* direction, Float8 room) {
    for (int axis = 0; axis < 3; ++axis) {
      const float* const along = frame.axes[axis];
      const float size = size_of_axis(along);
      const bool is_there = size > BoxRay::k_no_size;
      const Float8 o = (origin[0] * along[0] + origin[1] * along[1]) + origin[2] * along[2];
      const Float8 d = (direction[0] * along[0] + direction[1] * along[1]) + direction[2] * along[2];
      origin_high_[axis].halves[h] = is_there ? o + room * size : all8(BoxRay::k_far);
      origin_low_[axis].halves[h] = is_there ? o - room * size : all8(-BoxRay::k_far);
      for (int k = 0; k < 8; ++k)
        inverse_[axis].halves[h][k] = is_there ? BoxRay::inverse(d[k]) : BoxRay::k_far;
    }
  }

  Lanes16 origin_high_[3], origin_low_[3], inverse_[3], t_min_, t_max_;
};

template <typename Sample, bool k_any>
class PacketSearch {
 public:
  PacketSearch(const PatchArrays& arrays, const PatchPart& part, PatchRayQuery* rays, unsigned count)
      : points_(arrays, part.patch),
        frame_(PatchFrame::of_patch(points_)),
        map_(*arrays.map, rays[0].fraction),
        bounds_(points_, frame_, map_),
        rays_(rays),
        box_rays_(rays, count, frame_),
        waiting_((1u << count) - 1) {}

  void run(const PatchPart& part) {
    push(bounds_.square_of(part), waiting_, -3e38f, count_);
    while (count_ > 0 && waiting_ != 0) {
      const Entry entry = stack_[--count_];
      const unsigned active = box_rays_.not_before(entry.active & waiting_, entry.t);
      if (active == 0) continue;
      if (entry.square.level <= 1) {
        test_leaf(entry.square, active);
      } else {
        open(entry.square, active);
      }
    }
  }

 private:
  struct Entry {
    Square square;
    unsigned active;
    float t;  // none of its rays meets it before
  };

  void open(const Square& square, unsigned active) {
    const Boxes4 boxes = bounds_.boxes_of_children(square);
    const unsigned inside = children_inside(points_, square);
    const int base = count_;
    for (int k = 0; k < 4; ++k) {
      if ((inside >> k & 1) == 0) continue;
      float enter;
      const unsigned met = box_rays_.meet(boxes, k, active, enter);
      if (met != 0) push(bounds_.child(square, k), met, enter, base);
    }
  }

  // The nearest comes on top of those above `base`.
  void push(const Square& square, unsigned active, float t, int base) {
    int at = count_++;
    for (; at > base && stack_[at - 1].t < t; --at) stack_[at] = stack_[at - 1];
    stack_[at] = {square, active, t};
  }

  void test_leaf(const Square& square, unsigned active) {
    const Leaf<Sample> leaf(points_, map_, square);
    for (; active != 0; active &= active - 1) {
      const int k = __builtin_ctz(active);
      leaf.template test<k_any>(rays_[k]);
      if (!rays_[k].is_met) continue;
      if (k_any) {
        waiting_ &= ~(1u << k);
      } else {
        box_rays_.set_t_max(k, rays_[k].t_max);
      }
    }
  }

  PatchPoints points_;
  PatchFrame frame_;
  HeightMap<Sample> map_;
  PatchBounds<Sample> bounds_;
  PatchRayQuery* rays_;
  BoxRays box_rays_;
  unsigned waiting_;  // rays that look for a hit
  int count_ = 0;
  Entry stack_[3 * k_most_level + 4];
};

}  // namespace
}  // namespace recede::detail
