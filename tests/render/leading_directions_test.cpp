#include <recede/render/detail/leading_directions.h>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace recede::detail {
namespace {

/// Rows of `rank` directions, each of `fall` times the strength of the one before.
VectorRows falling_rows(Eigen::Index rows, Eigen::Index columns, Eigen::Index rank, float fall) {
  std::mt19937 random(7);
  std::normal_distribution<float> number(0, 1);
  VectorRows weights(rows, rank), along(rank, columns);
  for (float& weight : weights.reshaped()) weight = number(random);
  for (float& step : along.reshaped()) step = number(random);
  for (Eigen::Index i = 0; i < rank; ++i) along.row(i) *= std::pow(fall, static_cast<float>(i));
  return weights * along;
}

TEST(LeadingDirections, HoldAsMuchAsTheLargestEigenvectors) {
  struct Case {
    Eigen::Index rows, columns, count;
  };
  // Few rows, few columns, and neither.
  for (const Case& c : {Case{40, 300, 6}, Case{300, 50, 6}, Case{300, 200, 1}, Case{300, 200, 8},
                        Case{150, 400, 12}, Case{90, 80, 64}}) {
    const VectorRows rows = falling_rows(c.rows, c.columns, std::min(c.rows, c.columns), 0.98F);
    const Eigen::MatrixXf found =
        leading_directions(rows, c.count, {}, {.least_gain = 1e-7, .most_steps = 100});
    ASSERT_EQ(found.rows(), c.columns);
    ASSERT_EQ(found.cols(), c.count);
    const Eigen::MatrixXf should_be_one = found.transpose() * found;
    EXPECT_TRUE(should_be_one.isIdentity(1e-5F));

    const Eigen::MatrixXd exact = rows.cast<double>();
    const Eigen::VectorXd eigenvalues =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(exact.transpose() * exact).eigenvalues().reverse();
    const Eigen::VectorXd squares = (exact * found.cast<double>()).colwise().squaredNorm();
    // Steps end when one gains 1e-7, and floats have seven digits.
    EXPECT_NEAR(squares.sum() / eigenvalues.head(c.count).sum(), 1, 1e-5) << c.rows << " x " << c.columns;
    for (Eigen::Index i = 1; i < c.count; ++i) EXPECT_LE(squares[i], squares[i - 1] * (1 + 1e-5)) << i;
  }
}

TEST(LeadingDirections, AreNoneBeyondTheRankOfTheRows) {
  for (const Eigen::Index rows : {30, 200}) {
    const VectorRows flat = falling_rows(rows, 150, 3, 0.5F);
    const double mean_square = flat.cast<double>().squaredNorm() / static_cast<double>(rows);
    const Eigen::MatrixXf found = leading_directions(flat, 5, {}, {.rounding = 1e-12 * mean_square});
    for (Eigen::Index i = 0; i < 5; ++i) EXPECT_NEAR(found.col(i).norm(), i < 3 ? 1 : 0, 1e-5) << rows;
    const VectorRows left = flat - flat * found * found.transpose();
    EXPECT_LT(left.cwiseAbs().maxCoeff(), 1e-5F * flat.cwiseAbs().maxCoeff());
  }
  EXPECT_TRUE(leading_directions(VectorRows::Zero(100, 90), 3, {}, {}).isZero(0));
  EXPECT_TRUE(leading_directions(VectorRows::Zero(1, 90), 3, {}, {}).isZero(0));
  EXPECT_EQ(leading_directions(VectorRows::Zero(100, 90), 0, {}, {}).cols(), 0);
}

}  // namespace
}  // namespace recede::detail
