// How much light a displaced plane scatters, seen from so far that its bumps can't be told apart.
#pragma once

#include <recede/render/normal_distribution.h>

#include <filesystem>
#include <vector>

namespace recede {

/// How each of the small faces scatters light. N is its normal, L and V point to the light and the viewer.
enum class FacetLobe {
  diffuse,      ///< N.L
  reflection,   ///< R.V to a power, R the mirror image of L (Phong 1975)
  half_vector,  ///< N.H to a power, H half-way between L and V (Blinn 1977)
};

struct ReflectanceTableOptions {
  FacetLobe lobe = FacetLobe::diffuse;
  /// Of the lobe, but for `diffuse`; greater than 0. With 31 bins, normals can't be told apart for lobes of
  /// more than about 500.
  double exponent = 20;
  int light_angles =
      31;  ///< polar angles of the light: evenly from 0 to 90 degrees, both included; 2 to 1024
  int light_azimuths = 64;  ///< of the light, from the viewer's on: evenly around the circle; 1 to 1024
  /// Values are those of light that comes from below, from the mirror image of each direction: for lamps
  /// without shadows, which light slopes beyond the horizon.
  bool from_below = false;
};

/// The mean over the normals that are seen of max(0, lobe), by view and light. Light that bumps take from
/// each other isn't considered: faces that look to the light have it.
///
/// The cosine of the light's angle is contained, that of each face: an albedo R under the irradiance E (of
/// what faces the light) gives the radiance R / pi * value * E, with no further cosine. As a BRDF it is value
/// / (pi cos theta_L), which grows beyond all bounds at the horizon.
struct ReflectanceTable {
  int views = 0, azimuths = 0;  ///< as `VisibleNormals` has them
  int light_angles = 0, light_azimuths = 0;
  /// By view (0 first), azimuth of the viewer, light's angle, light's azimuth.
  std::vector<double> values{};

  std::size_t slice_size() const {
    return static_cast<std::size_t>(light_angles) * static_cast<std::size_t>(light_azimuths);
  }
  std::span<const double> slice(std::size_t slice) const {
    return std::span<const double>(values).subspan(slice * slice_size(), slice_size());
  }

  /// Linear between all angles; radians. `light_azimuth` is counter-clockwise from the viewer's. 0 for lights
  /// below the horizon; views beyond the last one as that.
  double value(double view_angle, double light_angle, double light_azimuth, double view_azimuth = 0) const;
  /// The same for unit vectors in the frame of the surface: x along u, y along v, z along its normal.
  double value(const Vec3& toward_viewer, const Vec3& toward_light) const;
};

/// Sums over the bins of the normals (Becker and Max 1993; Ramsey's dissertation on displaced levels of
/// detail, its section on isotropic BRDFs). Same values for any number of threads. Throws what `validate`
/// throws, `OptionError` for options out of range, and `Cancelled`.
ReflectanceTable make_reflectance_table(const VisibleNormals& normals,
                                        const ReflectanceTableOptions& options = {},
                                        Progress* progress = nullptr);

/// Where a table isn't that of a real surface, for views and lights up to an angle.
struct ReflectanceViolations {
  /// How far BRDF x both cosines changes when light and viewer change places, as a share of its mean: RMS
  /// over all pairs of directions of the table, and the largest.
  double reciprocity_rms = 0, reciprocity_max = 0;
  /// The most that any view gathers from the same radiance all around: 1 is all. At most 1 for diffuse
  /// tables.
  double most_gathered = 0;
  /// The most that leaves, over what arrives, for light from any one direction; above 1 where light that
  /// bumps would take from each other is counted.
  double most_scattered = 0;
};

/// For albedo 1; the mean over the viewer's azimuths. `largest_angle` in radians, greater than 0, at most
/// pi / 2; at pi / 2 light along the plane arrives at nothing, so that the last number has no bound. Throws
/// `OptionError`.
ReflectanceViolations measure_violations(const ReflectanceTable& table, double largest_angle = 1.4);

/// Draws directions of light in proportion to a table, for a given view.
class ReflectanceSampler {
 public:
  /// Throws `InputError` unless the table has a value for each pair of directions, all finite and none below
  /// 0.
  explicit ReflectanceSampler(const ReflectanceTable& table);

  struct Sample {
    Vec3 toward_light = Vec3::UnitZ();
    double density = 0;  ///< per solid angle
  };
  /// In the frame of the surface. `random` in [0, 1) x [0, 1). A density of 0: the view scatters nothing.
  Sample sample(const Vec3& toward_viewer, const Vec2& random) const;
  /// The density with which `sample` draws a unit direction. In each cell of the table it is constant, the
  /// mean of its corners. Integrates to 1 over the hemisphere.
  double density(const Vec3& toward_viewer, const Vec3& toward_light) const;

 private:
  struct View;
  View view(const Vec3& toward_viewer) const;
  double cell_density(const View& view, std::size_t cell) const;

  int views_, azimuths_, rows_, columns_;
  std::vector<double> heights_;  // cosines of the light's angles
  std::vector<double> sums_;     // by slice: integrals of the table over cells, cumulated, from 0 on
};

/// Writes a table as one file: "recede reflectance 1" and a line break, five numbers of 32 bits (views,
/// azimuths, light angles, light azimuths, 0), and the values as doubles in the order of `values`, all
/// little-endian. No half-written file is ever seen. Throws `InputError` when the file can't be written or
/// the table has not as many values as its numbers say.
void write_reflectance_table(const std::filesystem::path& path, const ReflectanceTable& table);

/// The same table, bit for bit. Throws `InputError` for anything that isn't one, and for values that are
/// negative or not finite.
ReflectanceTable read_reflectance_table(const std::filesystem::path& path);

}  // namespace recede
