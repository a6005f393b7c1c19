#include "uv_sheet.h"
#include <recede/geometry/error.h>
#include <recede/render/image_difference.h>
#include <recede/render/renderer.h>
#include <recede/render/volume_levels.h>
#include <recede/shells/procedural_volumes.h>

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace {

using namespace recede;

PolygonSoup square(int n) { return test::uv_sheet(n); }

PlacedVolume placed(const PolygonSoup& base, const VolumeTexture& texture, double thickness,
                    const Vec2& repeat) {
  PlacedVolume volume;
  volume.textured.shell = std::make_shared<const Shell>(
      build_shell(base, {.thickness = thickness, .method = DirectorMethod::normals}));
  volume.textured.texture = std::make_shared<const VolumeMipmap>(make_mipmap(texture));
  volume.textured.coordinates.repeat = repeat;
  return volume;
}

Image picture(const PlacedVolume& volume, const Camera& camera, int samples) {
  const Scene scene({}, std::span<const PlacedVolume>(&volume, 1));
  return render(scene, camera, {.samples_per_pixel = samples, .background = Rgb::Zero(), .camera_light = {}});
}

Rgb mean_of(const Image& image) {
  Rgb sum = Rgb::Zero();
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += image.at(x, y);
  return sum / static_cast<float>(image.width * image.height);
}

// A ball in each of 2 x 2 periods, in a layer as thick as a period is wide, is seen where balls would be.
TEST(ShellVolume, ShowsBallsWhereTheyAre) {
  const VolumeTexture texture =
      make_volume([](const Vec3& point) { return 0.3 - (point - Vec3(0.5, 0.5, 0.5)).norm(); },
                  {.size = {48, 48, 48}, .extent = Vec3::Ones()});
  const PlacedVolume volume = placed(square(3), texture, 1, {2, 2});
  const Camera camera{.position = {0.3, -4, 5}, .target = {0, 0, 0.5}, .width = 160, .height = 160};
  const Image image = picture(volume, camera, 1);
  const CameraFrame frame = frame_of(camera);
  int wrong = 0, inside = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vec3 direction = frame.direction(x + 0.5, y + 0.5);
      double nearest = 10;
      for (const Vec3& center :
           {Vec3(-0.5, -0.5, 0.5), Vec3(0.5, -0.5, 0.5), Vec3(-0.5, 0.5, 0.5), Vec3(0.5, 0.5, 0.5)}) {
        const Vec3 off = center - frame.position;
        nearest = std::min(nearest, (off - off.dot(direction) * direction).norm());
      }
      const bool is_hit = image.at(x, y).sum() > 0;
      inside += is_hit ? 1 : 0;
      // Samples aren't at pixels' middles, and the texture is off by less than a hundredth at the surface:
      // pixels within 0.03 of an outline count for neither.
      if (std::abs(nearest - 0.3) > 0.03 && is_hit != (nearest < 0.3)) ++wrong;
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(inside, 1000);
}

// The same texture on few large and many small triangles: walls between prisms can't be seen.
TEST(ShellVolume, HasNoSeamsBetweenPrisms) {
  const VolumeTexture texture = make_volume(weave(), 32);
  const Camera camera{.position = {0.4, -3, 2}, .target = {0, 0, 0}, .width = 120, .height = 120};
  const Image coarse = picture(placed(square(1), texture, 0.3, {4, 4}), camera, 1),
              fine = picture(placed(square(16), texture, 0.3, {4, 4}), camera, 1);
  int differ = 0;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      if ((coarse.at(x, y) - fine.at(x, y)).cwiseAbs().maxCoeff() > 0.02f) ++differ;
  // Rays that just touch a thread may miss or meet it, as steps begin elsewhere.
  EXPECT_LE(differ, camera.width * camera.height / 500);
}

// Over a quad that is wider on one side a texture is bilinear, as over many small quads between its sides;
// cut into two prisms it bends at the diagonal.
TEST(ShellVolume, DoesNotBendOverQuads) {
  const auto trapezoid = [](int n) {
    PolygonSoup base = square(n);
    for (Vec3& p : base.positions) p.x() *= 0.65 - 0.35 * p.y();
    return base;
  };
  const VolumeTexture texture = make_volume(weave(), 32);
  const Camera camera{.position = {0.1, -0.4, 4}, .target = {0, 0, 0}, .width = 120, .height = 120};
  const auto differing = [&](const PolygonSoup& base, const Image& other) {
    const Image image = picture(placed(base, texture, 0.2, {4, 4}), camera, 1);
    int differ = 0;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x)
        differ += (image.at(x, y) - other.at(x, y)).cwiseAbs().maxCoeff() > 0.1f;
    return differ;
  };
  const Image fine = picture(placed(trapezoid(32), texture, 0.2, {4, 4}), camera, 1);
  const Shell cut = build_shell(trapezoid(1), {.thickness = 0.2});
  // Rays that just touch a thread may miss or meet it; frames are interpolated over longer ways.
  const int of_quad = differing(trapezoid(1), fine), of_prisms = differing(cut.base, fine);
  EXPECT_LE(of_quad, camera.width * camera.height / 100);
  EXPECT_GT(of_prisms, camera.width * camera.height / 10);
}

