#include "appearance_run.h"
#include "measurement.h"
#include "plot_sheet.h"
#include "transition_scene.h"
#include <recede/render/image_difference.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede::bench {
namespace {

constexpr int k_samples = DrawnBy{}.samples, k_reference_samples = 256;

std::string csv_line(std::string_view surface, std::string_view method, std::string_view figure,
                     double value) {
  return fmt::format("transitions,{},{},{},{:.6g}\n", surface, method, figure, value);
}

Image reference_of(const TransitionScene& scene, const Camera& camera) {
  return draw(scene.scene, camera,
              {.representation = Representation::displacement, .samples = k_reference_samples});
}

struct NamedView {
  const char* name;
  Camera camera;
};

/// The object fills the pictures, so that times are not those of the background.
std::vector<NamedView> views_of(const TransitionScene& scene) {
  return {{"1", camera_at(scene, 1, 320)},
          {"4", camera_at(scene, 4, 96)},
          {"0.3 to 2 along the surface", camera_along(scene, 2, 320)}};
}

/// The dissertation's table 8.1: seconds for a picture by each method, from three places.
std::string method_table(const TransitionScene& scene, const TransitionScene& plain, std::size_t repeats,
                         std::string& csv) {
  struct Method {
    const char* name;
    const Scene& scene;
    DrawnBy by;
  };
  const Method methods[] = {
      {"base alone", scene.bare, {}},
      {"table (`brdf`)", scene.scene, {.representation = Representation::brdf}},
      {"bump map as it is", plain.scene, {.representation = Representation::bump}},
      {"redistributed bump map", scene.scene, {.representation = Representation::bump}},
      {"displacement everywhere", scene.scene, {.representation = Representation::displacement}},
      {"**transitions** (`auto`)", scene.scene, {.representation = Representation::automatic}}};
  const std::vector<NamedView> views = views_of(scene);
  std::string head = "| seconds ; RMSE |", line = "|---|";
  std::vector<Image> references;
  for (const NamedView& view : views) {
    head += fmt::format(" {} |", view.name);
    line += "---|";
    references.push_back(reference_of(scene, view.camera));
  }
  std::string rows;
  std::vector<double> displaced(views.size()), automatic(views.size());
  for (const Method& method : methods) {
    rows += fmt::format("| {} |", method.name);
    for (std::size_t v = 0; v < views.size(); ++v) {
      Image image;
      const double seconds =
          median_wall_seconds(repeats, [&] { image = draw(method.scene, views[v].camera, method.by); });
      if (method.by.representation == Representation::displacement) displaced[v] = seconds;
      if (method.by.representation == Representation::automatic) automatic[v] = seconds;
      const double error = compare_images(image, references[v]).rmse;
      rows += fmt::format(" {:.4f} ; {:.4f} |", seconds, error);
      csv += csv_line(views[v].name, method.name, "seconds", seconds) +
             csv_line(views[v].name, method.name, "RMSE", error);
    }
    rows += "\n";
  }
  rows += "| displacement over transitions |";
  for (std::size_t v = 0; v < views.size(); ++v)
    rows += fmt::format(" {:.2f} |", displaced[v] / automatic[v]);
  return head + "\n" + line + "\n" + rows + "\n";
}

/// Figure 8.3: moving away.
std::string distance_table(const TransitionScene& scene, std::size_t repeats, std::string& csv) {
  constexpr int k_size = 320;
  std::string rows;
  for (const double distance : {0.3, 0.5, 0.65, 0.75, 0.9, 1.0, 1.2, 1.6, 2.2, 4.0, 10.0}) {
    // From far away the object is small, and so is the picture.
    const Camera camera =
        camera_at(scene, distance, static_cast<int>(k_size / std::max(1.0, distance / 1.2)));
    const Image reference = reference_of(scene, camera);
    const auto measured = [&](Representation representation) {
      Image image;
      const double seconds = median_wall_seconds(
          repeats, [&] { image = draw(scene.scene, camera, {.representation = representation}); });
      return std::pair(seconds, compare_images(image, reference).rmse);
    };
    const auto [automatic, error] = measured(Representation::automatic);
    const auto [displaced, displaced_error] = measured(Representation::displacement);
    const std::string at = fmt::format("{}", distance);
    csv += csv_line(at, "transitions", "seconds", automatic) +
           csv_line(at, "displacement", "seconds", displaced) + csv_line(at, "transitions", "RMSE", error) +
           csv_line(at, "displacement", "RMSE", displaced_error);
    const PictureShares shares = count_methods(scene.scene, camera);
    const double all = 1 - shares.background;
    const auto percent = [&](RenderingMethod method) { return 100 * shares.of(method) / all; };
    rows += fmt::format(
        "| {} | {:.3f} | {:.3f} | {:.2f} | {:.4f} | {:.4f} | {:.0f} ; {:.0f} ; {:.0f} ; {:.0f} ; {:.0f} |\n",
        distance, automatic, displaced, displaced / automatic, error, displaced_error,
        percent(RenderingMethod::displacement), percent(RenderingMethod::bump_to_displacement),
        percent(RenderingMethod::bump), percent(RenderingMethod::brdf_to_bump),
        percent(RenderingMethod::brdf));
  }
  return "| distance | seconds | displacement everywhere | ratio | RMSE | displacement's | displacement ; "
         "growing "
         "; bump ; blended ; table, % |\n|---|---|---|---|---|---|---|\n" +
         rows;
}

/// Figure 8.4: the same view with methods that change elsewhere.
std::string threshold_table(const TransitionScene& scene, std::size_t repeats) {
  const Camera camera = camera_along(scene, 2, 320);
  const double two_pixels = scene.two_pixels(camera);
  std::string rows;
  for (const double share : {0.1, 0.3, 0.5, 1.0, 2.0, 4.0, 100.0}) {
    const DrawnBy by{.transition = transition_around(share * two_pixels)};
    const double seconds = median_wall_seconds(repeats, [&] { draw(scene.scene, camera, by); });
    const PictureShares shares = count_methods(scene.scene, camera, {.transition = by.transition});
    const double all = 1 - shares.background;
    rows += fmt::format(
        "| {} | {:.4f} | {:.0f} | {:.0f} | {:.0f} |\n", share, seconds,
        100 * (shares.of(RenderingMethod::displacement) + shares.of(RenderingMethod::bump_to_displacement)) /
            all,
        100 * shares.of(RenderingMethod::bump) / all,
        100 * (shares.of(RenderingMethod::brdf) + shares.of(RenderingMethod::brdf_to_bump)) / all);
  }
  return "| `--transition-distance`, in units of the automatic one | seconds | displaced or growing, % | "
         "bump, % | table, "
         "pure or blended, % |\n|---|---|---|---|---|\n" +
         rows;
}

/// With shadows, and with light that surfaces pass on: the mean of a flat plane of waves by each method over
/// that of displacement, by paths.
std::string light_table(const TransitionScene& scene, std::string& csv) {
  const Scene plane = scene.plane();
  std::string rows;
  for (const bool paths : {false, true}) {
    for (const double light : {20.0, 45.0, 70.0}) {
      for (const double view : {20.0, 50.0, 75.0}) {
        const auto mean = [&](Representation representation, std::optional<double> grown) {
          return plane_brightness(plane, {.representation = representation,
                                          .view = view,
                                          .light = light,
                                          .paths = paths,
                                          .grown = grown});
        };
        const double reference = mean(Representation::displacement, {});
        const double table = mean(Representation::brdf, {}) / reference;
        const double bump = mean(Representation::bump, {}) / reference;
        const double half = mean(Representation::automatic, 0.5) / reference;
        rows += fmt::format("| {} | {} | {} | {:+.2f} | {:+.2f} | {:+.2f} |\n",
                            paths ? "paths" : "direct, shadows", light, view, 100 * (table - 1),
                            100 * (bump - 1), 100 * (half - 1));
        const std::string at = fmt::format("light {} view {}{}", light, view, paths ? " paths" : "");
        csv += csv_line(at, "table", "brightness", table) + csv_line(at, "bump", "brightness", bump) +
               csv_line(at, "half displaced", "brightness", half);
      }
    }
  }
  return "| light | angle of the light | of the view | table, % off | bump map, % off | half displaced, % "
         "off "
         "|\n|---|---|---|---|---|---|\n" +
         rows;
}

double light_of(const Image& image) {
  double sum = 0;
  for (const Rgb& pixel : image.pixels) sum += static_cast<double>(pixel.sum());
  return sum;
}

/// Light of the whole object over a way through all methods, relative to displacement, frame by frame.
std::string way_table(const TransitionScene& scene, const TransitionScene& plain, std::string& csv) {
  constexpr int k_frames = 48, k_way_size = 200;
  constexpr double k_from = 0.45, k_to = 2.6, k_unit = 8;
  struct Way {
    const char* name;
    std::vector<double> ratios;
  };
  Way ways[] = {
      {"**transitions**", {}}, {"bump maps as they are", {}}, {"hard changes at the middle distances", {}}};
  for (int frame = 0; frame < k_frames; ++frame) {
    const double distance = k_from * std::pow(k_to / k_from, static_cast<double>(frame) / (k_frames - 1));
    Camera camera = camera_at(scene, 3 / k_unit, k_way_size);  // two pixels cover a wave at k_unit
    camera.position = camera.target + distance * k_unit * (camera.position - camera.target).normalized();
    const double reference =
        light_of(draw(scene.scene, camera, {.representation = Representation::displacement, .samples = 16}));
    const auto ratio = [&](const TransitionScene& drawn, Representation representation) {
      return light_of(draw(drawn.scene, camera, {.representation = representation, .samples = 16})) /
             reference;
    };
    ways[0].ratios.push_back(ratio(scene, Representation::automatic));
    ways[1].ratios.push_back(ratio(plain, Representation::automatic));
    const Representation hard = distance < 0.75  ? Representation::displacement
                                : distance < 1.5 ? Representation::bump
                                                 : Representation::brdf;
    ways[2].ratios.push_back(ratio(plain, hard));
  }
  std::string rows;
  for (const Way& way : ways) {
    double step = 0, off = 0;
    for (std::size_t i = 0; i < way.ratios.size(); ++i) {
      if (i > 0) step = std::max(step, std::abs(way.ratios[i] - way.ratios[i - 1]));
      off = std::max(off, std::abs(way.ratios[i] - 1));
    }
    rows += fmt::format("| {} | {:.2f} | {:.2f} |\n", way.name, 100 * step, 100 * off);
    csv += csv_line("way", way.name, "largest step", step) + csv_line("way", way.name, "farthest off", off);
  }
  return "| | largest step between frames, % | farthest from displacement, % |\n|---|---|---|\n" + rows;
}

/// Pixels of the object that have nothing but the object around them.
ImageMask inside_of(const Image& image) {
  ImageMask mask{image.width, image.height, {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      bool counts = true;
      for (int k = 0; k < 9; ++k) {
        const int i = std::clamp(x + k % 3 - 1, 0, image.width - 1);
        const int j = std::clamp(y + k / 3 - 1, 0, image.height - 1);
        counts = counts && image.at(i, j).x() > 0.1f;  // the background is black
      }
      mask.inside.push_back(counts ? 1 : 0);
    }
  }
  return mask;
}

/// From so far that waves are smaller than pixels: how pixels flicker while the camera creeps on, and how far
/// one sample is from a picture of many.
std::string noise_table(const TransitionScene& scene, std::string& csv) {
  constexpr int k_frames = 16, k_noise_size = 160;
  std::string rows;
  for (const double distance : {1.6, 2.5, 4.0}) {
    const auto camera_of = [&](int frame) {
      Camera camera = camera_at(scene, distance, k_noise_size);
      camera.position += 0.002 * frame * Vec3(1, 0.3, -0.2);
      return camera;
    };
    const Image reference = reference_of(scene, camera_of(0));
    const ImageMask inside_of_it = inside_of(reference);
    for (const auto& [name, by] :
         {std::pair("displacement, 1 sample", DrawnBy{Representation::displacement, 1}),
          std::pair("displacement, 4 samples", DrawnBy{Representation::displacement, 4}),
          std::pair("displacement, 16 samples", DrawnBy{Representation::displacement, 16}),
          std::pair("**transitions, 1 sample**", DrawnBy{Representation::automatic, 1})}) {
      const std::size_t pixels = reference.pixels.size();
      std::vector<double> sums(pixels), squares(pixels);
      std::vector<bool> always_seen(pixels, true);
      double error = 0, inner_error = 0;
      for (int frame = 0; frame < k_frames; ++frame) {
        const Image image = draw(scene.scene, camera_of(frame), by);
        if (frame == 0) {
          error = compare_images(image, reference).rmse;
          inner_error = compare_images(image, reference, inside_of_it).rmse;
        }
        for (std::size_t i = 0; i < pixels; ++i) {
          const auto value = static_cast<double>(image.pixels[i].x());
          sums[i] += value;
          squares[i] += value * value;
          if (value == 0) always_seen[i] = false;
        }
      }
      // Borders of the object come and go with any method: only pixels among others that are always seen
      // count.
      double variance = 0, inside = 0;
      const auto row = static_cast<std::size_t>(reference.width);
      for (std::size_t i = row + 1; i + row + 1 < pixels; ++i) {
        bool counts = true;
        for (const std::size_t k :
             {i - row - 1, i - row, i - row + 1, i - 1, i, i + 1, i + row - 1, i + row, i + row + 1})
          counts = counts && always_seen[k];
        if (!counts) continue;
        variance += squares[i] / k_frames - std::pow(sums[i] / k_frames, 2);
        ++inside;
      }
      csv += csv_line(fmt::format("{}", distance), name, "flicker", variance / inside) +
             csv_line(fmt::format("{}", distance), name, "RMSE", error);
      rows += fmt::format("| {} | {} | {:.4f} | {:.4f} | {:.2e} |\n", distance, name, error, inner_error,
                          variance / inside);
    }
  }
  return "| distance | | RMSE of a picture | inside the object | variance of a pixel over frames "
         "|\n|---|---|---|---|---|\n" +
         rows;
}

/// Pictures of more and more samples, from where some waves are smaller than a pixel.
Plot sample_curve(const TransitionScene& scene, std::size_t repeats) {
  constexpr double k_distance = 1.6;
  constexpr int k_size = 240;
  const Camera camera = camera_at(scene, k_distance, k_size);
  const Image reference = reference_of(scene, camera);
  const ImageMask inside = inside_of(reference);
  Plot plot = log_plot(fmt::format("Torus of waves at distance {:g}, 1 to 32 samples", k_distance),
                       "processor seconds", "RMSE inside");
  for (const auto& [name, representation] : {std::pair("transitions", Representation::automatic),
                                             std::pair("displacement", Representation::displacement)}) {
    for (const int samples : {1, 2, 4, 8, 16, 32}) {
      Image image;
      const double seconds = median_seconds(repeats, [&] {
        image = draw(scene.scene, camera, {representation, samples});
      });
      add_point(plot, name, seconds, compare_images(image, reference, inside).rmse);
    }
  }
  return plot;
}

}  // namespace

AppearanceSection measure_transitions(const BenchOptions& options) {
  const TransitionScene scene;
  const TransitionScene plain({.shading = false, .redistribute = false});
  AppearanceSection section;
  section.markdown = fmt::format(
      "## Transitions\n\nDistances are in units of that at which a wave covers two pixels; {} samples; RMSE "
      "against {} "
      "samples of displacement.\n\n",
      k_samples, k_reference_samples);
  section.markdown += method_table(scene, plain, options.repeats, section.csv) + "\n";
  section.markdown += distance_table(scene, options.repeats, section.csv) + "\n";
  if (!options.quick) {
    section.markdown += threshold_table(scene, options.repeats) + "\n";
    section.markdown += light_table(scene, section.csv) + "\n";
    section.markdown += way_table(scene, plain, section.csv) + "\n";
    section.markdown += noise_table(scene, section.csv);
  }
  section.curves.push_back(sample_curve(scene, options.repeats));
  return section;
}

}  // namespace recede::bench
