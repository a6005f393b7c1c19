#include "common.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/image_difference.h>
#include <recede/render/image_io.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

namespace recede::cli {
namespace {

enum class MapKind { flip, ssim, difference };

struct DiffOptions {
  CommonOptions common;
  std::string first, second, mask, output;
  MapKind map = MapKind::flip;
  FlipOptions flip;
  std::optional<double> fail_above;
};

struct Inputs {
  Image first, second;
  ImageMask mask;
};

struct Measures {
  ImageDifference difference;
  ImageMeasure ssim, flip;
  std::size_t pixels = 0;  ///< that count
};

/// Like `read_image`, of the size of the first image.
Image read_of_size(const std::string& file, const Image& first, const std::string& first_file) {
  Image image = read_image(file);
  if (image.width == first.width && image.height == first.height) return image;
  throw InputError::in_file(file, fmt::format("has {} x {} pixels, but {} has {} x {}", image.width,
                                              image.height, first_file, first.width, first.height));
}

Inputs read_inputs(const DiffOptions& options) {
  Inputs inputs{.first = read_image(options.first), .second = {}, .mask = {}};
  inputs.second = read_of_size(options.second, inputs.first, options.first);
  if (options.mask.empty()) return inputs;
  inputs.mask = mask_of(read_of_size(options.mask, inputs.first, options.first));
  const std::vector<std::uint8_t>& inside = inputs.mask.inside;
  if (std::find(inside.begin(), inside.end(), 1) == inside.end())
    throw InputError::in_file(options.mask, "no pixel is lighter than 0.5");
  return inputs;
}

Measures measure(const Inputs& inputs, const FlipOptions& options) {
  const auto& [first, second, mask] = inputs;
  Measures measures{compare_images(first, second, mask), compute_ssim(first, second, mask),
                    compute_flip(first, second, options, mask), first.pixels.size()};
  if (!mask.inside.empty())
    measures.pixels = static_cast<std::size_t>(std::count(mask.inside.begin(), mask.inside.end(), 1));
  return measures;
}

/// 0 where nothing differs.
FloatRaster map_of(const Measures& measures, MapKind kind) {
  if (kind == MapKind::flip) return measures.flip.map;
  if (kind == MapKind::difference) return measures.difference.magnitudes;
  FloatRaster map = measures.ssim.map;
  for (float& value : map.samples) value = 1 - value;
  return map;
}

void write_map(const std::string& file, const FloatRaster& map) {
  if (is_exr(file)) return write_file_atomically(file, encode_exr(map));
  write_png(file, heat_map(map, 1));
}

void print_text(const Measures& measures, const Image& first, const DiffOptions& options) {
  const ImageDifference& difference = measures.difference;
  fmt::print("size         {} x {} pixels, {} compared\n", first.width, first.height, measures.pixels);
  fmt::print("flip         {:.5f}, mean at {} pixels per degree\n", measures.flip.mean,
             options.flip.pixels_per_degree);
  fmt::print("ssim         {:.5f}, mean\n", measures.ssim.mean);
  fmt::print("psnr         {:.2f} dB\n", difference.psnr);
  fmt::print("rmse         {:.5f}, of sRGB values from 0 to 1\n", difference.rmse);
  fmt::print("maximum      {:.5f}\n", difference.max);
  fmt::print("changed      {:.4g} % of the pixels by more than 1/255\n", 100 * difference.changed_share);
}

Json to_json(const Measures& measures, const Image& first, const DiffOptions& options, double seconds) {
  const auto file_or_null = [](const std::string& file) { return file.empty() ? Json() : Json(file); };
  const double psnr = measures.difference.psnr;
  return {{"command", "diff"},
          {"first", {{"input", options.first}}},
          {"second", {{"input", options.second}}},
          {"mask", file_or_null(options.mask)},
          {"output", file_or_null(options.output)},
          {"width", first.width},
          {"height", first.height},
          {"pixels", measures.pixels},
          {"flip", measures.flip.mean},
          {"pixels_per_degree", options.flip.pixels_per_degree},
          {"ssim", measures.ssim.mean},
          {"psnr", std::isfinite(psnr) ? Json(psnr) : Json()},
          {"rmse", measures.difference.rmse},
          {"max", measures.difference.max},
          {"changed_share", measures.difference.changed_share},
          {"seconds", seconds}};
}

void run(const DiffOptions& options) {
  if (!options.output.empty()) check_image_path(options.output);
  const Inputs inputs = read_inputs(options);
  const auto start = std::chrono::steady_clock::now();
  const Measures measures = measure(inputs, options.flip);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!options.output.empty()) write_map(options.output, map_of(measures, options.map));
  if (options.common.json) {
    print_json(to_json(measures, inputs.first, options, seconds));
  } else {
    print_text(measures, inputs.first, options);
  }
  if (options.fail_above && measures.flip.mean > *options.fail_above)
    throw Error(fmt::format("FLIP of {:.5g} is above {:.5g}", measures.flip.mean, *options.fail_above));
}

}  // namespace

void add_diff_command(CLI::App& app) {
  const auto options = std::make_shared<DiffOptions>();
  CLI::App* command = app.add_subcommand("diff", "Measures how much two pictures differ.");
  command->footer("Example:\n  recede diff before.png after.png -o heat.png --fail-above 0.01");
  command->add_option("first", options->first, "picture (.png .exr)")->required();
  command->add_option("second", options->second, "the other picture, of the same size")->required();
  command->add_option("--mask", options->mask, "picture of that size: only pixels lighter than 0.5 count");
  CLI::Option* output = command->add_option("-o,--output", options->output,
                                            "map to write: colours (.png) or its values (.exr)");
  command->add_option("--map", options->map, "what the map shows: flip (default), ssim or difference")
      ->transform(one_of<MapKind>(
          {{"flip", MapKind::flip}, {"ssim", MapKind::ssim}, {"difference", MapKind::difference}}))
      ->needs(output);
  command
      ->add_option("--pixels-per-degree", options->flip.pixels_per_degree,
                   "pixels that a degree of the viewer's field of view covers, for FLIP (67.02)")
      ->check(between(1.0, 1000.0));
  command
      ->add_option("--fail-above", options->fail_above, "exit with 1 when FLIP's mean is above this, 0 to 1")
      ->check(between(0.0, 1.0));
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
