#include "bench_report.h"
#include "progressive_run.h"

#include <fmt/format.h>

namespace recede::bench {
namespace {

/// A line of a table: what it says of a model.
struct Line {
  std::string name;
  std::function<std::string(const ProgressiveRow&)> cell;
};

/// What `text` makes of the figures, or why there are none.
template <class Figures>
std::function<std::string(const ProgressiveRow&)> cell(Measured<Figures> ProgressiveRow::*measured,
                                                       std::string (*text)(const ProgressiveRow&,
                                                                           const Figures&)) {
  return [=](const ProgressiveRow& row) {
    const auto& [figures, failure] = row.*measured;
    return figures ? text(row, *figures) : failure;
  };
}

/// Models across, as in the other tables.
std::string table(const std::string& title, const std::vector<ProgressiveRow>& rows,
                  const std::vector<Line>& lines) {
  std::string text = fmt::format("**{}**\n\n| |", title), rule = "|---|";
  for (const ProgressiveRow& row : rows) {
    text += fmt::format(" {} |", row.model);
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const Line& line : lines) {
    text += fmt::format("| {} |", line.name);
    for (const ProgressiveRow& row : rows) text += fmt::format(" {} |", line.cell(row));
    text += '\n';
  }
  return text + '\n';
}

double bits_per_vertex(const ProgressiveRow& row, std::size_t bytes) {
  return 8 * static_cast<double>(bytes) / static_cast<double>(row.vertices);
}

double million_faces_per_second(const ProgressiveRow& row, std::size_t base_faces, double seconds) {
  return 1e-6 * static_cast<double>(row.faces - base_faces) / seconds;
}

std::string file_text(const ProgressiveRow& row, const ProgressiveFigures::File& file) {
  const std::string numbering =
      file.numbering_bytes == 0
          ? ""
          : fmt::format(" and {:.1f} of numbering", bits_per_vertex(row, file.numbering_bytes));
  return fmt::format("{:.1f}{} ; {:.2g} ; {:.2g}", bits_per_vertex(row, file.bytes - file.numbering_bytes),
                     numbering, file.write_seconds, file.read_seconds);
}

std::vector<Line> progressive_lines() {
  using Row = ProgressiveRow;
  using Ours = ProgressiveFigures;
  constexpr auto ours = &Row::ours;
  return {
      {"faces, of the base",
       cell<Ours>(ours, [](const Row& row,
                           const Ours& f) { return fmt::format("{}, {}", row.faces, f.base_faces); })},
      {"`simplify` to the base ; building ; ratio",
       cell<Ours>(ours,
                  [](const Row&, const Ours& f) {
                    return fmt::format("{:.2g} ; {:.2g} ; {:.2f}", f.simplify_seconds, f.build_seconds,
                                       f.build_seconds / f.simplify_seconds);
                  })},
      {"proof of all levels",
       cell<Ours>(ours, [](const Row&, const Ours& f) { return fmt::format("{:.2g}", f.proof_seconds); })},
      {"refining ; coarsening, million faces per second",
       cell<Ours>(ours,
                  [](const Row& row, const Ours& f) {
                    return fmt::format("{:.0f} ; {:.0f}",
                                       million_faces_per_second(row, f.base_faces, f.refine_seconds),
                                       million_faces_per_second(row, f.base_faces, f.coarsen_seconds));
                  })},
      {"floats: bits per vertex ; writing ; reading",
       cell<Ours>(ours, [](const Row& row, const Ours& f) { return file_text(row, f.lossless); })},
      {fmt::format("{} bits: the same", k_bits),
       cell<Ours>(ours, [](const Row& row, const Ours& f) { return file_text(row, f.quantised); })},
      {"OpenMesh ModProgMesh: building ; writing ; bits per vertex, floats",
       cell<ProgressivePeerFigures>(&Row::openmesh, [](const Row& row, const ProgressivePeerFigures& f) {
         return fmt::format("{:.2g} ; {:.2g} ; {:.1f}", f.build_seconds, f.write_seconds,
                            bits_per_vertex(row, f.bytes));
       })}};
}

std::vector<Line> texture_lines() {
  using Row = ProgressiveRow;
  using Texture = TextureFigures;
  constexpr auto texture = &Row::texture;
  return {{"atlas: seconds ; charts ; L2 stretch",
           cell<Texture>(texture,
                         [](const Row&, const Texture& f) {
                           return fmt::format("{:.2g} ; {} ; {:.3f}", f.atlas_seconds, f.charts, f.stretch);
                         })},
          {"`texture_deviation`: seconds ; RMS",
           cell<Texture>(texture,
                         [](const Row&, const Texture& f) {
                           return fmt::format("{:.2g} ; {:.3g}", f.deviation_seconds, 1e4 * f.deviation_rms);
                         })},
          {"`volume`, half-edge: seconds ; RMS", cell<Texture>(texture, [](const Row&, const Texture& f) {
             return fmt::format("{:.2g} ; {:.3g}", f.volume_seconds, 1e4 * f.volume_rms);
           })}};
}

std::vector<Line> map_lines() {
  using Row = ProgressiveRow;
  using Maps = MapFigures;
  constexpr auto maps = &Row::maps;
  return {{"seconds",
           cell<Maps>(maps, [](const Row&, const Maps& f) { return fmt::format("{:.2g}", f.seconds); })},
          {"RMS bare ; displaced", cell<Maps>(maps,
                                              [](const Row&, const Maps& f) {
                                                return fmt::format("{:.3g} ; {:.3g}", 1e4 * f.bare_rms,
                                                                   1e4 * f.rms);
                                              })},
          {"maximum bare ; displaced, 1e-3", cell<Maps>(maps,
                                                        [](const Row&, const Maps& f) {
                                                          return fmt::format("{:.3g} ; {:.3g}",
                                                                             1e3 * f.bare_max, 1e3 * f.max);
                                                        })},
          {"missed of all texels", cell<Maps>(maps, [](const Row&, const Maps& f) {
             return fmt::format("{} of {}", f.missed, f.texels);
           })}};
}

std::vector<Line> walk_lines() {
  using Row = ProgressiveRow;
  using Walk = WalkFigures;
  constexpr auto walk = &Row::walk;
  return {
      {"faces ; splits and merges, medians",
       cell<Walk>(
           walk, [](const Row&, const Walk& f) { return fmt::format("{:.0f} ; {:.0f}", f.faces, f.moves); })},
      {"milliseconds: median ; 95 of 100 ; slowest",
       cell<Walk>(walk,
                  [](const Row&, const Walk& f) {
                    return fmt::format("{:.2g} ; {:.2g} ; {:.2g}", f.median, f.slow, f.slowest);
                  })},
      {"first view, from the base",
       cell<Walk>(walk, [](const Row&, const Walk& f) { return fmt::format("{:.2g}", f.first); })},
      {"setting up, seconds",
       cell<Walk>(walk, [](const Row&, const Walk& f) { return fmt::format("{:.2g}", f.setup_seconds); })}};
}

using Named = std::vector<std::pair<const char*, double>>;

double count(std::size_t number) { return static_cast<double>(number); }

Named named(const ProgressiveFigures& f) {
  return {{"base_faces", count(f.base_faces)},
          {"simplify_seconds", f.simplify_seconds},
          {"build_seconds", f.build_seconds},
          {"proof_seconds", f.proof_seconds},
          {"refine_seconds", f.refine_seconds},
          {"coarsen_seconds", f.coarsen_seconds},
          {"lossless_bytes", count(f.lossless.bytes)},
          {"lossless_numbering_bytes", count(f.lossless.numbering_bytes)},
          {"lossless_write_seconds", f.lossless.write_seconds},
          {"lossless_read_seconds", f.lossless.read_seconds},
          {"quantised_bytes", count(f.quantised.bytes)},
          {"quantised_write_seconds", f.quantised.write_seconds},
          {"quantised_read_seconds", f.quantised.read_seconds}};
}

Named named(const ProgressivePeerFigures& f) {
  return {{"base_faces", count(f.base_faces)},
          {"build_seconds", f.build_seconds},
          {"write_seconds", f.write_seconds},
          {"bytes", count(f.bytes)}};
}

Named named(const TextureFigures& f) {
  return {{"charts", count(f.charts)},
          {"atlas_seconds", f.atlas_seconds},
          {"l2_stretch", f.stretch},
          {"deviation_seconds", f.deviation_seconds},
          {"deviation_rms_share_of_diagonal", f.deviation_rms},
          {"volume_seconds", f.volume_seconds},
          {"volume_rms_share_of_diagonal", f.volume_rms}};
}

Named named(const MapFigures& f) {
  return {{"faces", count(f.faces)},
          {"texels", count(f.texels)},
          {"missed", count(f.missed)},
          {"seconds", f.seconds},
          {"bare_rms_share_of_diagonal", f.bare_rms},
          {"rms_share_of_diagonal", f.rms},
          {"bare_max_share_of_diagonal", f.bare_max},
          {"max_share_of_diagonal", f.max}};
}

Named named(const WalkFigures& f) {
  return {{"setup_seconds", f.setup_seconds},
          {"first_milliseconds", f.first},
          {"median_milliseconds", f.median},
          {"slow_milliseconds", f.slow},
          {"slowest_milliseconds", f.slowest},
          {"faces", f.faces},
          {"moves", f.moves}};
}

}  // namespace

std::string progressive_tables(const std::vector<ProgressiveRow>& rows) {
  return table("Progressive meshes: processor seconds", rows, progressive_lines()) +
         table(fmt::format("A new atlas, and {:g} % of the faces with it: processor seconds ; RMS in 1e-4",
                           100 * k_texture_share),
               rows, texture_lines()) +
         table(fmt::format("Maps of {} texels on {:g} % of the faces: processor seconds ; RMS in 1e-4",
                           k_map_size, 100 * k_map_share),
               rows, map_lines()) +
         table(fmt::format("A walk of {} views at an error of one pixel", k_walk_frames), rows, walk_lines());
}

// A line for each figure: the measurements have nothing in common.
std::string progressive_csv(const std::vector<ProgressiveRow>& rows) {
  std::string text = "model,faces,vertices,measurement,figure,value\n";
  for (const ProgressiveRow& row : rows) {
    const auto add = [&](const char* measurement, const auto& measured) {
      const std::string start =
          fmt::format("{},{},{},{},", quoted(row.model), row.faces, row.vertices, measurement);
      if (!measured.figures) {
        text += start + "failure," + quoted(measured.failure) + '\n';
        return;
      }
      for (const auto& [name, value] : named(*measured.figures))
        text += fmt::format("{}{},{:.6g}\n", start, name, value);
    };
    add("progressive", row.ours);
    add("OpenMesh", row.openmesh);
    add("texture", row.texture);
    add("maps", row.maps);
    add("walk", row.walk);
  }
  return text;
}

}  // namespace recede::bench
