// Volume textures beside slices through them, and from afar.
#include "shell_volumes.h"

#include "shell_run.h"
#include <recede/geometry/detail/hashed_number.h>
#include <recede/render/detail/flush_denormals.h>
#include <recede/render/detail/tracing.h>

#include <tbb/parallel_for.h>

namespace recede::bench {

PolygonSoup flat_square() {
  PolygonSoup square;
  square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.add_face(std::array<Index, 4>{0, 1, 2, 3});
  square.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return square;
}

PlacedVolume place_volume(const PolygonSoup& base, std::shared_ptr<const VolumeMipmap> texture,
                          double thickness, const Vec2& repeat) {
  PlacedVolume volume;
  volume.textured.shell = std::make_shared<const Shell>(
      build_shell(base, {.thickness = thickness, .method = DirectorMethod::normals}));
  volume.textured.texture = std::move(texture);
  volume.textured.coordinates.repeat = repeat;
  return volume;
}

std::vector<SeenVolume> trace_volumes(const Scene& scene, const Camera& camera, int samples) {
  const CameraFrame frame = frame_of(camera);
  const detail::SceneData& data = scene.data();
  const Eigen::Vector3f eye = data.scaled(frame.position).cast<float>();
  const auto of_pixel = static_cast<std::size_t>(samples) * static_cast<std::size_t>(samples),
             width = static_cast<std::size_t>(camera.width);
  std::vector<SeenVolume> seen(width * static_cast<std::size_t>(camera.height) * of_pixel);
  tbb::parallel_for(0, camera.height, [&](int y) {
    const detail::FlushDenormals flush;
    std::size_t at = static_cast<std::size_t>(y) * width * of_pixel;
    for (int x = 0; x < camera.width; ++x) {
      for (int s = 0; s < samples * samples; ++s, ++at) {
        // Several are anywhere in their part of the pixel: even ones beat with periods.
        const double u = samples > 1 ? detail::hashed_number(at, 0) : 0.5,
                     v = samples > 1 ? detail::hashed_number(at, 1) : 0.5;
        const Vec3 direction =
            frame.direction(x + (s % samples + u) / samples, y + (s / samples + v) / samples);
        const detail::Ray ray{eye, direction.cast<float>()};
        detail::Hit hit;
        if (!detail::nearest_hit(data, ray, hit)) continue;
        const double distance = static_cast<double>(hit.distance) / data.scale;
        seen[at] = {true, distance * direction.dot(frame.forward), hit.front.cast<double>()};
      }
    }
  });
  return seen;
}

BenchSection measure_shell_volumes(const BenchOptions& options) {
  BenchSection section;
  section.markdown =
      "## Volume textures\n\nSlices are a rasteriser on the processor, in double precision: their seconds "
      "are "
      "no graphics hardware's. Seconds are those of the processor, of all threads together.\n";
  measure_volume_slices(options, section);
  measure_chain_mail_slices(options, section);
  measure_large_volume(options, section);
  measure_volume_storage(section);
  measure_receding_sheets(section);
  measure_flicker(section);
  measure_volume_brightness(section);
  measure_tubes(section);
  return section;
}

}  // namespace recede::bench
