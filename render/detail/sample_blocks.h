// Samples of a picture, block by block, and what they sum up to.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/render/detail/picture_tracer.h>

#include <array>
#include <cstddef>
#include <functional>

namespace recede::detail {

/// Sums over the samples of 4 x 4 pixels.
struct BlockSums {
  std::array<std::array<double, k_lanes>, 3> sums, squares;
};

/// For reading; without samples, `of` may hold anything.
struct Block {
  const BlockSums& of;
  int samples;
};

double mean(const Block& block, std::size_t channel, std::size_t lane);
/// Of the mean. Infinite below two samples.
double standard_error(const Block& block, std::size_t channel, std::size_t lane);

/// Takes samples until the block has `goal` of them or is good enough for `options.noise`. The first one sets
/// the sums to zero before.
void take_samples(const PictureTracer& tracer, double noise, int column, int row, int goal, BlockSums& sums,
                  int& samples);

/// How a picture is cut.
struct BlockGrid {
  BlockGrid(int width, int height);
  int columns, rows;
  std::size_t count() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
};

/// `work(column, row)` for all blocks, tile by tile in parallel. Reports come from the calling thread, which
/// works with the others, so that a receiver hears from one thread only; `before` and `after` are the shares
/// of all the work at both ends.
void for_each_block(const BlockGrid& grid, double before, double after, Progress* progress,
                    const std::function<void(int, int)>& work);

/// Throws `OptionError` for what is out of range; otherwise its argument.
const RenderOptions& checked(const RenderOptions& options);

}  // namespace recede::detail
