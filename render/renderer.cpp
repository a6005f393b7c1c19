#include <recede/render/detail/sample_blocks.h>
#include <recede/render/progressive_render.h>

namespace recede {

namespace {

// As many are taken of a block at once, so that a request to stop is heard soon.
constexpr int k_few_samples = 64;

void write_block(const detail::Block& block, int column, int row, Image& image) {
  for (int lane = 0; lane < detail::k_lanes; ++lane) {
    const int x = column * detail::k_packet_side + detail::column_of(lane);
    const int y = row * detail::k_packet_side + detail::row_of(lane);
    if (x >= image.width || y >= image.height) continue;
    for (std::size_t channel = 0; channel < 3; ++channel)
      image.at(x, y)[static_cast<int>(channel)] =
          static_cast<float>(detail::mean(block, channel, static_cast<std::size_t>(lane)));
  }
}

}  // namespace

// The same bytes as those of a ProgressiveRender. With few samples each block is done in one go, and no sums
// are kept, which need four times the memory of the image.
Image render(const Scene& scene, const Camera& camera, const RenderOptions& options, Progress* progress) {
  if (options.samples_per_pixel > k_few_samples) {
    ProgressiveRender picture(scene, camera, options);
    picture.add_samples(options.samples_per_pixel, progress);
    return picture.image();
  }
  const detail::PictureTracer tracer(scene.data(), camera, detail::checked(options));
  Image image(camera.width, camera.height);
  report_progress(progress, "render", 0);
  detail::for_each_block(
      detail::BlockGrid(camera.width, camera.height), 0, 1, progress, [&](int column, int row) {
        detail::BlockSums sums;
        int samples = 0;
        detail::take_samples(tracer, options.noise, column, row, options.samples_per_pixel, sums, samples);
        write_block({sums, samples}, column, row, image);
      });
  report_progress(progress, "render", 1);
  return image;
}

}  // namespace recede
