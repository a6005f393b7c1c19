// Measures how a matt displaced plane reflects light between two directions, without a picture of it: over
// the places of its precomputed visibility.
#pragma once

#include <recede/render/diffuse_scattering.h>
#include <recede/render/image.h>
#include <recede/render/open_ellipses.h>

#include <optional>
#include <span>
#include <vector>

namespace recede {

/// How it is told which places are lit and which are seen.
enum class OpennessTest {
  rays,      ///< exact, at the places
  ellipses,  ///< by `OpenEllipses`: no rays after the preparation
};

struct GoniometerOptions {
  VisibilityOptions visibility = {};
  OpennessTest test = OpennessTest::rays;
  int orders = 4;  ///< see `scatter_light`
};

/// The virtual gonioreflectometer of Heidrich, Daubert, Kautz and Seidel (2000), with means over the area
/// that is seen, where the source speaks of visible points. Directions are unit vectors in the frame of the
/// surface: x along u, y along v, z along its normal. Queries may run in parallel. Keeps a reference to the
/// plane, which must stay in place.
class VirtualGoniometer {
 public:
  /// Throws what `compute_visibility` and `scatter_light` throw.
  explicit VirtualGoniometer(const DisplacedPlane& plane, const GoniometerOptions& options = {},
                             Progress* progress = nullptr);
  explicit VirtualGoniometer(DisplacedPlane&&, const GoniometerOptions& = {}, Progress* = nullptr) = delete;

  const HeightFieldVisibility& visibility() const { return visibility_; }

  /// Light of a sun of irradiance 1 on all places.
  ScatteredLight light(const Vec3& toward_light) const;

  /// For each place the area that a viewer sees of it, as a share of the area of its cell on the undisplaced
  /// plane. 0 for viewers at or below the horizon.
  std::vector<double> seen_areas(const Vec3& toward_viewer) const;
  /// How far the mean of these is from the viewer's z, as a share of it: of an endless surface a viewer sees
  /// as much as of the plane without heights, so this tells how good the test of openness is.
  double area_error(const Vec3& toward_viewer) const;

  /// The reflectance distribution function, per steradian, for places of one albedo. The same with viewer and
  /// light exchanged, but for what the test and the places get wrong. 0 at and below the horizon.
  double brdf(const Vec3& toward_viewer, const Vec3& toward_light, double albedo) const;
  /// The same by parts of the map, `columns` x `rows` of them, row by row from the top: a function that
  /// varies over the surface. 0 where nothing of a part is seen. Throws `OptionError` unless both are from 1
  /// to the number of places along that side.
  std::vector<double> local_brdfs(const Vec3& toward_viewer, const Vec3& toward_light, double albedo,
                                  int columns, int rows) const;

  /// One texture of a bidirectional texture function: a pixel for each place, pi times its radiance (1 is a
  /// white plane that faces the sun); black where it isn't seen.
  Image texture(const Vec3& toward_viewer, const Vec3& toward_light, const Rgb& albedo) const;
  /// A light field: such textures for one sun and many viewers.
  std::vector<Image> light_field(std::span<const Vec3> toward_viewers, const Vec3& toward_light,
                                 const Rgb& albedo) const;

 private:
  double openness(std::size_t place, const Vec3& direction) const;
  Image texture(const Vec3& toward_viewer, const ScatteredLight& light, const Rgb& albedo) const;

  const DisplacedPlane* plane_;
  int orders_;
  HeightFieldVisibility visibility_;
  DiffuseTransport transport_;
  std::optional<OpenEllipses> ellipses_;
};

}  // namespace recede
