#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/detail/report_content.h>
#include <recede/render/image_io.h>
#include <recede/render/renderer.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace recede {

namespace {

using detail::LevelContent;
using detail::MapContent;
using detail::SwitchView;

constexpr int k_largest_shown = 420;  // pixels a side; larger pictures are shrunk
constexpr int k_close_up_side = 420;
constexpr double k_window_margin = 0.1;  // around the bounding sphere's disc, share of its diameter

// Few samples exaggerate differences along silhouettes, so small pictures, which are cheap and shown
// enlarged, get more. Large ones stay below this many rays.
int samples_for(int pixels_a_side) {
  constexpr double k_most_rays = 5e6;
  const double samples = k_most_rays / (static_cast<double>(pixels_a_side) * pixels_a_side);
  return samples >= 16 ? 16 : samples >= 9 ? 9 : samples >= 4 ? 4 : 1;
}

struct SwitchCamera {
  Camera camera;
  double distance;
  bool sphere_fits;
};

SwitchCamera switch_camera(const LodHierarchy& hierarchy, const LodLevel& level, const Vec3& up) {
  const double distance = level.switch_distance + hierarchy.radius;
  const Camera whole = look_at(hierarchy.center, view_from_front(up), distance, up, hierarchy.view);
  const double disc = projected_diameter(whole, hierarchy.radius);
  // Two pixels more for the disc's own rounding; the parity of the image keeps its pixels.
  const double wanted = std::ceil(disc * (1 + k_window_margin)) + 2;
  const bool fits = wanted <= whole.height;
  int side = fits ? static_cast<int>(wanted) : whole.height;
  side += (whole.height - side) % 2;
  return {crop_to_middle(whole, side, side), distance, fits};
}

SwitchView compare_at_switch(const LodHierarchy& hierarchy, std::size_t index, const Scene& original,
                             const Scene& simplified, const Vec3& up, Progress* progress) {
  const SwitchCamera view = switch_camera(hierarchy, hierarchy.levels[index], up);
  const int side = view.camera.height;
  RenderOptions options;
  options.samples_per_pixel = samples_for(side);
  const Image level_image = render(simplified, view.camera, options, progress);
  const Image original_image = render(original, view.camera, options, progress);
  SwitchView result;
  result.difference = compare_images(level_image, original_image);
  result.shrink_factor = (side + k_largest_shown - 1) / k_largest_shown;
  result.level = shrink(level_image, result.shrink_factor);
  result.original = shrink(original_image, result.shrink_factor);
  result.heat = heat_map(result.difference.magnitudes, detail::k_heat_map_scale, result.shrink_factor);
  result.difference.magnitudes.samples = {};
  result.samples_per_pixel = options.samples_per_pixel;
  result.camera_distance = view.distance;
  result.sphere_fits = view.sphere_fits;
  return result;
}

Camera close_up_camera(const PolygonMesh& mesh, const Vec3& up) {
  constexpr double k_field_of_view = 0.5;  // radians; a long lens, about 29 degrees
  constexpr double k_margin = 0.06;
  return frame_points(to_soup(mesh).positions, view_from_front(up), up, k_field_of_view, k_close_up_side,
                      k_margin);
}

bool change_the_look(const BakedMaps& maps) {
  return !maps.displacement.samples.empty() || !maps.normal.samples.empty();
}

// The surface that displacement and normals stand for, in facets of about a pixel.
PolygonSoup mapped_surface(const BakedMaps& maps) {
  constexpr double k_facets = 2.0 * k_close_up_side * k_close_up_side;
  const double triangles = static_cast<double>(std::max<std::size_t>(1, maps.surface.n_faces()));
  return dice_surface(maps, {.parts = std::max(1, static_cast<int>(std::sqrt(k_facets / triangles)))});
}

MapContent draw_maps(const BakedMaps& maps, const Camera& camera, const RenderOptions& options,
                     Progress* progress) {
  MapContent content;
  if (change_the_look(maps)) {
    content.close_up = render(Scene(mapped_surface(maps)), camera, options, progress);
  }
  const auto add = [&content](const char* name, const Raster& raster) {
    if (raster.samples.empty()) return;
    const int factor = (raster.width + detail::k_map_side - 1) / detail::k_map_side;
    content.pictures.push_back({name, shrink(to_image(raster), factor)});
  };
  add("Displacement", maps.displacement);
  add("Normals", maps.normal);
  add("Colours", maps.color);
  return content;
}

// Hands on the progress of one picture as a part of the whole report's.
class PictureProgress : public Progress {
 public:
  PictureProgress(Progress* whole, std::size_t pictures) : whole_(whole), pictures_(pictures) {}
  void update(std::string_view, double fraction) override {
    report_progress(whole_, "draw report",
                    std::min(1.0, (static_cast<double>(done_) + fraction) / static_cast<double>(pictures_)));
    if (fraction >= 1) ++done_;
  }