// Two textures in one layer show what the larger opacity of both does, and one moves by its coordinates
// alone.
TEST(ShellVolume, TwoTexturesInALayerAreTheirUnion) {
  const auto ball = [](double x, double y) {
    return [=](const Vec3& point) { return 0.22 - (point - Vec3(x, y, 0.5)).norm(); };
  };
  const VolumeOptions options{.size = {32, 32, 32}, .extent = Vec3::Ones(), .is_periodic = false};
  const VolumeTexture first = make_volume(ball(0.4, 0.4), options),
                      second = make_volume(ball(0.6, 0.6), options);
  const Camera camera{.position = {0.3, -4, 5}, .target = {0, 0, 0.5}, .width = 120, .height = 120};
  const auto in_layer = [](const VolumeTexture& texture) {
    PlacedVolume volume;
    volume.textured.shell = std::make_shared<const Shell>(
        build_shell(square(2), {.thickness = 1, .method = DirectorMethod::normals}));
    volume.textured.texture = finest_only(texture);
    return volume;
  };
  for (const int moved : {0, 4}) {  // texels
    VolumeTexture both = first;
    both.opacity = BrickGrid<std::uint8_t>::make(both.size, [&](BrickGrid<std::uint8_t>::Brick& brick) {
      for_each_texel(brick.box(), [&](int i, int j, int k) {
        const std::uint8_t other = i < moved ? std::uint8_t{0} : second.opacity.at(i - moved, j, k);
        brick.at(i, j, k) = std::max(first.opacity.at(i, j, k), other);
      });
    });
    std::vector<PlacedVolume> two{in_layer(first), in_layer(second)};
    two[1].textured.coordinates.offset.x() = -moved / 32.0;
    const PlacedVolume united = in_layer(both);
    const RenderOptions rendering{.samples_per_pixel = 1, .background = Rgb::Zero(), .camera_light = {}};
    const Image apart = render(Scene({}, std::span<const PlacedVolume>(two)), camera, rendering),
                together = picture(united, camera, 1);
    int differ = 0, seen = 0;
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        differ += (apart.at(x, y) - together.at(x, y)).cwiseAbs().maxCoeff() > 0.02f ? 1 : 0;
        seen += together.at(x, y).sum() > 0 ? 1 : 0;
      }
    }
    // Where the two balls meet gradients of the larger one have a crease, smoothed over two texels.
    EXPECT_LE(differ, seen / 25);
    EXPECT_GT(seen, 400);
  }
}

// Normals are those of a ball, as well in a layer that points inwards.
TEST(ShellVolume, ShadesByTheGradientOnBothSides) {
  const VolumeTexture texture =
      make_volume([](const Vec3& point) { return 0.3 - (point - Vec3(0.5, 0.5, 0.5)).norm(); },
                  {.size = {64, 64, 64}, .extent = Vec3::Ones()});
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    PlacedVolume volume = placed(square(2), texture, 1, {2, 2});
    volume.textured.shell = std::make_shared<const Shell>(
        build_shell(square(2), {.thickness = 1, .side = side, .method = DirectorMethod::normals}));
    volume.textured.side = side;
    volume.color = Rgb::Ones();
    const double height = side == ShellSide::exterior ? 0.5 : -0.5;
    const Camera camera{.position = {0.5, 0.5, 6},
                        .target = {0.5, 0.5, 0},
                        .up = Vec3::UnitY(),
                        .field_of_view = 0.1,
                        .width = 64,
                        .height = 64};
    RenderOptions options{.samples_per_pixel = 1, .background = Rgb::Zero()};
    options.transport = LightTransport::direct;
    options.lighting = {.directionals = {{.toward = Vec3(0.6, 0, 0.8),
                                          .irradiance = Rgb::Constant(static_cast<float>(std::numbers::pi))}},
                        .ambient = 0};
    const Scene scene({}, std::span<const PlacedVolume>(&volume, 1));
    const Image image = render(scene, camera, options);
    const CameraFrame frame = frame_of(camera);
    int checked = 0;
    for (int y = 4; y < 64; y += 4) {
      for (int x = 4; x < 64; x += 4) {
        const Vec3 direction = frame.direction(x + 0.5, y + 0.5);
        const Vec3 from_center = frame.position - Vec3(0.5, 0.5, height);
        const double b = from_center.dot(direction), c = from_center.squaredNorm() - 0.09;
        if (b * b - c < 0.02) continue;  // near the outline normals turn fast
        const Vec3 normal = (from_center + (-b - std::sqrt(b * b - c)) * direction) / 0.3;
        const double lit = normal.dot(Vec3(0.6, 0, 0.8));
        if (lit < 0.1) continue;
        // Pixels are 0.01 wide, over which normals turn by 2 degrees; rounding turns them by a degree.
        EXPECT_NEAR(static_cast<double>(image.at(x, y).x()), lit, 0.05) << x << " " << y;
        ++checked;
      }
    }
    EXPECT_GT(checked, 60);
  }
}

