#include <recede/geometry/error.h>
#include <recede/geometry/raster.h>
#include <recede/shells/detail/matter_calibration.h>
#include <recede/shells/detail/matter_path.h>
#include <recede/shells/detail/matter_statistics.h>
#include <recede/shells/detail/mipmap_levels.h>
#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/volume_mipmap.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace recede {

using Matrix3 = Eigen::Matrix3d;

double opacity_in_row(double first, double second, double correlation) {
  return (1 - correlation) * (1 - (1 - first) * (1 - second)) + correlation * std::max(first, second);
}

double TransparentVolume::opacity_along(const std::array<int, 3>& texel, const Vec3& direction) const {
  return detail::opacity_along(opacity.at(texel), direction);
}

namespace {

constexpr std::array<std::array<int, 2>, 6> k_entries{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

bool is_one(const std::array<int, 3>& size) { return size == std::array<int, 3>{1, 1, 1}; }

using Shares = BrickGrid<float>;
using Opacity = BrickGrid<std::uint8_t>;
using Colors = BrickGrid<std::array<std::uint8_t, 3>>;

/// Smaller versions of a texture as a surface, one after the other.
class SurfaceLevels {
 public:
  explicit SurfaceLevels(const VolumeTexture& texture) : level_(texture) {
    if (!texture.colors.empty()) shares_of_opacity_ = detail::coverage_of_opacity(texture);
  }

  const VolumeTexture& level() const { return level_; }

  void halve() {
    VolumeTexture next = level_;
    next.size = detail::half(level_.size);
    next.opacity = Opacity::make(next.size, [&](Opacity::Brick& brick) { set_opacity(brick); });
    if (!level_.colors.empty()) {
      next.colors = Colors::make(next.size, [&](Colors::Brick& brick) { set_colors(brick); });
      shares_ = Shares::make(next.size, [&](Shares::Brick& brick) { set_shares(brick); });
    }
    level_ = std::move(next);
  }

 private:
  void set_opacity(Opacity::Brick& brick) const {
    if (brick.fill_if_alike(level_.opacity, detail::children_of(brick.box(), level_.size))) return;
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      double sum = 0;
      const TexelBox children = children_of(i, j, k);
      for_each_texel(children, [&](int ci, int cj, int ck) { sum += level_.opacity.at(ci, cj, ck); });
      brick.at(i, j, k) = static_cast<std::uint8_t>(sum / static_cast<double>(children.n_texels()) + 0.5);
    });
  }

  // Means of what is inside of texels.
  void set_colors(Colors::Brick& brick) const {
    // A mean of the same is the same but for a rounding far below that to bytes.
    if (brick.fill_if_alike(level_.colors, detail::children_of(brick.box(), level_.size))) return;
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      double weight = 0;
      Vec3 color = Vec3::Zero();
      for_each_texel(children_of(i, j, k), [&](int ci, int cj, int ck) {
        const double share =
            static_cast<double>(share_at(ci, cj, ck)) + 1e-4;  // empty texels have some colour, too
        weight += share;
        const std::array<std::uint8_t, 3>& bytes = level_.colors.at(ci, cj, ck);
        for (std::size_t c = 0; c < 3; ++c) color[static_cast<int>(c)] += share * linear_[bytes[c]];
      });
      for (std::size_t c = 0; c < 3; ++c) {
        brick.at(i, j, k)[c] = detail::byte_of(
            static_cast<double>(encode_srgb(static_cast<float>(color[static_cast<int>(c)] / weight))));
      }
    });
  }

  void set_shares(Shares::Brick& brick) const {
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      const TexelBox children = children_of(i, j, k);
      // Pairs along s, of these pairs along t, of these along r; one without a partner stays.
      const auto along_s = [&](int cj, int ck) {
        const float first = share_at(children.first[0], cj, ck);
        return children.length(0) < 2 ? first : mean(first, share_at(children.first[0] + 1, cj, ck));
      };
      const auto along_t = [&](int ck) {
        const float first = along_s(children.first[1], ck);
        return children.length(1) < 2 ? first : mean(first, along_s(children.first[1] + 1, ck));
      };
      const float first = along_t(children.first[2]);
      brick.at(i, j, k) = children.length(2) < 2 ? first : mean(first, along_t(children.first[2] + 1));
    });
  }

  static float mean(float a, float b) { return (a + b) / 2; }

  float share_at(int i, int j, int k) const {
    return shares_.empty() ? shares_of_opacity_[level_.opacity.at(i, j, k)] : shares_.at(i, j, k);
  }
  TexelBox children_of(int i, int j, int k) const {
    return detail::children_of({{i, j, k}, {i + 1, j + 1, k + 1}}, level_.size);
  }

  VolumeTexture level_;
  detail::CoverageOfOpacity shares_of_opacity_{};  // at the finest level
  const std::array<double, 256>& linear_ = detail::linear_of_bytes();
  Shares shares_;  // that are inside, at others; of textures with colours
};

