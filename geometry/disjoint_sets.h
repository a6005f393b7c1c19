// Sets that only ever grow together.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <numeric>
#include <vector>

namespace recede {

/// A forest of elements 0 to n-1. The name of a set is one of its elements, chosen by the caller.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), Index{0}); }

  /// Name of the element's set.
  Index find(Index element) {
    while (parent_[element] != element) {
      parent_[element] = parent_[parent_[element]];
      element = parent_[element];
    }
    return element;
  }

  /// `absorbed`, the name of a set, becomes part of the set named `kept`.
  void merge(Index kept, Index absorbed) { parent_[absorbed] = kept; }

  /// Both elements' sets become one, named by the lower of the two names.
  void unite(Index a, Index b) {
    a = find(a);
    b = find(b);
    if (a < b) {
      parent_[b] = a;
    } else {
      parent_[a] = b;
    }
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace recede
