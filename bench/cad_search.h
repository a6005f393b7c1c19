// Which setting of a mesher gives a measured deviation that is just the one asked for.
#pragma once

#include "cad_meshers.h"

#include <algorithm>

namespace recede::bench {

/// Samples of a face while looking: a fifth, for many runs.
inline constexpr std::size_t k_search_samples = 2'000;

/// `mesh(setting)` gives a judgement. Scales the setting by what was reached, a few times; the fewest
/// triangles within the deflection count.
template <typename Mesh>
CadEqual find_equal(double deflection, const CadJudgement& first, Mesh&& mesh) {
  constexpr int k_runs = 6;
  constexpr double k_near_enough = 0.97, k_most_change = 4, k_over = 1 + 1e-6, k_flat = 1e-3;
  // Beyond, nothing is found in reasonable time.
  constexpr double k_least_setting = 0.02;
  constexpr std::size_t k_most_growth = 20;
  CadEqual best;
  if (!(first.deviation > k_flat * deflection)) return best;
  double setting = deflection;
  double within = 0, beyond = 0;  // settings that were seen to be so
  CadJudgement here = first;
  for (int run = 0;; ++run) {
    const bool is_within = here.deviation <= k_over * deflection;
    if (is_within && (best.triangles == 0 || here.triangles < best.triangles)) {
      best = {setting / deflection, here.deviation / deflection, here.triangles};
    }
    if (run == k_runs || (is_within && here.deviation >= k_near_enough * deflection)) return best;
    if (is_within) {
      within = std::max(within, setting);
    } else {
      beyond = beyond == 0 ? setting : std::min(beyond, setting);
    }
    const double factor = std::clamp(0.99 * deflection / here.deviation, 1 / k_most_change, k_most_change);
    double next = setting * factor;
    if (within > 0 && beyond > within && !(next > within && next < beyond)) next = std::sqrt(within * beyond);
    setting = next;
    if (setting < k_least_setting * deflection || here.triangles > k_most_growth * first.triangles)
      return best;
    here = mesh(setting);
  }
}

}  // namespace recede::bench
