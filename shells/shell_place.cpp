#include <recede/shells/detail/prism.h>
#include <recede/shells/detail/shell_pieces.h>
#include <recede/shells/shell.h>

#include <algorithm>
#include <cmath>

namespace recede {

namespace {

using detail::Prism;

Vec3 corner(const Prism& prism, std::size_t k, double height) {
  return (1 - height) * prism.bottom[k] + height * prism.top[k];
}

Vec3 point_in(const Prism& prism, const Vec3& weights, double height) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) sum += weights[static_cast<Eigen::Index>(k)] * corner(prism, k, height);
  return sum;
}

Prism prism_of(const Shell& shell, const ShellLayer& layer, Index triangle) {
  Prism prism;
  for (std::size_t k = 0; k < 3; ++k) {
    const Index v = shell.base.face(triangle)[k];
    prism.bottom[k] = shell.base.positions[v];
    prism.top[k] = layer.tops[v];
  }
  return prism;
}

}  // namespace

Vec3 shell_point(const Shell& shell, const ShellLayer& layer, const ShellPlace& place) {
  return point_in(prism_of(shell, layer, place.triangle), place.weights, place.height);
}

std::optional<ShellPlace> place_in_prism(const Shell& shell, const ShellLayer& layer, Index triangle,
                                         const Vec3& point) {
  const Prism prism = prism_of(shell, layer, triangle);
  const double size = (prism.top[0] - prism.bottom[0]).norm() + (prism.bottom[1] - prism.bottom[0]).norm() +
                      (prism.bottom[2] - prism.bottom[0]).norm();
  constexpr int k_most_steps = 32;
  constexpr double k_close = 1e-12, k_outside = 1e-9;  // of the prism's size; of weights and heights
  Vec3 weights = Vec3::Constant(1.0 / 3);
  double height = 0.5;
  for (int step = 0; step < k_most_steps; ++step) {
    const Vec3 off = point - point_in(prism, weights, height);
    if (off.norm() <= k_close * size) break;
    Vec3 up = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      up += weights[static_cast<Eigen::Index>(k)] * (prism.top[k] - prism.bottom[k]);
    Eigen::Matrix3d jacobian;
    jacobian << corner(prism, 1, height) - corner(prism, 0, height),
        corner(prism, 2, height) - corner(prism, 0, height), up;
    const Vec3 move = jacobian.partialPivLu().solve(off);
    if (!move.allFinite()) return {};
    weights += Vec3(-move.x() - move.y(), move.x(), move.y());
    height += move.z();
  }
  if (!((point - point_in(prism, weights, height)).norm() <= 1e3 * k_close * size)) return {};
  if (weights.minCoeff() < -k_outside || height < -k_outside || height > 1 + k_outside) return {};
  return ShellPlace{triangle, weights, height};
}

PolygonSoup shell_boundary(const Shell& shell) {
  const std::vector<Index>& triangles = shell.base.corner_vertices;
  PolygonSoup boundary;
  boundary.positions = shell.exterior ? shell.exterior->tops : shell.base.positions;
  const auto n = static_cast<Index>(boundary.positions.size());
  const std::vector<Vec3>& inner = shell.interior ? shell.interior->tops : shell.base.positions;
  boundary.positions.insert(boundary.positions.end(), inner.begin(), inner.end());
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const Index a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
    boundary.add_face(std::array<Index, 3>{a, b, c});
    boundary.add_face(std::array<Index, 3>{n + c, n + b, n + a});
  }
  for (const Index corner : detail::find_open_sides(n, triangles)) {
    const Index a = triangles[corner], b = triangles[detail::next_in_triangle(corner)];
    boundary.add_face(std::array<Index, 4>{b, a, n + a, n + b});
  }
  return boundary;
}

ShellThickness reached_thickness(const Shell& shell, const ShellLayer& layer) {
  std::vector<unsigned char> is_used(shell.base.positions.size(), 0);
  for (const Index v : shell.base.corner_vertices) is_used[v] = 1;
  ShellThickness reached{std::numeric_limits<double>::infinity(), 0, 0};
  std::size_t n = 0;
  for (std::size_t v = 0; v < is_used.size(); ++v) {
    if (is_used[v] == 0) continue;
    const double share = (layer.tops[v] - shell.base.positions[v]).norm() / shell.thicknesses[v];
    reached.least = std::min(reached.least, share);
    reached.most = std::max(reached.most, share);
    reached.mean += share;
    ++n;
  }
  reached.mean /= static_cast<double>(n);
  return reached;
}

}  // namespace recede
