#include "common.h"
#include "drawn_levels.h"
#include "size_option.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/point_cloud.h>
#include <recede/lod/billboard_budget.h>
#include <recede/lod/billboard_level.h>
#include <recede/lod/billboard_mipmaps.h>
#include <recede/render/billboard_reflectance.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numbers>

namespace recede::cli {
namespace {

struct BillboardsOptions {
  CommonOptions common;
  std::string input, output, folder;
  BillboardOptions clouds;
  BillboardTextureOptions textures;
  ViewSettings view;
  double field_of_view = 45;  // degrees
  std::optional<std::size_t> most_bytes;
  int mipmaps = 0;
  bool reflectance = false;
  std::vector<double> relative_errors;
  double largest_deviation = 60;  // degrees
};

// Of a cloud.
struct CloudFigures {
  double area = 0, face_area = 0, largest_error = 0, largest_deviation = 0;
  double texels = 0;  // with sides as long as the error
};

CloudFigures figures_of(const BillboardCloud& cloud) {
  CloudFigures figures;
  for (const Billboard& billboard : cloud.billboards) {
    figures.area += billboard.area();
    figures.face_area += billboard.face_area;
    figures.largest_error = std::max(figures.largest_error, billboard.error);
    figures.largest_deviation = std::max(figures.largest_deviation, billboard.normal_deviation);
    const Vec2 texels = (2 * billboard.half_sizes / cloud.error).array().ceil();
    figures.texels += std::max(texels.x(), 1.0) * std::max(texels.y(), 1.0);
  }
  return figures;
}

// The rectangles, in a colour each.
PolygonSoup quads_of(const BillboardCloud& cloud) {
  PolygonSoup soup;
  for (std::size_t i = 0; i < cloud.billboards.size(); ++i) {
    const Billboard& billboard = cloud.billboards[i];
    const auto first = static_cast<Index>(soup.positions.size());
    const Vec3 u = billboard.half_sizes.x() * billboard.axis_u,
               v = billboard.half_sizes.y() * billboard.axis_v;
    // Hues far apart one after the other.
    const double hue = std::fmod(0.618034 * static_cast<double>(i), 1.0);
    Vec4 color(0, 0, 0, 1);
    for (int k = 0; k < 3; ++k)
      color[k] = 0.5 + 0.4 * std::cos(2 * std::numbers::pi * (hue - static_cast<double>(k) / 3));
    for (const Vec2& corner : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)}) {
      soup.positions.push_back(billboard.center + corner.x() * u + corner.y() * v);
      soup.vertex_colors.push_back(color);
    }
    soup.add_face(std::array<Index, 4>{first, first + 1, first + 2, first + 3});
  }
  return soup;
}

// With the number of the cloud before the extension, where there are several.
std::string numbered(const std::string& output, std::size_t number, std::size_t count) {
  if (count == 1) return output;
  std::filesystem::path path(output);
  path.replace_filename(fmt::format("{}_{}{}", path.stem().string(), number, path.extension().string()));
  return path.string();
}

// Discs for the points of a file without faces. Where normals had to be estimated, both sides count.
PolygonSoup read_points(BillboardsOptions& options, std::size_t& n_points, Progress* progress) {
  const PointCloud points = read_point_cloud(options.input, progress);
  n_points = points.positions.size();
  Splats splats = splats_of(points);
  if (splats.are_normals_estimated) options.clouds.is_two_sided = true;
  print_remark(
      fmt::format("{}: no faces; {} points become discs{}", options.input, n_points,
                  splats.are_normals_estimated ? ", with estimated normals, seen from both sides" : ""),
      options.common);
  return std::move(splats.soup);
}

PolygonSoup read_input(BillboardsOptions& options, std::size_t& n_points, Progress* progress) {
  PolygonSoup model = read_unrepaired(options.input, options.common, progress);
  if (model.n_faces() == 0) model = read_points(options, n_points, progress);
  merge_identical_vertices(model);
  for (const double share : options.relative_errors)
    options.clouds.errors.push_back(share * bounding_box(model).diagonal().norm());
  options.clouds.largest_deviation = options.largest_deviation * std::numbers::pi / 180;
  options.view.field_of_view = options.field_of_view * std::numbers::pi / 180;
  return model;
}

