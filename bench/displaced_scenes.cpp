#include "displaced_scenes.h"

#include "measurement.h"
#include <recede/geometry/error.h>
#include <recede/render/detail/displaced_data.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::bench {
namespace {

using Vec2f = Eigen::Vector2f;
using Vec3f = Eigen::Vector3f;

RTCScene commit(RTCDevice device, RTCGeometry geometry, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE) {
  rtcCommitGeometry(geometry);
  const RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | flags));
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    throw Error("Embree fails with error " + std::to_string(error));
  return scene;
}

DisplacedMeshOptions at_level(int level) {
  DisplacedMeshOptions options;
  options.level = level;
  return options;
}

DisplacedScene build_ours(RTCDevice, DisplacedSurface&& surface, int level) {
  DisplacedScene result;
  std::shared_ptr<DisplacedMesh> mesh;
  result.build_seconds = median_seconds(1, [&] {
    mesh = std::make_shared<DisplacedMesh>(surface.base, std::move(surface.map), at_level(level));
  });
  result.scene = mesh->data().scene.get();
  result.kept = mesh;
  return result;
}

/// The points of all patches, patch by patch and row by row, straight into Embree's buffer; calls `build`
/// with the number of points a patch's row has.
template <typename Build>
DisplacedScene build_from_points(DisplacedSurface&& surface, int level, const Build& build) {
  DisplacedScene result;
  const DisplacedMesh mesh(surface.base, std::move(surface.map), at_level(level));
  result.build_seconds = median_seconds(1, [&] { result.scene = build(mesh.data(), (1u << level) + 1); });
  return result;
}

void write_points(const DisplacedMesh::Data& data, std::uint32_t row, float* to) {
  for (std::uint32_t patch = 0; patch < data.patches.patches.size(); ++patch) {
    const bool is_single = data.patches.patches[patch].is_single != 0;
    for (std::uint32_t j = 0; j < row; ++j) {
      for (std::uint32_t i = 0; i < row; ++i, to += 3) {
        // Beyond a lone triangle's diagonal there is nothing; its points close up there.
        const std::uint32_t i1 = is_single ? std::min(i, row - 1 - j) : i;
        detail::displaced_kernel().point(data.arrays(), patch, i1, j, 1, to);
      }
    }
  }
}

DisplacedScene build_triangles(RTCDevice device, DisplacedSurface&& surface, int level, RTCSceneFlags flags) {
  return build_from_points(
      std::move(surface), level, [&](const DisplacedMesh::Data& data, std::uint32_t row) {
        const std::size_t patches = data.patches.patches.size(), n_points = patches * row * row;
        const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* points = static_cast<float*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, n_points));
        write_points(data, row, points);
        std::size_t count = 0;
        for (const detail::DisplacedPatch& patch : data.patches.patches)
          count += (patch.is_single ? std::size_t{1} : 2) * (row - 1) * (row - 1);
        auto* corner = static_cast<std::uint32_t*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count));
        for (std::uint32_t p = 0; p < patches; ++p) {
          const bool is_single = data.patches.patches[p].is_single != 0;
          for (std::uint32_t j = 0; j + 1 < row; ++j) {
            for (std::uint32_t i = 0; i + 1 < row; ++i) {
              const std::uint32_t at = p * row * row + j * row + i;
              if (is_single && i + j + 2 > row) continue;
              for (const std::uint32_t k : {at, at + 1, at + row}) *corner++ = k;
              if (is_single && i + j + 3 > row) continue;
              for (const std::uint32_t k : {at + row + 1, at + row, at + 1}) *corner++ = k;
            }
          }
        }
        return commit(device, geometry, flags);
      });
}

