#include <recede/geometry/error.h>
#include <recede/lod/detail/map_seams.h>
#include <recede/lod/detail/map_texels.h>

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>
#include <map>

namespace recede::detail {
namespace {

/// Shares of a seam's length, 0 to 1, between which the heights of both sides are quadratic: where either
/// side crosses a line of texel middles.
std::vector<double> breaks_of(const Seam& seam, int size) {
  std::vector<double> shares{0, 1};
  for (const auto& side : {seam.here, seam.there}) {
    const Vec2 from = texel_coordinates(side[0], size), to = texel_coordinates(side[1], size);
    for (Eigen::Index axis = 0; axis < 2; ++axis) {
      const auto [low, high] = std::pair(std::min(from[axis], to[axis]), std::max(from[axis], to[axis]));
      for (double line = std::ceil(low); line < high; ++line) {
        const double share = (line - from[axis]) / (to[axis] - from[axis]);
        if (share > 0 && share < 1) shares.push_back(share);
      }
    }
  }
  std::sort(shares.begin(), shares.end());
  return shares;
}

/// Calls `visit(share, length)` for each piece of a seam between breaks, with the shares of its two ends and
/// its middle, and with its length in texels, on the longer side.
template <typename Visit>
void visit_pieces(const Seam& seam, int size, const Visit& visit) {
  const std::vector<double> breaks = breaks_of(seam, size);
  const double length =
      size * std::max((seam.here[1] - seam.here[0]).norm(), (seam.there[1] - seam.there[0]).norm());
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    visit(std::array{breaks[i], 0.5 * (breaks[i] + breaks[i + 1]), breaks[i + 1]},
          length * (breaks[i + 1] - breaks[i]));
  }
}

Vec2 along(const std::array<Vec2, 2>& side, double share) { return side[0] + share * (side[1] - side[0]); }

/// A place on a seam where both sides are compared.
struct Comparison {
  Footprint here, there;
  double share;  ///< of the integral along the seam in texels, by Simpson's rule
};

/// Three for each piece; between them differences are quadratic.
std::vector<Comparison> compare_sides(const std::vector<Seam>& seams, int size) {
  constexpr std::array k_simpson{1.0 / 6, 4.0 / 6, 1.0 / 6};
  constexpr double k_shortest = 1e-3;  // texels: shorter pieces count like this, lest they have no weight
  std::vector<Comparison> comparisons;
  for (const Seam& seam : seams) {
    visit_pieces(seam, size, [&](const std::array<double, 3>& shares, double length) {
      for (std::size_t i = 0; i < 3; ++i) {
        comparisons.push_back({footprint_of(along(seam.here, shares[i]), size),
                               footprint_of(along(seam.there, shares[i]), size),
                               k_simpson[i] * std::max(length, k_shortest)});
      }
    });
  }
  return comparisons;
}

/// Differences across seams as linear functions of the texels near them.
class SeamSystem {
 public:
  SeamSystem(const std::vector<Seam>& seams, int size) : comparisons_(compare_sides(seams, size)) {
    const auto visit_texels = [this](const auto& visit) {
      for (std::size_t row = 0; row < comparisons_.size(); ++row) {
        for (const auto& [side, sign] :
             {std::pair(&comparisons_[row].here, 1.0), {&comparisons_[row].there, -1.0}}) {
          for (std::size_t k = 0; k < 4; ++k) {
            if (side->weights[k] != 0) visit(row, side->texels[k], sign * side->weights[k]);
          }
        }
      }
    };
    visit_texels([this](std::size_t, Index texel, double) { texels_.push_back(texel); });
    std::sort(texels_.begin(), texels_.end());
    texels_.erase(std::unique(texels_.begin(), texels_.end()), texels_.end());
    std::vector<Eigen::Triplet<double>> entries;
    visit_texels([&](std::size_t row, Index texel, double weight) {
      const auto column = std::lower_bound(texels_.begin(), texels_.end(), texel) - texels_.begin();
      entries.emplace_back(static_cast<int>(row), static_cast<int>(column), weight);
    });
    differences_.resize(static_cast<Eigen::Index>(comparisons_.size()),
                        static_cast<Eigen::Index>(texels_.size()));
    differences_.setFromTriplets(entries.begin(), entries.end());
  }

  const Eigen::SparseMatrix<double>& differences() const { return differences_; }

