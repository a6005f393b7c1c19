#include "cad_rows.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>
#include <map>

namespace recede::bench {
namespace {

using Figure = std::function<std::string(const CadFigures&)>;

/// A figure of all three.
std::string cell(const CadRow& row, const Figure& figure) {
  std::string text;
  for (const CadAnswer* answer : {&row.recede, &row.brep_mesh, &row.wide_angle}) {
    if (!text.empty()) text += " ; ";
    text += answer->figures ? figure(*answer->figures) : "-";
  }
  return text;
}

std::string count(std::size_t n) { return fmt::format("{}", n); }

std::string ratio_text(double ratio) {
  return ratio < 10 ? fmt::format("{:.2f}", ratio) : fmt::format("{:.0f}", ratio);
}

std::string row_line(const CadRow& row) {
  const std::string proved =
      row.recede.figures ? fmt::format("{:.2f}", row.recede.figures->bound / row.deflection) : "-";
  return fmt::format(
      "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", row.model, row.faces,
      cell(row, [](const CadFigures& f) { return count(f.judgement.triangles); }),
      cell(row, [](const CadFigures& f) { return fmt::format("{:.2g}", f.total.cpu); }),
      cell(row, [](const CadFigures& f) { return fmt::format("{:.2g}", f.total.wall); }),
      cell(row, [](const CadFigures& f) { return fmt::format("{:.0f}", 1e-6 * double(f.peak_bytes)); }),
      cell(row, [&](const CadFigures& f) { return ratio_text(f.judgement.deviation / row.deflection); }),
      proved, cell(row, [](const CadFigures& f) { return count(f.judgement.faces_over); }),
      cell(row, [](const CadFigures& f) { return count(f.judgement.faces_missing); }),
      cell(row,
           [](const CadFigures& f) {
             return fmt::format("{} ({})", f.judgement.open_edges, f.judgement.closed_open_edges);
           }),
      cell(row, [](const CadFigures& f) { return count(f.judgement.inverted); }));
}

std::vector<double> shares_of(const std::vector<CadRow>& rows) {
  std::map<double, bool, std::greater<>> shares;
  for (const CadRow& row : rows) shares[row.share] = true;
  std::vector<double> result;
  for (const auto& [share, is_there] : shares) result.push_back(share);
  return result;
}

/// Geometric mean of a figure of ours over theirs; rows without both don't count.
class MeanRatio {
 public:
  void add(double ours, double theirs) {
    if (!(ours > 0 && theirs > 0)) return;
    sum_ += std::log(ours / theirs);
    ++n_;
  }
  double mean() const { return n_ > 0 ? std::exp(sum_ / static_cast<double>(n_)) : 0; }

