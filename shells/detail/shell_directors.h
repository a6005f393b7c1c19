// The lines along which a shell grows.
#pragma once

#include <recede/shells/shell.h>

#include <span>
#include <vector>

namespace recede::detail {

/// A surface as shells see it.
struct ShellSurface {
  std::span<const Vec3> positions;
  std::span<const Index> triangles;  ///< three vertices each
  /// Unit, of each vertex: in front of all its triangles if a direction is, else their mean. Zero without
  /// triangles.
  std::vector<Vec3> normals;
};

ShellSurface shell_surface_of(std::span<const Vec3> positions, std::span<const Index> triangles);

/// The surface, and beyond its open borders a strip as wide as `reaches` says at each vertex.
PolygonSoup with_extended_borders(const ShellSurface& surface, std::span<const double> reaches);

/// Where directors of some vertices end.
struct TracedDirectors {
  std::vector<Vec3> ends;  ///< of each of the vertices
  std::size_t evaluations = 0;
};

/// `side` is 1 in front of the surface and -1 behind it; `thicknesses` are those of all vertices.
TracedDirectors trace_directors(const ShellSurface& surface, std::span<const Index> vertices,
                                std::span<const double> thicknesses, double side, const ShellOptions& options,
                                Progress* progress);

}  // namespace recede::detail
