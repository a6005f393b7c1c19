// How far two small patches of surface are from each other, with proof.
#pragma once

#include <recede/geometry/closest_point.h>

#include <span>
#include <vector>

namespace recede::detail {

/// Keeps lists between patches, so that no memory is allocated: one object per thread.
class PatchDistance {
 public:
  /// At least the two-sided Hausdorff distance between two sets of a few triangles, and at most a tenth more,
  /// or `floor`, or what a bounded number of steps allows. Infinity when only one of them is empty.
  double bound(std::span<const Triangle> a, std::span<const Triangle> b, double floor);

 private:
  struct Piece {
    Triangle corners;
    int depth;
  };
  void raise(std::span<const Triangle> from, std::span<const Triangle> to);
  void settle(const Piece& piece, std::span<const Triangle> to);
  bool cut_along_prism(const Piece& piece, const Triangle& target);
  void cut_in_four(const Piece& piece);

  std::vector<Piece> pieces_;
  double lower_ = 0, upper_ = 0, floor_ = 0;
  std::size_t steps_ = 0;
};

}  // namespace recede::detail
