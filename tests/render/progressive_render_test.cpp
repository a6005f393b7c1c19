#include "measured_radiance.h"
#include "shapes.h"
#include <recede/geometry/error.h>
#include <recede/render/image_difference.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede {
namespace {

const Scene& bumpy_scene() {
  static const Scene scene(make_sphere(Vec3::Zero(), 1, 60, 30, 0.2),
                           {.crease_angle = 0, .ground = Ground{.up = Vec3::UnitY()}});
  return scene;
}

Camera camera_of(int side) {
  return {.position = Vec3(1, 1, 4), .field_of_view = 0.7, .width = side, .height = side};
}

// All kinds of lights.
RenderOptions many_lights(LightTransport transport) {
  RenderOptions options;
  options.transport = transport;
  options.lighting = daylight();
  options.lighting.points.push_back({.position = {1, 2, 2}, .intensity = Rgb(1, 2, 3)});
  options.lighting.areas.push_back({.corner = {-2, 2, 0}, .radiance = Rgb(3, 2, 1), .two_sided = true});
  return options;
}

TEST(ProgressiveRender, ThreadsAndPartsDoNotChangeABit) {
  for (const LightTransport transport :
       {LightTransport::camera, LightTransport::direct, LightTransport::path}) {
    for (const double noise : {0.0, 0.02}) {
      RenderOptions options = many_lights(transport);
      options.samples_per_pixel = 40;
      options.noise = noise;
      const auto picture = [&](std::size_t threads, const std::vector<int>& parts) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        ProgressiveRender render(bumpy_scene(), camera_of(50), options);
        for (const int part : parts) render.add_samples(part);
        EXPECT_EQ(render.samples(), 40);
        return std::pair(render.image().pixels, render.standard_error().pixels);
      };
      const auto whole = picture(1, {40});
      EXPECT_TRUE(picture(2, {40}) == whole);
      EXPECT_TRUE(picture(2, {1, 6, 0, 9, 24}) == whole);
      EXPECT_TRUE(render(bumpy_scene(), camera_of(50), options).pixels == whole.first);
    }
  }
}

TEST(ProgressiveRender, StopsWhenAskedAndGoesOnFromThere) {
  struct StopAfterTheFirstTile : Progress {
    // Of the tiles only the calling thread's are sure to be reported, and it has one at least.
    void update(std::string_view, double fraction) override { stopped |= fraction > 0; }
    bool cancel_requested() const override { return stopped; }
    bool stopped = false;
  } stop;
  const RenderOptions options = many_lights(LightTransport::path);
  ProgressiveRender stopped(bumpy_scene(), camera_of(100), options),
      whole(bumpy_scene(), camera_of(100), options);
  EXPECT_THROW(stopped.add_samples(8, &stop), Cancelled);
  EXPECT_EQ(stopped.samples(), 0);
  stopped.add_samples(8);
  whole.add_samples(8);
  EXPECT_TRUE(stopped.image().pixels == whole.image().pixels);
}

TEST(ProgressiveRender, ReportsProgressUpToItsEnd) {
  struct Record : Progress {
    void update(std::string_view stage, double fraction) override {
      EXPECT_EQ(stage, "render");
      EXPECT_TRUE(fraction >= last && fraction <= 1) << fraction << " after " << last;
      last = fraction;
    }
    double last = 0;
  } record;
  ProgressiveRender render(bumpy_scene(), camera_of(70), many_lights(LightTransport::direct));
  render.add_samples(150, &record);
  EXPECT_EQ(record.last, 1);
}

TEST(ProgressiveRender, ErrorsShrinkWithTheRootOfTheSamplesAndAreTrue) {
  RenderOptions options = many_lights(LightTransport::path);
  options.lighting.environment->radiance = Image(2, 1);  // black
  ProgressiveRender render(bumpy_scene(), camera_of(32), options),
      truth(bumpy_scene(), camera_of(32), options);
  EXPECT_TRUE(render.image().at(16, 16).isZero(0));
  render.add_samples(1);
  EXPECT_EQ(render.standard_error().at(16, 16).x(), std::numeric_limits<float>::infinity());
  const auto mean_square = [](const Image& image) {
    double sum = 0;
    for (const Rgb& pixel : image.pixels) sum += static_cast<double>(pixel.squaredNorm());
    return sum;
  };
  render.add_samples(15);
  const double of_16 = mean_square(render.standard_error());
  Image off = render.image();
  truth.add_samples(2048);
  const Image expected = truth.image();
  for (std::size_t i = 0; i < off.pixels.size(); ++i) off.pixels[i] -= expected.pixels[i];
  // Points that fill evenly are nearer to the truth than chance, which the estimate stands for.
  EXPECT_LT(mean_square(off), of_16);
  EXPECT_GT(mean_square(off), 0.01 * of_16);
  render.add_samples(48);
  EXPECT_NEAR(mean_square(render.standard_error()) / of_16, 0.25, 0.05);
}

