#include "cad_run.h"

#include "cad_rows.h"
#include <recede/geometry/atomic_file.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace recede::bench {
namespace {

constexpr double k_equal_share = 1e-3;   // where triangles of equal deviation are looked for
constexpr double k_levels_share = 1e-2;  // of the coarser faces
constexpr const char* k_drawn_model = "bored sphere";

CadRow measure_row(const CadSubject& subject, double share, std::size_t repeats, bool is_large) {
  CadRow row{subject.name, subject.n_faces(), share, share * subject.diagonal, {}, {}, {}};
  CadRunOptions run;
  run.deflection = row.deflection;
  run.repeats = repeats;
  run.equal = share == k_equal_share && !is_large;
  row.recede = run_recede(subject, run);
  row.wide_angle.failure = row.brep_mesh.failure = "";
  CadRunOptions wide = run;
  wide.angle = k_wide_angle;
  row.wide_angle = run_brep_mesh(subject, wide);
  run.equal = false;
  row.brep_mesh = run_brep_mesh(subject, run);
  return row;
}

double load() {
  double value = 0;
  return ::getloadavg(&value, 1) == 1 ? value : 0;
}

}  // namespace

std::string cad_tables(const BenchOptions& options) {
  const double load_before = load();
  std::filesystem::create_directories(options.out);
  std::vector<CadRow> rows;
  std::vector<CadLevelsRow> levels;
  for (const CadSource& source : cad_sources(options.data.parent_path() / "cad")) {
    if (!is_wanted(source.name, options.models) || (options.quick && source.is_large)) continue;
    const CadSubject subject = load_cad(source);
    for (const double share : {1e-2, 1e-3, 1e-4}) {
      if (source.is_large && share != k_equal_share) continue;
      rows.push_back(measure_row(subject, share, options.repeats, source.is_large));
    }
    if (subject.n_faces() > 1) {
      const double deflection = k_levels_share * subject.diagonal;
      const auto file = [&](const char* name) {
        return source.name == k_drawn_model ? options.out / name : std::filesystem::path();
      };
      levels.push_back({source.name, run_recede_levels(subject, deflection, file("cad-recede.ply")),
                        run_brep_mesh_levels(subject, deflection, file("cad-brep-mesh.ply"))});
    }
    fmt::print(stderr, "{} is done\n", source.name);
  }
  std::string text = cad_report(rows, levels);
  if (is_wanted("scale", options.models)) text += cad_scale_tables(options);
  text += fmt::format("Processes that wanted to run, mean of a minute: {:.1f} before, {:.1f} after.\n\n",
                      load_before, load());
  write_file_atomically(options.out / "cad.json", cad_json(rows, levels));
  write_file_atomically(options.out / "cad.md", text);
  return text;
}

}  // namespace recede::bench
