#include <recede/geometry/error.h>
#include <recede/render/detail/flush_denormals.h>
#include <recede/render/detail/scene_data.h>
#include <recede/render/renderer.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recede {

namespace {

using detail::SceneData;

using Vec3f = Eigen::Vector3f;

constexpr int k_packet_side = 4;  // a packet holds the same sample of 4 x 4 neighbouring pixels
constexpr int k_lanes = k_packet_side * k_packet_side;
constexpr int k_tile_side = 32;
constexpr std::size_t k_batch = 256;  // tiles between two reports of progress

// Samples (i + 1/2, j(i) + 1/2) / n with j(i) = i g mod n: a lattice that meets each of n columns and n rows
// once. Steps near the golden section keep the points apart.
std::vector<Vec2> sample_pattern(int count) {
  int step = std::max(1, static_cast<int>(std::lround(0.6180339887 * count)));
  while (std::gcd(step, count) != 1) ++step;
  std::vector<Vec2> pattern;
  for (int i = 0; i < count; ++i)
    pattern.push_back((Vec2(i, (i * step) % count) + Vec2::Constant(0.5)) / count);
  return pattern;
}

// A packet of rays, and what shading needs to know of each beside what Embree stores.
struct Packet {
  alignas(64) int active[k_lanes];
  alignas(64) RTCRayHit16 rays;
  Vec3f directions[k_lanes];
  float entry[k_lanes];  // from the camera to the ray's origin, units of the scaled scene
};

class PictureTracer {
 public:
  PictureTracer(const SceneData& scene, const Camera& camera, const RenderOptions& options)
      : scene_(scene),
        options_(options),
        frame_(frame_of(camera)),
        samples_(sample_pattern(options.samples_per_pixel)) {
    eye_ = (frame_.position - scene.center) * scene.scale;
    const Vec3& lamp = options.light.toward;
    toward_lamp_ = (lamp.x() * frame_.right + lamp.y() * frame_.up - lamp.z() * frame_.forward)
                       .normalized()
                       .cast<float>();
    up_ = frame_.up.cast<float>();
  }

  void draw_packet(int left, int top, Image& image) const;

 private:
  void aim(int left, int top, const Vec2& sample, Packet& packet) const;
  Rgb shade(const Packet& packet, int lane) const;
  Rgb light_on(const Vec3f& normal) const;
  float line_cover(const Packet& packet, int lane, const std::array<Vec3f, 3>& corners, const Vec3f& hit,
                   float pixel) const;

