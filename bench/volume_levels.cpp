// Volume textures from afar: what is left of their opacity and brightness.
#include "shell_volumes.h"
#include <recede/render/renderer.h>
#include <recede/shells/procedural_volumes.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::bench {
namespace {

constexpr double k_degree = std::numbers::pi / 180;
constexpr int k_texels = 64;  // of a period

/// Two layers of wires across each other.
ProceduralVolume wire_mesh() {
  constexpr double k_wire = 0.055, k_pitch = 0.5, k_apart = 0.05;
  return {[](const Vec3& point) {
            const double x = std::remainder(point.x() - k_pitch / 2, k_pitch),
                         y = std::remainder(point.y() - k_pitch / 2, k_pitch), z = point.z() - 0.125;
            return k_wire - std::min(std::hypot(x, z - k_apart), std::hypot(y, z + k_apart));
          },
          Vec3(1, 1, 0.25)};
}

constexpr double k_all = 1e9;

/// Of a sheet of 128 periods across.
struct Sheet {
  static constexpr double k_period = 2.0 / 128;
  Vec3 extent;

  PlacedVolume place(std::shared_ptr<const VolumeMipmap> texture) const {
    return place_volume(flat_square(), std::move(texture), k_period * extent.z() / extent.x(),
                        {128, std::round(128 * extent.x() / extent.y())});
  }
  /// From `elevation` on, so far away that pixels are as wide as `texels` texels.
  Camera camera(double elevation, int side, double texels) const {
    const double field = 0.02, distance = texels * k_period / k_texels / (2 * std::tan(field / 2) / side);
    return {.position = distance * Vec3(0, -std::cos(elevation), std::sin(elevation)),
            .target = Vec3::Zero(),
            .up = Vec3(0, std::sin(elevation), std::cos(elevation)),
            .field_of_view = field,
            .width = side,
            .height = side};
  }
};

constexpr int k_side = 128, k_block = 8;

/// Share of the rays that are stopped, in blocks of 8 x 8 pixels.
std::vector<double> block_coverage(const PlacedVolume& placed, const Camera& camera, int samples) {
  const Scene scene({}, std::span<const PlacedVolume>(&placed, 1));
  const std::vector<SeenVolume> seen = trace_volumes(scene, camera, samples);
  constexpr int k_across = k_side / k_block;
  std::vector<double> blocks(k_across * k_across);
  const std::size_t of_pixel = seen.size() / (k_side * k_side);
  for (std::size_t s = 0; s < seen.size(); ++s) {
    const std::size_t pixel = s / of_pixel, x = pixel % k_side, y = pixel / k_side;
    if (seen[s].is_hit) blocks[y / k_block * k_across + x / k_block] += 1;
  }
  for (double& block : blocks) block /= static_cast<double>(of_pixel * k_block * k_block);
  return blocks;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double difference_of(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

/// What is seen of a sheet with pixels of some size, by kinds of levels.
class SheetLevels {
 public:
  explicit SheetLevels(const ProceduralVolume& procedural)
      : sheet_{procedural.extent}, texture_(make_volume(procedural, k_texels)) {
    all_surfaces_ = std::make_shared<const VolumeMipmap>(
        make_mipmap(texture_, {.least_share = 0, .seen_tolerance = k_all}));
    both_ = std::make_shared<const VolumeMipmap>(make_mipmap(texture_));
  }

  int first_transparent() const { return both_->first_transparent(); }

  /// Shares of blocks: of the finest level with 16 samples a pixel and with one, of levels as surfaces, and
  /// of surfaces and then matter.
  std::array<std::vector<double>, 4> coverage(double texels_to_a_pixel) const {
    const Camera camera = sheet_.camera(45 * k_degree, k_side, texels_to_a_pixel);
    PlacedVolume finest = sheet_.place(both_), surfaces = sheet_.place(all_surfaces_), doubled = finest;
    surfaces.view = volume_view(camera);
    doubled.view = surfaces.view;
    return {block_coverage(finest, camera, 4), block_coverage(finest, camera, 1),
            block_coverage(surfaces, camera, 1), block_coverage(doubled, camera, 1)};
  }

 private:
  Sheet sheet_;
  VolumeTexture texture_;
  std::shared_ptr<const VolumeMipmap> all_surfaces_, both_;
};

void add_receding_sheet(const std::string& name, const ProceduralVolume& procedural, BenchSection& section) {
  const SheetLevels levels(procedural);
  // Behind them is a texel alone, which is matter in any case.
  for (int level = -1; level <= 5; ++level) {
    const auto [reference, one, linear, matter] = levels.coverage(std::exp2(level));
    const double share = mean_of(reference), chance = std::sqrt(share * (1 - share)) / k_block;
    section.markdown += fmt::format(
        "| {} | {} | {:.3f} | {:.3f} ; {:.3f} | {:.3f} ; {:.3f} | {:.3f} ; {:.3f} | {:.3f} |\n", name,
        std::exp2(level), share, mean_of(one), difference_of(one, reference), mean_of(linear),
        difference_of(linear, reference), mean_of(matter), difference_of(matter, reference), chance);
    section.rows.push_back({{"experiment", "receding sheet"},
                            {"texture", name},
                            {"texels_to_a_pixel", std::exp2(level)},
                            {"first_transparent", levels.first_transparent()},
                            {"reference", share},
                            {"one_sample", mean_of(one)},
                            {"one_sample_blocks", difference_of(one, reference)},
                            {"surfaces", mean_of(linear)},
                            {"surfaces_blocks", difference_of(linear, reference)},
                            {"double", mean_of(matter)},
                            {"double_blocks", difference_of(matter, reference)},
                            {"chance", chance}});
  }
}

}  // namespace

void measure_receding_sheets(BenchSection& section) {
  section.markdown +=
      "\n### Sheets that recede\n\nFrom 45 degrees, 64 texels a period. Share of the rays that are stopped, "
      "mean and root mean square of how far blocks of 8 x 8 pixels are off: reference of 16 samples a pixel, "
      "and with a sample a pixel no levels, all levels as surfaces (linear), levels as surfaces and then "
      "matter (double); last what 64 independent samples are off by\n\n| sheet | texels a pixel | reference "
      "| none | linear | double | chance |\n|---|---|---|---|---|---|---|\n";
  add_receding_sheet("wire mesh", wire_mesh(), section);
  add_receding_sheet("chain mail", chain_mail(), section);
}

namespace {

/// Sheets that get 1.5 times as far away over some frames: how much blocks of pixels jump, beside the mean of
/// the frames before and after.
void add_flicker(const std::string& name, const ProceduralVolume& procedural, BenchSection& section) {
  const SheetLevels levels(procedural);
  constexpr int k_frames = 25;
  for (const double nearest : {1.0, 4.0, 12.0}) {
    std::array<std::vector<std::vector<double>>, 4> blocks;
    for (int frame = 0; frame < k_frames; ++frame) {
      auto seen = levels.coverage(nearest * std::pow(1.5, static_cast<double>(frame) / k_frames));
      for (std::size_t by = 0; by < seen.size(); ++by) blocks[by].push_back(std::move(seen[by]));
    }
    std::array<double, 4> flicker{};
    for (std::size_t by = 0; by < 4; ++by) {
      double sum = 0;
      for (std::size_t frame = 1; frame + 1 < k_frames; ++frame) {
        std::vector<double> between = blocks[by][frame - 1];
        for (std::size_t b = 0; b < between.size(); ++b)
          between[b] = (between[b] + blocks[by][frame + 1][b]) / 2;
        const double jump = difference_of(blocks[by][frame], between);
        sum += jump * jump;
      }
      flicker[by] = std::sqrt(sum / (k_frames - 2));
    }
    section.markdown += fmt::format("| {} | {} to {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} |\n", name, nearest,
                                    1.5 * nearest, flicker[0], flicker[1], flicker[2], flicker[3]);
    section.rows.push_back({{"experiment", "flicker"},
                            {"texture", name},
                            {"texels_to_a_pixel", nearest},
                            {"reference", flicker[0]},
                            {"one_sample", flicker[1]},
                            {"surfaces", flicker[2]},
                            {"double", flicker[3]}});
  }
}

}  // namespace

void measure_flicker(BenchSection& section) {
  section.markdown +=
      "\n### Flicker of sheets that recede\n\nThe same sheets over 25 frames, in which they get 1.5 times as "
      "far away: root mean square of how far the share of stopped rays in a block of 8 x 8 pixels is off the "
      "mean of the frames before and after\n\n| sheet | texels a pixel | 16 samples | none | linear | double "
      "|\n|---|---|---|---|---|---|\n";
  add_flicker("wire mesh", wire_mesh(), section);
  add_flicker("chain mail", chain_mail(), section);
}

namespace {

ProceduralVolume ground(double bumps) {
  return {[bumps](const Vec3& point) {
            const double waves =
                std::sin(6 * std::numbers::pi * point.x()) * std::sin(6 * std::numbers::pi * point.y());
            // Nearer where it is steep.
            return (0.2 + bumps * waves - point.z()) / (1 + 13 * bumps);
          },
          Vec3(1, 1, 0.5)};
}

ProceduralVolume without_colors(ProceduralVolume volume) {
  volume.color = nullptr;
  return volume;
}

struct Brightness {
  double finest, one_normal, ellipsoid, drawn;
};

const Vec3 k_beside_the_camera = Vec3(1, 0, 1).normalized();  // in the camera's frame

constexpr std::array<std::pair<const char*, double>, 3> k_grounds{
    {{"smooth", 0}, {"rough, slopes up to 0.75", 0.04}, {"rougher, slopes up to 1.9", 0.1}}};

/// Share of a picture's rays that are stopped, and the mean radiance of those.
struct Seen {
  double share = 0, brightness = 0;
};

/// Of white matter under a lamp, in the camera's frame, without shadows.
Seen look_at(PlacedVolume placed, const Camera& camera, const Vec3& toward_lamp) {
  constexpr int k_samples = 8;
  placed.color = Rgb::Ones();
  const Scene scene({}, std::span<const PlacedVolume>(&placed, 1));
  double hits = 0, light = 0;
  const std::vector<SeenVolume> seen = trace_volumes(scene, camera, k_samples);
  for (const SeenVolume& sample : seen) hits += sample.is_hit ? 1 : 0;
  const Image image = render(scene, camera,
                             {.samples_per_pixel = k_samples * k_samples,
                              .background = Rgb::Zero(),
                              .camera_light = {toward_lamp, Rgb::Ones(), Rgb::Zero(), Rgb::Zero()}});
  for (const Rgb& pixel : image.pixels) light += static_cast<double>(pixel.x());
  const double share = hits / static_cast<double>(seen.size());
  return {share, light / static_cast<double>(image.pixels.size()) / share};
}

Brightness brightness_of(const VolumeTexture& texture, const std::shared_ptr<const VolumeMipmap>& mipmap,
                         double elevation) {
  const Vec3& toward_lamp = k_beside_the_camera;
  // 8 periods across.
  const Camera camera = Sheet{texture.extent}.camera(elevation, 32, 16);
  const CameraFrame frame = frame_of(camera);
  const Vec3 light = (toward_lamp.x() * frame.right - toward_lamp.z() * frame.forward).normalized();
  PlacedVolume placed = Sheet{texture.extent}.place(mipmap);
  const double finest = look_at(placed, camera, toward_lamp).brightness;
  placed.view = VolumeView{frame.position, 1};  // pixels are larger than any texel
  const double drawn = look_at(placed, camera, toward_lamp).brightness;
  Vec3 gradients = Vec3::Zero();
  for (int k = 0; k < texture.size[2]; ++k)
    for (int j = 0; j < texture.size[1]; ++j)
      for (int i = 0; i < texture.size[0]; ++i)
        gradients -= opacity_gradient(texture, texture.middle(i, j, k)).cwiseQuotient(texture.extent);
  const Vec3 mean =
      mean_normal_along(normal_matrix(mipmap->transparent.back().normals.at(0, 0, 0)), frame.forward);
  // Closed bodies' normals cancel out: what is left is rounding.
  const bool is_any = gradients.norm() > 1e-3 * static_cast<double>(texture.n_texels());
  return {finest, is_any ? std::max(0.0, gradients.normalized().dot(light)) : -1,
          std::max(0.0, mean.dot(light)), drawn};
}

/// Radius 1, of quads between meridians and circles, with texture coordinates once around.
PolygonSoup ball_of_quads() {
  constexpr int k_rings = 32, k_around = 64;
  PolygonSoup ball;
  const auto at = [](int i, int j) {
    const double down = std::numbers::pi * j / k_rings,
                 around = 2 * std::numbers::pi * (i % k_around) / k_around;
    const double out = j == 0 || j == k_rings ? 0 : std::sin(down);
    return Vec3(out * std::cos(around), out * std::sin(around), std::cos(down));
  };
  for (int j = 0; j <= k_rings; ++j)
    for (int i = 0; i < k_around; ++i) ball.positions.push_back(at(i, j));
  for (int j = 0; j < k_rings; ++j) {
    for (int i = 0; i < k_around; ++i) {
      const std::array<std::array<int, 2>, 4> corners{{{i, j}, {i, j + 1}, {i + 1, j + 1}, {i + 1, j}}};
      std::vector<Index> face;
      for (const auto& [u, v] : corners) {
        if (!face.empty() && (j == 0 ? v == 0 : v == k_rings && u == i + 1)) continue;  // once at a pole
        const bool is_pole = v == 0 || v == k_rings;
        face.push_back(static_cast<Index>(v * k_around + (is_pole ? 0 : u % k_around)));
        ball.corner_uvs.emplace_back(static_cast<double>(u) / k_around, 1 - static_cast<double>(v) / k_rings);
      }
      ball.add_face(face);
    }
  }
  return ball;
}

void add_rough_balls(BenchSection& section) {
  section.markdown +=
      "\nThe same grounds around a ball of 64 x 32 periods, so far away that a pixel is as wide as a period: "
      "share of the picture's rays that are stopped, and brightness over what is seen\n\n| ball | finest: "
      "share ; brightness | level for the distance |\n|---|---|---|\n";
  const PolygonSoup base = ball_of_quads();
  constexpr double k_away = 400, k_seen = 1.1;
  const Camera camera{.position = {0, -k_away, 0},
                      .target = Vec3::Zero(),
                      .up = Vec3::UnitZ(),
                      .field_of_view = 2 * std::atan(k_seen / k_away),
                      .width = 64,
                      .height = 64};
  for (const auto& [name, bumps] : k_grounds) {
    const auto mipmap =
        std::make_shared<const VolumeMipmap>(make_mipmap(make_volume(ground(bumps), k_texels)));
    PlacedVolume placed = place_volume(base, mipmap, 0.05, {64, 32});
    const Seen finest = look_at(placed, camera, k_beside_the_camera);
    placed.view = volume_view(camera);
    const Seen level = look_at(placed, camera, k_beside_the_camera);
    section.markdown += fmt::format("| {} | {:.4f} ; {:.3f} | {:.4f} ; {:.3f} |\n", name, finest.share,
                                    finest.brightness, level.share, level.brightness);
    section.rows.push_back({{"experiment", "brightness of balls"},
                            {"ball", name},
                            {"finest_share", finest.share},
                            {"finest", finest.brightness},
                            {"level_share", level.share},
                            {"level", level.brightness}});
  }
}

}  // namespace

void measure_volume_brightness(BenchSection& section) {
  section.markdown +=
      "\n### Brightness of rough sheets\n\nMatt and white, a lamp 45 degrees beside the camera without "
      "shadows: drawn at the finest level; from a whole period's filtered normal, and from its ellipsoid of "
      "normals, as the source has them; drawn from the last level of matter\n\n| sheet | seen from | finest "
      "| one normal | ellipsoid | last level |\n|---|---|---|---|---|---|\n";
  std::vector<std::pair<std::string, ProceduralVolume>> sheets;
  for (const auto& [name, bumps] : k_grounds) sheets.emplace_back(name, ground(bumps));
  sheets.emplace_back("bark", without_colors(bark()));
  sheets.emplace_back("chain mail", chain_mail());
  for (const auto& [name, procedural] : sheets) {
    const VolumeTexture texture = make_volume(procedural, k_texels);
    const auto mipmap = std::make_shared<const VolumeMipmap>(make_mipmap(texture));
    for (const double elevation : {90.0, 45.0}) {
      const Brightness found = brightness_of(texture, mipmap, elevation * k_degree);
      section.markdown +=
          fmt::format("| {} | {} | {:.3f} | {} | {:.3f} | {:.3f} |\n", name, elevation, found.finest,
                      found.one_normal < 0 ? "none" : fmt::format("{:.3f}", found.one_normal),
                      found.ellipsoid, found.drawn);
      section.rows.push_back({{"experiment", "brightness"},
                              {"sheet", name},
                              {"elevation", elevation},
                              {"finest", found.finest},
                              {"one_normal", found.one_normal},
                              {"ellipsoid", found.ellipsoid},
                              {"last_level", found.drawn}});
    }
  }
  add_rough_balls(section);
}

namespace {

/// Share of the rays along an axis, through a whole period or the layer, that meet the surface.
double stopped_along(const VolumeTexture& texture, int axis) {
  constexpr int k_rays = 128;
  const int steps = 2 * texture.size[static_cast<std::size_t>(axis)];
  int stopped = 0;
  for (int ray = 0; ray < k_rays * k_rays; ++ray) {
    Vec3 place;
    place[(axis + 1) % 3] = (ray % k_rays + 0.5) / k_rays;
    place[(axis + 2) % 3] = (ray / k_rays + 0.5) / k_rays;
    for (int n = 0; n < steps; ++n) {
      place[axis] = (n + 0.5) / steps;
      if (opacity_at(texture, place) < 0.5) continue;
      ++stopped;
      break;
    }
  }
  return static_cast<double>(stopped) / (k_rays * k_rays);
}

/// The same of a level, from texel to texel.
double opacity_of_rows(const TransparentVolume& level, int axis, double correlation) {
  const auto along = static_cast<std::size_t>(axis), u = (along + 1) % 3, v = (along + 2) % 3;
  double sum = 0;
  std::array<int, 3> at{};
  for (at[u] = 0; at[u] < level.size[u]; ++at[u]) {
    for (at[v] = 0; at[v] < level.size[v]; ++at[v]) {
      double opacity = 0;
      for (at[along] = 0; at[along] < level.size[along]; ++at[along])
        opacity =
            opacity_in_row(opacity, level.opacity.at(at)[along] / 255.0, at[along] == 0 ? 0 : correlation);
      sum += opacity;
    }
  }
  return sum / (level.size[u] * level.size[v]);
}

}  // namespace

void measure_tubes(BenchSection& section) {
  section.markdown +=
      "\n### A bundle of tubes\n\nTubes along t, sixteen of diameter 0.16 in a period of 1 x 1 x 1, in four "
      "rows. Share of the rays along an axis that are stopped: at the finest level, and by rows of texels of "
      "a level one after the other, as if they were independent (C = 0) or with the level's correlation\n\n| "
      "along | finest level | texels in a row | C = 0 | estimated C | C |\n|---|---|---|---|---|---|\n";
  const VolumeTexture texture = make_volume(
      [](const Vec3& point) {
        const double x = std::remainder(point.x() - 0.125, 0.25), z = std::remainder(point.z() - 0.125, 0.25);
        return 0.08 - std::hypot(x, z);
      },
      {.size = {64, 64, 64}, .extent = Vec3::Ones()});
  const VolumeMipmap mipmap = make_mipmap(texture, {.least_share = 1, .seen_tolerance = 0});
  for (int axis = 0; axis < 3; ++axis) {
    const double exact = stopped_along(texture, axis);
    for (const TransparentVolume& level : mipmap.transparent) {
      const int n = level.size[static_cast<std::size_t>(axis)];
      if (n > 16 || n == 1) continue;
      const double correlation = level.correlation[axis];
      const double independent = opacity_of_rows(level, axis, 0),
                   estimated = opacity_of_rows(level, axis, correlation);
      section.markdown += fmt::format("| {} | {:.3f} | {} | {:.3f} | {:.3f} | {:.2f} |\n", "str"[axis], exact,
                                      n, independent, estimated, correlation);
      section.rows.push_back({{"experiment", "tubes"},
                              {"along", std::string(1, "str"[axis])},
                              {"finest", exact},
                              {"texels", n},
                              {"independent", independent},
                              {"estimated", estimated},
                              {"correlation", correlation}});
    }
  }
}

}  // namespace recede::bench
