// The part of the report that shows the levels: all of them one below the other, or, where scripts run, one
// at a time with a slider.
#include <recede/geometry/detail/base64.h>
#include <recede/render/detail/markup.h>
#include <recede/render/detail/report_content.h>

#include <fmt/format.h>

#include <algorithm>

namespace recede::detail {

namespace {

// Without angle brackets, so that it is markup like the rest.
constexpr std::string_view k_script = R"(
(function () {
  "use strict";
  var bar = document.getElementById("slider"), range = document.getElementById("level"),
      all = document.getElementById("all-levels"), shown = document.getElementById("shown-level");
  var levels = Array.from(document.querySelectorAll("section.level"));
  function show() {
    var chosen = levels[range.valueAsNumber].querySelector("h3").textContent;
    levels.forEach(function (level, i) { level.hidden = !all.checked && i !== range.valueAsNumber; });
    range.disabled = all.checked;
    range.setAttribute("aria-valuetext", chosen);
    shown.textContent = all.checked ? "All levels" : chosen;
  }
  function follow_link() {
    var i = levels.findIndex(function (level) { return "#" + level.id === location.hash; });
    if (i === -1) return;
    range.value = i;
    show();
    levels[i].scrollIntoView();
  }
  range.addEventListener("input", show);
  all.addEventListener("change", show);
  window.addEventListener("hashchange", follow_link);
  bar.hidden = false;
  show();
  follow_link();
})();
)";

constexpr unsigned k_picture_background = 0xe3e7ec;  // that of `RenderOptions`

// Starts at the finest level that isn't the input.
std::string slider(std::size_t levels) {
  return fmt::format(
      "<div class=\"slider\" id=\"slider\" hidden>\n<label for=\"level\">Level</label>\n"
      "<input type=\"range\" id=\"level\" min=\"0\" max=\"{}\" step=\"1\" value=\"1\" "
      "autocomplete=\"off\">\n"
      "<output id=\"shown-level\" for=\"level\"></output>\n"
      "<label><input type=\"checkbox\" id=\"all-levels\" autocomplete=\"off\"> all levels</label>\n</div>\n",
      levels - 1);
}

// Small pictures are enlarged by a whole factor, so that every pixel of the camera stays a square.
int enlargement(const Image& image) {
  constexpr int k_wanted = 420;
  return std::max(1, k_wanted / std::max(image.width, image.height));
}

std::string image_tag(const Image& image, const std::string& alternative, int factor = 1) {
  return fmt::format(
      "<img class=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\" src=\"data:image/png;base64,{}\">",
      factor > 1 ? "enlarged" : "plain", image.width * factor, image.height * factor,
      escape_markup(alternative), encode_base64(encode_png(image)));
}

// In a square of the same size for all levels, so that nothing jumps when the slider moves.
std::string shot(const std::string& tag, const std::string& caption,
                 unsigned background = k_picture_background) {
  return fmt::format(
      "<figure class=\"shot\"><div class=\"frame\" style=\"background: #{:06x}\">{}</div>"
      "<figcaption>{}</figcaption></figure>\n",
      background, tag, caption);
}

std::string heat_scale() {
  std::string stops;
  for (const unsigned color : heat_map_colors()) stops += fmt::format(", #{:06x}", color);
  return fmt::format(
      "<div class=\"scale\" style=\"background: linear-gradient(to right{})\"></div>"
      "<div class=\"ends\"><span>0</span><span>{:g}</span></div>",
      stops, k_heat_map_scale);
}

std::string size_note(const SwitchView& view, int factor) {
  const std::string size =
      fmt::format("{} × {} pixels", view.difference.magnitudes.width, view.difference.magnitudes.height);
  if (view.shrink_factor > 1) return size + fmt::format(", shown {} times smaller", view.shrink_factor);
  return factor > 1 ? size + fmt::format(", shown {} times larger", factor) : size;
}

std::string switch_shot(const SwitchView& view, std::size_t index) {
  const int factor = enlargement(view.level);
  const std::string cut =
      view.sphere_fits ? "" : " The image's middle: the model's sphere is larger than the image.";
  return shot(image_tag(view.level, fmt::format("Level {} at its switch distance", index), factor),
              fmt::format("Level {} at its switch distance. {}.{}", index, size_note(view, factor), cut));
}

std::string comparison_shots(const SwitchView& view) {
  const int factor = enlargement(view.level);
  const ImageDifference& difference = view.difference;
  return shot(image_tag(view.original, "The original from the same camera", factor),
              "The original from the same camera.") +
         shot(image_tag(view.heat, "Difference of both pictures", factor),
              heat_scale() + fmt::format("Difference: RMSE {}, largest {}, {} of pixels above 1/255.",
                                         short_number(difference.rmse), short_number(difference.max),
                                         percent(difference.changed_share)),
              heat_map_colors().front());
}

std::string map_caption(const MapPicture& picture, const BakedMaps& maps) {
  const std::string size = fmt::format("{0}, {1} × {1} texels", picture.name, maps.size);
  if (picture.name != "Displacement") return size + ".";
  return size + fmt::format(": black {}, white {} object units along the normal.",
                            short_number(maps.height_offset),
                            short_number(maps.height_offset + maps.height_scale));
}

std::string map_shots(const MapContent& content, const BakedMaps& maps, std::size_t index) {
  std::string html;
  if (content.close_up) {
    const bool normals = !maps.normal.samples.empty();
    const std::string_view with = maps.displacement.samples.empty() ? "normals"
                                  : normals                         ? "displacement and normals"
                                                                    : "displacement";
    html += shot(image_tag(*content.close_up, fmt::format("Level {} with its maps", index)),
                 fmt::format("Level {} from near, with its maps of {}.", index, with));
  }
  html += "<div class=\"maps\">\n";
  for (const MapPicture& picture : content.pictures) {
    html += fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n",
                        image_tag(picture.image, fmt::format("{} of level {}", picture.name, index)),
                        map_caption(picture, maps));
  }
  return html + "</div>\n";
}

