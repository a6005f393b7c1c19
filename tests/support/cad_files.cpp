// Writing the shapes of cad_shapes.h.
#include "cad_shapes.h"

#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Controller.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Writer.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include <map>
#include <stdexcept>

namespace recede::test {

namespace {

void require(bool is_done, const std::filesystem::path& path) {
  if (!is_done) throw std::runtime_error("can't write " + path.string());
}

}  // namespace

void write_brep(const std::filesystem::path& path, const TopoDS_Shape& shape) {
  require(BRepTools::Write(shape, path.string().c_str()), path);
}

void write_step(const std::filesystem::path& path, const TopoDS_Shape& shape, const std::string& unit) {
  const Silence silence;
  STEPCAFControl_Controller::Init();
  Interface_Static::SetCVal("write.step.unit", unit.c_str());
  STEPControl_Writer writer;
  const bool is_done = writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone &&
                       writer.Write(path.string().c_str()) == IFSelect_RetDone;
  Interface_Static::SetCVal("write.step.unit", "MM");
  require(is_done, path);
}

void write_iges(const std::filesystem::path& path, const TopoDS_Shape& shape) {
  const Silence silence;
  IGESControl_Controller::Init();
  IGESControl_Writer writer("MM", 1);  // 1: solids as such, not as faces on their own
  const bool is_added = writer.AddShape(shape);
  writer.ComputeModel();
  require(is_added && writer.Write(path.string().c_str()), path);
}

void write_step_assembly(const std::filesystem::path& path, const std::vector<CadComponent>& components,
                         const std::vector<TopoDS_Shape>& painted) {
  const Silence silence;
  STEPCAFControl_Controller::Init();
  Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  XCAFDoc_DocumentTool::Set(document->Main());
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const Handle(XCAFDoc_ColorTool) colors = XCAFDoc_DocumentTool::ColorTool(document->Main());
  const TDF_Label assembly = shapes->NewShape();
  TDataStd_Name::Set(assembly, "assembly");
  std::map<const void*, TDF_Label> parts;
  for (const CadComponent& component : components) {
    TDF_Label& part = parts[component.shape.TShape().get()];
    if (part.IsNull()) {
      part = shapes->AddShape(component.shape, false);
      TDataStd_Name::Set(part, component.name.c_str());
    }
    gp_Trsf move;
    move.SetTranslation(gp_Vec(component.at[0], component.at[1], component.at[2]));
    const TDF_Label placed = shapes->AddComponent(assembly, part, TopLoc_Location(move));
    TDataStd_Name::Set(placed, component.name.c_str());
    const auto& [red, green, blue] = component.color;
    if (red >= 0)
      colors->SetColor(part, Quantity_Color(red, green, blue, Quantity_TOC_RGB), XCAFDoc_ColorGen);
  }
  for (const TopoDS_Shape& shape : painted) {
    const TDF_Label part = parts[shape.TShape().get()];
    const TDF_Label face = shapes->AddSubShape(part, TopExp_Explorer(shape, TopAbs_FACE).Current());
    colors->SetColor(face, Quantity_Color(1, 0, 0, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
  }
  shapes->UpdateAssemblies();
  STEPCAFControl_Writer writer;
  require(
      writer.Transfer(document, STEPControl_AsIs) && writer.Write(path.string().c_str()) == IFSelect_RetDone,
      path);
}

}  // namespace recede::test
