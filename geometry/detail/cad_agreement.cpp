#include <recede/geometry/detail/cad_agreement.h>
#include <recede/geometry/detail/cad_trimming.h>

#include <fmt/format.h>

#include <algorithm>

namespace recede::detail {

namespace {

constexpr int k_samples = 16;
/// Of a part's size: what rounding and fitting may add to the file's tolerances.
constexpr double k_slack = 1e-9;

struct Use {
  std::size_t patch;
  TrimmingCurve* curve;
};

Vec3 at(const CadPart& part, const Use& use, double share) {
  const ParameterRange domain = use.curve->curve.domain();
  const double x = use.curve->runs_against ? 1 - share : share;
  return evaluate(part.patches[use.patch].surface,
                  evaluate(use.curve->curve, domain.begin + x * domain.length()));
}

/// Ends may be apart by the tolerances of corners, which are wider: places between tell.
double distance(const CadPart& part, const Use& a, const Use& b) {
  double largest = 0;
  for (int i = 1; i < k_samples; ++i) {
    const double share = static_cast<double>(i) / k_samples;
    largest = std::max(largest, (at(part, a, share) - at(part, b, share)).norm());
  }
  return largest;
}

std::vector<std::vector<Use>> uses_of_edges(CadPart& part, std::size_t n_edges) {
  std::vector<std::vector<Use>> uses(n_edges);
  for (std::size_t p = 0; p < part.patches.size(); ++p) {
    for (TrimmingLoop& loop : part.patches[p].loops) {
      for (TrimmingCurve& curve : loop.curves) {
        if (curve.edge != k_no_index) uses[curve.edge].push_back({p, &curve});
      }
    }
  }
  return uses;
}

double size_of(const CadPart& part) {
  Box3 box;
  for (const TrimmedPatch& patch : part.patches) {
    for (const Vec3& point : patch.surface.points) box.extend(point);
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

}  // namespace

std::vector<std::string> separate_distant_uses(CadPart& part, const std::vector<double>& edge_tolerances) {
  std::vector<std::string> lines;
  const double slack = k_slack * size_of(part);
  for (const std::vector<Use>& uses : uses_of_edges(part, edge_tolerances.size())) {
    for (std::size_t i = 1; i < uses.size(); ++i) {
      const Index edge = uses[i].curve->edge;
      const double gap = distance(part, uses[0], uses[i]);
      if (gap <= 2 * k_tolerance_slack * edge_tolerances[edge] + slack) continue;
      lines.push_back(
          fmt::format("edge {}: curves of \"{}\" and \"{}\" are {:.3g} apart, and the second is on its own",
                      edge, part.patches[uses[0].patch].name, part.patches[uses[i].patch].name, gap));
      uses[i].curve->edge = k_no_index;
      uses[i].curve->runs_against = false;
    }
  }
  return lines;
}

bool is_closed(const CadPart& part) {
  std::vector<int> uses(part.n_edges, 0);
  for (const TrimmedPatch& patch : part.patches) {
    for (const TrimmingLoop& loop : patch.loops) {
      for (const TrimmingCurve& curve : loop.curves) {
        if (curve.edge != k_no_index) ++uses[curve.edge];
      }
    }
  }
  return !part.patches.empty() && std::all_of(uses.begin(), uses.end(), [](int n) { return n == 2; });
}

}  // namespace recede::detail
