#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/shells/detail/shell_cell.h>
#include <recede/shells/layer_grid.h>
#include <recede/shells/volume_texture.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede {
namespace {

// A triangle in texels, and places in it.
struct FlatTriangle {
  std::array<Vec2, 3> corners;
  double area = 0;  ///< twice, below 0 where it is mirrored

  explicit FlatTriangle(const std::array<Vec2, 3>& at) : corners(at) {
    const Vec2 first = at[1] - at[0], second = at[2] - at[0];
    area = first.x() * second.y() - first.y() * second.x();
  }

  Vec3 weights(const Vec2& place) const {
    Vec3 result;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 side = corners[(k + 2) % 3] - corners[(k + 1) % 3], off = place - corners[(k + 1) % 3];
      result[static_cast<int>(k)] = (side.x() * off.y() - side.y() * off.x()) / area;
    }
    return result;
  }

  // How far inside of all sides a place is, or how far outside of the triangle, below 0.
  double inside_by(const Vec2& place, const Vec3& at) const {
    if (at.minCoeff() < 0) return -(nearest(place) - place).norm();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
      const double side = (corners[(k + 2) % 3] - corners[(k + 1) % 3]).norm();
      least = std::min(least, at[static_cast<int>(k)] * std::abs(area) / side);
    }
    return least;
  }

  Vec2 nearest(const Vec2& place) const {
    const auto in_space = [](const Vec2& p) { return Vec3(p.x(), p.y(), 0); };
    return closest_point_on_triangle(in_space(place),
                                     {in_space(corners[0]), in_space(corners[1]), in_space(corners[2])})
        .head<2>();
  }
};

/// Where in a quad with these corners a place is: none where it isn't found.
std::optional<Vec2> along_quad(const std::array<Vec2, 4>& corners, const Vec2& place) {
  constexpr int k_most_steps = 32;
  constexpr double k_exact = 1e-12;  // of the quad's sides
  Vec2 along(0.5, 0.5);
  for (int step = 0; step < k_most_steps; ++step) {
    const detail::FacePlace at{along.x(), along.y()};
    const detail::FaceWeights weights = detail::weights_at(4, at);
    const auto [u, v] = detail::weight_steps_at(4, at);
    Vec2 off = place;
    Eigen::Matrix2d jacobian = Eigen::Matrix2d::Zero();
    for (std::size_t k = 0; k < 4; ++k) {
      off -= weights[k] * corners[k];
      jacobian.col(0) += u[k] * corners[k];
      jacobian.col(1) += v[k] * corners[k];
    }
    const Vec2 move = jacobian.inverse() * off;
    if (!move.allFinite()) return {};
    along += move;
    if (move.cwiseAbs().maxCoeff() <= k_exact) return along;
  }
  return {};
}

const ShellLayer& layer_on(const Shell* shell, ShellSide side) {
  if (!shell) throw InputError("a grid needs a shell");
  if (side == ShellSide::envelope) throw OptionError("a grid fills one layer: the exterior or interior one");
  const std::optional<ShellLayer>& layer = side == ShellSide::exterior ? shell->exterior : shell->interior;
  if (!layer) throw InputError("the shell has no layer on the grid's side");
  return *layer;
}

void check_coordinates(const PolygonSoup& base) {
  if (base.corner_uvs.empty()) throw InputError("a shell to fill needs texture coordinates");
  constexpr double k_rounding = 1e-9;  // of coordinates that were written as text
  for (std::size_t corner = 0; corner < base.corner_uvs.size(); ++corner) {
    const Vec2& uv = base.corner_uvs[corner];
    if (!(uv.minCoeff() >= -k_rounding && uv.maxCoeff() <= 1 + k_rounding)) {
      throw InputError(fmt::format(
          "texture coordinates of a shell to fill are from 0 to 1: triangle {} has ({:.6g}, {:.6g})",
          corner / 3, uv.x(), uv.y()));
    }
  }
}

}  // namespace

LayerGrid::LayerGrid(std::shared_ptr<const Shell> shell, ShellSide side, const std::array<int, 3>& size)
    : shell_(std::move(shell)), layer_(&layer_on(shell_.get(), side)), size_(size) {
  check_texels(size);
  check_coordinates(shell_->base);
  set_columns();
  set_quads();
  set_texel_sides();
}

