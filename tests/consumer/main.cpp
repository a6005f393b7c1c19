// consumer MESH: halves the faces of a mesh, and bakes it to show that every room links.
#include <recede/geometry/mesh_io.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/simplify.h>
#include <recede/render/report.h>
#include <recede/version.h>

#include <iostream>
#include <string_view>

static_assert(std::string_view(RECEDE_VERSION) == FOUND_VERSION, "the header and find_package say the same");

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const recede::PolygonMesh mesh = recede::read_mesh(argv[1]).mesh;
  const recede::SimplifyResult result = recede::simplify(mesh, {.target = {.ratio = 0.5}});
  std::cout << result.faces_before << " faces became " << result.faces_after << '\n';
  recede::HierarchyOptions options;
  options.ratios = {0.5};
  const recede::LodHierarchy hierarchy = recede::build_hierarchy(mesh, "block", options);
  const recede::HierarchyFiles files = recede::write_hierarchy("out", hierarchy);
  std::cout << recede::write_report("out", hierarchy, files).html.string() << '\n';
}
