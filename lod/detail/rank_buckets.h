// A set of items in the order of a cost, from which the item of any rank can be taken.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <vector>

namespace recede::detail {

/// Items 0..n-1, each absent or in the bucket of its cost. Costs that differ by less than 0.4 % share a
/// bucket, where items have no order. All operations cost the logarithm of the number of buckets.
class RankBuckets {
 public:
  explicit RankBuckets(std::size_t n_items);

  /// Number of items present.
  std::size_t size() const { return size_; }
  /// Inserts an absent item or moves a present one. `cost` must not be negative.
  void set(Index item, double cost);
  void erase(Index item);
  /// An item with exactly `rank` or fewer items in cheaper buckets; `rank` below `size()`.
  Index at_rank(std::size_t rank) const;

 private:
  struct Place {
    Index bucket = k_no_index, position = 0;
  };
  void add(Index bucket, std::ptrdiff_t change);

  std::vector<std::vector<Index>> buckets_;
  std::vector<std::size_t> tree_;  // Fenwick tree of bucket sizes
  std::vector<Place> place_;
  std::size_t size_ = 0;
};

}  // namespace recede::detail
