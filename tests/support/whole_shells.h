// What `check_shell` is to find in layers with whole coordinates below 2^11: every pair of parts, by
// separating axes in whole numbers.
#pragma once

#include "shell_layers.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace recede::test {

using WholeVec = std::array<std::int64_t, 3>;

inline WholeVec minus(const WholeVec& a, const WholeVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline WholeVec cross(const WholeVec& a, const WholeVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline std::int64_t dot(const WholeVec& a, const WholeVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

using Hull = std::vector<WholeVec>;

/// Whether all of one hull lies strictly before all of the other along the axis.
inline bool is_separating(const WholeVec& axis, const Hull& a, const Hull& b) {
  constexpr auto k_most = std::numeric_limits<std::int64_t>::max();
  std::int64_t a_low = k_most, a_high = -k_most, b_low = k_most, b_high = -k_most;
  for (const WholeVec& p : a) a_low = std::min(a_low, dot(axis, p)), a_high = std::max(a_high, dot(axis, p));
  for (const WholeVec& p : b) b_low = std::min(b_low, dot(axis, p)), b_high = std::max(b_high, dot(axis, p));
  return a_high < b_low || b_high < a_low;
}

inline std::vector<WholeVec> steps(const Hull& hull) {
  std::vector<WholeVec> result;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    for (std::size_t j = i + 1; j < hull.size(); ++j) result.push_back(minus(hull[j], hull[i]));
  }
  return result;
}

/// Whether the convex hulls have a common point. When they don't, a normal of a facet of their difference
/// separates them; where the difference is flat, also one of an edge in its plane, or its direction.
inline bool hulls_meet(const Hull& a, const Hull& b) {
  for (const WholeVec& axis : {WholeVec{1, 0, 0}, WholeVec{0, 1, 0}, WholeVec{0, 0, 1}}) {
    if (is_separating(axis, a, b)) return false;
  }
  const std::vector<WholeVec> own = steps(a), other = steps(b);
  std::vector<WholeVec> all = own;
  all.insert(all.end(), other.begin(), other.end());
  all.push_back(minus(b[0], a[0]));
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (is_separating(all[i], a, b)) return false;
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      const WholeVec normal = cross(all[i], all[j]);
      if (is_separating(normal, a, b)) return false;
      if (is_separating(cross(normal, all[i]), a, b) || is_separating(cross(normal, all[j]), a, b))
        return false;
    }
  }
  return true;
}

/// Whether two hulls of numbered points meet apart from the hull of their common ones: then faces without a
/// common point do, since from any other common place the way on leads away from a common point up to a
/// smaller face. Two with the same points count as meeting.
inline bool meet_apart(std::span<const Vec3> points, const std::vector<Index>& a,
                       const std::vector<Index>& b) {
  const auto whole_point = [&](Index i) {
    WholeVec p{};
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = static_cast<std::int64_t>(points[i][static_cast<Eigen::Index>(k)]);
    return p;
  };
  if (std::is_permutation(a.begin(), a.end(), b.begin(), b.end())) return true;
  for (unsigned face = 1; face < (1u << a.size()); ++face) {
    Hull own, other;
    std::vector<Index> used;
    for (std::size_t i = 0; i < a.size(); ++i) {
      if ((face >> i & 1) == 0) continue;
      used.push_back(a[i]);
      own.push_back(whole_point(a[i]));
    }
    for (const Index i : b) {
      if (std::find(used.begin(), used.end(), i) == used.end()) other.push_back(whole_point(i));
    }
    if (!other.empty() && hulls_meet(own, other)) return true;
  }
  return false;
}

/// The boundary of a layer, with what it stands for.
struct WholePart {
  std::vector<Index> points;
  ShellPart kind;
  Index number;  ///< of the triangle, or the corner of a wall
};

inline std::vector<WholePart> parts_of(const Layer& layer) {
  std::vector<WholePart> parts;
  const auto n = static_cast<Index>(layer.bottom.size());
  std::map<std::pair<Index, Index>, int> sides;
  const auto side = [&](std::size_t c) {
    return std::pair(layer.triangles[c], layer.triangles[c % 3 == 2 ? c - 2 : c + 1]);
  };
  for (std::size_t c = 0; c < layer.triangles.size(); ++c)
    ++sides[std::minmax(side(c).first, side(c).second)];
  for (const ShellPart kind : {ShellPart::bottom, ShellPart::top}) {
    const Index shift = kind == ShellPart::top ? n : 0;
    for (std::size_t t = 0; t < layer.triangles.size(); t += 3) {
      parts.push_back({{}, kind, static_cast<Index>(t / 3)});
      for (std::size_t k = 0; k < 3; ++k) parts.back().points.push_back(layer.triangles[t + k] + shift);
    }
  }
  for (std::size_t c = 0; c < layer.triangles.size(); ++c) {
    const auto [a, b] = side(c);
    if (sides[std::minmax(a, b)] != 1) continue;
    parts.push_back({{a, b, a + n, b + n}, ShellPart::wall, static_cast<Index>(c)});
  }
  return parts;
}

/// The contacts of all pairs, without the other lists.
inline ShellValidity contacts_by_brute_force(const Layer& layer) {
  std::vector<Vec3> points = layer.bottom;
  points.insert(points.end(), layer.top.begin(), layer.top.end());
  const std::vector<WholePart> parts = parts_of(layer);
  ShellValidity found;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = i + 1; j < parts.size(); ++j) {
      const WholePart &a = parts[i], &b = parts[j];
      if (!meet_apart(points, a.points, b.points)) continue;
      if (b.kind == ShellPart::wall) {
        const bool is_wall = a.kind == ShellPart::wall;
        found.wall_contacts.push_back({is_wall ? a.number : b.number, a.kind, is_wall ? b.number : a.number});
      } else {
        auto& list = a.kind != b.kind              ? found.layer_contacts
                     : a.kind == ShellPart::bottom ? found.bottom_contacts
                                                   : found.top_contacts;
        list.emplace_back(a.number, b.number);
      }
    }
  }
  for (auto* list : {&found.bottom_contacts, &found.top_contacts, &found.layer_contacts}) {
    std::sort(list->begin(), list->end());
  }
  std::sort(found.wall_contacts.begin(), found.wall_contacts.end());
  return found;
}

}  // namespace recede::test
