#include <recede/lod/displaced_base.h>
#include <recede/render/detail/displaced_look.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::detail {
namespace {

using BasePlace = DisplacedMesh::Data::BasePlace;

BasePlace place_of(const DisplacedLook& look, const Hit& hit) {
  return look.surface.base_place(hit.part.primitive, hit.part.small, static_cast<double>(hit.u),
                                 static_cast<double>(hit.v));
}

Vec3 facet_normal(const Hit& hit) { return hit.front.cast<double>().stableNormalized(); }

Vec3 normal_of_map(const DisplacedLook& look, const BasePlace& at) {
  const MapPlace place = look.map_triangles->at(at.triangle, at.weights);
  const Vec3 mapped = look.maps->normal_at(at.uv);
  return (mapped.x() * place.tangent + mapped.y() * place.bitangent + mapped.z() * place.normal)
      .stableNormalized();
}

Vec3 corner_of(const float* coordinates) { return Eigen::Vector3f(coordinates).cast<double>(); }

// P + h n with n = N / |N|, all linear but for that: across its derivatives along two sides of the triangle.
Vec3 normal_of_heights(const DisplacedLook& look, const Hit& hit, const BasePlace& at) {
  const DisplacedPatches& patches = look.surface.patches;
  const DisplacedPatch& patch = patches.patches[at.patch];
  const std::array<std::size_t, 3> corners = at.corners();
  std::array<Vec3, 3> positions, directions;
  Vec3 direction = Vec3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const DisplacedVertex& vertex = patches.vertices[patch.vertices[corners[k]]];
    positions[k] = corner_of(vertex.position);
    directions[k] = corner_of(vertex.direction);
    direction += at.patch_weights[static_cast<Eigen::Index>(k)] * directions[k];
  }
  const double length = direction.norm();
  if (!(length > 1e-6)) return facet_normal(hit);
  const Vec3 unit = direction / length;
  const double scale = look.surface.frame.scale;
  const DisplacementMap& map = look.surface.map;
  const double height = map.height_at(at.uv);
  // For a step of one texel along columns and rows, which run down.
  const Vec2 slope = map.smooth_derivative_at(at.uv).cwiseQuotient(Vec2(map.columns(), -map.rows()));
  const auto along = [&](std::size_t k) {
    const Vec3 turn = directions[k] - directions[0];
    const auto step = [&](const float* texels) {
      return static_cast<double>(texels[corners[k]]) - static_cast<double>(texels[corners[0]]);
    };
    const double rise = slope.dot(Vec2(step(patch.x), step(patch.y)));
    return Vec3(positions[k] - positions[0] +
                scale * (rise * unit + height / length * (turn - unit.dot(turn) * unit)));
  };
  const Vec3 normal = along(1).cross(along(2)).stableNormalized();
  return normal.squaredNorm() > 0.5 ? normal : facet_normal(hit);
}

}  // namespace

DisplacedLook::DisplacedLook(const BakedMaps& baked, const DisplacedMeshOptions& options)
    : DisplacedLook(baked.surface, displacement_map_of(baked), options) {
  if (baked.normal.samples.empty()) return;
  maps = baked;
  map_triangles.emplace(*maps);
}

Hit hit_of_base(const DisplacedLook& look, const Hit& hit) {
  if (is_on_base(hit)) return hit;
  const BasePlace place = place_of(look, hit);
  Hit result = hit;
  result.part.primitive = place.triangle;
  result.u = static_cast<float>(place.weights[1]);
  result.v = static_cast<float>(place.weights[2]);
  return result;
}

Vec3 displaced_normal(const DisplacedLook& look, const Hit& hit) {
  if (look.is_flat) return facet_normal(hit);
  const BasePlace place = place_of(look, hit);
  return look.map_triangles ? normal_of_map(look, place) : normal_of_heights(look, hit, place);
}

double displaced_rounding_bound(const DisplacedLook& look, const MeshData& base, const Hit& hit,
                                const Vec3& position) {
  constexpr double k_unit = 0x1p-24;
  double side = 0;
  for (const std::uint32_t vertex : base.triangles[hit_of_base(look, hit).part.primitive])
    side = std::max(side, static_cast<double>(base.longest_sides[vertex]));
  // Besides what holds for triangles, the place is found along the ray, whose length was rounded. Small
  // triangles are no longer than a side of the base and the span of all heights.
  side += look.surface.height_span();
  return k_unit * (2 * position.cwiseAbs().maxCoeff() + 2 * static_cast<double>(hit.distance) + 16 * side);
}

}  // namespace recede::detail
