// How far two surfaces are from each other.
#pragma once

#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/progress.h>

#include <memory>
#include <optional>

namespace recede {

struct DistanceOptions {
  /// Sample points per surface, spread evenly by area (one stratified sequence per triangle) beside all
  /// vertices.
  std::size_t samples = 200'000;
  /// Width of the certified interval relative to its upper end: `max_bound - max_lower <= tolerance *
  /// max_bound`. Wider, and still true, where that would take more than some fifty million steps, or 200 for
  /// each triangle: surfaces of slivers. Unset: no certified bound is computed.
  std::optional<double> bound_tolerance{};
  /// When set, with a bound: triangles whose certified distance may be larger are listed in `beyond`, object
  /// units, and no time is spent on telling apart what is smaller.
  std::optional<double> limit{};
  /// A certified bound never gets finer than this times the diagonal of both surfaces' box; below that,
  /// distances are noise of double precision.
  double relative_floor = 1e-12;
};

/// One direction: from points of one surface to the nearest point of the other. Lengths are object units.
struct OneSidedDistance {
  double max = 0;          ///< largest sampled distance: a lower bound of the true maximum
  double rms = 0;          ///< square root of the area-weighted mean of the squared sampled distances
  double mean = 0;         ///< area-weighted mean of the sampled distances
  Vec3 at = Vec3::Zero();  ///< where `max` was seen
};

struct MeshDistance {
  OneSidedDistance forward;   ///< from the first surface to the second
  OneSidedDistance backward;  ///< from the second to the first
  double max = 0;             ///< larger of both sampled maxima
  double rms = 0;             ///< both sides pooled, each weighted by its area
  /// Certified, up to rounding in double precision: the two-sided Hausdorff distance of the triangulated
  /// surfaces lies in [max_lower, max_bound].
  std::optional<double> max_bound;
  double max_lower = 0;
  std::vector<Vec3>
      beyond;               ///< a place on each triangle of either surface that may be farther than the limit
  double diagonal = 0;      ///< of the first surface's bounding box
  std::size_t samples = 0;  ///< points evaluated on both surfaces together, vertices included
  double samples_per_unit_area = 0;  ///< sampling density, vertices left out; points per square unit
};

/// Two-sided distance between two polygon surfaces. Polygons with more than three sides stand for the
/// triangles of `triangulate`. Throws `InputError` when either has no faces or
/// positions that aren't finite. Same result for any number of
/// threads.
MeshDistance measure_distance(const PolygonSoup& a, const PolygonSoup& b, const DistanceOptions& options = {},
                              Progress* progress = nullptr);
MeshDistance measure_distance(const PolygonMesh& a, const PolygonMesh& b, const DistanceOptions& options = {},
                              Progress* progress = nullptr);

/// Measures many surfaces against one, whose search tree is built once.
class DistanceMeter {
 public:
  /// Keeps what it needs of `reference`, which may go. Throws `InputError` when it has no faces or positions
  /// that aren't finite.
  explicit DistanceMeter(const PolygonSoup& reference);
  ~DistanceMeter();
  DistanceMeter(const DistanceMeter&) = delete;
  DistanceMeter& operator=(const DistanceMeter&) = delete;

  /// As `measure_distance(reference, other)`, for surfaces of about the same size.
  MeshDistance to(const PolygonSoup& other, const DistanceOptions& options = {},
                  Progress* progress = nullptr) const;

 private:
  struct Measured;
  std::unique_ptr<Measured> measured_;
};

}  // namespace recede
