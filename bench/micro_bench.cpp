// The parts that every command passes through: reading, building the half-edge mesh, nearest points,
// distances, rays.
#include <recede/geometry/bilinear_patch.h>
#include <recede/geometry/closest_point.h>
#include <recede/geometry/displacement_map.h>
#include <recede/geometry/height_field.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/sample_models.h>
#include <recede/geometry/subdivision_surface.h>

#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <random>

namespace {

using namespace recede;

const PolygonSoup& sphere_of_a_million() {
  static const PolygonSoup soup = make_displaced_sphere(1'000'000, true);
  return soup;
}

/// A file of the sphere that goes away with the object. It is read once more than measured, so that it comes
/// from the page cache.
class SphereFile {
 public:
  explicit SphereFile(const std::string& extension)
      : path_(std::filesystem::temp_directory_path() /
              ("recede_micro_bench_" + std::to_string(::getpid()) + extension)) {
    write_soup(path_, sphere_of_a_million());
  }
  ~SphereFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  SphereFile(const SphereFile&) = delete;
  SphereFile& operator=(const SphereFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void count_faces(benchmark::State& state, std::size_t faces) {
  state.counters["faces/s"] =
      benchmark::Counter(static_cast<double>(faces), benchmark::Counter::kIsIterationInvariantRate);
}

void read_file(benchmark::State& state, const std::string& extension) {
  const SphereFile file(extension);
  benchmark::DoNotOptimize(read_soup(file.path()));
  for (auto _ : state) benchmark::DoNotOptimize(read_soup(file.path()));
  count_faces(state, sphere_of_a_million().n_faces());
  state.SetBytesProcessed(state.iterations() *
                          static_cast<std::int64_t>(std::filesystem::file_size(file.path())));
}

void build_polygon_mesh(benchmark::State& state) {
  const PolygonSoup& soup = sphere_of_a_million();
  for (auto _ : state) benchmark::DoNotOptimize(to_polygon_mesh(soup));
  count_faces(state, soup.n_faces());
}

void build_closest_point_tree(benchmark::State& state) {
  const PolygonSoup& soup = sphere_of_a_million();
  const std::vector<Index> triangles = triangulate(soup);
  for (auto _ : state) benchmark::DoNotOptimize(ClosestPointTree(soup.positions, triangles));
  count_faces(state, soup.n_faces());
}

/// Points near the surface, a neighbour's triangle as the hint when `hinted`.
void find_closest_points(benchmark::State& state, bool hinted) {
  const PolygonSoup& soup = sphere_of_a_million();
  const ClosestPointTree tree(soup.positions, triangulate(soup));
  std::mt19937 random(1);
  std::uniform_int_distribution<std::size_t> any_vertex(0, soup.positions.size() - 1);
  std::uniform_real_distribution<double> scale(0.99, 1.01);
  std::vector<Vec3> points;
  std::size_t vertex = 0;
  for (int i = 0; i < 100'000; ++i) {
    vertex = hinted ? vertex + 1 : any_vertex(random);
    points.push_back(scale(random) * soup.positions[vertex % soup.positions.size()]);
  }
  for (auto _ : state) {
    Index hint = k_no_index;
    for (const Vec3& p : points) {
      const ClosestPointTree::Hit hit = tree.closest(p, hint);
      if (hinted) hint = hit.triangle;
      benchmark::DoNotOptimize(hit);
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points.size()));
}

/// The million-face sphere against a coarser one.
void measure_spheres(benchmark::State& state, bool with_bound) {
  const PolygonSoup coarse = make_displaced_sphere(100'000, true);
  DistanceOptions options;
  if (with_bound) options.bound_tolerance = 0.05;
  for (auto _ : state) benchmark::DoNotOptimize(measure_distance(sphere_of_a_million(), coarse, options));
}

/// Random patches and rays; one ray is traced against 64 patches, of which it hits about an eighth. `aimed`:
/// each ray is made for one patch, which it hits.
void intersect_bilinear_patches(benchmark::State& state, bool aimed) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  std::vector<BilinearPatch> patches;
  std::vector<PatchRay> rays;
  for (int i = 0; i < 4096; ++i) {
    patches.push_back({vector(), vector(), vector(), vector()});
    const Vec3 origin = 2 * vector();
    rays.emplace_back(origin, (aimed ? patches.back().point(0.3, 0.6) : vector()) - origin);
  }
  const std::size_t patches_of_a_ray = aimed ? 1 : 64;
  std::size_t hits = 0, tested = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      for (std::size_t k = 0; k < patches_of_a_ray; ++k, ++tested) {
        const auto hit = rays[i].nearest_hit(patches[(i + k) % patches.size()]);
        if (hit.has_value()) ++hits;
      }
    }
    benchmark::DoNotOptimize(hits);
  }
  state.counters["hit share"] = static_cast<double>(hits) / static_cast<double>(tested);
  state.SetItemsProcessed(static_cast<std::int64_t>(tested));
}

/// Smooth hills with noise on them: `size` x `size` texels of 16 bits.
DisplacementMap make_hills(int size) {
  Raster raster{size, size, 1, 16, false, {}};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(0, 1000);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double hill = std::sin(20.0 * x / size) * std::cos(15.0 * y / size);
      raster.samples.push_back(static_cast<std::uint16_t>(32000 + 30000 * hill + noise(random)));
    }
  }
  return DisplacementMap(std::move(raster), 0.1, 0);
}

