#include <recede/render/detail/report_content.h>

#include <nlohmann/json.hpp>

namespace recede::detail {

namespace {

using Json = nlohmann::ordered_json;

Json as_list(const Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json error_fields(const LevelError& error, double diagonal) {
  return {{"max", error.max},
          {"rms", error.rms},
          {"bound", error.bound},
          {"max_relative", error.max / diagonal},
          {"rms_relative", error.rms / diagonal},
          {"bound_relative", error.bound / diagonal}};
}

Json difference_fields(const SwitchView& view) {
  return {{"rmse", view.difference.rmse},
          {"max", view.difference.max},
          {"changed_share", view.difference.changed_share},
          {"width", view.difference.magnitudes.width},
          {"height", view.difference.magnitudes.height},
          {"samples_per_pixel", view.samples_per_pixel},
          {"camera_distance", view.camera_distance}};
}

Json map_fields(const ReportContent& content, std::size_t index) {
  const LodLevel& level = content.hierarchy.levels[index];
  if (!level.maps) return nullptr;
  const MapReport& report = level.maps->report;
  const auto& accuracy = level.map_accuracy;
  return {{"size", level.maps->size},
          {"max", accuracy ? Json(accuracy->max) : Json()},
          {"rms", accuracy ? Json(accuracy->rms) : Json()},
          {"seam_difference", report.seam_difference},
          {"texels", report.texels},
          {"missed", report.missed},
          {"search_distance", report.search_distance},
          {"atlas_reason", report.atlas_reason},
          {"seconds", report.seconds}};
}

Json viewer_fields(const ViewerLevel& level) {
  if (level.data.empty()) return nullptr;
  return {{"triangles", level.triangles}, {"largest_distance", level.largest_distance}};
}

Json level_fields(const ReportContent& content, std::size_t index) {
  const LodLevel& level = content.hierarchy.levels[index];
  const LevelContent& drawn = content.levels[index];
  return {{"level", index},
          {"file", content.files.level_files[index].filename().string()},
          {"bytes", content.files.level_bytes[index]},
          {"faces", drawn.summary.faces},
          {"triangles", drawn.summary.triangles},
          {"quads", drawn.summary.quads},
          {"larger_polygons", drawn.summary.larger_polygons},
          {"vertices", drawn.summary.vertices},
          {"error", error_fields(level.error, content.diagonal)},
          {"switch_distance", level.switch_distance},
          {"screen_coverage", level.screen_coverage},
          {"seconds", {{"simplify", level.simplify_seconds}, {"measure", level.measure_seconds}}},
          {"stop_reason", level.stop_reason},
          {"image_difference", drawn.at_switch ? difference_fields(*drawn.at_switch) : Json()},
          {"maps", map_fields(content, index)},
          {"patches", content.options.patches.empty() ? Json() : Json(content.options.patches[index])},
          {"viewer", viewer_fields(content.viewer.levels[index])}};
}

}  // namespace

std::string report_json(const ReportContent& content) {
  const LodHierarchy& hierarchy = content.hierarchy;
  Json report{{"name", hierarchy.name},
              {"diagonal", content.diagonal},
              {"center", as_list(hierarchy.center)},
              {"radius", hierarchy.radius},
              {"glb", content.files.glb.filename().string()},
              {"view",
               {{"image_height", hierarchy.view.image_height},
                {"field_of_view", hierarchy.view.field_of_view},
                {"pixel_error", hierarchy.view.pixel_error},
                {"up", as_list(content.options.up)}}},
              {"levels", Json::array()}};
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i)
    report["levels"].push_back(level_fields(content, i));
  // Names come from files and may hold bytes that aren't UTF-8; those become the replacement character.
  return report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace recede::detail
