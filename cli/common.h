// What the commands share: options, reading a model, and printing.
#pragma once

#include "terminal_progress.h"
#include <recede/geometry/displacement_map.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/simplify.h>
#include <recede/render/camera.h>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace recede::cli {

using Json = nlohmann::ordered_json;

/// Options of every command.
struct CommonOptions {
  bool json = false;   ///< one JSON document on standard output instead of text
  bool quiet = false;  ///< no progress and no remarks
  int threads = 0;     ///< 0: all
};
void add_common_options(CLI::App& command, CommonOptions& options);

/// A model by file name, or one of the built-in ones, `teapot`, `sphere` and `tree`.
struct Model {
  std::string name;  ///< for files made from it
  MeshFromSoup read;
};
Model read_model(const std::string& input, Progress* progress);
/// Throws `InputError` for a model without faces, with which nothing can be done.
void require_faces(const Model& model, const std::string& input);
inline constexpr const char* k_input_help =
    "mesh file (.obj .ply .stl .off .gltf .glb), or a built-in model: teapot, sphere, tree";

/// Whether two names of a choice are the same; hyphens and underscores are alike.
bool is_same_name(const std::string& a, const std::string& b);

/// Turns a name into its number. CLI11's own transformers also take the numbers, and list them when they
/// complain.
template <typename Value>
CLI::Validator one_of(std::vector<std::pair<std::string, Value>> names) {
  const auto replace = [names](std::string& text) -> std::string {
    std::string known;
    for (const auto& [name, value] : names) {
      if (is_same_name(text, name)) {
        text = std::to_string(static_cast<int>(value));
        return "";
      }
      known += (known.empty() ? "" : ", ") + name;
    }
    return fmt::format("{} isn't one of {}", text, known);
  };
  return {replace, "NAME"};
}
/// The name as it stands here.
CLI::Validator one_of_names(std::vector<std::string> names);

// Numbers out of range are refused in words: CLI11's own validators print their limits with all digits.
CLI::Validator above_zero();
CLI::Validator not_negative();
CLI::Validator between(double least, double most);

// Before any work: whether a folder, or a file with one of these extensions, can be written there. Throw
// `InputError`, `check_output_file` also `OptionError` for another extension.
void check_output_folder(const std::string& folder);
void check_output_file(const std::string& file, const std::vector<std::string>& extensions);

/// What the file holds, with nothing repaired; a built-in model else. Says what is left aside.
PolygonSoup read_unrepaired(const std::string& input, const CommonOptions& options, Progress* progress);

/// Where a camera stands and what it looks at.
struct ViewOptions {
  std::optional<std::array<double, 3>> eye, look_at;  ///< object units
  std::string up;                                     ///< x, y or z; empty: see `up_direction`
  double field_of_view = 45;                          ///< vertical, degrees
};
/// Adds `--eye`, which it returns, `--look-at`, `--up` and `--field-of-view`.
CLI::Option* add_view_options(CLI::App& command, ViewOptions& view, const std::string& group);
void add_up_option(CLI::App& command, std::string& up, const std::string& group);
/// Unset: y, but z for the built-in teapot, which stands upright along it as its author made it.
Vec3 up_direction(const std::string& up, const std::string& input);
Vec3 to_vector(const std::array<double, 3>& point);
/// Where it was asked to stand, or where all points are seen from in front.
Camera camera_of(const ViewOptions& view, const std::string& input, std::span<const Vec3> points, int width,
                 int height);

/// Heights of a mesh that has none of its own.
struct HeightMapOptions {
  std::string file;  ///< empty: none
  DisplacementMapOptions heights;
  bool periodic = false;
};
/// Adds `--displacement-map`, `--displacement-scale`, `--displacement-offset` and `--periodic-map`.
void add_height_map_options(CLI::App& command, HeightMapOptions& options, const std::string& group);
/// A mesh with texture coordinates, and the heights over it.
struct MeshWithHeights {
  PolygonSoup base;
  DisplacementMap map;
};
DisplacementMap read_heights(const HeightMapOptions& options);
MeshWithHeights read_mesh_with_heights(const std::string& input, const HeightMapOptions& options,
                                       const CommonOptions& common, Progress* progress);

/// How to simplify, without the target.
void add_simplify_options(CLI::App& command, SimplifyOptions& options, double& feature_angle);
/// Marks the edges that `--feature-angle` (degrees) asks to keep; nothing when it is 0.
void mark_features(PolygonMesh& mesh, double feature_angle);

/// Prints what reading changed, a line for each step that changed something.
void print_repairs(const RepairReport& report, const CommonOptions& options);
/// Says so when a file or folder has the name of a built-in model, and stands for that.
void remark_hidden_model(const std::string& input, const CommonOptions& options);
/// Says which textures have no pictures.
void print_missing_pictures(const std::vector<Material>& materials, const CommonOptions& options);
/// A remark on standard error.
void print_remark(const std::string& text, const CommonOptions& options);

Json repairs_to_json(const RepairReport& report);
Json refused_to_json(const RefusedCollapses& refused);
/// Fields `max`, `rms`, `bound` (null: not computed) and their shares of the diagonal.
Json error_to_json(double max, double rms, std::optional<double> bound, double diagonal);

/// Corners `min` and `max`; null without points.
Json box_to_json(const Box3& box);

/// A length with its share of the diagonal: `0.00123 (0.042 %)`.
std::string length_text(double length, double diagonal);

/// The document in lines; bytes that aren't UTF-8 become the replacement character.
std::string text_of(const Json& document);
/// Prints it.
void print_json(const Json& document);

// The commands. Each adds itself to the application; its callback does the work.
void add_atlas_command(CLI::App& app);
void add_billboards_command(CLI::App& app);
void add_bake_command(CLI::App& app);
void add_batch_command(CLI::App& app);
void add_simplify_command(CLI::App& app);
void add_carve_command(CLI::App& app);
void add_compare_command(CLI::App& app);
void add_info_command(CLI::App& app);
void add_progressive_command(CLI::App& app);
void add_extract_command(CLI::App& app);
void add_render_command(CLI::App& app);
void add_turntable_command(CLI::App& app);
void add_diff_command(CLI::App& app);
void add_dice_command(CLI::App& app);
void add_shell_command(CLI::App& app);
void add_subdivide_command(CLI::App& app);
void add_seams_command(CLI::App& app);
void add_walk_command(CLI::App& app);

}  // namespace recede::cli
