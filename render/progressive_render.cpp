#include <recede/geometry/error.h>
#include <recede/render/detail/flush_denormals.h>
#include <recede/render/detail/picture_tracer.h>
#include <recede/render/progressive_render.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

namespace recede {

namespace {

using detail::k_lanes;
using detail::k_packet_side;

constexpr int k_tile_blocks = 8;  // a tile has 8 x 8 blocks of 4 x 4 pixels
constexpr int k_most_samples = 1 << 30;
constexpr int k_samples_at_once = 64;  // between two reports of progress
constexpr int k_noise_round = 16;      // samples between two looks at the noise

/// Sums over the samples of 4 x 4 pixels.
struct Block {
  std::array<std::array<double, k_lanes>, 3> sums{}, squares{};
  int samples = 0;
};

void add(const std::array<float, k_lanes>& colors, std::array<double, k_lanes>& sums,
         std::array<double, k_lanes>& squares) {
  for (std::size_t lane = 0; lane < k_lanes; ++lane) {
    const double value = static_cast<double>(colors[lane]);
    sums[lane] += value;
    squares[lane] += value * value;
  }
}

double mean(const Block& block, std::size_t channel, std::size_t lane) {
  return block.samples > 0 ? block.sums[channel][lane] / block.samples : 0.0;
}

double standard_error(const Block& block, std::size_t channel, std::size_t lane) {
  if (block.samples < 2) return std::numeric_limits<double>::infinity();
  const double n = block.samples, center = mean(block, channel, lane);
  const double variance = std::max(0.0, (block.squares[channel][lane] / n - center * center) * n / (n - 1));
  return std::sqrt(variance / n);
}

// The standard error as a screen shows it: the largest of the three channels, RMS over the block's pixels.
double visible_noise(const Block& block) {
  double sum = 0;
  for (std::size_t lane = 0; lane < k_lanes; ++lane) {
    float largest = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const double center = std::min(mean(block, channel, lane), 1.0);
      const double error = standard_error(block, channel, lane);
      // Upwards in dark places, downwards from white, where the screen ends.
      const double other = center < 0.5 ? center + error : std::max(0.0, center - error);
      largest = std::max(largest, std::abs(encode_srgb(static_cast<float>(other)) -
                                           encode_srgb(static_cast<float>(center))));
    }
    sum += static_cast<double>(largest * largest);
  }
  return std::sqrt(sum / k_lanes);
}

// Looks at whole rounds only, so that it doesn't matter how many samples were added at once.
bool is_good_enough(const Block& block, double noise) {
  return noise > 0 && block.samples > 0 && block.samples % k_noise_round == 0 &&
         visible_noise(block) <= noise;
}

void check(const RenderOptions& options) {
  const int most = options.transport == LightTransport::camera ? 1024 : 65536;
  if (options.samples_per_pixel < 1 || options.samples_per_pixel > most)
    throw OptionError("samples per pixel lie between 1 and " + std::to_string(most));
  if (options.max_bounces < 0 || options.max_bounces > 1000)
    throw OptionError("the bounces of a path lie between 0 and 1000");
  if (!(options.noise >= 0 && options.noise <= 1)) throw OptionError("the noise lies between 0 and 1");
  if (!options.background.allFinite()) throw OptionError("the background must be finite");
  if (!options.wireframe) return;
  if (!(options.wireframe->width > 0)) throw OptionError("the width of wireframe lines is above 0 pixels");
  if (!(options.wireframe->darkness >= 0 && options.wireframe->darkness <= 1)) {
    throw OptionError("the darkness of wireframe lines lies between 0 and 1");
  }
}

const RenderOptions& checked(const RenderOptions& options) {
  check(options);
  return options;
}

int ceiling_quotient(int number, int divisor) { return (number + divisor - 1) / divisor; }

}  // namespace

