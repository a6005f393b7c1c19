#include <recede/geometry/detail/disk_map.h>
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/simple_polygon.h>
#include <recede/geometry/parameterization.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseLU>

#include <cmath>
#include <numbers>

namespace recede {
namespace {

// Angles nearer to 0 or pi, and shorter edges (against the longer one of the same angle), count as this much:
// weights stay positive and finite.
constexpr double k_least_tangent = 1e-6;
constexpr double k_least_length_ratio = 1e-6;
// Border edges shorter than this share of the mean one take as much of the circle.
constexpr double k_least_border_share = 1e-3;
// Triangles of less area, against the square of their longest side, have none but what rounding gave them.
constexpr double k_least_area = 1e-14;
// The longer axis of an ellipse is at most this often the shorter one.
constexpr double k_longest_ellipse = 100;

/// What the angle at v between p and q adds to the weights of p and q.
Vec2 angle_weights(const Vec3& v, const Vec3& p, const Vec3& q) {
  const Vec3 to_p = p - v, to_q = q - v;
  const double length_p = to_p.norm(), length_q = to_q.norm();
  const double longer = std::max(length_p, length_q);
  if (!(longer > 0)) return {1, 1};
  const double sine = to_p.cross(to_q).norm();
  const double cosine = to_p.dot(to_q);
  const double below = length_p * length_q + cosine;  // tan(a/2) = sin a / (1 + cos a)
  const double tangent = sine < below / k_least_tangent ? std::max(sine / below, k_least_tangent)
                         : length_p * length_q > 0      ? 1 / k_least_tangent
                                                        : k_least_tangent;
  const double least = k_least_length_ratio * longer;
  return {tangent / std::max(length_p, least), tangent / std::max(length_q, least)};
}

/// Vertices of the border on the unit circle by arc length, counter-clockwise, the first at (1, 0).
std::vector<Vec2> border_on_circle(const detail::Disk& disk) {
  const std::size_t n = disk.border.size();
  std::vector<double> lengths(n);
  double perimeter = 0;
  for (std::size_t k = 0; k < n; ++k) {
    lengths[k] = (disk.positions[disk.border[(k + 1) % n]] - disk.positions[disk.border[k]]).norm();
    perimeter += lengths[k];
  }
  const double least = perimeter > 0 ? k_least_border_share * perimeter / static_cast<double>(n) : 1;
  double total = 0;
  for (double& length : lengths) total += length = std::max(length, least);
  std::vector<Vec2> points(n);
  double passed = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double angle = 2 * std::numbers::pi * passed / total;
    points[k] = {std::cos(angle), std::sin(angle)};
    passed += lengths[k];
  }
  return points;
}

/// Vertices of the border dropped onto the plane of the disk's vector area. Empty when there is none.
std::vector<Vec2> border_in_plane(const detail::Disk& disk) {
  Vec3 area = Vec3::Zero();
  for (std::size_t t = 0; t < disk.triangles.size(); t += 3) {
    const Vec3& a = disk.positions[disk.triangles[t]];
    area += (disk.positions[disk.triangles[t + 1]] - a).cross(disk.positions[disk.triangles[t + 2]] - a);
  }
  if (!(area.norm() > 0)) return {};
  const Vec3 normal = area.normalized(), x = normal.unitOrthogonal(), y = normal.cross(x);
  std::vector<Vec2> points;
  for (const Index v : disk.border) {
    const Vec3 p = disk.positions[v] - disk.positions[disk.border[0]];
    points.emplace_back(p.dot(x), p.dot(y));
  }
  return points;
}

/// The circle turned, scaled and moved to where it differs least from `border`, in the sense of squares, and
/// `share` of the way from there to `border` itself.
std::vector<Vec2> between(const std::vector<Vec2>& circle, const std::vector<Vec2>& border, double share) {
  const std::size_t n = circle.size();
  Vec2 circle_middle = Vec2::Zero(), border_middle = Vec2::Zero();
  for (std::size_t k = 0; k < n; ++k) {
    circle_middle += circle[k] / static_cast<double>(n);
    border_middle += border[k] / static_cast<double>(n);
  }
  double along = 0, across = 0, squares = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const Vec2 c = circle[k] - circle_middle, b = border[k] - border_middle;
    along += c.dot(b);
    across += c.x() * b.y() - c.y() * b.x();
    squares += c.squaredNorm();
  }
  Eigen::Matrix2d turn;
  turn << along, -across, across, along;
  turn /= squares;
  std::vector<Vec2> points(n);
  for (std::size_t k = 0; k < n; ++k) {
    points[k] = (1 - share) * (turn * (circle[k] - circle_middle)) + share * (border[k] - border_middle);
  }
  return points;
}