/// Transparent levels, from fine to coarse. Nothing is done before the first one is asked for.
class MatterLevels {
 public:
  MatterLevels(const VolumeTexture& finest, double flatness) : finest_(finest), flatness_(flatness) {}

  /// `texture` is that level as a surface.
  TransparentVolume make(int number, const VolumeTexture& texture) {
    if (!statistics_) statistics_.emplace(finest_, flatness_);
    for (; number_ < number; ++number_) statistics_->halve();
    TransparentVolume level{.size = texture.size,
                            .opacity = statistics_->opacity(),
                            .normals = statistics_->normals(),
                            .colors = texture.colors};
    for (std::size_t axis = 0; axis < 3; ++axis)
      level.correlation[static_cast<int>(axis)] = statistics_->correlation(axis);
    return level;
  }

 private:
  const VolumeTexture& finest_;
  double flatness_;
  std::optional<detail::MatterStatistics> statistics_;
  int number_ = 0;
};

/// Share of the texels that have an opacity of a half and more.
double volume_of(const VolumeTexture& texture) {
  std::size_t inside = 0;
  for (std::size_t brick = 0; brick < texture.opacity.n_bricks(); ++brick) {
    const TexelBox box = texture.opacity.box(brick);
    if (const std::optional<std::uint8_t> value = texture.opacity.uniform_value(brick))
      inside += *value >= 128 ? box.n_texels() : 0;
    else
      for_each_texel(box, [&](int i, int j, int k) {
        if (texture.opacity.at(i, j, k) >= 128) ++inside;
      });
  }
  return static_cast<double>(inside) / static_cast<double>(texture.n_texels());
}

/// Whether a level is seen as the finest one is, in the mean over directions.
bool is_seen_alike(const std::vector<detail::SeenLayer>& level, const std::vector<detail::SeenLayer>& finest,
                   double tolerance) {
  double opacity = 0, other_opacity = 0, light = 0, other_light = 0;
  for (std::size_t d = 0; d < finest.size(); ++d) {
    opacity += level[d].opacity;
    other_opacity += finest[d].opacity;
    light += level[d].opacity * level[d].normal.norm();
    other_light += finest[d].opacity * finest[d].normal.norm();
  }
  return std::abs(opacity - other_opacity) <= tolerance * other_opacity &&
         std::abs(light - other_light) <= tolerance * other_light;
}

}  // namespace

std::shared_ptr<const VolumeMipmap> finest_only(VolumeTexture texture) {
  auto mipmap = std::make_shared<VolumeMipmap>();
  mipmap->surfaces.push_back(std::move(texture));
  return mipmap;
}

VolumeMipmap make_mipmap(const VolumeTexture& texture, const MipmapOptions& options) {
  return detail::make_mipmap_to(std::numeric_limits<int>::max(), texture, options);
}

