#include <recede/geometry/error.h>
#include <recede/lod/billboard_budget.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace recede {

namespace {

constexpr double k_steps_per_octave = 4;

// Rising.
std::vector<double> errors_for(double size) {
  constexpr double k_least = 1e-3;
  std::vector<double> errors;
  for (double error = size; error > k_least * size; error *= std::exp2(-1 / k_steps_per_octave))
    errors.push_back(error);
  std::reverse(errors.begin(), errors.end());
  return errors;
}

std::size_t bytes_of(const BillboardCloud& cloud, double texels_per_error, BillboardTextureOptions options) {
  options.texels_per_error = texels_per_error;
  return texture_bytes(cloud, options);
}

// All clusters come from one run; the others are made one by one as long as they fit.
std::optional<BillboardCloud> finest_within(const PolygonSoup& model, std::size_t bytes,
                                            BillboardOptions clouds, const BillboardTextureOptions& textures,
                                            Progress* progress) {
  const std::vector<double> errors = errors_for(bounding_box(model).sizes().maxCoeff());
  if (clouds.method == BillboardMethod::face_clustering) {
    clouds.errors = errors;
    for (BillboardCloud& cloud : build_billboard_clouds(model, clouds, progress)) {
      if (texture_bytes(cloud, textures) <= bytes) return std::move(cloud);
    }
    return std::nullopt;
  }
  std::optional<BillboardCloud> best;
  for (std::size_t i = errors.size(); i-- > 0;) {
    clouds.errors = {errors[i]};
    BillboardCloud cloud = std::move(build_billboard_clouds(model, clouds, progress).front());
    if (texture_bytes(cloud, textures) > bytes) break;
    best = std::move(cloud);
  }
  return best;
}

}  // namespace

BillboardTextures billboards_within(const PolygonSoup& model, std::size_t bytes,
                                    const BillboardOptions& clouds, const BillboardTextureOptions& textures,
                                    Progress* progress) {
  validate(model, "billboard cloud");
  if (!(bounding_box(model).sizes().maxCoeff() > 0))
    throw InputError("a billboard cloud needs faces with an area");
  const std::optional<BillboardCloud> cloud = finest_within(model, bytes, clouds, textures, progress);
  if (!cloud)
    throw OptionError(fmt::format("{} bytes are too few for the textures of any cloud of this model", bytes));
  double fits = textures.texels_per_error, too_many = 4 * fits;
  constexpr int k_halvings = 12;
  for (int i = 0; i < k_halvings; ++i) {
    const double middle = std::sqrt(fits * too_many);
    (bytes_of(*cloud, middle, textures) <= bytes ? fits : too_many) = middle;
  }
  BillboardTextureOptions best = textures;
  best.texels_per_error = fits;
  return texture_billboards(model, *cloud, best, progress);
}

}  // namespace recede