/// Solves for the inner vertices of one disk: one factorisation for given weights, any number of borders.
class InnerVertices {
 public:
  explicit InnerVertices(const detail::Disk& disk) : disk_(disk), row_(disk.positions.size(), 0) {
    for (const Index v : disk.border) row_[v] = k_border;
    for (int& row : row_) {
      if (row != k_border) row = n_inner_++;
    }
  }

  /// The weight of neighbour j is multiplied by `factors[j]`. False when numbers fail.
  bool factorise(ParameterizationWeights weights, const std::vector<double>& factors) {
    if (n_inner_ == 0) return true;
    assemble(weights, factors);
    Eigen::SparseMatrix<double> matrix(n_inner_, n_inner_);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    if (!analysed_) solver_.analyzePattern(matrix);
    analysed_ = true;
    solver_.factorize(matrix);
    return solver_.info() == Eigen::Success;
  }

  /// Positions of all vertices. Empty when numbers fail.
  std::vector<Vec2> solve(const std::vector<Vec2>& border) {
    std::vector<Vec2> uvs(row_.size(), Vec2::Zero());
    for (std::size_t k = 0; k < border.size(); ++k) uvs[disk_.border[k]] = border[k];
    if (n_inner_ == 0) return uvs;
    Eigen::Matrix<double, Eigen::Dynamic, 2> right(n_inner_, 2);
    right.setZero();
    for (const auto& entry : border_entries_) {
      right.row(entry.row()) += entry.value() * uvs[static_cast<std::size_t>(entry.col())].transpose();
    }
    const Eigen::Matrix<double, Eigen::Dynamic, 2> solution = solver_.solve(right);
    if (!solution.allFinite()) return {};
    for (std::size_t v = 0; v < uvs.size(); ++v) {
      if (row_[v] != k_border) uvs[v] = solution.row(row_[v]).transpose();
    }
    return uvs;
  }

 private:
  static constexpr int k_border = -1;

  void assemble(ParameterizationWeights weights, const std::vector<double>& factors) {
    entries_.clear();
    border_entries_.clear();
    std::vector<double> sums(static_cast<std::size_t>(n_inner_), 0.0);
    const auto each_weight = [&](const auto& use) {
      for (std::size_t t = 0; t < disk_.triangles.size(); ++t) {
        const std::size_t first = t - t % 3;
        const Index v = disk_.triangles[t], p = disk_.triangles[first + (t + 1) % 3],
                    q = disk_.triangles[first + (t + 2) % 3];
        if (row_[v] == k_border) continue;
        const Vec2 pair = weights == ParameterizationWeights::uniform
                              ? Vec2(0.5, 0.5)
                              : angle_weights(disk_.positions[v], disk_.positions[p], disk_.positions[q]);
        use(row_[v], p, pair.x() * factors[p]);
        use(row_[v], q, pair.y() * factors[q]);
      }
    };
    each_weight([&](int row, Index, double weight) { sums[static_cast<std::size_t>(row)] += weight; });
    for (int row = 0; row < n_inner_; ++row) entries_.emplace_back(row, row, 1.0);
    each_weight([&](int row, Index neighbour, double weight) {
      const double share = weight / sums[static_cast<std::size_t>(row)];
      if (row_[neighbour] == k_border) {
        border_entries_.emplace_back(row, static_cast<int>(neighbour), share);
      } else {
        entries_.emplace_back(row, row_[neighbour], -share);
      }
    });
  }

  const detail::Disk& disk_;
  std::vector<int> row_;  // of an inner vertex in the matrix
  int n_inner_ = 0;
  std::vector<Eigen::Triplet<double>> entries_, border_entries_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>> solver_;
  bool analysed_ = false;
};

void add_triangle(detail::StretchSum& sum, std::span<const Vec3> positions, std::span<const Vec2> uvs,
                  std::span<const Index> triangle) {
  const Index a = triangle[0], b = triangle[1], c = triangle[2];
  sum.add(positions[a], positions[b], positions[c], uvs[a], uvs[b], uvs[c]);
}

