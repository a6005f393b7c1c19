// Certified errors of a simplification: what a level is off by, and how far one may go.
#pragma once

#include <recede/geometry/mesh_distance.h>
#include <recede/lod/detail/simplifier.h>

#include <optional>

namespace recede::detail {

/// The two-sided distance between the input and a simplified surface lies in [lower, upper], object units.
struct ErrorInterval {
  double lower = 0, upper = 0;
};

/// Proves errors against one input, and counts what that costs.
class ErrorProof {
 public:
  /// `input` must live as long as the proof.
  explicit ErrorProof(const PolygonSoup& input);

  /// Nothing when either surface has no faces.
  std::optional<ErrorInterval> prove(const PolygonSoup& simplified, Progress* progress);

  double diagonal() const { return diagonal_; }
  double seconds() const { return seconds_; }

 private:
  const PolygonSoup& input_;
  std::optional<DistanceMeter> meter_;  // built with the first proof
  double diagonal_ = 0, seconds_ = 0;
};

/// Simplifies as far as the proved error keeps `limits.error`, here the true two-sided distance in table units:
/// a few runs, each stopping at an estimate, that come closer to the limit. The last that kept it is restored.
StopReason run_to_proved_error(Simplifier& simplifier, const Limits& limits,
                               const std::vector<Vec3>& source_positions, ErrorProof& proof,
                               Progress* progress);

}  // namespace recede::detail
