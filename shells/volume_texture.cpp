#include <recede/geometry/error.h>
#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/volume_texture.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <atomic>

namespace recede {

void validate(const VolumeTexture& texture, const std::string& source) {
  const auto refuse = [&](const std::string& why) { throw InputError(fmt::format("{}: {}", source, why)); };
  for (const int size : texture.size) {
    if (size < 1) refuse("a volume texture needs a texel and more along each axis");
  }
  const auto check_size = [&](const std::array<int, 3>& size, const char* what) {
    if (size != texture.size)
      refuse(fmt::format("a volume texture of {} texels has {} of {}", fmt::join(texture.size, " x "), what,
                         fmt::join(size, " x ")));
  };
  check_size(texture.opacity.size(), "opacities");
  if (!texture.colors.empty()) check_size(texture.colors.size(), "colours");
  if (!(texture.extent.minCoeff() > 0) || !texture.extent.allFinite() || !(texture.ramp >= 0) ||
      !std::isfinite(texture.ramp))
    refuse("lengths of a volume texture must be finite and above 0");
}

double opacity_at(const VolumeTexture& texture, const Vec3& place) {
  return detail::sampled_opacity(texture, place);
}

Vec3 opacity_gradient(const VolumeTexture& texture, const Vec3& place) {
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    const double texel = 1.0 / texture.size[static_cast<std::size_t>(axis)];
    double before = place[axis] - texel, behind = place[axis] + texel;
    if (axis == 2 || !texture.is_periodic) {
      // Beyond the outermost middles nothing changes.
      before = std::clamp(before, texel / 2, 1 - texel / 2);
      behind = std::clamp(behind, texel / 2, 1 - texel / 2);
    }
    Vec3 from = place, to = place;
    from[axis] = before;
    to[axis] = behind;
    gradient[axis] = behind > before
                         ? (detail::sampled_opacity(texture, to) - detail::sampled_opacity(texture, from)) /
                               (behind - before)
                         : 0;
  }
  return gradient;
}

void check_texels(const std::array<int, 3>& size) {
  double texels = 1;
  for (const int along : size) {
    if (along < 1)
      throw OptionError(fmt::format("a volume texture can't have {} texels along an axis", along));
    texels *= along;
  }
  if (texels > static_cast<double>(k_most_texels)) {
    throw OptionError(fmt::format("{} x {} x {} texels are more than the {} that a volume texture may have",
                                  size[0], size[1], size[2], k_most_texels));
  }
}

namespace {

void check(const VolumeOptions& options) {
  check_texels(options.size);
  if (!(options.extent.minCoeff() > 0) || !options.extent.allFinite())
    throw OptionError("lengths of a volume texture must be finite and above 0");
  if (!(options.ramp_texels > 0) || !std::isfinite(options.ramp_texels))
    throw OptionError("the ramp of a volume texture must be finite and above 0");
}

}  // namespace

VolumeTexture make_volume(const InsideDistance& inside, const VolumeOptions& options, Progress* progress) {
  check(options);
  VolumeTexture texture{.size = options.size, .is_periodic = options.is_periodic, .extent = options.extent};
  double side = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    side = std::max(side, options.extent[static_cast<int>(axis)] / options.size[axis]);
  texture.ramp = options.ramp_texels * side;
  const auto point_of = [&](int i, int j, int k) -> Vec3 {
    return texture.middle(i, j, k).cwiseProduct(texture.extent);
  };

  std::atomic<std::size_t> first_bad = texture.n_texels();  // the least, whatever the threads
  const auto set_opacity = [&](BrickGrid<std::uint8_t>::Brick& brick) {
    brick.fill(0);
    const std::array<int, 3>& first = brick.box().first;
    if (texture.texel(first[0], first[1], first[2]) > first_bad) return;
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      const double distance = inside(point_of(i, j, k));
      if (!std::isnan(distance)) {
        brick.at(i, j, k) = detail::opacity_byte(detail::ramped_opacity(distance, texture.ramp));
        return;
      }
      const std::size_t texel = texture.texel(i, j, k);
      std::size_t least = first_bad;
      while (texel < least && !first_bad.compare_exchange_weak(least, texel)) {
      }
    });
  };
  texture.opacity = BrickGrid<std::uint8_t>::make(texture.size, set_opacity, progress, "volume texture");
  if (first_bad < texture.n_texels()) {
    const std::size_t row = static_cast<std::size_t>(texture.size[0]),
                      layer = row * static_cast<std::size_t>(texture.size[1]), bad = first_bad;
    throw InputError(fmt::format("the volume texture is not a number at texel ({}, {}, {})", bad % row,
                                 bad % layer / row, bad / layer));
  }
  if (!options.color) return texture;
  using Colors = BrickGrid<std::array<std::uint8_t, 3>>;
  const auto set_colors = [&](Colors::Brick& brick) {
    for_each_texel(brick.box(), [&](int i, int j, int k) {
      brick.at(i, j, k) = detail::color_bytes(options.color(point_of(i, j, k)));
    });
  };
  texture.colors = Colors::make(texture.size, set_colors, progress, "colours of the volume texture");
  return texture;
}

}  // namespace recede
