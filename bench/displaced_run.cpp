#include "displaced_run.h"

#include "child_process.h"
#include "displaced_rays.h"
#include "displaced_scenes.h"
#include "plot_sheet.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/render/detail/displaced_data.h>
#include <recede/render/detail/flush_denormals.h>
#include <recede/render/renderer.h>

#include <fmt/format.h>
#include <malloc.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace recede::bench {
namespace {

constexpr unsigned k_seconds_allowed = 1200;
constexpr int k_image_side = 1024;
/// Scenes are scaled to a longest side of 1 around the origin, and rays are theirs.
constexpr double k_radius = 0.5;

double thread_seconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// A picture of the ball, 4 x 4 pixels after 4 x 4 pixels.
std::vector<Ray> camera_rays() {
  std::vector<Ray> rays;
  for (int at = 0; at < k_image_side * k_image_side; ++at) {
    const int block = at / 16, x = block % (k_image_side / 4) * 4 + at % 4,
              y = block / (k_image_side / 4) * 4 + at / 4 % 4;
    const auto across = [](int pixel) { return 0.74 * ((pixel + 0.5) / k_image_side - 0.5); };
    rays.push_back(
        {Vec3(0, 0, 3 * k_radius).cast<float>(), Vec3(across(x), across(y), -1).normalized().cast<float>()});
  }
  return rays;
}

/// From around the ball to points within it.
std::vector<Ray> incoherent_rays() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Ray> rays;
  for (int k = 0; k < k_image_side * k_image_side; ++k) {
    const Vec3 from = 1.3 * k_radius * random_direction(random);
    const Vec3 to = 0.95 * k_radius * std::cbrt(share(random)) * random_direction(random);
    rays.push_back({from.cast<float>(), (to - from).normalized().cast<float>()});
  }
  return rays;
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

double median_rate(std::size_t runs, const std::function<double()>& rate) {
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
  Figures figures;
  figures.small = small_triangles(surface, level);
  const RTCDevice device = rtcNewDevice(nullptr);
  warm_up();
  system.build(device, rough_sphere(1, Vec3::Zero(), 1), 1);
  malloc_trim(0);
  // The map is there already. Scenes keep it or let go of it: either way it isn't what stood before.
  const std::size_t before = resident_bytes() - surface.map.bytes();
  const DisplacedScene scene = system.build(device, std::move(surface), level);
  malloc_trim(0);
  figures.build_seconds = scene.build_seconds;
  // Small ones can fit into what was freed before.
  const std::size_t kept = std::max(resident_bytes(), before) - before;
  figures.bytes = static_cast<double>(kept) / static_cast<double>(figures.small);
  const std::vector<Ray> camera = camera_rays(), any = incoherent_rays();
  const auto count =
      static_cast<std::size_t>(1e-3 * system.rays_of_thousand * static_cast<double>(camera.size()));
  const bool is_slow = system.rays_of_thousand < 1000;
  if (!is_slow) figures.packets = median_rate(repeats, [&] { return packet_rate(scene.scene, camera); });
  figures.camera = median_rate(repeats, [&] { return single_rate(scene.scene, camera, count, true); });
  figures.incoherent = median_rate(repeats, [&] { return single_rate(scene.scene, any, count, false); });
  return figures;
}

std::string cell(const ChildAnswer& answer, const std::function<std::string(const Figures&)>& text) {
  if (!answer.succeeded) return answer.failure;
  ByteReader reader(answer.bytes);
  return text(reader.take<Figures>());
}

ChildAnswer measure_in_child(const DisplacedSystem& system, const std::function<DisplacedSurface()>& make,
                             int level, std::size_t repeats) {
  return run_in_child([&] { return as_bytes(measure_scene(system, make(), level, repeats)); },
                      k_seconds_allowed);
}

/// What `work` says in a process of its own, or why it says nothing.
std::string text_in_child(const std::function<std::string()>& work) {
  const ChildAnswer answer = run_in_child([&] { return as_bytes(work()); }, k_seconds_allowed);
  return answer.succeeded ? ByteReader(answer.bytes).take_text() : answer.failure + "\n\n";
}

/// Nothing where packets weren't traced.
std::string packets_text(const Figures& f) { return f.packets > 0 ? fmt::format("{:.3g}", f.packets) : ""; }

std::string rates_text(const Figures& f) {
  return fmt::format("{:.2f} | {:.3g} | {} | {:.3g} | {:.3g}", f.build_seconds, f.bytes, packets_text(f),
                     f.camera, f.incoherent);
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

/// RMS distance of the small triangles of levels 1, 2, ... from those of the last one, as shares of the
/// diagonal.
std::vector<double> level_errors(int last) {
  const ChildAnswer answer = run_in_child(
      [&] {
        const DisplacedSurface surface = fractal_sphere();
        const auto at_level = [&](int level) {
          DisplacedMeshOptions levels;
          levels.level = level;
          return DisplacedMesh(surface.base, surface.map, levels).tessellate();
        };
        const DistanceMeter finest(at_level(last));
        std::vector<double> errors;
        for (int level = 1; level < last; ++level) {
          const MeshDistance distance = finest.to(at_level(level));
          errors.push_back(distance.rms / distance.diagonal);
        }
        return as_bytes(errors);
      },
      k_seconds_allowed);
  if (!answer.succeeded) throw Error("errors of levels: " + answer.failure);
  std::vector<double> errors;
  ByteReader(answer.bytes).take(errors);
  return errors;
}

void add_levels(const BenchOptions& options, BenchSection& section) {
  Plot memory = log_plot("Fractal sphere: memory", "small triangles", "bytes of a small triangle"),
       camera = log_plot("Rays of a camera, one by one", "small triangles", "microseconds of a ray"),
       incoherent = log_plot("Incoherent rays", "small triangles", "microseconds of a ray"),
       error = log_plot("Fractal sphere: error over memory", "megabytes, with the map where it is kept",
                        "RMS to the finest level, of the diagonal");
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
  if (systems.empty()) return;
  const std::vector<double> errors = level_errors(options.quick ? 5 : 6);
  const int most = options.quick ? 5 : 8;
  for (int level = 1; level <= most; ++level) {
    text += fmt::format("| {} |", level);
    for (const DisplacedSystem& system : systems) {
      if ((std::size_t{3072} << (2 * level)) > system.most_small) {
        text += "  |";
        continue;
      }
      const ChildAnswer answer = measure_in_child(system, fractal_sphere, level, options.repeats);
      text += fmt::format(" {} |", cell(answer, [&](const Figures& f) {
                            const auto small = static_cast<double>(f.small);
                            add_point(memory, system.name, small, f.bytes);
                            add_point(camera, system.name, small, 1 / f.camera);
                            add_point(incoherent, system.name, small, 1 / f.incoherent);
                            if (const auto at = static_cast<std::size_t>(level - 1); at < errors.size())
                              add_point(error, system.name, 1e-6 * f.bytes * small, errors[at]);
                            return fmt::format("{:.3g} ; {} ; {:.3g} ; {:.3g}", f.bytes, packets_text(f),
                                               f.camera, f.incoherent);
                          }));
    }
    text += "\n";
  }
  section.markdown += text + "\n";
  section.curves = {memory, camera, incoherent, error};
}

/// What a map of 4096 x 4096 texels on a million triangles costs, as a surface alone and as a scene of the
/// renderer, which also keeps what shading needs of the base.
std::string memory_lines(const BenchOptions& options) {
  std::string text = text_in_child([&] {
    warm_up();
    DisplacedSurface surface = tiled_sphere();
    std::vector<Index> faces;
    triangulate(surface.base, &faces, nullptr);
    const std::size_t triangles = faces.size(), map = surface.map.bytes();
    const std::vector<Ray> rays = camera_rays();
    malloc_trim(0);
    const std::size_t before = resident_bytes();
    DisplacedMeshOptions levels;
    levels.level = surface.level;
    const DisplacedMesh mesh(surface.base, std::move(surface.map), levels);
    const double rate =
        single_rate(mesh.data().scene.get(), rays, options.quick ? rays.size() / 16 : rays.size(), true);
    malloc_trim(0);
    const DisplacedMesh::Memory memory = mesh.memory();
    return fmt::format(
        "A map of 4096 x 4096 texels on {} base triangles, {:.2g} small triangles: {:.1f} MB above the map "
        "of {:.1f} "
        "MB, {:.1f} of them the base in our form and {:.1f} the pyramid; {:.2f} million camera rays a "
        "second\n\n",
        triangles, static_cast<double>(mesh.small_triangles()),
        1e-6 * static_cast<double>(resident_bytes() - before), 1e-6 * static_cast<double>(map),
        1e-6 * static_cast<double>(memory.base), 1e-6 * static_cast<double>(memory.pyramid), rate);
  });
  text += text_in_child([] {
    warm_up();
    const DisplacedSurface surface = tiled_sphere();
    malloc_trim(0);
    const std::size_t before = resident_bytes();
    DisplacedMeshOptions levels;
    levels.level = surface.level;
    const Scene scene(surface.base, surface.map, levels);
    Camera camera;
    camera.width = camera.height = 256;
    RenderOptions rendering;
    rendering.samples_per_pixel = 1;
    render(scene, camera, rendering);
    malloc_trim(0);
    return fmt::format("The same in a scene of the renderer, with a copy of the map: {:.1f} MB\n\n",
                       1e-6 * static_cast<double>(resident_bytes() - before));
  });
  return text;
}

std::string edit_line() {
  return text_in_child([] {
    const DisplacedSurface surface = fractal_sphere();
    DisplacedMeshOptions options;
    options.level = surface.level;
    DisplacedMesh mesh(surface.base, surface.map, options);
    std::vector<double> milliseconds;
    for (int k = 0; k < 9; ++k) {
      DisplacementMap copy = surface.map;
      const WorkTimer timer;
      mesh.set_map(std::move(copy));
      milliseconds.push_back(1e3 * timer.wall());
    }
    return fmt::format("Another map on the fractal sphere: {:.1f} ms\n\n", median(milliseconds));
  });
}

/// Processor seconds of a picture.
double picture_seconds(const Scene& scene, const Camera& camera, std::size_t repeats) {
  RenderOptions options;
  options.samples_per_pixel = 4;
  return median_seconds(repeats, [&] { render(scene, camera, options); });
}

/// Pictures of the bunny: over their size, over the base, and with another level for every one.
std::string pictures_table(const BenchOptions& options) {
  return text_in_child([&] {
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
    return text;
  });
}

}  // namespace

BenchSection measure_displaced(const BenchOptions& options) {
  // The checks start threads, after which this process may not fork: they come last.
  BenchSection section;
  section.markdown = systems_table("Fractal sphere", fractal_sphere, options.quick ? 5 : 6, options);
  section.markdown += systems_table(
      "Bunny with a map", [&] { return mapped_bunny(options.data); }, options.quick ? 4 : 5, options);
  add_levels(options, section);
  section.markdown +=
      pictures_table(options) + memory_lines(options) + edit_line() + displaced_checks(options);
  return section;
}

}  // namespace recede::bench
