#include "displaced_run.h"

#include "child_process.h"
#include "displaced_scenes.h"
#include <recede/geometry/error.h>
#include <recede/render/detail/displaced_data.h>
#include <recede/render/detail/flush_denormals.h>
#include <recede/render/detail/surface_point.h>
#include <recede/render/renderer.h>

#include <fmt/format.h>
#include <malloc.h>
#include <tbb/parallel_for.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <random>

namespace recede::bench {
namespace {

constexpr unsigned k_seconds_allowed = 1200;
constexpr int k_image_side = 1024;

double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Ray {
  Eigen::Vector3f origin, direction;
};

Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

/// A picture of the ball, 4 x 4 pixels after 4 x 4 pixels.
std::vector<Ray> camera_rays(const Vec3& center, double radius) {
  std::vector<Ray> rays;
  for (int at = 0; at < k_image_side * k_image_side; ++at) {
    const int block = at / 16, x = block % (k_image_side / 4) * 4 + at % 4,
              y = block / (k_image_side / 4) * 4 + at / 4 % 4;
    const auto across = [](int pixel) { return 0.74 * ((pixel + 0.5) / k_image_side - 0.5); };
    rays.push_back({(center + Vec3(0, 0, 3 * radius)).cast<float>(),
                    Vec3(across(x), across(y), -1).normalized().cast<float>()});
  }
  return rays;
}

/// From around the ball to points within it.
std::vector<Ray> incoherent_rays(const Vec3& center, double radius) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Ray> rays;
  for (int k = 0; k < k_image_side * k_image_side; ++k) {
    const Vec3 from = center + 1.3 * radius * random_direction(random);
    const Vec3 to = center + 0.95 * radius * std::cbrt(share(random)) * random_direction(random);
    rays.push_back({from.cast<float>(), (to - from).normalized().cast<float>()});
  }
  return rays;
}

RTCRayHit embree_ray(const Ray& ray) {
  RTCRayHit hit{};
  hit.ray.org_x = ray.origin.x();
  hit.ray.org_y = ray.origin.y();
  hit.ray.org_z = ray.origin.z();
  hit.ray.dir_x = ray.direction.x();
  hit.ray.dir_y = ray.direction.y();
  hit.ray.dir_z = ray.direction.z();
  hit.ray.tfar = std::numeric_limits<float>::infinity();
  hit.ray.mask = 0xffffffffu;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return hit;
}

detail::RayContext context_of(bool coherent) {
  detail::RayContext context = detail::make_ray_context();
  if (coherent) context.embree.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

/// Million rays a second, one by one.
double single_rate(RTCScene scene, const std::vector<Ray>& rays, std::size_t count, bool coherent) {
  const detail::FlushDenormals flush;
  const double start = thread_seconds();
  // Evenly over all, so that fewer rays see the same.
  const std::size_t step = std::max<std::size_t>(1, rays.size() / count);
  std::size_t traced = 0;
  for (std::size_t k = 0; k < rays.size(); k += step, ++traced) {
    detail::RayContext context = context_of(coherent);
    RTCRayHit ray = embree_ray(rays[k]);
    rtcIntersect1(scene, &context.embree, &ray);
  }
  return 1e-6 * static_cast<double>(traced) / (thread_seconds() - start);
}

/// Sixteen together.
double packet_rate(RTCScene scene, const std::vector<Ray>& rays) {
  const detail::FlushDenormals flush;
  const double start = thread_seconds();
  for (std::size_t first = 0; first + 16 <= rays.size(); first += 16) {
    alignas(64) std::array<int, 16> valid;
    RTCRayHit16 packet;
    for (std::size_t k = 0; k < 16; ++k) {
      const RTCRayHit ray = embree_ray(rays[first + k]);
      valid[k] = -1;
      packet.ray.org_x[k] = ray.ray.org_x;
      packet.ray.org_y[k] = ray.ray.org_y;
      packet.ray.org_z[k] = ray.ray.org_z;
      packet.ray.dir_x[k] = ray.ray.dir_x;
      packet.ray.dir_y[k] = ray.ray.dir_y;
      packet.ray.dir_z[k] = ray.ray.dir_z;
      packet.ray.tnear[k] = 0;
      packet.ray.tfar[k] = ray.ray.tfar;
      packet.ray.time[k] = 0;
      packet.ray.mask[k] = ray.ray.mask;
      packet.ray.id[k] = static_cast<unsigned>(k);
      packet.ray.flags[k] = 0;
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
    }
    detail::RayContext context = context_of(true);
    rtcIntersect16(valid.data(), scene, &context.embree, &packet);
  }
  return 1e-6 * static_cast<double>(rays.size()) / (thread_seconds() - start);
}

struct Figures {
  std::size_t small = 0;
  double build_seconds = 0;
  double bytes = 0;                                ///< of a small triangle, map included
  double packets = 0, camera = 0, incoherent = 0;  ///< million rays a second
};

double best(std::size_t runs, const std::function<double()>& rate) {
  std::vector<double> rates;
  while (rates.size() < runs) rates.push_back(rate());
  return median(rates);
}

std::size_t small_triangles(const DisplacedSurface& surface, int level) {
  std::vector<Index> faces;
  triangulate(surface.base, &faces, nullptr);
  return faces.size() << (2 * level);
}

/// What libraries take once for all is no surface's.
void warm_up() {
  const DisplacedSurface surface = rough_sphere(4, Vec3::Zero(), 1);
  DisplacedMeshOptions options;
  options.level = 1;
  DisplacedMesh(surface.base, surface.map, options).first_hit({0, 0, 3}, {0, 0, -1});
}

Figures measure_scene(const DisplacedSystem& system, DisplacedSurface surface, int level,
                      std::size_t repeats) {
  const Box3 box = bounding_box(surface.base);
  const double scale = 1 / box.sizes().maxCoeff(), radius = 0.5 * scale * box.sizes().maxCoeff();
  Figures figures;
  figures.small = small_triangles(surface, level);
  const RTCDevice device = rtcNewDevice(nullptr);
  warm_up();
  system.build(device, rough_sphere(1, Vec3::Zero(), 1), 1);
  malloc_trim(0);
  const std::size_t before = resident_bytes();
  const DisplacedScene scene = system.build(device, std::move(surface), level);
  malloc_trim(0);
  figures.build_seconds = scene.build_seconds;
  // Small ones can fit into what was freed before.
  const std::size_t kept = std::max(resident_bytes(), before) - before + scene.map_bytes;
  figures.bytes = static_cast<double>(kept) / static_cast<double>(figures.small);
  // Rays are those of the scaled scene around the origin.
  const std::vector<Ray> camera = camera_rays(Vec3::Zero(), radius),
                         any = incoherent_rays(Vec3::Zero(), radius);
  const auto count =
      static_cast<std::size_t>(1e-3 * system.rays_of_thousand * static_cast<double>(camera.size()));
  const bool is_slow = system.rays_of_thousand < 1000;
  if (!is_slow) figures.packets = best(repeats, [&] { return packet_rate(scene.scene, camera); });
  figures.camera = best(repeats, [&] { return single_rate(scene.scene, camera, count, true); });
  figures.incoherent = best(repeats, [&] { return single_rate(scene.scene, any, count, false); });
  return figures;
}

std::string cell(const ChildAnswer& answer, const std::function<std::string(const Figures&)>& text) {
  if (!answer.succeeded) return answer.failure;
  ByteReader reader(answer.bytes);
  return text(reader.take<Figures>());
}

ChildAnswer measure_in_child(const DisplacedSystem& system, const std::function<DisplacedSurface()>& make,
                             int level, std::size_t repeats) {
  return run_in_child(
      [&] {
        std::string bytes;
        put(bytes, measure_scene(system, make(), level, repeats));
        return bytes;
      },
      k_seconds_allowed);
}

std::string rates_text(const Figures& f) {
  const std::string packets = f.packets > 0 ? fmt::format("{:.2f}", f.packets) : "";
  return fmt::format("{:.2f} | {:.3g} | {} | {:.3g} | {:.3g}", f.build_seconds, f.bytes, packets, f.camera,
                     f.incoherent);
}

std::string systems_table(const std::string& name, const std::function<DisplacedSurface()>& make, int level,
                          const BenchOptions& options) {
  std::string text;
  std::size_t small = 0;
  for (const DisplacedSystem& system : displaced_systems()) {
    if (!is_wanted(system.name, options.systems)) continue;
    const ChildAnswer answer = measure_in_child(system, make, level, options.repeats);
    text += fmt::format("| {} | {} |\n", system.name, cell(answer, [&](const Figures& f) {
                          small = f.small;
                          return rates_text(f);
                        }));
  }
  return fmt::format(
      "**{}, level {}: {} small triangles**\n\n| system | build, s | bytes each | camera, 16 together | "
      "camera | "
      "incoherent |\n|---|---|---|---|---|---|\n{}\n",
      name, level, small, text);
}

std::string levels_table(const BenchOptions& options) {
  std::string text =
      "**Fractal sphere at growing levels: bytes each ; camera rays 16 together ; camera ; incoherent**\n\n| "
      "level |";
  std::vector<DisplacedSystem> systems;
  for (const DisplacedSystem& system : displaced_systems()) {
    const bool is_shown =
        system.name == "Recede" || system.name == "Embree triangles" || system.name == "recursion";
    if (!is_shown || !is_wanted(system.name, options.systems)) continue;
    systems.push_back(system);
    text += fmt::format(" {} |", system.name);
  }
  text += "\n|---|";
  for (std::size_t k = 0; k < systems.size(); ++k) text += "---|";
  text += "\n";
  if (systems.empty()) return {};
  for (int level = 1; level <= 8; ++level) {
    text += fmt::format("| {} |", level);
    for (const DisplacedSystem& system : systems) {
      if ((std::size_t{3072} << (2 * level)) > system.most_small) {
        text += "  |";
        continue;
      }
      const ChildAnswer answer = measure_in_child(system, fractal_sphere, level, options.repeats);
      text += fmt::format(" {} |", cell(answer, [](const Figures& f) {
                            return fmt::format("{:.3g} ; {:.3g} ; {:.3g} ; {:.3g}", f.bytes, f.packets,
                                               f.camera, f.incoherent);
                          }));
    }
    text += "\n";
  }
  return text + "\n";
}

/// Runs `work` for the numbers from 0 to `tasks`, on all threads, and sums what it counts.
std::size_t count_in_parallel(int tasks, const std::function<std::size_t(int)>& work) {
  std::atomic<std::size_t> sum{0};
  tbb::parallel_for(0, tasks, [&](int task) {
    const detail::FlushDenormals flush;
    sum += work(task);
  });
  return sum;
}

std::vector<std::uint8_t> mixed_levels(const PolygonSoup& base, int least, int most) {
  std::mt19937 random(3);
  std::vector<Index> faces;
  triangulate(base, &faces, nullptr);
  std::vector<std::uint8_t> levels(faces.size());
  for (std::uint8_t& level : levels)
    level = static_cast<std::uint8_t>(std::uniform_int_distribution<int>(least, most)(random));
  return levels;
}

/// Rays from around the middle of a closed surface that get out: aimed at the base's corners, at its sides,
/// at corners and sides of small triangles, and at random, by turns.
std::size_t leaks(const Vec3& center, bool is_mixed, std::size_t rays) {
  const DisplacedSurface surface = rough_sphere(8, center, 5);
  DisplacedMeshOptions options;
  if (is_mixed) {
    options.triangle_levels = mixed_levels(surface.base, 1, 6);
  } else {
    options.level = surface.level;
  }
  const DisplacedMesh mesh(surface.base, surface.map, options);
  const PolygonSoup small = mesh.tessellate();
  constexpr int k_tasks = 1024;
  return count_in_parallel(k_tasks, [&](int task) {
    std::mt19937 random(static_cast<unsigned>(task));
    std::uniform_real_distribution<double> share(0, 1);
    const auto side_of = [&](const PolygonSoup& soup) {
      const Index face = static_cast<Index>(random() % soup.n_faces());
      const Index first = soup.face_offsets[face], n = soup.face_offsets[face + 1] - first;
      const Index k = static_cast<Index>(random() % n);
      return std::pair(soup.positions[soup.corner_vertices[first + k]],
                       soup.positions[soup.corner_vertices[first + (k + 1) % n]]);
    };
    std::size_t escaped = 0;
    for (std::size_t k = 0; k < rays / k_tasks; ++k) {
      const bool at_base = k % 5 < 2;
      const auto [a, b] = side_of(at_base ? surface.base : small);
      Vec3 to = a;
      if (k % 5 == 1 || k % 5 == 3) to = a + share(random) * (b - a);
      if (k % 5 == 4) to = center + random_direction(random);
      const Vec3 from = k % 2 == 0 ? center : Vec3(center + 0.3 * random_direction(random));
      if (!mesh.is_hit(from, to - from)) ++escaped;
    }
    return escaped;
  });
}

std::string leaks_table(const BenchOptions& options) {
  const std::size_t rays = options.quick ? 1'000'000 : 17'000'000;
  std::string text = fmt::format(
      "**Rays that get out of a closed rough sphere, of {} million each**\n\n| offset | one level | mixed "
      "levels "
      "|\n|---|---|---|\n",
      rays / 1'000'000);
  for (const double offset : {0.0, 1e3, 1e5}) {
    const Vec3 center = offset * Vec3(1, -0.7, 0.4);
    text +=
        fmt::format("| {:g} | {} | {} |\n", offset, leaks(center, false, rays), leaks(center, true, rays));
  }
  return text + "\n";
}

/// Rays for which the search differs from Embree's over the same small triangles, each tested alone.
std::string first_hits_line(const BenchOptions& options) {
  const std::size_t rays = options.quick ? 1'000'000 : 10'000'000;
  const RTCDevice device = rtcNewDevice(nullptr);
  std::string text;
  for (const bool is_mixed : {false, true}) {
    const DisplacedSurface surface = rough_sphere(8, Vec3::Zero(), 5);
    DisplacedMeshOptions mesh_options;
    if (is_mixed) {
      mesh_options.triangle_levels = mixed_levels(surface.base, 1, 6);
    } else {
      mesh_options.level = surface.level;
    }
    const DisplacedMesh mesh(surface.base, surface.map, mesh_options);
    const DisplacedScene reference = one_by_one(device, mesh);
    const std::size_t per_task = rays / 2 / 1024;
    const std::size_t different = count_in_parallel(1024, [&](int task) {
      std::mt19937 random(static_cast<unsigned>(task));
      std::size_t count = 0;
      for (std::size_t k = 0; k < per_task; ++k) {
        const Vec3 from = 0.65 * random_direction(random), to = 0.55 * random_direction(random);
        const Ray ray{from.cast<float>(), (to - from).cast<float>()};
        RTCRayHit ours = embree_ray(ray), theirs = embree_ray(ray);
        detail::RayContext context = context_of(false);
        rtcIntersect1(mesh.data().scene, &context.embree, &ours);
        rtcIntersect1(reference.scene, &context.embree, &theirs);
        count += ours.hit.geomID != theirs.hit.geomID || ours.ray.tfar != theirs.ray.tfar ? 1 : 0;
      }
      return count;
    });
    text += fmt::format("First hits that differ from brute force, {} levels: {} of {} million\n\n",
                        is_mixed ? "mixed" : "equal", different, 1e-6 * static_cast<double>(per_task * 1024));
  }
  return text;
}

std::string memory_line() {
  const ChildAnswer answer = run_in_child(
      [] {
        warm_up();
        DisplacedSurface surface = tiled_sphere();
        std::vector<Index> faces;
        triangulate(surface.base, &faces, nullptr);
        const std::size_t triangles = faces.size(), map = surface.map.bytes();
        malloc_trim(0);
        const std::size_t before = resident_bytes();
        DisplacedMeshOptions options;
        options.level = surface.level;
        const DisplacedMesh mesh(surface.base, std::move(surface.map), options);
        const std::vector<Ray> rays = camera_rays(Vec3::Zero(), 0.5);
        const double rate = single_rate(mesh.data().scene, rays, rays.size(), true);
        malloc_trim(0);
        const std::size_t kept = resident_bytes() - before;
        const DisplacedMesh::Memory memory = mesh.memory();
        const double small = static_cast<double>(mesh.small_triangles());
        std::string bytes;
        put(bytes,
            fmt::format(
                "A map of 4096 x 4096 texels on {} base triangles, {:.2g} small triangles: {:.1f} MB above "
                "the map of {:.1f} MB, {:.1f} of them the base in our form and {:.1f} the pyramid; {:.2f} "
                "million camera rays a second\n\n",
                triangles, small, 1e-6 * static_cast<double>(kept), 1e-6 * static_cast<double>(map),
                1e-6 * static_cast<double>(memory.base), 1e-6 * static_cast<double>(memory.pyramid), rate));
        return bytes;
      },
      k_seconds_allowed);
  if (!answer.succeeded) return answer.failure + "\n\n";
  ByteReader reader(answer.bytes);
  return reader.take_text();
}

/// Small triangles of a sphere of one height are the faces of a convex body: none that faces the light is in
/// a shadow. Counts those that are, for places and directions at random.
std::string self_shadows_line(const BenchOptions& options) {
  const std::size_t rays = options.quick ? 1'000'000 : 10'000'000;
  const DisplacedSurface surface = rough_sphere(8, Vec3::Zero(), 5);
  DisplacedMeshOptions mesh_options;
  mesh_options.level = 5;
  const Scene scene(surface.base, DisplacementMap(2, 2, std::vector<float>(4, 0.05f)), mesh_options);
  constexpr int k_tasks = 1024;
  std::atomic<std::size_t> lit{0};
  const std::size_t shadowed = count_in_parallel(k_tasks, [&](int task) {
    std::mt19937 random(static_cast<unsigned>(task));
    std::size_t count = 0;
    for (std::size_t k = 0; k < 2 * rays / k_tasks; ++k) {  // half of all places face away
      const Vec3 from = 0.9 * random_direction(random), to = 0.3 * random_direction(random),
                 toward = random_direction(random);
      const detail::Ray ray{from.cast<float>(), (to - from).normalized().cast<float>()};
      detail::Hit hit;
      if (!detail::nearest_hit(scene.data(), ray, hit)) continue;
      const detail::SurfacePoint point = detail::surface_point(scene.data(), hit, ray.direction);
      if (point.geometric_normal.dot(toward) <= 0) continue;
      ++lit;
      count += detail::occluded(scene.data(), point.ray_towards(toward)) ? 1 : 0;
    }
    return count;
  });
  return fmt::format("False shadows of a convex body on itself: {} of {:.1f} million shadow rays\n\n",
                     shadowed, 1e-6 * static_cast<double>(lit));
}

std::string edit_line() {
  const ChildAnswer answer = run_in_child(
      [] {
        const DisplacedSurface surface = fractal_sphere();
        DisplacedMeshOptions options;
        options.level = surface.level;
        DisplacedMesh mesh(surface.base, surface.map, options);
        std::vector<double> milliseconds;
        for (int k = 0; k < 9; ++k) {
          DisplacementMap copy = surface.map;
          timespec start{}, end{};
          clock_gettime(CLOCK_MONOTONIC, &start);
          mesh.set_map(std::move(copy));
          clock_gettime(CLOCK_MONOTONIC, &end);
          milliseconds.push_back(1e3 * static_cast<double>(end.tv_sec - start.tv_sec) +
                                 1e-6 * static_cast<double>(end.tv_nsec - start.tv_nsec));
        }
        std::string bytes;
        put(bytes, fmt::format("Another map on the fractal sphere: {:.1f} ms\n\n", median(milliseconds)));
        return bytes;
      },
      k_seconds_allowed);
  if (!answer.succeeded) return answer.failure + "\n\n";
  ByteReader reader(answer.bytes);
  return reader.take_text();
}

/// Processor seconds of a picture.
double picture_seconds(const Scene& scene, const Camera& camera, std::size_t repeats) {
  RenderOptions options;
  options.samples_per_pixel = 4;
  return median_seconds(repeats, [&] { render(scene, camera, options); });
}

/// Pictures of the bunny: over their size, over the base, and with another level for every one.
std::string pictures_table(const BenchOptions& options) {
  const ChildAnswer answer = run_in_child(
      [&] {
        const Scene coarse(bunny_maps(options.data, 0.02), {}), fine(bunny_maps(options.data, 0.2), {});
        Camera camera;
        camera.position = {0.6, 0.5, 1.6};
        std::string text =
            "**Pictures of the traced bunny, 4 samples a pixel, processor seconds**\n\n| pixels | 2 % of the "
            "faces | 20 % of the faces |\n|---|---|---|\n";
        for (const int size : {256, 512, 1024}) {
          camera.width = camera.height = size;
          text += fmt::format("| {} x {} | {:.3f} | {:.3f} |\n", size, size,
                              picture_seconds(coarse, camera, options.repeats),
                              picture_seconds(fine, camera, options.repeats));
        }
        // The base with its normal map is that of a surface without heights and subdivision.
        BakedMaps maps = bunny_maps(options.data, 0.02);
        const Scene bare(maps.surface);
        maps.height_scale = maps.height_offset = 0;
        const Scene bump(maps, {.level = 0});
        text += fmt::format("\nThe last size without heights: base {:.3f} s, with its normal map {:.3f} s.\n",
                            picture_seconds(bare, camera, options.repeats),
                            picture_seconds(bump, camera, options.repeats));
        camera.width = camera.height = 256;
        const double by_turns = median_seconds(options.repeats, [&] {
          for (int k = 0; k < 8; ++k) picture_seconds(k % 2 == 0 ? coarse : fine, camera, 1);
        });
        const double in_a_row = median_seconds(options.repeats, [&] {
          for (int k = 0; k < 8; ++k) picture_seconds(k < 4 ? coarse : fine, camera, 1);
        });
        text += fmt::format(
            "\nEight pictures with the levels by turns take {:.2f} times as long as four of each.\n\n",
            by_turns / in_a_row);
        std::string bytes;
        put(bytes, text);
        return bytes;
      },
      k_seconds_allowed);
  if (!answer.succeeded) return answer.failure + "\n\n";
  ByteReader reader(answer.bytes);
  return reader.take_text();
}

}  // namespace

std::string displaced_tables(const BenchOptions& options) {
  // Children first: they must be forked before this process has threads.
  std::string text = systems_table("Fractal sphere", fractal_sphere, 6, options);
  text += systems_table(
      "Bunny with a map", [&] { return mapped_bunny(options.data); }, 5, options);
  if (!options.quick) text += levels_table(options);
  text += pictures_table(options) + memory_line() + edit_line();
  return text + leaks_table(options) + first_hits_line(options) + self_shadows_line(options);
}

}  // namespace recede::bench
