// bake_hierarchy INPUT FOLDER: levels that are off by 0.1 %, 0.5 % and 2 % of the model's size at most, with
// a report.
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/render/report.h>

#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: bake_hierarchy INPUT FOLDER\n";
    return 2;
  }
  const recede::PolygonMesh mesh = recede::read_mesh(argv[1]).mesh;

  recede::HierarchyOptions options;
  options.relative_errors = {0.001, 0.005, 0.02};  // shares of the diagonal
  options.view = {.image_height = 1080, .field_of_view = 0.785, .pixel_error = 1};
  const recede::LodHierarchy hierarchy = recede::build_hierarchy(mesh, "model", options);

  const recede::HierarchyFiles files = recede::write_hierarchy(argv[2], hierarchy);
  const recede::ReportFiles report = recede::write_report(argv[2], hierarchy, files);
  std::cout << "report: " << report.html.string() << '\n';

  // Any program can take it from here:
  for (const recede::LodLevel& level : recede::read_hierarchy(files.folder).levels) {
    std::cout << level.mesh.n_faces() << " faces from distance " << level.switch_distance
              << " on, off by at most " << level.error.bound << '\n';
  }
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
