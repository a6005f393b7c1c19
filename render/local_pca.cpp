#include <recede/geometry/error.h>
#include <recede/render/detail/half_numbers.h>
#include <recede/render/detail/vector_clusters.h>
#include <recede/render/local_pca.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace recede {
namespace {

using detail::VectorClusters;
using detail::VectorRows;

void check(const LocalPcaOptions& options) {
  const auto in_range = [](const char* what, int value, int least, int most) {
    if (value < least || value > most)
      throw OptionError(fmt::format("local PCA: {} {} to {}, not {}", what, least, most, value));
  };
  constexpr int k_most = std::numeric_limits<int>::max();
  in_range("clusters", options.clusters, 1, 65'536);
  in_range("components", options.components, 0, 64);
  in_range("training vectors", options.training_vectors, 1, k_most);
  in_range("rounds", options.rounds, 1, k_most);
  if (!(options.least_change >= 0)) throw OptionError("local PCA: the least change must not be negative");
}

void check(const VectorSource& vectors) {
  if (vectors.count == 0 || vectors.dimension == 0)
    throw InputError("local PCA: there must be a vector, and it must have a number");
}

/// What each vector has of the directions of its cluster.
VectorRows weights_of(const VectorRows& rows, const VectorClusters& clusters, int components) {
  VectorRows weights(rows.rows(), components);
  detail::for_row_parts(rows.rows(), [&](Eigen::Index first, Eigen::Index count) {
    for (Eigen::Index row = first; row < first + count; ++row) {
      const std::size_t k = clusters.of_vector[static_cast<std::size_t>(row)];
      const Eigen::RowVectorXf rest =
          rows.row(row) - clusters.means.col(static_cast<Eigen::Index>(k)).transpose();
      weights.row(row).noalias() = rest * clusters.directions[k];
    }
  });
  return weights;
}

/// Makes the largest weight of each direction 1, and directions as long as it was: weights can't overflow,
/// and directions are of the data's size.
void take_lengths(VectorRows& weights, VectorClusters& clusters) {
  const Eigen::Index components = weights.cols();
  VectorRows largest = VectorRows::Zero(clusters.means.cols(), components);
  for (Eigen::Index row = 0; row < weights.rows(); ++row) {
    auto of_cluster = largest.row(clusters.of_vector[static_cast<std::size_t>(row)]);
    of_cluster = of_cluster.cwiseMax(weights.row(row).cwiseAbs());
  }
  for (Eigen::Index row = 0; row < weights.rows(); ++row) {
    const auto of_cluster = largest.row(clusters.of_vector[static_cast<std::size_t>(row)]);
    for (Eigen::Index c = 0; c < components; ++c)
      weights(row, c) = of_cluster[c] > 0 ? weights(row, c) / of_cluster[c] : 0;
  }
  for (std::size_t k = 0; k < clusters.directions.size(); ++k)
    clusters.directions[k] *= largest.row(static_cast<Eigen::Index>(k)).asDiagonal();
}

/// Means and directions of all clusters as the vectors have them, by cluster and entry.
std::vector<float> parts_of(const VectorClusters& clusters, const detail::VectorBasis& basis, float unit,
                            int components) {
  const Eigen::Index dimension = basis.directions.rows(), per_entry = components + 1;
  const auto size = static_cast<std::size_t>(dimension * per_entry);
  std::vector<float> parts(clusters.directions.size() * size);
  tbb::parallel_for(std::size_t{0}, clusters.directions.size(), [&](std::size_t k) {
    Eigen::MatrixXf short_parts(basis.directions.cols(), per_entry);
    short_parts << clusters.means.col(static_cast<Eigen::Index>(k)), clusters.directions[k];
    Eigen::Map<VectorRows> long_parts(parts.data() + k * size, dimension, per_entry);
    long_parts.noalias() = basis.directions * (unit * short_parts);
    long_parts.col(0) += basis.mean.transpose();
  });
  return parts;
}

/// The power of two that brings the largest number to between 2^14 and 2^15: halves go up to nearly 2^16, and
/// have all their digits down to 2^-14. Of numbers so small that it would have too few digits itself, the
/// least that has all.
float scale_of(const std::vector<float>& numbers) {
  float largest = 0;
  for (const float number : numbers) largest = std::max(largest, std::abs(number));
  int exponent = 15;
  if (largest > 0) std::frexp(largest, &exponent);
  return std::max(std::ldexp(1.0F, exponent - 15), std::numeric_limits<float>::min());
}

}  // namespace

VectorSource vectors_in(std::span<const float> values, std::size_t dimension) {
  if (dimension == 0 || values.size() % dimension != 0)
    throw InputError("vectors in memory: not a whole number of them");
  return {.count = values.size() / dimension,
          .dimension = dimension,
          .read = [values, dimension](std::size_t first, std::span<float> into) {
            std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(first * dimension), into.size(),
                        into.begin());
          }};
}

