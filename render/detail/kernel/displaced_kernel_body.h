// One version of the kernel. The source that includes it defines RECEDE_KERNEL as its name.
#include <recede/render/detail/kernel/packet_search.h>

namespace recede::detail {
namespace {

// Calls with a Sample() of the map's kind.
template <typename Function>
auto with_sample(const HeightMapView& map, const Function& function) {
  return map.floats != nullptr ? function(float{}) : function(std::uint16_t{});
}

template <bool k_any>
void search_patch(const PatchArrays& arrays, std::uint32_t number, PatchRayQuery& ray) {
  const PatchPart part = part_of(arrays, number);
  with_sample(*arrays.map,
              [&](auto sample) { PatchSearch<decltype(sample), k_any>(arrays, part, ray).run(part); });
}

template <bool k_any>
void search_patch_together(const PatchArrays& arrays, std::uint32_t number, PatchRayQuery* rays,
                           unsigned count) {
  const PatchPart part = part_of(arrays, number);
  with_sample(*arrays.map, [&](auto sample) {
    PacketSearch<decltype(sample), k_any>(arrays, part, rays, count).run(part);
  });
}

PatchBox part_bounds(const PatchArrays& arrays, std::uint32_t number, bool partial) {
  const PatchPart part = part_of(arrays, number);
  const PatchPoints points(arrays, part.patch);
  const PatchFrame frame = PatchFrame::of_scene();
  const Boxes4 box = with_sample(*arrays.map, [&](auto sample) {
    const HeightMap<decltype(sample)> map(*arrays.map, 1);
    const PatchBounds<decltype(sample)> bounds(points, frame, map);
    return bounds.box_of(bounds.square_of(part), partial);
  });
  PatchBox result;
  for (int axis = 0; axis < 3; ++axis) {
    result.lower[axis] = box.lower[axis][0];
    result.upper[axis] = box.upper[axis][0];
  }
  return result;
}

void patch_point(const PatchArrays& arrays, std::uint32_t number, std::uint32_t i, std::uint32_t j,
                 float fraction, float* position) {
  const Place place = PatchPoints(arrays, number).point(i, j);
  with_sample(*arrays.map, [&](auto sample) {
    displaced_point(place, HeightMap<decltype(sample)>(*arrays.map, fraction), position);
  });
}

bool meet_triangle(const float* a, const float* b, const float* c, PatchRayQuery& ray) {
  const WatertightLine line(ray);
  if (!line.is_inside(a, b, c)) return false;
  const SmallTriangleHit hit = line.meet({{a[0], a[1], a[2]}}, {{b[0], b[1], b[2]}}, {{c[0], c[1], c[2]}});
  if (!(hit.t >= ray.t_min) || hit.t > ray.t_max || (hit.t == ray.t_max && !ray.accepts_equal)) return false;
  ray.t_max = hit.t;
  for (int axis = 0; axis < 3; ++axis) ray.normal[axis] = hit.normal[axis];
  return true;
}

}  // namespace

const DisplacedKernel RECEDE_KERNEL = {search_patch<false>,
                                       search_patch<true>,
                                       search_patch_together<false>,
                                       search_patch_together<true>,
                                       part_bounds,
                                       patch_point,
                                       meet_triangle};

}  // namespace recede::detail
