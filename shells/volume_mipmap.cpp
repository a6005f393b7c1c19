#include <recede/geometry/error.h>
#include <recede/geometry/raster.h>
#include <recede/shells/detail/matter_calibration.h>
#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/volume_mipmap.h>

#include <Eigen/Eigenvalues>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace recede {

using Matrix3 = Eigen::Matrix3d;

double opacity_in_row(double first, double second, double correlation) {
  return (1 - correlation) * (1 - (1 - first) * (1 - second)) + correlation * std::max(first, second);
}

std::size_t TransparentVolume::texel_at(const Vec3& place, bool is_periodic) const {
  std::array<int, 3> cell{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double at = place[static_cast<int>(axis)];
    if (axis < 2 && is_periodic) at -= std::floor(at);
    cell[axis] = std::clamp(static_cast<int>(std::floor(at * size[axis])), 0, size[axis] - 1);
  }
  return texel(cell[0], cell[1], cell[2]);
}

double TransparentVolume::opacity_along(std::size_t texel, const Vec3& direction) const {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double along = direction[static_cast<int>(axis)];
    sum += along * along * opacity[texel][axis];
  }
  return sum / 255;
}

namespace {

constexpr std::array<std::array<int, 2>, 6> k_entries{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

std::array<std::uint8_t, 6> normal_bytes(const Matrix3& matrix) {
  std::array<std::uint8_t, 6> bytes{};
  for (std::size_t e = 0; e < 6; ++e) {
    const double entry = std::clamp(matrix(k_entries[e][0], k_entries[e][1]), -1.0, 1.0);
    bytes[e] = static_cast<std::uint8_t>(std::lround(127.5 * (entry + 1)));
  }
  return bytes;
}

std::uint8_t byte_of(double share) {
  return static_cast<std::uint8_t>(255 * std::clamp(share, 0.0, 1.0) + 0.5);
}

std::array<int, 3> half(const std::array<int, 3>& size) {
  return {(size[0] + 1) / 2, (size[1] + 1) / 2, (size[2] + 1) / 2};
}

bool is_one(const std::array<int, 3>& size) { return size == std::array<int, 3>{1, 1, 1}; }

/// Numbers on a grid.
struct Grid {
  std::array<int, 3> size;
  std::vector<float> values;

  explicit Grid(const std::array<int, 3>& sizes)
      : size(sizes),
        values(static_cast<std::size_t>(sizes[0]) * static_cast<std::size_t>(sizes[1]) *
               static_cast<std::size_t>(sizes[2])) {}
  std::size_t at(const std::array<int, 3>& cell) const {
    return static_cast<std::size_t>(cell[0]) +
           static_cast<std::size_t>(size[0]) *
               (static_cast<std::size_t>(cell[1]) +
                static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(cell[2]));
  }
};

template <typename Visit>
void for_each_cell(const std::array<int, 3>& size, Visit&& visit) {
  tbb::parallel_for(0, size[2], [&](int k) {
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) visit(std::array<int, 3>{i, j, k});
  });
}

/// The grid with pairs along an axis put together; a last one without a partner stays.
template <typename Combine>
Grid halved(const Grid& grid, std::size_t axis, Combine&& combine) {
  std::array<int, 3> size = grid.size;
  size[axis] = (size[axis] + 1) / 2;
  Grid result(size);
  for_each_cell(size, [&](std::array<int, 3> cell) {
    const std::size_t place = result.at(cell);
    cell[axis] *= 2;
    const float first = grid.values[grid.at(cell)];
    if (++cell[axis] < grid.size[axis])
      result.values[place] = combine(first, grid.values[grid.at(cell)]);
    else
      result.values[place] = first;
  });
  return result;
}

float larger(float a, float b) { return std::max(a, b); }
float mean(float a, float b) { return (a + b) / 2; }

/// Share of each texel that is inside, if the surface is flat across it.
Grid coverage(const VolumeTexture& texture) {
  Grid grid(texture.size);
  double side = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    side = std::max(side, texture.extent[static_cast<int>(axis)] / texture.size[axis]);
  // Of opacity for a step of a texel; without a known ramp, opacity itself is the share.
  const double steepness = texture.ramp > 0 ? 2 * texture.ramp / side : 1;
  for (std::size_t i = 0; i < grid.values.size(); ++i) {
    const double opacity = texture.opacity[i] / 255.0;
    grid.values[i] = static_cast<float>(std::clamp(0.5 + steepness * (opacity - 0.5), 0.0, 1.0));
  }
  return grid;
}

VolumeTexture halved(const VolumeTexture& texture, const Grid& shares) {
  VolumeTexture result{.size = half(texture.size),
                       .is_periodic = texture.is_periodic,
                       .extent = texture.extent,
                       .ramp = texture.ramp};
  result.opacity.resize(result.n_texels());
  if (!texture.colors.empty()) result.colors.resize(result.n_texels());
  for_each_cell(result.size, [&](const std::array<int, 3>& cell) {
    double sum = 0, weight = 0;
    int count = 0;
    Vec3 color = Vec3::Zero();
    for (int child = 0; child < 8; ++child) {
      const int i = 2 * cell[0] + (child & 1), j = 2 * cell[1] + ((child >> 1) & 1),
                k = 2 * cell[2] + (child >> 2);
      if (i >= texture.size[0] || j >= texture.size[1] || k >= texture.size[2]) continue;
      const std::size_t texel = texture.texel(i, j, k);
      sum += texture.opacity[texel];
      ++count;
      if (texture.colors.empty()) continue;
      const double share =
          static_cast<double>(shares.values[texel]) + 1e-4;  // empty texels have some colour, too
      weight += share;
      for (std::size_t c = 0; c < 3; ++c)
        color[static_cast<int>(c)] +=
            share * static_cast<double>(decode_srgb(static_cast<float>(texture.colors[texel][c]) / 255.0f));
    }
    const std::size_t texel = result.texel(cell[0], cell[1], cell[2]);
    result.opacity[texel] = static_cast<std::uint8_t>(sum / count + 0.5);
    for (std::size_t c = 0; c < 3 && !texture.colors.empty(); ++c)
      result.colors[texel][c] =
          byte_of(static_cast<double>(encode_srgb(static_cast<float>(color[static_cast<int>(c)] / weight))));
  });
  return result;
}

/// What a transparent level is made of, kept from level to level.
struct Statistics {
  Grid shares;                   // mean of what is inside
  std::array<Grid, 3> rows;      // by axis: the largest share in a row, halved along it alone
  std::vector<Matrix3> normals;  // none at the finest level, whose texels have a piece of surface each
};

Matrix3 flat_piece(const VolumeTexture& texture, const std::array<int, 3>& cell, double flatness) {
  const Vec3 normal = detail::texel_gradient(texture, cell).cwiseQuotient(texture.extent);
  const double length = normal.norm();
  if (!(length > 0)) return Matrix3::Zero();
  const Vec3 unit = normal / length;
  // Where opacity changes most there is most of the surface.
  return length * (Matrix3::Identity() - (1 - flatness * flatness) * unit * unit.transpose());
}

// `normal_of` says what a texel of the finer level adds.
template <typename NormalOf>
std::vector<Matrix3> summed_normals(const Grid& fine, const Grid& coarse, NormalOf&& normal_of) {
  std::vector<Matrix3> sums(coarse.values.size(), Matrix3::Zero());
  for_each_cell(coarse.size, [&](const std::array<int, 3>& cell) {
    for (int child = 0; child < 8; ++child) {
      const std::array<int, 3> at{2 * cell[0] + (child & 1), 2 * cell[1] + ((child >> 1) & 1),
                                  2 * cell[2] + (child >> 2)};
      if (at[0] < fine.size[0] && at[1] < fine.size[1] && at[2] < fine.size[2])
        sums[coarse.at(cell)] += normal_of(at);
    }
  });
  return sums;
}

Grid halved_everywhere(const Grid& grid) { return halved(halved(halved(grid, 0, mean), 1, mean), 2, mean); }

// `texture` is the finest level.
Statistics halved(const Statistics& fine, const VolumeTexture& texture, double flatness) {
  Statistics coarse{
      halved_everywhere(fine.shares),
      {halved(fine.rows[0], 0, larger), halved(fine.rows[1], 1, larger), halved(fine.rows[2], 2, larger)},
      {}};
  coarse.normals = summed_normals(fine.shares, coarse.shares, [&](const std::array<int, 3>& cell) -> Matrix3 {
    return fine.normals.empty() ? flat_piece(texture, cell, flatness) : fine.normals[fine.shares.at(cell)];
  });
  return coarse;
}

/// Rows along an axis, averaged across it to the texels of a level.
Grid opacity_of_rows(const Grid& rows, std::size_t axis, const std::array<int, 3>& size) {
  Grid grid = rows;
  for (std::size_t other = 0; other < 3; ++other) {
    while (other != axis && grid.size[other] > size[other]) grid = halved(grid, other, mean);
  }
  return grid;
}

/// The correlation with which rows of up to four texels stop as much as the finest texels say; least squares,
/// since opacity is linear in it.
double fitted_correlation(const Grid& rows, std::size_t axis, const Grid& opacity) {
  Grid independent = opacity, largest = opacity, whole = rows;
  for (int step = 0; step < 2 && independent.size[axis] > 1; ++step) {
    independent = halved(independent, axis, [](float a, float b) { return 1 - (1 - a) * (1 - b); });
    largest = halved(largest, axis, larger);
    whole = halved(whole, axis, larger);
  }
  const Grid exact = opacity_of_rows(whole, axis, independent.size);
  double numerator = 0, denominator = 0;
  for (std::size_t i = 0; i < exact.values.size(); ++i) {
    const double range = static_cast<double>(largest.values[i] - independent.values[i]);
    numerator += range * static_cast<double>(exact.values[i] - independent.values[i]);
    denominator += range * range;
  }
  return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0;
}

TransparentVolume transparent_level(const Statistics& statistics, const VolumeTexture& texture,
                                    double flatness) {
  TransparentVolume level{.size = texture.size, .colors = texture.colors};
  const std::size_t n = texture.n_texels();
  level.opacity.resize(n);
  level.normals.resize(n);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Grid opacity = opacity_of_rows(statistics.rows[axis], axis, level.size);
    for (std::size_t i = 0; i < n; ++i)
      level.opacity[i][axis] = byte_of(static_cast<double>(opacity.values[i]));
    level.correlation[static_cast<int>(axis)] = fitted_correlation(statistics.rows[axis], axis, opacity);
  }
  for_each_cell(level.size, [&](const std::array<int, 3>& cell) {
    const std::size_t i = level.texel(cell[0], cell[1], cell[2]);
    const Matrix3 normals =
        statistics.normals.empty() ? flat_piece(texture, cell, flatness) : statistics.normals[i];
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(normals, Eigen::EigenvaluesOnly);
    const double largest = solver.eigenvalues()[2];
    level.normals[i] = normal_bytes(largest > 0 ? Matrix3(normals / largest) : Matrix3::Identity());
  });
  return level;
}

