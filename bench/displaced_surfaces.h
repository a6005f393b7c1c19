// The displaced surfaces that ray tracing is measured on.
#pragma once

#include <recede/geometry/displacement_map.h>
#include <recede/geometry/polygon_soup.h>
#include <recede/lod/displacement_bake.h>

#include <filesystem>

namespace recede::bench {

struct DisplacedSurface {
  PolygonSoup base;
  DisplacementMap map;
  int level = 0;  ///< of subdivision, at which small triangles are about half a texel
};

/// A sphere of six charts of 16 x 16 quads, with fractal heights of up to 6 % of the radius: 64 x 64 texels a
/// quad, 12.6 million small triangles at level 6.
DisplacedSurface fractal_sphere();
/// The same charts of n x n quads at another place; random heights without any smoothness, that differ along
/// all seams. Small, for checks.
DisplacedSurface rough_sphere(int n, const Vec3& center, unsigned seed);
/// A million triangles with a map of 4096 x 4096 texels that repeats on each.
DisplacedSurface tiled_sphere();
/// The bunny at a share of its faces, with maps of 1024 x 1024 texels of the rest. Throws `InputError` when
/// its file isn't in the folder.
BakedMaps bunny_maps(const std::filesystem::path& data, double share);
/// The same at 2 % as a surface.
DisplacedSurface mapped_bunny(const std::filesystem::path& data);

}  // namespace recede::bench
