// Scenes of Embree that hold one displaced surface, each system's way.
#pragma once

#include "displaced_surfaces.h"
#include <recede/render/displaced_mesh.h>

#include <embree3/rtcore.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace recede::bench {

/// A scene and what must live as long. Rays are those of the surface's frame; they bring a
/// `detail::RayContext`.
struct DisplacedScene {
  RTCScene scene = nullptr;
  std::shared_ptr<void> kept{};
  double build_seconds = 0;  ///< processor time from base and map, without making them
};

struct DisplacedSystem {
  std::string name;
  /// Takes the surface at a level of subdivision.
  std::function<DisplacedScene(RTCDevice, DisplacedSurface&&, int level)> build;
  /// About how many rays it traces while Embree's triangles are asked for a thousand.
  double rays_of_thousand = 1000;
  std::size_t most_small = std::size_t{1} << 26;  ///< triangles that fit into memory
};

/// Ours first, then Embree's triangles, triangles with its compact flag, grids, subdivision surfaces with a
/// displacement function, and the recursion over all small triangles.
std::vector<DisplacedSystem> displaced_systems();

/// Every small triangle as one user primitive tested like in our own search: brute force that Embree finds
/// the candidates for. `numbers` gets the number that `DisplacedMesh::Hit::small` has for each.
DisplacedScene one_by_one(RTCDevice device, const DisplacedMesh& mesh, std::vector<std::uint64_t>& numbers);

}  // namespace recede::bench