struct ProgressiveRender::State {
  State(const Scene& scene, const Camera& camera, const RenderOptions& render_options)
      : options(checked(render_options)),
        tracer(scene.data(), camera, options),
        columns(ceiling_quotient(camera.width, k_packet_side)),
        rows(ceiling_quotient(camera.height, k_packet_side)),
        blocks(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

  Block& block(int column, int row) {
    return blocks[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(column)];
  }

  void sample_block(int column, int row, int goal);
  void sample_tile(int tile, int tiles_across, int goal);
  void sample_picture(int goal, double before, double after, Progress* progress);

  template <typename Value>
  Image picture_of(Value&& value);

  RenderOptions options;
  detail::PictureTracer tracer;
  int columns, rows;
  std::vector<Block> blocks;
  int samples = 0;
};

void ProgressiveRender::State::sample_block(int column, int row, int goal) {
  Block& sum = block(column, row);
  detail::BlockColors colors;
  while (sum.samples < goal && !is_good_enough(sum, options.noise)) {
    tracer.sample_block(column * k_packet_side, row * k_packet_side, sum.samples, colors);
    add(colors.red, sum.sums[0], sum.squares[0]);
    add(colors.green, sum.sums[1], sum.squares[1]);
    add(colors.blue, sum.sums[2], sum.squares[2]);
    ++sum.samples;
  }
}

void ProgressiveRender::State::sample_tile(int tile, int tiles_across, int goal) {
  const detail::FlushDenormals flush;
  const int left = tile % tiles_across * k_tile_blocks, top = tile / tiles_across * k_tile_blocks;
  for (int row = top; row < std::min(rows, top + k_tile_blocks); ++row) {
    for (int column = left; column < std::min(columns, left + k_tile_blocks); ++column)
      sample_block(column, row, goal);
  }
}

// Until all blocks have `goal` samples. Reports come from the calling thread, which works with the others, so
// that a receiver hears from one thread only; `before` and `after` are the work's shares at both ends.
void ProgressiveRender::State::sample_picture(int goal, double before, double after, Progress* progress) {
  const int across = ceiling_quotient(columns, k_tile_blocks), down = ceiling_quotient(rows, k_tile_blocks);
  std::atomic<int> done = 0;
  const std::thread::id caller = std::this_thread::get_id();
  tbb::parallel_for(0, across * down, [&](int tile) {
    sample_tile(tile, across, goal);
    const double share = static_cast<double>(++done) / (across * down);
    if (std::this_thread::get_id() == caller)
      report_progress(progress, "render", before + share * (after - before));
  });
}

template <typename Value>
Image ProgressiveRender::State::picture_of(Value&& value) {
  Image image(tracer.width(), tracer.height());
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Block& sum = block(x / k_packet_side, y / k_packet_side);
      const auto lane = static_cast<std::size_t>(y % k_packet_side * k_packet_side + x % k_packet_side);
      for (std::size_t channel = 0; channel < 3; ++channel)
        image.at(x, y)[static_cast<int>(channel)] = static_cast<float>(value(sum, channel, lane));
    }
  }
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
    state_->sample_picture(goal, static_cast<double>(from - begin) / count,
                           static_cast<double>(goal - begin) / count, progress);
  }
  state_->samples = end;
  report_progress(progress, "render", 1);
}

int ProgressiveRender::samples() const { return state_->samples; }

Image ProgressiveRender::image() const { return state_->picture_of(mean); }

Image ProgressiveRender::standard_error() const { return state_->picture_of(recede::standard_error); }

FloatRaster ProgressiveRender::sample_counts() const {
  FloatRaster counts{state_->tracer.width(), state_->tracer.height(), {"samples"}, {}};
  for (int y = 0; y < counts.height; ++y) {
    for (int x = 0; x < counts.width; ++x)
      counts.samples.push_back(
          static_cast<float>(state_->block(x / k_packet_side, y / k_packet_side).samples));
  }
  return counts;
}

}  // namespace recede
