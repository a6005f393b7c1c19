// Pictures of clouds beside those of their models: outlines, and light.
#include "billboard_models.h"
#include "billboard_run.h"
#include "hough_billboards.h"
#include <recede/render/renderer.h>
#include <recede/render/sphere_directions.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede::bench {
namespace {

constexpr double k_share = 0.01;  // of the longest side: the error

struct DrawnCloud {
  std::string name;
  std::size_t billboards = 0;
  double texels_per_error = 1;
  Scene scene;
};

std::vector<DrawnCloud> outlined_clouds(const BillboardModel& model) {
  std::vector<DrawnCloud> clouds;
  for (const TexturedCloud& cloud : textured_clouds(model, k_share)) {
    const std::size_t n = cloud.textures.billboards.size();
    clouds.push_back({cloud.construction, n, cloud.texels_per_error, scene_of(cloud.textures)});
    if (cloud.texels_per_error == 1) continue;
    clouds.push_back({fmt::format("{}, flat", cloud.construction), n, cloud.texels_per_error,
                      scene_of(flattened(cloud.textures))});
  }
  const BillboardCloud hough = hough_billboards(model.soup, k_share * model.size());
  clouds.push_back(
      {"Hough, flat", hough.billboards.size(), 1, scene_of(flattened(hough_textures(model, hough, 1)))});
  return clouds;
}

struct Outline {
  double overlap = 0;           // area in both over area in either, all pictures together
  double worst = 1;             // of a picture
  double holes = 0, extra = 0;  // shares of the model's area
};

// Pixels that something covers half and more of: black on white without light.
std::vector<bool> covered_pixels(const Scene& scene, const Camera& camera, int samples) {
  RenderOptions options;
  options.samples_per_pixel = samples;
  options.background = Rgb::Ones();
  options.camera_light.lamp = options.camera_light.sky = options.camera_light.ground = Rgb::Zero();
  std::vector<bool> covered;
  for (const Rgb& pixel : render(scene, camera, options).pixels) covered.push_back(pixel.x() <= 0.5f);
  return covered;
}

struct OutlinedView {
  Camera camera;
  std::vector<bool> covered;  // by the model
};

std::vector<OutlinedView> views_of(const BillboardModel& model, int n, double pixel, int samples) {
  const Scene scene(model.soup);
  std::vector<OutlinedView> views;
  for (const Vec3& direction : spread_directions(n).directions) {
    const Camera camera = camera_at_pixel(model, direction, pixel);
    views.push_back({camera, covered_pixels(scene, camera, samples)});
  }
  return views;
}

Outline outline_of(const Scene& scene, const std::vector<OutlinedView>& views, int samples) {
  Outline outline;
  double of_model = 0, of_both = 0, of_either = 0;
  for (const OutlinedView& view : views) {
    const std::vector<bool> covered = covered_pixels(scene, view.camera, samples);
    double both = 0, either = 0;
    for (std::size_t i = 0; i < covered.size(); ++i) {
      const bool in_model = view.covered[i], in_cloud = covered[i];
      of_model += in_model ? 1 : 0;
      outline.holes += in_model && !in_cloud ? 1 : 0;
      outline.extra += !in_model && in_cloud ? 1 : 0;
      both += in_model && in_cloud ? 1 : 0;
      either += in_model || in_cloud ? 1 : 0;
    }
    of_both += both;
    of_either += either;
    if (either > 0) outline.worst = std::min(outline.worst, both / either);
  }
  outline.overlap = of_both / std::max(1.0, of_either);
  outline.holes /= std::max(1.0, of_model);
  outline.extra /= std::max(1.0, of_model);
  return outline;
}

nlohmann::json json_of(const Outline& outline) {
  return {{"overlap", outline.overlap},
          {"worst_overlap", outline.worst},
          {"holes", outline.holes},
          {"extra", outline.extra}};
}

std::string text_of(const Outline& outline) {
  return fmt::format("{:.3f} ; {:.2f} ; {:.2f}", outline.overlap, 100 * outline.holes, 100 * outline.extra);
}

// Sums over pictures of sRGB values.
struct Squares {
  double whole = 0, inside = 0;
  double n_whole = 0, n_inside = 0;

  void add(const Image& image, const Image& reference, const Rgb& background) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const bool is_inside = reference.pixels[i] != background;
      for (int k = 0; k < 3; ++k) {
        const auto step = static_cast<double>(encode_srgb(image.pixels[i][k])) -
                          static_cast<double>(encode_srgb(reference.pixels[i][k]));
        whole += step * step;
        if (is_inside) inside += step * step;
      }
      n_whole += 3;
      n_inside += is_inside ? 3 : 0;
    }
  }
  double whole_decibels() const { return -10 * std::log10(whole / n_whole); }
  double inside_decibels() const { return -10 * std::log10(inside / n_inside); }
};

