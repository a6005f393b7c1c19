#include "common.h"
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/texture.h>

#include <fmt/format.h>

namespace recede::cli {
namespace {

struct AtlasCommandOptions {
  CommonOptions common;
  std::string input, output;
  AtlasOptions atlas;
  bool no_straighten = false, ignore_materials = false;
};

Json stretch_to_json(const Stretch& stretch) {
  return {{"l2", stretch.l2}, {"l_infinity", stretch.l_infinity}};
}

Json to_json(const AtlasCommandOptions& options, const AtlasResult& atlas, const WriteResult& written) {
  Json refused;
  for (std::size_t i = 0; i < atlas.report.refused.size(); ++i) {
    refused[std::string(to_string(static_cast<ChartRefusal>(i)))] = atlas.report.refused[i];
  }
  Json charts = Json::array();
  for (const AtlasChart& chart : atlas.charts) {
    charts.push_back({{"faces", chart.faces},
                      {"area", chart.area},
                      {"stretch", stretch_to_json(chart.stretch)},
                      {"flipped", chart.flipped},
                      {"texels", {chart.x, chart.y, chart.width, chart.height}}});
  }
  return {{"command", "atlas"},
          {"input", options.input},
          {"output", options.output},
          {"stretch", stretch_to_json(atlas.stretch)},
          {"flipped", atlas.flipped},
          {"cut_length", atlas.report.cut_length},
          {"border_edges", atlas.report.border_edges},
          {"non_manifold_edges", atlas.report.non_manifold_edges},
          {"kept_edges", atlas.report.kept_edges},
          {"split_for_flips", atlas.split_for_flips},
          {"split_for_stretch", atlas.split_for_stretch},
          {"unmerged", refused},
          {"map_size", atlas.resolution},
          {"occupancy", atlas.occupancy},
          {"charts", charts},
          {"bytes", written.bytes},
          {"written_without", written.written_without}};
}

void print_text(const AtlasCommandOptions& options, const AtlasResult& atlas) {
  fmt::print("charts       {}, {} of them split for flips and {} for stretch\n", atlas.charts.size(),
             atlas.split_for_flips, atlas.split_for_stretch);
  fmt::print("stretch      {:.4g} L2, {:.4g} L infinity\n", atlas.stretch.l2, atlas.stretch.l_infinity);
  fmt::print("flipped      {} triangles\n", atlas.flipped);
  fmt::print("cut          {:.4g} long, between charts\n", atlas.report.cut_length);
  fmt::print("texels       {} a side, {:.1f} % covered\n", atlas.resolution, 100 * atlas.occupancy);
  fmt::print("written      {}\n", options.output);
}

void run(AtlasCommandOptions options) {
  check_mesh_path(options.output);
  TerminalProgress progress(options.common.quiet);
  options.atlas.charts.straighten = !options.no_straighten;
  options.atlas.charts.keep_materials = !options.ignore_materials;
  PolygonSoup soup = read_unrepaired(options.input, options.common, &progress);
  if (soup.n_faces() == 0) throw InputError::in_file(options.input, "holds no faces");
  if (has_textures(soup.materials))
    print_remark(options.input + ": its textures don't fit the new coordinates and are left out",
                 options.common);
  merge_identical_vertices(soup);
  const AtlasResult atlas = make_atlas(soup, options.atlas, &progress);
  const WriteResult written = write_soup(options.output, atlas.soup);
  progress.clear();
  for (const std::string& missing : written.written_without) {
    print_remark(fmt::format("{}: written without {}", options.output, missing), options.common);
  }
  if (options.common.json) return print_json(to_json(options, atlas, written));
  print_text(options, atlas);
}

}  // namespace

void add_atlas_command(CLI::App& app) {
  const auto options = std::make_shared<AtlasCommandOptions>();
  CLI::App* command =
      app.add_subcommand("atlas", "Cuts a surface into charts and gives it one-to-one texture coordinates.");
  command->footer("Example:\n  recede atlas dragon.ply -o dragon.obj --map-size 2048");
  command->add_option("input", options->input, k_input_help)->required();
  command->add_option("-o,--output", options->output, "mesh to write; the extension chooses the format")
      ->required();
  ChartOptions& charts = options->atlas.charts;
  const auto cutting = "Charts";
  command->add_option("--charts", charts.charts, "merge until so many are left")->group(cutting);
  command
      ->add_option("--bend-limit", charts.bend_limit,
                   "how far a chart may bend: 0 flat, 0.5 a hemisphere (0.2)")
      ->check(between(0.0, 1.0))
      ->group(cutting);
  command->add_option("--compactness", charts.compactness, "weight of the squared perimeter (1)")
      ->check(not_negative())
      ->group(cutting);
  command
      ->add_flag("--no-straighten", options->no_straighten,
                 "leave the borders of charts as merging made them")
      ->group(cutting);
  command->add_flag("--ignore-materials", options->ignore_materials, "charts may have several materials")
      ->group(cutting);
  command
      ->add_flag("--keep-uv-seams", charts.keep_uv_seams, "cut where the input's texture coordinates are cut")
      ->group(cutting);
  const auto mapping = "Atlas";
  command
      ->add_option("--stretch-limit", options->atlas.stretch_limit,
                   "L2 stretch above which a chart is cut (1.25)")
      ->check(between(1.0, 1e9))
      ->group(mapping);
  command->add_flag("--scale-by-stretch", options->atlas.scale_by_stretch, "more texels for stretched charts")
      ->group(mapping);
  command->add_option("--map-size", options->atlas.packing.resolution, "texels along each side (1024)")
      ->check(between(1, 65536))
      ->group(mapping);
  command->add_option("--gutter", options->atlas.packing.gutter, "texels between two charts (4)")
      ->check(between(0, 1024))
      ->group(mapping);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