void write_mipmaps(const LodHierarchy& hierarchy, const HierarchyFiles& files, int n) {
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const std::vector<BillboardMipmap> mipmaps = billboard_mipmaps(*hierarchy.levels[i].billboards, n);
    for (std::size_t k = 0; k < mipmaps.size(); ++k) {
      const auto write = [&](const Raster& raster, const char* kind) {
        write_file_atomically(files.folder / fmt::format("level_{}_{}_{}.png", i, kind, k + 1),
                              encode_png(raster));
      };
      write(mipmaps[k].color, "color");
      write(mipmaps[k].normal, "normal");
      write(mipmaps[k].height, "height");
    }
  }
}

// The clouds with textures, as levels.
LodHierarchy textured(const PolygonSoup& model, const std::vector<BillboardCloud>& clouds,
                      const BillboardsOptions& options, Progress* progress) {
  std::vector<BillboardTextures> textures;
  for (const BillboardCloud& cloud : clouds)
    textures.push_back(texture_billboards(model, cloud, options.textures, progress));
  return billboard_hierarchy(model, std::filesystem::path(options.input).stem().string(), std::move(textures),
                             options.view, progress);
}

// From which on its error isn't seen: the finest level of a hierarchy serves from everywhere, but as nothing
// finer is there.
double distance_of(const LodLevel& level, const ViewSettings& view) {
  return std::max(level.switch_distance, switch_distance(level.error.bound, view));
}

Json textures_to_json(const LodLevel& level, const MapFiles& files, const ViewSettings& view) {
  const BillboardTextures& textures = *level.billboards;
  return {{"color", files.color.string()},
          {"normal", files.normal.string()},
          {"height", files.height.string()},
          {"size", {textures.color.width, textures.color.height}},
          {"bytes", textures.bytes()},
          {"covered", textures.covered},
          {"packed", textures.packed},
          {"error", {{"max", level.error.max}, {"rms", level.error.rms}, {"bound", level.error.bound}}},
          {"switch_distance", distance_of(level, view)}};
}

// Of a cloud: what became a file.
struct WrittenReflectance {
  std::string file;
  std::size_t bytes = 0, raw_bytes = 0;
  double rms = 0;  // of the range
};

Json reflectance_to_json(const WrittenReflectance& written) {
  return {{"file", written.file},
          {"bytes", written.bytes},
          {"raw_bytes", written.raw_bytes},
          {"rms", written.rms}};
}

// What was made, and where it is.
struct Made {
  PolygonSoup model;
  std::size_t n_points = 0;  // of a file without faces
  std::vector<BillboardCloud> clouds;
  std::optional<LodHierarchy> hierarchy;
  HierarchyFiles hierarchy_files;
  std::vector<WrittenReflectance> reflectances;
  std::vector<std::string> files;
};

void write_folder(Made& made, const BillboardsOptions& options,
                  const std::vector<BillboardReflectance>& reflectances) {
  made.hierarchy_files = write_hierarchy(options.folder, *made.hierarchy);
  write_mipmaps(*made.hierarchy, made.hierarchy_files, options.mipmaps);
  for (std::size_t i = 0; i < reflectances.size(); ++i) {
    const std::filesystem::path file = reflectance_file(made.hierarchy_files.folder, i);
    write_billboard_reflectance(file, reflectances[i]);
    made.reflectances.push_back(
        {file.string(), bytes(reflectances[i]), raw_bytes(reflectances[i]), reflectances[i].error.rms});
  }
  made.files.push_back(made.hierarchy_files.glb.string());
}

Made make(BillboardsOptions& options, Progress* progress) {
  Made made;
  made.model = read_input(options, made.n_points, progress);
  if (options.most_bytes) {
    BillboardTextures best =
        billboards_within(made.model, *options.most_bytes, options.clouds, options.textures, progress);
    made.clouds.push_back({best.error, best.billboards, best.left_out, options.clouds.is_two_sided});
    std::vector<BillboardTextures> textures;
    textures.push_back(std::move(best));
    made.hierarchy = billboard_hierarchy(made.model, std::filesystem::path(options.input).stem().string(),
                                         std::move(textures), options.view, progress);
  } else {
    made.clouds = build_billboard_clouds(made.model, options.clouds, progress);
    if (!options.folder.empty()) made.hierarchy = textured(made.model, made.clouds, options, progress);
  }
  // All that may fail for reasons of the model comes before anything is written.
  std::vector<BillboardReflectance> reflectances;
  for (std::size_t i = 0; options.reflectance && i < made.clouds.size(); ++i)
    reflectances.push_back(make_billboard_reflectance(made.model, made.clouds[i],
                                                      *made.hierarchy->levels[i].billboards, {}, progress));
  for (std::size_t i = 0; i < made.clouds.size() && !options.output.empty(); ++i) {
    made.files.push_back(numbered(options.output, i, made.clouds.size()));
    write_soup(made.files.back(), quads_of(made.clouds[i]));
  }
  if (!options.folder.empty()) write_folder(made, options, reflectances);
  return made;
}

