// bake_maps INPUT PICTURE.png: a fiftieth of the faces with maps of the rest, and a picture of the coarse
// mesh bare, with its normal map, displaced, and of the input.
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/displacement_bake.h>
#include <recede/lod/simplify.h>
#include <recede/render/renderer.h>

#include <array>
#include <iostream>

namespace {

using namespace recede;

Image picture_of(const PolygonSoup& surface, const PolygonSoup& input) {
  constexpr int k_size = 250;
  const Camera camera = frame_points(input.positions, {0.3, 0.35, 1}, Vec3::UnitY(), 0.4, k_size, 0.05);
  RenderOptions options;
  options.samples_per_pixel = 16;
  return render(Scene(surface), camera, options);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: bake_maps INPUT PICTURE.png\n";
    return 2;
  }
  recede::PolygonSoup fine = recede::read_soup(argv[1]);
  recede::merge_identical_vertices(fine);
  recede::SimplifyOptions coarser;
  coarser.target.ratio = 0.02;
  const recede::SimplifySoupResult coarse = recede::simplify(fine, coarser);

  recede::MapOptions options;
  options.size = 1024;
  options.search_distance = 2 * coarse.error_bound.value();
  const recede::BakedMaps maps = recede::bake_maps(fine, coarse.soup, options);
  const recede::MapAccuracy accuracy = recede::measure_maps(fine, maps);
  std::cout << coarse.faces_after << " faces, off by " << accuracy.bare_rms << " bare and " << accuracy.rms
            << " displaced (RMS); seams differ by " << maps.report.seam_difference << " at most\n";

  recede::PolygonSoup bare = coarse.soup;
  bare.corner_normals = maps.surface.corner_normals;
  const recede::PolygonSoup mapped = recede::dice_surface(maps, {.displace = false});
  const recede::PolygonSoup displaced = recede::dice_surface(maps);
  recede::write_png(argv[2],
                    recede::side_by_side(std::array{picture_of(bare, fine), picture_of(mapped, fine),
                                                    picture_of(displaced, fine), picture_of(fine, fine)}));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
