#include <recede/shells/detail/matter_statistics.h>
#include <recede/shells/detail/volume_sampler.h>

#include <Eigen/Eigenvalues>
#include <tbb/parallel_for.h>

#include <cmath>

namespace recede::detail {

using Matrix3 = Eigen::Matrix3d;

CoverageOfOpacity coverage_of_opacity(const VolumeTexture& texture) {
  double side = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    side = std::max(side, texture.extent[static_cast<int>(axis)] / texture.size[axis]);
  // Of opacity for a step of a texel; without a known ramp, opacity itself is the share.
  const double steepness = texture.ramp > 0 ? 2 * texture.ramp / side : 1;
  CoverageOfOpacity coverage{};
  for (std::size_t byte = 0; byte < coverage.size(); ++byte) {
    const double opacity = static_cast<double>(byte) / 255.0;
    coverage[byte] = static_cast<float>(std::clamp(0.5 + steepness * (opacity - 0.5), 0.0, 1.0));
  }
  return coverage;
}

namespace {

/// The grid with the larger one of each pair along an axis; a last one without a partner stays.
BrickGrid<std::uint8_t> halved_rows(const BrickGrid<std::uint8_t>& rows, std::size_t axis) {
  std::array<int, 3> size = rows.size();
  size[axis] = (size[axis] + 1) / 2;
  return BrickGrid<std::uint8_t>::make(size, [&](BrickGrid<std::uint8_t>::Brick& brick) {
    TexelBox from = brick.box();
    from.first[axis] *= 2;
    from.last[axis] = std::min(2 * from.last[axis], rows.size()[axis]);
    if (brick.fill_if_alike(rows, from)) return;
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      std::array<int, 3> cell{i, j, k};
      cell[axis] *= 2;
      const std::uint8_t first = rows.at(cell);
      const bool is_last = ++cell[axis] == from.last[axis];
      brick.at(i, j, k) = is_last ? first : std::max(first, rows.at(cell));
    });
  });
}

/// Puts `n` numbers together, the first with the second and so on; a last one without a partner stays.
/// Returns how many there are then.
template <typename Combine>
std::size_t put_together(float* numbers, std::size_t n, Combine&& combine) {
  for (std::size_t i = 0; i + 1 < n; i += 2) numbers[i / 2] = combine(numbers[i], numbers[i + 1]);
  if (n % 2 == 1) numbers[n / 2] = numbers[n - 1];
  return (n + 1) / 2;
}

float larger(float a, float b) { return std::max(a, b); }
float mean(float a, float b) { return (a + b) / 2; }
float independent(float a, float b) { return 1 - (1 - a) * (1 - b); }

std::array<std::size_t, 2> others_of(std::size_t axis) {
  return {axis == 0 ? std::size_t{1} : 0, axis == 2 ? std::size_t{1} : 2};
}

}  // namespace

/// Means of rows along an axis over texels of a level, for boxes of texels.
class MatterStatistics::Means {
 public:
  Means(const MatterStatistics& statistics, std::size_t axis)
      : rows_(statistics.rows_[axis]),
        coverage_(statistics.coverage_),
        axis_(axis),
        others_(others_of(axis)),
        level_(statistics.level_) {}

  /// Along the axis the box is in `1 << groups` texels at a time, of which the largest counts. Numbers are in
  /// the order of `box`.
  void make(const TexelBox& box, int groups, std::vector<float>& means) {
    const auto [first, second] = others_;
    TexelBox from = box;
    widen(from, axis_, groups);
    widen(from, first, level_);
    widen(from, second, level_);
    means.resize(box.n_texels());
    if (const std::optional<std::uint8_t> value = rows_.uniform_value(from)) {
      std::fill(means.begin(), means.end(), coverage_[*value]);
      return;
    }
    const auto n_first = static_cast<std::size_t>(box.length(first)),
               n_along = static_cast<std::size_t>(box.length(axis_)),
               n_lines = static_cast<std::size_t>(from.length(second));
    // Of each place along the axis and each of the first: a line along the second.
    lines_.resize(n_along * n_first * n_lines);
    for (std::size_t line = 0; line < n_lines; ++line)
      read_line(from, line, groups, n_along, n_first, n_lines);
    std::array<std::size_t, 3> step{1, static_cast<std::size_t>(box.length(0)), 0};
    step[2] = step[1] * static_cast<std::size_t>(box.length(1));
    for (std::size_t a = 0; a < n_along; ++a) {
      for (std::size_t f = 0; f < n_first; ++f) {
        float* line = lines_.data() + (a * n_first + f) * n_lines;
        reduce(line, n_lines);
        for (std::size_t s = 0; s < static_cast<std::size_t>(box.length(second)); ++s)
          means[a * step[axis_] + f * step[first] + s * step[second]] = line[s];
      }
    }
  }

