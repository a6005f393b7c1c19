// Which normals of a displaced plane are seen, from every angle: what bump maps and reflectance tables are
// made to agree with displacement by.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/geometry/vec.h>
#include <recede/render/displaced_plane.h>

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace recede {

struct VisibleNormalsOptions {
  int bins = 31;   ///< a side of the square of normals, 1 to 1024; odd, so that +z is in the middle of a bin
  int views = 31;  ///< polar angles: the middles of as many equal parts of 0 to 90 degrees, 1 to 1024
  /// Azimuths from which the viewer looks, 1 to 1024. 1: the mean over all azimuths, for isotropic heights;
  /// more: one distribution for each of as many azimuths, from that of u on, counter-clockwise.
  int azimuths = 1;
  int samples = 131'072;  ///< rays for each view, 2 to 2^30
  /// Replaces every share by the mean of its 3 x 3 neighbourhood (border bins count again where it is cut
  /// off). For few samples; widens what is sharp.
  bool smooth = false;
  /// The normal that counts where a ray lands, by its texture coordinate: a unit vector in the frame of the
  /// plane; nothing where the ray shall not count. Unset: the plane's own. Called in parallel.
  std::function<std::optional<Vec3>(const Vec2& uv)> normal_at{};
};

/// Distributions of the normals that are seen, one for each view. Normals are in the viewer's frame: z is
/// that of the undisplaced plane, x points to where the viewer stands. They are binned in the square of
/// `hemisphere_to_square`, whose bins have equal solid angles.
struct VisibleNormals {
  int bins = 0, views = 0, azimuths = 0;
  /// By view, azimuth, bin of the square's first coordinate, bin of its second. View 0 looks straight down;
  /// views 1 to `views` are those of the options. Each view's shares sum to 1.
  std::vector<double> shares{};
  /// By view and azimuth: about how much of a distribution chance has put into wrong bins (half of the total
  /// variation between two halves of the samples; before smoothing).
  std::vector<double> noise{};
  std::size_t missed = 0;  ///< rays that rounding let through; 0 as far as known

  std::size_t slice_count() const {
    return static_cast<std::size_t>(views + 1) * static_cast<std::size_t>(azimuths);
  }
  std::size_t bin_count() const { return static_cast<std::size_t>(bins) * static_cast<std::size_t>(bins); }
  std::size_t slice_of(int view, int azimuth = 0) const {
    return static_cast<std::size_t>(view) * static_cast<std::size_t>(azimuths) +
           static_cast<std::size_t>(azimuth);
  }
  std::span<const double> slice(std::size_t slice) const {
    return std::span<const double>(shares).subspan(slice * bin_count(), bin_count());
  }
  /// Polar angle of a view, radians: 0 for view 0.
  double view_angle(int view) const;
  /// Of the middle of a bin.
  Vec3 normal_of_bin(std::size_t bin) const;
};

/// Distributions between which a view lies, and how much each of them counts; weights sum to 1.
struct ViewMix {
  int count = 0;
  std::array<std::size_t, 4> slices{};
  std::array<double, 4> weights{};
};

/// Linear between the polar angles and, around the circle, between azimuths; beyond the last view that one.
/// Angles in radians, not negative for the polar one.
ViewMix mix_for_view(int views, int azimuths, double view_angle, double view_azimuth = 0);

/// The distribution for any view: shares as those of a slice.
std::vector<double> normals_for_view(const VisibleNormals& normals, double view_angle,
                                     double view_azimuth = 0);

/// Half of the sum of absolute differences: the share that must move to make one distribution the other.
double total_variation(std::span<const double> a, std::span<const double> b);

/// Rays that are uniform over the plane are uniform over the picture of it, so that counting normals where
/// they land weighs them by the area that is seen (Becker and Max 1993; Ramsey's dissertation on displaced
/// levels of detail). They come down from the height of the map's peaks.
///
/// Places are low-discrepancy points by view: same result for any number of threads. A view of which no ray
/// lands has the distribution of the one before. Throws `OptionError` for options out of range, and
/// `Cancelled`.
VisibleNormals sample_visible_normals(const DisplacedPlane& plane, const VisibleNormalsOptions& options = {},
                                      Progress* progress = nullptr);

/// Throws `InputError` unless there is one share for each bin of each view, none below 0, and the shares of
/// each view sum to 1 up to 1e-9.
void validate(const VisibleNormals& normals);

}  // namespace recede
