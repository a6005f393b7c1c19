#include <recede/render/detail/markup.h>
#include <recede/render/detail/report_content.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::detail {

namespace {

constexpr std::string_view k_style = R"(
:root { color-scheme: light dark; --page: #fbfbfa; --ink: #20242a; --faint: #666d77; --line: #d9dce1; --raised: #fff; }
@media (prefers-color-scheme: dark) {
  :root { --page: #16181c; --ink: #e4e6ea; --faint: #9aa1ac; --line: #343941; --raised: #1e2126; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 24px 20px 60px; max-width: 1240px; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, sans-serif; }
h1 { font-size: 26px; margin: 0 0 4px; overflow-wrap: anywhere; }
h2 { font-size: 19px; margin: 40px 0 10px; }
h3 { font-size: 16px; margin: 0 0 2px; }
p { margin: 0 0 8px; max-width: 75ch; }
.faint, figcaption, th small { color: var(--faint); }
.below { margin: 8px 0 20px; }
.wide { overflow-x: auto; border: 1px solid var(--line); border-radius: 8px; background: var(--raised); }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; font-variant-numeric: tabular-nums; }
th, td { padding: 6px 9px; text-align: right; white-space: nowrap; vertical-align: top; }
td:last-child { white-space: normal; min-width: 9ch; }
th { font-weight: 600; line-height: 1.25; }
th small { display: block; font-weight: 400; }
thead { border-bottom: 1px solid var(--line); }
tbody tr + tr { border-top: 1px solid var(--line); }
td small { display: block; color: var(--faint); font-size: 12px; }
td.text, th.text { text-align: left; }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 420px), 1fr)); gap: 14px; }
.plot, .level { border: 1px solid var(--line); border-radius: 8px; background: var(--raised); padding: 14px; }
.plots svg { display: block; width: 100%; overflow: visible; }
.plots .tip rect { fill: var(--page); stroke: var(--faint); }
.plots .tip circle { fill: none; stroke: currentColor; stroke-width: 2; }
.plots .tip { pointer-events: none; }
.spoken { position: absolute; width: 1px; height: 1px; overflow: hidden; clip-path: inset(50%); white-space: nowrap; }
.slider { position: sticky; top: 0; z-index: 1; display: flex; flex-wrap: wrap; align-items: center; gap: 6px 14px;
  margin: 0 0 14px; padding: 10px 14px; border: 1px solid var(--line); border-radius: 8px; background: var(--raised); }