 private:
  void widen(TexelBox& box, std::size_t axis, int levels) const {
    box.first[axis] <<= levels;
    box.last[axis] =
        static_cast<int>(std::min<std::int64_t>(std::int64_t{box.last[axis]} << levels, rows_.size()[axis]));
  }

  void reduce(float* line, std::size_t n) const {
    for (int l = 0; l < level_; ++l) n = put_together(line, n, mean);
  }

  // Means along the first of the other axes at one place along the second.
  void read_line(const TexelBox& from, std::size_t line, int groups, std::size_t n_along, std::size_t n_first,
                 std::size_t n_lines) {
    const auto [first, second] = others_;
    TexelBox slice = from;
    slice.first[second] = from.first[second] + static_cast<int>(line);
    slice.last[second] = slice.first[second] + 1;
    opacities_.resize(slice.n_texels());
    rows_.copy_to(slice, opacities_.data());
    const auto length = static_cast<std::size_t>(slice.length(first)),
               along = static_cast<std::size_t>(slice.length(axis_));
    // The earlier axis runs faster.
    const std::size_t step_along = axis_ < first ? 1 : length, step_first = axis_ < first ? along : 1;
    numbers_.resize(length);
    for (std::size_t a = 0; a < n_along; ++a) {
      const std::size_t begin = a << groups, end = std::min((a + 1) << groups, along);
      for (std::size_t f = 0; f < length; ++f) {
        std::uint8_t most = 0;
        for (std::size_t n = begin; n < end; ++n)
          most = std::max(most, opacities_[n * step_along + f * step_first]);
        numbers_[f] = coverage_[most];
      }
      reduce(numbers_.data(), length);
      for (std::size_t f = 0; f < n_first; ++f) lines_[(a * n_first + f) * n_lines + line] = numbers_[f];
    }
  }

  const BrickGrid<std::uint8_t>& rows_;
  const CoverageOfOpacity& coverage_;
  std::size_t axis_;
  std::array<std::size_t, 2> others_;
  int level_;
  std::vector<std::uint8_t> opacities_;
  std::vector<float> numbers_, lines_;
};

MatterStatistics::MatterStatistics(const VolumeTexture& finest, double flatness)
    : finest_(finest),
      flatness_(flatness),
      coverage_(coverage_of_opacity(finest)),
      size_(finest.size),
      rows_{finest.opacity, finest.opacity, finest.opacity} {}

void MatterStatistics::halve() {
  for (std::size_t axis = 0; axis < 3; ++axis) rows_[axis] = halved_rows(rows_[axis], axis);
  size_ = half(size_);
  ++level_;
  if (level_ < 2) return;
  // Two levels at once to begin with.
  const std::array<int, 3> fine = level_ == 2 ? half(finest_.size) : normals_.size();
  normals_ = BrickGrid<Sum>::make(size_, [&](BrickGrid<Sum>::Brick& brick) {
    brick.fill({});
    TexelBox children = children_of(brick.box(), fine);
    if (level_ == 2) children = children_of(children, finest_.size);
    if (level_ == 2 && !has_surface(children)) return;
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      Eigen::Map<Matrix3>(brick.at(i, j, k).data()) = sum_of_children(level_, {i, j, k});
    });
  });
}

BrickGrid<std::array<std::uint8_t, 3>> MatterStatistics::opacity() const {
  using Opacity = BrickGrid<std::array<std::uint8_t, 3>>;
  return Opacity::make(size_, [&](Opacity::Brick& brick) {
    std::vector<float> means;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Means(*this, axis).make(brick.box(), 0, means);
      std::size_t next = 0;
      for_each_texel(brick.box(), [&](int i, int j, int k) {
        brick.at(i, j, k)[axis] = byte_of(static_cast<double>(means[next++]));
      });
    }
  });
}

