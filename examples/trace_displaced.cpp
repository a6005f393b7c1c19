// trace_displaced PICTURE.png: a sphere with a rough height map, traced without tessellation: what it costs,
// what a ray meets, and a picture.
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/render/displaced_mesh.h>
#include <recede/render/image.h>
#include <recede/render/renderer.h>

#include <cmath>
#include <iostream>

namespace {

/// Heights of 0 to 0.05 in rings and ripples, `size` texels a side.
recede::DisplacementMap make_ripples(int size) {
  std::vector<float> heights;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double u = 40.0 * x / size, v = 40.0 * y / size;
      heights.push_back(
          static_cast<float>(0.025 + 0.015 * std::sin(u) * std::sin(v) + 0.01 * std::sin(5 * u + v)));
    }
  }
  return recede::DisplacementMap(size, size, std::move(heights));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: trace_displaced PICTURE.png\n";
    return 2;
  }
  const recede::PolygonSoup base = recede::make_atlas(recede::make_displaced_sphere(1000, true)).soup;
  const recede::DisplacementMap map = make_ripples(1024);

  recede::DisplacedMeshOptions options;
  options.level = 6;
  const recede::DisplacedMesh mesh(base, map, options);
  const recede::DisplacedMesh::Memory memory = mesh.memory();
  std::cout << mesh.small_triangles() << " small triangles in " << memory.map + memory.pyramid + memory.base
            << " bytes\n";
  if (const auto hit = mesh.first_hit({0, 0, 3}, {0, 0, -1})) {
    std::cout << "a ray lands on face " << hit->face << " after " << hit->t << '\n';
  }

  const recede::Scene scene(base, map, options);
  recede::Camera camera;
  camera.position = {1.2, 0.9, 2.4};
  recede::RenderOptions rendering;
  rendering.transport = recede::LightTransport::direct;
  rendering.lighting = recede::daylight();
  recede::write_png(argv[1], recede::render(scene, camera, rendering));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
