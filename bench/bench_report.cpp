#include "bench_report.h"

#include <recede/geometry/atomic_file.h>
#include <recede/render/svg_plot.h>

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <thread>

namespace recede::bench {
namespace {

using Cell = std::function<std::string(const Row&)>;
using Keep = std::function<bool(const Row&)>;

std::vector<std::string> different(const std::vector<Row>& rows, std::string Row::*field) {
  std::vector<std::string> values;
  for (const Row& row : rows) {
    if (std::find(values.begin(), values.end(), row.*field) == values.end()) values.push_back(row.*field);
  }
  return values;
}

std::vector<Row> kept(const std::vector<Row>& rows, const Keep& keep) {
  std::vector<Row> chosen;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(chosen), keep);
  return chosen;
}

/// Systems down, models across. Nothing when there are no rows.
std::string table(const std::string& title, const std::vector<Row>& rows, const Cell& cell) {
  if (rows.empty()) return {};
  const auto models = different(rows, &Row::model);
  std::string text = fmt::format("**{}**\n\n| system |", title);
  for (const std::string& model : models) text += fmt::format(" {} |", model);
  text += "\n|---|";
  for (std::size_t i = 0; i < models.size(); ++i) text += "---|";
  text += '\n';
  for (const std::string& system : different(rows, &Row::system)) {
    text += fmt::format("| {} |", system);
    for (const std::string& model : models) {
      const auto row = std::find_if(rows.begin(), rows.end(),
                                    [&](const Row& r) { return r.system == system && r.model == model; });
      text += fmt::format(" {} |", row == rows.end() ? "" : row->figures ? cell(*row) : row->remark);
    }
    text += '\n';
  }
  return text + '\n';
}

double percent(std::size_t part, std::size_t whole) {
  return 100 * static_cast<double>(part) / static_cast<double>(whole);
}

std::string error_cell(const Row& row) {
  const Figures& f = *row.figures;
  std::string text = fmt::format("{:.2g} ; {:.3g} ; {:.3g}", f.seconds, 1e3 * f.max, 1e4 * f.rms);
  if (!row.reached_target() || row.target == 0)
    text += fmt::format(" at {:.2g} %", percent(f.faces, row.input_faces));
  return text;
}

std::string polygon_cell(const Row& row) {
  const Figures& f = *row.figures;
  std::string text = fmt::format("{:.2g} ; {:.3g} ; {:.3g} ; {:.0f} % of {}", f.seconds, 1e3 * f.max,
                                 1e4 * f.rms, 100 * f.quad_share, f.faces);
  if (!row.reached_target())
    text += fmt::format(" at {:.3g} % of the vertices", percent(f.vertices, row.input_vertices));
  return text;
}

std::string bound_cell(const Row& row) {
  const Figures& f = *row.figures;
  return fmt::format("{:.3g} ; {}", 1e3 * f.bound,
                     f.reported > 0 ? fmt::format("{:.3g}", 1e3 * f.reported) : "-");
}

std::string proof_cell(const Row& row) {
  const Figures& f = *row.figures;
  return fmt::format("{:.2g} ; {:.2f} ; {:.1f}", f.proof_seconds, f.reported / f.max,
                     f.proof_seconds / f.seconds);
}

std::string speed_cell(const Row& row) {
  const Figures& f = *row.figures;
  const auto faces = static_cast<double>(row.input_faces);
  return fmt::format("{:.3g} ; {:.2g} ; {:.0f} ; {:.0f}", row.million_faces_per_second(), f.cpu_seconds,
                     static_cast<double>(f.peak_bytes) / faces,
                     static_cast<double>(f.call_peak_bytes) / faces);
}

std::string defect_cell(const Row& row) {
  const SurfaceDefects& d = row.figures->new_defects;
  return fmt::format("{} ; {} ; {}", d.border_edges, d.non_manifold_edges, d.degenerate_faces);
}

std::string growth_cell(const Row& row) {
  const auto faces = static_cast<double>(row.input_faces);
  return fmt::format("{:.0f} ; {:.0f}", 1e9 * row.figures->seconds / faces,
                     static_cast<double>(row.figures->call_peak_bytes) / faces);
}

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

std::string facts(const BenchResults& results) {
  return fmt::format(
      "# Simplification, ours and the peers'\n\n"
      "{}, {} threads; {}, {}. Load average (1 minute) {:.2f} at the start, {:.2f} at the end; above the "
      "threads that a "
      "system uses, wall clocks are too long and results.csv has the processor time.\n\n"
      "Every system gets the same welded faces with positions rounded to single precision. Seconds are "
      "the median "
      "wall clock of the simplify call alone, without the proof of the error. All but "
      "the rows with all threads run in one. Errors are two-sided, from 200 000 samples on each surface and "
      "all "
      "vertices, as shares of the input's bounding box diagonal. Where a system didn't reach the target, the "
      "cell says "
      "what share of the faces it kept; its error can't be compared then.\n\n",
      cpu_name(), std::thread::hardware_concurrency(), RECEDE_COMPILER, RECEDE_BUILD_TYPE,
      results.load_at_start, results.load_at_end);
}

constexpr const char* k_csv_header =
    "kind,model,goal,system,threads,status,remark,input_faces,input_vertices,target_count,faces,vertices,"
    "runs,"
    "setup_seconds,seconds,cpu_seconds,proof_seconds,million_faces_per_second,peak_bytes,call_peak_bytes,"
    "peak_bytes_per_"
    "face,"
    "max_share_of_diagonal,rms_share_of_diagonal,certified_bound_share_of_diagonal,reported_error_share_of_"
    "diagonal,"
    "new_border_edges,new_non_manifold_edges,new_degenerate_faces,quad_share\n";

std::string csv_line(const Row& row, const std::string& kind) {
  const std::string status = !row.figures ? "failed" : row.reached_target() ? "done" : "above target";
  std::string line = fmt::format(
      "{},{},{},{},{},{},{},{},{},{},", kind, quoted(row.model), quoted(row.goal), quoted(row.system),
      row.all_threads ? std::thread::hardware_concurrency() : 1u, status, quoted(row.remark), row.input_faces,
      row.input_vertices, row.target == 0 ? "" : std::to_string(row.target));
  if (!row.figures) return line + std::string(18, ',') + '\n';
  const Figures& f = *row.figures;
  line += fmt::format("{},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{},{},{:.4g},", f.faces, f.vertices,
                      f.runs, f.setup_seconds, f.seconds, f.cpu_seconds, f.proof_seconds,
                      row.million_faces_per_second(), f.peak_bytes, f.call_peak_bytes,
                      static_cast<double>(f.peak_bytes) / static_cast<double>(row.input_faces));
  // Zeros would read as perfect results.
  if (!f.with_errors) return line + std::string(7, ',') + '\n';
  line += fmt::format("{:.6g},{:.6g},{:.6g},{},", f.max, f.rms, f.bound,
                      f.reported > 0 ? fmt::format("{:.6g}", f.reported) : "");
  line += fmt::format("{},{},{},{:.4g}\n", f.new_defects.border_edges, f.new_defects.non_manifold_edges,
                      f.new_defects.degenerate_faces, f.quad_share);
  return line;
}

/// A series per system over what `point` says of its rows.
std::vector<PlotSeries> series_by_system(const std::vector<Row>& rows,
                                         const std::function<Vec2(const Row&)>& point) {
  std::vector<PlotSeries> series;
  for (const std::string& system : different(rows, &Row::system)) {
    PlotSeries& line = series.emplace_back();
    for (const Row& row : rows) {
      if (row.system != system) continue;
      line.name = row.label;
      line.points.push_back(point(row));
    }
  }
  return series;
}

std::string error_against_speed(const std::vector<Row>& rows, const std::string& goal) {
  return svg_plot(
      {.title = goal + ", displaced spheres",
       .x = {"million faces per second", true},
       .y = {"RMS / diagonal", true},
       .series = series_by_system(
           rows, [](const Row& row) { return Vec2(row.million_faces_per_second(), row.figures->rms); }),
       .width = 900,
       .height = 480});
}

std::string growth_plot(const std::vector<Row>& rows) {
  return svg_plot({.title = "Time per face over growing models, to 10 % of the faces",
                   .x = {"faces of the input", true},
                   .y = {"nanoseconds per face", false},
                   .series = series_by_system(rows,
                                              [](const Row& row) {
                                                const auto faces = static_cast<double>(row.input_faces);
                                                return Vec2(faces, 1e9 * row.figures->seconds / faces);
                                              }),
                   .width = 720,
                   .height = 420});
}

/// Bounds, memory and defects.
std::string detail_tables(const BenchResults& results) {
  std::string text;
  for (const std::string& goal : different(results.rows, &Row::goal)) {
    const auto rows = kept(results.rows, [&](const Row& row) { return row.goal == goal; });
    text += table(goal + ": certified bound of the maximum 1e-3 ; error that the system reports 1e-3", rows,
                  bound_cell);
    const auto proved =
        kept(rows, [](const Row& row) { return row.figures && row.figures->proof_seconds > 0; });
    text += table(
        goal +
            ": proof of the error, seconds ; its bound over the sampled maximum ; its time over that of "
            "simplifying",
        proved, proof_cell);
    text += table(goal +
                      ": million faces per second ; CPU seconds ; peak bytes per input face above the input "
                      "; of the call alone",
                  rows, speed_cell);
    text +=
        table(goal + ": new border edges ; new non-manifold edges ; new degenerate faces", rows, defect_cell);
  }
  return text;
}

void write_plots(const BenchResults& results, const std::filesystem::path& folder) {
  for (const auto& [goal, name] : {std::pair{"10 % of the faces", "rms_against_speed_10_percent.svg"},
                                   std::pair{"1 % of the faces", "rms_against_speed_1_percent.svg"}}) {
    const auto rows = kept(results.rows, [goal = goal](const Row& row) {
      return row.synthetic && row.goal == goal && row.reached_target();
    });
    if (!rows.empty()) write_file_atomically(folder / name, error_against_speed(rows, goal));
  }
  const auto growth = kept(results.growth, [](const Row& row) { return row.figures.has_value(); });
  if (!growth.empty()) write_file_atomically(folder / "growth.svg", growth_plot(growth));
}

}  // namespace

