// How far a triangle is from a few others, with proof, and which of them the proof needs.
#pragma once

#include <recede/geometry/closest_point.h>

#include <span>
#include <vector>

namespace recede::detail {

/// A triangle of a face.
struct FaceTriangle {
  Triangle corners;
  Index face;
};

/// Keeps lists between calls, so that no memory is allocated: one object per thread.
class TriangleCover {
 public:
  /// At least the largest distance from a point of `triangle` to the nearest of `targets`, which are not
  /// none. At most `enough` or a tenth more than the truth, unless that takes too many steps. The bound needs
  /// only the targets of the faces `used()`.
  double bound(const Triangle& triangle, std::span<const FaceTriangle> targets, double enough);
  const std::vector<Index>& used() const { return used_; }

 private:
  struct Piece {
    Triangle corners;
    int depth;
  };
  void settle(const Piece& piece, std::span<const FaceTriangle> targets);
  void accept(double bound, Index face);
  bool cut_along_prism(const Piece& piece, const Triangle& target);

  std::vector<Piece> pieces_;
  std::vector<Index> used_;
  double lower_ = 0, upper_ = 0, enough_ = 0;
  std::size_t steps_ = 0;
};

}  // namespace recede::detail