DisplacedScene build_grids(RTCDevice device, DisplacedSurface&& surface, int level) {
  return build_from_points(
      std::move(surface), level, [&](const DisplacedMesh::Data& data, std::uint32_t row) {
        const std::size_t patches = data.patches.patches.size();
        const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
        write_points(data, row,
                     static_cast<float*>(rtcSetNewGeometryBuffer(
                         geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, patches * row * row)));
        auto* grids = static_cast<RTCGrid*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, sizeof(RTCGrid), patches));
        for (std::uint32_t p = 0; p < patches; ++p) {
          grids[p] = {p * row * row, row, static_cast<std::uint16_t>(row), static_cast<std::uint16_t>(row)};
        }
        return commit(device, geometry);
      });
}

/// A quad of the base with its directions and texture coordinates, as the displacement function sees it.
struct Quad {
  std::array<Vec3f, 4> positions, directions;
  std::array<Vec2f, 4> uvs;

  template <typename Value>
  static Value between(const std::array<Value, 4>& corners, float u, float v) {
    return (1 - u) * (1 - v) * corners[0] + u * (1 - v) * corners[1] + u * v * corners[2] +
           (1 - u) * v * corners[3];
  }
};

struct QuadSurface {
  std::vector<Quad> quads;
  DisplacementMap map;
  float scale = 1;
};

void displace(const RTCDisplacementFunctionNArguments* arguments) {
  const auto& surface = *static_cast<const QuadSurface*>(arguments->geometryUserPtr);
  const Quad& quad = surface.quads[arguments->primID];
  for (unsigned k = 0; k < arguments->N; ++k) {
    const float u = arguments->u[k], v = arguments->v[k];
    const Vec2f uv = Quad::between(quad.uvs, u, v);
    const auto height = static_cast<float>(surface.map.height_at(uv.cast<double>())) * surface.scale;
    const Vec3f place =
        Quad::between(quad.positions, u, v) + height * Quad::between(quad.directions, u, v).normalized();
    arguments->P_x[k] = place.x();
    arguments->P_y[k] = place.y();
    arguments->P_z[k] = place.z();
  }
}

/// Quads only, each with corners of its own: Embree would smooth them otherwise.
DisplacedScene build_subdivision(RTCDevice device, DisplacedSurface&& surface, int level) {
  const detail::SceneFrame frame = DisplacedMesh(surface.base, surface.map, at_level(0)).data().frame;
  const auto quads =
      std::make_shared<QuadSurface>(QuadSurface{{}, std::move(surface.map), static_cast<float>(frame.scale)});
  const PolygonSoup& base = surface.base;
  for (Index f = 0; f < base.n_faces(); ++f) {
    if (base.face_offsets[f + 1] - base.face_offsets[f] != 4) throw Error("quads only");
    Quad& quad = quads->quads.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      const Index corner = base.face_offsets[f] + static_cast<Index>(k);
      quad.positions[k] = frame.to_scene(base.positions[base.corner_vertices[corner]]).cast<float>();
      quad.directions[k] = base.corner_normals[corner].cast<float>();
      quad.uvs[k] = base.corner_uvs[corner].cast<float>();
    }
  }
  DisplacedScene result;
  result.kept = quads;
  result.build_seconds = median_seconds(1, [&] {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
    const std::size_t n = quads->quads.size();
    auto* points = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 4 * n));
    auto* corners = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, 4, 4 * n));
    auto* sizes = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0, RTC_FORMAT_UINT, 4, n));
    for (std::uint32_t q = 0; q < n; ++q) {
      sizes[q] = 4;
      for (std::uint32_t k = 0; k < 4; ++k) {
        corners[4 * q + k] = 4 * q + k;
        Eigen::Map<Vec3f>(points + 12 * q + 3 * k) = quads->quads[q].positions[k];
      }
    }
    rtcSetGeometryTessellationRate(geometry, static_cast<float>(1 << level));
    rtcSetGeometrySubdivisionMode(geometry, 0, RTC_SUBDIVISION_MODE_PIN_ALL);
    rtcSetGeometryUserData(geometry, quads.get());
    rtcSetGeometryDisplacementFunction(geometry, displace);
    result.scene = commit(device, geometry);
  });
  return result;
}

