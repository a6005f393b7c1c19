// dice_view PICTURE.png: a landscape of 512 triangles and a height map, diced for a camera; the mesh as the
// camera sees it, and from the side.
#include <recede/geometry/error.h>
#include <recede/lod/view_dependent_remesh.h>
#include <recede/render/renderer.h>

#include <array>
#include <cmath>
#include <iostream>
#include <vector>

namespace {

using namespace recede;

/// The square from -1 to 1 in the plane z = 0, with texture coordinates.
PolygonSoup make_plane(Index n) {
  PolygonSoup soup;
  std::vector<Vec2> uvs;
  for (Index y = 0; y <= n; ++y) {
    for (Index x = 0; x <= n; ++x) {
      uvs.emplace_back(double(x) / n, double(y) / n);
      soup.positions.emplace_back(2 * uvs.back().x() - 1, 2 * uvs.back().y() - 1, 0);
    }
  }
  for (Index y = 0; y < n; ++y) {
    for (Index x = 0; x < n; ++x) {
      const Index a = y * (n + 1) + x, b = a + n + 1;
      soup.add_face(std::array{a, a + 1, b + 1});
      soup.add_face(std::array{a, b + 1, b});
    }
  }
  for (const Index v : soup.corner_vertices) soup.corner_uvs.push_back(uvs[v]);
  return soup;
}

/// Ridges of six octaves.
DisplacementMap make_ridges(int size) {
  std::vector<float> heights;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      double height = 0, u = 7.0 * x / size + 1, v = 7.0 * y / size + 2, strength = 0.13;
      for (int octave = 0; octave < 6; ++octave, strength *= 0.45) {
        height +=
            strength * (1 - std::abs(std::sin(u + 0.7 * std::sin(v)) * std::cos(v - 0.4 * std::sin(u))));
        const double turned = 1.6 * u + 1.2 * v;
        v = 1.6 * v - 1.2 * u + 3;
        u = turned;
      }
      heights.push_back(static_cast<float>(height - 0.12));
    }
  }
  return {size, size, std::move(heights)};
}

Image picture_of(const PolygonSoup& mesh, const Camera& camera) {
  RenderOptions options;
  options.samples_per_pixel = 16;
  options.wireframe = Wireframe{};
  return render(Scene(mesh), camera, options);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: dice_view PICTURE.png\n";
    return 2;
  }
  const recede::DisplacedBase base(make_plane(16), make_ridges(1024));
  recede::Camera camera;
  camera.position = {-0.8, -0.95, 0.25};
  camera.target = {-0.25, -0.3, -0.12};
  camera.up = recede::Vec3::UnitZ();
  camera.width = camera.height = 240;

  recede::RemeshOptions options;
  options.triangle_pixels = 11;
  const recede::RemeshResult diced = recede::remesh_for_view(base, recede::remesh_view_of(camera), options);
  std::cout << diced.report.base_triangles << " triangles, " << diced.report.culled << " of "
            << diced.report.patches << " patches not in the picture, " << diced.report.triangles
            << " small triangles\n";

  recede::Camera aside = camera;
  aside.position = {0.6, -1.8, 2.6};
  aside.target = {-0.1, -0.1, 0};
  aside.field_of_view = 0.6;
  recede::write_png(argv[1], recede::side_by_side(
                                 std::array{picture_of(diced.soup, camera), picture_of(diced.soup, aside)}));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
