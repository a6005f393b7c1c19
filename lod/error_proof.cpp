#include <recede/lod/detail/error_proof.h>

#include <chrono>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

/// Width of the proved interval relative to its upper end.
constexpr double k_tolerance = 0.05;
/// Errors below this share of the diagonal are rounding, and count as none.
constexpr double k_rounding = 1e-12;

using Clock = std::chrono::steady_clock;

}  // namespace

ErrorProof::ErrorProof(const PolygonSoup& input) : input_(input) {
  const Box3 box = bounding_box(input);
  if (!box.isEmpty()) diagonal_ = box.diagonal().norm();
}

std::optional<ErrorInterval> ErrorProof::prove(const PolygonSoup& simplified, Progress* progress) {
  if (input_.n_faces() == 0 || simplified.n_faces() == 0) return std::nullopt;
  const auto start = Clock::now();
  if (!meter_) meter_.emplace(input_);
  // The vertices are samples enough to start from; what lies between them is bounded.
  const MeshDistance distance =
      meter_->to(simplified, {.samples = 0, .bound_tolerance = k_tolerance}, progress);
  seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
  return ErrorInterval{distance.max_lower, *distance.max_bound};
}

namespace {

/// Guesses of the estimate at which the proved error meets its limit: each from how the last one came out, between
/// the largest that kept the limit and the smallest that broke it.
class EstimateSearch {
 public:
  explicit EstimateSearch(double limit) : limit_(limit), guess_(k_first * limit) {}

  double guess() const { return guess_; }
  bool is_close() const { return close_ || above_ <= k_narrow * below_; }

  /// `proved`: the error at the present guess. True when it keeps the limit.
  bool learn(double proved) {
    const bool kept = proved <= limit_;
    (kept ? below_ : above_) = guess_;
    close_ = kept && proved >= k_close * limit_;
    double next = proved > 0 ? guess_ * k_aim * limit_ / proved : k_step * guess_;
    if (!(next > below_ && next < above_)) {
      next = std::isfinite(above_) ? 0.5 * (below_ + above_) : k_step * guess_;
    }
    guess_ = next;
    return kept;
  }

 private:
  static constexpr double k_first = 0.7, k_aim = 0.95, k_step = 4;
  /// Shares of the limit, and between the ends of the search, that are near enough.
  static constexpr double k_close = 0.9, k_narrow = 1.05;
  double limit_, guess_;
  double below_ = 0, above_ = std::numeric_limits<double>::infinity();
  bool close_ = false;
};

}  // namespace

StopReason run_to_proved_error(Simplifier& simplifier, const Limits& limits,
                               const std::vector<Vec3>& source_positions, ErrorProof& proof,
                               Progress* progress) {
  constexpr int k_runs = 7;
  const double scale = simplifier.table().scale;
  EstimateSearch search(std::max(limits.error * scale, k_rounding * proof.diagonal()));
  Simplifier::State best = simplifier.state();
  for (int run = 0; run < k_runs && !search.is_close(); ++run) {
    Limits estimated = limits;
    estimated.error = search.guess() / scale;
    const StopReason why = simplifier.run(estimated, progress);
    const auto error = proof.prove(to_soup(simplifier.table(), source_positions), progress);
    if (!search.learn(error ? error->upper : 0)) {
      simplifier.restore(best);
      continue;
    }
    best = simplifier.state();
    if (why != StopReason::error_target) return why;
  }
  return StopReason::error_target;
}

}  // namespace recede::detail
