// CAD files as OpenCASCADE itself reads them, to be compared with what is imported.
#pragma once

#include "cad_checks.h"

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IGESControl_Reader.hxx>
#include <STEPControl_Reader.hxx>

namespace recede::test {

/// The file as OpenCASCADE's own readers give it, in one shape.
inline TopoDS_Shape shape_of(const std::filesystem::path& path) {
  const Silence silence;
  TopoDS_Shape shape;
  if (path.extension() == ".brep") {
    BRepTools::Read(shape, path.string().c_str(), BRep_Builder());
  } else if (path.extension() == ".step") {
    STEPControl_Reader reader;
    reader.ReadFile(path.string().c_str());
    reader.TransferRoots();
    shape = reader.OneShape();
  } else {
    IGESControl_Reader reader;
    reader.ReadFile(path.string().c_str());
    reader.TransferRoots();
    shape = reader.OneShape();
  }
  return shape;
}

/// Solids, or all faces when there is none: what becomes a part each.
inline std::vector<TopoDS_Shape> bodies_of(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Shape> bodies;
  for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next()) {
    if (!faces_of(solid.Current()).empty()) bodies.push_back(solid.Current());
  }
  if (bodies.empty() && !faces_of(shape).empty()) bodies.push_back(shape);
  return bodies;
}

/// A face of a body in the coordinates of its part: bodies are in their own, loose faces stand where they
/// are.
inline TopoDS_Face face_of_body(const TopoDS_Face& face, const TopoDS_Shape& body) {
  if (body.ShapeType() == TopAbs_FACE) return face;
  return TopoDS::Face(face.Moved(body.Location().Inverted()));
}

}  // namespace recede::test
