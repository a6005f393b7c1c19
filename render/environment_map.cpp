#include <recede/geometry/error.h>
#include <recede/render/camera.h>
#include <recede/render/detail/environment_map.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace recede::detail {

namespace {

constexpr double k_pi = std::numbers::pi;

double luminance(const Rgb& color) {
  return 0.2126 * static_cast<double>(color.x()) + 0.7152 * static_cast<double>(color.y()) +
         0.0722 * static_cast<double>(color.z());
}

void check(const EnvironmentLight& light) {
  if (light.radiance.pixels.empty()) throw OptionError("an environment needs a picture");
  if (!(light.up.norm() > 0) || !light.up.allFinite())
    throw OptionError("an environment needs a direction that points up");
  if (!(light.scale >= 0) || !std::isfinite(light.scale) || !std::isfinite(light.rotation))
    throw OptionError("the scale of an environment is a number from 0 on, its rotation any number");
  for (int y = 0; y < light.radiance.height; ++y) {
    for (int x = 0; x < light.radiance.width; ++x) {
      if (!light.radiance.at(x, y).allFinite())
        throw InputError(fmt::format("environment: the pixel in column {}, row {} isn't finite", x, y));
    }
  }
}

/// Where a share of the last sum falls: the entry, and how far inside of it, 0 to 1. Entries that add nothing
/// are never found.
std::pair<std::size_t, double> find_share(std::span<const double> sums, double share) {
  const double value = share * sums.back();
  auto found = static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end(), value) - sums.begin());
  // Rounding may leave the last value beyond all; the first entry that reaches the end is the last with
  // light.
  if (found == sums.size())
    found = static_cast<std::size_t>(std::lower_bound(sums.begin(), sums.end(), sums.back()) - sums.begin());
  const double before = found == 0 ? 0.0 : sums[found - 1];
  return {found, std::clamp((value - before) / (sums[found] - before), 0.0, 1.0)};
}

}  // namespace

EnvironmentMap::EnvironmentMap(const EnvironmentLight& light) : image_(light.radiance) {
  check(light);
  visible_ = light.visible;
  up_ = light.up.normalized();
  const Eigen::AngleAxisd turn(light.rotation, up_);
  ahead_ = turn * -front_of(up_);
  right_ = ahead_.cross(up_);
  for (Rgb& pixel : image_.pixels) {
    const Vec3 scaled = light.scale * pixel.cwiseMax(0.0f).cast<double>();
    if (scaled.maxCoeff() > static_cast<double>(k_most_light))
      throw OptionError("the radiance of an environment times its scale is at most 1e15");
    pixel = scaled.cast<float>();
    if (pixel != image_.pixels[0]) constant_ = false;
    luminances_.push_back(luminance(pixel));
  }
  for (int y = 0; y <= image_.height; ++y) row_cosines_.push_back(std::cos(k_pi * y / image_.height));
  const double width = 2 * k_pi / image_.width;
  const std::size_t columns = static_cast<std::size_t>(image_.width);
  for (int y = 0; y < image_.height; ++y) {
    double sum = 0;
    for (std::size_t x = 0; x < columns; ++x)
      column_sums_.push_back(sum += luminances_[static_cast<std::size_t>(y) * columns + x]);
    const auto row = static_cast<std::size_t>(y);
    row_sums_.push_back(total_ += sum * width * (row_cosines_[row] - row_cosines_[row + 1]));
  }
}

// In pixels, (0, 0) the upper left corner.
Vec2 EnvironmentMap::place_of(const Vec3& direction) const {
  const double longitude = std::atan2(direction.dot(right_), direction.dot(ahead_));
  const double height = std::clamp(direction.dot(up_), -1.0, 1.0);
  return {(0.5 + longitude / (2 * k_pi)) * image_.width, std::acos(height) / k_pi * image_.height};
}

std::size_t EnvironmentMap::texel_of(const Vec3& direction) const {
  const Vec2 place = place_of(direction);
  const int x = std::clamp(static_cast<int>(place.x()), 0, image_.width - 1);
  const int y = std::clamp(static_cast<int>(place.y()), 0, image_.height - 1);
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) + static_cast<std::size_t>(x);
}

Rgb EnvironmentMap::radiance(const Vec3& direction) const { return image_.pixels[texel_of(direction)]; }

Rgb EnvironmentMap::smooth_radiance(const Vec3& direction) const {
  const Vec2 place = place_of(direction) - Vec2::Constant(0.5);
  const double left = std::floor(place.x()), top = std::floor(place.y());
  const auto at = [&](double x, double y) -> const Rgb& {
    const int column = (static_cast<int>(x) + image_.width) % image_.width;  // longitudes close a circle
    return image_.at(column, std::clamp(static_cast<int>(y), 0, image_.height - 1));
  };
  const float across = static_cast<float>(place.x() - left), down = static_cast<float>(place.y() - top);
  return (1 - down) * ((1 - across) * at(left, top) + across * at(left + 1, top)) +
         down * ((1 - across) * at(left, top + 1) + across * at(left + 1, top + 1));
}

// A row by its light, a texel in it by its luminance, and a place in the texel evenly by solid angle: so the
// density is the same all over a texel.
EnvironmentMap::Sample EnvironmentMap::sample(const Vec2& random) const {
  const auto [row, down] = find_share(row_sums_, random.y());
  const auto columns = static_cast<std::size_t>(image_.width);
  const auto [column, across] =
      find_share(std::span<const double>(column_sums_).subspan(row * columns, columns), random.x());
  const double upper = row_cosines_[row], lower = row_cosines_[row + 1];
  const double height = upper + down * (lower - upper), level = std::sqrt(std::max(0.0, 1 - height * height));
  const double longitude = ((static_cast<double>(column) + across) / image_.width - 0.5) * 2 * k_pi;
  const Vec3 direction = level * (std::cos(longitude) * ahead_ + std::sin(longitude) * right_) + height * up_;
  const std::size_t texel = row * columns + column;
  return {direction.normalized(), luminances_[texel] / total_, image_.pixels[texel]};
}

double EnvironmentMap::density(const Vec3& direction) const {
  return is_black() ? 0.0 : luminances_[texel_of(direction)] / total_;
}

}  // namespace recede::detail
