// progressive_mesh FILE.pmesh PICTURE.png [INPUT]: a progressive mesh of INPUT, or of a surface made by code,
// into a file and back, and a picture of four of its levels.
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/pmesh.h>
#include <recede/render/renderer.h>

#include <iostream>

namespace {

using namespace recede;

Image picture_of(const PolygonSoup& level, const PolygonSoup& input) {
  constexpr int k_size = 215;
  const Camera camera = frame_points(input.positions, {0.3, 0.35, 1}, Vec3::UnitY(), 0.4, k_size, 0.05);
  RenderOptions options;
  options.samples_per_pixel = 16;
  options.wireframe = Wireframe{};
  return render(Scene(level), camera, options);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3 && argc != 4) {
    std::cerr << "usage: progressive_mesh FILE.pmesh PICTURE.png [INPUT]\n";
    return 2;
  }
  const recede::PolygonSoup input =
      argc == 4 ? recede::read_soup(argv[3]) : recede::make_displaced_sphere(20'000, true);

  recede::ProgressiveOptions options;
  options.simplify.target.ratio = 0.005;
  const recede::ProgressiveMesh built = recede::build_progressive_mesh(input, options);
  const recede::PmeshReport file = recede::write_pmesh(argv[1], built, {.keep_numbering = true});
  std::cout << file.bytes << " bytes for " << input.n_faces() << " faces\n";

  const recede::ProgressiveMesh mesh = recede::read_pmesh(argv[1]);
  recede::ProgressiveCursor cursor(mesh);
  std::vector<recede::Image> pictures;
  for (const double share : {0.005, 0.03, 0.2, 1.0}) {
    const double faces = share * static_cast<double>(input.n_faces());
    cursor.move_to(mesh.level_for_faces(static_cast<std::size_t>(faces)));
    std::cout << cursor.n_faces() << " faces, off by at most " << cursor.error() << '\n';
    pictures.push_back(picture_of(cursor.soup(), input));
  }
  recede::write_png(argv[2], recede::side_by_side(pictures));

  // With its numbering the full level is the input, bit for bit.
  const bool same = cursor.soup().positions == input.positions;
  std::cout << (same ? "the input is back" : "the input is lost") << '\n';
  return same ? 0 : 1;
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
