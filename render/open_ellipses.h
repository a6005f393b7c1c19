// For each place of a height field, the directions from which it isn't hidden, as one ellipse: shadows and
// masking for a few multiplications.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/render/curved_visibility.h>
#include <recede/render/height_field_visibility.h>

#include <vector>

namespace recede {

/// Unit directions of the upper hemisphere whose x and y lie inside of an ellipse.
struct OpenEllipse {
  Vec2 center = Vec2::Zero();
  double xx = 1, xy = 0, yy = 1;  ///< symmetric: radii squared along the axes, turned to x and y

  /// 1 in the middle, 0 on the edge, negative outside: what the source tests (its equations 2 to 4).
  double inside(const Vec2& at) const;

  struct Axes {
    Vec2 major = Vec2::UnitX();  ///< unit length; the minor one is perpendicular
    Vec2 radii = Vec2::Ones();   ///< along the major and the minor axis
  };
  Axes axes() const;
};

struct OpenEllipsesOptions {
  /// The search changes radii alone, as the source's does. Else centre and axes move too, which fits better.
  bool radii_only = false;
  /// Width of the edge over which openness falls from 1 to 0, about radians of the light's angle; 0: sharp.
  double soft_edge = 0.15;
  BaseCurvature curvature = {};
};

/// Periodic, laid out as the places of the visibility that they were made from.
struct OpenEllipses {
  int columns = 0, rows = 0;
  double soft_edge = 0;
  std::vector<OpenEllipse> places{};

  /// 0 to 1 for a unit direction; 0 at and below the horizon. Whether the direction is below the place's own
  /// facet isn't contained: that is for max(0, N.L).
  double openness(std::size_t place, const Vec3& direction) const;
  /// The same at any texture coordinate, bilinear between four places: what a bump map needs to show the
  /// shadows that its heights cast, or to hide what they hide.
  double openness_at(const Vec2& uv, const Vec3& direction) const;
};

/// Fits one ellipse to each place so that as many directions as possible that see the sky are inside, and as
/// many as possible that see another place outside (Heidrich et al. 2000, section on shadow tests): from the
/// mean and the variance of the open ones, by a local search. Directions below the facet don't matter. A
/// place that is open all around has the unit circle, one that is never open a point.
///
/// Same values for any number of threads. Throws `OptionError` for a soft edge that isn't from 0 to 1, what
/// `bend_directions` throws, and `Cancelled`.
OpenEllipses fit_open_ellipses(const HeightFieldVisibility& visibility,
                               const OpenEllipsesOptions& options = {}, Progress* progress = nullptr);

/// Ellipses that follow the curvature of the undisplaced surface: linear between five states of it.
struct BendableEllipses {
  OpenEllipses flat{};
  std::vector<OpenEllipse> along_u{}, along_v{};  ///< change for a curvature of 1, of all numbers of `flat`

  OpenEllipses bent(const BaseCurvature& curvature) const;
};

/// Fits at no curvature and at a little of it, both ways along u and along v: `change` is a share of the
/// inverse of the map's longer side. Fitted again for a curvature of twice that, ellipses would differ by
/// little; far beyond, the model fails. The curvature of the options isn't used. Throws what
/// `fit_open_ellipses` throws, and `OptionError` unless `change` is greater than 0.
BendableEllipses fit_bendable_ellipses(const HeightFieldVisibility& visibility,
                                       const OpenEllipsesOptions& options = {}, double change = 0.1,
                                       Progress* progress = nullptr);

/// How often tests of openness are wrong: shares of places and directions.
struct OpennessErrors {
  struct Share {
    double mean = 0, worst = 0;  ///< over all places; of the place where it is largest
  };
  Share nearest{};   ///< `is_open_by_nearest`
  Share three{};     ///< `openness_by_three`, at least a half
  Share ellipses{};  ///< `OpenEllipses::openness`, at least a half
};

/// Against rays, in `directions` directions over the hemisphere above the undisplaced surface, those below
/// facets among them. Throws `OptionError` unless there are 3 to 2048, and `Cancelled`.
OpennessErrors measure_openness_errors(const DisplacedPlane& plane, const HeightFieldVisibility& visibility,
                                       const OpenEllipses& ellipses, int directions = 500,
                                       Progress* progress = nullptr);

}  // namespace recede