// Far away, a sheet is as opaque and as bright as its finest texture seen with many samples.
void expect_alike_from_afar(const ProceduralVolume& procedural, double tolerance) {
  constexpr double k_period = 2.0 / 32;
  const Vec3& extent = procedural.extent;
  PlacedVolume volume = placed(square(2), make_volume(procedural, 64), k_period * extent.z() / extent.x(),
                               {32, 32 * extent.x() / extent.y()});
  for (const double elevation : {90.0, 45.0}) {
    // Four periods wide, far from the sheet's borders.
    const double angle = elevation * std::numbers::pi / 180;
    const Camera camera{.position = {0, -10 * std::cos(angle), 10 * std::sin(angle)},
                        .target = Vec3::Zero(),
                        .up = elevation < 90 ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::UnitY()),
                        .field_of_view = 2 * std::atan(0.0125),
                        .width = 24,
                        .height = 24};
    const double reference = static_cast<double>(mean_of(picture(volume, camera, 64)).sum());
    for (int level = 0; level <= 6; ++level) {
      // As if pixels were as wide as texels of that level.
      volume.view = VolumeView{{0, 0, 1000}, k_period / 64 * std::pow(2.0, level) / 1000};
      const double mean = static_cast<double>(mean_of(picture(volume, camera, 32)).sum());
      EXPECT_NEAR(mean / reference, 1, tolerance) << "level " << level << " from " << elevation;
    }
    volume.view.reset();
  }
}

TEST(ShellVolume, FarAwayIsAsOpaqueAndBrightAsNearBy) {
  ProceduralVolume grey = weave();
  grey.color = nullptr;
  // Measured: 0.026 at most. Corrections come from some 320 rays of a direction, whose normals' means are off
  // by 0.03 and less.
  expect_alike_from_afar(chain_mail(), 0.04);
  expect_alike_from_afar(grey, 0.04);
  // Measured: 0.069. Threads of one colour lie in another light than those of the other, and means of both
  // are multiplied.
  expect_alike_from_afar(weave(), 0.08);
}

// Share of the rays that a sheet of 16 x 16 periods stops, far from its borders, as if pixels were as wide as
// texels of a level.
struct SheetFromAfar {
  explicit SheetFromAfar(const ProceduralVolume& procedural, int n_texels) : texels(n_texels) {
    volume = placed(square(1), make_volume(procedural, n_texels),
                    k_period * procedural.extent.z() / procedural.extent.x(),
                    {16, 16 * procedural.extent.x() / procedural.extent.y()});
    volume.color = Rgb::Ones();
  }
  Image picture_at(double level) {
    volume.view = VolumeView{{0, 0, 1000}, k_period / texels * std::exp2(level) / 1000};
    return picture_with(volume);
  }
  Image picture_with(const PlacedVolume& shown) const {
    // Four periods wide.
    const Camera camera{.position = {0, -7, 7},
                        .target = Vec3::Zero(),
                        .up = Vec3::UnitZ(),
                        .field_of_view = 2 * std::atan(2 * k_period / std::hypot(7, 7)),
                        .width = 24,
                        .height = 24};
    RenderOptions options{.samples_per_pixel = 16, .background = Rgb::Zero()};
    options.transport = LightTransport::direct;
    options.lighting = {.ambient = 1};
    return render(Scene({}, std::span<const PlacedVolume>(&shown, 1)), camera, options);
  }