/// The affine map T of determinant 1 for which the stretch of uv -> T uv -> surface is least: with M the sum
/// of squared derivatives, the trace of T^-T M T^-1 is least for T^T T = M / sqrt(det M).
void fit_affine(const detail::Disk& disk, std::vector<Vec2>& uvs) {
  detail::StretchSum sum;
  for (std::size_t t = 0; t < disk.triangles.size(); t += 3) {
    add_triangle(sum, disk.positions, uvs, std::span(disk.triangles).subspan(t, 3));
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(sum.metric());
  const double ratio = std::sqrt(axes.eigenvalues()[1] / axes.eigenvalues()[0]);
  if (!(ratio >= 1)) return;  // no area, or not finite
  const double stretch = std::sqrt(std::min(ratio, k_longest_ellipse));
  const Eigen::Matrix2d map =
      axes.eigenvectors() * Vec2(1 / stretch, stretch).asDiagonal() * axes.eigenvectors().transpose();
  for (Vec2& uv : uvs) uv = map * uv;
}

/// Divides each vertex's factor by the root mean squared stretch of the triangles around it.
void divide_by_stretch(const detail::Disk& disk, const std::vector<Vec2>& uvs, std::vector<double>& factors) {
  std::vector<double> areas(factors.size(), 0.0), sums(factors.size(), 0.0);
  for (std::size_t t = 0; t < disk.triangles.size(); t += 3) {
    const auto triangle = std::span(disk.triangles).subspan(t, 3);
    const Vec3& a = disk.positions[triangle[0]];
    const double area = 0.5 * (disk.positions[triangle[1]] - a).cross(disk.positions[triangle[2]] - a).norm();
    detail::StretchSum sum;
    add_triangle(sum, disk.positions, uvs, triangle);
    const double weighted = 0.5 * sum.metric().trace();
    if (!(area > 0) || !std::isfinite(weighted)) continue;
    for (const Index v : triangle) {
      areas[v] += area;
      sums[v] += weighted;
    }
  }
  constexpr double k_most_at_once = 10;
  for (std::size_t v = 0; v < factors.size(); ++v) {
    if (!(sums[v] > 0)) continue;
    factors[v] /= std::clamp(std::sqrt(sums[v] / areas[v]), 1 / k_most_at_once, k_most_at_once);
  }
}

/// Finds the best map of one disk.
class DiskMapper {
 public:
  DiskMapper(const detail::Disk& disk, const ParameterizationOptions& options)
      : disk_(disk), options_(options), inner_(disk), circle_(border_on_circle(disk)) {
    if (options.border == DiskBorder::natural) in_plane_ = border_in_plane(disk);
  }

  Parameterization run() {
    try_weights(options_.weights);
    if (best_.uvs.empty() || best_.flipped > 0) try_weights(ParameterizationWeights::uniform);
    if (best_.uvs.empty()) {  // nothing could be solved
      best_.uvs.assign(disk_.positions.size(), Vec2::Zero());
      best_.flipped = disk_.triangles.size() / 3;
      best_.stretch = measure_stretch(disk_.positions, best_.uvs, disk_.triangles);
    } else {
      lower_stretch();
    }
    return std::move(best_);
  }

 private:
  void try_weights(ParameterizationWeights weights) {
    if (!inner_.factorise(weights, std::vector<double>(disk_.positions.size(), 1.0))) return;
    if (!in_plane_.empty()) try_natural_borders(weights);
    const DiskBorder round = options_.border == DiskBorder::circle ? DiskBorder::circle : DiskBorder::ellipse;
    try_border(round, circle_, weights);
  }

  /// The border in the plane, or what comes near it where that doesn't do.
  void try_natural_borders(ParameterizationWeights weights) {
    if (try_border(DiskBorder::natural, in_plane_, weights)) return;
    for (const double share : {0.75, 0.5, 0.25}) {
      try_border(DiskBorder::natural, between(circle_, in_plane_, share), weights);
    }
  }

  /// Keeps a map when it flips fewer triangles than the best so far, or as many and stretches less.
  bool try_border(DiskBorder kind, const std::vector<Vec2>& border, ParameterizationWeights weights) {
    if (kind == DiskBorder::natural && !detail::is_simple_polygon(border)) return false;
    std::vector<Vec2> uvs = inner_.solve(border);
    if (uvs.empty()) return false;
    if (kind != DiskBorder::circle) fit_affine(disk_, uvs);
    Parameterization map;
    map.flipped = count_flipped(uvs, disk_.triangles);
    if (kind == DiskBorder::natural && map.flipped > 0) return false;
    map.stretch = measure_stretch(disk_.positions, uvs, disk_.triangles);
    map.weights = weights;
    map.border = kind;
    map.uvs = std::move(uvs);
    const bool better = best_.uvs.empty() || map.flipped < best_.flipped ||
                        (map.flipped == best_.flipped && map.stretch.l2 < best_.stretch.l2);
    if (!better) return false;
    best_ = std::move(map);
    best_border_ = border;
    return true;
  }

  void lower_stretch() {
    std::vector<double> factors(disk_.positions.size(), 1.0);
    for (int round = 0; round < options_.stretch_rounds; ++round) {
      divide_by_stretch(disk_, best_.uvs, factors);
      if (!inner_.factorise(best_.weights, factors)) return;
      if (!try_border(best_.border, best_border_, best_.weights)) return;
    }
  }

  const detail::Disk& disk_;
  const ParameterizationOptions& options_;
  InnerVertices inner_;
  std::vector<Vec2> circle_, in_plane_, best_border_;
  Parameterization best_;
};

}  // namespace