std::string fact(std::string_view name, const std::string& value, const std::string& second_line = "") {
  const std::string small = second_line.empty() ? "" : "<small>" + second_line + "</small>";
  return fmt::format("<dt>{}</dt><dd>{}{}</dd>\n", name, value, small);
}

std::string map_facts(const LodLevel& level, double diagonal) {
  const MapReport& report = level.maps->report;
  std::string facts;
  if (const auto& accuracy = level.map_accuracy) {
    facts += fact("Max with maps", short_number(accuracy->max), percent(accuracy->max / diagonal));
    facts += fact("RMS with maps", short_number(accuracy->rms), percent(accuracy->rms / diagonal));
    facts += fact("Seam difference", short_number(report.seam_difference),
                  percent(report.seam_difference / diagonal));
  }
  facts += fact("Missed texels", grouped(report.missed), "of " + grouped(report.texels));
  return facts + fact("Atlas", report.atlas_reason.empty() ? "the original's" : "new",
                      escape_markup(report.atlas_reason));
}

std::string level_facts(const ReportContent& content, std::size_t index) {
  const LodLevel& level = content.hierarchy.levels[index];
  std::string facts = fact("Faces", grouped(content.levels[index].summary.faces)) +
                      fact("Vertices", grouped(content.levels[index].summary.vertices));
  if (index == 0 && !is_of_cad(content)) return facts;
  const auto error = [&](std::string_view name, double value) {
    return fact(name, short_number(value), percent(value / content.diagonal));
  };
  facts += error("Max error", level.error.max) + error("RMS error", level.error.rms) +
           error("Bound", level.error.bound) + fact("Switch distance", short_number(level.switch_distance));
  return level.maps ? facts + map_facts(level, content.diagonal) : facts;
}

std::string level_section(const ReportContent& content, std::size_t index) {
  const LodLevel& level = content.hierarchy.levels[index];
  const LevelContent& drawn = content.levels[index];
  const std::string bound = fmt::format("off by {} {} object units", level.billboards ? "about" : "at most",
                                        short_number(level.error.bound));
  const std::string serves =
      index > 0 ? fmt::format("Serves from distance {} on; {}.", short_number(level.switch_distance), bound)
      : is_of_cad(content) ? fmt::format("The finest level; {}.", bound)
                           : "The input.";
  std::string html = fmt::format(
      "<section class=\"level\" id=\"level-{0}\"><div><h3>Level {0}: {1} faces</h3>\n"
      "<p class=\"faint\">{2}</p>\n<dl>\n{3}</dl></div>\n<div class=\"pictures\">\n",
      index, grouped(drawn.summary.faces), serves, level_facts(content, index));
  if (drawn.at_switch) html += switch_shot(*drawn.at_switch, index);
  html += shot(image_tag(drawn.close_up, fmt::format("Level {} from near", index)),
               fmt::format("Level {} from near{}.", index,
                           level.billboards ? ", as billboards" : ", with the polygons' sides"));
  if (drawn.at_switch) html += comparison_shots(*drawn.at_switch);
  if (drawn.maps) html += map_shots(*drawn.maps, level.maps.value(), index);
  return html + "</div>\n</section>\n";
}

}  // namespace

bool has_maps(const ReportContent& content) {
  return std::any_of(content.levels.begin(), content.levels.end(),
                     [](const LevelContent& level) { return level.maps.has_value(); });
}

std::string level_sections(const ReportContent& content) {
  const std::size_t count = content.levels.size();
  std::string html = "<div>\n<h2>Level by level</h2>\n";
  if (count > 1) html += slider(count);
  for (std::size_t i = 0; i < count; ++i) html += level_section(content, i);
  html += "</div>\n";
  return count > 1 ? html + "<script>" + std::string(k_script) + "</script>\n" : html;
}

}  // namespace recede::detail
