// Parts of the section about volume textures, and what they share.
#pragma once

#include "section_run.h"
#include <recede/render/scene.h>

#include <vector>

namespace recede::bench {

/// Pictures of the same textures by slices and by rays.
void measure_volume_slices(const BenchOptions& options, BenchSection& section);
/// The same for chain mail around a body, and for a texture of 512^3 texels, or fewer with `options.quick`.
void measure_chain_mail_slices(const BenchOptions& options, BenchSection& section);
void measure_large_volume(const BenchOptions& options, BenchSection& section);
/// Memory of textures, and of making their smaller versions.
void measure_volume_storage(BenchSection& section);
/// What is seen from afar, by kinds of levels.
void measure_receding_sheets(BenchSection& section);
/// The same over time.
void measure_flicker(BenchSection& section);
void measure_volume_brightness(BenchSection& section);
void measure_tubes(BenchSection& section);

/// Of sides 2 around the origin, z up, a quad, with texture coordinates from 0 to 1.
PolygonSoup flat_square();

/// A texture in a layer along the normals, drawn from its finest level.
PlacedVolume place_volume(const PolygonSoup& base, std::shared_ptr<const VolumeMipmap> texture,
                          double thickness, const Vec2& repeat);

/// What a ray through a pixel meets.
struct SeenVolume {
  bool is_hit = false;
  double depth = 0;            ///< along the view's forward axis
  Vec3 normal = Vec3::Zero();  ///< of transparent matter the mean, not unit
};

/// Of `samples` x `samples` rays through each pixel, one in each part of it, one after the other.
std::vector<SeenVolume> trace_volumes(const Scene& scene, const Camera& camera, int samples = 1);

}  // namespace recede::bench
