// The space in which long vectors are sorted into clusters.
#pragma once

#include <recede/render/local_pca.h>

#include <Eigen/Core>

#include <functional>

namespace recede::detail {

/// A vector in each row.
using VectorRows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Calls `use(first, count)` from several threads for parts of `rows` rows. The parts are the same for any
/// number of threads, so that products of matrices are.
void for_row_parts(Eigen::Index rows, const std::function<void(Eigen::Index, Eigen::Index)>& use);

/// Orthonormal columns with the same span; a full set if that has fewer directions.
Eigen::MatrixXf orthonormal(Eigen::MatrixXf columns);

/// Orthonormal directions around a mean.
struct VectorBasis {
  Eigen::RowVectorXf mean;
  Eigen::MatrixXf directions;  ///< one in each column
};

/// The directions in which the training vectors differ most, about: as many as `options` has means and
/// components, from 256 to 1024, and at most as there are numbers or training vectors.
VectorBasis find_basis(const VectorSource& vectors, const LocalPcaOptions& options, Progress* progress);

/// Vectors by the directions of a basis, from its mean.
struct VectorCoordinates {
  VectorRows rows;  ///< the largest number is from 1/2 to 1, so that squares of squares stay finite
  float unit = 1;   ///< a power of two; the vectors are mean + `unit` x row
  /// The mean square of a vector's length, from 0 and in units: what rounding errors are relative to.
  double mean_square = 0;
};

/// Reads them in blocks of 64 MB, or one by one. Throws `InputError` for a number that isn't finite, and
/// `Cancelled`; so does `find_basis`.
VectorCoordinates coordinates_of(const VectorSource& vectors, const VectorBasis& basis, Progress* progress);

}  // namespace recede::detail
