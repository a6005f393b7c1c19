// What a report says, before it becomes HTML and JSON.
#pragma once

#include <recede/lod/lod_hierarchy.h>
#include <recede/render/image_difference.h>
#include <recede/render/report.h>

#include <optional>
#include <string>
#include <vector>

namespace recede::detail {

/// A level and the original from where the level begins to serve.
struct SwitchView {
  ImageDifference difference;   ///< its `magnitudes` are dropped once the heat map is drawn
  Image level, original, heat;  ///< for showing: shrunk by `shrink_factor`
  int shrink_factor = 1;
  int samples_per_pixel = 0;
  double camera_distance = 0;  ///< to the center of the bounding sphere, object units
  bool sphere_fits = true;     ///< false: the bounding sphere is larger than the image
};

/// A map of a level for showing.
struct MapPicture {
  std::string name;  ///< "Displacement", "Normals" or "Colours"
  Image image;       ///< shrunk to `k_map_side` pixels a side or a little less
};

/// The maps of a level, for showing.
struct MapContent {
  /// The level with its displacement and normals by the camera of its own picture, unless it has colours
  /// only.
  std::optional<Image> close_up;
  std::vector<MapPicture> pictures;
};

struct LevelContent {
  MeshSummary summary;
  Image close_up;  ///< with the polygons' sides
  std::optional<SwitchView> at_switch;
  std::optional<MapContent> maps;
};

/// A level as the viewer takes it.
struct ViewerLevel {
  std::size_t triangles = 0, vertices = 0;
  double largest_distance = 0;  ///< of a vertex to the input, object units
  std::string data;             ///< see `pack`; empty: the viewer doesn't show this level
  std::size_t billboards = 0;   ///< which it is made of, with these PNG files in base64:
  std::string color, normal;
  std::string left_out;  ///< why it doesn't
};

struct ViewerContent {
  Box3 box;   ///< of all levels that are shown
  Box3 seen;  ///< without the empty corners of billboards, unless there is nothing else
  std::vector<ViewerLevel> levels;
};

struct ReportContent {
  const LodHierarchy& hierarchy;
  const HierarchyFiles& files;
  const ReportOptions& options;
  double diagonal = 0;  ///< of level 0's box
  std::vector<LevelContent> levels;
  ViewerContent viewer;
};

/// Difference that heat maps show in their lightest colour, the same for all levels so that they can be
/// compared.
inline constexpr double k_heat_map_scale = 0.25;

/// Maps are shown no larger: normal maps hardly compress, and the report is one file.
inline constexpr int k_map_side = 256;

/// Levels of at most `limit` triangles, and none where the library has no viewer.
ViewerContent pack_levels(const LodHierarchy& hierarchy, std::size_t limit, Progress* progress);

/// Whether the viewer shows any level.
bool has_viewer(const ReportContent& content);

/// The levels in three dimensions, or a line that says why they can't be seen.
std::string viewer_section(const ReportContent& content);

/// Whether level 0 has an error as well: there are no triangles that it could be the same as.
inline bool is_of_cad(const ReportContent& content) { return !content.options.patches.empty(); }

/// Whether any level has maps.
bool has_maps(const ReportContent& content);

/// Errors and seconds against faces; empty for a single level.
std::string plots(const ReportContent& content);

/// The slider over the levels, and a section for each with its figures and pictures.
std::string level_sections(const ReportContent& content);

std::string report_html(const ReportContent& content);
std::string report_json(const ReportContent& content);

}  // namespace recede::detail
