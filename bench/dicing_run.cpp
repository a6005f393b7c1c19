#include "dicing_run.h"

#include "models.h"
#include "plot_sheet.h"
#include <recede/lod/displacement_bake.h>
#include <recede/lod/simplify.h>
#include <recede/render/image_difference.h>
#include <recede/render/renderer.h>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <array>

namespace recede::bench {
namespace {

constexpr int k_width = 1920, k_height = 1080;
constexpr double k_field_of_view = 0.7;
constexpr const char* k_drawn_model = "bunny00";
/// Of pictures whose errors are compared: every side a quarter.
constexpr int k_compared_width = k_width / 4, k_compared_height = k_height / 4;

BakedMaps maps_of(const PolygonSoup& soup) {
  SimplifyOptions coarser;
  coarser.target.ratio = 0.02;
  const SimplifySoupResult coarse = simplify(soup, coarser);
  MapOptions options{.normal = false, .color = false, .size = 1024};
  options.search_distance = MapOptions::k_reach * coarse.error_bound.value();
  return bake_maps(soup, coarse.soup, options);
}

struct NamedView {
  const char* name;
  Camera camera;
};

/// The whole model, and a place on it from near by.
std::vector<NamedView> views_of(const PolygonSoup& soup, int width, int height) {
  const Camera whole = camera_in_front(soup.positions, Vec3::UnitY(), k_field_of_view, width, height);
  // The point that is nearest to the camera lies on the surface.
  Vec3 nearest = soup.positions[0];
  for (const Vec3& p : soup.positions) {
    if ((p - whole.position).norm() < (nearest - whole.position).norm()) nearest = p;
  }
  Camera near = whole;
  near.target = nearest;
  near.position = nearest + 0.12 * (whole.position - nearest);
  return {{"whole", whole}, {"near", near}};
}

Image picture_of(const PolygonSoup& soup, const Camera& camera) {
  return render(Scene(soup), camera, {.samples_per_pixel = 4});
}

struct Speed {
  RemeshReport report;
  double seconds = 0;
  std::string text() const {
    const auto vertices =
        static_cast<double>(report.corner_vertices + report.edge_vertices + report.inner_vertices);
    return fmt::format("{:.2f} M ; {:.2f} M ; {:.3f} ; {:.1f}", 1e-6 * vertices,
                       1e-6 * static_cast<double>(report.triangles), seconds, 1e-6 * vertices / seconds);
  }
};

Speed measure_speed(const DisplacedBase& base, const Camera& camera, const RemeshOptions& options,
                    std::size_t repeats) {
  Speed speed;
  speed.seconds = median_seconds(
      repeats, [&] { speed.report = remesh_for_view(base, remesh_view_of(camera), options).report; });
  return speed;
}

struct UniformMesh {
  std::size_t triangles = 0;
  double seconds = 0;
  std::array<double, 2> errors{};  ///< of both views
};

/// Uniform dicing, finer and finer, beside the surface itself.
std::vector<UniformMesh> measure_uniform(const BakedMaps& maps, const std::vector<NamedView>& views,
                                         const std::vector<Image>& references) {
  std::vector<UniformMesh> meshes;
  for (const int parts : {1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 17, 20, 24, 28}) {
    UniformMesh& mesh = meshes.emplace_back();
    PolygonSoup soup;
    mesh.seconds = median_seconds(1, [&] { soup = dice_surface(maps, {.parts = parts}); });
    mesh.triangles = soup.n_faces();
    for (std::size_t v = 0; v < views.size(); ++v)
      mesh.errors[v] = compare_images(picture_of(soup, views[v].camera), references[v]).rmse;
  }
  return meshes;
}

std::string error_rows(const std::string& model, const BakedMaps& maps, const DisplacedBase& base,
                       std::vector<Plot>& curves) {
  const std::vector<NamedView> views = views_of(maps.surface, k_compared_width, k_compared_height);
  // The surface of the map itself, by triangles of half a pixel.
  std::vector<Image> references;
  for (const NamedView& view : views) {
    const RemeshOptions exact{.triangle_pixels = 0.5, .footprint = FootprintRule::none, .normals = false};
    references.push_back(
        picture_of(remesh_for_view(base, remesh_view_of(view.camera), exact).soup, view.camera));
  }
  const std::vector<UniformMesh> uniform = measure_uniform(maps, views, references);
  std::string rows;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::string title = fmt::format("{}, {}", model, views[v].name);
    Plot over_time = log_plot(title, "processor seconds", "RMSE of the picture"),
         over_size = log_plot(title, "triangles", "RMSE of the picture");
    const auto add = [&](const char* series, std::size_t triangles, double seconds, double error) {
      add_point(over_time, series, seconds, error);
      add_point(over_size, series, static_cast<double>(triangles), error);
    };
    for (const double pixels : {1.0, 2.0, 4.0, 8.0}) {
      RemeshResult diced;
      const double seconds = median_seconds(1, [&] {
        diced = remesh_for_view(base, remesh_view_of(views[v].camera),
                                {.triangle_pixels = pixels, .normals = false});
      });
      const double error = compare_images(picture_of(diced.soup, views[v].camera), references[v]).rmse;
      add("Recede", diced.report.triangles, seconds, error);
      std::string same = "more than the finest";
      for (const UniformMesh& mesh : uniform) {
        if (mesh.errors[v] > error) continue;
        same = fmt::format("{} ; {:.2f}", mesh.triangles,
                           static_cast<double>(mesh.triangles) / static_cast<double>(diced.report.triangles));
        break;
      }
      rows += fmt::format("| {}, {} | {} | {} | {:.5f} | {} |\n", model, views[v].name, pixels,
                          diced.report.triangles, error, same);
    }
    for (const UniformMesh& mesh : uniform) add("uniform", mesh.triangles, mesh.seconds, mesh.errors[v]);
    curves.push_back(over_time);
    curves.push_back(over_size);
  }
  return rows;
}

}  // namespace