void LayerGrid::set_columns() {
  const std::array<double, 2> texels{static_cast<double>(size_[0]), static_cast<double>(size_[1])};
  columns_.resize(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]));
  std::vector<double> inside_by(columns_.size(), -k_gutter);
  for (Index t = 0; t < shell_->base.n_faces(); ++t) {
    std::array<Vec2, 3> corners;
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = shell_->base.corner_uvs[3 * t + k].cwiseProduct(Vec2(texels[0], texels[1]));
    const FlatTriangle triangle(corners);
    const auto range = [&](int axis, int size) {
      const auto [least, most] = std::minmax({corners[0][axis], corners[1][axis], corners[2][axis]});
      return std::pair(std::max(0, static_cast<int>(std::ceil(least - k_gutter - 0.5))),
                       std::min(size - 1, static_cast<int>(std::floor(most + k_gutter - 0.5))));
    };
    const auto [i_first, i_last] = range(0, size_[0]);
    const auto [j_first, j_last] = range(1, size_[1]);
    bool is_met = false;
    for (int j = j_first; triangle.area != 0 && j <= j_last; ++j) {
      for (int i = i_first; i <= i_last; ++i) {
        const Vec2 middle(i + 0.5, j + 0.5);
        Vec3 weights = triangle.weights(middle);
        const double inside = triangle.inside_by(middle, weights);
        is_met = is_met || inside >= 0;
        const std::size_t at =
            static_cast<std::size_t>(j) * static_cast<std::size_t>(size_[0]) + static_cast<std::size_t>(i);
        constexpr double k_touching = 1e-6;  // texels: neighbours share sides up to rounding
        if (inside > k_touching && inside_by[at] > k_touching) {
          throw InputError(fmt::format(
              "texture coordinates of triangles {} and {} lie above each other: the shell needs an atlas",
              columns_[at].triangle, t));
        }
        if (!(inside > inside_by[at])) continue;
        inside_by[at] = inside;
        constexpr double k_farthest = -2;  // slivers don't go on as planes
        if (weights.minCoeff() < k_farthest) weights = triangle.weights(triangle.nearest(middle));
        columns_[at] = {t, inside >= 0, weights};
      }
    }
    missed_ += is_met ? 0 : 1;
  }
}

void LayerGrid::set_quads() {
  std::vector<Index> quads(shell_->base.n_faces(), k_no_index);
  for (const Index quad : layer_->hexahedra) quads[quad] = quads[quad + 1] = quad;
  for (int j = 0; j < size_[1]; ++j) {
    for (int i = 0; i < size_[0]; ++i) {
      Column& at = columns_[static_cast<std::size_t>(j) * static_cast<std::size_t>(size_[0]) +
                            static_cast<std::size_t>(i)];
      if (!at.is_in_chart || quads[at.triangle] == k_no_index) continue;
      const std::array<Index, 4> corners =
          detail::quad_corners(shell_->base.corner_vertices, quads[at.triangle]);
      std::array<Vec2, 4> uvs;
      for (std::size_t k = 0; k < 4; ++k) uvs[k] = shell_->base.corner_uvs[corners[k]];
      const std::optional<Vec2> along = along_quad(uvs, {(i + 0.5) / size_[0], (j + 0.5) / size_[1]});
      if (!along) continue;
      at.quad = quads[at.triangle];
      at.along_quad = *along;
    }
  }
}

void LayerGrid::set_texel_sides() {
  const PolygonSoup& base = shell_->base;
  texel_sides_.assign(base.positions.size(), 0);
  std::vector<double> texels_around(base.positions.size(), 0);
  Vec3 lengths = Vec3::Zero();
  double texels_in_all = 0;
  for (std::size_t t = 0; t < base.n_faces(); ++t) {
    std::array<Vec3, 3> middles;
    double height = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index v = base.corner_vertices[3 * t + k];
      middles[k] = (base.positions[v] + layer_->tops[v]) / 2;
      height += (layer_->tops[v] - base.positions[v]).norm() / 3;
    }
    Eigen::Matrix2d texels;
    for (int k = 0; k < 2; ++k)
      texels.col(k) = (base.corner_uvs[3 * t + static_cast<std::size_t>(k) + 1] - base.corner_uvs[3 * t])
                          .cwiseProduct(Vec2(size_[0], size_[1]));
    const double n_texels = std::abs(texels.determinant());
    if (!(n_texels > 0)) continue;
    Eigen::Matrix<double, 3, 2> along;
    along << middles[1] - middles[0], middles[2] - middles[0];
    const Eigen::Matrix<double, 3, 2> of_texel = along * texels.inverse();
    const Vec3 sides(of_texel.col(0).norm(), of_texel.col(1).norm(), height / size_[2]);
    lengths += n_texels * sides.cwiseProduct(Vec3(size_[0], size_[1], size_[2]));
    texels_in_all += n_texels;
    for (std::size_t k = 0; k < 3; ++k) {
      texel_sides_[base.corner_vertices[3 * t + k]] += n_texels * sides.maxCoeff();
      texels_around[base.corner_vertices[3 * t + k]] += n_texels;
    }
  }
  for (std::size_t v = 0; v < texel_sides_.size(); ++v) {
    if (texels_around[v] > 0) texel_sides_[v] /= texels_around[v];
  }
  // Without any area or thickness no length means anything.
  constexpr double k_least = std::numeric_limits<double>::min();
  mean_extent_ = (lengths / std::max(texels_in_all, k_least)).cwiseMax(k_least);
}