  /// Values of a map at the texels that are read, in the order of the columns of `differences`.
  template <typename Value>
  Eigen::VectorXd gather(const std::vector<Value>& map) const {
    Eigen::VectorXd values(static_cast<Eigen::Index>(texels_.size()));
    for (std::size_t i = 0; i < texels_.size(); ++i) values[static_cast<Eigen::Index>(i)] = map[texels_[i]];
    return values;
  }

  template <typename Value>
  void scatter(const Eigen::VectorXd& values, std::vector<Value>& map) const {
    for (std::size_t i = 0; i < texels_.size(); ++i)
      map[texels_[i]] = static_cast<Value>(values[static_cast<Eigen::Index>(i)]);
  }

  /// Weights for the squares of differences whose sum is the integral along the seams.
  Eigen::VectorXd shares() const {
    Eigen::VectorXd shares(differences_.rows());
    for (std::size_t i = 0; i < comparisons_.size(); ++i)
      shares[static_cast<Eigen::Index>(i)] = comparisons_[i].share;
    return shares;
  }

 private:
  std::vector<Comparison> comparisons_;
  std::vector<Index> texels_;  // those that are read, in order
  Eigen::SparseMatrix<double> differences_;
};

/// Least change of `found`, each square by its cost, and least differences, each square by its weight.
class LeastChange {
 public:
  LeastChange(const Eigen::SparseMatrix<double>& differences, Eigen::VectorXd found,
              const Eigen::VectorXd& costs)
      : differences_(differences), found_(std::move(found)), costs_(differences.cols(), differences.cols()) {
    costs_.setIdentity();
    costs_.diagonal() = costs;
  }

  Eigen::VectorXd solve(const Eigen::VectorXd& weights) {
    const Eigen::SparseMatrix<double> weighted = differences_.transpose() * weights.asDiagonal();
    Eigen::SparseMatrix<double> normal = weighted * differences_;
    normal += costs_;
    if (!analyzed_) factors_.analyzePattern(normal);
    analyzed_ = true;
    factors_.factorize(normal);
    if (factors_.info() != Eigen::Success) throw Error("the seams of the maps couldn't be closed");
    const Eigen::VectorXd right = weighted * (differences_ * found_);
    return found_ - factors_.solve(right);
  }

 private:
  const Eigen::SparseMatrix<double>& differences_;
  Eigen::VectorXd found_;
  Eigen::SparseMatrix<double> costs_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
  bool analyzed_ = false;
};

/// Samples that are whole numbers, moved by single units until both sides differ by less than one.
class SampleRepair {
 public:
  SampleRepair(const Eigen::SparseMatrix<double>& differences, Eigen::VectorXd samples)
      : columns_(differences),
        rows_(differences),
        samples_(std::move(samples)),
        values_(differences * samples_) {}

  Eigen::VectorXd run() {
    constexpr int k_most_passes = 100;
    bool improved = true;
    for (int pass = 0; improved && pass < k_most_passes; ++pass) {
      improved = false;
      for (Eigen::Index row = 0; row < values_.size(); ++row) improved = repair(row) || improved;
    }
    return std::move(samples_);
  }

 private:
  // Quadratics rise a little above their three compared values; with this most of them stay below 1.
  static constexpr double k_limit = 0.8;
  static constexpr double k_most = 65535;

  static double excess(double difference) {
    const double above = std::max(std::abs(difference) - k_limit, 0.0);
    return above * above;
  }

  /// What all differences together exceed the limit by, less than now when negative.
  double gain(Eigen::Index texel, double move) const {
    double sum = 0;
    for (Eigen::SparseMatrix<double>::InnerIterator entry(columns_, texel); entry; ++entry)
      sum += excess(values_[entry.row()] + move * entry.value()) - excess(values_[entry.row()]);
    return sum;
  }

  /// Returns whether a difference beyond the limit became better.
  bool repair(Eigen::Index row) {
    if (std::abs(values_[row]) <= k_limit) return false;
    double best = -1e-9, best_move = 0;  // a little below 0, so that rounding can't go round in circles
    Eigen::Index best_texel = 0;
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(rows_, row); entry; ++entry) {
      const double move = entry.value() * values_[row] > 0 ? -1 : 1;
      if (samples_[entry.col()] + move < 0 || samples_[entry.col()] + move > k_most) continue;
      const double change = gain(entry.col(), move);
      if (change >= best) continue;
      best = change;
      best_move = move;
      best_texel = entry.col();
    }
    if (best_move == 0) return false;
    samples_[best_texel] += best_move;
    for (Eigen::SparseMatrix<double>::InnerIterator entry(columns_, best_texel); entry; ++entry)
      values_[entry.row()] += best_move * entry.value();
    return true;
  }

