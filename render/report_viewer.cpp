// The part of the report that shows the levels in three dimensions.
#include <recede/geometry/detail/base64.h>
#include <recede/render/camera.h>
#include <recede/render/detail/markup.h>
#include <recede/render/detail/report_content.h>
#include <recede/render/detail/viewer_mesh.h>
#include <recede/render/detail/viewer_program.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace recede::detail {

namespace {

using Json = nlohmann::ordered_json;

// Without angle brackets, so that it is markup like the rest.
constexpr std::string_view k_script = R"(
(function () {
  "use strict";
  var absent = document.getElementById("viewer-absent");
  function fail(error) { absent.hidden = false; absent.textContent = "The viewer doesn't run here: " + error.message; }
  if (!window.DecompressionStream) {
    absent.textContent = "The viewer needs a browser of 2023 or later.";
    return;
  }
  absent.textContent = "The viewer is being unpacked.";
  var packed = Uint8Array.from(atob(document.getElementById("viewer-program").textContent), function (c) {
    return c.charCodeAt(0);
  });
  new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))).text().then(function (text) {
    var script = document.createElement("script");
    script.textContent = text;
    document.body.append(script);
  }).catch(fail);
})();
)";

constexpr std::string_view k_controls = R"(<div id="viewer" class="viewer" hidden>
<div class="controls">
<label for="viewer-level">Level</label><input type="range" id="viewer-level" autocomplete="off">
<output id="viewer-shown" for="viewer-level"></output>
<label for="viewer-distance">Distance</label><input type="range" id="viewer-distance" autocomplete="off">
<output id="viewer-at" for="viewer-distance"></output>
</div>
<div class="choices">
<label><input type="checkbox" id="viewer-follow" autocomplete="off" checked> level by distance</label>
<label><input type="checkbox" id="viewer-size" autocomplete="off"> true size</label>
<label><input type="checkbox" id="viewer-wireframe" autocomplete="off"> wireframe</label>
<label><input type="checkbox" id="viewer-error" autocomplete="off"> colour by error</label>
<label><input type="checkbox" id="viewer-beside" autocomplete="off"> reference beside</label>
<button type="button" id="viewer-reset">Reset view</button>
</div>
<div class="canvas" id="viewer-frame"><canvas id="viewer-canvas" tabindex="0" role="application" aria-label="The model"
aria-describedby="viewer-help"></canvas></div>
<div class="below-canvas" id="viewer-below" hidden><span id="viewer-left"></span><span id="viewer-right"></span></div>
<div id="viewer-legend" hidden><div class="scale" id="viewer-scale"></div>
<div class="ends"><span>0</span><span id="viewer-most"></span></div>
<p class="faint">Distance of each vertex to level 0; between vertices it may be larger. The scale is that of the level.</p></div>
<p class="faint" id="viewer-help">Drag or use the arrow keys to turn, with Shift or two fingers to move; pinch, the wheel (after a click)
or + and - to zoom; 0 resets. True size: the pixels that the view of the switch distances has from there.</p>
</div>
)";

// Why a level isn't in the viewer; empty: it is.
std::string left_out_because(const LodLevel& level, std::size_t triangles, std::size_t limit) {
  constexpr std::size_t k_most_texels = std::size_t{1} << 22;  // some 10 MB in the page
  if (level.billboards && level.billboards->is_impostor) return "an impostor";
  if (level.billboards && level.billboards->bytes() / 8 > k_most_texels)
    return fmt::format("textures of more than {} texels", grouped(k_most_texels));
  if (triangles == 0) return "no triangles";
  if (triangles > limit) return fmt::format("{} triangles, more than {}", grouped(triangles), grouped(limit));
  return "";
}

std::size_t count_triangles(const PolygonMesh& mesh) {
  std::size_t triangles = 0;
  for (const auto face : mesh.faces()) triangles += mesh.valence(face) - 2;
  return triangles;
}

