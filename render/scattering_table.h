// How much light a displaced plane scatters, seen from so far that its bumps can't be told apart: with the
// shadows of its bumps, and with the light that they pass to each other.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/render/displaced_plane.h>
#include <recede/render/image.h>
#include <recede/render/reflectance_table.h>

#include <array>
#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

namespace recede {

struct ScatteringTableOptions {
  int views = 31;      ///< as `VisibleNormalsOptions` has them
  int azimuths = 1;    ///< of the viewer, as there; more than 1 must divide the light's azimuths
  int samples = 8192;  ///< rays for each view, 2 to 2^24
  int light_angles = 31, light_azimuths = 64;  ///< as `ReflectanceTableOptions` has them
  /// How often light meets the surface before the rest is estimated, 1 to 8.
  int orders = 4;
  int directions = 128;  ///< in which light goes from place to place, see `VisibilityOptions`
  /// The most places along a side of the map for shadows and for light from place to place, 1 to 1024. Time
  /// grows with the square. Normals are always those of the map itself, however fine it is.
  int places = 64;
};

/// The series over orders of scattering at matt facets, by view and light. Order k is light that has met the
/// surface k times, for albedo 1; a facet of albedo R has R^k times of it. Under the irradiance E (of what
/// faces the light) the radiance is
///
///     E / pi * (R T_1 + R^2 T_2 + ...),
///
/// with no further cosine: as in `ReflectanceTable`, where R times its value stands for the sum.
struct ScatteringTable {
  static constexpr int k_most_orders = 8;

  int views = 0, azimuths = 0;  ///< as `VisibleNormals` has them
  int light_angles = 0, light_azimuths = 0;
  int orders = 0;
  /// Of the light that the last order sends out, the share that meets the surface again, and so on.
  double hits_again = 0;
  /// By view (0 first), azimuth of the viewer, light's angle, light's azimuth, order.
  std::vector<double> values{};

  std::size_t slice_count() const {
    return static_cast<std::size_t>(views + 1) * static_cast<std::size_t>(azimuths);
  }
  std::size_t slice_size() const {
    return static_cast<std::size_t>(light_angles) * static_cast<std::size_t>(light_azimuths) *
           static_cast<std::size_t>(orders);
  }

  /// T_1, T_2, ...; zeros after the last order.
  using Series = std::array<double, k_most_orders>;
  /// Linear between all angles, which are those of `ReflectanceTable::value`.
  Series series(double view_angle, double light_angle, double light_azimuth, double view_azimuth = 0) const;
  /// The same for unit vectors in the frame of the surface: x along u, y along v, z along its normal.
  Series series(const Vec3& toward_viewer, const Vec3& toward_light) const;

  /// The sum for an albedo, all orders after the last included as a geometric series.
  double sum(const Series& series, double albedo) const;
  /// For an albedo of each channel, from one look at the table. Times E / pi it is the radiance.
  Rgb value(const Rgb& albedo, const Vec3& toward_viewer, const Vec3& toward_light) const;
};

/// Which places are seen, rays tell, as `sample_visible_normals` has them: so every place counts by the area
/// that is seen of it. There, the map's normal and the horizon of the places around decide on direct light.
/// What a place passes to others goes through `compute_visibility` (Heidrich, Daubert, Kautz and Seidel 2000,
/// section on the virtual gonioreflectometer).
///
/// Same values for any number of threads. Throws `OptionError` for options out of range and for more than
/// 2^28 values or samples in all, `InputError` when no ray of a view meets the surface, and `Cancelled`.
ScatteringTable make_scattering_table(const DisplacedPlane& plane, const ScatteringTableOptions& options = {},
                                      Progress* progress = nullptr);

/// The table for one albedo from 0 to 1, in the form that `ReflectanceSampler` and `measure_violations` take:
/// its value times albedo / pi times E is the radiance. Throws `OptionError` for other albedos and
/// `InputError` unless the scattering table has as many values as its numbers say.
ReflectanceTable reflectance_of(const ScatteringTable& table, double albedo);

/// Writes a table as `write_reflectance_table` does, with the number of orders in place of the 0 and
/// `hits_again` as one more double before the values. Throws the same.
void write_scattering_table(const std::filesystem::path& path, const ScatteringTable& table);

/// The same table, bit for bit. Throws as `read_reflectance_table` does.
ScatteringTable read_scattering_table(const std::filesystem::path& path);

}  // namespace recede
