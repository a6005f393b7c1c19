#include <recede/render/progressive_render.h>

namespace recede {

Image render(const Scene& scene, const Camera& camera, const RenderOptions& options, Progress* progress) {
  ProgressiveRender picture(scene, camera, options);
  picture.add_samples(options.samples_per_pixel, progress);
  return picture.image();
}

}  // namespace recede
