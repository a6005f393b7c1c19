#include <recede/render/detail/leading_directions.h>
#include <recede/render/detail/vector_clusters.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace recede::detail {
namespace {

/// Differences of this share of a vector's length may come from rounding.
constexpr double k_rounding = 1e-6;
constexpr DirectionPrecision k_while_sorting{.least_gain = 1e-4, .most_steps = 20};
constexpr DirectionPrecision k_at_the_end{.least_gain = 1e-7, .most_steps = 100};

class ClusterSearch {
 public:
  ClusterSearch(const VectorCoordinates& coordinates, const LocalPcaOptions& options, Progress* progress)
      : rows_(coordinates.rows),
        options_(options),
        rounding_(k_rounding * k_rounding * coordinates.mean_square),
        progress_(progress),
        errors_(static_cast<std::size_t>(rows_.rows())) {
    clusters_.of_vector.resize(errors_.size());
  }

  VectorClusters find() {
    draw_means();
    clusters_.directions.assign(cluster_count(), Eigen::MatrixXf(rows_.cols(), 0));
    // The start needn't be the best of clusters without directions.
    improve("sorting by means", 0, 10, 0.01);
    if (options_.components > 0) {
      update(options_.components, k_while_sorting);
      improve("sorting by directions", options_.components, options_.rounds, options_.least_change);
    }
    update(options_.components, k_at_the_end);
    return std::move(clusters_);
  }

 private:
  std::size_t cluster_count() const { return static_cast<std::size_t>(clusters_.means.cols()); }

  /// k-means++: each next mean is a vector, of some that are drawn by their squared distances to those before
  /// the one that lowers these most.
  void draw_means() {
    std::mt19937_64 random(options_.seed);
    const auto number = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
    constexpr int k_candidates = 4;
    clusters_.means.resize(rows_.cols(), options_.clusters);
    auto drawn = static_cast<Eigen::Index>(number() * static_cast<double>(errors_.size()));
    clusters_.means.col(0) = rows_.row(drawn);
    std::vector<float> nearest(errors_.size(), std::numeric_limits<float>::max());
    double sum = lower_distances(nearest, drawn);
    Eigen::Index count = 1;
    // When nothing is left of them, all vectors are means already.
    for (; count < clusters_.means.cols() && sum > 0; ++count) {
      report_progress(progress_, "drawing means", static_cast<double>(count) / options_.clusters);
      std::vector<float> best_nearest;
      double best = std::numeric_limits<double>::max();
      for (int i = 0; i < k_candidates; ++i) {
        drawn = draw_by(nearest, number() * sum);
        std::vector<float> with = nearest;
        const double sum_with = lower_distances(with, drawn);
        if (!(sum_with < best)) continue;
        best = sum_with;
        best_nearest = std::move(with);
        clusters_.means.col(count) = rows_.row(drawn);
      }
      nearest = std::move(best_nearest);
      sum = best;
    }
    clusters_.means.conservativeResize(Eigen::NoChange, count);
  }

  /// Squared distances of all vectors to the nearest mean, with one more mean; 0 where they are of rounding.
  /// Returns their sum.
  double lower_distances(std::vector<float>& nearest, Eigen::Index mean) const {
    for_row_parts(rows_.rows(), [&](Eigen::Index first, Eigen::Index part) {
      for (Eigen::Index row = first; row < first + part; ++row) {
        const float square = (rows_.row(row) - rows_.row(mean)).squaredNorm();
        float& least = nearest[static_cast<std::size_t>(row)];
        least = std::min(least, square > rounding_ ? square : 0);
      }
    });
    return std::accumulate(nearest.begin(), nearest.end(), 0.0);
  }

  /// The vector up to which squares sum to more than `sum`; the last of those that have any.
  static Eigen::Index draw_by(const std::vector<float>& squares, double sum) {
    std::size_t drawn = 0;
    for (std::size_t i = 0; i < squares.size(); ++i) {
      if (!(squares[i] > 0)) continue;
      drawn = i;
      if ((sum -= squares[i]) < 0) break;
    }
    return static_cast<Eigen::Index>(drawn);
  }

  void improve(std::string_view stage, int components, int most_rounds, double least_change) {
    double last = 0;
    for (int round = 0;; ++round) {
      report_progress(progress_, stage, static_cast<double>(round) / most_rounds);
      const double sum = assign(components);
      const bool last_round = round + 1 >= most_rounds || (round > 0 && last - sum <= least_change * last);
      if (last_round || sum <= rounding_ * static_cast<double>(errors_.size())) break;
      last = sum;
      update(components, k_while_sorting);
    }
    report_progress(progress_, stage, 1);
  }

