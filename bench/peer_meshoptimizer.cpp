#include "systems.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <limits>

namespace recede::bench {
namespace {

PolygonSoup to_soup(const std::vector<Vec3>& positions, const std::vector<unsigned>& indices) {
  PolygonSoup soup;
  soup.positions = positions;
  soup.corner_vertices = indices;
  for (std::size_t corner = 3; corner <= indices.size(); corner += 3) {
    soup.face_offsets.push_back(static_cast<Index>(corner));
  }
  remove_unreferenced_vertices(soup);
  return soup;
}

Outcome run(const PolygonSoup& soup, const SimplifyTarget& target) {
  Outcome outcome;
  const WorkTimer setup;
  std::vector<float> positions;
  positions.reserve(3 * soup.positions.size());
  for (const Vec3& p : soup.positions) {
    for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(p[axis]));
  }
  // Its result may need as much room as its input, whatever the target.
  std::vector<unsigned> result(soup.corner_vertices.size());
  outcome.setup_seconds = setup.wall();
  const std::size_t stride = 3 * sizeof(float);
  // Only the count is to stop it.
  const float any_error = std::numeric_limits<float>::max();
  float error = 0;
  // It takes no target above what there is.
  const std::size_t target_indices = std::min(3 * target.faces.value(), soup.n_corners());
  const CallMeter meter;
  const std::size_t size = meshopt_simplify(
      result.data(), soup.corner_vertices.data(), soup.corner_vertices.size(), positions.data(),
      soup.positions.size(), stride, target_indices, any_error, 0u, &error);
  meter.stop(outcome);
  result.resize(size);
  outcome.reported_error =
      static_cast<double>(error * meshopt_simplifyScale(positions.data(), soup.positions.size(), stride));
  outcome.result = to_soup(soup.positions, result);
  return outcome;
}

}  // namespace

void add_meshoptimizer(std::vector<System>& systems) {
  const int version = MESHOPTIMIZER_VERSION;  // major * 1000 + minor * 10
  systems.push_back({.name = fmt::format("meshoptimizer {}.{}", version / 1000, version % 1000 / 10),
                     .label = "meshoptimizer",
                     .in_growth = true,
                     .run = run});
}

}  // namespace recede::bench
