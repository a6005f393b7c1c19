#include <recede/geometry/raster.h>
#include <recede/render/coverage.h>

#include <algorithm>

namespace recede {

FloatRaster render_coverage(const Scene& scene, const Camera& camera, const RenderOptions& options,
                            Progress* progress) {
  constexpr int k_most_samples = 1024;  // with the camera's light
  RenderOptions plain;
  plain.samples_per_pixel = std::min(options.samples_per_pixel, k_most_samples);
  plain.representation = options.representation;
  plain.transition = options.transition;
  // What white in the place of black behind the scene adds is what the scene doesn't cover.
  plain.background = Rgb::Zero();
  const Image over_black = render(scene, camera, plain, progress);
  plain.background = Rgb::Ones();
  const Image over_white = render(scene, camera, plain, progress);
  FloatRaster coverage;
  coverage.width = camera.width;
  coverage.height = camera.height;
  coverage.channels = {"Y"};
  for (std::size_t i = 0; i < over_black.pixels.size(); ++i) {
    const float seen_through = (over_white.pixels[i] - over_black.pixels[i]).maxCoeff();
    coverage.samples.push_back(std::clamp(1 - seen_through, 0.0f, 1.0f));
  }
  return coverage;
}

Image mask_picture(const FloatRaster& coverage) {
  Image picture;
  picture.width = coverage.width;
  picture.height = coverage.height;
  for (const float value : coverage.samples) picture.pixels.emplace_back(Rgb::Constant(decode_srgb(value)));
  return picture;
}

}  // namespace recede
