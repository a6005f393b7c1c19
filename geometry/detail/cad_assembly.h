// The bodies of a CAD file, where they stand, and what they are called and made of.
#pragma once

#include <recede/geometry/cad_import.h>
#include <recede/geometry/detail/cad_document.h>

#include <TopoDS_Face.hxx>

#include <string>
#include <vector>

namespace recede::detail {

struct CadFace {
  TopoDS_Face face;  ///< in the body's coordinates
  std::string name;  ///< empty: none
  Index material = k_no_index;
};

/// A solid, a shell on its own, or all loose faces of one shape.
struct CadBody {
  std::string name;
  TopoDS_Shape shape;
  std::vector<CadFace> faces;
};

struct CadAssembly {
  std::vector<CadBody> bodies;
  std::vector<CadInstance> instances;  ///< `part` numbers the bodies
  std::vector<Material> materials;
  std::vector<CadLeftOut> left_out;
};

/// `name` stands for shapes without one.
CadAssembly list_bodies(const CadDocument& document, const std::string& name);

}  // namespace recede::detail
