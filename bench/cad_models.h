// CAD models as both sides get them: shapes of OpenCASCADE, and patches, face by face.
#pragma once

#include <recede/geometry/cad_import.h>
// Before OpenCASCADE, whose macro Handle would change it.
#include <recede/geometry/polygon_mesh.h>

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace recede::bench {

/// A body of a file, once for all of its instances.
struct CadBench {
  TopoDS_Shape shape;
  std::vector<TopoDS_Face> faces;  ///< in the coordinates of the part
  std::size_t part = 0;            ///< of the model
  std::vector<std::size_t> face_of_patch;
};

struct CadSubject {
  std::string name;
  CadModel model;
  std::vector<CadBench> bodies;
  double diagonal = 0;  ///< of the box of all trimming loops, instances in their places

  std::size_t n_faces() const;
  std::size_t n_patches() const;
};

struct CadSource {
  std::string name;
  bool is_large = false;       ///< one deflection is enough, 1e-3
  std::filesystem::path file;  ///< empty: made by code
  std::function<TopoDS_Shape()> make{};
};

/// The files of Debian's package occt-misc below the folder, then shapes that OpenCASCADE makes.
std::vector<CadSource> cad_sources(const std::filesystem::path& folder);

/// An assembly of about that many patches: plates with screws, two parts with many instances.
CadSubject load_cad_assembly(int patches);

/// Starts no thread. Throws `InputError` for files without a face.
CadSubject load_cad(const CadSource& source);

}  // namespace recede::bench