 private:
  double sum_ = 0;
  std::size_t n_ = 0;
};

/// One line over all models at a deflection.
struct Summary {
  std::size_t models = 0, over = 0, faces_over = 0, missing = 0, inverted = 0, closed_open = 0, failed = 0;
  std::size_t triangles = 0;
  double worst = 0, cpu = 0, wall = 0;
  void add(const CadAnswer& answer, double deflection) {
    ++models;
    if (!answer.figures) {
      ++failed;
      return;
    }
    const CadJudgement& judgement = answer.figures->judgement;
    over += judgement.faces_over > 0 ? 1 : 0;
    faces_over += judgement.faces_over;
    missing += judgement.faces_missing;
    inverted += judgement.inverted;
    closed_open += judgement.closed_open_edges;
    triangles += judgement.triangles;
    worst = std::max(worst, judgement.deviation / deflection);
    cpu += answer.figures->total.cpu;
    wall += answer.figures->total.wall;
  }
};

std::string summary(const std::vector<CadRow>& rows) {
  std::string text =
      "**All models.** Worst deviation in units of the deflection; open edges are those of bodies that the "
      "file closes\n\n| deflection | | triangles | processor s | wall s | models over ; faces over | worst | "
      "faces missing | open edges | inverted triangles | no answer |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const double share : shares_of(rows)) {
    for (const auto& [name, answer] :
         {std::pair{"Recede", &CadRow::recede}, std::pair{"BRepMesh", &CadRow::brep_mesh},
          std::pair{"BRepMesh, wide angle", &CadRow::wide_angle}}) {
      Summary all;
      for (const CadRow& row : rows) {
        if (row.share == share) all.add(row.*answer, row.deflection);
      }
      text += fmt::format("| {:g} | {} | {} | {:.2f} | {:.2f} | {} of {} ; {} | {} | {} | {} | {} | {} |\n",
                          share, name, all.triangles, all.cpu, all.wall, all.over, all.models, all.faces_over,
                          ratio_text(all.worst), all.missing, all.closed_open, all.inverted, all.failed);
    }
  }
  return text + '\n';
}

std::string details(const std::vector<CadRow>& rows, double share) {
  std::string text = fmt::format(
      "**Deflection {:g} of the diagonal.** Recede ; BRepMesh ; BRepMesh with a wide angle\n\n"
      "| model | faces | triangles | processor s | wall s | MB | deviation over deflection | proved | faces "
      "over | faces missing | open edges (of closed bodies) | inverted |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      share);
  MeanRatio triangles, wide, cpu, cpu_wide;
  for (const CadRow& row : rows) {
    if (row.share != share) continue;
    text += row_line(row);
    if (!row.recede.figures) continue;
    const CadFigures& ours = *row.recede.figures;
    for (const auto& [answer, n, seconds] :
         {std::tuple{&row.brep_mesh, &triangles, &cpu}, std::tuple{&row.wide_angle, &wide, &cpu_wide}}) {
      if (!answer->figures) continue;
      n->add(double(ours.judgement.triangles), double(answer->figures->judgement.triangles));
      seconds->add(ours.total.cpu, answer->figures->total.cpu);
    }
  }
  return text + fmt::format(
                    "\nRecede over BRepMesh, geometric mean: triangles {:.2f}, processor seconds "
                    "{:.2f}; over that with a wide angle: {:.2f} and {:.2f}.\n\n",
                    triangles.mean(), cpu.mean(), wide.mean(), cpu_wide.mean());
}

std::string stages(const std::vector<CadRow>& rows) {
  std::string text =
      "**Where Recede's processor seconds go,** and triangles of a processor second\n\n| model | deflection "
      "| "
      "surfaces | seams | collapses | triangles | thousand a second, triangles alone ; all | BRepMesh |\n"
      "|---|---|---|---|---|---|---|---|\n";
  for (const CadRow& row : rows) {
    if (!row.recede.figures) continue;
    const CadFigures& f = *row.recede.figures;
    const double n = 1e-3 * static_cast<double>(f.judgement.triangles);
    const std::string theirs =
        row.brep_mesh.figures
            ? fmt::format("{:.0f}", 1e-3 * static_cast<double>(row.brep_mesh.figures->judgement.triangles) /
                                        row.brep_mesh.figures->total.cpu)
            : "-";
    text += fmt::format("| {} | {:g} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.0f} ; {:.0f} | {} |\n",
                        row.model, row.share, f.surfaces.cpu, f.seams.cpu, f.collapses.cpu,
                        f.triangulation.cpu, n / f.triangulation.cpu, n / f.total.cpu, theirs);
  }
  return text + '\n';
}

std::string equal_table(const std::vector<CadRow>& rows) {
  std::string text =
      "**Triangles for the same measured deviation:** the fewest of some settings that keep within the "
      "deflection. Settings and deviations in its units; BRepMesh with a wide angle\n\n| model | "
      "Recede: triangles ; setting ; deviation | BRepMesh: triangles ; setting ; deviation | ratio |\n"
      "|---|---|---|---|\n";
  MeanRatio mean;
  const auto text_of = [](const CadAnswer& answer) -> std::string {
    if (!answer.figures) return "-";
    const CadEqual& equal = answer.figures->equal;
    if (equal.triangles == 0) return "none found";
    return fmt::format("{} ; {:.3g} ; {:.2f}", equal.triangles, equal.setting, equal.deviation);
  };
  for (const CadRow& row : rows) {
    const std::string ours = text_of(row.recede), theirs = text_of(row.wide_angle);
    const bool is_there = row.recede.figures && row.recede.figures->equal.triangles > 0;
    if (!is_there) continue;
    std::string ratio = "-";
    if (row.wide_angle.figures && row.wide_angle.figures->equal.triangles > 0) {
      const auto n = double(row.recede.figures->equal.triangles),
                 of_them = double(row.wide_angle.figures->equal.triangles);
      mean.add(n, of_them);
      ratio = fmt::format("{:.2f}", n / of_them);
    }
    text += fmt::format("| {} | {} | {} | {} |\n", row.model, ours, theirs, ratio);
  }
  return text + fmt::format("\nGeometric mean of the ratios: {:.2f}.\n\n", mean.mean());
}

std::string levels_table(const std::vector<CadLevelsRow>& levels) {
  std::string text =
      "**Every second face at a twentieth of the deflection:** open edges with one deflection, then with "
      "two\n\n"
      "| model | Recede | BRepMesh | triangles |\n|---|---|---|---|\n";
  const auto text_of = [](const CadLevelsAnswer& answer) {
    return answer.levels ? fmt::format("{} ; {}", answer.levels->even, answer.levels->odd_finer) : "-";
  };
  for (const CadLevelsRow& row : levels) {
    text += fmt::format("| {} | {} | {} | {} ; {} |\n", row.model, text_of(row.recede),
                        text_of(row.brep_mesh), row.recede.levels ? count(row.recede.levels->triangles) : "-",
                        row.brep_mesh.levels ? count(row.brep_mesh.levels->triangles) : "-");
  }
  return text + '\n';
}

/// What Recede says or the samples say isn't within the deflection, and what failed.
std::string refused_list(const std::vector<CadRow>& rows) {
  std::string text = "**Recede not within the deflection**\n\n";
  const std::size_t empty = text.size();
  for (const CadRow& row : rows) {
    const std::string where = fmt::format("{} at {:g}", row.model, row.share);
    if (!row.recede.figures) {
      text += fmt::format("- {}: {}\n", where, row.recede.failure);
      continue;
    }
    const CadFigures& f = *row.recede.figures;
    if (f.refused == 0 && f.judgement.faces_over == 0 && f.judgement.faces_missing == 0 &&
        f.judgement.inverted == 0) {
      continue;
    }
    text += fmt::format(
        "- {}: {} patches refused, proved {:.3g}, sampled {:.3g} of the deflection, {} faces "
        "over, {} missing, {} triangles inverted\n",
        where, f.refused, f.bound / row.deflection, f.judgement.deviation / row.deflection,
        f.judgement.faces_over, f.judgement.faces_missing, f.judgement.inverted);
  }
  if (text.size() == empty) text += "- nothing\n";
  return text + '\n';
}

nlohmann::json json_of(const CadSeconds& seconds) {
  return {{"processor", seconds.cpu}, {"wall", seconds.wall}};
}

nlohmann::json json_of(const CadAnswer& answer, double deflection) {
  if (!answer.figures) return {{"failure", answer.failure}};
  const CadFigures& f = *answer.figures;
  const CadJudgement& j = f.judgement;
  nlohmann::json json{{"triangles", j.triangles},
                      {"seconds", json_of(f.total)},
                      {"peak_bytes", f.peak_bytes},
                      {"deviation_over_deflection", j.deviation / deflection},
                      {"faces_over", j.faces_over},
                      {"faces_missing", j.faces_missing},
                      {"inverted", j.inverted},
                      {"open_edges", j.open_edges},
                      {"open_edges_of_closed_bodies", j.closed_open_edges}};
  if (f.equal.triangles > 0) {
    json["equal_deviation"] = {{"triangles", f.equal.triangles},
                               {"setting_over_deflection", f.equal.setting},
                               {"deviation_over_deflection", f.equal.deviation}};
  }
  return json;
}

nlohmann::json json_of_ours(const CadAnswer& answer, double deflection) {
  nlohmann::json json = json_of(answer, deflection);
  if (!answer.figures) return json;
  const CadFigures& f = *answer.figures;
  json["bound_over_deflection"] = f.bound / deflection;
  json["refused"] = f.refused;
  json["vanished"] = f.vanished;
  json["surface_gap_over_deflection"] = f.judgement.surface_gap / deflection;
  json["stages"] = {{"surfaces", json_of(f.surfaces)},
                    {"seams", json_of(f.seams)},
                    {"collapses", json_of(f.collapses)},
                    {"triangles", json_of(f.triangulation)}};
  return json;
}

}  // namespace

std::string cad_report(const std::vector<CadRow>& rows, const std::vector<CadLevelsRow>& levels) {
  std::string text = summary(rows);
  for (const double share : shares_of(rows)) text += details(rows, share);
  return text + equal_table(rows) + levels_table(levels) + stages(rows) + refused_list(rows);
}

std::string cad_json(const std::vector<CadRow>& rows, const std::vector<CadLevelsRow>& levels) {
  nlohmann::json json{{"tessellations", nlohmann::json::array()}, {"levels", nlohmann::json::array()}};
  for (const CadRow& row : rows) {
    json["tessellations"].push_back({{"model", row.model},
                                     {"faces", row.faces},
                                     {"deflection_over_diagonal", row.share},
                                     {"recede", json_of_ours(row.recede, row.deflection)},
                                     {"brep_mesh", json_of(row.brep_mesh, row.deflection)},
                                     {"brep_mesh_wide_angle", json_of(row.wide_angle, row.deflection)}});
  }
  const auto of_levels = [](const CadLevelsAnswer& answer) -> nlohmann::json {
    if (!answer.levels) return {{"failure", answer.failure}};
    return {{"open_edges_of_one_deflection", answer.levels->even},
            {"open_edges_of_two", answer.levels->odd_finer},
            {"triangles", answer.levels->triangles}};
  };
  for (const CadLevelsRow& row : levels) {
    json["levels"].push_back(
        {{"model", row.model}, {"recede", of_levels(row.recede)}, {"brep_mesh", of_levels(row.brep_mesh)}});
  }
  return json.dump(1) + '\n';
}

}  // namespace recede::bench