TEST(ProgressiveRender, NoisyBlocksGetMoreSamplesUntilTheyAreGoodEnough) {
  RenderOptions options = many_lights(LightTransport::path);
  options.noise = 0.01;
  ProgressiveRender render(bumpy_scene(), camera_of(64), options);
  render.add_samples(512);
  const FloatRaster counts = render.sample_counts();
  float least = 1e9f, most = 0;
  for (const float count : counts.samples) {
    least = std::min(least, count);
    most = std::max(most, count);
    EXPECT_EQ(std::fmod(count, 16.0f), 0);
  }
  EXPECT_EQ(least, 16) << "the background has no noise";
  EXPECT_GE(most, 64);
  EXPECT_LT(most, 512) << "else the target was never reached";
  // Encoded values rise by at most 12.92 for a linear step; what is left is at most the target, RMS of
  // blocks.
  const Image errors = render.standard_error(), image = render.image();
  double sum = 0;
  for (std::size_t i = 0; i < errors.pixels.size(); ++i) {
    const float value = std::min(1.0f, image.pixels[i].x());
    const float step = encode_srgb(value) - encode_srgb(std::max(0.0f, value - errors.pixels[i].x()));
    sum += static_cast<double>(step * step);
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(errors.pixels.size())), 0.011);
}

TEST(ProgressiveRender, FewSamplesOfManyFillThePixelByTheCamerasLightToo) {
  RenderOptions options;
  options.samples_per_pixel = 1024;
  options.background = Rgb::Zero();
  options.camera_light = {.lamp = Rgb::Zero(), .sky = Rgb::Ones(), .ground = Rgb::Ones()};
  const Camera camera{.position = {0, 0, 3}, .field_of_view = 0.1, .width = 1, .height = 1};
  // A floor's border runs through the middle of the only pixel, in four directions.
  for (const Vec3& middle : {Vec3(-5, 0, 0), Vec3(5, 0, 0), Vec3(0, -5, 0), Vec3(0, 5, 0)}) {
    const Scene scene(with_albedo(make_floor(5, middle), 1));
    ProgressiveRender picture(scene, camera, options);
    for (const int samples : {16, 48, 960}) {
      picture.add_samples(samples);
      // One sample lies in each of as many columns and rows: one may be on the wrong side.
      EXPECT_NEAR(picture.image().at(0, 0).x(), 0.5, 1.01 / picture.samples()) << middle.transpose();
    }
  }
}

TEST(ProgressiveRender, BlocksOfTheCamerasLightEndWhenTheyAreGoodEnough) {
  RenderOptions options = many_lights(LightTransport::camera);
  options.samples_per_pixel = 1024;
  const Image whole = render(bumpy_scene(), camera_of(64), options);
  options.noise = 0.01;
  ProgressiveRender picture(bumpy_scene(), camera_of(64), options);
  picture.add_samples(1024);
  const FloatRaster counts = picture.sample_counts();
  EXPECT_EQ(*std::min_element(counts.samples.begin(), counts.samples.end()), 16);
  // The noise is an RMS over blocks, of the largest channel.
  EXPECT_LT(compare_images(picture.image(), whole).rmse, 0.01);
}

TEST(ProgressiveRender, OptionsOutOfRangeAreRefused) {
  const auto refuse = [](auto&& change) {
    RenderOptions options = many_lights(LightTransport::path);
    change(options);
    EXPECT_THROW(ProgressiveRender(bumpy_scene(), camera_of(4), options), OptionError);
  };
  refuse([](RenderOptions& o) { o.samples_per_pixel = 0; });
  refuse([](RenderOptions& o) { o.samples_per_pixel = 70000; });
  refuse([](RenderOptions& o) { o.max_bounces = -1; });
  refuse([](RenderOptions& o) { o.noise = -0.1; });
  refuse([](RenderOptions& o) { o.noise = std::nan(""); });
  refuse([](RenderOptions& o) { o.background.x() = std::nanf(""); });
  ProgressiveRender render(bumpy_scene(), camera_of(4), many_lights(LightTransport::path));
  EXPECT_THROW(render.add_samples(-1), OptionError);
}

}  // namespace
}  // namespace recede