LocalPca make_local_pca(const VectorSource& vectors, const LocalPcaOptions& options, Progress* progress) {
  check(options);
  check(vectors);
  LocalPcaOptions useful = options;  // no more directions than there are between vectors
  useful.components = static_cast<int>(
      std::min({static_cast<std::size_t>(options.components), vectors.dimension, vectors.count - 1}));
  useful.clusters = static_cast<int>(std::min(static_cast<std::size_t>(options.clusters), vectors.count));
  const int components = useful.components;

  const detail::VectorBasis basis = detail::find_basis(vectors, useful, progress);
  const detail::VectorCoordinates coordinates = detail::coordinates_of(vectors, basis, progress);
  VectorClusters clusters = detail::find_clusters(coordinates, useful, progress);
  VectorRows weights = weights_of(coordinates.rows, clusters, components);
  take_lengths(weights, clusters);

  LocalPca pca{.dimension = vectors.dimension, .components = components};
  pca.parts = parts_of(clusters, basis, coordinates.unit, components);
  pca.scale = scale_of(pca.parts);
  for (float& part : pca.parts) part = pca.scale * detail::from_half(detail::to_half(part / pca.scale));
  pca.clusters = std::move(clusters.of_vector);
  pca.weights.assign(weights.data(), weights.data() + weights.size());
  for (float& weight : pca.weights) weight = detail::from_half(detail::to_half(weight));
  return pca;
}

float entry(const LocalPca& pca, std::size_t vector, std::size_t index) {
  float value = 0;
  reconstruct(pca, vector, std::span(&value, 1), index);
  return value;
}

void reconstruct(const LocalPca& pca, std::size_t vector, std::span<float> values, std::size_t first) {
  const std::size_t per_entry = pca.parts_per_entry(), components = per_entry - 1;
  const float* weights = pca.weights.data() + vector * components;
  const float* parts = pca.parts.data() + (pca.clusters[vector] * pca.dimension + first) * per_entry;
  for (float& value : values) {
    float sum = parts[0];
    for (std::size_t c = 0; c < components; ++c) sum += weights[c] * parts[c + 1];
    value = sum;
    parts += per_entry;
  }
}

LocalPcaError measure_error(const LocalPca& pca, const VectorSource& vectors, std::size_t sample) {
  check(vectors);
  if (sample == 0) throw OptionError("local PCA: the error of no vectors");
  if (vectors.count != pca.vector_count() || vectors.dimension != pca.dimension)
    throw InputError(fmt::format("local PCA: {} vectors of {} numbers were compressed, not {} of {}",
                                 pca.vector_count(), pca.dimension, vectors.count, vectors.dimension));
  LocalPcaError error{.sample = std::min(sample, vectors.count)};
  std::vector<float> values(vectors.dimension), stored(vectors.dimension);
  float least = std::numeric_limits<float>::max(), most = std::numeric_limits<float>::lowest();
  double squares = 0, worst = -1;
  for (std::size_t i = 0; i < error.sample; ++i) {
    const std::size_t vector = i * vectors.count / error.sample;
    vectors.read(vector, values);
    reconstruct(pca, vector, stored);
    double sum = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      least = std::min(least, values[k]);
      most = std::max(most, values[k]);
      const double difference = static_cast<double>(values[k]) - stored[k];
      sum += difference * difference;
    }
    squares += sum;
    if (!(sum > worst)) continue;
    worst = sum;
    error.worst_vector = vector;
  }
  error.range = static_cast<double>(most) - least;
  if (!(error.range > 0)) return error;
  const auto dimension = static_cast<double>(vectors.dimension);
  error.rms = std::sqrt(squares / (dimension * static_cast<double>(error.sample))) / error.range;
  error.worst_rms = std::sqrt(worst / dimension) / error.range;
  return error;
}

}  // namespace recede