std::vector<DrawnCloud> lit_clouds(const BillboardModel& model) {
  std::vector<DrawnCloud> clouds;
  for (const TexturedCloud& cloud : textured_clouds(model, k_share)) {
    clouds.push_back({cloud.construction, cloud.textures.billboards.size(), cloud.texels_per_error,
                      scene_of(cloud.textures)});
  }
  return clouds;
}

}  // namespace

BenchSection measure_outlines(const BenchOptions& options) {
  constexpr int k_views = 100, k_samples = 4, k_near_views = 20, k_near_samples = 1, k_near_size = 384;
  BenchSection section;
  section.markdown =
      "## Outlines\n\nAt 1 % of the longest side: overlap ; holes, % ; extra, %. From afar: 100 views, a "
      "pixel "
      "is "
      "the error. Near by: 20 views of 384 x 384 pixels that the model fills\n\n| model | | billboards | "
      "texels "
      "per "
      "error | from afar | its worst overlap | near by |\n|---|---|---|---|---|---|---|\n";
  for (const BillboardModel& model : billboard_models(options)) {
    const std::vector<OutlinedView> far = views_of(model, k_views, k_share * model.size(), k_samples);
    const std::vector<OutlinedView> near =
        views_of(model, k_near_views, model.diagonal() / k_near_size, k_near_samples);
    for (const DrawnCloud& cloud : outlined_clouds(model)) {
      const Outline from_afar = outline_of(cloud.scene, far, k_samples),
                    near_by = outline_of(cloud.scene, near, k_near_samples);
      section.markdown += fmt::format("| {} | {} | {} | {:g} | {} | {:.3f} | {} |\n", model.name, cloud.name,
                                      cloud.billboards, cloud.texels_per_error, text_of(from_afar),
                                      from_afar.worst, text_of(near_by));
      section.rows.push_back({{"model", model.name},
                              {"cloud", cloud.name},
                              {"billboards", cloud.billboards},
                              {"texels_per_error", cloud.texels_per_error},
                              {"from_afar", json_of(from_afar)},
                              {"near_by", json_of(near_by)}});
    }
    fmt::print(stderr, "{} is outlined\n", model.name);
  }
  return section;
}

BenchSection measure_relit(const BenchOptions& options) {
  constexpr int k_views = 64, k_lights = 8;
  BenchSection section;
  section.markdown =
      "## Light\n\n64 views, each under 8 directional lights with shadows, a pixel is the error of 1 %: PSNR "
      "of all pixels, and of those that the model is in\n\n| model | | texels per error | whole picture, dB "
      "| "
      "the model's pixels, dB |\n|---|---|---|---|---|\n";
  for (const BillboardModel& model : billboard_models(options)) {
    const Scene original(model.soup);
    const std::vector<DrawnCloud> clouds = lit_clouds(model);
    std::vector<Squares> squares(clouds.size());
    RenderOptions drawn{.samples_per_pixel = 4, .transport = LightTransport::direct};
    for (const Vec3& direction : spread_directions(k_views).directions) {
      const Camera camera = camera_at_pixel(model, direction, k_share * model.size());
      for (const Vec3& toward : spread_directions(k_lights).directions) {
        drawn.lighting.directionals = {{.toward = toward}};
        const Image reference = render(original, camera, drawn);
        for (std::size_t i = 0; i < clouds.size(); ++i)
          squares[i].add(render(clouds[i].scene, camera, drawn), reference, drawn.background);
      }
    }
    for (std::size_t i = 0; i < clouds.size(); ++i) {
      section.markdown +=
          fmt::format("| {} | {} | {:g} | {:.1f} | {:.1f} |\n", model.name, clouds[i].name,
                      clouds[i].texels_per_error, squares[i].whole_decibels(), squares[i].inside_decibels());
      section.rows.push_back({{"model", model.name},
                              {"cloud", clouds[i].name},
                              {"texels_per_error", clouds[i].texels_per_error},
                              {"psnr_of_pictures", squares[i].whole_decibels()},
                              {"psnr_of_the_model", squares[i].inside_decibels()}});
    }
    fmt::print(stderr, "{} is lit\n", model.name);
  }
  return section;
}

}  // namespace recede::bench
