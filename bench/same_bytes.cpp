#include "same_bytes.h"

#include "different_models.h"

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <cstdint>

namespace recede::bench {
namespace {

std::uint64_t fnv1a(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char byte : bytes) {
    hash ^= static_cast<unsigned char>(byte);
    hash *= 0x100000001b3;
  }
  return hash;
}

std::string fingerprint(const PolygonSoup& soup, CostPolicy cost, std::size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  SimplifyOptions options;
  options.target.ratio = 0.1;
  options.cost = cost;
  return fmt::format("`{:016x}`", fnv1a(test::bytes_of(simplify(soup, options))));
}

}  // namespace

BenchSection compare_threads(const BenchOptions& options) {
  std::string text =
      "| model | kind | faces | `volume`, 1 thread | 2 threads | `normal_deviation`, 1 thread | 2 threads |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const test::DifferentModel& model : test::different_models()) {
    if (!is_wanted(model.name, options.models)) continue;
    const PolygonSoup soup = model.load(options.data.parent_path());
    text += fmt::format("| {} | {} | {} |", model.name, model.kind, soup.n_faces());
    for (const CostPolicy cost : {CostPolicy::volume, CostPolicy::normal_deviation}) {
      if (cost != CostPolicy::volume && !model.small) {
        text += "  |  |";
        continue;
      }
      const std::string one = fingerprint(soup, cost, 1), two = fingerprint(soup, cost, 2);
      text += fmt::format(" {} | {}{} |", one, two, one == two ? "" : " **differs**");
    }
    text += '\n';
  }
  return {.markdown = text};
}

}  // namespace recede::bench
