#include "round_trips.h"

#include "hard_cases.h"
#include "same_bits.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/pmesh.h>

#include <fmt/format.h>

#include <algorithm>

namespace recede::bench {
namespace {

namespace fs = std::filesystem;

double bits_per_vertex(const PmeshReport& report, const PolygonSoup& soup) {
  return 8.0 * static_cast<double>(report.bytes) /
         static_cast<double>(std::max<std::size_t>(soup.positions.size(), 1));
}

/// What came of a model: the cells of its row behind the name.
struct RoundTrip {
  std::string cells;
  bool identical = false, refused = false;
};

RoundTrip round_trip(const PolygonSoup& soup, const fs::path& file) {
  ProgressiveOptions options;
  options.simplify.target.ratio = 0.01;
  options.simplify.prove_error = false;
  RoundTrip row;
  row.cells = fmt::format("{} | {}", soup.positions.size(), soup.n_faces());
  try {
    const ProgressiveMesh mesh = build_progressive_mesh(soup, options);
    PmeshReport small;
    encode_pmesh(mesh, {.position_bits = 14}, &small);
    PmeshReport lossless;
    encode_pmesh(mesh, {}, &lossless);
    write_pmesh(file, mesh, {.keep_numbering = true});
    const ProgressiveMesh back = read_pmesh(file);
    ProgressiveCursor cursor(back);
    cursor.move_to(back.n_splits());
    const std::string difference = test::first_difference(cursor.soup(), soup);
    row.identical = difference.empty();
    row.cells +=
        fmt::format(" | {} | {:.1f} | {:.1f} | {}", lossless.positions, bits_per_vertex(lossless, soup),
                    bits_per_vertex(small, soup), row.identical ? "yes" : "**no**: " + difference);
  } catch (const InputError& error) {
    row.refused = true;
    row.cells += fmt::format(" | | | | refused: {}", error.what());
  }
  return row;
}

}  // namespace

BenchSection run_round_trips(const BenchOptions& options) {
  std::vector<std::pair<std::string, fs::path>> files;
  for (const auto& entry : fs::directory_iterator(options.data))
    files.emplace_back(entry.path().filename().string(), entry.path());
  std::sort(files.begin(), files.end());
  fs::create_directories(options.out);
  const fs::path file = options.out / "round_trip.pmesh";
  std::string text =
      "| model | vertices | faces | positions | lossless, bits/vertex | 14 bits | identical |\n"
      "|---|---|---|---|---|---|---|\n";
  std::size_t n = 0, identical = 0, refused = 0;
  const auto add = [&](const std::string& name, const PolygonSoup& soup) {
    const RoundTrip row = round_trip(soup, file);
    text += fmt::format("| {} | {} |\n", name, row.cells);
    ++n;
    identical += row.identical ? 1 : 0;
    refused += row.refused ? 1 : 0;
  };
  for (const auto& [name, path] : files) {
    if (!is_wanted(name, options.models)) continue;
    try {
      add(name, read_soup(path));
    } catch (const InputError& error) {
      text += fmt::format("| {} | | | | | | not read: {} |\n", name, error.what());
    }
  }
  for (const test::HardCase& hard_case : test::hard_cases()) {
    if (is_wanted(hard_case.name, options.models)) add("hard case: " + hard_case.name, hard_case.soup);
  }
  fs::remove(file);
  text += fmt::format("\n{} of {} identical, {} refused\n", identical, n, refused);
  return {.markdown = text};
}

}  // namespace recede::bench