void print_text(const Made& made, double seconds) {
  fmt::print("error        billboards     texels   area/faces   largest error   normals off by\n");
  for (const BillboardCloud& cloud : made.clouds) {
    const CloudFigures figures = figures_of(cloud);
    fmt::print("{:<12.5g} {:10} {:10.0f} {:12.2f} {:15.4g} {:11.1f} deg\n", cloud.error,
               cloud.billboards.size(), figures.texels, figures.area / figures.face_area,
               figures.largest_error, figures.largest_deviation * 180 / std::numbers::pi);
  }
  if (made.hierarchy) {
    fmt::print("level        textures        bytes   covered   max error   rms error   from distance\n");
    for (std::size_t i = 0; i < made.hierarchy->levels.size(); ++i) {
      const LodLevel& level = made.hierarchy->levels[i];
      const BillboardTextures& textures = *level.billboards;
      fmt::print("{:<12} {:5} x {:<5} {:9} {:7.1f} % {:11.4g} {:11.4g} {:15.5g}\n", i, textures.color.width,
                 textures.color.height, textures.bytes(), 100 * textures.covered, level.error.max,
                 level.error.rms, distance_of(level, made.hierarchy->view));
    }
  }
  for (std::size_t i = 0; i < made.reflectances.size(); ++i) {
    const WrittenReflectance& written = made.reflectances[i];
    fmt::print("reflectance  {:<5} {} bytes, {:.2g} % of {}; off by {:.2g} % of its range\n", i,
               written.bytes,
               100 * static_cast<double>(written.bytes) / static_cast<double>(written.raw_bytes),
               written.raw_bytes, 100 * written.rms);
  }
  fmt::print("seconds      {:.3g}\n", seconds);
  for (const std::string& file : made.files) fmt::print("written      {}\n", file);
}

void print_document(const Made& made, const BillboardsOptions& options, double seconds) {
  Json list = Json::array();
  for (std::size_t i = 0; i < made.clouds.size(); ++i) {
    const CloudFigures figures = figures_of(made.clouds[i]);
    list.push_back({{"error", made.clouds[i].error},
                    {"billboards", made.clouds[i].billboards.size()},
                    {"texels", figures.texels},
                    {"area", figures.area},
                    {"face_area", figures.face_area},
                    {"largest_error", figures.largest_error},
                    {"largest_deviation", figures.largest_deviation * 180 / std::numbers::pi},
                    {"textures", nullptr},
                    {"reflectance", nullptr}});
    if (!options.folder.empty())
      list.back()["textures"] =
          textures_to_json(made.hierarchy->levels[i], made.hierarchy_files.map_files[i], options.view);
    if (options.reflectance) list.back()["reflectance"] = reflectance_to_json(made.reflectances[i]);
  }
  print_json({{"command", "billboards"},
              {"input", options.input},
              {"outputs", made.files},
              {"points", made.n_points},
              {"left_out", made.clouds.front().left_out},
              {"clouds", list},
              {"seconds", seconds}});
}

void run(BillboardsOptions options) {
  const auto start = std::chrono::steady_clock::now();
  if (!options.output.empty()) check_mesh_path(options.output);
  if (!options.folder.empty()) check_output_folder(options.folder);
  if (options.mipmaps > 0 && options.folder.empty()) throw OptionError("--mipmaps needs --folder");
  if (options.reflectance && options.folder.empty()) throw OptionError("--reflectance needs --folder");
  TerminalProgress progress(options.common.quiet);
  const Made made = make(options, &progress);
  progress.clear();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (made.clouds.front().left_out > 0)
    print_remark(fmt::format("{} faces without area are left out", made.clouds.front().left_out),
                 options.common);
  options.common.json ? print_document(made, options, seconds) : print_text(made, seconds);
}

}  // namespace