 private:
  Progress* whole_;
  std::size_t pictures_;
  std::size_t done_ = 0;
};

std::vector<LevelContent> draw_levels(const LodHierarchy& hierarchy, const Vec3& up, Progress* progress) {
  const std::size_t count = hierarchy.levels.size();
  const auto with_maps =
      std::count_if(hierarchy.levels.begin(), hierarchy.levels.end(),
                    [](const LodLevel& level) { return level.maps && change_the_look(*level.maps); });
  PictureProgress pictures(progress, 3 * count - 2 + static_cast<std::size_t>(with_maps));
  std::vector<LevelContent> levels(count);
  const Scene original(hierarchy.levels[0]);
  const Camera camera = close_up_camera(hierarchy.levels[0].mesh, up);
  RenderOptions close_up;
  close_up.samples_per_pixel = 9;
  close_up.wireframe = Wireframe{};
  levels[0].summary = summarize(hierarchy.levels[0].mesh);
  levels[0].close_up = render(original, camera, close_up, &pictures);
  for (std::size_t i = 1; i < count; ++i) {
    const Scene scene(hierarchy.levels[i]);
    levels[i].summary = summarize(hierarchy.levels[i].mesh);
    levels[i].close_up = render(scene, camera, close_up, &pictures);
    levels[i].at_switch = compare_at_switch(hierarchy, i, original, scene, up, &pictures);
    if (hierarchy.levels[i].maps) {
      RenderOptions smooth = close_up;
      smooth.wireframe.reset();
      levels[i].maps = draw_maps(*hierarchy.levels[i].maps, camera, smooth, &pictures);
    }
  }
  return levels;
}

void check(const LodHierarchy& hierarchy, const HierarchyFiles& files, const ReportOptions& options) {
  if (hierarchy.levels.empty()) throw InputError("a hierarchy without levels has nothing to report");
  if (files.level_files.size() != hierarchy.levels.size() ||
      files.level_bytes.size() != hierarchy.levels.size()) {
    throw OptionError(fmt::format("{} levels, but {} files and {} file sizes", hierarchy.levels.size(),
                                  files.level_files.size(), files.level_bytes.size()));
  }
  if (!options.patches.empty() && options.patches.size() != hierarchy.levels.size())
    throw OptionError(
        fmt::format("{} levels, but {} counts of patches", hierarchy.levels.size(), options.patches.size()));
  if (!(options.up.norm() > 0) || !options.up.allFinite())
    throw OptionError("the up direction must not be zero");
}

}  // namespace

ReportFiles write_report(const std::filesystem::path& folder, const LodHierarchy& hierarchy,
                         const HierarchyFiles& files, const ReportOptions& options, Progress* progress) {
  const auto start = std::chrono::steady_clock::now();
  check(hierarchy, files, options);
  detail::ReportContent content{hierarchy, files, options, 0, draw_levels(hierarchy, options.up, progress),
                                {}};
  content.viewer = detail::pack_levels(hierarchy, options.viewer_triangles, progress);
  content.diagonal = content.levels[0].summary.box.diagonal().norm();
  ReportFiles written{.html = folder / "report.html", .json = folder / "report.json"};
  write_file_atomically(written.html, detail::report_html(content));
  write_file_atomically(written.json, detail::report_json(content));
  written.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return written;
}

}  // namespace recede
