#include "common.h"

#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <set>
#include <system_error>

namespace recede::cli {

namespace fs = std::filesystem;

void add_common_options(CLI::App& command, CommonOptions& options) {
  command.add_flag("--json", options.json, "print one JSON document instead of text");
  command.add_flag("-q,--quiet", options.quiet, "no progress bar and no remarks");
  constexpr int k_most_threads = 1024;
  command.add_option("--threads", options.threads, "number of threads; 0: all")
      ->check(between(0, k_most_threads));
}

namespace {

// Complains with `text` of finite numbers that aren't `right`.
CLI::Validator number_check(std::function<bool(double)> right, const std::string& text) {
  const auto check = [right = std::move(right), text](const std::string& input) -> std::string {
    double value = 0;
    if (!CLI::detail::lexical_cast(input, value)) return fmt::format("{} isn't a number", input);
    if (!std::isfinite(value)) return fmt::format("{} isn't a finite number", input);
    return right(value) ? "" : fmt::format("{} must be {}", input, text);
  };
  return CLI::Validator(check, text);
}

}  // namespace

bool is_same_name(const std::string& a, const std::string& b) {
  const auto plain = [](char letter) { return letter == '_' ? '-' : letter; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return plain(x) == plain(y); });
}

CLI::Validator one_of_names(std::vector<std::string> names) {
  const auto replace = [names](std::string& text) -> std::string {
    for (const std::string& name : names) {
      if (!is_same_name(text, name)) continue;
      text = name;
      return "";
    }
    return fmt::format("{} isn't one of {}", text, fmt::join(names, ", "));
  };
  return {replace, "NAME"};
}

CLI::Validator above_zero() {
  return number_check([](double value) { return value > 0; }, "above 0");
}

CLI::Validator not_negative() {
  return number_check([](double value) { return value >= 0; }, "at least 0");
}

CLI::Validator between(double least, double most) {
  return number_check([=](double value) { return value >= least && value <= most; },
                      fmt::format("{} to {}", least, most));
}

void check_output_folder(const std::string& folder) {
  fs::path nearest = fs::absolute(folder);
  while (!fs::exists(nearest) && nearest.has_relative_path()) nearest = nearest.parent_path();
  if (!fs::is_directory(nearest)) {
    const std::string wrong = nearest == fs::absolute(folder) ? "" : nearest.string() + " ";
    throw InputError::in_file(folder, wrong + "isn't a folder");
  }
  if (::access(nearest.c_str(), W_OK | X_OK) != 0)
    throw InputError::in_file(folder, std::error_code(errno, std::generic_category()).message());
}

void check_output_file(const std::string& file, const std::vector<std::string>& extensions) {
  const std::string extension = detail::lower_case_extension(file);
  if (std::find(extensions.begin(), extensions.end(), extension) == extensions.end())
    throw OptionError(fmt::format("--output: {} should end in {}", file, fmt::join(extensions, ", ")));
  detail::check_place(file);
}

namespace {

bool is_built_in_name(const std::string& input) {
  return input == "teapot" || input == "sphere" || input == "tree";
}

std::optional<PolygonSoup> built_in_model(const std::string& input) {
  if (fs::exists(input)) return {};
  constexpr std::size_t k_sphere_faces = 250'000;
  if (input == "teapot") return make_teapot();
  if (input == "sphere") return make_displaced_sphere(k_sphere_faces, true);
  if (input == "tree") return make_tree();
  return {};
}

}  // namespace

void remark_hidden_model(const std::string& input, const CommonOptions& options) {
  if (!is_built_in_name(input) || !fs::exists(input)) return;
  print_remark(fmt::format("takes {} that is there, and not the built-in model of this name",
                           fs::is_directory(input) ? "the folder " + input : "the file " + input),
               options);
}

Model read_model(const std::string& input, Progress* progress) {
  if (std::optional<PolygonSoup> soup = built_in_model(input))
    return {input, repair_to_polygon_mesh(std::move(*soup))};
  return {fs::path(input).stem().string(), read_mesh(input, progress)};
}

PolygonSoup read_unrepaired(const std::string& input, const CommonOptions& options, Progress* progress) {
  if (fs::exists(input)) {
    ReadSoup read = read_soup_with_pictures(input, progress);
    print_repairs(read.report, options);
    return std::move(read.soup);
  }
  return to_soup(read_model(input, progress).read.mesh);
}

CLI::Option* add_view_options(CLI::App& command, ViewOptions& view, const std::string& group) {
  CLI::Option* eye = command.add_option("--eye", view.eye, "where the camera stands, object units")
                         ->option_text("X Y Z")
                         ->group(group);
  command.add_option("--look-at", view.look_at, "what it looks at (the middle of the model)")
      ->option_text("X Y Z")
      ->group(group);
  add_up_option(command, view.up, group);
  command.add_option("--field-of-view", view.field_of_view, "vertical, degrees (45)")->group(group);
  return eye;
}