.slider input[type=range] { flex: 1 1 240px; accent-color: #2f6fb3; }
.slider output { flex: 0 1 auto; min-width: 24ch; font-variant-numeric: tabular-nums; }
.viewer { border: 1px solid var(--line); border-radius: 8px; background: var(--raised); padding: 14px; }
.controls { display: grid; grid-template-columns: max-content minmax(80px, 1fr) minmax(0, 36ch); gap: 8px 14px;
  align-items: center; font-variant-numeric: tabular-nums; }
.controls input, .choices input { accent-color: #2f6fb3; }
.choices { display: flex; flex-wrap: wrap; gap: 8px 18px; align-items: center; margin: 10px 0 12px; }
.viewer button { font: inherit; color: inherit; background: none; border: 1px solid var(--faint); border-radius: 6px;
  padding: 2px 10px; cursor: pointer; }
.viewer :focus-visible, .plot :focus-visible { outline: 2px solid #2f7fd6; outline-offset: 2px; }
.canvas { position: relative; aspect-ratio: 16 / 9; max-height: 75vh; border-radius: 4px; }
.canvas canvas { display: block; width: 100%; height: 100%; border-radius: 4px; touch-action: none; cursor: grab; }
.canvas.beside::after { content: ""; position: absolute; inset: 0 auto 0 50%; border-left: 1px solid #666d77; }
.below-canvas { display: grid; grid-template-columns: 1fr 1fr; margin: 6px 0 0; text-align: center; font-size: 12.5px; }
#viewer-legend { max-width: 480px; margin: 10px 0; font-size: 12.5px; }
#viewer-help { margin: 8px 0 0; font-size: 12.5px; }
@media screen { [hidden] { display: none !important; } }
@media print { .slider, .viewer { display: none; } }
.level { display: grid; grid-template-columns: minmax(220px, 1fr) minmax(0, 868px); gap: 18px; margin: 0 0 14px;
  scroll-margin-top: 64px; }
.level dl { display: grid; margin-top: 10px; font-variant-numeric: tabular-nums; }
.level dd small { display: block; color: var(--faint); font-size: 12px; }
.pictures { display: flex; flex-wrap: wrap; gap: 14px; align-items: flex-start; align-content: flex-start; }
figure { margin: 0; max-width: 100%; }
.shot { width: 420px; }
.maps { display: grid; grid-template-columns: 1fr 1fr; gap: 14px; width: 420px; max-width: 100%; }
.maps img { width: 100%; }
.frame { display: grid; place-items: center; aspect-ratio: 1; border-radius: 4px; overflow: hidden; }
a { color: inherit; }
figure img { display: block; max-width: 100%; height: auto; border-radius: 4px; }
img.enlarged { image-rendering: pixelated; }
figcaption { font-size: 12.5px; line-height: 1.35; margin-top: 5px; contain: inline-size; }
.scale { height: 10px; border-radius: 3px; margin-top: 8px; }
.ends { display: flex; justify-content: space-between; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 5px 16px; margin: 0; font-size: 14px; }
dt { font-weight: 600; }
dd { margin: 0; max-width: 80ch; }
@media (max-width: 560px) {
  .controls { grid-template-columns: max-content minmax(0, 1fr); }
  .controls output { grid-column: 1 / -1; }
  .canvas { aspect-ratio: 1; }
  .canvas.beside { aspect-ratio: 1 / 2; max-height: none; }
  .canvas.beside::after { inset: 50% 0 auto; border-top: 1px solid #666d77; border-left: none; }
  .below-canvas { grid-template-columns: 1fr; text-align: left; }
}
@media (max-width: 760px) { .level { grid-template-columns: minmax(0, 1fr); } }
@media (max-width: 560px) { dl { display: block; } dd { margin-bottom: 8px; } body { padding: 16px 12px 40px; } }
)";

std::string bytes_text(std::uintmax_t bytes) {
  if (bytes < 1000) return fmt::format("{} B", bytes);
  const double size = static_cast<double>(bytes);
  if (bytes < 1'000'000) return short_number(size / 1e3) + " kB";
  return bytes < 1'000'000'000 ? short_number(size / 1e6) + " MB" : short_number(size / 1e9) + " GB";
}

double in_degrees(double radians) { return radians * 180 / std::numbers::pi; }

std::string cell(const std::string& content, const std::string& second_line = "") {
  const std::string small = second_line.empty() ? "" : "<small>" + second_line + "</small>";
  return "<td>" + content + small + "</td>";
}

// "12 tri", "6 quad", "1 n-gon" on lines of their own: only kinds that occur, unless all are triangles.
std::string kinds_of_faces(const MeshSummary& summary) {
  if (summary.triangles == summary.faces) return "triangles";
  std::string text;
  const auto add = [&text](std::size_t count, std::string_view kind) {
    if (count != 0) text += (text.empty() ? "" : "<br>") + grouped(count) + " " + std::string(kind);
  };
  add(summary.triangles, "tri");
  add(summary.quads, "quad");
  add(summary.larger_polygons, "n-gon");
  return text;
}

std::string error_cell(double error, double diagonal) {
  return cell(short_number(error), percent(error / diagonal));
}

std::string table_row(const ReportContent& content, std::size_t index) {
  const LodLevel& level = content.hierarchy.levels[index];
  const LevelContent& drawn = content.levels[index];
  std::string row = fmt::format("<tr id=\"row-{0}\"><td><a href=\"#level-{0}\">{0}</a></td>", index);
  std::string faces = kinds_of_faces(drawn.summary);
  if (!content.options.patches.empty())
    faces += (faces.empty() ? "" : "<br>") + grouped(content.options.patches[index]) + " patches";
  row += cell(grouped(drawn.summary.faces), faces);
  row += cell(grouped(drawn.summary.vertices));
  row += cell(bytes_text(content.files.level_bytes[index]));
  for (const double error : {level.error.max, level.error.rms, level.error.bound}) {
    row += error_cell(error, content.diagonal);
  }
  row += cell(short_number(level.switch_distance));
  row += cell(percent(level.screen_coverage));
  row += drawn.at_switch ? cell(short_number(drawn.at_switch->difference.rmse),
                                percent(drawn.at_switch->difference.changed_share) + " of pixels")
                         : cell("–");
  row += cell(short_number(level.simplify_seconds));
  row += cell(short_number(level.measure_seconds));
  row += fmt::format("<td class=\"text\">{}</td></tr>\n",
                     level.stop_reason.empty() ? "the input" : escape_markup(level.stop_reason));
  return row;
}

std::string summary_table(const ReportContent& content) {
  std::string table =
      "<div class=\"wide\"><table>\n<thead><tr><th>Level</th><th>Faces</th><th>Vertices</th><th>File</th>"
      "<th>Max error<small>object units<br>% of diagonal</small></th><th>RMS error<small>object units<br>% "
      "of diagonal</small></th>"
      "<th>Bound<small>object units<br>% of diagonal</small></th><th>Switch<br>distance<small>object "
      "units</small></th><th>Screen<br>coverage</th>"
      "<th>Image<br>RMSE</th><th>Simplify<small>s</small></th><th>Measure<small>s</small></th>"
      "<th class=\"text\">Stopped by</th></tr></thead>\n<tbody>\n";
  for (std::size_t i = 0; i < content.levels.size(); ++i) table += table_row(content, i);
  return table + "</tbody>\n</table></div>\n";
}

std::string header(const ReportContent& content) {
  const LodHierarchy& hierarchy = content.hierarchy;
  const MeshSummary& input = content.levels[0].summary;
  std::string html = fmt::format("<h1>{}</h1>\n", escape_markup(hierarchy.name));
  html += fmt::format(
      "<p>{} faces, {} vertices, bounding box diagonal {} object units. {} levels in <b>{}</b>.</p>\n",
      grouped(input.faces), grouped(input.vertices), short_number(content.diagonal), content.levels.size(),
      escape_markup(content.files.glb.filename().string()));
  if (hierarchy.source_faces > 0) {
    html += fmt::format(
        "<p>The input has {} faces, more than memory allowed. Errors are those to all of them; pictures and "
        "the "
        "viewer compare with level 0.</p>\n",
        grouped(hierarchy.source_faces));
  }
  html += fmt::format(
      "<p class=\"faint\">Switch distances hold for an image {} pixels high, a vertical field of view of "
      "{:.4g} degrees and {:.4g} {} of permitted error.</p>\n",
      grouped(static_cast<std::size_t>(std::lround(hierarchy.view.image_height))),
      in_degrees(hierarchy.view.field_of_view), hierarchy.view.pixel_error,
      hierarchy.view.pixel_error == 1 ? "pixel" : "pixels");
  return html;
}

constexpr std::string_view k_how_to_read = R"(<h2 id="reading">How to read this</h2>
<dl>
<dt>Faces, vertices</dt><dd>Polygons and points of the level; triangles, quads and larger polygons are counted apart.</dd>
<dt>File</dt><dd>Size of the level's own file, polygons in double precision.</dd>
<dt>Max error</dt><dd>Largest distance seen between the level and the original, both ways, in object units: the truth is at
least this.</dd>
<dt>RMS error</dt><dd>Root of the mean squared distance over both surfaces, in object units.</dd>
<dt>Bound</dt><dd>Proved: no point of either surface is farther than this from the other.</dd>
<dt>Switch distance</dt><dd>From here on the bound covers no more than the permitted number of pixels, so the level
may stand in for the original.</dd>
<dt>Screen coverage</dt><dd>Share of the image's height that the model's bounding sphere covers at that distance.</dd>
<dt>Image RMSE</dt><dd>Root of the mean squared difference between the pictures of the level and of the original at the switch
distance, where 1 is the step from black to white; below it, the share of pixels that differ by more than 1/255.</dd>
<dt>Simplify</dt><dd>Seconds from the start of the run to this level.</dd>
<dt>Measure</dt><dd>Seconds to measure the level's error.</dd>
<dt>Stopped by</dt><dd>What ended the simplification at this level.</dd>
<dt>Pictures</dt><dd>The camera stands where the bounding sphere's nearest point is at the switch distance and
looks at its center; the picture is cut to the sphere. Light grey surfaces have no material. Shading shows normals, so a
picture may differ where the shape is within its bound.</dd>
)";

constexpr std::string_view k_how_to_read_viewer =
    R"(<dt>Viewer</dt><dd>Draws with three.js, MIT licence, © 2010-2026 three.js authors; the licence is in the page's script.</dd>
)";

constexpr std::string_view k_how_to_read_maps =
    R"(<dt>With maps</dt><dd>Error of the level when the displacement map moves its points, in object units; dark places of that map lie
deep, light ones high.</dd>
<dt>Seam difference</dt><dd>Largest difference between the heights on both sides of a seam of the maps, in object units.</dd>
<dt>Missed texels</dt><dd>Those whose line along the normal met nothing of the original; its closest point took over.</dd>
<dt>Atlas</dt><dd>Whether the maps use the original's texture coordinates, or why the level got new ones.</dd>
)";

}  // namespace

std::string report_html(const ReportContent& content) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{}: levels of detail</title>\n<style>{}</style>\n</head>\n<body>\n",
      escape_markup(content.hierarchy.name), k_style);
  html += header(content);
  html += "<h2>Levels</h2>\n" + summary_table(content);
  html += "<p class=\"below\"><a href=\"#reading\">How to read this</a></p>\n";
  html += plots(content) + viewer_section(content) + level_sections(content);
  html += k_how_to_read;
  if (has_viewer(content)) html += k_how_to_read_viewer;
  if (has_maps(content)) html += k_how_to_read_maps;
  html += "</dl>\n";
  return html + "</body>\n</html>\n";
}

}  // namespace recede::detail
