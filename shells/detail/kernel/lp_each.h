// Sums over all of a surface, for points of which the next is near: where registers are wide enough, two of
// them walk down the tree together, each with the four children of a node in its half. Nodes wait in a queue,
// level by level, so that which ones come next is known long before they do: processors needn't wait or
// guess.
//
// Each point takes the same parts in the same order as it would alone, and leaves in turn to two sums, which
// are halves of the widest registers or follow each other. So its sums are the same to the last bit whatever
// the others are, and however many a processor takes at once.
#pragma once

#include <recede/shells/detail/kernel/lp_totals.h>

namespace recede::detail {
namespace {

/// Of the leaves of a point, every other in one sum.
struct LeafPairTotals {
  LeafTotals even, odd;

  void add_last(const Vector4& x, const LpBlock& block) { even.add<false>(x, 0, block); }
  LpSums sums() const {
    LpSums result;
    result.integral = total(even.value + odd.value);
    result.gradient[0] = total(even.gradient.x + odd.gradient.x);
    result.gradient[1] = total(even.gradient.y + odd.gradient.y);
    result.gradient[2] = total(even.gradient.z + odd.gradient.z);
    return result;
  }
};

/// Adds pairs of leaves; a last one without another is left.
RECEDE_INLINE void add_pairs(const Vector4& x, const LpBlock* blocks, const std::uint32_t* leaves, int n,
                             LeafPairTotals& totals) {
#if defined(__AVX512F__)
  using Double8 = EightLanes::Double;
  const auto joined = [](Double4 low, Double4 high) -> Double8 {
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const auto at = [&](const double(&low)[4], const double(&high)[4]) {
    return joined(lanes_at(low), lanes_at(high));
  };
  const auto vectors = [&](const double(&low)[3][4], const double(&high)[3][4]) -> VectorLanes<Double8> {
    return {at(low[0], high[0]), at(low[1], high[1]), at(low[2], high[2])};
  };
  const VectorLanes<Double8> point = {joined(x.x, x.x), joined(x.y, x.y), joined(x.z, x.z)};
  Double8 value = joined(totals.even.value, totals.odd.value);
  VectorLanes<Double8> gradient = {joined(totals.even.gradient.x, totals.odd.gradient.x),
                                   joined(totals.even.gradient.y, totals.odd.gradient.y),
                                   joined(totals.even.gradient.z, totals.odd.gradient.z)};
  for (int i = 0; i + 1 < n; i += 2) {
    const LpBlock &low = blocks[leaves[i]], &high = blocks[leaves[i + 1]];
    const IntegralLanes<Double8> part = integrate_cubic<EightLanes>(
        vectors(low.corners[0], high.corners[0]) - point, vectors(low.corners[1], high.corners[1]) - point,
        vectors(low.corners[2], high.corners[2]) - point, vectors(low.normal, high.normal),
        at(low.twice_area, high.twice_area));
    value += part.value;
    gradient.x += part.gradient.x;
    gradient.y += part.gradient.y;
    gradient.z += part.gradient.z;
  }
  const auto parted = [](Double8 lanes, Double4& low, Double4& high) {
    low = __builtin_shufflevector(lanes, lanes, 0, 1, 2, 3);
    high = __builtin_shufflevector(lanes, lanes, 4, 5, 6, 7);
  };
  parted(value, totals.even.value, totals.odd.value);
  parted(gradient.x, totals.even.gradient.x, totals.odd.gradient.x);
  parted(gradient.y, totals.even.gradient.y, totals.odd.gradient.y);
  parted(gradient.z, totals.even.gradient.z, totals.odd.gradient.z);
#else
  for (int i = 0; i + 1 < n; i += 2) {
    totals.even.add<false>(x, 0, blocks[leaves[i]]);
    totals.odd.add<false>(x, 0, blocks[leaves[i + 1]]);
  }
#endif
}

/// So that it's there when its turn comes.
template <typename T>
RECEDE_INLINE void prefetch(const T& entry) {
  constexpr std::size_t k_line = 64;
  for (std::size_t at = 0; at < sizeof entry; at += k_line)
    __builtin_prefetch(reinterpret_cast<const char*>(&entry) + at);
}

/// A point in each four lanes.
template <typename Lanes>
struct Walk {
  using Double = typename Lanes::Double;
  using Mask = typename Lanes::Mask;
  using Vector = VectorLanes<Double>;
  static constexpr int k_points = Lanes::k_size / 4, k_leaves = 32;
  static constexpr int k_at_once = 2;  ///< nodes; of four, numbers wouldn't fit into registers

  const LpArrays& arrays;
  LpVisit* visits;
  Vector x{};
  Double value = Lanes::all(0);
  Vector gradient = {Lanes::all(0), Lanes::all(0), Lanes::all(0)};
  int n_visits = 0;
  LpVisit leaves[k_leaves + 4 * k_at_once];  // and what visits add to a list that isn't full
  int n_leaves = 0;
  std::uint32_t left[k_points] = {};  // a leaf that waits for another
  bool is_left[k_points] = {};
  LeafPairTotals totals[k_points];

  Walk(const LpArrays& arrays_, const LpQuery* queries, int n, LpVisit* visits_)
      : arrays(arrays_), visits(visits_) {
    for (int lane = 0; lane < Lanes::k_size; ++lane) {
      const double* const point = queries[lane / 4 < n ? lane / 4 : 0].point;
      x.x[lane] = point[0];
      x.y[lane] = point[1];
      x.z[lane] = point[2];
    }
    visits[n_visits++] = {0, (1u << static_cast<unsigned>(4 * n)) - 1u};
  }

  /// Children at `r` from their centroids, by 1 / |r|, or zero for what doesn't count.
  RECEDE_INLINE void add(const Vector& r, Double reciprocal, const LpNode& node) {
    const auto all = [](double number) { return Lanes::all(number); };
    const auto of = [](const double(&values)[4]) { return Lanes::repeated(values); };
    const Double inverse = reciprocal * reciprocal, inverse2 = inverse * inverse;
    const Double xy = of(node.tensor[3]), xz = of(node.tensor[4]), yz = of(node.tensor[5]);
    const Vector turned = {of(node.tensor[0]) * r.x + xy * r.y + xz * r.z,
                           xy * r.x + of(node.tensor[1]) * r.y + yz * r.z,
                           xz * r.x + yz * r.y + of(node.tensor[2]) * r.z};
    const Double part = of(node.mass), second = dot(turned, r) * inverse2;
    const Double power = inverse * reciprocal;
    value += power * (part + second);
    const Double along = power * inverse * (all(3) * part + all(7) * second),
                 across = all(2) * power * inverse2;
    gradient.x += across * turned.x - along * r.x;
    gradient.y += across * turned.y - along * r.y;
    gradient.z += across * turned.z - along * r.z;
  }

  /// Children go where they belong without a branch for each, which processors would guess wrong.
  RECEDE_INLINE void push(const LpNode& node, unsigned open) {
    for (unsigned slot = 0; slot < 4; ++slot) {
      const std::uint32_t child = node.child[slot], points = open >> slot & 0x11u;
      const std::uint32_t is_open = points != 0, is_leaf = child >> 31u;
      visits[n_visits] = {child, 0xfu * points};
      n_visits += static_cast<int>(is_open & ~is_leaf);
      leaves[n_leaves] = {child & ~k_lp_leaf_bit, 0xfu * points};
      n_leaves += static_cast<int>(is_open & is_leaf);
    }
  }

  /// Adds the children of some nodes that are far, and puts the others where they belong.
  RECEDE_INLINE void visit(const LpVisit* entries) {
    Mask is_far[k_at_once];
    Vector r[k_at_once];
    Double squared[k_at_once], reciprocal[k_at_once];
    for (int i = 0; i < k_at_once; ++i) {
      const LpNode& node = arrays.nodes[entries[i].node];
      r[i] = {x.x - Lanes::repeated(node.center[0]), x.y - Lanes::repeated(node.center[1]),
              x.z - Lanes::repeated(node.center[2])};
      squared[i] = dot(r[i], r[i]);
      is_far[i] = Lanes::both(Lanes::is_less(Lanes::repeated(node.squared_reach), squared[i]),
                              Lanes::mask_of(entries[i].lanes));
    }
    reciprocal_roots<Lanes>(squared, reciprocal);
    for (int i = 0; i < k_at_once; ++i)
      add(r[i], Lanes::where_true(is_far[i], reciprocal[i]), arrays.nodes[entries[i].node]);
    for (int i = 0; i < k_at_once; ++i)
      push(arrays.nodes[entries[i].node], entries[i].lanes & ~Lanes::bits(is_far[i]));
  }

  Vector4 point(int k) const { return {all4(x.x[4 * k]), all4(x.y[4 * k]), all4(x.z[4 * k])}; }

  /// In pairs: a last one is left.
  void add_leaves() {
    for (int i = 0; i < n_leaves; ++i) prefetch(arrays.blocks[leaves[i].node]);
    for (int k = 0; k < k_points; ++k) {
      std::uint32_t list[k_leaves + 4 * k_at_once + 2];  // and the one that waits
      int n = 0;
      list[n] = left[k];
      n += is_left[k];
      for (int i = 0; i < n_leaves; ++i) {
        list[n] = leaves[i].node;
        n += static_cast<int>(leaves[i].lanes >> (4 * k) & 1u);
      }
      add_pairs(point(k), arrays.blocks, list, n, totals[k]);
      is_left[k] = n % 2 != 0;
      if (is_left[k]) left[k] = list[n - 1];
    }
    n_leaves = 0;
  }

  void run() {
    for (int next = 0; next < n_visits;) {
      LpVisit now[k_at_once] = {};  // the root for nobody, when there is but one
      for (int i = 0; i < k_at_once; ++i) {
        if (next < n_visits) now[i] = visits[next++];
        if (next + k_at_once < n_visits) prefetch(arrays.nodes[visits[next + k_at_once].node]);
      }
      visit(now);
      if (n_leaves >= k_leaves) add_leaves();
    }
    add_leaves();
    for (int k = 0; k < k_points; ++k) {
      if (is_left[k]) totals[k].add_last(point(k), arrays.blocks[left[k]]);
    }
  }
};

void sum_each(const LpArrays& arrays, const LpQuery* queries, int n, LpVisit* visits, LpSums* sums) {
  using Here = Walk<WidestLanes>;
  for (int first = 0; first < n; first += Here::k_points) {
    const int here = n - first < Here::k_points ? n - first : Here::k_points;
    Here walk(arrays, queries + first, here, visits);
    walk.run();
    for (int k = 0; k < here; ++k) {
      const auto total_of = [&](const typename Here::Double& lanes) {
        return (lanes[4 * k] + lanes[4 * k + 1]) + (lanes[4 * k + 2] + lanes[4 * k + 3]);
      };
      LpSums& sum = sums[first + k];
      sum = walk.totals[k].sums();
      sum.integral += total_of(walk.value);
      sum.gradient[0] += total_of(walk.gradient.x);
      sum.gradient[1] += total_of(walk.gradient.y);
      sum.gradient[2] += total_of(walk.gradient.z);
    }
  }
}

}  // namespace
}  // namespace recede::detail
