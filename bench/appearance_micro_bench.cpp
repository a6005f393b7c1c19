// What agreeing appearances cost: their tables, and lookups in them beside plain bump mapping.
#include <recede/render/diffuse_scattering.h>
#include <recede/render/filtered_reflectance.h>
#include <recede/render/open_ellipses.h>
#include <recede/render/redistributed_bump.h>
#include <recede/render/reflectance_table.h>
#include <recede/render/scattering_table.h>

#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <random>

namespace {

using namespace recede;

constexpr double k_pi = std::numbers::pi;

/// Waves of up to four to a side, `size` x `size` heights, slopes of up to about 1.
const DisplacementMap& waves(int size) {
  const auto make = [](int texels) {
    std::mt19937 random(1);
    std::uniform_int_distribution<int> frequency(-4, 4);
    std::uniform_real_distribution<double> phase(0, 2 * k_pi);
    std::vector<double> sums(static_cast<std::size_t>(texels) * static_cast<std::size_t>(texels), 0.0);
    for (int wave = 0; wave < 40; ++wave) {
      const int u = frequency(random), v = frequency(random);
      const double start = phase(random);
      for (std::size_t i = 0; i < sums.size(); ++i) {
        const auto side = static_cast<std::size_t>(texels);
        const double x = static_cast<double>(i % side) / texels, y = static_cast<double>(i / side) / texels;
        sums[i] += 0.004 * std::cos(2 * k_pi * (u * x + v * y) + start);
      }
    }
    return DisplacementMap(texels, texels, std::vector<float>(sums.begin(), sums.end()), MapBorder::periodic);
  };
  static const DisplacementMap small = make(32), middle = make(128), large = make(512);
  return size == 32 ? small : size == 128 ? middle : large;
}

const VisibleNormals& normals_of_waves() {
  static const VisibleNormals normals = sample_visible_normals(DisplacedPlane(waves(32), {1, 1}));
  return normals;
}

/// The default: 31 x 31 bins, 31 angles, 131 072 rays each.
void sample_normals(benchmark::State& state, int size) {
  const DisplacedPlane plane(waves(size), {1, 1});
  for (auto _ : state) benchmark::DoNotOptimize(sample_visible_normals(plane));
  const VisibleNormalsOptions options;
  state.SetItemsProcessed(state.iterations() * (options.views + 1) * options.samples);
}

void make_table(benchmark::State& state) {
  const VisibleNormals& normals = normals_of_waves();
  for (auto _ : state) benchmark::DoNotOptimize(make_reflectance_table(normals));
}

/// Its cumulated shares and its grids.
void make_redistribution(benchmark::State& state) {
  const VisibleNormals& normals = normals_of_waves();
  for (auto _ : state) benchmark::DoNotOptimize(RedistributedBump(normals));
}

void make_facet_levels(benchmark::State& state, int size) {
  for (auto _ : state) benchmark::DoNotOptimize(FacetLevels(waves(size)));
}

/// Places of a map with directions to viewers and lights, in an order without plan.
struct Lookup {
  Vec2 uv;
  Vec3 toward_viewer, toward_light;
};
std::vector<Lookup> random_lookups() {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(0, 1);
  const auto direction = [&] {
    const double height = number(random), azimuth = 2 * k_pi * number(random);
    const double level = std::sqrt(1 - height * height);
    return Vec3(level * std::cos(azimuth), level * std::sin(azimuth), height);
  };
  std::vector<Lookup> lookups;
  for (int i = 0; i < 100'000; ++i)
    lookups.push_back({Vec2(number(random), number(random)), direction(), direction()});
  return lookups;
}

template <class Value>
void look_up(benchmark::State& state, const Value& value) {
  const std::vector<Lookup> lookups = random_lookups();
  double sum = 0;
  for (auto _ : state) {
    for (const Lookup& lookup : lookups) sum += value(lookup);
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(lookups.size()));
}

void shade_plain_bump(benchmark::State& state, int size) {
  const DisplacedPlane plane(waves(size), {1, 1});
  look_up(state, [&](const Lookup& at) { return plane.normal_at(at.uv).dot(at.toward_light); });
}

void shade_redistributed_bump(benchmark::State& state, int size) {
  const DisplacedPlane plane(waves(size), {1, 1});
  const RedistributedBump bump(normals_of_waves());
  look_up(state, [&](const Lookup& at) {
    return bump.normal_for_view(plane.normal_at(at.uv), at.toward_viewer).dot(at.toward_light);
  });
}

void shade_partly_displaced(benchmark::State& state) {
  const DisplacedPlane plane(waves(32), {1, 1});
  const RedistributedBump bump(normals_of_waves());
  look_up(state, [&](const Lookup& at) {
    return bump.normal_for_view(plane.normal_at(at.uv), at.toward_viewer, 0.5).dot(at.toward_light);
  });
}

void shade_by_table(benchmark::State& state) {
  const ReflectanceTable table = make_reflectance_table(normals_of_waves());
  look_up(state, [&](const Lookup& at) { return table.value(at.toward_viewer, at.toward_light); });
}

void shade_by_facets(benchmark::State& state) {
  const FacetDistribution facets = PackedFacets(facets_of(waves(32))).unpacked();
  look_up(state, [&](const Lookup& at) {
    return filtered_reflectance(facets, at.toward_viewer, at.toward_light) * at.toward_light.z();
  });
}

void draw_by_table(benchmark::State& state) {
  const ReflectanceSampler sampler(make_reflectance_table(normals_of_waves()));
  look_up(state, [&](const Lookup& at) { return sampler.sample(at.toward_viewer, at.uv).density; });
}

/// What a pixel costs that is displaced: one ray to the surface.
void shade_displaced(benchmark::State& state, int size) {
  const DisplacedPlane plane(waves(size), {1, 1});
  look_up(state, [&](const Lookup& at) {
    const auto hit = plane.first_hit(Vec3(at.uv.x(), at.uv.y(), 1), -at.toward_viewer);
    return hit ? hit->normal.dot(at.toward_light) : 0.0;
  });
}

/// Scatter textures of 100 directions, as the source has them.
HeightFieldVisibility visibility_of_waves(int size) {
  return compute_visibility(DisplacedPlane(waves(size), {1, 1}), {.directions = 100});
}

void see_places(benchmark::State& state, int size) {
  for (auto _ : state) benchmark::DoNotOptimize(visibility_of_waves(size));
  state.SetItemsProcessed(state.iterations() * size * size * 100);
}

void fit_ellipses(benchmark::State& state, int size) {
  const HeightFieldVisibility visibility = visibility_of_waves(size);
  for (auto _ : state) benchmark::DoNotOptimize(fit_open_ellipses(visibility));
  state.SetItemsProcessed(state.iterations() * size * size);
}

/// Light from all places to all others once.
void pass_light(benchmark::State& state, int size) {
  const DiffuseTransport transport(visibility_of_waves(size));
  const std::vector<double> light(transport.place_count(), 1.0);
  std::vector<double> next(light.size());
  for (auto _ : state) {
    transport.gather(light, 1, next);
    benchmark::DoNotOptimize(next.data());
  }
}

/// The default: 32 x 31 x 64 pairs of directions, four orders, 64 x 64 places at most.
void make_scattering(benchmark::State& state, int size) {
  const DisplacedPlane plane(waves(size), {1, 1});
  for (auto _ : state) benchmark::DoNotOptimize(make_scattering_table(plane));
}

void shade_shadowed_bump(benchmark::State& state, int size) {
  const DisplacedPlane plane(waves(size), {1, 1});
  const OpenEllipses ellipses = fit_open_ellipses(visibility_of_waves(size));
  look_up(state, [&](const Lookup& at) {
    return plane.normal_at(at.uv).dot(at.toward_light) * ellipses.openness_at(at.uv, at.toward_light);
  });
}

void shade_by_scattering_table(benchmark::State& state) {
  const DisplacedPlane plane(waves(32), {1, 1});
  const ScatteringTable table = make_scattering_table(plane);
  const Rgb albedo(0.8F, 0.5F, 0.3F);
  look_up(state, [&](const Lookup& at) {
    return static_cast<double>(table.value(albedo, at.toward_viewer, at.toward_light).x());
  });
}

BENCHMARK_CAPTURE(see_places, 32, 32)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(see_places, 128, 128)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(fit_ellipses, 32, 32)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(fit_ellipses, 128, 128)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(pass_light, 32, 32)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(pass_light, 128, 128)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(make_scattering, 32, 32)->Unit(benchmark::kSecond)->UseRealTime();
BENCHMARK_CAPTURE(make_scattering, 512, 512)->Unit(benchmark::kSecond)->UseRealTime();
BENCHMARK_CAPTURE(shade_shadowed_bump, 32, 32)->Unit(benchmark::kMillisecond);
BENCHMARK(shade_by_scattering_table)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(sample_normals, 32, 32)->Unit(benchmark::kSecond)->UseRealTime();
BENCHMARK_CAPTURE(sample_normals, 512, 512)->Unit(benchmark::kSecond)->UseRealTime();
BENCHMARK(make_table)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(make_redistribution)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(make_facet_levels, 32, 32)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(make_facet_levels, 512, 512)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(shade_plain_bump, 32, 32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shade_plain_bump, 512, 512)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shade_redistributed_bump, 32, 32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shade_redistributed_bump, 512, 512)->Unit(benchmark::kMillisecond);
BENCHMARK(shade_partly_displaced)->Unit(benchmark::kMillisecond);
BENCHMARK(shade_by_table)->Unit(benchmark::kMillisecond);
BENCHMARK(shade_by_facets)->Unit(benchmark::kMillisecond);
BENCHMARK(draw_by_table)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shade_displaced, 32, 32)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(shade_displaced, 512, 512)->Unit(benchmark::kMillisecond);

}  // namespace
