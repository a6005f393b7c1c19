// What stands for a model from far away: triangles or billboards.
#pragma once

#include <recede/lod/billboard_cloud.h>
#include <recede/lod/billboard_texture.h>
#include <recede/lod/lod_hierarchy.h>

namespace recede {

struct FarLevelOptions {
  /// Of the clouds that are tried, as shares of the longest side of the model's box, increasing.
  std::vector<double> relative_errors{0.02, 0.04, 0.08};
  int views = 12;  ///< spread over all directions, in which pictures are compared
  /// Of clouds, more faces than these aren't merged, as that takes minutes.
  std::size_t most_faces = 400'000;
};

/// Both kinds of a level, at the distance where the cloud's error is what the view permits.
struct FarLevelTrial {
  double error = 0;  ///< of the cloud, object units
  BillboardMethod method = BillboardMethod::face_clustering;
  double distance = 0;  ///< from the model's sphere
  std::size_t billboards = 0, texels = 0, billboard_bytes = 0;
  std::size_t triangles = 0, triangle_bytes = 0;  ///< of the simplified model: no more bytes than the cloud
  /// Root mean square of differences from the model's pictures, over its pixels of all views; sRGB, 0 to 1. 0
  /// when there were no pictures.
  double billboard_difference = 0, triangle_difference = 0;
  bool takes_billboards = false;
  std::string reason{};
  std::optional<BillboardTextures> cloud{};  ///< if there is one
};

/// Bytes of a mesh in a renderer's memory: 28 a vertex (position, normal, colour; its copies where faces
/// don't share these) and 12 a triangle.
std::size_t mesh_bytes(const PolygonMesh& mesh);
/// Of textures, and of rectangles with positions, normals, tangents and texture coordinates.
std::size_t billboard_bytes(const BillboardTextures& textures);

/// For each error, which of both is nearer to the model's pictures with as many bytes. Clusters and planes
/// are tried, and that which differs most from triangles counts. Where a simplified model with fewer bytes
/// than texels for the model's area would take is off by less than half of the cloud's error, triangles
/// serve, and no cloud is built. Throws `OptionError` for errors that aren't above 0 and increasing, or
/// without views; `Cancelled`.
std::vector<FarLevelTrial> compare_far_levels(const LodHierarchy& hierarchy,
                                              const FarLevelOptions& options = {},
                                              Progress* progress = nullptr);

/// Appends the clouds that won. They replace levels of triangles that would serve from farther away, and the
/// trial's reason then says so. Returns the number of clouds.
std::size_t append_far_levels(LodHierarchy& hierarchy, std::vector<FarLevelTrial>& trials,
                              Progress* progress = nullptr);

}  // namespace recede