  static constexpr double k_period = 2.0 / 16;
  int texels;
  PlacedVolume volume;
};

// Surfaces fade into matter without a step.
TEST(ShellVolume, OpacityIsSmoothFromSurfacesToMatter) {
  SheetFromAfar sheet(chain_mail(), 32);
  const double finest = static_cast<double>(mean_of(sheet.picture_at(-3)).x());
  const int first = sheet.volume.textured.texture->first_transparent();
  double before = finest;
  // Of 9216 samples the standard error is 0.0035 of these; measured are steps of 0.0071 and 0.0204 in all at
  // most.
  for (int quarter = -4; quarter <= 4; ++quarter) {
    const double share = static_cast<double>(mean_of(sheet.picture_at(first + quarter / 4.0)).x());
    EXPECT_NEAR(share / before, 1, 0.012) << quarter;
    EXPECT_NEAR(share / finest, 1, 0.025) << quarter;
    before = share;
  }
}

// Before the transition there is no matter, and behind it there are no surfaces.
TEST(ShellVolume, LevelsAreSeenInTheirRangeOnly) {
  SheetFromAfar sheet(chain_mail(), 32);
  const std::shared_ptr<const VolumeMipmap> whole = sheet.volume.textured.texture;
  const int first = whole->first_transparent();
  VolumeMipmap opaque = *whole, hollow = *whole;
  for (TransparentVolume& matter : opaque.transparent) matter.opacity = {matter.size, {255, 255, 255}};
  for (VolumeTexture& surface : hollow.surfaces) surface.opacity = {surface.size, 0};
  const auto changes = [&](const VolumeMipmap& other, double level) {
    sheet.volume.textured.texture = whole;
    const Image image = sheet.picture_at(level);
    sheet.volume.textured.texture = std::make_shared<const VolumeMipmap>(other);
    const bool is_other = sheet.picture_at(level).pixels != image.pixels;
    sheet.volume.textured.texture = whole;
    return is_other;
  };
  // Texels of the sheet aren't quite squares, so that levels are off by a little.
  constexpr double k_little = 0.1;
  EXPECT_FALSE(changes(opaque, first - 1 - k_little));
  EXPECT_TRUE(changes(opaque, first - 0.5));
  EXPECT_TRUE(changes(hollow, first - 0.5));
  EXPECT_FALSE(changes(hollow, first + k_little));
}

TEST(ShellVolume, IsTheSameForAnyNumberOfThreadsAndRefusesWhatIsMissing) {
  PlacedVolume volume = placed(square(2), make_volume(weave(), 16), 0.2, {4, 4});
  const Camera camera{.position = {0, -3, 2}, .target = Vec3::Zero(), .width = 40, .height = 40};
  volume.view = VolumeView{{0, 0, 1000}, 1e-4};
  const Image image = picture(volume, camera, 4);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(picture(volume, camera, 4).pixels, image.pixels);
  }
  volume.textured.side = ShellSide::interior;
  EXPECT_THROW(picture(volume, camera, 1), InputError);
  volume.textured.side = ShellSide::exterior;
  Shell bare = *volume.textured.shell;
  bare.base.corner_uvs.clear();
  volume.textured.shell = std::make_shared<const Shell>(bare);
  EXPECT_THROW(picture(volume, camera, 1), InputError);
}

// Levels that a view doesn't need change nothing of its picture.
TEST(ShellVolume, IsDrawnAlikeWithTheLevelsOfTheView) {
  const PlacedVolume all = placed(square(4), make_volume(chain_mail(), 16), 0.2, {4, 2});
  std::vector<std::size_t> n_levels;
  for (const double distance : {1.5, 12.0, 100.0}) {
    const Camera camera{
        .position = {0.2, -0.6 * distance, 0.8 * distance}, .target = {0, 0, 0}, .width = 40, .height = 40};
    PlacedVolume whole = all, needed = all;
    whole.view = needed.view = volume_view(camera);
    needed.textured.texture = finest_only(all.textured.texture->surfaces.front());
    needed.textured = with_levels_for(needed.textured, *needed.view);
    EXPECT_EQ(picture(whole, camera, 4).pixels, picture(needed, camera, 4).pixels) << distance;
    n_levels.push_back(needed.textured.texture->surfaces.size() +
                       needed.textured.texture->transparent.size());
  }
  EXPECT_LT(n_levels.front(), n_levels.back());
  EXPECT_LT(n_levels.front(),
            all.textured.texture->surfaces.size() + all.textured.texture->transparent.size());
}

}  // namespace
