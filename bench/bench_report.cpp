#include "bench_report.h"

#include "bench_run.h"
#include "plot_sheet.h"
#include <recede/geometry/atomic_file.h>

#include <fmt/format.h>

#include <algorithm>
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

constexpr const char* k_rules =
    "Every system gets the same welded faces with positions rounded to single precision. Seconds are the "
    "median wall clock of the simplify call alone, without the proof of the error, in one thread but for "
    "rows with all threads. Errors are two-sided, from 200 000 samples on each surface and all vertices, as "
    "shares of the input's bounding box diagonal. Where a system didn't reach the target, the cell says what "
    "share of the faces it kept; its error can't be compared then.\n\n";

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

/// Time and error.
std::string summary_tables(const std::vector<Row>& all) {
  std::string text;
  const auto triangles = kept(all, [](const Row& row) { return !row.polygons; });
  for (const std::string& goal : different(triangles, &Row::goal)) {
    const auto rows = kept(triangles, [&](const Row& row) { return row.goal == goal; });
    text += table(goal + ": seconds ; max 1e-3 ; RMS 1e-4", rows, error_cell);
  }
  const auto polygons = kept(all, [](const Row& row) { return row.polygons; });
  for (const std::string& goal : different(polygons, &Row::goal)) {
    const auto rows = kept(polygons, [&](const Row& row) { return row.goal == goal; });
    text +=
        table(goal + ", quad models: seconds ; max 1e-3 ; RMS 1e-4 ; quads of all faces", rows, polygon_cell);
  }
  return text;
}

/// Bounds, memory and defects.
std::string detail_tables(const std::vector<Row>& all) {
  std::string text;
  for (const std::string& goal : different(all, &Row::goal)) {
    const auto rows = kept(all, [&](const Row& row) { return row.goal == goal; });
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

std::vector<Plot> size_plots(const std::vector<Row>& rows) {
  const std::string model = rows.empty() ? "" : rows.front().model;
  Plot over_time = log_plot(model + ", 50 to 1 % of the faces", "processor seconds", "RMS / diagonal"),
       over_size = log_plot(model, "faces", "RMS / diagonal");
  for (const Row& row : rows) {
    if (!row.figures || !row.reached_target()) continue;
    add_point(over_time, row.label, row.figures->cpu_seconds, row.figures->rms);
    add_point(over_size, row.label, static_cast<double>(row.figures->faces), row.figures->rms);
  }
  return {over_time, over_size};
}

std::vector<Plot> growth_plots(const std::vector<Row>& rows) {
  Plot time = log_plot("To 10 % of the faces: time", "faces of the input", "nanoseconds per face"),
       memory = log_plot("Memory above the input", "faces of the input", "bytes per face");
  for (const Row& row : rows) {
    if (!row.figures) continue;
    const auto faces = static_cast<double>(row.input_faces);
    add_point(time, row.label, faces, 1e9 * row.figures->seconds / faces);
    add_point(memory, row.label, faces, static_cast<double>(row.figures->call_peak_bytes) / faces);
  }
  return {time, memory};
}

void write_csv(const std::filesystem::path& file,
               const std::vector<std::pair<const char*, const std::vector<Row>*>>& kinds) {
  std::filesystem::create_directories(file.parent_path());
  std::string csv = k_csv_header;
  for (const auto& [kind, rows] : kinds) {
    for (const Row& row : *rows) csv += csv_line(row, kind);
  }
  write_file_atomically(file, csv);
}

}  // namespace

double percent(std::size_t part, std::size_t whole) {
  return 100 * static_cast<double>(part) / static_cast<double>(whole);
}

std::string quoted(std::string text) {
  std::replace(text.begin(), text.end(), '"', '\'');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return '"' + text + '"';
}

BenchSection measure_simplification(const BenchOptions& options) {
  const std::filesystem::path file = options.out / "simplification.csv";
  const std::vector<Row> rows = run_simplification(options, [&](const auto& so_far) {
    write_csv(file, {{"comparison", &so_far}});
  });
  const std::vector<Row> sizes = run_sizes(options, [&](const auto& so_far) {
    write_csv(file, {{"comparison", &rows}, {"sizes", &so_far}});
  });
  BenchSection section;
  section.markdown = k_rules + summary_tables(rows) + detail_tables(rows);
  section.curves = size_plots(sizes);
  return section;
}

BenchSection measure_growth(const BenchOptions& options) {
  const std::vector<Row> rows = run_growth(options, [&](const auto& so_far) {
    write_csv(options.out / "growth.csv", {{"growth", &so_far}});
  });
  BenchSection section;
  section.markdown = table("To 10 % of the faces: nanoseconds ; bytes per input face", rows, growth_cell);
  section.curves = growth_plots(rows);
  return section;
}

}  // namespace recede::bench
