// The models that billboards are measured on, and how they are looked at.
#pragma once

#include "bench_run.h"
#include <recede/lod/billboard_texture.h>
#include <recede/render/camera.h>
#include <recede/render/scene.h>

#include <memory>
#include <string>
#include <vector>

namespace recede::bench {

struct BillboardModel {
  std::string name;
  bool is_two_sided = false;  ///< leaves
  PolygonSoup soup{};
  Box3 box{};

  double size() const { return box.sizes().maxCoeff(); }  ///< its longest side
  double diagonal() const { return box.sizes().norm(); }
};

/// A head, a tree, a man and a CAD part, as far as `options.models` finds them. Throws `InputError` when a
/// file is missing.
std::vector<BillboardModel> billboard_models(const BenchOptions& options);
BillboardModel billboard_model(const BenchOptions& options, const std::string& name);

/// Loose rectangles in a ball, turned anyhow, with the area of the ball's surface.
PolygonSoup loose_leaves(std::size_t n);

/// A cloud with an error that is a share of the longest side, by one of the library's constructions.
BillboardCloud cloud_of(const BillboardModel& model, BillboardMethod method, double share);

/// Clusters and planes with one, two and four texels per error.
struct TexturedCloud {
  std::string construction;
  double texels_per_error = 1;
  BillboardTextures textures;
};

std::vector<TexturedCloud> textured_clouds(const BillboardModel& model, double share);

/// Two-sided: the model's faces within the error are drawn wherever they are on a rectangle.
BillboardTextures hough_textures(const BillboardModel& model, const BillboardCloud& cloud,
                                 double texels_per_error);

/// As viewers of glTF draw it: every height 0.
BillboardTextures flattened(BillboardTextures textures);

Scene scene_of(const BillboardTextures& textures);

/// From far away: a pixel is `pixel` long at the model's middle, and the picture holds all of it.
Camera camera_at_pixel(const BillboardModel& model, const Vec3& direction, double pixel);

}  // namespace recede::bench