void add_up_option(CLI::App& command, std::string& up, const std::string& group) {
  command.add_option("--up", up, "axis that points up in the pictures: x, y (default) or z")
      ->transform(one_of_names({"x", "y", "z"}))
      ->option_text("x|y|z")
      ->group(group);
}

Vec3 up_direction(const std::string& up, const std::string& input) {
  if (up == "x") return Vec3::UnitX();
  if (up == "z" || (up.empty() && input == "teapot" && !fs::exists(input))) return Vec3::UnitZ();
  return Vec3::UnitY();
}

void add_height_map_options(CLI::App& command, HeightMapOptions& options, const std::string& group) {
  command
      .add_option("--displacement-map", options.file, "of a mesh: a grey .png, or an .exr with the channel Y")
      ->option_text("FILE")
      ->group(group);
  command
      .add_option("--displacement-scale", options.heights.scale,
                  "height of the value 1, white in a .png, object units (1)")
      ->group(group);
  command
      .add_option("--displacement-offset", options.heights.offset, "height of the value 0, object units (0)")
      ->group(group);
  command.add_flag("--periodic-map", options.periodic, "the map repeats beyond its border")->group(group);
}

DisplacementMap read_heights(const HeightMapOptions& options) {
  DisplacementMapOptions heights = options.heights;
  heights.border = options.periodic ? MapBorder::periodic : MapBorder::clamped;
  return read_displacement_map(options.file, heights);
}

MeshWithHeights read_mesh_with_heights(const std::string& input, const HeightMapOptions& options,
                                       const CommonOptions& common, Progress* progress) {
  PolygonSoup soup = read_unrepaired(input, common, progress);
  if (soup.n_faces() == 0) throw InputError::in_file(input, "holds no faces");
  if (soup.corner_uvs.empty()) {
    throw InputError::in_file(input, "has no texture coordinates; `recede atlas` makes some");
  }
  return {std::move(soup), read_heights(options)};
}

Vec3 to_vector(const std::array<double, 3>& point) { return {point[0], point[1], point[2]}; }

Camera camera_of(const ViewOptions& view, const std::string& input, std::span<const Vec3> points, int width,
                 int height) {
  const auto vector = [](const std::optional<std::array<double, 3>>& point) {
    return point ? std::optional(to_vector(*point)) : std::nullopt;
  };
  const Camera in_front = camera_in_front(points, up_direction(view.up, input),
                                          view.field_of_view * std::numbers::pi / 180, width, height);
  return place_camera(in_front, points, vector(view.eye), vector(view.look_at));
}

void require_faces(const Model& model, const std::string& input) {
  if (model.read.mesh.n_faces() > 0) return;
  std::string reason = "holds no faces";
  for (const RepairStep& step : model.read.report.steps) {
    if (step.name == "remove_degenerate_faces" && step.changed > 0) {
      reason = "holds no faces after repair: " + step.detail;
    }
  }
  throw InputError::in_file(input, reason);
}

