#include <recede/geometry/detail/cad_repair.h>

#include <BRepBuilderAPI_Copy.hxx>
#include <BRep_Tool.hxx>
#include <ShapeBuild_ReShape.hxx>
#include <ShapeFix_Face.hxx>
#include <ShapeFix_Wire.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>

namespace recede::detail {

MendedFace mend_face(const TopoDS_Face& face) {
  if (BRep_Tool::Surface(face).IsNull()) return {};
  // Mending changes edges in place, which other faces use: it gets a copy.
  BRepBuilderAPI_Copy copy(face, true, false);
  const Handle(ShapeBuild_ReShape) changes = new ShapeBuild_ReShape;
  const Handle(ShapeFix_Face) fix = new ShapeFix_Face(TopoDS::Face(copy.Shape()));
  fix->SetContext(changes);
  fix->FixWireTool()->ModifyTopologyMode() = true;
  fix->FixWireTool()->ModifyGeometryMode() = true;
  fix->Perform();
  MendedFace mended;
  const TopoDS_Shape result = fix->Result().IsNull() ? TopoDS_Shape() : changes->Apply(fix->Result());
  for (TopExp_Explorer piece(result, TopAbs_FACE); piece.More(); piece.Next()) {
    mended.faces.push_back(TopoDS::Face(piece.Current()));
  }
  for (const TopAbs_ShapeEnum kind : {TopAbs_EDGE, TopAbs_VERTEX}) {
    for (TopExp_Explorer old(face, kind); old.More(); old.Next()) {
      const TopoDS_Shape now = changes->Apply(copy.ModifiedShape(old.Current()));
      // Nothing is left of what was mended away.
      if (!now.IsNull() && now.ShapeType() == kind && !mended.originals.Contains(now))
        mended.originals.Add(now, old.Current());
    }
  }
  return mended;
}

}  // namespace recede::detail
