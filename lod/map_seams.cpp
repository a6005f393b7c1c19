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

/// Differences across seams as linear functions of the texels near them.
class SeamSystem {
 public:
  SeamSystem(const std::vector<Seam>& seams, int size) : size_(size) {
    constexpr std::array k_simpson{1.0 / 6, 4.0 / 6, 1.0 / 6};
    for (const Seam& seam : seams) {
      visit_pieces(seam, size, [&](const std::array<double, 3>& shares, double length) {
        for (std::size_t i = 0; i < 3; ++i) {
          const double root = std::sqrt(k_simpson[i] * length);
          add(footprint_of(along(seam.here, shares[i]), size_), root);
          add(footprint_of(along(seam.there, shares[i]), size_), -root);
          ++rows_;
        }
      });
    }
    texels_.reserve(entries_.size());
    for (const auto& entry : entries_) texels_.push_back(static_cast<Index>(entry.col()));
    std::sort(texels_.begin(), texels_.end());
    texels_.erase(std::unique(texels_.begin(), texels_.end()), texels_.end());
  }

  void solve(double weight, std::vector<double>& heights) const {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(entries_.size());
    for (const auto& entry : entries_) {
      const auto column = std::lower_bound(texels_.begin(), texels_.end(), entry.col()) - texels_.begin();
      entries.emplace_back(entry.row(), static_cast<int>(column), entry.value());
    }
    const auto n = static_cast<Eigen::Index>(texels_.size());
    Eigen::SparseMatrix<double> differences(rows_, n), unit(n, n);
    differences.setFromTriplets(entries.begin(), entries.end());
    unit.setIdentity();
    Eigen::VectorXd found(n);
    for (Eigen::Index i = 0; i < n; ++i) found[i] = heights[texels_[static_cast<std::size_t>(i)]];
    const Eigen::SparseMatrix<double> transposed = differences.transpose();
    Eigen::SparseMatrix<double> normal = weight * (transposed * differences);
    normal += unit;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(normal);
    if (factors.info() != Eigen::Success) throw Error("the seams of the maps couldn't be closed");
    const Eigen::VectorXd right = -weight * (transposed * (differences * found));
    const Eigen::VectorXd change = factors.solve(right);
    for (Eigen::Index i = 0; i < n; ++i) heights[texels_[static_cast<std::size_t>(i)]] += change[i];
  }

 private:
  void add(const Footprint& footprint, double factor) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (footprint.weights[k] != 0)
        entries_.emplace_back(rows_, static_cast<int>(footprint.texels[k]), factor * footprint.weights[k]);
    }
  }

  int size_, rows_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;  // sample, texel, weight
  std::vector<Index> texels_;                    // those that are read, in order
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

void close_seams(const std::vector<Seam>& seams, int size, double weight, std::vector<double>& heights) {
  if (seams.empty() || !(weight > 0)) return;
  SeamSystem(seams, size).solve(weight, heights);
}

}  // namespace recede::detail
