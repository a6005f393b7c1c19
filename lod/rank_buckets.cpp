#include <recede/lod/detail/rank_buckets.h>

#include <algorithm>
#include <bit>

namespace recede::detail {
namespace {

// A float's leading bits: sign 0, 8 of exponent, 8 of mantissa (steps of 1/256, 0.4 %).
constexpr int k_dropped_bits = 15;
constexpr Index k_buckets = Index{1} << (31 - k_dropped_bits);

Index bucket_of(double cost) {
  return std::min(std::bit_cast<Index>(static_cast<float>(cost)) >> k_dropped_bits, k_buckets - 1);
}

}  // namespace

RankBuckets::RankBuckets(std::size_t n_items)
    : buckets_(k_buckets), tree_(k_buckets + 1, 0), place_(n_items) {}

void RankBuckets::add(Index bucket, std::ptrdiff_t change) {
  for (Index i = bucket + 1; i <= k_buckets; i += i & (~i + 1)) {
    tree_[i] = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(tree_[i]) + change);
  }
}

void RankBuckets::set(Index item, double cost) {
  const Index bucket = bucket_of(cost);
  if (place_[item].bucket == bucket) return;
  erase(item);
  place_[item] = {bucket, static_cast<Index>(buckets_[bucket].size())};
  buckets_[bucket].push_back(item);
  add(bucket, 1);
  ++size_;
}

void RankBuckets::erase(Index item) {
  const auto [bucket, position] = place_[item];
  if (bucket == k_no_index) return;
  const Index last = buckets_[bucket].back();
  buckets_[bucket][position] = last;
  place_[last].position = position;
  buckets_[bucket].pop_back();
  place_[item].bucket = k_no_index;
  add(bucket, -1);
  --size_;
}

Index RankBuckets::at_rank(std::size_t rank) const {
  Index bucket = 0;
  for (Index step = k_buckets; step > 0; step /= 2) {
    if (bucket + step <= k_buckets && tree_[bucket + step] <= rank) {
      bucket += step;
      rank -= tree_[bucket];
    }
  }
  return buckets_[bucket][rank];
}

}  // namespace recede::detail
