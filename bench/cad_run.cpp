#include "cad_run.h"

#include "cad_rows.h"
#include "plot_sheet.h"
#include <recede/geometry/atomic_file.h>

#include <fmt/format.h>

#include <algorithm>

namespace recede::bench {
namespace {

constexpr double k_equal_share = 1e-3;   // where triangles of equal deviation are looked for
constexpr double k_levels_share = 1e-2;  // of the coarser faces
constexpr const char* k_drawn_model = "bored sphere";
constexpr const char* k_curve_model = "linkrods.step";
constexpr double k_curve_shares[]{1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5};

CadRow measure_row(const CadSubject& subject, double share, std::size_t repeats, bool is_short) {
  CadRow row{subject.name, subject.n_faces(), share, share * subject.diagonal, {}, {}, {}};
  CadRunOptions run;
  run.deflection = row.deflection;
  run.repeats = repeats;
  run.equal = share == k_equal_share && !is_short;
  row.recede = run_recede(subject, run);
  CadRunOptions wide = run;
  wide.angle = k_wide_angle;
  row.wide_angle = run_brep_mesh(subject, wide);
  run.equal = false;
  row.brep_mesh = run_brep_mesh(subject, run);
  return row;
}

std::vector<Plot> curves_of(const CadSubject& subject, std::size_t repeats) {
  Plot over_time = log_plot(subject.name, "processor seconds", "deviation / diagonal"),
       over_size = log_plot(subject.name, "triangles", "deviation / diagonal");
  for (const double share : k_curve_shares) {
    const CadRow row = measure_row(subject, share, repeats, true);
    for (const auto& [series, answer] :
         {std::pair{"Recede", &row.recede}, std::pair{"BRepMesh", &row.brep_mesh},
          std::pair{"BRepMesh, wide angle", &row.wide_angle}}) {
      if (!answer->figures) continue;
      const CadFigures& figures = *answer->figures;
      const double error = figures.judgement.deviation / subject.diagonal;
      add_point(over_time, series, figures.total.cpu, error);
      add_point(over_size, series, static_cast<double>(figures.judgement.triangles), error);
    }
  }
  return {over_time, over_size};
}

}  // namespace

BenchSection measure_cad(const BenchOptions& options) {
  BenchSection section;
  std::filesystem::create_directories(options.out);
  std::vector<CadRow> rows;
  std::vector<CadLevelsRow> levels;
  for (const CadSource& source : cad_sources(options.data.parent_path() / "cad")) {
    if (!is_wanted(source.name, options.models) || (options.quick && source.is_large)) continue;
    const CadSubject subject = load_cad(source);
    for (const double share : {1e-2, 1e-3, 1e-4}) {
      if ((source.is_large || options.quick) && share != k_equal_share) continue;
      rows.push_back(measure_row(subject, share, options.repeats, source.is_large || options.quick));
    }
    if (subject.n_faces() > 1) {
      const double deflection = k_levels_share * subject.diagonal;
      const auto file = [&](const char* name) {
        return source.name == k_drawn_model ? options.out / name : std::filesystem::path();
      };
      levels.push_back({source.name, run_recede_levels(subject, deflection, file("cad-recede.ply")),
                        run_brep_mesh_levels(subject, deflection, file("cad-brep-mesh.ply"))});
    }
    if (source.name == k_curve_model) section.curves = curves_of(subject, options.repeats);
    fmt::print(stderr, "{} is done\n", source.name);
  }
  section.markdown = cad_report(rows, levels);
  if (is_wanted("scale", options.models) && !options.quick) section.markdown += cad_scale_tables(options);
  write_file_atomically(options.out / "cad.json", cad_json(rows, levels));
  write_file_atomically(options.out / "cad.md", section.markdown);
  return section;
}

}  // namespace recede::bench