void build_height_bounds(benchmark::State& state) {
  const DisplacementMap map = make_hills(4096);
  for (auto _ : state) benchmark::DoNotOptimize(HeightBounds(map));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(map.bytes()));
}

/// 2048 x 2048 cells of hills, seen from one point row by row, or by random rays between two points above.
void trace_height_field(benchmark::State& state, bool camera) {
  const DisplacementMap map = make_hills(2048);
  const HeightField field(map);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(0, 1);
  std::vector<std::pair<Vec3, Vec3>> rays;
  constexpr int k_side = 400;
  for (int y = 0; y < k_side; ++y) {
    for (int x = 0; x < k_side; ++x) {
      const Vec3 origin = camera ? Vec3(0.5, -0.6, 0.6) : Vec3(number(random), number(random), 0.15);
      const Vec3 target = camera ? Vec3((x + .5) / k_side, (y + .5) / k_side, 0.05)
                                 : Vec3(number(random), number(random), 0.1 * number(random));
      rays.emplace_back(origin, target - origin);
    }
  }
  std::size_t hits = 0;
  for (auto _ : state) {
    hits = 0;
    for (const auto& [origin, direction] : rays)
      if (field.first_hit(origin, direction).has_value()) ++hits;
  }
  state.counters["hit share"] = static_cast<double>(hits) / static_cast<double>(rays.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
}

/// The teapot's quads as a control mesh, with normals and the estimate of the error.
void subdivide_teapot(benchmark::State& state, SubdivisionScheme scheme) {
  const PolygonSoup control = to_soup(repair_to_polygon_mesh(make_teapot(10)).mesh);
  SubdivisionOptions options;
  options.scheme = scheme;
  options.level = 4;
  std::size_t points = 0;
  for (auto _ : state) points = subdivide(control, options).soup.positions.size();
  state.counters["limit points/s"] =
      benchmark::Counter(static_cast<double>(points), benchmark::Counter::kIsIterationInvariantRate);
}

BENCHMARK_CAPTURE(read_file, ply, std::string(".ply"))->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(read_file, obj, std::string(".obj"))->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(build_polygon_mesh)->Unit(benchmark::kMillisecond);
BENCHMARK(build_closest_point_tree)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find_closest_points, scattered, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(find_closest_points, neighbours_with_hint, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(measure_spheres, sampled, false)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(measure_spheres, sampled_and_bound, true)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(intersect_bilinear_patches, random, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(intersect_bilinear_patches, aimed, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(subdivide_teapot, catmull_clark, SubdivisionScheme::catmull_clark)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(subdivide_teapot, loop, SubdivisionScheme::loop)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(build_height_bounds)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(trace_height_field, camera, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(trace_height_field, scattered, false)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
