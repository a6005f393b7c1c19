#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/displacement_map.h>
#include <recede/geometry/error.h>
#include <recede/geometry/exr.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede {
namespace {

DisplacementMap from_png(const std::filesystem::path& path, const DisplacementMapOptions& options) {
  Raster raster = read_png(path);
  if (raster.channels != 1) {
    throw InputError::in_file(path.string(),
                              fmt::format("has {} channels; heights are one grey channel", raster.channels));
  }
  return {std::move(raster), options.scale, options.offset, options.border};
}

DisplacementMap from_exr(const std::filesystem::path& path, const DisplacementMapOptions& options) {
  const FloatRaster raster = read_exr(path);
  const auto grey = std::find(raster.channels.begin(), raster.channels.end(), "Y");
  if (grey == raster.channels.end() && raster.channels.size() != 1) {
    throw InputError::in_file(path.string(), "has neither a channel Y nor one channel alone");
  }
  const auto channel =
      grey == raster.channels.end() ? 0 : static_cast<std::size_t>(grey - raster.channels.begin());
  std::vector<float> heights;
  heights.reserve(raster.samples.size() / raster.channels.size());
  for (std::size_t i = channel; i < raster.samples.size(); i += raster.channels.size()) {
    const double height = options.offset + options.scale * static_cast<double>(raster.samples[i]);
    if (!std::isfinite(static_cast<float>(height))) {
      const auto width = static_cast<std::size_t>(raster.width);
      throw InputError::in_file(path.string(), fmt::format("the height of texel ({}, {}) is not finite",
                                                           heights.size() % width, heights.size() / width));
    }
    heights.push_back(static_cast<float>(height));
  }
  return {raster.width, raster.height, std::move(heights), options.border};
}

}  // namespace

DisplacementMap read_displacement_map(const std::filesystem::path& path,
                                      const DisplacementMapOptions& options) {
  if (!std::isfinite(options.scale) || !std::isfinite(options.offset)) {
    throw OptionError("displacement map: scale and offset must be finite");
  }
  const std::string extension = detail::lower_case_extension(path);
  if (extension == ".png") return from_png(path, options);
  if (extension == ".exr") return from_exr(path, options);
  throw InputError::in_file(path.string(), "is neither a .png nor an .exr file");
}

}  // namespace recede
