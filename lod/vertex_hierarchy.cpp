#include <recede/lod/vertex_hierarchy.h>

namespace recede {

VertexHierarchy::VertexHierarchy(std::size_t n_vertices, std::vector<VertexPair> splits)
    : splits_(std::move(splits)),
      first_(n_vertices, k_no_index),
      following_(splits_.size(), k_no_index),
      preceding_(splits_.size(), k_no_index) {
  for (std::size_t s = splits_.size(); s-- > 0;) {
    const auto split = static_cast<Index>(s);
    const Index kept = splits_[s].kept;
    if (kept == k_no_index) continue;
    following_[s] = first_[kept];
    first_[kept] = split;
    for (const Index later : {following_[s], first_[splits_[s].removed]}) {
      if (later != k_no_index) preceding_[later] = split;
    }
  }
}

VertexFront::VertexFront(const VertexHierarchy& hierarchy)
    : hierarchy_(&hierarchy), applied_(hierarchy.n_splits(), 0), place_(hierarchy.n_vertices(), 0) {
  for (Index s = 0; s < hierarchy.n_splits(); ++s) {
    const Index removed = hierarchy.split(s).removed;
    if (removed == k_no_index)
      loose_.push_back(s);
    else
      place_[removed] = k_no_index;
  }
  for (Index v = 0; v < hierarchy.n_vertices(); ++v) {
    if (place_[v] == k_no_index) continue;
    place_[v] = static_cast<Index>(members_.size());
    members_.push_back({v, hierarchy.first(v), k_no_index, false});
  }
}

bool VertexFront::is_last(Index split) const {
  const VertexPair& pair = hierarchy_->split(split);
  return pair.kept == k_no_index || (last(pair.kept) == split && last(pair.removed) == split);
}

void VertexFront::mark_split(Index split) {
  applied_[split] = 1;
  const auto [removed, kept] = hierarchy_->split(split);
  if (kept == k_no_index) return;
  Member& stays = members_[place_[kept]];
  stays.next = hierarchy_->following(split);
  set_last(stays, split);
  place_[removed] = static_cast<Index>(members_.size());
  members_.push_back({removed, hierarchy_->first(removed), split, true});
}

void VertexFront::mark_merge(Index split) {
  applied_[split] = 0;
  const auto [removed, kept] = hierarchy_->split(split);
  if (kept == k_no_index) return;
  Member& stays = members_[place_[kept]];
  stays.next = split;
  set_last(stays, hierarchy_->preceding(split));
  const Index place = place_[removed];
  members_[place] = members_.back();
  place_[members_[place].vertex] = place;
  members_.pop_back();
  place_[removed] = k_no_index;
}

}  // namespace recede
