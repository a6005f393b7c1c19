#include <recede/lod/detail/point_classifier.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace recede::detail {

/// True for a point in the middle of one closed fan of faces that agree in everything: the common case, seen
/// without sorting anything.
bool PointClassifier::is_plain(Index p) const {
  constexpr std::size_t k_most = 16;
  const std::size_t n = table_.ring_start[p + 1] - table_.ring_start[p];
  if (n > k_most) return false;
  const Index* const corners = table_.ring.data() + table_.ring_start[p];
  std::array<Index, k_most> after, before;
  for (std::size_t i = 0; i < n; ++i) {
    after[i] = table_.point_after(corners[i]);
    before[i] = table_.point_before(corners[i]);
  }
  const auto agree = [&](Index c, Index following) {
    const auto same = [&](Index x, Index y) { return table_.wedge[x] == table_.wedge[y]; };
    if (!table_.wedge.empty() && !(same(c, following) && same(table_.previous(c), table_.next(following)))) {
      return false;
    }
    if (!table_.feature.empty() && table_.feature[following] != 0) return false;
    return table_.face_material.empty() ||
           table_.face_material[table_.face(c)] == table_.face_material[table_.face(following)];
  };
  // From the first face on around over common neighbours, none of which may be met twice.
  std::size_t at = 0;
  for (std::size_t met = 1; met <= n; ++met) {
    std::size_t following = n;
    for (std::size_t i = 0; i < n; ++i) {
      if (after[i] != before[at]) continue;
      if (following != n) return false;
      following = i;
    }
    if (following == n || !agree(corners[at], corners[following])) return false;
    at = following;
    if (at == 0) return met == n;
  }
  return false;
}

/// Number of fans of faces around a point: its neighbours fall into that many sets when each corner joins
/// the two beside it.
std::size_t PointClassifier::count_fans() {
  parents_.resize(neighbours_.size());
  std::iota(parents_.begin(), parents_.end(), Index{0});
  const auto root_of = [&](Index q) {
    auto i =
        static_cast<Index>(std::lower_bound(neighbours_.begin(), neighbours_.end(), q) - neighbours_.begin());
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  };
  std::size_t fans = neighbours_.size();
  for (const Index corner : corners_) {
    const Index x = root_of(table_.point_after(corner)), y = root_of(table_.point_before(corner));
    if (x == y) continue;
    parents_[x] = y;
    --fans;
  }
  return fans;
}

PointClass PointClassifier::classify(Index p) {
  if (is_plain(p)) return PointClass::smooth;
  neighbours_.clear();
  corners_.clear();
  table_.each_corner(p, [&](Index corner) {
    corners_.push_back(corner);
    neighbours_.push_back(table_.point_after(corner));
    neighbours_.push_back(table_.point_before(corner));
  });
  std::sort(neighbours_.begin(), neighbours_.end());
  neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
  std::array<unsigned, 2> kinds{};
  std::size_t n_creases = 0;
  for (const Index q : neighbours_) {
    const unsigned kind = table_.edge_kind(p, q);
    if (kind == k_smooth_edge) continue;
    if (n_creases < 2) kinds[n_creases] = kind;
    ++n_creases;
  }
  if (count_fans() > 1) return PointClass::fixed;
  if (n_creases == 0) return PointClass::smooth;
  if (n_creases != 2 || kinds[0] != kinds[1]) return PointClass::fixed;
  if (lock_borders_ && (kinds[0] & k_border_edge) != 0) return PointClass::fixed;
  return PointClass::crease;
}

}  // namespace recede::detail
