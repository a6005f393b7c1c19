#include <recede/geometry/error.h>
#include <recede/render/detail/vector_basis.h>

#include <Eigen/QR>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace recede::detail {
namespace {

constexpr Eigen::Index k_rows_at_once = 128;      // a part for one thread
constexpr float k_most = 1e15F;                   // sums of squares stay finite
constexpr std::size_t k_block_numbers = 1 << 24;  // 64 MB
/// Directions at least: when few are wanted, more are needed to find them.
constexpr Eigen::Index k_least_directions = 256;
/// At most: 2304 instead lower the error of 256 clusters of texels with 8 components by its 300th part, in
/// twice the time.
constexpr Eigen::Index k_most_directions = 1024;

Eigen::Index to_index(std::size_t number) { return static_cast<Eigen::Index>(number); }

void read_rows(const VectorSource& vectors, std::size_t first, float* into, std::size_t count) {
  const std::size_t numbers = count * vectors.dimension;
  vectors.read(first, std::span(into, numbers));
  const auto good = [](float number) { return std::abs(number) <= k_most; };
  const float* bad = std::find_if_not(into, into + numbers, good);
  if (bad == into + numbers) return;
  const auto at = static_cast<std::size_t>(bad - into);
  throw InputError(fmt::format("local PCA: number {} of vector {} isn't finite, or beyond {:g}",
                               at % vectors.dimension, first + at / vectors.dimension, k_most));
}

/// Evenly from all vectors.
VectorRows read_training(const VectorSource& vectors, std::size_t count, Progress* progress) {
  VectorRows rows(to_index(count), to_index(vectors.dimension));
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 64 == 0)
      report_progress(progress, "reading training vectors",
                      static_cast<double>(i) / static_cast<double>(count));
    const std::size_t vector = i * vectors.count / count;
    read_rows(vectors, vector, rows.row(to_index(i)).data(), 1);
  }
  return rows;
}

Eigen::RowVectorXf mean_of(const VectorRows& rows) {
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(rows.cols());
  for (Eigen::Index row = 0; row < rows.rows(); ++row) sum += rows.row(row).cast<double>();
  return (sum / static_cast<double>(rows.rows())).cast<float>();
}

/// Random signs: sums of all rows, so that none is left out.
Eigen::MatrixXf random_signs(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Eigen::MatrixXf signs(rows, columns);
  for (float& sign : signs.reshaped()) sign = random() & 1 ? 1.0F : -1.0F;
  return signs;
}

/// rows^T * by
Eigen::MatrixXf sums_of_rows(const VectorRows& rows, const Eigen::MatrixXf& by) {
  Eigen::MatrixXf sums(rows.cols(), by.cols());
  for_row_parts(rows.cols(), [&](Eigen::Index first, Eigen::Index count) {
    sums.middleRows(first, count).noalias() = rows.middleCols(first, count).transpose() * by;
  });
  return sums;
}

/// rows * by
Eigen::MatrixXf products_of_rows(const VectorRows& rows, const Eigen::MatrixXf& by) {
  Eigen::MatrixXf products(rows.rows(), by.cols());
  for_row_parts(rows.rows(), [&](Eigen::Index first, Eigen::Index count) {
    products.middleRows(first, count).noalias() = rows.middleRows(first, count) * by;
  });
  return products;
}

/// Divides by the power of two that brings the largest number to between 1/2 and 1, and returns it.
float take_unit(VectorRows& rows) {
  int exponent = 0;
  std::frexp(rows.cwiseAbs().maxCoeff(), &exponent);
  const float unit = std::ldexp(1.0F, exponent);
  rows /= unit;
  return unit;
}

}  // namespace

Eigen::MatrixXf orthonormal(Eigen::MatrixXf columns) {
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXf>> factors(columns);
  return factors.householderQ() * Eigen::MatrixXf::Identity(columns.rows(), columns.cols());
}

void for_row_parts(Eigen::Index rows, const std::function<void(Eigen::Index, Eigen::Index)>& use) {
  const Eigen::Index parts = (rows + k_rows_at_once - 1) / k_rows_at_once;
  tbb::parallel_for(Eigen::Index{0}, parts, [&](Eigen::Index part) {
    const Eigen::Index first = part * k_rows_at_once;
    use(first, std::min(k_rows_at_once, rows - first));
  });
}

VectorBasis find_basis(const VectorSource& vectors, const LocalPcaOptions& options, Progress* progress) {
  const std::size_t training = std::min(vectors.count, static_cast<std::size_t>(options.training_vectors));
  VectorRows rows = read_training(vectors, training, progress);
  VectorBasis basis{.mean = mean_of(rows), .directions = {}};
  const Eigen::Index wanted = Eigen::Index{options.clusters} * (options.components + 1);
  const Eigen::Index count = std::min(rows.cols(), std::clamp(wanted, k_least_directions, k_most_directions));
  if (count == rows.cols()) {
    basis.directions = Eigen::MatrixXf::Identity(count, count);
    return basis;
  }
  constexpr std::string_view k_stage = "finding directions";
  report_progress(progress, k_stage, 0);
  for_row_parts(rows.rows(), [&](Eigen::Index first, Eigen::Index part) {
    rows.middleRows(first, part).rowwise() -= basis.mean;
  });
  take_unit(rows);
  if (count >= rows.rows()) {
    basis.directions = orthonormal(rows.transpose());
    return basis;
  }
  basis.directions = orthonormal(sums_of_rows(rows, random_signs(rows.rows(), count, options.seed)));
  report_progress(progress, k_stage, 1.0 / 3);
  // Once over the vectors again: directions of small variance fall off by its cube instead.
  const Eigen::MatrixXf products = products_of_rows(rows, basis.directions);
  report_progress(progress, k_stage, 2.0 / 3);
  basis.directions = orthonormal(sums_of_rows(rows, products));
  report_progress(progress, k_stage, 1);
  return basis;
}

VectorCoordinates coordinates_of(const VectorSource& vectors, const VectorBasis& basis, Progress* progress) {
  VectorCoordinates result{.rows = VectorRows(to_index(vectors.count), basis.directions.cols())};
  std::vector<double> squares(vectors.count);
  const std::size_t most = std::max<std::size_t>(1, k_block_numbers / vectors.dimension);
  VectorRows block;
  for (std::size_t block_first = 0; block_first < vectors.count; block_first += most) {
    report_progress(progress, "projecting vectors",
                    static_cast<double>(block_first) / static_cast<double>(vectors.count));
    const std::size_t block_count = std::min(most, vectors.count - block_first);
    block.resize(to_index(block_count), to_index(vectors.dimension));
    read_rows(vectors, block_first, block.data(), block_count);
    for_row_parts(block.rows(), [&](Eigen::Index first, Eigen::Index count) {
      for (Eigen::Index row = first; row < first + count; ++row)
        squares[block_first + static_cast<std::size_t>(row)] = block.row(row).cast<double>().squaredNorm();
      auto part = block.middleRows(first, count);
      part.rowwise() -= basis.mean;
      result.rows.middleRows(to_index(block_first) + first, count).noalias() = part * basis.directions;
    });
  }
  report_progress(progress, "projecting vectors", 1);
  result.unit = take_unit(result.rows);
  const double square_unit = static_cast<double>(result.unit) * result.unit;
  for (const double square : squares)
    result.mean_square += square / square_unit / static_cast<double>(vectors.count);
  return result;
}

}  // namespace recede::detail
