#include <recede/lod/displaced_base.h>
#include <recede/render/detail/displaced_look.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::detail {
namespace {

/// Height and its slopes by u and v, object units. Slopes are those of central differences at texels,
/// bilinear between them.
struct SmoothHeight {
  double height = 0;
  Vec2 slope = Vec2::Zero();
};

SmoothHeight smooth_height(const DisplacementMap& map, const Vec2& uv) {
  const DisplacementMap::CellPlace x = map.column_place(uv.x()), y = map.row_place(uv.y());
  // A cell lies between the texels cell - 1 and cell. A border's texels repeat; a period goes around.
  const auto texel = [&](int column, int row) {
    const auto inside = [&](int k, int count) {
      if (map.border() == MapBorder::periodic) return ((k % count) + count) % count;
      return std::clamp(k, 0, count - 1);
    };
    return map.texel(inside(column, map.columns()), inside(row, map.rows()));
  };
  SmoothHeight result{map.height_at(uv)};
  for (int corner = 0; corner < 4; ++corner) {
    const int column = x.cell - 1 + (corner & 1), row = y.cell - 1 + (corner >> 1);
    const double weight = ((corner & 1) != 0 ? x.fraction : 1 - x.fraction) *
                          ((corner >> 1) != 0 ? y.fraction : 1 - y.fraction);
    const double across = (texel(column + 1, row) - texel(column - 1, row)) / 2 * map.columns();
    const double down = (texel(column, row + 1) - texel(column, row - 1)) / 2 * map.rows();
    result.slope += weight * Vec2(across, -down);  // rows go against v
  }
  return result;
}

std::array<double, 3> weights_of(const Hit& base_hit) {
  const double u = static_cast<double>(base_hit.u), v = static_cast<double>(base_hit.v);
  return {1 - u - v, u, v};
}

Vec3 normal_of_map(const DisplacedLook& look, const Hit& base_hit) {
  const std::array<double, 3> weights = weights_of(base_hit);
  const MapTriangles& triangles = *look.map_triangles;
  const std::size_t triangle = base_hit.part.primitive;
  const MapPlace place = triangles.at(triangle, {weights[0], weights[1], weights[2]});
  Vec2 uv = Vec2::Zero();
  for (std::size_t k = 0; k < 3; ++k) uv += weights[k] * triangles.uv(triangle, k);
  const Vec3 mapped = look.maps->normal_at(uv);
  return (mapped.x() * place.tangent + mapped.y() * place.bitangent + mapped.z() * place.normal)
      .stableNormalized();
}

}  // namespace

DisplacedLook::DisplacedLook(const PolygonSoup& base, DisplacementMap heights,
                             const DisplacedMeshOptions& options)
    : surface(base, std::move(heights), options) {
  std::vector<Index> corners;
  triangulate(base, nullptr, &corners);
  for (const Index corner : corners) uvs.push_back(base.corner_uvs[corner]);
  directions.resize(corners.size());
  const DisplacedPatches& patches = surface.patches;
  for (std::size_t p = 0; p < patches.patches.size(); ++p) {
    const DisplacedPatch& patch = patches.patches[p];
    constexpr std::array<std::array<std::size_t, 3>, 2> k_corners{{{0, 1, 3}, {2, 3, 1}}};
    for (std::size_t half = 0; half < (patch.is_single != 0 ? 1u : 2u); ++half) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t at =
            3 * std::size_t{patches.triangles[p][half]} + (patch.first_corner[half] + k) % 3;
        directions[at] = Vec3f(patches.vertices[patch.vertices[k_corners[half][k]]].direction);
      }
    }
  }
}

DisplacedLook::DisplacedLook(const BakedMaps& baked, const DisplacedMeshOptions& options)
    : DisplacedLook(baked.surface, displacement_map_of(baked), options) {
  if (baked.normal.samples.empty()) return;
  maps = baked;
  map_triangles.emplace(*maps);
}

Hit hit_of_base(const DisplacedLook& look, const Hit& hit) {
  const DisplacedMesh::Data::BasePlace place = look.surface.base_place(
      hit.part.primitive, hit.part.small, static_cast<double>(hit.u), static_cast<double>(hit.v));
  Hit result = hit;
  result.part.primitive = place.triangle;
  result.u = static_cast<float>(place.weights[1]);
  result.v = static_cast<float>(place.weights[2]);
  return result;
}

Vec3 displaced_normal(const DisplacedLook& look, const MeshData& base, const Hit& base_hit) {
  if (look.is_flat) return base_hit.front.cast<double>().stableNormalized();
  if (look.map_triangles) return normal_of_map(look, base_hit);
  // P(u, v) + h n with n = N / |N|, all linear but for that: its derivatives along two sides of the triangle.
  const std::array<std::uint32_t, 3>& vertices = base.triangles[base_hit.part.primitive];
  const std::array<double, 3> weights = weights_of(base_hit);
  const std::size_t triangle = base_hit.part.primitive;
  std::array<Vec3, 3> directions;
  Vec3 direction = Vec3::Zero();
  Vec2 uv = Vec2::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    directions[k] = look.directions[3 * triangle + k].cast<double>();
    direction += weights[k] * directions[k];
    uv += weights[k] * look.uvs[3 * triangle + k];
  }
  const double length = direction.norm();
  if (!(length > 1e-6)) return base_hit.front.cast<double>().stableNormalized();
  const Vec3 unit = direction / length;
  const double scale = look.surface.frame.scale;
  const SmoothHeight at = smooth_height(look.surface.map, uv);
  const auto along = [&](std::size_t k) {
    const Vec3 step = base.position(vertices[k]) - base.position(vertices[0]);
    const Vec3 turn = directions[k] - directions[0];
    const double rise = at.slope.dot(look.uvs[3 * triangle + k] - look.uvs[3 * triangle]);
    return Vec3(step + scale * (rise * unit + at.height / length * (turn - unit.dot(turn) * unit)));
  };
  const Vec3 normal = along(1).cross(along(2)).stableNormalized();
  return normal.squaredNorm() > 0.5 ? normal : Vec3(base_hit.front.cast<double>().stableNormalized());
}

double displaced_rounding_bound(const MeshData& base, const Hit& base_hit, const Vec3& position) {
  constexpr double k_unit = 0x1p-24;
  double side = 0;
  for (const std::uint32_t vertex : base.triangles[base_hit.part.primitive])
    side = std::max(side, static_cast<double>(base.longest_sides[vertex]));
  // Besides what holds for triangles, the place is found along the ray, whose length was rounded.
  return k_unit *
         (2 * position.cwiseAbs().maxCoeff() + 2 * static_cast<double>(base_hit.distance) + 16 * side);
}

}  // namespace recede::detail
