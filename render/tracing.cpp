#include <recede/render/detail/tracing.h>

namespace recede::detail {

namespace {

/// Refuses the triangle on which the ray starts. Embree doesn't ask this of displaced surfaces, which do it
/// themselves.
void refuse_start(const RTCFilterFunctionNArguments* arguments) {
  const SurfacePart& from = reinterpret_cast<const RayContext*>(arguments->context)->from;
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (RTCHitN_geomID(arguments->hit, arguments->N, i) == from.object &&
        RTCHitN_primID(arguments->hit, arguments->N, i) == from.primitive)
      arguments->valid[i] = 0;
  }
}

RayContext context_of(const Ray& ray) {
  RayContext context = make_ray_context();
  context.from = ray.from;
  context.fraction = ray.target.fraction;
  if (ray.from.object != RTC_INVALID_GEOMETRY_ID) context.embree.filter = refuse_start;
  return context;
}

RTCScene scene_for(const SceneData& scene, const RayTarget& target) {
  if (scene.appearances == nullptr || target.shape == SurfaceShape::displaced) return scene.scene.get();
  const bool is_base = target.shape == SurfaceShape::base;
  return (is_base ? scene.appearances->base : scene.appearances->envelope).get();
}

RTCRay embree_ray(const Ray& ray) {
  RTCRay embree{};
  embree.org_x = ray.origin.x();
  embree.org_y = ray.origin.y();
  embree.org_z = ray.origin.z();
  embree.dir_x = ray.direction.x();
  embree.dir_y = ray.direction.y();
  embree.dir_z = ray.direction.z();
  embree.tfar = ray.length;
  embree.mask = 0xffffffffu;
  return embree;
}

}  // namespace

bool nearest_hit(const SceneData& scene, const Ray& ray, Hit& hit) {
  RayContext context = context_of(ray);
  RTCRayHit found{};
  found.ray = embree_ray(ray);
  found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_for(scene, ray.target), &context.embree, &found);
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  const std::uint32_t small =
      ray.target.shape != SurfaceShape::displaced ? SurfacePart::k_none : context.small[0];
  hit = {{found.hit.geomID, found.hit.primID, small},
         found.hit.u,
         found.hit.v,
         found.ray.tfar,
         ray.origin,
         Vec3f(found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z)};
  return true;
}

bool occluded(const SceneData& scene, const Ray& ray) {
  RayContext context = context_of(ray);
  RTCRay embree = embree_ray(ray);
  rtcOccluded1(scene_for(scene, ray.target), &context.embree, &embree);
  return embree.tfar < 0;
}

void nearest_hits(const SceneData& scene, RayPacket& packet, const RayTarget& target) {
  bool any = false;
  for (const int active : packet.active) any |= active != 0;
  if (!any) return;
  RayContext context = make_ray_context();
  context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  context.fraction = target.fraction;
  rtcIntersect16(packet.active, scene_for(scene, target), &context.embree, &packet.rays);
  packet.small = context.small;
  if (target.shape != SurfaceShape::displaced) packet.small.fill(SurfacePart::k_none);
}

}  // namespace recede::detail