std::vector<double> mean_value_weights(const Vec3& v, std::span<const Vec3> ring) {
  std::vector<double> weights(ring.size(), 0.0);
  double sum = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const std::size_t after = (i + 1) % ring.size();
    const Vec2 pair = angle_weights(v, ring[i], ring[after]);
    weights[i] += pair.x();
    weights[after] += pair.y();
    sum += pair.sum();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

namespace detail {

Parameterization map_disk(const Disk& disk, const ParameterizationOptions& options) {
  return DiskMapper(disk, options).run();
}

void StretchSum::add(const Vec3& a, const Vec3& b, const Vec3& c, const Vec2& p, const Vec2& q,
                     const Vec2& r) {
  const Vec3 ab = b - a, ac = c - a;
  const double area = 0.5 * ab.cross(ac).norm();
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  const Vec2 pq = q - p, pr = r - p;
  const double twice_plane_area = pq.x() * pr.y() - pq.y() * pr.x();
  plane_area_ += 0.5 * std::abs(twice_plane_area);
  if (!(area > k_least_area * longest)) return;
  area_ += area;
  if (twice_plane_area == 0) {
    infinite_ = true;
    return;
  }
  const Vec3 by_x = (ab * pr.y() - ac * pq.y()) / twice_plane_area;
  const Vec3 by_y = (ac * pq.x() - ab * pr.x()) / twice_plane_area;
  const double xx = by_x.squaredNorm(), xy = by_x.dot(by_y), yy = by_y.squaredNorm();
  metric_(0, 0) += area * xx;
  metric_(0, 1) += area * xy;
  metric_(1, 0) += area * xy;
  metric_(1, 1) += area * yy;
  largest_ = std::max(largest_, std::sqrt(0.5 * (xx + yy + std::hypot(xx - yy, 2 * xy))));
}

Stretch StretchSum::stretch() const {
  if (!(area_ > 0)) return {};
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  if (infinite_) return {k_infinity, k_infinity};
  const double keep_area = std::sqrt(plane_area_ / area_);
  return {std::sqrt(0.5 * metric_.trace() / area_) * keep_area, largest_ * keep_area};
}

}  // namespace detail

Stretch measure_stretch(std::span<const Vec3> positions, std::span<const Vec2> uvs,
                        std::span<const Index> triangles) {
  detail::StretchSum sum;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    add_triangle(sum, positions, uvs, triangles.subspan(t, 3));
  }
  return sum.stretch();
}

std::size_t count_flipped(std::span<const Vec2> uvs, std::span<const Index> triangles) {
  std::size_t flipped = 0;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    if (detail::orientation(uvs[triangles[t]], uvs[triangles[t + 1]], uvs[triangles[t + 2]]) <= 0) ++flipped;
  }
  return flipped;
}

}  // namespace recede