std::string quoted(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return '"' + text + '"';
}

std::string summary_tables(const BenchResults& results) {
  std::string text;
  const auto triangles = kept(results.rows, [](const Row& row) { return !row.polygons; });
  for (const std::string& goal : different(triangles, &Row::goal)) {
    const auto rows = kept(triangles, [&](const Row& row) { return row.goal == goal; });
    text += table(goal + ": seconds ; max 1e-3 ; RMS 1e-4", rows, error_cell);
  }
  const auto polygons = kept(results.rows, [](const Row& row) { return row.polygons; });
  for (const std::string& goal : different(polygons, &Row::goal)) {
    const auto rows = kept(polygons, [&](const Row& row) { return row.goal == goal; });
    text +=
        table(goal + ", quad models: seconds ; max 1e-3 ; RMS 1e-4 ; quads of all faces", rows, polygon_cell);
  }
  return text + table("Growth, to 10 % of the faces: nanoseconds ; bytes per input face", results.growth,
                      growth_cell);
}

void write_report(const BenchResults& results, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::string csv = k_csv_header;
  for (const Row& row : results.rows) csv += csv_line(row, "comparison");
  for (const Row& row : results.growth) csv += csv_line(row, "growth");
  write_file_atomically(folder / "results.csv", csv);
  write_file_atomically(folder / "results.md",
                        facts(results) + summary_tables(results) + detail_tables(results));
  write_plots(results, folder);
}

}  // namespace recede::bench