BenchSection measure_dicing(const BenchOptions& options) {
  BenchSection section;
  std::string speeds, errors;
  for (const ModelSource& source : all_models(options.data, true)) {
    const bool is_drawn = source.name == k_drawn_model;
    if (source.polygons || !is_wanted(source.name, options.models) || (options.quick && !is_drawn)) continue;
    require_file(source);
    const BakedMaps maps = maps_of(load_model(source));
    const DisplacedBase base(maps);
    {
      const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, std::size_t{1});
      for (const NamedView& view : views_of(maps.surface, k_width, k_height)) {
        speeds += fmt::format("| {}, {} |", source.name, view.name);
        for (const auto& [pixels, rule, normals] :
             {std::tuple(1.0, FootprintRule::by_side, true), std::tuple(1.0, FootprintRule::by_side, false),
              std::tuple(1.0, FootprintRule::mean, true), std::tuple(4.0, FootprintRule::by_side, true)}) {
          const RemeshOptions dicing{.triangle_pixels = pixels, .footprint = rule, .normals = normals};
          speeds += fmt::format(" {} |", measure_speed(base, view.camera, dicing, options.repeats).text());
        }
        speeds += "\n";
      }
    }
    std::vector<Plot> curves;
    errors += error_rows(source.name, maps, base, curves);
    if (is_drawn) section.curves = std::move(curves);
    fmt::print(stderr, "{} is done\n", source.name);
  }
  section.markdown =
      "| vertices ; triangles ; seconds ; million vertices per second | 1 pixel | without normals | `mean` | "
      "4 pixels |\n|---|---|---|---|---|\n" +
      speeds +
      "\n| | pixels | triangles | RMSE | uniform of no larger error: triangles ; ratio |\n"
      "|---|---|---|---|---|\n" +
      errors;
  return section;
}

}  // namespace recede::bench
