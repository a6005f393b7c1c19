#include <recede/render/detail/leading_directions.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <random>

namespace recede::detail {
namespace {

constexpr Eigen::Index k_exact_up_to = 64;  // rows or numbers: a millisecond or two
constexpr Eigen::Index k_spare = 8;         // columns more than are asked for

/// Columns of squares along them that are of rounding alone become 0.
void clear_rounding(Eigen::MatrixXf& directions, const Eigen::VectorXd& squares, double least) {
  for (Eigen::Index i = 0; i < directions.cols(); ++i) {
    if (!(squares[i] > least)) directions.col(i).setZero();
  }
}

/// From all products of rows, or of columns if these are fewer.
Eigen::MatrixXf exact_directions(const VectorRows& rows, Eigen::Index count, double least) {
  const bool by_rows = rows.rows() < rows.cols();
  const Eigen::MatrixXd exact = rows.cast<double>();
  Eigen::MatrixXd products;
  if (by_rows)
    products = exact * exact.transpose();
  else
    products = exact.transpose() * exact;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(products);  // the least first
  const Eigen::Index found = std::min(count, products.rows());
  const Eigen::MatrixXd vectors = solved.eigenvectors().rightCols(found).rowwise().reverse();
  Eigen::MatrixXf directions = Eigen::MatrixXf::Zero(rows.cols(), count);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(count);
  squares.head(found) = solved.eigenvalues().tail(found).reverse();
  Eigen::MatrixXd columns;
  if (by_rows)
    columns = exact.transpose() * vectors;
  else
    columns = vectors;
  directions.leftCols(found) = columns.colwise().normalized().cast<float>();
  clear_rounding(directions, squares, least);
  return directions;
}

}  // namespace

Eigen::MatrixXf leading_directions(const VectorRows& rows, Eigen::Index count, const Eigen::MatrixXf& start,
                                   const DirectionPrecision& precision) {
  const Eigen::Index rank = std::min(rows.rows(), rows.cols());
  const double least = precision.rounding * static_cast<double>(rows.rows());
  if (count == 0 || rank == 0) return Eigen::MatrixXf::Zero(rows.cols(), count);
  if (rank <= std::max(k_exact_up_to, count + k_spare)) return exact_directions(rows, count, least);

  std::mt19937 random(1);
  Eigen::MatrixXf directions(rows.cols(), count + k_spare);
  for (float& number : directions.reshaped()) number = random() & 1 ? 1.0F : -1.0F;
  directions = directions / std::sqrt(static_cast<float>(rows.cols()));
  if (start.cols() > 0) directions.leftCols(start.cols()) += start;
  directions = orthonormal(std::move(directions));
  double last = 0;
  for (int step = 0;; ++step) {
    const Eigen::MatrixXf products = rows * directions;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(
        (products.transpose() * products).cast<double>());
    const Eigen::VectorXd squares = solved.eigenvalues().reverse();
    const double sum = squares.head(count).sum();
    if (step >= precision.most_steps || sum - last <= precision.least_gain * sum) {
      const Eigen::MatrixXf turned = solved.eigenvectors().rowwise().reverse().leftCols(count).cast<float>();
      directions = directions * turned;
      clear_rounding(directions, squares, least);
      return directions;
    }
    last = sum;
    directions = orthonormal(rows.transpose() * products);
  }
}

}  // namespace recede::detail
