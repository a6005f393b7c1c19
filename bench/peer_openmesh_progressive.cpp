#include "measurement.h"
#include "openmesh_mesh.h"
#include "progressive_run.h"
#include <recede/geometry/error.h>

#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModProgMeshT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

namespace recede::bench {

ProgressivePeerFigures run_openmesh_progressive(const PolygonSoup& soup, std::size_t base_faces,
                                                const std::filesystem::path& file, std::size_t repeats) {
  namespace decimater = OpenMesh::Decimater;
  using Mesh = OpenMeshTriangles;
  ProgressivePeerFigures figures;
  omerr().disable();
  std::size_t refused_faces = 0;
  const Mesh input = to_openmesh<Mesh>(soup, refused_faces);
  if (refused_faces > 0) throw Error("refuses faces as not manifold");
  std::vector<double> build, write;
  for (std::size_t run = 0; run < repeats; ++run) {
    Mesh mesh = input;
    decimater::DecimaterT<Mesh> simplifier(mesh);
    decimater::ModQuadricT<Mesh>::Handle quadric;
    decimater::ModNormalFlippingT<Mesh>::Handle flipping;
    decimater::ModProgMeshT<Mesh>::Handle recorder;
    simplifier.add(quadric);
    simplifier.add(flipping);
    simplifier.add(recorder);
    simplifier.module(quadric).unset_max_err();
    build.push_back(median_seconds(1, [&] {
      if (!simplifier.initialize()) throw Error("the decimater can't be initialised");
      simplifier.decimate_to_faces(0, base_faces);
    }));
    write.push_back(median_seconds(1, [&] {
      if (!simplifier.module(recorder).write(file.string())) throw Error("the file can't be written");
    }));
    figures.base_faces = soup.n_faces();
    for (const auto face : mesh.all_faces()) {
      if (mesh.status(face).deleted()) --figures.base_faces;
    }
  }
  figures.bytes = std::filesystem::file_size(file);
  figures.build_seconds = median(build);
  figures.write_seconds = median(write);
  return figures;
}

}  // namespace recede::bench
