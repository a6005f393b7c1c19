// compare_renderings PICTURE.png: the teapot, a level of it with a hundredth of the faces, and where one sees
// the difference.
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/simplify.h>
#include <recede/render/image_difference.h>
#include <recede/render/renderer.h>

#include <array>
#include <iostream>

namespace {

using namespace recede;

Image picture_of(const PolygonSoup& surface, const PolygonSoup& input) {
  constexpr int k_size = 300;
  RenderOptions options;
  options.samples_per_pixel = 16;
  return render(Scene(surface),
                frame_points(input.positions, {0.5, -1, 0.5}, Vec3::UnitZ(), 0.4, k_size, 0.02), options);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: compare_renderings PICTURE.png\n";
    return 2;
  }
  const recede::PolygonSoup fine = recede::make_teapot();
  recede::SimplifyOptions options;
  options.target.ratio = 0.01;
  const recede::SimplifySoupResult coarse = recede::simplify(fine, options);
  const recede::Image original = picture_of(fine, fine), level = picture_of(coarse.soup, fine);

  const recede::ImageDifference difference = recede::compare_images(original, level);
  const recede::ImageMeasure ssim = recede::compute_ssim(original, level);
  const recede::ImageMeasure flip = recede::compute_flip(original, level, {.pixels_per_degree = 67});
  std::cout << coarse.faces_after << " faces: FLIP " << flip.mean << ", SSIM " << ssim.mean << ", PSNR "
            << difference.psnr << " dB\n";
  recede::write_png(argv[1],
                    recede::side_by_side(std::array{original, level, recede::heat_map(flip.map, 1)}));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
