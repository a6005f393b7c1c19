// One version of the kernel. The source that includes it defines RECEDE_KERNEL as its name.
#include <recede/shells/detail/kernel/lp_each.h>
#include <recede/shells/detail/kernel/lp_packet.h>
#include <recede/shells/detail/kernel/lp_totals.h>
#include <recede/shells/detail/lp_kernel.h>

namespace recede::detail {
namespace {

struct Setting {
  explicit Setting(const LpQuery& query)
      : x{all4(query.point[0]), all4(query.point[1]), all4(query.point[2])},
        p(query.p),
        squared_unit(query.unit * query.unit),
        support(query.support),
        order(query.first_order_left_out) {
    for (int k = 0; k < order; ++k) error_factor *= (p + k) / (k + 1);
    // One derivative more: p (p + 1) ... (p + order) / order!, by the same polynomials.
    gradient_error_factor = error_factor * (p + order);
  }
  Vector4 x;
  double p, squared_unit, support;
  int order;
  double error_factor = 1, gradient_error_factor = 1;
};

template <bool is_cubic>
Double4 power_of(Double4 inverse_square, const Setting& setting) {
  if constexpr (is_cubic) return inverse_square * root(inverse_square);
  Double4 result;
  for (int k = 0; k < 4; ++k)
    result[k] = __builtin_pow(inverse_square[k] * setting.squared_unit, 0.5 * setting.p);
  return result;
}

template <bool is_cubic, bool is_weighted, bool is_bounded>
struct Totals {
  Double4 value = all4(0), mass = all4(0);
  Vector4 gradient = {all4(0), all4(0), all4(0)};
  Double4 error = all4(0), gradient_error = all4(0);

  /// Adds the children that are far. The answer: those that are neither far nor without weight.
  Mask4 add(const Setting& setting, const LpNode& node, const LpNodeExtent& extent) {
    const Vector4 r = setting.x - vectors_at(node.center);
    const Double4 squared = dot(r, r);
    Mask4 is_far = squared > lanes_at(node.squared_reach), is_out = squared < all4(0);
    Double4 weight = all4(1), distance = all4(0), radius = all4(0);
    if constexpr (is_weighted || is_bounded) {
      distance = root(squared);
      radius = lanes_at(extent.radius);
    }
    if constexpr (is_weighted) {
      weight = weight_of(distance, setting.support);
      is_out = distance - radius > all4(k_lp_fade_end * setting.support);
      // Weights are those of triangles: where they differ, bounds ask for the triangles, others for small
      // parts.
      const Mask4 is_full = distance + radius < all4(setting.support);
      const Mask4 is_small = radius < all4(k_lp_fading_part * setting.support);
      is_far &= is_bounded ? is_full : (is_full | is_small);
    }
    const Mask4 counts = is_far & ~is_out;
    const Double4 inverse = where(counts, all4(1) / squared), inverse2 = inverse * inverse;
    const Double4 xy = lanes_at(node.tensor[3]), xz = lanes_at(node.tensor[4]), yz = lanes_at(node.tensor[5]);
    const Vector4 turned = {lanes_at(node.tensor[0]) * r.x + xy * r.y + xz * r.z,
                            xy * r.x + lanes_at(node.tensor[1]) * r.y + yz * r.z,
                            xz * r.x + yz * r.y + lanes_at(node.tensor[2]) * r.z};
    const Double4 child = lanes_at(node.mass), second = dot(turned, r) * inverse2;
    Double4 power = power_of<is_cubic>(inverse, setting);
    if constexpr (is_weighted) power *= weight;
    value += power * (child + second);
    const Double4 along = -power * inverse * (all4(setting.p) * child + all4(setting.p + 4) * second),
                  across = all4(2) * power * inverse2;
    gradient.x += along * r.x + across * turned.x;
    gradient.y += along * r.y + across * turned.y;
    gradient.z += along * r.z + across * turned.z;
    mass += where(counts, child * weight);
    if constexpr (is_bounded) add_bound(setting, where(counts, all4(1) / (distance - radius)), extent);
    return ~(is_far | is_out);
  }

