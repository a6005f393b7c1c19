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
    : hierarchy_(&hierarchy),
      last_(hierarchy.n_vertices(), k_no_index),
      applied_(hierarchy.n_splits(), 0),
      position_(hierarchy.n_vertices(), 0) {
  next_.reserve(hierarchy.n_vertices());
  for (Index v = 0; v < hierarchy.n_vertices(); ++v) next_.push_back(hierarchy.first(v));
  for (Index s = 0; s < hierarchy.n_splits(); ++s) {
    const Index removed = hierarchy.split(s).removed;
    if (removed == k_no_index)
      loose_.push_back(s);
    else
      position_[removed] = k_no_index;
  }
  for (Index v = 0; v < hierarchy.n_vertices(); ++v) {
    if (position_[v] == k_no_index) continue;
    position_[v] = static_cast<Index>(vertices_.size());
    vertices_.push_back(v);
  }
}

bool VertexFront::is_last(Index split) const {
  const VertexPair& pair = hierarchy_->split(split);
  return pair.kept == k_no_index || (last_[pair.kept] == split && last_[pair.removed] == split);
}

void VertexFront::mark_split(Index split) {
  applied_[split] = 1;
  const auto [removed, kept] = hierarchy_->split(split);
  if (kept == k_no_index) return;
  next_[kept] = hierarchy_->following(split);
  last_[kept] = last_[removed] = split;
  position_[removed] = static_cast<Index>(vertices_.size());
  vertices_.push_back(removed);
}

void VertexFront::mark_merge(Index split) {
  applied_[split] = 0;
  const auto [removed, kept] = hierarchy_->split(split);
  if (kept == k_no_index) return;
  next_[kept] = split;
  last_[kept] = hierarchy_->preceding(split);
  const Index position = position_[removed];
  vertices_[position] = vertices_.back();
  position_[vertices_[position]] = position;
  vertices_.pop_back();
}

}  // namespace recede
