// Certified errors of a simplification: what a level is off by, and how far one may go.
#pragma once

#include <recede/geometry/mesh_distance.h>
#include <recede/lod/detail/simplifier.h>

#include <limits>
#include <optional>

namespace recede::detail {

/// Width of a proved interval relative to its upper end.
inline constexpr double k_proof_tolerance = 0.05;
/// Errors below this share of the model's size are rounding, and count as none.
inline constexpr double k_proof_rounding = 1e-12;

/// The two-sided distance between the input and a simplified surface lies in [lower, upper], object units.
struct ErrorInterval {
  double lower = 0, upper = 0;
};

/// Whether an error limit is kept.
struct LimitCheck {
  double lower = 0;          ///< a distance that occurs, object units
  std::vector<Vec3> beyond;  ///< places that may be farther than the limit; none: it is proved
};

/// Proves errors against one input, and counts what that costs.
class ErrorProof {
 public:
  /// `input` must live as long as the proof.
  explicit ErrorProof(const PolygonSoup& input);

  /// Nothing when either surface has no faces.
  std::optional<ErrorInterval> prove(const PolygonSoup& simplified, Progress* progress);

  LimitCheck check(const PolygonSoup& simplified, double limit, Progress* progress);

  double diagonal() const { return diagonal_; }
  double seconds() const { return seconds_; }

 private:
  MeshDistance measure(const PolygonSoup& simplified, std::optional<double> limit, Progress* progress);

  const PolygonSoup& input_;
  std::optional<DistanceMeter> meter_;  // built with the first proof
  double diagonal_ = 0, seconds_ = 0;
};

struct ProvedRun {
  StopReason reason = StopReason::error_target;
  double proved = std::numeric_limits<double>::infinity();  ///< the error is at most this, object units
};

/// Simplifies as far as the proved error keeps `limits.error`, here the true two-sided distance in table
/// units: a few runs that stop at an estimate. Where one went beyond the limit, the next holds the surface;
/// when that is in many places, it stops earlier. The last run that kept the limit is restored; when none
/// did, the state from before.
ProvedRun run_to_proved_error(Simplifier& simplifier, const Limits& limits,
                              const std::vector<Vec3>& source_positions, ErrorProof& proof,
                              Progress* progress);

}  // namespace recede::detail
