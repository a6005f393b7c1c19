#include <recede/render/detail/displaced_look.h>
#include <recede/render/detail/picture_tracer.h>
#include <recede/render/detail/wireframe.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace recede::detail {

namespace {

// Samples (i + 1/2, j(i) + 1/2) / n with j(i) = i g mod n: a lattice that meets each of n columns and n rows
// once. Steps near the golden section keep the points apart. In the order of reversed bits the first ones are
// spread over the pixel too, with which a picture may end.
std::vector<Vec2> sample_pattern(int count) {
  int step = std::max(1, static_cast<int>(std::lround(0.6180339887 * count)));
  while (std::gcd(step, count) != 1) ++step;
  const auto end = std::bit_ceil(static_cast<std::uint32_t>(count));
  std::vector<Vec2> pattern;
  for (std::uint32_t k = 0; k < end; ++k) {
    const auto i = static_cast<int>(std::uint64_t{reverse_bits(k)} * end >> 32);
    if (i < count) pattern.push_back((Vec2(i, (i * step) % count) + Vec2::Constant(0.5)) / count);
  }
  return pattern;
}

// The sum of several lights that are as bright as a light may be can be infinite in float; a picture has
// numbers.
constexpr float k_brightest = 1e18f;

}  // namespace

PictureTracer::PictureTracer(const SceneData& scene, const Camera& camera, const RenderOptions& options)
    : scene_(scene), options_(options), rays_(scene, camera), surfaces_(scene, rays_.frame(), options) {
  if (options.transport == LightTransport::camera) {
    const CameraFrame& frame = rays_.frame();
    const Vec3& lamp = options.camera_light.toward;
    toward_lamp_ = (lamp.x() * frame.right + lamp.y() * frame.up - lamp.z() * frame.forward).normalized();
    up_ = frame.up;
    pattern_ = sample_pattern(options.samples_per_pixel);
  } else {
    lights_.emplace(options.lighting, scene, options.light_sampling);
    paths_.emplace(scene, *lights_, options);
  }
}

Rgb PictureTracer::camera_light_on(const SurfaceLook& look) const {
  const CameraLight& light = options_.camera_light;
  const auto upward = static_cast<float>(0.5 + 0.5 * mean_normal(look).dot(up_));
  return light.lamp * static_cast<float>(facing(look, toward_lamp_)) + light.ground +
         upward * (light.sky - light.ground);
}

Rgb PictureTracer::method_color_of(const SeenSurface& surface, const Vec3f& direction) const {
  const SurfaceLook look = look_of(scene_, surface.hit, direction, surface.shares);
  const float shade =
      0.35f + 0.65f * std::max(0.0f, -static_cast<float>(mean_normal(look).dot(direction.cast<double>())));
  if (!surface.transition) return Rgb::Constant(0.5f * shade);
  const MethodShares& shares = surface.shares;
  const double bump = 1 - std::max(shares.table, shares.displaced);
  return shade * Vec3(shares.table, shares.displaced, bump).cast<float>();
}

float PictureTracer::line_factor_at(const RayPacket& packet, int lane, const Hit& hit) const {
  const float pixel = (packet.entry[lane] + hit.distance) * static_cast<float>(rays_.frame().pixel);
  const MeshData& mesh = scene_.meshes[hit.part.object];
  if (mesh.billboards || mesh.volume) return 1;
  return line_factor(mesh, *options_.wireframe, mesh.displaced ? hit_of_base(*mesh.displaced, hit) : hit,
                     packet.directions[lane], pixel);
}

void PictureTracer::sample_block(int left, int top, int sample, BlockColors& colors) const {
  if (lights_) return sample_by_scene_light(left, top, sample, colors);
  sample_by_camera_light(left, top, sample, colors);
}

void PictureTracer::sample_by_camera_light(int left, int top, int sample, BlockColors& colors) const {
  CameraRays::Places places;
  places.fill(pattern_[static_cast<std::size_t>(sample) % pattern_.size()]);
  RayPacket packet;
  rays_.aim(left, top, places, packet);
  SeenSurfaces::Block seen;
  surfaces_.find(packet, seen);
  for (int lane = 0; lane < k_lanes; ++lane) {
    const SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
    const Vec3f& direction = packet.directions[lane];
    Rgb color = options_.background;
    if (surface.is_there && options_.show_methods) {
      color = method_color_of(surface, direction);
    } else if (surface.is_there) {
      const SurfaceLook look = look_of(scene_, surface.hit, direction, surface.shares);
      color = look.albedo.cwiseProduct(camera_light_on(look));
    }
    if (surface.is_there && options_.wireframe) color *= line_factor_at(packet, lane, surface.hit);
    colors.set(lane, color);
  }
}

void PictureTracer::sample_by_scene_light(int left, int top, int sample, BlockColors& colors) const {
  std::array<SampleStream, k_lanes> numbers;
  CameraRays::Places places;
  for (int lane = 0; lane < k_lanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    numbers[i] = SampleStream(left + column_of(lane), top + row_of(lane), static_cast<std::uint32_t>(sample));
    places[i] = numbers[i].next_pair();
  }
  RayPacket packet;
  rays_.aim(left, top, places, packet);
  SeenSurfaces::Block seen;
  surfaces_.find(packet, seen);
  for (int lane = 0; lane < k_lanes; ++lane) {
    const SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
    const Vec3 direction = packet.directions[lane].cast<double>();
    double distance = std::numeric_limits<double>::infinity();
    Rgb color;
    if (surface.is_there) {
      distance = static_cast<double>(packet.entry[lane]) + static_cast<double>(surface.hit.distance);
      color = options_.show_methods ? method_color_of(surface, packet.directions[lane])
                                    : paths_->radiance(surface.hit, packet.directions[lane], surface.shares,
                                                       numbers[static_cast<std::size_t>(lane)]);
      if (options_.wireframe) color *= line_factor_at(packet, lane, surface.hit);
    } else {
      color = lights_->seen_environment(direction).value_or(options_.background);
    }
    color += lights_->seen(rays_.eye(), direction, distance);
    colors.set(lane, color.cwiseMin(k_brightest));
  }
}

}  // namespace recede::detail
