// bake_out_of_core INPUT FOLDER: levels of a mesh that may be larger than memory, a binary PLY or STL file.
#include <recede/geometry/error.h>
#include <recede/lod/out_of_core.h>

#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::fprintf(stderr, "usage: bake_out_of_core INPUT FOLDER\n");
    return 2;
  }
  recede::HierarchyOptions options;
  options.ratios = {0.1, 0.01};
  const recede::OutOfCoreHierarchy built = recede::build_hierarchy_out_of_core(
      argv[1], "scan", options, {.memory = std::size_t{2} << 30, .scratch = argv[2]});
  for (const recede::LodLevel& level : built.hierarchy.levels)
    std::printf("%zu faces, off by at most %g\n", level.mesh.n_faces(), level.error.bound);

  recede::write_hierarchy(argv[2], built.hierarchy);
} catch (const recede::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
