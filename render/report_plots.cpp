// The part of the report that plots what levels cost and how far they are off.
#include <recede/render/detail/report_content.h>
#include <recede/render/svg_plot.h>

namespace recede::detail {

namespace {

// Shows the values of the point nearest to the pointer, and goes through points by arrow keys. Without angle
// brackets, so that it is markup like the rest.
constexpr std::string_view k_script = R"(
(function () {
  "use strict";
  var spoken = document.getElementById("plot-values");
  function element(name, parent, attributes) {
    var made = document.createElementNS("http://www.w3.org/2000/svg", name);
    Object.keys(attributes).forEach(function (key) { made.setAttribute(key, attributes[key]); });
    return parent.appendChild(made);
  }
  document.querySelectorAll(".plot svg").forEach(function (svg) {
    var points = Array.from(svg.querySelectorAll(".point")).map(function (group) {
      var title = group.querySelector("title"), box = group.getBBox();
      title.remove();
      return { text: title.textContent, x: box.x + box.width / 2, y: box.y + box.height / 2 };
    });
    if (points.length === 0) return;
    var shown = -1, width = svg.viewBox.baseVal.width;
    var tip = element("g", svg, { class: "tip", visibility: "hidden" });
    var ring = element("circle", tip, { r: 8 }), ground = element("rect", tip, { rx: 4, height: 24 });
    var label = element("text", tip, {});
    function show(number) {
      shown = number;
      tip.setAttribute("visibility", number === -1 ? "hidden" : "visible");
      if (number === -1) return;
      var point = points[number];
      label.textContent = point.text;
      var length = label.getComputedTextLength() + 16;
      var left = Math.max(0, Math.min(point.x - length / 2, width - length));
      var top = point.y - 38;
      ring.setAttribute("cx", point.x);
      ring.setAttribute("cy", point.y);
      ground.setAttribute("x", left);
      ground.setAttribute("y", top);
      ground.setAttribute("width", length);
      label.setAttribute("x", left + 8);
      label.setAttribute("y", top + 16.5);
    }
    function tell(number) {
      show(number);
      spoken.textContent = number === -1 ? "" : points[number].text;
    }
    function nearest(event) {
      var place = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      var distances = points.map(function (p) { return Math.hypot(p.x - place.x, p.y - place.y); });
      var least = Math.min.apply(null, distances);
      return Math.max(least, 30) === 30 ? distances.indexOf(least) : -1;
    }
    svg.addEventListener("pointermove", function (event) { show(nearest(event)); });
    svg.addEventListener("pointerdown", function (event) { show(nearest(event)); });
    svg.addEventListener("pointerleave", function () { show(-1); });
    svg.addEventListener("focus", function () { if (svg.matches(":focus-visible")) tell(0); });
    svg.addEventListener("blur", function () { show(-1); });
    svg.addEventListener("keydown", function (event) {
      var last = points.length - 1;
      var next = { ArrowRight: shown + 1, ArrowDown: shown + 1, ArrowLeft: shown - 1, ArrowUp: shown - 1, Home: 0, End: last,
        Escape: -1 }[event.key];
      if (next === undefined) return;
      event.preventDefault();
      tell(event.key === "Escape" ? -1 : Math.max(0, Math.min(next, last)));
    });
    svg.setAttribute("tabindex", "0");
    svg.setAttribute("role", "application");
    svg.setAttribute("aria-label", svg.getAttribute("aria-label") + ": arrow keys go through the points");
  });
})();
)";

std::string error_plot(const ReportContent& content) {
  PlotSeries bound{"certified bound", {}}, max{"maximum", {}}, rms{"RMS", {}}, displaced{"RMS with maps", {}};
  for (std::size_t i = 1; i < content.levels.size(); ++i) {
    const double faces = static_cast<double>(content.levels[i].summary.faces);
    const LevelError& error = content.hierarchy.levels[i].error;
    if (!content.hierarchy.levels[i].billboards) bound.points.emplace_back(faces, error.bound);
    max.points.emplace_back(faces, error.max);
    rms.points.emplace_back(faces, error.rms);
    if (const auto& accuracy = content.hierarchy.levels[i].map_accuracy) {
      displaced.points.emplace_back(faces, accuracy->rms);
    }
  }
  std::vector<PlotSeries> series{bound, max, rms};
  if (!displaced.points.empty()) series.push_back(displaced);
  return svg_plot({.title = "Error against size",
                   .x = {"faces", true},
                   .y = {"error (object units)", true},
                   .series = series});
}

std::string seconds_plot(const ReportContent& content) {
  PlotSeries simplify{"simplify, from the start of the run", {}}, measure{"measure", {}};
  for (std::size_t i = 1; i < content.levels.size(); ++i) {
    const double faces = static_cast<double>(content.levels[i].summary.faces);
    simplify.points.emplace_back(faces, content.hierarchy.levels[i].simplify_seconds);
    measure.points.emplace_back(faces, content.hierarchy.levels[i].measure_seconds);
  }
  return svg_plot({.title = "Time against size",
                   .x = {"faces", true},
                   .y = {"seconds", false},
                   .series = {simplify, measure}});
}

}  // namespace

std::string plots(const ReportContent& content) {
  if (content.levels.size() == 1) return "";
  return "<div class=\"plots\">\n<div class=\"plot\">" + error_plot(content) +
         "</div>\n<div class=\"plot\">" + seconds_plot(content) +
         "</div>\n</div>\n<p class=\"spoken\" id=\"plot-values\" role=\"status\"></p>\n<script>" +
         std::string(k_script) + "</script>\n";
}

}  // namespace recede::detail
