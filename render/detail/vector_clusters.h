// Vectors sorted into clusters, each with a mean and directions of its own.
#pragma once

#include <recede/render/detail/vector_basis.h>

namespace recede::detail {

struct VectorClusters {
  Eigen::MatrixXf means;                    ///< a column for each cluster
  std::vector<Eigen::MatrixXf> directions;  ///< by cluster: a column each, orthonormal or 0
  std::vector<std::uint16_t> of_vector;
};

/// What `make_local_pca` says of its rounds; no cluster is empty. Throws `Cancelled`.
VectorClusters find_clusters(const VectorCoordinates& coordinates, const LocalPcaOptions& options,
                             Progress* progress);

}  // namespace recede::detail