VolumeMipmap detail::make_mipmap_to(int last_level, const VolumeTexture& texture,
                                    const MipmapOptions& options) {
  validate(texture, "a mipmap");
  if (!(options.least_share >= 0) || !(options.least_share <= 1))
    throw OptionError("the share that levels of surfaces keep must be from 0 to 1");
  if (!(options.seen_tolerance >= 0))
    throw OptionError("what levels of surfaces may be seen off by is 0 or more");
  if (!(options.flatness > 0) || !(options.flatness <= 1))
    throw OptionError("the flatness of normals must be above 0 and at most 1");
  VolumeMipmap mipmap;
  mipmap.surfaces.push_back(texture);
  const std::vector<detail::SeenLayer> exact = detail::measure_layer(texture);
  const double volume = volume_of(texture);
  MatterLevels matter(texture, options.flatness);
  SurfaceLevels levels(texture);
  bool keeps_shape = true;
  int number = 0;
  for (; !is_one(levels.level().size) && number <= last_level; ++number) {
    const VolumeTexture level = levels.level();
    levels.halve();
    if (keeps_shape) {
      const double share = volume_of(levels.level());
      keeps_shape = share >= options.least_share * volume && options.least_share * share <= volume &&
                    is_seen_alike(detail::measure_layer(levels.level()), exact, options.seen_tolerance);
    }
    if (keeps_shape)
      mipmap.surfaces.push_back(levels.level());
    else
      mipmap.transparent.push_back(matter.make(number, level));
  }
  if (number <= last_level) mipmap.transparent.push_back(matter.make(number, levels.level()));
  for (TransparentVolume& level : mipmap.transparent) detail::calibrate(texture, exact, level);
  return mipmap;
}

std::array<std::uint8_t, 6> normal_bytes(const Matrix3& matrix) {
  std::array<std::uint8_t, 6> bytes{};
  for (std::size_t e = 0; e < 6; ++e) {
    const double entry = std::clamp(matrix(k_entries[e][0], k_entries[e][1]), -1.0, 1.0);
    bytes[e] = static_cast<std::uint8_t>(std::lround(127.5 * (entry + 1)));
  }
  return bytes;
}

Matrix3 normal_matrix(const std::array<std::uint8_t, 6>& bytes) {
  Matrix3 matrix;
  for (std::size_t e = 0; e < 6; ++e) {
    const double entry = bytes[e] / 127.5 - 1;
    matrix(k_entries[e][0], k_entries[e][1]) = entry;
    matrix(k_entries[e][1], k_entries[e][0]) = entry;
  }
  return matrix;
}

Vec3 mean_normal_along(const Matrix3& inverse, const Vec3& direction) {
  // Rounding to bytes may have made flat ellipsoids hollow.
  const Matrix3 firm = inverse + 0.01 * Matrix3::Identity();
  const Matrix3 form = firm.inverse();
  const Vec3 side = direction.unitOrthogonal(), up = direction.cross(side);
  Eigen::Matrix<double, 3, 2> basis;
  basis << side, up;
  const Eigen::Matrix2d shadow = basis.transpose() * firm * basis;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(shadow);
  // Spaced so that the mean over a ball's disc, of length 2/3, comes out.
  constexpr double k_spacing = 0.6245;
  Vec3 sum = Vec3::Zero();
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      const Vec2 local(i * k_spacing * std::sqrt(std::max(solver.eigenvalues()[0], 0.0)),
                       j * k_spacing * std::sqrt(std::max(solver.eigenvalues()[1], 0.0)));
      const Vec3 at = basis * (solver.eigenvectors() * local);
      // The first point along the direction.
      const double a = direction.dot(form * direction), b = direction.dot(form * at),
                   c = at.dot(form * at) - 1;
      const double root = std::sqrt(std::max(b * b - a * c, 0.0));
      sum += (form * (at + (-b - root) / a * direction)).normalized();
    }
  }
  return sum / 9;
}

}  // namespace recede