void add_simplify_options(CLI::App& command, SimplifyOptions& options, double& feature_angle) {
  const CLI::Validator cost = one_of<CostPolicy>({{"volume", CostPolicy::volume},
                                                  {"normal_deviation", CostPolicy::normal_deviation},
                                                  {"texture_deviation", CostPolicy::texture_deviation}});
  const CLI::Validator placement = one_of<VertexPlacement>({{"automatic", VertexPlacement::automatic},
                                                            {"half_edge", VertexPlacement::half_edge},
                                                            {"midpoint", VertexPlacement::midpoint},
                                                            {"optimal", VertexPlacement::optimal}});
  const auto group = "Simplification";
  command
      .add_option("--cost", options.cost,
                  "what decides which edge goes: volume (default), normal_deviation or texture_deviation")
      ->transform(cost)
      ->group(group)
      ->option_text("NAME");
  command
      .add_option("--placement", options.placement,
                  "where the vertex of a collapsed edge goes: automatic, half_edge, midpoint or optimal")
      ->transform(placement)
      ->group(group)
      ->option_text("NAME");
  command
      .add_option("--normal-threshold", options.normal_threshold,
                  "normal_deviation: least dot product of normals before and after (0.99)")
      ->group(group);
  command
      .add_option("--candidate-share", options.candidate_share,
                  "normal_deviation: candidates per collapse as a share of all polygons (0.01)")
      ->group(group);
  command.add_option("--seed", options.seed, "normal_deviation: seed of the candidate draws (1)")
      ->group(group);
  command
      .add_option("--feature-angle", feature_angle,
                  "keep edges whose faces meet at more than this angle, degrees; 0: none")
      ->check(between(0.0, 180.0))
      ->group(group);
  command.add_flag("--lock-borders", options.lock_borders, "leave border vertices where they are")
      ->group(group);
  command
      .add_option("--join-distance", options.join_distance,
                  "volume: parts may grow together where they are this near, object units; 0: never")
      ->check(not_negative())
      ->group(group);
  command
      .add_flag("--drop-parts", options.drop_parts,
                "drop parts that are no farther from the rest than the surface is off anyway")
      ->group(group);
  const auto add_switch_off = [&](const char* name, bool& option, const char* help) {
    command
        .add_flag_callback(
            name, [&option] { option = false; }, help)
        ->group(group);
  };
  const auto add_weight = [&](const char* name, double& weight, const char* help) {
    command.add_option(name, weight, help)->check(not_negative())->group(group);
  };
  add_weight("--uv-weight", options.weights.uv,
             "volume: what a change of texture coordinates by 1 costs, as a share of the longest side (0.1)");
  add_weight("--normal-weight", options.weights.normal, "the same for normals (0.003)");
  add_weight("--color-weight", options.weights.color, "the same for vertex colours (0.01)");
  command
      .add_option("--scalar-weight", options.weights.scalars,
                  "the same for a named scalar of the vertices (0); may be repeated")
      ->group(group)
      ->option_text("NAME WEIGHT");
  add_switch_off("--ignore-uv-seams", options.keep_uv_seams, "let texture seams move freely");
  add_switch_off("--ignore-normal-seams", options.keep_normal_seams, "let normal seams move freely");
  add_switch_off("--ignore-polygons", options.keep_polygons,
                 "don't prefer collapses that keep quads and larger polygons");
}

void mark_features(PolygonMesh& mesh, double feature_angle) {
  if (feature_angle > 0) mark_feature_edges(mesh, feature_angle * std::numbers::pi / 180);
}

void print_remark(const std::string& text, const CommonOptions& options) {
  if (!options.quiet) fmt::print(stderr, "recede: {}\n", text);
}

void print_repairs(const RepairReport& report, const CommonOptions& options) {
  for (const RepairStep& step : report.steps) {
    if (step.changed > 0) print_remark(fmt::format("{}: {}", step.name, step.detail), options);
  }
}

void print_missing_pictures(const std::vector<Material>& materials, const CommonOptions& options) {
  std::set<std::string> missing;
  for (const Material& material : materials) {
    if (!material.base_color_picture) missing.insert(material.base_color_texture);
    if (!material.normal_picture) missing.insert(material.normal_texture);
  }
  missing.erase("");
  if (missing.empty()) return;
  print_remark(
      fmt::format("no picture of texture {}, of which only the name is left", fmt::join(missing, ", ")),
      options);
}

Json repairs_to_json(const RepairReport& report) {
  Json steps = Json::array();
  for (const RepairStep& step : report.steps) {
    steps.push_back({{"step", step.name}, {"changed", step.changed}, {"detail", step.detail}});
  }
  return steps;
}

Json refused_to_json(const RefusedCollapses& refused) {
  Json counts;
  for (std::size_t i = 0; i < refused.counts.size(); ++i) {
    counts[std::string(to_string(static_cast<Refusal>(i)))] = refused.counts[i];
  }
  return counts;
}

Json error_to_json(double max, double rms, std::optional<double> bound, double diagonal) {
  const auto share = [&](double length) { return diagonal > 0 ? Json(length / diagonal) : Json(nullptr); };
  return {{"max", max},
          {"rms", rms},
          {"bound", bound ? Json(*bound) : Json(nullptr)},
          {"max_relative", share(max)},
          {"rms_relative", share(rms)},
          {"bound_relative", bound ? share(*bound) : Json(nullptr)}};
}

Json box_to_json(const Box3& box) {
  if (box.isEmpty()) return nullptr;
  const Vec3 low = box.min(), high = box.max();
  return {{"min", {low.x(), low.y(), low.z()}}, {"max", {high.x(), high.y(), high.z()}}};
}

std::string length_text(double length, double diagonal) {
  return diagonal > 0 ? fmt::format("{:.4g} ({:.3g} %)", length, 100 * length / diagonal)
                      : fmt::format("{:.4g}", length);
}

std::string text_of(const Json& document) {
  // Names of files may hold bytes that aren't UTF-8.
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

void print_json(const Json& document) { fmt::print("{}", text_of(document)); }

}  // namespace recede::cli
