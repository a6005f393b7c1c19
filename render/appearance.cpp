#include <recede/geometry/error.h>
#include <recede/render/appearance.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace recede {
namespace {

ReflectanceTableOptions from_below(ReflectanceTableOptions options) {
  options.from_below = true;
  return options;
}

template <class Table>
bool fits(const Table& table, const ReflectanceTable& other) {
  return table.views == other.views && table.azimuths == other.azimuths &&
         table.light_angles == other.light_angles && table.light_azimuths == other.light_azimuths;
}

}  // namespace

Appearance::Appearance(AppearanceTables tables, const AppearanceOptions& options)
    : tables_(std::move(tables)),
      bump_(tables_.normals, options.redistribution),
      redistributes_(options.redistribute),
      table_(make_reflectance_table(tables_.normals, options.reflectance)),
      from_below_(make_reflectance_table(tables_.normals, from_below(options.reflectance))),
      sampler_(table_) {
  const MapStretch& stretch = tables_.stretch;
  if (!stretch.sides.allFinite() || !(stretch.sides.minCoeff() > 0))
    throw OptionError("the sides of a map are lengths greater than 0");
  if (!(tables_.wavelength >= 0) || !std::isfinite(tables_.wavelength))
    throw OptionError("a wavelength is a length, or 0 for a flat map");
  const std::optional<ScatteringTable>& shading = tables_.shading;
  if (shading &&
      (!fits(*shading, table_) || shading->values.size() != shading->slice_count() * shading->slice_size()))
    throw InputError("the shading of an appearance has other angles than its table");
  const std::optional<ReflectanceTable>& bump = tables_.bump_light;
  if (bump && (!fits(*bump, table_) || bump->values.size() != table_.values.size()))
    throw InputError("the light of an appearance's bump map has other angles than its table");
  const VisibleNormals& normals = tables_.normals;
  for (std::size_t slice = 0; slice < normals.slice_count(); ++slice) {
    Vec3 mean = Vec3::Zero();
    const std::span<const double> shares = normals.slice(slice);
    for (std::size_t bin = 0; bin < shares.size(); ++bin) mean += shares[bin] * normals.normal_of_bin(bin);
    mean_normals_.push_back(mean);
  }
  if (bump && normals.azimuths == 1) {
    bump_factors_ = detail::FactorGrid(
        [&](const Vec3& viewer, const Vec3& light) { return exact_bump_factor(viewer, light); });
  }
}

double Appearance::exact_bump_factor(const Vec3& toward_viewer, const Vec3& toward_light) const {
  // From beyond the horizon as from there.
  const Vec3 light(toward_light.x(), toward_light.y(), std::max(toward_light.z(), 0.0));
  const double bump = tables_.bump_light->value(toward_viewer, light);
  constexpr double k_least = 1e-3, k_most = 4;  // no more is made of what the bump map hardly has
  return std::clamp(table_.value(toward_viewer, light) / std::max(bump, k_least), 1 / k_most, k_most);
}

double Appearance::bump_factor(const Vec3& toward_viewer, const Vec3& toward_light, double displaced) const {
  if (!redistributes_ || !tables_.bump_light || displaced >= 1) return 1;
  const double factor = bump_factors_.is_empty() ? exact_bump_factor(toward_viewer, toward_light)
                                                 : bump_factors_(toward_viewer, toward_light);
  return factor + displaced * (1 - factor);
}

double Appearance::unshadowed(const Vec3& toward_viewer, const Vec3& toward_light) const {
  if (toward_light.z() >= 0) return table_.value(toward_viewer, toward_light);
  return from_below_.value(toward_viewer, {toward_light.x(), toward_light.y(), -toward_light.z()});
}

Rgb Appearance::shading(const Rgb& albedo, const Vec3& toward_viewer, const Vec3& toward_light,
                        bool passed_on, double displaced) const {
  if (toward_light.z() < 0) return Rgb::Zero();
  const std::optional<ScatteringTable>& shading = tables_.shading;
  if (!shading || displaced >= 1) return Rgb::Ones();
  const ScatteringTable::Series whole = shading->series(toward_viewer, toward_light);
  double own = 1;  // what a part of the heights shades itself
  if (displaced > 0) {
    // Heights times s hide as the whole ones do from directions whose tangents are s times as large.
    const auto equivalent = [&](const Vec3& direction) {
      const double z = std::max(direction.z(), 0.0);
      return Vec3(Vec3(displaced * direction.x(), displaced * direction.y(), z).stableNormalized());
    };
    constexpr double k_least = 0.02;  // of light that is nearly gone, no more is taken away or given back
    own = std::max(k_least, shading->series(equivalent(toward_viewer), equivalent(toward_light))[0]);
  }
  if (!passed_on) return Rgb::Constant(static_cast<float>(whole[0] / own));
  // Slopes times s pass on s^2 of the light, and rays find that.
  const double missing = 1 - displaced * displaced;
  Rgb factors;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto share = static_cast<double>(albedo[k]);
    const double all = share > 0 ? shading->sum(whole, share) / share : whole[0];
    factors[k] = static_cast<float>((whole[0] + missing * (all - whole[0])) / own);
  }
  return factors;
}

Vec3 Appearance::mean_normal(const Vec3& toward_viewer) const {
  const double level = toward_viewer.head<2>().norm();
  const double c = level > 0 ? toward_viewer.x() / level : 1, s = level > 0 ? toward_viewer.y() / level : 0;
  const ViewMix mix = mix_for_view(tables_.normals.views, tables_.normals.azimuths,
                                   std::atan2(level, std::max(toward_viewer.z(), 0.0)), std::atan2(s, c));
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < static_cast<std::size_t>(mix.count); ++k)
    mean += mix.weights[k] * mean_normals_[mix.slices[k]];
  return {c * mean.x() - s * mean.y(), s * mean.x() + c * mean.y(), mean.z()};
}

}  // namespace recede