Vec3 LayerGrid::point(int i, int j, int k) const {
  const Column& at = column(i, j);
  const double height = (k + 0.5) / size_[2];
  if (at.quad == k_no_index) return shell_point(*shell_, *layer_, {at.triangle, at.weights, height});
  const std::array<Index, 4> corners = detail::quad_corners(shell_->base.corner_vertices, at.quad);
  const detail::FaceWeights weights = detail::weights_at(4, {at.along_quad.x(), at.along_quad.y()});
  Vec3 sum = Vec3::Zero();
  for (std::size_t c = 0; c < 4; ++c) {
    const Index v = shell_->base.corner_vertices[corners[c]];
    sum += weights[c] * ((1 - height) * shell_->base.positions[v] + height * layer_->tops[v]);
  }
  return sum;
}

double LayerGrid::texel_side(int i, int j) const {
  const Column& at = column(i, j);
  double side = 0, sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double weight = std::max(0.0, at.weights[static_cast<int>(k)]);
    side += weight * texel_sides_[shell_->base.corner_vertices[3 * at.triangle + k]];
    sum += weight;
  }
  return side / sum;
}

// In a hexahedron: space over texture.
double LayerGrid::quad_volume(const Column& at, double height) const {
  const std::array<Index, 4> corners = detail::quad_corners(shell_->base.corner_vertices, at.quad);
  const detail::FacePlace place{at.along_quad.x(), at.along_quad.y()};
  const detail::FaceWeights weights = detail::weights_at(4, place);
  const auto [u, v] = detail::weight_steps_at(4, place);
  Eigen::Matrix3d space = Eigen::Matrix3d::Zero();
  Eigen::Matrix2d texture = Eigen::Matrix2d::Zero();
  for (std::size_t c = 0; c < 4; ++c) {
    const Index vertex = shell_->base.corner_vertices[corners[c]];
    const Vec3 director = layer_->tops[vertex] - shell_->base.positions[vertex];
    const Vec3 point = shell_->base.positions[vertex] + height * director;
    space.col(0) += u[c] * point;
    space.col(1) += v[c] * point;
    space.col(2) += weights[c] * director;
    texture.col(0) += u[c] * shell_->base.corner_uvs[corners[c]];
    texture.col(1) += v[c] * shell_->base.corner_uvs[corners[c]];
  }
  return std::abs(space.determinant() / texture.determinant());
}

double LayerGrid::texel_volume(int i, int j, int k) const {
  const Column& at = column(i, j);
  if (!at.is_in_chart) return 0;
  const double height = (k + 0.5) / size_[2];
  const double texels = static_cast<double>(size_[0]) * size_[1] * size_[2];
  if (at.quad != k_no_index) return quad_volume(at, height) / texels;
  std::array<Vec3, 3> corners;
  Vec3 up = Vec3::Zero();
  Eigen::Matrix2d texture;
  for (std::size_t c = 0; c < 3; ++c) {
    const Index v = shell_->base.corner_vertices[3 * at.triangle + c];
    const Vec3 director = layer_->tops[v] - shell_->base.positions[v];
    corners[c] = shell_->base.positions[v] + height * director;
    up += at.weights[static_cast<int>(c)] * director;
  }
  const std::vector<Vec2>& uvs = shell_->base.corner_uvs;
  texture.col(0) = uvs[3 * at.triangle + 1] - uvs[3 * at.triangle];
  texture.col(1) = uvs[3 * at.triangle + 2] - uvs[3 * at.triangle];
  const double space = (corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(up);
  return std::abs(space / texture.determinant()) / texels;
}

}  // namespace recede