/// The dissertation's recursion: a base triangle is divided again for every ray, and all small ones are
/// tested.
struct RecursiveTriangle {
  std::array<Vec3f, 3> p, n;
  std::array<Vec2f, 3> uv;
};

struct RecursiveSurface {
  std::vector<RecursiveTriangle> triangles;
  DisplacementMap map;
  float scale = 1, low = 0, high = 0;
  int level = 0;
};

struct RecursiveRay {
  Vec3f origin, direction;
  float t_min, t_max;
  bool is_met = false;
};

void meet(const Vec3f& a, const Vec3f& b, const Vec3f& c, RecursiveRay& ray) {
  const Vec3f ab = b - a, ac = c - a, across = ray.direction.cross(ac);
  const float determinant = ab.dot(across);
  if (determinant == 0) return;
  const Vec3f from = ray.origin - a, turned = from.cross(ab);
  const float u = from.dot(across) / determinant, v = ray.direction.dot(turned) / determinant;
  const float t = ac.dot(turned) / determinant;
  if (!(u >= 0 && v >= 0 && u + v <= 1 && t >= ray.t_min && t <= ray.t_max)) return;
  ray.t_max = t;
  ray.is_met = true;
}

void recurse(const RecursiveSurface& surface, const RecursiveTriangle& triangle, int level,
             RecursiveRay& ray) {
  const auto moved = [&](const Vec3f& p, const Vec2f& uv, const Vec3f& n) {
    return Vec3f(p + n * (static_cast<float>(surface.map.height_at(uv.cast<double>())) * surface.scale));
  };
  const auto& [p, n, uv] = triangle;
  if (level == 0) {
    return meet(moved(p[0], uv[0], n[0]), moved(p[1], uv[1], n[1]), moved(p[2], uv[2], n[2]), ray);
  }
  std::array<Vec3f, 3> q, m;
  std::array<Vec2f, 3> w;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    q[k] = (p[k] + p[next]) / 2;
    m[k] = (n[k] + n[next]).normalized();
    w[k] = (uv[k] + uv[next]) / 2;
  }
  if (level == 1) {
    std::array<Vec3f, 3> corner, side;
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = moved(p[k], uv[k], n[k]);
      side[k] = moved(q[k], w[k], m[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) meet(corner[k], side[k], side[(k + 2) % 3], ray);
    return meet(side[0], side[1], side[2], ray);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t before = (k + 2) % 3;
    recurse(surface, {{p[k], q[k], q[before]}, {n[k], m[k], m[before]}, {uv[k], w[k], w[before]}}, level - 1,
            ray);
  }
  recurse(surface, {q, m, w}, level - 1, ray);
}

void bound_recursive(const RTCBoundsFunctionArguments* arguments) {
  const auto& surface = *static_cast<const RecursiveSurface*>(arguments->geometryUserPtr);
  const RecursiveTriangle& triangle = surface.triangles[arguments->primID];
  // Interpolated directions are no longer than 1, so the heights on both sides hold all.
  const float room = std::max(std::abs(surface.low), std::abs(surface.high));
  Eigen::AlignedBox3f box;
  for (const Vec3f& p : triangle.p) box.extend(p);
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = box.min().x() - room;
  bounds.lower_y = box.min().y() - room;
  bounds.lower_z = box.min().z() - room;
  bounds.upper_x = box.max().x() + room;
  bounds.upper_y = box.max().y() + room;
  bounds.upper_z = box.max().z() + room;
}

