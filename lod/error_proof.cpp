#include <recede/lod/detail/error_proof.h>

#include <chrono>

namespace recede::detail {
namespace {

using Clock = std::chrono::steady_clock;

}  // namespace

ErrorProof::ErrorProof(const PolygonSoup& input) : input_(input) {
  const Box3 box = bounding_box(input);
  if (!box.isEmpty()) diagonal_ = box.diagonal().norm();
}

MeshDistance ErrorProof::measure(const PolygonSoup& simplified, std::optional<double> limit,
                                 Progress* progress) {
  const auto start = Clock::now();
  if (!meter_) meter_.emplace(input_);
  // The vertices are samples enough to start from; what lies between them is bounded.
  MeshDistance distance =
      meter_->to(simplified, {.samples = 0, .bound_tolerance = k_proof_tolerance, .limit = limit}, progress);
  seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
  return distance;
}

std::optional<ErrorInterval> ErrorProof::prove(const PolygonSoup& simplified, Progress* progress) {
  if (input_.n_faces() == 0 || simplified.n_faces() == 0) return std::nullopt;
  const MeshDistance distance = measure(simplified, std::nullopt, progress);
  return ErrorInterval{distance.max_lower, *distance.max_bound};
}

LimitCheck ErrorProof::check(const PolygonSoup& simplified, double limit, Progress* progress) {
  if (input_.n_faces() == 0 || simplified.n_faces() == 0) return {};
  MeshDistance distance = measure(simplified, limit, progress);
  return {distance.max_lower, std::move(distance.beyond)};
}

ProvedRun run_to_proved_error(Simplifier& simplifier, const Limits& limits,
                              const std::vector<Vec3>& source_positions, ErrorProof& proof,
                              Progress* progress) {
  // Runs to come near the limit; if none of them kept it, some more that aim lower each time.
  constexpr int k_runs = 8, k_careful_runs = 12;
  constexpr double k_close = 0.8;  // share of the limit that is near enough
  constexpr double k_many = 0.02;  // share of the faces beyond the limit that is too many to hold
  constexpr double k_raise = 1.5, k_lower = 0.5;
  const double scale = simplifier.table().scale;
  const double limit = std::max(limits.error * scale, k_proof_rounding * proof.diagonal());
  double estimate = limit;
  ProvedRun result;
  Simplifier::State best = simplifier.state();
  bool kept = false;
  for (int run = 0; run < (kept ? k_runs : k_runs + k_careful_runs); ++run) {
    Limits estimated = limits;
    estimated.error = estimate / scale;
    const StopReason why = simplifier.run(estimated, progress);
    const PolygonSoup reached = to_soup(simplifier.table(), source_positions);
    const LimitCheck check = proof.check(reached, limit, progress);
    if (check.beyond.empty()) {
      kept = true;
      best = simplifier.state();
      result = {why, limit};
      if (why != StopReason::error_target || check.lower >= k_close * limit) break;
      estimate *= k_raise;
      continue;
    }
    simplifier.restore(best);
    const auto most = static_cast<std::size_t>(k_many * static_cast<double>(reached.n_faces()));
    if (check.beyond.size() > most || (!kept && run >= k_runs)) estimate *= k_lower;
    simplifier.hold(check.beyond);
    best.table.held = simplifier.table().held;
  }
  simplifier.restore(best);
  simplifier.release();
  return result;
}

}  // namespace recede::detail
