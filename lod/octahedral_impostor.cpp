#include <recede/geometry/error.h>
#include <recede/lod/billboard_budget.h>
#include <recede/lod/detail/billboard_faces.h>
#include <recede/lod/octahedral_impostor.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace recede {

namespace {

double sign_of(double x) { return x < 0 ? -1 : 1; }

// From the square -1..1, whose corners are all at -z.
Vec3 octahedral_direction(const Vec2& place) {
  Vec3 direction(place.x(), place.y(), 1 - std::abs(place.x()) - std::abs(place.y()));
  if (direction.z() < 0) {
    direction.x() = (1 - std::abs(place.y())) * sign_of(place.x());
    direction.y() = (1 - std::abs(place.x())) * sign_of(place.y());
  }
  return direction.normalized();
}

Vec2 node_place(int column, int row, int views) {
  return {2.0 * column / (views - 1) - 1, 2.0 * row / (views - 1) - 1};
}

}  // namespace

std::size_t octahedral_view(const Vec3& direction, int views) {
  const Vec3 scaled = direction / direction.cwiseAbs().sum();
  Vec2 place = scaled.head<2>();
  if (scaled.z() < 0) {
    place = Vec2((1 - std::abs(scaled.y())) * sign_of(scaled.x()),
                 (1 - std::abs(scaled.x())) * sign_of(scaled.y()));
  }
  const auto before = [&](double x) {
    return std::clamp(static_cast<int>(std::floor((x + 1) / 2 * (views - 1))), 0, views - 2);
  };
  const int column = before(place.x()), row = before(place.y());
  std::size_t best = 0;
  double most = -std::numeric_limits<double>::infinity();
  // The square isn't the sphere: of the four around the place.
  for (int k = 0; k < 4; ++k) {
    const int i = column + k % 2, j = row + k / 2;
    const double cosine = octahedral_direction(node_place(i, j, views)).dot(direction);
    if (cosine <= most) continue;
    most = cosine;
    best = static_cast<std::size_t>(j * views + i);
  }
  return best;
}

BillboardCloud octahedral_impostor(const PolygonSoup& model, int views) {
  if (views < 2 || views > 64) throw OptionError("an octahedral impostor has 2 to 64 views along each side");
  const detail::BillboardFaces faces = detail::billboard_faces_of(model);
  std::vector<Index> all(faces.count());
  std::iota(all.begin(), all.end(), 0u);
  BillboardCloud cloud;
  cloud.left_out = faces.left_out;
  cloud.is_two_sided = cloud.is_impostor = true;
  cloud.billboards.resize(static_cast<std::size_t>(views * views));
  tbb::parallel_for(0, views * views, [&](int view) {
    const Vec3 normal = octahedral_direction(node_place(view % views, view / views, views));
    Billboard& billboard = cloud.billboards[static_cast<std::size_t>(view)];
    billboard = detail::billboard_facing(faces, all, normal, true);
    if (billboard.normal().dot(normal) < 0) billboard.axis_v = -billboard.axis_v;
  });
  for (const Billboard& billboard : cloud.billboards) cloud.error = std::max(cloud.error, billboard.error);
  return cloud;
}

BillboardTextures octahedral_impostor_within(const PolygonSoup& model, std::size_t bytes, int views,
                                             Progress* progress) {
  const BillboardCloud cloud = octahedral_impostor(model, views);
  const double size = bounding_box(model).sizes().maxCoeff();
  const auto with = [&](double texels) {  // along the model's size
    BillboardTextureOptions options;
    options.texels_per_error = texels * std::max(cloud.error, 1e-6 * size) / size;
    return options;
  };
  double fits = 0.5, too_many = 4096;
  if (texture_bytes(cloud, with(fits)) > bytes)
    throw OptionError(
        fmt::format("{} bytes are too few for {} x {} pictures of a texel", bytes, views, views));
  constexpr int k_halvings = 20;
  for (int i = 0; i < k_halvings; ++i) {
    const double middle = std::sqrt(fits * too_many);
    (texture_bytes(cloud, with(middle)) <= bytes ? fits : too_many) = middle;
  }
  return texture_billboards(model, cloud, with(fits), progress);
}

}  // namespace recede
