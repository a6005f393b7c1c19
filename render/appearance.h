// How one displaced surface looks as geometry, as a bump map and as a BRDF, so that all three agree.
#pragma once

#include <recede/lod/displacement_bake.h>
#include <recede/render/detail/factor_grid.h>
#include <recede/render/map_stretch.h>
#include <recede/render/redistributed_bump.h>
#include <recede/render/reflectance_table.h>
#include <recede/render/scattering_table.h>

#include <filesystem>
#include <memory>
#include <optional>

namespace recede {

struct AppearanceOptions {
  VisibleNormalsOptions normals = {};
  ReflectanceTableOptions reflectance = {};
  RedistributionOptions redistribution = {};
  /// Shadows that bumps cast on each other, and light that they pass on. Without it tables and bump maps are
  /// lit as if nothing shaded anything.
  bool shading = true;
  int shading_samples = 8192;  ///< rays for each view, as in `ScatteringTableOptions`
  /// False: bump maps have their own normals from everywhere, which isn't as bright as displacement; for
  /// comparison.
  bool redistribute = true;
};

/// What rays and sums found of a displaced surface: all that files keep.
struct AppearanceTables {
  MapStretch stretch = {};
  double wavelength = 0;  ///< object units; 0: flat
  VisibleNormals normals = {};
  /// The mean of max(0, N.L) over the normals of the redistributed bump map, where `ReflectanceTable` has
  /// that over the normals that are seen. It differs where much of the surface has one normal. Unset: no
  /// difference.
  std::optional<ReflectanceTable> bump_light = {};
  /// What bumps make of light by shading each other and passing it on: a scattering table whose values are
  /// over those of light that nothing shades. Unset: nothing.
  std::optional<ScatteringTable> shading = {};
};

/// What the renderer needs to draw a displaced surface by other methods than displacement. Slopes are those
/// of heights over the mean stretch of the surface, in a frame of its normal and of the directions of u and
/// v.
class Appearance {
 public:
  /// Tables must fit `normals` and `options.reflectance` in their numbers of angles. Throws what `validate`
  /// throws, `OptionError` for options of the table out of range and for sides or a wavelength that aren't
  /// finite or below 0, and `InputError` for tables that don't fit.
  explicit Appearance(AppearanceTables tables, const AppearanceOptions& options = {});

  const AppearanceTables& tables() const { return tables_; }
  const MapStretch& stretch() const { return tables_.stretch; }
  double wavelength() const { return tables_.wavelength; }  ///< object units; 0: flat
  const VisibleNormals& normals() const { return tables_.normals; }
  /// As `RedistributedBump::normal_for_view`.
  Vec3 bump_normal(const Vec3& own, const Vec3& toward_viewer, double displaced = 0) const {
    return redistributes_ ? bump_.normal_for_view(own, toward_viewer, displaced) : own;
  }
  /// Factor of the light that the bump map's normals have, so that its mean is that of `unshadowed`. Unit
  /// vectors in the frame of the surface; arguments as those of `bump_normal`.
  double bump_factor(const Vec3& toward_viewer, const Vec3& toward_light, double displaced = 0) const;

  const ReflectanceTable& table() const { return table_; }
  const ReflectanceSampler& sampler() const { return sampler_; }

  /// The mean of max(0, N.L) over the normals that are seen, for light from everywhere, as if nothing shaded
  /// anything. Unit vectors in the frame of the surface.
  double unshadowed(const Vec3& toward_viewer, const Vec3& toward_light) const;

  /// `AppearanceTables::shading` as factors of the light that `unshadowed` gives, for an albedo of each
  /// channel; with `passed_on` the light that bumps pass to each other is in it. 0 for light from below the
  /// horizon.
  ///
  /// `displaced` is the share of the displacement that the surface has already, 0 to 1, which shades itself:
  /// the rest is returned, at 1 nothing.
  Rgb shading(const Rgb& albedo, const Vec3& toward_viewer, const Vec3& toward_light, bool passed_on,
              double displaced = 0) const;

  /// The mean of the normals that are seen, at most 1 long. `toward_viewer` and the result are in the frame
  /// of the surface.
  Vec3 mean_normal(const Vec3& toward_viewer) const;

 private:
  double exact_bump_factor(const Vec3& toward_viewer, const Vec3& toward_light) const;

  AppearanceTables tables_;
  RedistributedBump bump_;
  bool redistributes_ = true;
  ReflectanceTable table_, from_below_;
  ReflectanceSampler sampler_;
  std::vector<Vec3> mean_normals_;   // by slice, in the viewer's frame
  detail::FactorGrid bump_factors_;  // of the bump map's light; empty where azimuths matter, or for none
};

/// The appearances of heights over a surface. A map that isn't periodic is taken with its mirror images, and
/// only texels that the surface covers count. Throws what `measure_stretch` and `sample_visible_normals`
/// throw, and `Cancelled`.
std::shared_ptr<const Appearance> make_appearance(const PolygonSoup& surface, const DisplacementMap& map,
                                                  const AppearanceOptions& options = {},
                                                  Progress* progress = nullptr);
/// The same for baked maps; normals are those of the normal map where there is one.
std::shared_ptr<const Appearance> make_appearance(const BakedMaps& maps,
                                                  const AppearanceOptions& options = {},
                                                  Progress* progress = nullptr);

/// Writes all that `make_appearance` found as one file. No half-written file is ever seen. Throws
/// `InputError`.
void write_appearance(const std::filesystem::path& path, const Appearance& appearance);

/// The same again, bit for bit. Throws `InputError` for anything that isn't one.
std::shared_ptr<const Appearance> read_appearance(const std::filesystem::path& path);

}  // namespace recede
