// STEP, IGES and BREP files as OpenCASCADE reads them.
#pragma once

#include <recede/geometry/cad_import.h>

#include <TDocStd_Document.hxx>
#include <TopoDS_Shape.hxx>

#include <filesystem>

namespace recede::detail {

/// What a file holds: a document with assemblies, names and colours, or one shape.
struct CadDocument {
  Handle(TDocStd_Document) document;  ///< null for BREP
  TopoDS_Shape shape;                 ///< of BREP
  std::vector<CadLeftOut> left_out;   ///< what the file names and OpenCASCADE passed over
};

/// Lengths are in millimetres; those of BREP files, which name no unit, as they stand. Prints nothing. Throws
/// `InputError`.
CadDocument read_cad_document(const std::filesystem::path& path, Progress* progress);

}  // namespace recede::detail