/// Calls `search` with every valid ray, and stores what it finds. Embree asks for several at once, too.
template <typename Search>
void for_rays(const RTCIntersectFunctionNArguments* arguments, const Search& search) {
  const unsigned n = arguments->N;
  RTCRayN* rays = RTCRayHitN_RayN(arguments->rayhit, n);
  RTCHitN* hits = RTCRayHitN_HitN(arguments->rayhit, n);
  for (unsigned k = 0; k < n; ++k) {
    if (arguments->valid[k] != 0 && search(rays, hits, n, k)) {
      RTCHitN_primID(hits, n, k) = arguments->primID;
      RTCHitN_geomID(hits, n, k) = arguments->geomID;
    }
  }
}

void intersect_recursive(const RTCIntersectFunctionNArguments* arguments) {
  const auto& surface = *static_cast<const RecursiveSurface*>(arguments->geometryUserPtr);
  for_rays(arguments, [&](RTCRayN* rays, RTCHitN*, unsigned n, unsigned k) {
    RecursiveRay ray{{RTCRayN_org_x(rays, n, k), RTCRayN_org_y(rays, n, k), RTCRayN_org_z(rays, n, k)},
                     {RTCRayN_dir_x(rays, n, k), RTCRayN_dir_y(rays, n, k), RTCRayN_dir_z(rays, n, k)},
                     RTCRayN_tnear(rays, n, k),
                     RTCRayN_tfar(rays, n, k)};
    recurse(surface, surface.triangles[arguments->primID], surface.level, ray);
    if (ray.is_met) RTCRayN_tfar(rays, n, k) = ray.t_max;
    return ray.is_met;
  });
}

DisplacedScene build_recursive(RTCDevice device, DisplacedSurface&& surface, int level) {
  const detail::SceneFrame frame = DisplacedMesh(surface.base, surface.map, at_level(0)).data().frame;
  const auto kept = std::make_shared<RecursiveSurface>(
      RecursiveSurface{{}, std::move(surface.map), static_cast<float>(frame.scale)});
  DisplacedScene result;
  result.kept = kept;
  result.build_seconds = median_seconds(1, [&] {
    const HeightBounds bounds(kept->map);
    const HeightRange range = bounds.node(bounds.levels() - 1, 0, 0);
    kept->low = static_cast<float>(range.min) * kept->scale;
    kept->high = static_cast<float>(range.max) * kept->scale;
    kept->level = level;
    std::vector<Index> corners;
    triangulate(surface.base, nullptr, &corners);
    for (std::size_t c = 0; c < corners.size(); c += 3) {
      RecursiveTriangle& triangle = kept->triangles.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const Index corner = corners[c + k];
        const Vec3& position = surface.base.positions[surface.base.corner_vertices[corner]];
        triangle.p[k] = frame.to_scene(position).cast<float>();
        triangle.n[k] = surface.base.corner_normals[corner].cast<float>();
        triangle.uv[k] = surface.base.corner_uvs[corner].cast<float>();
      }
    }
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(kept->triangles.size()));
    rtcSetGeometryUserData(geometry, kept.get());
    rtcSetGeometryBoundsFunction(geometry, bound_recursive, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect_recursive);
    result.scene = commit(device, geometry);
  });
  return result;
}

/// Small triangles as primitives.
struct SmallTriangles {
  std::vector<std::array<float, 9>> corners;
};

void bound_small(const RTCBoundsFunctionArguments* arguments) {
  const auto& small = *static_cast<const SmallTriangles*>(arguments->geometryUserPtr);
  const auto& c = small.corners[arguments->primID];
  constexpr float k_room = 4e-6f;  // rays find hits a few steps of float beside
  const auto low = [&](std::size_t axis) { return std::min({c[axis], c[3 + axis], c[6 + axis]}) - k_room; };
  const auto high = [&](std::size_t axis) { return std::max({c[axis], c[3 + axis], c[6 + axis]}) + k_room; };
  *arguments->bounds_o = {low(0), low(1), low(2), 0, high(0), high(1), high(2), 0};
}