void add_billboards_command(CLI::App& app) {
  const auto options = std::make_shared<BillboardsOptions>();
  CLI::App* command = app.add_subcommand(
      "billboards", "Finds a few rectangles that stand for a model from far away, at each of some errors.");
  command->footer("Example:\n  recede billboards tree.obj -o cloud.ply --relative-errors 0.01 --two-sided");
  command
      ->add_option("input", options->input,
                   std::string(k_input_help) + "; a file without faces is taken as points")
      ->required();
  command->add_option(
      "-o,--output", options->output,
      "writes the rectangles in colours, one mesh for each error, numbered where there are several");
  command
      ->add_option(
          "--folder", options->folder,
          "writes the rectangles with textures, as levels of a hierarchy: a GLB file and its pictures")
      ->option_text("FOLDER");
  const auto group = "Billboards";
  command
      ->add_option(
          "--method", options->clouds.method,
          "clusters: little texture; planes: few planes; simplification: one for each triangle of the "
          "simplified model (clusters)")
      ->transform(one_of<BillboardMethod>({{"clusters", BillboardMethod::face_clustering},
                                           {"planes", BillboardMethod::plane_cover},
                                           {"simplification", BillboardMethod::simplification}}))
      ->group(group);
  auto* absolute = command
                       ->add_option("--errors", options->clouds.errors,
                                    "how far faces may be from their rectangle, object units; rising")
                       ->group(group);
  auto* relative =
      command
          ->add_option("--relative-errors", options->relative_errors,
                       "the same as shares of the diagonal (0.5, 1, 2 and 4 % of the longest side)")
          ->group(group)
          ->excludes(absolute);
  command
      ->add_option("--normal-deviation", options->largest_deviation,
                   "largest angle between a face and its rectangle, degrees, not of planes (60)")
      ->check(between(0.0, 180.0))
      ->group(group);
  command
      ->add_option("--waste", options->clouds.largest_waste,
                   "largest area of a rectangle over that of its faces, of clusters (4)")
      ->check(between(1.0, 1e9))
      ->group(group);
  command
      ->add_option("--neighbours", options->clouds.n_neighbours,
                   "faces near to each one that it may share a rectangle with, of clusters (50)")
      ->check(between(1, 100000))
      ->group(group);
  command->add_flag("--two-sided", options->clouds.is_two_sided, "faces count from both sides, as leaves do")
      ->group(group);
  const auto textures = "Textures";
  command
      ->add_option("--texels-per-error", options->textures.texels_per_error,
                   "a texel's sides are at most the error over this (1)")
      ->check(above_zero())
      ->group(textures);
  command->add_option("--samples", options->textures.samples, "rays along each side of a texel (4)")
      ->check(between(1, 64))
      ->group(textures);
  command
      ->add_option(
          "--overlap", options->textures.overlap,
          "texels in which faces of others are shown beside a rectangle's own ones, against gaps (2)")
      ->check(between(0, 1000))
      ->group(textures);
  command->add_option("--gutter", options->textures.gutter, "texels between rectangles in the atlas (1)")
      ->check(between(0, 64))
      ->group(textures);
  command
      ->add_option(
          "--most-bytes", options->most_bytes,
          "bytes of textures: the cloud of least error that fits, instead of --errors; such as 256kb")
      ->transform(size_in_bytes())
      ->option_text("BYTES")
      ->group(textures)
      ->excludes(absolute)
      ->excludes(relative);
  command
      ->add_option("--mipmaps", options->mipmaps,
                   "smaller versions of the pictures that are written, too (0)")
      ->check(between(0, 16))
      ->group(textures);
  command
      ->add_flag("--reflectance", options->reflectance,
                 "also writes what each texel sends of each light to each viewer, with shadows, for recede "
                 "render --reflectance; takes up to minutes")
      ->group(textures);
  const auto view = "View (for switch distances)";
  command->add_option("--image-height", options->view.image_height, "pixels (1080)")->group(view);
  command->add_option("--field-of-view", options->field_of_view, "vertical, degrees (45)")->group(view);
  command->add_option("--pixel-error", options->view.pixel_error, "error that a level may show, pixels (1)")
      ->group(view);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