double MatterStatistics::correlation(std::size_t axis) const {
  std::array<int, 3> size = size_;
  int groups = 0;
  for (; groups < 2 && size[axis] > 1; ++groups) size[axis] = (size[axis] + 1) / 2;
  // Rows of texels in their order, since sums of numbers depend on it; some at a time.
  constexpr int k_rows = 64, k_block = 8;
  const auto length = static_cast<std::size_t>(size[0]);
  std::vector<float> ranges(k_rows * length), differences(k_rows * length);
  double numerator = 0, denominator = 0;
  const auto measure = [&](const TexelBox& box, float* range, float* difference) {
    Means of_rows(*this, axis);
    std::vector<float> exact, opacity;
    of_rows.make(box, groups, exact);
    TexelBox fine = box;
    fine.first[axis] <<= groups;
    fine.last[axis] = std::min(fine.last[axis] << groups, size_[axis]);
    of_rows.make(fine, 0, opacity);
    const std::array<std::size_t, 3> step{
        1, static_cast<std::size_t>(fine.length(0)),
        static_cast<std::size_t>(fine.length(0)) * static_cast<std::size_t>(fine.length(1))};
    std::size_t next = 0;
    for_each_texel(box, [&](int i, int j, int k) {
      std::array<int, 3> cell{i, j, k};
      cell[axis] <<= groups;
      std::size_t place = 0;
      for (std::size_t a = 0; a < 3; ++a)
        place += static_cast<std::size_t>(cell[a] - fine.first[a]) * step[a];
      std::array<float, 4> alone{}, most{};
      auto n = static_cast<std::size_t>(std::min(1 << groups, fine.last[axis] - cell[axis]));
      for (std::size_t t = 0; t < n; ++t) alone[t] = most[t] = opacity[place + t * step[axis]];
      for (int g = 0; g < groups; ++g) {
        put_together(most.data(), n, larger);
        n = put_together(alone.data(), n, independent);
      }
      range[next] = most[0] - alone[0];
      difference[next] = exact[next] - alone[0];
      ++next;
    });
  };
  for (int k = 0; k < size[2]; ++k) {
    for (int first = 0; first < size[1]; first += k_rows) {
      const int last = std::min(first + k_rows, size[1]), n_blocks = (last - first + k_block - 1) / k_block;
      tbb::parallel_for(0, n_blocks, [&](int block) {
        const int j = first + block * k_block;
        const std::size_t place = static_cast<std::size_t>(j - first) * length;
        measure({{0, j, k}, {size[0], std::min(j + k_block, last), k + 1}}, ranges.data() + place,
                differences.data() + place);
      });
      for (std::size_t n = 0; n < static_cast<std::size_t>(last - first) * length; ++n) {
        const auto range = static_cast<double>(ranges[n]);
        numerator += range * static_cast<double>(differences[n]);
        denominator += range * range;
      }
    }
  }
  return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0;
}

Matrix3 MatterStatistics::flat_piece(const std::array<int, 3>& cell) const {
  const Vec3 normal = texel_gradient(finest_, cell).cwiseQuotient(finest_.extent);
  const double length = normal.norm();
  if (!(length > 0)) return Matrix3::Zero();
  const Vec3 unit = normal / length;
  // Where opacity changes most there is most of the surface.
  return length * (Matrix3::Identity() - (1 - flatness_ * flatness_) * unit * unit.transpose());
}

Matrix3 MatterStatistics::sum_of_children(int level, const std::array<int, 3>& cell) const {
  if (level == 0) return flat_piece(cell);
  Matrix3 sum = Matrix3::Zero();
  const std::array<int, 3> fine = level == 1   ? finest_.size
                                  : level == 2 ? half(finest_.size)
                                               : normals_.size();
  const TexelBox own{cell, {cell[0] + 1, cell[1] + 1, cell[2] + 1}};
  for_each_texel(children_of(own, fine), [&](int i, int j, int k) {
    if (level > 2)
      sum += Eigen::Map<const Matrix3>(normals_.at(i, j, k).data());
    else
      sum += sum_of_children(level - 1, {i, j, k});
  });
  return sum;
}

// Whether opacity may change in a part of the finest level or to the texels around it.
bool MatterStatistics::has_surface(const TexelBox& box) const {
  TexelBox around = box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    around.first[axis] = box.first[axis] - 1;
    around.last[axis] = box.last[axis] + 1;
    const bool is_at_end = around.first[axis] < 0 || around.last[axis] > finest_.size[axis];
    // What is at the other end isn't looked for.
    if (is_at_end && axis < 2 && finest_.is_periodic) return true;
    around.first[axis] = std::max(around.first[axis], 0);
    around.last[axis] = std::min(around.last[axis], finest_.size[axis]);
  }
  return !finest_.opacity.uniform_value(around);
}

BrickGrid<std::array<std::uint8_t, 6>> MatterStatistics::normals() const {
  using Normals = BrickGrid<std::array<std::uint8_t, 6>>;
  const std::array<std::uint8_t, 6> all_alike = normal_bytes(Matrix3::Identity());
  return Normals::make(size_, [&](Normals::Brick& brick) {
    brick.fill(all_alike);
    TexelBox finest = brick.box();
    if (level_ == 1) finest = children_of(finest, finest_.size);
    if (level_ < 2 && !has_surface(finest)) return;
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      const Matrix3 normals = level_ < 2 ? sum_of_children(level_, {i, j, k})
                                         : Matrix3(Eigen::Map<const Matrix3>(normals_.at(i, j, k).data()));
      if (normals.isZero(0)) return;
      const Eigen::SelfAdjointEigenSolver<Matrix3> solver(normals, Eigen::EigenvaluesOnly);
      const double largest = solver.eigenvalues()[2];
      if (largest > 0) brick.at(i, j, k) = normal_bytes(normals / largest);
    });
  });
}

}  // namespace recede::detail
