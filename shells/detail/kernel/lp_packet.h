// Sums within a support for points that lie near to each other: they walk down the tree together, so that
// what is far is added for several points at once, and asking of a part whether it is costs little.
//
// Each point takes the same parts in the same order as it would alone. So its sums are the same to the last
// bit whatever the others are, and however many a processor takes at once.
#pragma once

#include <recede/shells/detail/kernel/lp_totals.h>

namespace recede::detail {
namespace {

/// Of parts that are summed up, one at a time, for a point in each lane.
template <typename Lanes>
struct PartTotals {
  using Double = typename Lanes::Double;
  Double value = Lanes::all(0), mass = Lanes::all(0);
  VectorLanes<Double> gradient = {Lanes::all(0), Lanes::all(0), Lanes::all(0)};

  template <bool is_fading>
  void add(const VectorLanes<Double>& r, const LpNode& node, std::uint32_t slot, unsigned points,
           double support) {
    const auto all = [](double number) { return Lanes::all(number); };
    const Double squared = dot(r, r);
    const Double inverse = Lanes::where_set(points, all(1) / squared), inverse2 = inverse * inverse;
    const Double xy = all(node.tensor[3][slot]), xz = all(node.tensor[4][slot]),
                 yz = all(node.tensor[5][slot]);
    const VectorLanes<Double> turned = {all(node.tensor[0][slot]) * r.x + xy * r.y + xz * r.z,
                                        xy * r.x + all(node.tensor[1][slot]) * r.y + yz * r.z,
                                        xz * r.x + yz * r.y + all(node.tensor[2][slot]) * r.z};
    const Double part = all(node.mass[slot]), second = dot(turned, r) * inverse2;
    const Double reciprocal = Lanes::square_root(inverse);
    Double power = inverse * reciprocal, counted = Lanes::where_set(points, part);
    if constexpr (is_fading) {
      const Double t =
          (all(k_lp_fade_end * support) - squared * reciprocal) * all(1 / ((k_lp_fade_end - 1) * support));
      const Double inside = Lanes::larger_of(Lanes::smaller_of(t, all(1)), all(0));
      const Double weight = inside * inside * (all(3) - all(2) * inside);
      power *= weight;
      counted *= weight;
    }
    value += power * (part + second);
    const Double along = -power * inverse * (all(3) * part + all(7) * second),
                 across = all(2) * power * inverse2;
    gradient.x += along * r.x + across * turned.x;
    gradient.y += along * r.y + across * turned.y;
    gradient.z += along * r.z + across * turned.z;
    mass += counted;
  }
};

/// The points of a packet, one in each lane.
template <typename Lanes>
struct PacketWalk {
  using Double = typename Lanes::Double;
  using Vector = VectorLanes<Double>;
  static constexpr int k_lanes = Lanes::k_size;
  // Three children of a node wait while one is followed, for each of 16 levels.
  static constexpr int k_nodes = 64, k_parts = 64, k_leaves = 32;

  PacketWalk(const LpArrays& arrays_, const LpFade* fades_, double support_, const LpQuery* queries, int n)
      : arrays(arrays_), fades(fades_), support(support_) {
    for (int lane = 0; lane < k_lanes; ++lane) {
      const double* const point = queries[lane < n ? lane : 0].point;
      x.x[lane] = point[0];
      x.y[lane] = point[1];
      x.z[lane] = point[2];
    }
    nodes[n_nodes++] = {0, (1u << static_cast<unsigned>(n)) - 1u};
  }

  /// A node and those points that look into it, as bits; of parts, four times the node and the lane.
  struct Entry {
    std::uint32_t index, points;
  };

  const LpArrays& arrays;
  const LpFade* fades;
  double support;
  Vector x{};
  Entry nodes[k_nodes];
  Entry full[k_parts + 4], fading[k_parts + 4];  // and what a node adds to a list that isn't full
  std::uint32_t leaves[k_lanes][k_leaves + 4], fading_leaves[k_lanes][k_leaves + 4];
  int n_nodes = 0, n_full = 0, n_fading = 0;
  int n_leaves[k_lanes] = {}, n_fading_leaves[k_lanes] = {};
  // Apart, as lists get full earlier in other company.
  PartTotals<Lanes> of_full, of_fading;
  LeafTotals totals[k_lanes];

