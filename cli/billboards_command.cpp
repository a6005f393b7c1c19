#include "common.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/point_cloud.h>
#include <recede/lod/billboard_cloud.h>

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
  std::string input, output;
  BillboardOptions clouds;
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

void run(BillboardsOptions options) {
  const auto start = std::chrono::steady_clock::now();
  if (!options.output.empty()) check_mesh_path(options.output);
  TerminalProgress progress(options.common.quiet);
  PolygonSoup model = read_unrepaired(options.input, &progress);
  std::size_t n_points = 0;
  if (model.n_faces() == 0) model = read_points(options, n_points, &progress);
  merge_identical_vertices(model);
  Box3 box;
  for (const Vec3& point : model.positions) box.extend(point);
  for (const double share : options.relative_errors)
    options.clouds.errors.push_back(share * box.diagonal().norm());
  options.clouds.largest_deviation = options.largest_deviation * std::numbers::pi / 180;
  const std::vector<BillboardCloud> clouds = build_billboard_clouds(model, options.clouds, &progress);
  std::vector<std::string> files;
  for (std::size_t i = 0; i < clouds.size() && !options.output.empty(); ++i) {
    files.push_back(numbered(options.output, i, clouds.size()));
    write_soup(files.back(), quads_of(clouds[i]));
  }
  progress.clear();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (clouds.front().left_out > 0)
    print_remark(fmt::format("{} faces without area are left out", clouds.front().left_out), options.common);
  Json list = Json::array();
  if (!options.common.json)
    fmt::print("error        billboards     texels   area/faces   largest error   normals off by\n");
  for (const BillboardCloud& cloud : clouds) {
    const CloudFigures figures = figures_of(cloud);
    const double degrees = figures.largest_deviation * 180 / std::numbers::pi;
    if (!options.common.json) {
      fmt::print("{:<12.5g} {:10} {:10.0f} {:12.2f} {:15.4g} {:11.1f} deg\n", cloud.error,
                 cloud.billboards.size(), figures.texels, figures.area / figures.face_area,
                 figures.largest_error, degrees);
      continue;
    }
    list.push_back({{"error", cloud.error},
                    {"billboards", cloud.billboards.size()},
                    {"texels", figures.texels},
                    {"area", figures.area},
                    {"face_area", figures.face_area},
                    {"largest_error", figures.largest_error},
                    {"largest_deviation", degrees}});
  }
  if (!options.common.json) {
    fmt::print("seconds      {:.3g}\n", seconds);
    for (const std::string& file : files) fmt::print("written      {}\n", file);
    return;
  }
  print_json({{"command", "billboards"},
              {"input", options.input},
              {"outputs", files},
              {"points", n_points},
              {"left_out", clouds.front().left_out},
              {"clouds", list},
              {"seconds", seconds}});
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
  command
      ->add_option("--relative-errors", options->relative_errors,
                   "the same as shares of the diagonal (0.5, 1, 2 and 4 % of the longest side)")
      ->group(group)
      ->excludes(absolute);
  command
      ->add_option("--normal-deviation", options->largest_deviation,
                   "largest angle between a face and its rectangle, degrees, not of planes (60)")
      ->check(CLI::Range(0.0, 180.0))
      ->group(group);
  command
      ->add_option("--waste", options->clouds.largest_waste,
                   "largest area of a rectangle over that of its faces, of clusters (3)")
      ->check(CLI::Range(1.0, 1e9))
      ->group(group);
  command
      ->add_option("--neighbours", options->clouds.n_neighbours,
                   "faces near to each one that it may share a rectangle with, of clusters (50)")
      ->check(CLI::Range(1, 100000))
      ->group(group);
  command->add_flag("--two-sided", options->clouds.is_two_sided, "faces count from both sides, as leaves do")
      ->group(group);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
