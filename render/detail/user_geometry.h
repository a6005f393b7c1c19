// Shapes that Embree asks where rays meet them.
#pragma once

#include <recede/geometry/vec.h>
#include <recede/render/detail/ray_context.h>

#include <limits>

namespace recede::detail {

/// Where a ray meets a primitive.
struct Crossing {
  double distance = 0;             ///< along the ray
  float u = 0, v = 0;              ///< what `Hit` has of them
  Eigen::Vector3f front{0, 0, 1};  ///< normal of the surface in the scene, any length
};

/// A ray's way from `least` to `most`, and what it brings along.
struct CrossingQuery {
  Eigen::Vector3f origin, direction;
  double least, most;
  bool starts_here;  ///< on this geometry, at `start`
  std::uint32_t start;
};

/// `Look` has n_primitives(), bounds(primitive) and first_crossing(primitive, query, crossing).
template <typename Look>
class UserGeometry {
 public:
  /// Rays bring a `RayContext`. `look` stays in place.
  static RTCGeometry make(RTCDevice device, const Look& look) {
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(look.n_primitives()));
    rtcSetGeometryUserData(geometry, const_cast<Look*>(&look));
    rtcSetGeometryBoundsFunction(geometry, bound, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occlude);
    rtcCommitGeometry(geometry);
    return geometry;
  }

 private:
  static void bound(const RTCBoundsFunctionArguments* arguments) {
    const Box3 box = static_cast<const Look*>(arguments->geometryUserPtr)->bounds(arguments->primID);
    constexpr double k_pad = 1e-6;  // for the rounding to float
    const Eigen::Vector3f low = (box.min().array() - k_pad).cast<float>(),
                          high = (box.max().array() + k_pad).cast<float>();
    RTCBounds& bounds = *arguments->bounds_o;
    bounds.lower_x = low.x();
    bounds.lower_y = low.y();
    bounds.lower_z = low.z();
    bounds.upper_x = high.x();
    bounds.upper_y = high.y();
    bounds.upper_z = high.z();
  }

  template <typename Arguments>
  static bool cross(const Arguments& arguments, RTCRayN* rays, unsigned k, Crossing& crossing) {
    if (arguments.valid[k] == 0) return false;
    const unsigned n = arguments.N;
    const SurfacePart& from = reinterpret_cast<const RayContext*>(arguments.context)->from;
    const CrossingQuery query{
        {RTCRayN_org_x(rays, n, k), RTCRayN_org_y(rays, n, k), RTCRayN_org_z(rays, n, k)},
        {RTCRayN_dir_x(rays, n, k), RTCRayN_dir_y(rays, n, k), RTCRayN_dir_z(rays, n, k)},
        static_cast<double>(RTCRayN_tnear(rays, n, k)),
        static_cast<double>(RTCRayN_tfar(rays, n, k)),
        from.object == arguments.geomID,
        from.primitive};
    return static_cast<const Look*>(arguments.geometryUserPtr)
               ->first_crossing(arguments.primID, query, crossing) &&
           crossing.distance < query.most;
  }

  static void intersect(const RTCIntersectFunctionNArguments* arguments) {
    const unsigned n = arguments->N;
    RTCRayN* rays = RTCRayHitN_RayN(arguments->rayhit, n);
    RTCHitN* hits = RTCRayHitN_HitN(arguments->rayhit, n);
    for (unsigned k = 0; k < n; ++k) {
      Crossing crossing;
      if (!cross(*arguments, rays, k, crossing)) continue;
      RTCRayN_tfar(rays, n, k) = static_cast<float>(crossing.distance);
      RTCHitN_u(hits, n, k) = crossing.u;
      RTCHitN_v(hits, n, k) = crossing.v;
      RTCHitN_primID(hits, n, k) = arguments->primID;
      RTCHitN_geomID(hits, n, k) = arguments->geomID;
      RTCHitN_instID(hits, n, k, 0) = arguments->context->instID[0];
      RTCHitN_Ng_x(hits, n, k) = crossing.front.x();
      RTCHitN_Ng_y(hits, n, k) = crossing.front.y();
      RTCHitN_Ng_z(hits, n, k) = crossing.front.z();
    }
  }

  static void occlude(const RTCOccludedFunctionNArguments* arguments) {
    for (unsigned k = 0; k < arguments->N; ++k) {
      Crossing crossing;
      if (cross(*arguments, arguments->ray, k, crossing))
        RTCRayN_tfar(arguments->ray, arguments->N, k) = -std::numeric_limits<float>::infinity();
    }
  }
};

}  // namespace recede::detail