  /// Sorts the children of a node into what they are for each point.
  void visit(Entry entry) {
    const LpNode& node = arrays.nodes[entry.index];
    const LpFade& fade = fades[entry.index];
    const std::uint32_t points = entry.points;
    for (std::uint32_t slot = 0; slot < 4; ++slot) {
      const Vector r = from(node, slot);
      const Double squared = dot(r, r);
      const std::uint32_t inside = Lanes::at_most(squared, Lanes::all(fade.squared_end[slot])) & points;
      if (inside == 0) continue;
      const std::uint32_t is_full = Lanes::less(squared, Lanes::all(fade.squared_full[slot]));
      const std::uint32_t far = Lanes::less(Lanes::all(node.squared_reach[slot]), squared) &
                                Lanes::less(squared, Lanes::all(fade.squared_limit[slot])) & inside;
      const std::uint32_t open = inside & ~far;
      full[n_full] = {4 * entry.index + slot, far & is_full};
      n_full += (far & is_full) != 0;
      fading[n_fading] = {4 * entry.index + slot, far & ~is_full};
      n_fading += (far & ~is_full) != 0;
      if (open == 0) continue;
      const std::uint32_t child = node.child[slot];
      if ((child & k_lp_leaf_bit) == 0) {
        nodes[n_nodes++] = {child, open};
        continue;
      }
      for (std::uint32_t lane = 0; lane < k_lanes; ++lane) {
        const std::uint32_t is_open = open >> lane & 1u, whole = is_full >> lane & 1u;
        leaves[lane][n_leaves[lane]] = child & ~k_lp_leaf_bit;
        n_leaves[lane] += static_cast<int>(is_open & whole);
        fading_leaves[lane][n_fading_leaves[lane]] = child & ~k_lp_leaf_bit;
        n_fading_leaves[lane] += static_cast<int>(is_open & ~whole);
      }
    }
  }

  Vector from(const LpNode& node, std::uint32_t slot) const {
    return {x.x - Lanes::all(node.center[0][slot]), x.y - Lanes::all(node.center[1][slot]),
            x.z - Lanes::all(node.center[2][slot])};
  }

  template <bool is_fading>
  void add_list(const Entry* entries, int n, PartTotals<Lanes>& sums) {
    PartTotals<Lanes> local = sums;
    for (int i = 0; i < n; ++i) {
      const LpNode& node = arrays.nodes[entries[i].index / 4];
      const std::uint32_t slot = entries[i].index % 4;
      local.template add<is_fading>(from(node, slot), node, slot, entries[i].points, support);
    }
    sums = local;
  }

  void add_parts() {
    add_list<false>(full, n_full, of_full);
    add_list<true>(fading, n_fading, of_fading);
    n_full = n_fading = 0;
  }

  void add_leaves(int lane) {
    const Vector4 point = {all4(x.x[lane]), all4(x.y[lane]), all4(x.z[lane])};
    for (int i = 0; i < n_leaves[lane]; ++i)
      totals[lane].template add<false>(point, support, arrays.blocks[leaves[lane][i]]);
    for (int i = 0; i < n_fading_leaves[lane]; ++i)
      totals[lane].template add<true>(point, support, arrays.blocks[fading_leaves[lane][i]]);
    n_leaves[lane] = n_fading_leaves[lane] = 0;
  }

  void run() {
    while (n_nodes > 0) {
      visit(nodes[--n_nodes]);
      if (n_full >= k_parts || n_fading >= k_parts) add_parts();
      for (int lane = 0; lane < k_lanes; ++lane) {
        if (n_leaves[lane] >= k_leaves || n_fading_leaves[lane] >= k_leaves) add_leaves(lane);
      }
    }
    add_parts();
    for (int lane = 0; lane < k_lanes; ++lane) add_leaves(lane);
  }
};

void sum_packet(const LpArrays& arrays, const LpFade* fades, const LpQuery* queries, int n, LpSums* sums) {
  using Walk = PacketWalk<WidestLanes>;
  for (int first = 0; first < n; first += Walk::k_lanes) {
    const int here = n - first < Walk::k_lanes ? n - first : Walk::k_lanes;
    Walk walk(arrays, fades, queries[0].support, queries + first, here);
    walk.run();
    for (int lane = 0; lane < here; ++lane) {
      const LeafTotals& near = walk.totals[lane];
      LpSums& sum = sums[first + lane];
      sum.integral = walk.of_full.value[lane] + walk.of_fading.value[lane] + total(near.value);
      sum.gradient[0] =
          walk.of_full.gradient.x[lane] + walk.of_fading.gradient.x[lane] + total(near.gradient.x);
      sum.gradient[1] =
          walk.of_full.gradient.y[lane] + walk.of_fading.gradient.y[lane] + total(near.gradient.y);
      sum.gradient[2] =
          walk.of_full.gradient.z[lane] + walk.of_fading.gradient.z[lane] + total(near.gradient.z);
      sum.area = walk.of_full.mass[lane] + walk.of_fading.mass[lane] + total(near.mass);
    }
  }
}

}  // namespace
}  // namespace recede::detail