  void add_bound(const Setting& setting, Double4 nearest, const LpNodeExtent& extent) {
    const Double4 nearest2 = nearest * nearest;
    const Double4 order = setting.order == 3 ? nearest * nearest2 : nearest2;
    const Double4 remainder = lanes_at(extent.remainder) * order * power_of<is_cubic>(nearest2, setting);
    error += all4(setting.error_factor) * remainder;
    gradient_error += all4(setting.gradient_error_factor) * remainder * nearest;
  }
};

/// What is still to be visited. Children go where they belong without a branch for each, which processors
/// would guess wrong.
struct Pending {
  // Of the eight children of two nodes, six wait while two are followed: six for each of 16 levels, and
  // eight.
  static constexpr int k_nodes = 128, k_leaves = 64;
  std::uint32_t nodes[k_nodes];
  std::uint32_t leaves[k_leaves + 8];  // and what two nodes add to a list that isn't full
  int n_nodes = 0, n_leaves = 0;

  void push(const LpNode& node, Mask4 is_open) {
    for (int lane = 0; lane < 4; ++lane) {
      const std::uint32_t child = node.child[lane];
      const auto open = static_cast<std::uint32_t>(is_open[lane]) & 1u, leaf = child >> 31u;
      nodes[n_nodes] = child;
      n_nodes += static_cast<int>(open & ~leaf);
      leaves[n_leaves] = child & ~k_lp_leaf_bit;
      n_leaves += static_cast<int>(open & leaf);
    }
  }
};

template <bool is_cubic, bool is_weighted, bool is_bounded>
LpSums sum_tree(const LpArrays& arrays, const LpQuery& query) {
  const Setting setting(query);
  Totals<is_cubic, is_weighted, is_bounded> totals;
  LeafTotals leaves;
  LpSums sums;
  Pending pending;
  pending.nodes[pending.n_nodes++] = 0;
  while (pending.n_nodes > 0 || pending.n_leaves > 0) {
    while (pending.n_nodes > 0 && pending.n_leaves < Pending::k_leaves) {
      // Which nodes come next is known only when one is done; a second one fills the time.
      const std::uint32_t first = pending.nodes[--pending.n_nodes];
      if (pending.n_nodes == 0) {
        pending.push(arrays.nodes[first], totals.add(setting, arrays.nodes[first], arrays.extents[first]));
        continue;
      }
      const std::uint32_t second = pending.nodes[--pending.n_nodes];
      const Mask4 open_first = totals.add(setting, arrays.nodes[first], arrays.extents[first]);
      const Mask4 open_second = totals.add(setting, arrays.nodes[second], arrays.extents[second]);
      pending.push(arrays.nodes[first], open_first);
      pending.push(arrays.nodes[second], open_second);
    }
    for (int k = 0; k < pending.n_leaves; ++k) {
      const LpBlock& block = arrays.blocks[pending.leaves[k]];
      if (is_cubic && arrays.add_leaf == nullptr) {
        leaves.add<is_weighted>(setting.x, setting.support, block);
      } else {
        arrays.add_leaf(block, query, sums);
      }
    }
    pending.n_leaves = 0;
  }
  sums.integral += total(totals.value + leaves.value);
  sums.gradient[0] += total(totals.gradient.x + leaves.gradient.x);
  sums.gradient[1] += total(totals.gradient.y + leaves.gradient.y);
  sums.gradient[2] += total(totals.gradient.z + leaves.gradient.z);
  sums.area += total(totals.mass + leaves.mass);
  sums.error = total(totals.error);
  sums.gradient_error = total(totals.gradient_error);
  return sums;
}

template <bool is_cubic>
LpSums sum_powers(const LpArrays& arrays, const LpQuery& query) {
  const bool is_weighted = query.support < __builtin_inf();
  if (query.is_bounded)
    return is_weighted ? sum_tree<is_cubic, true, true>(arrays, query)
                       : sum_tree<is_cubic, false, true>(arrays, query);
  return is_weighted ? sum_tree<is_cubic, true, false>(arrays, query)
                     : sum_tree<is_cubic, false, false>(arrays, query);
}

LpSums sum_all(const LpArrays& arrays, const LpQuery& query) {
  return query.p == 3 ? sum_powers<true>(arrays, query) : sum_powers<false>(arrays, query);
}

}  // namespace

const LpKernel RECEDE_KERNEL = {sum_all, sum_packet, sum_each};

}  // namespace recede::detail
