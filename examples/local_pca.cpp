// local_pca: waves by view and light, a vector of 2401 numbers for each texel, as means and directions of few
// clusters, and a number of one texel from them.
#include <recede/geometry/error.h>
#include <recede/render/direction_grid.h>
#include <recede/render/filtered_reflectance.h>
#include <recede/render/local_pca.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <vector>

namespace {

recede::DisplacementMap make_waves(int side) {
  std::vector<float> heights;
  for (int at = 0; at < side * side; ++at) {
    const double x = 2 * std::numbers::pi * (at % side) / side, y = 2 * std::numbers::pi * (at / side) / side;
    heights.push_back(static_cast<float>(0.03 * std::sin(x) * std::cos(2 * y)));
  }
  return {side, side, std::move(heights), recede::MapBorder::periodic};
}

/// For each view and light of a grid, what a texel of the waves sends of the light.
void shade(const recede::FacetDistribution& facets, const recede::DirectionGrid& grid,
           std::span<float> values) {
  const recede::FacetMaterial rough{.albedo = 0.4, .roughness = 0.5};
  for (std::size_t view = 0; view < grid.size(); ++view) {
    for (std::size_t light = 0; light < grid.size(); ++light) {
      const recede::Vec3 toward_light = grid.direction(light);
      const double value = recede::filtered_reflectance(facets, grid.direction(view), toward_light, rough);
      values[view * grid.size() + light] = static_cast<float>(value * toward_light.z());
    }
  }
}

}  // namespace

int main() try {
  constexpr int k_side = 32;
  const recede::FacetLevels levels(make_waves(k_side));
  const recede::DirectionGrid grid{.side = 7};
  const std::size_t dimension = grid.size() * grid.size();
  std::vector<float> values(k_side * k_side * dimension);
  for (std::size_t texel = 0; texel < k_side * k_side; ++texel) {
    const int x = static_cast<int>(texel) % k_side, y = static_cast<int>(texel) / k_side;
    shade(levels.texel(0, x, y).unpacked(), grid, std::span(values).subspan(texel * dimension, dimension));
  }

  const recede::VectorSource texels = recede::vectors_in(values, dimension);
  const recede::LocalPca pca = recede::make_local_pca(texels, {.clusters = 16, .components = 4});
  const recede::LocalPcaError error = recede::measure_error(pca, texels);
  std::cout << values.size() * 2 << " bytes of halves in " << recede::bytes(pca) << ", off by "
            << 100 * error.rms << " % of the range (RMS)\n";

  const recede::NodeMix views = grid.mix(recede::Vec3(0.3, 0, 1).normalized());
  const recede::NodeMix lights = grid.mix(recede::Vec3(-0.5, 0.2, 1).normalized());
  double value = 0;
  for (std::size_t v = 0; v < 4; ++v) {
    for (std::size_t l = 0; l < 4; ++l) {
      const int index = views.nodes[v] * static_cast<int>(grid.size()) + lights.nodes[l];
      value +=
          views.weights[v] * lights.weights[l] * recede::entry(pca, 100, static_cast<std::size_t>(index));
    }
  }
  std::cout << "a texel between views and lights: " << value << '\n';
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
