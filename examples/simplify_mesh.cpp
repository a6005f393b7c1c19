// simplify_mesh INPUT OUTPUT: a tenth of the faces, and how far the result is from the input.
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/simplify.h>

#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: simplify_mesh INPUT OUTPUT\n";
    return 2;
  }
  const recede::MeshFromSoup input = recede::read_mesh(argv[1]);
  for (const recede::RepairStep& step : input.report.steps) {
    if (step.changed > 0) std::cout << step.name << ": " << step.detail << '\n';
  }

  recede::SimplifyOptions options;
  options.target.ratio = 0.1;
  const recede::SimplifyResult result = recede::simplify(input.mesh, options);
  std::cout << result.faces_before << " -> " << result.faces_after << " faces, "
            << to_string(result.stop_reason) << '\n';

  const recede::MeshDistance distance =
      recede::measure_distance(input.mesh, result.mesh, {.bound_tolerance = 0.05});
  std::cout << "seen " << distance.max << ", certainly at most " << *distance.max_bound << '\n';

  for (const std::string& missing : recede::write_mesh(argv[2], result.mesh).written_without) {
    std::cout << "written without " << missing << '\n';
  }
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