  const SceneData& scene_;
  const RenderOptions& options_;
  CameraFrame frame_;
  std::vector<Vec2> samples_;
  Vec3 eye_;
  Vec3f toward_lamp_, up_;
};

// Rays start where they enter the sphere around the scene: from there on, float holds the unit box well,
// however far the camera. Rays that miss the sphere aren't traced.
void PictureTracer::aim(int left, int top, const Vec2& sample, Packet& packet) const {
  for (int lane = 0; lane < k_lanes; ++lane) {
    const Vec3 direction =
        frame_.direction(left + lane % k_packet_side + sample.x(), top + lane / k_packet_side + sample.y());
    const double along = -eye_.dot(direction);
    const double squared_gap = (eye_ + along * direction).squaredNorm();
    const double half_chord_squared = scene_.radius * scene_.radius - squared_gap;
    const double half_chord = std::sqrt(std::max(0.0, half_chord_squared));
    packet.active[lane] = half_chord_squared > 0 && along + half_chord > 0 ? -1 : 0;
    const double entry = std::max(0.0, along - half_chord);
    const Vec3f origin = (eye_ + entry * direction).cast<float>();
    packet.entry[lane] = static_cast<float>(entry);
    packet.directions[lane] = direction.cast<float>();
    RTCRay16& ray = packet.rays.ray;
    ray.org_x[lane] = origin.x();
    ray.org_y[lane] = origin.y();
    ray.org_z[lane] = origin.z();
    ray.dir_x[lane] = packet.directions[lane].x();
    ray.dir_y[lane] = packet.directions[lane].y();
    ray.dir_z[lane] = packet.directions[lane].z();
    ray.tnear[lane] = 0;
    ray.tfar[lane] = std::numeric_limits<float>::infinity();
    ray.time[lane] = 0;
    ray.mask[lane] = 0xffffffffu;
    ray.id[lane] = 0;
    ray.flags[lane] = 0;
    packet.rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

Rgb PictureTracer::light_on(const Vec3f& normal) const {
  const Light& light = options_.light;
  const float upward = 0.5f + 0.5f * normal.dot(up_);
  return light.lamp * std::max(0.0f, normal.dot(toward_lamp_)) + light.ground +
         upward * (light.sky - light.ground);
}

// How much of the sample lies on a line, 0 to 1. Distances are measured across the ray, where the picture
// shows them.
float PictureTracer::line_cover(const Packet& packet, int lane, const std::array<Vec3f, 3>& corners,
                                const Vec3f& hit, float pixel) const {
  constexpr float k_unseen = 3, k_clear = 12;  // sides of polygons in pixels between which lines fade in
  const std::uint32_t triangle = packet.rays.hit.primID[lane];
  const Vec3f& direction = packet.directions[lane];
  const Vec3f front = (corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized();
  const float side = std::sqrt(scene_.polygon_areas[triangle] * std::abs(front.dot(direction))) / pixel;
  const float fade = std::clamp((side - k_unseen) / (k_clear - k_unseen), 0.0f, 1.0f);
  if (fade == 0) return 0;
  const float half_width = static_cast<float>(options_.wireframe->width) / 2;
  float cover = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if ((scene_.polygon_sides[triangle] >> k & 1) == 0) continue;
    const Vec3f across = direction.cross(corners[(k + 1) % 3] - corners[k]).stableNormalized();
    const float distance = std::abs(across.dot(corners[k] - hit)) / pixel;
    cover = std::max(cover, std::clamp(half_width + 0.5f - distance, 0.0f, 1.0f));
  }
  return fade * cover;
}

Rgb PictureTracer::shade(const Packet& packet, int lane) const {
  const RTCHit16& hit = packet.rays.hit;
  const std::uint32_t triangle = hit.primID[lane];
  const Vec3f weights(1 - hit.u[lane] - hit.v[lane], hit.u[lane], hit.v[lane]);
  const Vec3f front(hit.Ng_x[lane], hit.Ng_y[lane], hit.Ng_z[lane]);
  const std::array<std::uint32_t, 3>& vertices = scene_.triangles[triangle];
  Vec3f normal = Vec3f::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    normal += weights[static_cast<int>(k)] * scene_.corner_normals[3 * triangle + k];
  if (normal.squaredNorm() < 1e-12f) normal = front;
  if (front.dot(packet.directions[lane]) > 0) normal = -normal;
  Rgb color = scene_.triangle_colors[triangle];
  if (!scene_.vertex_colors.empty()) {
    Rgb factor = Rgb::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      factor += weights[static_cast<int>(k)] * scene_.vertex_colors[vertices[k]];
    color = color.cwiseProduct(factor);
  }
  color = color.cwiseProduct(light_on(normal.stableNormalized()));
  if (!options_.wireframe) return color;

  std::array<Vec3f, 3> corners;
  Vec3f place = Vec3f::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k] = Vec3f(scene_.positions[vertices[k]].data());
    place += weights[static_cast<int>(k)] * corners[k];
  }
  const float pixel = (packet.entry[lane] + packet.rays.ray.tfar[lane]) * static_cast<float>(frame_.pixel);
  const float cover = line_cover(packet, lane, corners, place, pixel);
  return color * (1 - static_cast<float>(options_.wireframe->darkness) * cover);
}

void PictureTracer::draw_packet(int left, int top, Image& image) const {
  Packet packet;
  std::array<Rgb, k_lanes> sums;
  sums.fill(Rgb::Zero());
  for (const Vec2& sample : samples_) {
    aim(left, top, sample, packet);
    if (std::any_of(packet.active, packet.active + k_lanes, [](int active) { return active != 0; })) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      rtcIntersect16(packet.active, scene_.scene, &context, &packet.rays);
    }
    for (int lane = 0; lane < k_lanes; ++lane) {
      const bool hit = packet.active[lane] != 0 && packet.rays.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
      sums[static_cast<std::size_t>(lane)] += hit ? shade(packet, lane) : options_.background;
    }
  }
  for (int lane = 0; lane < k_lanes; ++lane) {
    const int x = left + lane % k_packet_side, y = top + lane / k_packet_side;
    if (x >= image.width || y >= image.height) continue;
    image.at(x, y) = sums[static_cast<std::size_t>(lane)] / static_cast<float>(samples_.size());
  }
}

void draw_tile(const PictureTracer& tracer, int left, int top, Image& image) {
  const detail::FlushDenormals flush;
  const int right = std::min(image.width, left + k_tile_side),
            below = std::min(image.height, top + k_tile_side);
  for (int y = top; y < below; y += k_packet_side) {
    for (int x = left; x < right; x += k_packet_side) tracer.draw_packet(x, y, image);
  }
}

void check(const RenderOptions& options) {
  constexpr int k_most_samples = 1024;
  if (options.samples_per_pixel < 1 || options.samples_per_pixel > k_most_samples) {
    throw OptionError("samples per pixel lie between 1 and 1024");
  }
  if (!options.wireframe) return;
  if (!(options.wireframe->width > 0)) throw OptionError("the width of wireframe lines is above 0 pixels");
  if (!(options.wireframe->darkness >= 0 && options.wireframe->darkness <= 1)) {
    throw OptionError("the darkness of wireframe lines lies between 0 and 1");
  }
}

}  // namespace

Image render(const Scene& scene, const Camera& camera, const RenderOptions& options, Progress* progress) {
  check(options);
  const PictureTracer tracer(scene.data(), camera, options);
  Image image(camera.width, camera.height);
  const std::size_t columns = static_cast<std::size_t>((camera.width + k_tile_side - 1) / k_tile_side);
  const std::size_t rows = static_cast<std::size_t>((camera.height + k_tile_side - 1) / k_tile_side);
  const std::size_t tiles = columns * rows;
  for (std::size_t begin = 0; begin < tiles; begin += k_batch) {
    report_progress(progress, "render", static_cast<double>(begin) / static_cast<double>(tiles));
    tbb::parallel_for(begin, std::min(tiles, begin + k_batch), [&](std::size_t tile) {
      draw_tile(tracer, static_cast<int>(tile % columns) * k_tile_side,
                static_cast<int>(tile / columns) * k_tile_side, image);
    });
  }
  report_progress(progress, "render", 1);
  return image;
}

}  // namespace recede
