#include "systems.h"

#include <fmt/format.h>

#include <algorithm>

namespace recede::bench {
namespace {

Outcome run(const PolygonSoup& soup, const SimplifyTarget& target, CostPolicy cost) {
  Outcome outcome;
  SimplifyOptions options;
  options.target = target;
  options.cost = cost;
  options.prove_error = false;
  const CallMeter meter;
  SimplifySoupResult simplified = simplify(soup, options);
  meter.stop(outcome);
  outcome.remark = why_it_stopped_early(simplified);
  outcome.result = std::move(simplified.soup);
  // The same once more with its proof, which is timed by itself.
  options.prove_error = true;
  const SimplifySoupResult proved = simplify(soup, options);
  outcome.reported_error = proved.error_bound.value_or(0);
  outcome.proof_seconds = proved.proof_seconds;
  return outcome;
}

System make(const std::string& name, const std::string& label, CostPolicy cost) {
  return {.name = name,
          .label = label,
          .takes_polygons = true,
          .run = [cost](const PolygonSoup& soup, const SimplifyTarget& target) {
            return run(soup, target, cost);
          }};
}

}  // namespace

std::string why_it_stopped_early(const SimplifyReport& report) {
  if (report.stop_reason != StopReason::no_collapse_left) return {};
  std::string text(to_string(report.stop_reason));
  const auto& refused = report.refused.counts;
  const auto most = std::max_element(refused.begin(), refused.end());
  if (*most == 0) return text;
  return text +
         fmt::format(", most are refused for: {}", to_string(static_cast<Refusal>(most - refused.begin())));
}

void add_our_systems(std::vector<System>& systems) {
  System volume = make("Recede, 1 thread", "Recede, 1", CostPolicy::volume);
  volume.in_growth = true;
  systems.push_back(volume);
  volume.name = "Recede, all threads";
  volume.label = "Recede, all";
  volume.all_threads = true;
  systems.push_back(volume);
  System deviation = make("Recede normal deviation 0.99", "Recede normals", CostPolicy::normal_deviation);
  deviation.runs_to_its_end = true;
  systems.push_back(deviation);
}

}  // namespace recede::bench
