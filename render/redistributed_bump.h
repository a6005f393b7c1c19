// Bump mapping that shows, from every angle, as many normals of each kind as displacement would show.
#pragma once

#include <recede/render/normal_distribution.h>

#include <memory>
#include <vector>

namespace recede {

namespace detail {
struct ViewGrids;
}

struct RedistributionOptions {
  /// Exchanges the two directions, as the source prints them. It makes things worse than no redistribution;
  /// for comparison.
  bool literal = false;
  /// Distributions along the second axis are those given the first. False: as the source has them, not
  /// divided by the share of the row; for comparison.
  bool conditional = true;
  /// `normal_for_view` searches the cumulated shares as `redistribute` does, at three times the cost.
  bool exact = false;
};

/// Moves normals so that those of a bump map come to be distributed as the normals seen on the displaced
/// plane (Becker and Max 1993; Ramsey's dissertation on displaced levels of detail): a normal goes to the
/// place that has the same cumulated shares, first along one axis of the square, then along the other. Shares
/// are cumulated beforehand, and linear inside of bins and between views. For shading, that is sampled once
/// more on grids without angles or searches, 0.8 MB of them.
///
/// The source inverts the cumulated shares of the bump map where it should those of the visible normals; the
/// other way round is right, and gives the mean brightness of the displaced surface.
class RedistributedBump {
 public:
  /// Throws what `validate` throws.
  explicit RedistributedBump(const VisibleNormals& normals, const RedistributionOptions& options = {});

  /// A bump map's normal to that for a view. Both in the viewer's frame, unit length; see `VisibleNormals`.
  /// Normals below the horizon are taken as on it; views beyond the last one as that. Radians.
  Vec3 redistribute(const Vec3& normal, double view_angle, double view_azimuth = 0) const;
  /// The way back: the normals that are seen on the displaced plane to those of the bump map.
  Vec3 restore(const Vec3& normal, double view_angle, double view_azimuth = 0) const;

  /// What shading needs. `bump_normal` and `toward_viewer`, of unit length, are in the frame of the surface:
  /// x along u, y along v, z along its normal; so is the result, a unit vector.
  ///
  /// `displaced` is the share of the displacement that the surface has already, 0 to 1, where `bump_normal`
  /// is still that of the whole displacement. At 0 the result is that of `redistribute`, at 1 it is
  /// `bump_normal` but for rounding, and in between mean brightness stays the same.
  ///
  /// At 0 and for `VisibleNormals` of one azimuth, grids are looked up unless the options say otherwise:
  /// normals differ from those of `redistribute` by about 0.01, where it jumps by more, and distributions as
  /// a whole by less than their own noise. Normals that the bump map doesn't have are taken as ones that it
  /// has.
  Vec3 normal_for_view(const Vec3& bump_normal, const Vec3& toward_viewer, double displaced = 0) const;

 private:
  template <std::size_t k_slices>
  struct Mix;
  template <std::size_t k_slices>
  class Cumulated;
  template <std::size_t k_from, std::size_t k_to>
  Vec2 moved(const Vec2& place, const Mix<k_from>& from, const Mix<k_to>& to) const;
  Vec2 moved(const Vec2& place, const ViewMix& from, const ViewMix& to) const;
  Vec2 moved_for_view(const Vec2& place, double level, double height, double displaced) const;
  Vec2 moved_between_slices(Vec2 place, double view_angle, double azimuth, double displaced) const;
  Mix<2> mix_between_angles(double right_angles) const;
  ViewMix mix(double view_angle, double view_azimuth) const {
    return mix_for_view(views_, azimuths_, view_angle, view_azimuth);
  }

  int bins_ = 0, views_ = 0, azimuths_ = 0;
  RedistributionOptions options_;
  // Cumulated shares: by slice those along each row, then those over rows; an entry more than there are bins,
  // from 0 on, and then others until the stride is full.
  std::size_t stride_ = 0;
  std::vector<double> sums_;
  std::shared_ptr<const detail::ViewGrids> grids_;  // of `normal_for_view`; none when it searches
};

/// The polar angle from which the whole displacement shows those normals that a share `displaced` of it shows
/// from `view_angle`; radians. Heights times s are slopes times s, so its tangent is s times as large (the
/// source prints 1 - s, which is right only for the share that is still missing).
double equivalent_view_angle(double view_angle, double displaced);

}  // namespace recede
