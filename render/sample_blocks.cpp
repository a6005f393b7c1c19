#include <recede/geometry/error.h>
#include <recede/render/detail/flush_denormals.h>
#include <recede/render/detail/sample_blocks.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <thread>

namespace recede::detail {

namespace {

constexpr int k_tile_blocks = 8;   // a tile has 8 x 8 blocks
constexpr int k_noise_round = 16;  // samples between two looks at the noise

int ceiling_quotient(int number, int divisor) { return (number + divisor - 1) / divisor; }

void add(const std::array<float, k_lanes>& colors, std::array<double, k_lanes>& sums,
         std::array<double, k_lanes>& squares) {
  for (std::size_t lane = 0; lane < k_lanes; ++lane) {
    const double value = static_cast<double>(colors[lane]);
    sums[lane] += value;
    squares[lane] += value * value;
  }
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

}  // namespace

double mean(const Block& block, std::size_t channel, std::size_t lane) {
  return block.samples > 0 ? block.of.sums[channel][lane] / block.samples : 0.0;
}

double standard_error(const Block& block, std::size_t channel, std::size_t lane) {
  if (block.samples < 2) return std::numeric_limits<double>::infinity();
  const double n = block.samples, center = mean(block, channel, lane);
  const double variance =
      std::max(0.0, (block.of.squares[channel][lane] / n - center * center) * n / (n - 1));
  return std::sqrt(variance / n);
}

void take_samples(const PictureTracer& tracer, double noise, int column, int row, int goal, BlockSums& sums,
                  int& samples) {
  if (samples == 0 && goal > 0) sums = {};
  BlockColors colors;
  while (samples < goal && !is_good_enough({sums, samples}, noise)) {
    tracer.sample_block(column * k_packet_side, row * k_packet_side, samples, colors);
    add(colors.red, sums.sums[0], sums.squares[0]);
    add(colors.green, sums.sums[1], sums.squares[1]);
    add(colors.blue, sums.sums[2], sums.squares[2]);
    ++samples;
  }
}

BlockGrid::BlockGrid(int width, int height)
    : columns(ceiling_quotient(width, k_packet_side)), rows(ceiling_quotient(height, k_packet_side)) {}

void for_each_block(const BlockGrid& grid, double before, double after, Progress* progress,
                    const std::function<void(int, int)>& work) {
  const int across = ceiling_quotient(grid.columns, k_tile_blocks);
  const int tiles = across * ceiling_quotient(grid.rows, k_tile_blocks);
  std::atomic<int> done = 0;
  const std::thread::id caller = std::this_thread::get_id();
  tbb::parallel_for(0, tiles, [&](int tile) {
    const FlushDenormals flush;
    const int left = tile % across * k_tile_blocks, top = tile / across * k_tile_blocks;
    for (int row = top; row < std::min(grid.rows, top + k_tile_blocks); ++row) {
      for (int column = left; column < std::min(grid.columns, left + k_tile_blocks); ++column)
        work(column, row);
    }
    const double share = static_cast<double>(++done) / tiles;
    if (std::this_thread::get_id() == caller)
      report_progress(progress, "render", before + share * (after - before));
  });
}

const RenderOptions& checked(const RenderOptions& options) {
  check(options);
  return options;
}

}  // namespace recede::detail