  /// Gives each vector to the cluster that loses least of it; returns the sum of squares of what is lost.
  double assign(int components) {
    const Eigen::Index clusters = clusters_.means.cols();
    // All products with means and directions at once, as they are a product of matrices.
    Eigen::MatrixXf all(rows_.cols(), clusters * (components + 1));
    Eigen::VectorXf along_mean(clusters * components);
    all.leftCols(clusters) = clusters_.means;
    for (Eigen::Index k = 0; k < clusters; ++k) {
      const Eigen::MatrixXf& directions = clusters_.directions[static_cast<std::size_t>(k)];
      all.middleCols(clusters + k * components, components) = directions;
      along_mean.segment(k * components, components) = directions.transpose() * clusters_.means.col(k);
    }
    const Eigen::VectorXf squares = clusters_.means.colwise().squaredNorm();
    for_row_parts(rows_.rows(), [&](Eigen::Index first, Eigen::Index part) {
      const VectorRows products = rows_.middleRows(first, part) * all;
      for (Eigen::Index i = 0; i < part; ++i) {
        const float square = rows_.row(first + i).squaredNorm();
        const float* by_mean = products.row(i).data();
        const float* by_direction = by_mean + clusters;
        float least = std::numeric_limits<float>::max();
        Eigen::Index best = 0;
        for (Eigen::Index k = 0; k < clusters; ++k) {
          float error = square - 2 * by_mean[k] + squares[k];
          for (Eigen::Index c = k * components; c < (k + 1) * components; ++c) {
            const float along = by_direction[c] - along_mean[c];
            error -= along * along;
          }
          if (error < least) {
            least = error;
            best = k;
          }
        }
        const auto vector = static_cast<std::size_t>(first + i);
        clusters_.of_vector[vector] = static_cast<std::uint16_t>(best);
        errors_[vector] = loss(first + i, best, components);
      }
    });
    double sum = 0;
    for (const float error : errors_) sum += error;
    return sum;
  }

  /// The square of what a cluster loses of a vector, without the differences of large numbers that are good
  /// enough to choose by.
  float loss(Eigen::Index row, Eigen::Index cluster, int components) const {
    Eigen::VectorXf rest = rows_.row(row).transpose() - clusters_.means.col(cluster);
    if (components > 0) {
      const Eigen::MatrixXf& directions = clusters_.directions[static_cast<std::size_t>(cluster)];
      const Eigen::VectorXf along = directions.transpose() * rest;
      rest.noalias() -= directions * along;
    }
    return rest.squaredNorm();
  }

  /// Means and directions of the vectors that clusters have now.
  void update(int components, DirectionPrecision precision) {
    precision.rounding = rounding_;
    const std::vector<std::vector<Eigen::Index>> members = fill_empty_clusters();
    tbb::parallel_for(std::size_t{0}, members.size(), [&](std::size_t k) {
      VectorRows rows(static_cast<Eigen::Index>(members[k].size()), rows_.cols());
      Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(rows_.cols());
      for (Eigen::Index i = 0; i < rows.rows(); ++i) {
        rows.row(i) = rows_.row(members[k][static_cast<std::size_t>(i)]);
        sum += rows.row(i).cast<double>();
      }
      const Eigen::RowVectorXf mean = (sum / static_cast<double>(rows.rows())).cast<float>();
      rows.rowwise() -= mean;
      clusters_.means.col(static_cast<Eigen::Index>(k)) = mean;
      clusters_.directions[k] = leading_directions(rows, components, clusters_.directions[k], precision);
    });
  }

  /// The vectors of each cluster. One without any takes the vector that loses most; if all are exact, it
  /// goes.
  std::vector<std::vector<Eigen::Index>> fill_empty_clusters() {
    std::vector<std::vector<Eigen::Index>> members(cluster_count());
    std::vector<std::size_t> sizes(cluster_count(), 0);
    for (const std::uint16_t k : clusters_.of_vector) ++sizes[k];
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      if (sizes[k] > 0) continue;
      const auto worst = std::max_element(errors_.begin(), errors_.end());
      const auto vector = static_cast<std::size_t>(worst - errors_.begin());
      if (!(*worst > rounding_) || sizes[clusters_.of_vector[vector]] < 2) continue;
      *worst = 0;
      --sizes[clusters_.of_vector[vector]];
      clusters_.of_vector[vector] = static_cast<std::uint16_t>(k);
      clusters_.directions[k].setZero();
      ++sizes[k];
    }
    std::vector<std::size_t> new_number(sizes.size(), 0);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < sizes.size(); ++k) {
      if (sizes[k] == 0) continue;
      clusters_.directions[kept] = clusters_.directions[k];
      new_number[k] = kept++;
    }
    clusters_.directions.resize(kept);
    clusters_.means.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(kept));
    members.resize(kept);
    for (std::size_t vector = 0; vector < errors_.size(); ++vector) {
      std::uint16_t& k = clusters_.of_vector[vector];
      k = static_cast<std::uint16_t>(new_number[k]);
      members[k].push_back(static_cast<Eigen::Index>(vector));
    }
    return members;
  }

  const VectorRows& rows_;
  const LocalPcaOptions& options_;
  double rounding_;  // squared distances up to this are none
  Progress* progress_;
  std::vector<float> errors_;  // of each vector, squared
  VectorClusters clusters_;
};

}  // namespace

VectorClusters find_clusters(const VectorCoordinates& coordinates, const LocalPcaOptions& options,
                             Progress* progress) {
  return ClusterSearch(coordinates, options, progress).find();
}

}  // namespace recede::detail
