#include <recede/geometry/error.h>
#include <recede/render/detail/sample_blocks.h>
#include <recede/render/progressive_render.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

namespace recede {

namespace {

constexpr int k_most_samples = 1 << 30;
constexpr int k_samples_at_once = 64;  // between two reports of progress

}  // namespace

struct ProgressiveRender::State {
  State(const Scene& scene, const Camera& camera, const RenderOptions& render_options)
      : options(detail::checked(render_options)),
        tracer(scene.data(), camera, options),
        grid(camera.width, camera.height),
        counts(grid.count()),
        sums(new detail::BlockSums[grid.count()]) {}

  detail::Block block_at(int x, int y) const {
    const std::size_t i = grid.index(x / detail::k_packet_side, y / detail::k_packet_side);
    return {sums[i], counts[i]};
  }

  template <typename Value>
  Image picture_of(Value&& value) const;

  RenderOptions options;
  detail::PictureTracer tracer;
  detail::BlockGrid grid;
  std::vector<int> counts;  // of samples, by block
  // Without numbers until the first sample: the threads that take samples share the work of touching it.
  std::unique_ptr<detail::BlockSums[]> sums;
  int samples = 0;
};

template <typename Value>
Image ProgressiveRender::State::picture_of(Value&& value) const {
  Image image(tracer.width(), tracer.height());
  tbb::parallel_for(0, image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      const detail::Block block = block_at(x, y);
      const auto lane = detail::lane_of(x, y);
      for (std::size_t channel = 0; channel < 3; ++channel)
        image.at(x, y)[static_cast<int>(channel)] = static_cast<float>(value(block, channel, lane));
    }
  });
  return image;
}

ProgressiveRender::ProgressiveRender(const Scene& scene, const Camera& camera, const RenderOptions& options)
    : state_(std::make_unique<State>(scene, camera, options)) {}
ProgressiveRender::~ProgressiveRender() = default;
ProgressiveRender::ProgressiveRender(ProgressiveRender&&) noexcept = default;
ProgressiveRender& ProgressiveRender::operator=(ProgressiveRender&&) noexcept = default;

void ProgressiveRender::add_samples(int count, Progress* progress) {
  const int begin = state_->samples;
  if (count < 0 || count > k_most_samples - begin)
    throw OptionError("the samples of a picture lie between 0 and 2^30");
  const int end = begin + count;
  report_progress(progress, "render", 0);
  // In steps, so that the whole picture grows and a request to stop is heard soon.
  for (int from = begin; from < end; from += k_samples_at_once) {
    const int goal = std::min(end, from + k_samples_at_once);
    detail::for_each_block(state_->grid, static_cast<double>(from - begin) / count,
                           static_cast<double>(goal - begin) / count, progress, [&](int column, int row) {
                             const std::size_t i = state_->grid.index(column, row);
                             detail::take_samples(state_->tracer, state_->options.noise, column, row, goal,
                                                  state_->sums[i], state_->counts[i]);
                           });
  }
  state_->samples = end;
  report_progress(progress, "render", 1);
}

int ProgressiveRender::samples() const { return state_->samples; }

Image ProgressiveRender::image() const { return state_->picture_of(detail::mean); }

Image ProgressiveRender::standard_error() const { return state_->picture_of(detail::standard_error); }

FloatRaster ProgressiveRender::sample_counts() const {
  FloatRaster counts{state_->tracer.width(), state_->tracer.height(), {"samples"}, {}};
  for (int y = 0; y < counts.height; ++y) {
    for (int x = 0; x < counts.width; ++x)
      counts.samples.push_back(static_cast<float>(state_->block_at(x, y).samples));
  }
  return counts;
}

}  // namespace recede
