// What local PCA costs: compressing texels by view and light, and looking one up.
#include <recede/render/direction_grid.h>
#include <recede/render/local_pca.h>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <span>
#include <utility>
#include <vector>

namespace {

using namespace recede;

constexpr std::size_t k_views = 49, k_lights = 98, k_colours = 3;
constexpr std::size_t k_dimension = k_views * k_lights * k_colours + k_views;
const DirectionGrid k_view_grid{.side = 7}, k_light_grid{.side = 7, .whole_sphere = true};

/// A leaf of a texel: its colour and gloss, and the half-spaces that it is seen from and lit from.
struct Leaf {
  Vec3 normal, gap_to_view, gap_to_light;
  double view_gap, light_gap, gloss;
  std::array<double, k_colours> albedo;

  double seen_from(const Vec3& view) const {
    const double cosine = std::max(0.0, normal.dot(view));
    return cosine / (0.3 + cosine) * (gap_to_view.dot(view) > view_gap ? 1 : 0.2);
  }
};

Leaf random_leaf(std::mt19937& random) {
  std::normal_distribution<double> normal(0, 1);
  std::uniform_real_distribution<double> number(0, 1);
  const auto direction = [&](double up) {
    const double x = normal(random), y = normal(random);
    return Vec3(x, y, normal(random) + up).normalized();
  };
  Leaf leaf;
  leaf.normal = direction(1.5);
  leaf.gap_to_view = direction(0);
  leaf.gap_to_light = direction(0);
  leaf.normal.z() = std::abs(leaf.normal.z());
  leaf.view_gap = 1.2 * number(random) - 0.6;
  leaf.light_gap = 1.2 * number(random) - 0.6;
  leaf.gloss = 20 + 20 * number(random);
  leaf.albedo = {0.1 + 0.3 * number(random), 0.3 + 0.4 * number(random), 0.05 + 0.1 * number(random)};
  return leaf;
}

/// One to three leaves, by view, light and colour, and then how much of the texel each view sees covered.
void shade_texel(std::size_t texel, float* values) {
  std::mt19937 random(static_cast<unsigned>(texel));
  const int leaves = 1 + static_cast<int>(random() % 3);
  for (int i = 0; i < leaves; ++i) {
    const Leaf leaf = random_leaf(random);
    for (std::size_t v = 0; v < k_views; ++v) {
      const Vec3 view = k_view_grid.direction(v);
      const double seen = leaf.seen_from(view) / leaves;
      values[k_views * k_lights * k_colours + v] += static_cast<float>(seen);
      for (std::size_t l = 0; l < k_lights; ++l) {
        const Vec3 light = k_light_grid.direction(l);
        const double lit =
            seen * leaf.normal.dot(light) * (leaf.gap_to_light.dot(light) > leaf.light_gap ? 1 : 0.05);
        if (lit <= 0) continue;
        const double gloss =
            0.2 * std::pow(std::max(0.0, leaf.normal.dot((view + light).normalized())), leaf.gloss);
        for (std::size_t c = 0; c < k_colours; ++c)
          values[(v * k_lights + l) * k_colours + c] += static_cast<float>(lit * (leaf.albedo[c] + gloss));
      }
    }
  }
}

/// 58 kB each: 1.2 GB for 20 000.
VectorSource leaf_texels(std::size_t count) {
  static std::vector<float> values;
  const std::size_t before = values.size() / k_dimension;
  values.resize(std::max(before, count) * k_dimension);
  for (std::size_t texel = before; texel < count; ++texel)
    shade_texel(texel, values.data() + texel * k_dimension);
  return vectors_in(std::span(values).first(count * k_dimension), k_dimension);
}

void compress_texels(benchmark::State& state, std::size_t count, int clusters, int components) {
  const VectorSource texels = leaf_texels(count);
  LocalPca pca;
  for (auto _ : state) pca = make_local_pca(texels, {.clusters = clusters, .components = components});
  const LocalPcaError error = measure_error(pca, texels);
  state.counters["RMS %"] = 100 * error.rms;
  state.counters["worst %"] = 100 * error.worst_rms;
  state.counters["MB"] = static_cast<double>(bytes(pca)) / 1e6;
}

const LocalPca& compressed_texels() {
  static const LocalPca pca = make_local_pca(leaf_texels(2000), {.clusters = 64, .components = 8});
  return pca;
}

std::vector<Vec3> random_directions(std::size_t count) {
  std::mt19937 random(3);
  std::normal_distribution<double> number(0, 1);
  std::vector<Vec3> directions(count);
  for (Vec3& direction : directions)
    direction = Vec3(number(random), number(random), number(random)).normalized();
  return directions;
}

constexpr std::size_t k_lookups = 100'000;

/// Numbers in an order without plan.
void look_up_entry(benchmark::State& state) {
  const LocalPca& pca = compressed_texels();
  std::mt19937 random(4);
  std::vector<std::pair<std::size_t, std::size_t>> places(k_lookups);
  for (auto& [vector, index] : places) {
    vector = random() % pca.vector_count();
    index = random() % pca.dimension;
  }
  float sum = 0;
  for (auto _ : state) {
    for (const auto& [vector, index] : places) sum += entry(pca, vector, index);
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_lookups));
}

/// The colour of a texel between four views and four lights.
void shade_by_local_pca(benchmark::State& state) {
  const LocalPca& pca = compressed_texels();
  const std::vector<Vec3> directions = random_directions(k_lookups + 1);
  float sum = 0;
  for (auto _ : state) {
    for (std::size_t i = 0; i < k_lookups; ++i) {
      const NodeMix views = k_view_grid.mix(directions[i]), lights = k_light_grid.mix(directions[i + 1]);
      for (std::size_t v = 0; v < 4; ++v) {
        for (std::size_t l = 0; l < 4; ++l) {
          const std::size_t node =
              static_cast<std::size_t>(views.nodes[v]) * k_lights + static_cast<std::size_t>(lights.nodes[l]);
          std::array<float, k_colours> colour{};
          reconstruct(pca, i % pca.vector_count(), colour, node * k_colours);
          sum +=
              static_cast<float>(views.weights[v] * lights.weights[l]) * (colour[0] + colour[1] + colour[2]);
        }
      }
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_lookups));
}

void mix_directions(benchmark::State& state) {
  const std::vector<Vec3> directions = random_directions(k_lookups);
  double sum = 0;
  for (auto _ : state) {
    for (const Vec3& direction : directions) sum += k_light_grid.mix(direction).weights[0];
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(k_lookups));
}

BENCHMARK_CAPTURE(compress_texels, 2000_to_64x8, 2000, 64, 8)->Unit(benchmark::kSecond)->UseRealTime();
BENCHMARK_CAPTURE(compress_texels, 20000_to_16x8, 20000, 16, 8)->Unit(benchmark::kSecond)->UseRealTime();
BENCHMARK_CAPTURE(compress_texels, 20000_to_64x4, 20000, 64, 4)->Unit(benchmark::kSecond)->UseRealTime();
BENCHMARK_CAPTURE(compress_texels, 20000_to_64x8, 20000, 64, 8)->Unit(benchmark::kSecond)->UseRealTime();
BENCHMARK(look_up_entry)->Unit(benchmark::kMillisecond);
BENCHMARK(shade_by_local_pca)->Unit(benchmark::kMillisecond);
BENCHMARK(mix_directions)->Unit(benchmark::kMillisecond);

}  // namespace
