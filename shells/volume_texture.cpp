#include <recede/geometry/error.h>
#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/volume_texture.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <atomic>

namespace recede {

void validate(const VolumeTexture& texture, const std::string& source) {
  const auto refuse = [&](const std::string& why) { throw InputError(fmt::format("{}: {}", source, why)); };
  for (const int size : texture.size) {
    if (size < 1) refuse("a volume texture needs a texel and more along each axis");
  }
  if (texture.opacity.size() != texture.n_texels()) {
    refuse(fmt::format("a volume texture of {} x {} x {} has {} opacities", texture.size[0], texture.size[1],
                       texture.size[2], texture.opacity.size()));
  }
  if (!texture.colors.empty() && texture.colors.size() != texture.n_texels())
    refuse(fmt::format("a volume texture of {} texels has {} colours", texture.n_texels(),
                       texture.colors.size()));
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
  texture.opacity.resize(texture.n_texels());
  if (options.color) texture.colors.resize(texture.n_texels());
  double side = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    side = std::max(side, options.extent[static_cast<int>(axis)] / options.size[axis]);
  texture.ramp = options.ramp_texels * side;

  std::atomic<std::size_t> first_bad = texture.n_texels();  // the least, whatever the threads
  for (int k = 0; k < texture.size[2]; ++k) {
    report_progress(progress, "volume texture", static_cast<double>(k) / texture.size[2]);
    tbb::parallel_for(0, texture.size[1], [&](int j) {
      for (int i = 0; i < texture.size[0]; ++i) {
        const Vec3 point = texture.middle(i, j, k).cwiseProduct(texture.extent);
        const double distance = inside(point);
        const std::size_t texel = texture.texel(i, j, k);
        if (std::isnan(distance)) {
          std::size_t least = first_bad;
          while (texel < least && !first_bad.compare_exchange_weak(least, texel)) {
          }
          continue;
        }
        const double opacity = detail::ramped_opacity(distance, texture.ramp);
        texture.opacity[texel] = detail::opacity_byte(opacity);
        if (options.color) texture.colors[texel] = detail::color_bytes(options.color(point));
      }
    });
    if (first_bad < texture.n_texels()) {
      const std::size_t row = static_cast<std::size_t>(texture.size[0]),
                        in_layer = first_bad % (row * static_cast<std::size_t>(texture.size[1]));
      throw InputError(fmt::format("the volume texture is not a number at texel ({}, {}, {})", in_layer % row,
                                   in_layer / row, k));
    }
  }
  report_progress(progress, "volume texture", 1);
  return texture;
}

}  // namespace recede