Json as_list(const Vec3& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json level_fields(const ReportContent& content, std::size_t index) {
  const LodLevel& level = content.hierarchy.levels[index];
  const ViewerLevel& packed = content.viewer.levels[index];
  Json fields{{"level", index}, {"switch_distance", level.switch_distance}};
  if (packed.data.empty()) return fields;
  fields.update({{"triangles", packed.triangles},
                 {"vertices", packed.vertices},
                 {"largest_distance", packed.largest_distance},
                 {"data", packed.data}});
  if (packed.billboards > 0)
    fields.update({{"billboards", packed.billboards}, {"color", packed.color}, {"normal", packed.normal}});
  return fields;
}

// Numbers, base64 and plain words only, so that it is markup as it is.
std::string data_for_script(const ReportContent& content) {
  const LodHierarchy& hierarchy = content.hierarchy;
  Json data{{"box", {as_list(content.viewer.box.min()), as_list(content.viewer.box.max())}},
            {"seen", {as_list(content.viewer.seen.min()), as_list(content.viewer.seen.max())}},
            {"center", as_list(hierarchy.center)},
            {"radius", hierarchy.radius},
            {"diagonal", content.diagonal},
            {"up", as_list(content.options.up)},
            {"from", as_list(view_from_front(content.options.up))},
            {"image_height", hierarchy.view.image_height},
            {"field_of_view", hierarchy.view.field_of_view},
            {"reference", is_of_cad(content) ? "the finest level" : "the input"},
            {"levels", Json::array()}};
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i)
    data["levels"].push_back(level_fields(content, i));
  return data.dump();
}

ViewerLevel pack_level(const LodLevel& level, const Box3& box, const ClosestPointTree& input) {
  ViewerLevel packed;
  const ViewerMesh mesh = viewer_mesh(level.billboards ? quads_of(*level.billboards) : to_soup(level.mesh),
                                      box, input, level.billboards.has_value());
  packed.triangles = mesh.indices.size() / 3;
  packed.vertices = mesh.distances.size();
  packed.largest_distance = mesh.largest_distance;
  packed.data = pack(mesh);
  if (level.billboards) {
    packed.billboards = level.billboards->billboards.size();
    packed.color = encode_base64(encode_png(level.billboards->color));
    packed.normal = encode_base64(encode_png(level.billboards->normal));
  }
  return packed;
}

std::string left_out_line(const std::vector<ViewerLevel>& levels) {
  std::string line;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    if (!levels[i].left_out.empty())
      line +=
          fmt::format("{}level {} ({})", line.empty() ? "Not in the viewer: " : ", ", i, levels[i].left_out);
  }
  return line.empty() ? "" : "<p class=\"faint below\">" + line + ".</p>\n";
}

}  // namespace

ViewerContent pack_levels(const LodHierarchy& hierarchy, std::size_t limit, Progress* progress) {
  const std::size_t count = hierarchy.levels.size();
  ViewerContent content;
  content.levels.resize(count);
  if (viewer_program().empty()) return content;
  bool any = false;
  for (std::size_t i = 0; i < count; ++i) {
    const LodLevel& level = hierarchy.levels[i];
    ViewerLevel& packed = content.levels[i];
    packed.triangles = count_triangles(level.mesh);
    packed.left_out = left_out_because(level, packed.triangles, limit);
    if (!packed.left_out.empty()) continue;
    any = true;
    for (const auto vertex : level.mesh.vertices()) {
      content.box.extend(level.mesh.point(vertex));
      if (!level.billboards) content.seen.extend(level.mesh.point(vertex));
    }
  }
  if (!any) return content;
  if (content.seen.isEmpty()) content.seen = content.box;
  const PolygonSoup input = to_soup(hierarchy.levels[0].mesh);
  const ClosestPointTree tree(input.positions, triangulate(input));
  for (std::size_t i = 0; i < count; ++i) {
    report_progress(progress, "pack levels", static_cast<double>(i) / static_cast<double>(count));
    ViewerLevel& packed = content.levels[i];
    if (!packed.left_out.empty()) continue;
    packed = pack_level(hierarchy.levels[i], content.box, tree);
  }
  return content;
}

bool has_viewer(const ReportContent& content) {
  return std::any_of(content.viewer.levels.begin(), content.viewer.levels.end(),
                     [](const ViewerLevel& level) { return !level.data.empty(); });
}

std::string viewer_section(const ReportContent& content) {
  if (content.options.viewer_triangles == 0) return "";
  const std::vector<ViewerLevel>& levels = content.viewer.levels;
  std::string html = "<h2>The model</h2>\n";
  if (viewer_program().empty()) {
    return html +
           "<p class=\"faint\" id=\"viewer-absent\">There is no viewer here: Recede was built without "
           "it.</p>\n";
  }
  if (!has_viewer(content)) return html + left_out_line(levels);
  html += "<p class=\"faint\" id=\"viewer-absent\">The viewer needs scripts, which don't run here.</p>\n";
  html += std::string(k_controls) + left_out_line(levels);
  html += "<script type=\"application/json\" id=\"viewer-data\">" + data_for_script(content) + "</script>\n";
  html += fmt::format("<script type=\"text/plain\" id=\"viewer-program\">{}</script>\n", viewer_program());
  return html + fmt::format("<script>{}</script>\n", k_script);
}

}  // namespace recede::detail
