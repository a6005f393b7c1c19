// The directions in which points differ most.
#pragma once

#include <recede/render/detail/vector_basis.h>

namespace recede::detail {

struct DirectionPrecision {
  /// Of the sum of squares along all directions: ends when a step adds less, as a share.
  double least_gain = 1e-4;
  int most_steps = 20;
  /// Mean squares up to this are of rounding; directions of such are 0.
  double rounding = 0;
};

/// Leading eigenvectors of rows^T rows, `count` columns, the largest first: orthonormal, or 0 beyond the rank
/// of the rows, whose mean should be 0. `start` are directions to begin with, if any. Exact where rows or
/// numbers are few, else by steps of subspace iteration with some directions more than are asked for, each
/// ended by a small eigenvalue problem (Rayleigh and Ritz). Runs in the calling thread.
Eigen::MatrixXf leading_directions(const VectorRows& rows, Eigen::Index count, const Eigen::MatrixXf& start,
                                   const DirectionPrecision& precision);

}  // namespace recede::detail