/// Share of the texels that have an opacity of a half and more.
double volume_of(const VolumeTexture& texture) {
  const auto inside = std::count_if(texture.opacity.begin(), texture.opacity.end(),
                                    [](std::uint8_t opacity) { return opacity >= 128; });
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
  validate(texture, "a mipmap");
  if (!(options.least_share >= 0) || !(options.least_share <= 1))
    throw OptionError("the share that levels of surfaces keep must be from 0 to 1");
  if (!(options.seen_tolerance >= 0))
    throw OptionError("what levels of surfaces may be seen off by is 0 or more");
  if (!(options.flatness > 0) || !(options.flatness <= 1))
    throw OptionError("the flatness of normals must be above 0 and at most 1");
  Statistics statistics{coverage(texture), {coverage(texture), coverage(texture), coverage(texture)}, {}};

  VolumeMipmap mipmap;
  mipmap.surfaces.push_back(texture);
  const std::vector<detail::SeenLayer> exact = detail::measure_layer(texture);
  const double volume = volume_of(texture);
  VolumeTexture level = texture;
  bool keeps_shape = true;
  while (!is_one(level.size)) {
    const VolumeTexture next = halved(level, statistics.shares);
    if (keeps_shape) {
      const double share = volume_of(next);
      keeps_shape = share >= options.least_share * volume && options.least_share * share <= volume &&
                    is_seen_alike(detail::measure_layer(next), exact, options.seen_tolerance);
    }
    if (keeps_shape) {
      mipmap.surfaces.push_back(next);
    } else {
      mipmap.transparent.push_back(transparent_level(statistics, level, options.flatness));
    }
    statistics = halved(statistics, texture, options.flatness);
    level = next;
  }
  mipmap.transparent.push_back(transparent_level(statistics, level, options.flatness));
  for (TransparentVolume& matter : mipmap.transparent) detail::calibrate(texture, exact, matter);
  return mipmap;
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
