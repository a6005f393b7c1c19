// How freely a point may move, from the faces around it.
#pragma once

#include <recede/lod/detail/corner_table.h>

namespace recede::detail {

/// Classifies points of a table whose rings are linked. Keeps lists between points, so that no memory is
/// allocated: one object per thread.
class PointClassifier {
 public:
  PointClassifier(const CornerTable& table, bool lock_borders) : table_(table), lock_borders_(lock_borders) {}

  PointClass classify(Index p);

 private:
  bool is_plain(Index p) const;
  std::size_t count_fans();

  const CornerTable& table_;
  bool lock_borders_;
  std::vector<Index> neighbours_, corners_, parents_;
};

}  // namespace recede::detail
