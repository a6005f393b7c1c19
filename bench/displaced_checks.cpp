// What must hold of displaced surfaces, counted over many rays.
#include "displaced_rays.h"
#include "displaced_run.h"
#include "displaced_scenes.h"
#include <recede/render/detail/displaced_data.h>
#include <recede/render/detail/flush_denormals.h>
#include <recede/render/detail/surface_point.h>
#include <recede/render/scene.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <atomic>

namespace recede::bench {
namespace {

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

/// Levels 1 to 6, mixed, or the surface's own.
DisplacedMeshOptions levels_of(const DisplacedSurface& surface, bool is_mixed) {
  DisplacedMeshOptions options;
  if (is_mixed) {
    options.triangle_levels = mixed_levels(surface.base, 1, 6);
  } else {
    options.level = surface.level;
  }
  return options;
}

/// Rays from around the middle of a closed surface that get out: aimed at the base's corners, at its sides,
/// at corners and sides of small triangles, and at random, by turns.
std::size_t leaks(const Vec3& center, bool is_mixed, std::size_t rays) {
  const DisplacedSurface surface = rough_sphere(8, center, 5);
  const DisplacedMesh mesh(surface.base, surface.map, levels_of(surface, is_mixed));
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

/// The same small triangle at the same distance, bit by bit; or both none.
bool is_same(const RTCRayHit& ours, std::uint32_t small, const RTCRayHit& theirs,
             const std::vector<std::uint64_t>& numbers) {
  const bool is_met = ours.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  if (is_met != (theirs.hit.geomID != RTC_INVALID_GEOMETRY_ID)) return false;
  return !is_met || (ours.ray.tfar == theirs.ray.tfar &&
                     numbers[theirs.hit.primID] == (std::uint64_t{ours.hit.primID} << 32 | small));
}

/// Rays for which the search differs from Embree's over the same small triangles, each tested alone.
std::string first_hits_line(const BenchOptions& options) {
  const std::size_t rays = options.quick ? 1'000'000 : 10'000'000;
  const RTCDevice device = rtcNewDevice(nullptr);
  std::string text;
  for (const bool is_mixed : {false, true}) {
    const DisplacedSurface surface = rough_sphere(8, Vec3::Zero(), 5);
    const DisplacedMesh mesh(surface.base, surface.map, levels_of(surface, is_mixed));
    std::vector<std::uint64_t> numbers;
    const DisplacedScene reference = one_by_one(device, mesh, numbers);
    const std::size_t per_task = rays / 2 / 1024;
    const std::size_t different = count_in_parallel(1024, [&](int task) {
      std::mt19937 random(static_cast<unsigned>(task));
      std::size_t count = 0;
      for (std::size_t k = 0; k < per_task; ++k) {
        const Vec3 from = 0.65 * random_direction(random), to = 0.55 * random_direction(random);
        const Ray ray{from.cast<float>(), (to - from).cast<float>()};
        RTCRayHit ours = embree_ray(ray), theirs = embree_ray(ray);
        detail::RayContext context = detail::make_ray_context();
        rtcIntersect1(mesh.data().scene.get(), &context.embree, &ours);
        rtcIntersect1(reference.scene, &context.embree, &theirs);
        if (!is_same(ours, context.small[0], theirs, numbers)) ++count;
      }
      return count;
    });
    text += fmt::format("First hits that differ from brute force, {} levels: {} of {} million\n\n",
                        is_mixed ? "mixed" : "equal", different, 1e-6 * static_cast<double>(per_task * 1024));
  }
  return text;
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
      if (detail::occluded(scene.data(), point.ray_towards(toward))) ++count;
    }
    return count;
  });
  return fmt::format("False shadows of a convex body on itself: {} of {:.1f} million shadow rays\n\n",
                     shadowed, 1e-6 * static_cast<double>(lit));
}

}  // namespace

std::string displaced_checks(const BenchOptions& options) {
  return leaks_table(options) + first_hits_line(options) + self_shadows_line(options);
}

}  // namespace recede::bench
