// A picture that gets better with every sample.
#pragma once

#include <recede/geometry/exr.h>
#include <recede/render/renderer.h>

#include <memory>

namespace recede {

/// Adds samples to a picture as long as one likes. After n samples the picture has the same bytes, whether
/// they were added at once or in parts, and for any number of threads; they are those of `render` with as
/// many `samples_per_pixel`.
class ProgressiveRender {
 public:
  /// The scene must live as long as this. Throws `OptionError` and `InputError` as `render` does.
  ProgressiveRender(const Scene& scene, const Camera& camera, const RenderOptions& options = {});
  ~ProgressiveRender();
  ProgressiveRender(ProgressiveRender&&) noexcept;
  ProgressiveRender& operator=(ProgressiveRender&&) noexcept;

  /// Adds `count` samples to every pixel, 0 or more; fewer to pixels that are good enough when
  /// `options.noise` is set. With the camera's light, samples beyond `samples_per_pixel` repeat its pattern.
  /// Throws `OptionError` for a negative number or more than 2^30 in all, and `Cancelled`: then some pixels
  /// have the samples already, `samples` doesn't count them, and the next call goes on from there.
  void add_samples(int count, Progress* progress = nullptr);

  /// All that were added to each pixel.
  int samples() const;

  /// Means over samples. Black before the first one.
  Image image() const;

  /// Per channel, the standard deviation of the mean, from the spread of a pixel's samples: an estimate, and
  /// too large as a rule, since samples are spread more evenly than by chance. Infinite below two samples.
  Image standard_error() const;

  /// How many samples each pixel has, one channel.
  FloatRaster sample_counts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace recede
