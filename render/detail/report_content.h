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

struct LevelContent {
  MeshSummary summary;
  Image close_up;  ///< with the polygons' sides
  std::optional<SwitchView> at_switch;
};

struct ReportContent {
  const LodHierarchy& hierarchy;
  const HierarchyFiles& files;
  const ReportOptions& options;
  double diagonal = 0;  ///< of level 0's box
  std::vector<LevelContent> levels;
};

/// Difference that heat maps show in their lightest colour, the same for all levels so that they can be
/// compared.
inline constexpr double k_heat_map_scale = 0.25;

std::string report_html(const ReportContent& content);
std::string report_json(const ReportContent& content);

}  // namespace recede::detail