  const Eigen::SparseMatrix<double>& columns_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows_;
  Eigen::VectorXd samples_, values_;
};

}  // namespace

std::vector<Seam> find_seams(const PolygonSoup& surface) {
  const std::vector<Index> points = points_of_corners(surface);
  std::map<std::pair<Index, Index>, std::array<Vec2, 2>> first;
  std::vector<Seam> seams;
  for (std::size_t f = 0; f < surface.n_faces(); ++f) {
    const Index begin = surface.face_offsets[f], end = surface.face_offsets[f + 1];
    for (Index c = begin; c < end; ++c) {
      Index from = c, to = c + 1 == end ? begin : c + 1;
      if (points[from] == points[to]) continue;
      if (points[from] > points[to]) std::swap(from, to);
      const std::array<Vec2, 2> side{surface.corner_uvs[from], surface.corner_uvs[to]};
      const auto [known, is_new] = first.try_emplace({points[from], points[to]}, side);
      if (!is_new && known->second != side) seams.push_back({known->second, side});
    }
  }
  return seams;
}

double largest_difference(const std::vector<Seam>& seams, int size,
                          const std::function<double(Index)>& height) {
  const auto lookup = [&](const Vec2& uv) {
    const Footprint footprint = footprint_of(uv, size);
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += footprint.weights[k] * height(footprint.texels[k]);
    return sum;
  };
  double largest = 0;
  for (const Seam& seam : seams) {
    visit_pieces(seam, size, [&](const std::array<double, 3>& shares, double) {
      std::array<double, 3> d{};
      for (std::size_t i = 0; i < 3; ++i)
        d[i] = lookup(along(seam.here, shares[i])) - lookup(along(seam.there, shares[i]));
      largest = std::max({largest, std::abs(d[0]), std::abs(d[2])});
      // d[0] + slope x + bend x^2 for x from 0 to 1.
      const double bend = 2 * (d[0] - 2 * d[1] + d[2]), slope = 4 * d[1] - 3 * d[0] - d[2];
      if (slope * bend < 0 && std::abs(slope) < 2 * std::abs(bend))
        largest = std::max(largest, std::abs(d[0] - slope * slope / (4 * bend)));
    });
  }
  return largest;
}

void close_seams(const std::vector<Seam>& seams, int size, double weight, const std::vector<double>& costs,
                 std::vector<double>& heights) {
  if (seams.empty() || !(weight > 0)) return;
  const SeamSystem system(seams, size);
  LeastChange change(system.differences(), system.gather(heights), system.gather(costs));
  system.scatter(change.solve(weight * system.shares()), heights);
}

void close_seams_within(const std::vector<Seam>& seams, int size, double tolerance,
                        const std::vector<double>& costs, std::vector<double>& heights) {
  if (seams.empty() || !(tolerance > 0)) return;
  constexpr double k_first_weight = 1e6, k_most_growth = 1e4, k_near_enough = 1.2;
  constexpr int k_most_rounds = 15;
  const SeamSystem system(seams, size);
  LeastChange change(system.differences(), system.gather(heights), system.gather(costs));
  Eigen::VectorXd weights = k_first_weight * system.shares(), closed;
  for (int round = 0; round < k_most_rounds; ++round) {
    closed = change.solve(weights);
    const Eigen::VectorXd shares = (system.differences() * closed).cwiseAbs() / tolerance;
    if (shares.maxCoeff() <= k_near_enough) break;
    for (Eigen::Index row = 0; row < shares.size(); ++row)
      weights[row] *= std::clamp(shares[row] * shares[row], 1.0, k_most_growth);
  }
  system.scatter(closed, heights);
}

void repair_samples(const std::vector<Seam>& seams, int size, std::vector<std::uint16_t>& samples) {
  if (seams.empty()) return;
  const SeamSystem system(seams, size);
  system.scatter(SampleRepair(system.differences(), system.gather(samples)).run(), samples);
}

}  // namespace recede::detail