void intersect_small(const RTCIntersectFunctionNArguments* arguments) {
  const auto& small = *static_cast<const SmallTriangles*>(arguments->geometryUserPtr);
  const float* c = small.corners[arguments->primID].data();
  for_rays(arguments, [&](RTCRayN* rays, RTCHitN* hits, unsigned n, unsigned k) {
    detail::PatchRayQuery query{};
    const float origin[3] = {RTCRayN_org_x(rays, n, k), RTCRayN_org_y(rays, n, k), RTCRayN_org_z(rays, n, k)};
    const float direction[3] = {RTCRayN_dir_x(rays, n, k), RTCRayN_dir_y(rays, n, k),
                                RTCRayN_dir_z(rays, n, k)};
    std::copy(origin, origin + 3, query.origin);
    std::copy(direction, direction + 3, query.direction);
    query.t_min = RTCRayN_tnear(rays, n, k);
    query.t_max = RTCRayN_tfar(rays, n, k);
    query.accepts_equal = RTCHitN_geomID(hits, n, k) == RTC_INVALID_GEOMETRY_ID ||
                          RTCHitN_primID(hits, n, k) > arguments->primID;
    const bool is_met = detail::displaced_kernel().test_triangle(c, c + 3, c + 6, query);
    if (is_met) RTCRayN_tfar(rays, n, k) = query.t_max;
    return is_met;
  });
}

}  // namespace

DisplacedScene one_by_one(RTCDevice device, const DisplacedMesh& mesh, std::vector<std::uint64_t>& numbers) {
  const DisplacedMesh::Data& data = mesh.data();
  const detail::PatchArrays arrays = data.arrays();
  const auto small = std::make_shared<SmallTriangles>();
  for (std::uint32_t number = 0; number < data.n_parts(); ++number) {
    const detail::PatchPart part = arrays.parts != nullptr
                                       ? arrays.parts[number]
                                       : detail::PatchPart{number, 0, 0, arrays.patches[number].level};
    const detail::DisplacedPatch& patch = arrays.patches[part.patch];
    const std::uint32_t side = 1u << patch.level, size = 1u << part.level;
    for (std::uint32_t at = 0; at < 2 * size * size; ++at) {
      const std::uint32_t i = part.i + at / 2 % size, j = part.j + at / 2 / size, upper = at & 1;
      if (patch.is_single && i + j + 1 + upper > side) continue;
      numbers.push_back(std::uint64_t{number} << 32 | (2 * (i + side * j) + upper));
      std::array<float, 9>& corners = small->corners.emplace_back();
      const auto set = [&](std::size_t k, std::uint32_t di, std::uint32_t dj) {
        detail::displaced_kernel().point(arrays, part.patch, i + di, j + dj, 1, corners.data() + 3 * k);
      };
      set(0, upper, upper);
      set(1, 1 - upper, upper);
      set(2, upper, 1 - upper);
    }
  }
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(small->corners.size()));
  rtcSetGeometryUserData(geometry, small.get());
  rtcSetGeometryBoundsFunction(geometry, bound_small, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_small);
  DisplacedScene result;
  result.scene = commit(device, geometry);
  result.kept = small;
  return result;
}

std::vector<DisplacedSystem> displaced_systems() {
  const auto triangles = [](RTCSceneFlags flags) {
    return [flags](RTCDevice device, DisplacedSurface&& surface, int level) {
      return build_triangles(device, std::move(surface), level, flags);
    };
  };
  constexpr std::size_t k_many = std::size_t{1} << 26;
  return {{"Recede", build_ours, 1000, std::size_t{1} << 40},
          {"Embree triangles", triangles(RTC_SCENE_FLAG_NONE), 1000, k_many},
          {"Embree triangles, compact", triangles(RTC_SCENE_FLAG_COMPACT), 1000, k_many},
          {"Embree grids", build_grids, 1000, k_many},
          {"Embree subdivision", build_subdivision, 1000, k_many},
          {"recursion", build_recursive, 2, std::size_t{1} << 24}};
}

}  // namespace recede::bench
