// views_of_a_mesh VIEWS.png GEOMORPH.png [INPUT]: a progressive mesh of INPUT, or of a surface made by code,
// refined for a camera; and one level that turns into another.
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/geomorph.h>
#include <recede/lod/selective_mesh.h>
#include <recede/render/image_difference.h>
#include <recede/render/renderer.h>

#include <iostream>

namespace {

using namespace recede;

Image picture_of(const PolygonSoup& soup, const Camera& camera, bool with_lines = true) {
  RenderOptions options;
  options.samples_per_pixel = 16;
  if (with_lines) options.wireframe = Wireframe{};
  return render(Scene(soup, {.crease_angle = 0}), camera, options);
}

/// A camera close by that sees a part of the surface, and another that sees all of it from the side.
void draw_views(const ProgressiveMesh& mesh, const Box3& box, const char* path) {
  const double size = box.diagonal().norm();
  Camera camera;
  camera.width = camera.height = 250;
  camera.field_of_view = 0.35;
  camera.position = box.center() + size * Vec3(-0.9, 0.3, 0.6);
  camera.target = box.center() + size * Vec3(-0.05, 0.16, 0);
  Camera aside = camera;
  aside.position = box.center() + size * Vec3(1.1, 0.4, 0.8);
  aside.target = box.center();
  aside.field_of_view = 0.6;

  RefinementView view;
  view.position = camera.position;
  view.target = camera.target;
  view.view = {.image_height = 250, .field_of_view = camera.field_of_view, .pixel_error = 1};
  SelectiveMesh selective(mesh);
  const RefinementReport seen = selective.update(view);
  std::vector<Image> pictures{picture_of(selective.soup(), camera), picture_of(selective.soup(), aside)};
  view.faces = seen.faces / 4;
  const RefinementReport within = selective.update(view);
  pictures.push_back(picture_of(selective.soup(), aside));
  write_png(path, side_by_side(pictures));
  std::cout << seen.faces << " of " << mesh.level_faces.back() << " faces for one pixel, " << within.faces
            << " within the budget for " << within.pixel_error << " pixels\n";
}

/// Five pictures from a coarse level to a fine one, and how much pictures of small steps differ.
void draw_geomorph(const ProgressiveMesh& mesh, const std::vector<Vec3>& points, const char* path) {
  const auto level = [&](std::size_t faces) { return mesh.level_for_faces(faces); };
  const Geomorph morph = make_geomorph(mesh, level(600), level(6000));
  const Camera camera = frame_points(points, {0.3, 0.35, 1}, Vec3::UnitY(), 0.4, 176, 0.02);
  std::vector<Image> pictures;
  for (int i = 0; i <= 4; ++i) pictures.push_back(picture_of(morph.at(i / 4.0), camera));
  write_png(path, side_by_side(pictures));

  ProgressiveCursor cursor(mesh);
  cursor.move_to(morph.coarse_level);
  const Image coarse = picture_of(cursor.soup(), camera, false), fine = picture_of(morph.fine, camera, false);
  const double start = compare_images(picture_of(morph.at(0), camera, false), coarse).rmse;
  const double jump = compare_images(coarse, fine).rmse;
  double step = 0;
  constexpr int k_steps = 16;
  Image before = coarse;
  for (int i = 1; i <= k_steps; ++i) {
    Image now = picture_of(morph.at(i / static_cast<double>(k_steps)), camera, false);
    step = std::max(step, compare_images(before, now).rmse);
    before = std::move(now);
  }
  std::cout << "the levels' pictures differ by " << jump << " (RMSE), those of " << k_steps << " steps by "
            << step << " at most; the first is the coarse level's but for " << start << '\n';
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3 && argc != 4) {
    std::cerr << "usage: views_of_a_mesh VIEWS.png GEOMORPH.png [INPUT]\n";
    return 2;
  }
  const recede::PolygonSoup input =
      argc == 4 ? recede::read_soup(argv[3]) : recede::make_displaced_sphere(20'000, true);
  recede::ProgressiveOptions options;
  options.simplify.target.ratio = 0.005;
  const recede::ProgressiveMesh mesh = recede::build_progressive_mesh(input, options);
  draw_views(mesh, recede::bounding_box(input), argv[1]);
  draw_geomorph(mesh, input.positions, argv[2]);
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
