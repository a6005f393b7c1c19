#include <recede/geometry/detail/cad_assembly.h>

#include <BRep_Builder.hxx>
#include <Quantity_ColorRGBA.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Iterator.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <utility>

namespace recede::detail {

namespace {

Eigen::Affine3d to_affine(const TopLoc_Location& location) {
  Eigen::Affine3d placement = Eigen::Affine3d::Identity();
  const gp_Trsf trsf = location.Transformation();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      placement.matrix()(row, column) = trsf.Value(row + 1, column + 1);
    }
  }
  return placement;
}

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) attribute;
  if (label.IsNull() || !label.FindAttribute(TDataStd_Name::GetID(), attribute)) return "";
  const TCollection_ExtendedString& wide = attribute->Get();
  const auto length = static_cast<std::size_t>(wide.LengthOfCString());
  std::string text(length + 1, '\0');
  Standard_PCharacter bytes = text.data();
  wide.ToUTF8CString(bytes);
  text.resize(length);
  // Names stand in messages of one line.
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  return text;
}

/// What an instance inherits on the way down an assembly.
struct Place {
  TopLoc_Location location;
  std::string name;
  Index material = k_no_index;
  bool is_colored_here = false;  ///< by the component, whose colour stands above that of what it refers to
};

class BodyLister {
 public:
  BodyLister(const CadDocument& document, std::string name) : name_(std::move(name)) {
    if (document.document.IsNull()) return;
    shapes_ = XCAFDoc_DocumentTool::ShapeTool(document.document->Main());
    colors_ = XCAFDoc_DocumentTool::ColorTool(document.document->Main());
  }

  CadAssembly run(const CadDocument& document) {
    if (shapes_.IsNull()) {
      add_shape(document.shape, {{}, name_}, {});
    } else {
      add_free_labels();
    }
    add_loose(loose_faces_, {{}, name_});
    return std::move(assembly_);
  }

 private:
  using BodyKey = std::pair<const void*, int>;
  struct LooseBody {
    std::vector<TopoDS_Shape> faces;
    Index body;
  };

  void add_free_labels();
  void add_label(const TDF_Label& label, Place place);
  void add_shape(const TopoDS_Shape& shape, const Place& place, const TDF_Label& label);
  void collect(const TopoDS_Shape& shape, const Place& place, const std::string& name,
               std::vector<TopoDS_Shape>& loose);
  void add_body(const TopoDS_Shape& shape, const Place& place, const std::string& name);
  void add_loose(const std::vector<TopoDS_Shape>& faces, const Place& place);
  void fill(CadBody& body, const TopoDS_Shape& located);
  std::string sub_shape_name(const TopoDS_Shape& shape) const;
  Index material_of(const TDF_Label& label);
  Index material_of(const TopoDS_Shape& shape);
  Index number_of(const Quantity_ColorRGBA& color);
  void leave_out(const std::string& name, const TopoDS_Shape& shape);

  std::string name_;
  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colors_;
  std::map<BodyKey, Index> known_;
  std::vector<LooseBody> loose_bodies_;
  std::vector<TopoDS_Shape> loose_faces_;
  std::map<std::string, Index> material_numbers_;
  CadAssembly assembly_;
};

/// Faces that stand on their own, as in IGES files, are one body together.
void BodyLister::add_free_labels() {
  TDF_LabelSequence free;
  shapes_->GetFreeShapes(free);
  for (const TDF_Label& label : free) {
    const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
    if (shape.ShapeType() == TopAbs_FACE) {
      loose_faces_.push_back(shape);
    } else {
      add_label(label, {{}, name_of(label)});
    }
  }
}

void BodyLister::add_label(const TDF_Label& label, Place place) {
  const Index own = material_of(label);
  if (own != k_no_index && !place.is_colored_here) place.material = own;
  if (!XCAFDoc_ShapeTool::IsAssembly(label)) {
    add_shape(XCAFDoc_ShapeTool::GetShape(label), place, label);
    return;
  }
  TDF_LabelSequence components;
  XCAFDoc_ShapeTool::GetComponents(label, components);
  for (const TDF_Label& component : components) {
    TDF_Label referred;
    if (!XCAFDoc_ShapeTool::GetReferredShape(component, referred)) continue;
    Place below = place;
    below.location = place.location * XCAFDoc_ShapeTool::GetLocation(component);
    below.name = name_of(component);
    if (below.name.empty() || below.name.starts_with("=>[")) below.name = name_of(referred);
    const Index of_component = material_of(component);
    below.is_colored_here = of_component != k_no_index;
    if (below.is_colored_here) below.material = of_component;
    add_label(referred, std::move(below));
  }
}

void BodyLister::add_shape(const TopoDS_Shape& shape, const Place& place, const TDF_Label& label) {
  std::string name = name_of(label);
  if (name.empty()) name = name_;
  std::vector<TopoDS_Shape> loose;
  collect(shape, place, name, loose);
  Place of_loose = place;
  if (of_loose.name.empty()) of_loose.name = name;
  add_loose(loose, of_loose);
}

void BodyLister::collect(const TopoDS_Shape& shape, const Place& place, const std::string& name,
                         std::vector<TopoDS_Shape>& loose) {
  switch (shape.ShapeType()) {
    case TopAbs_COMPOUND:
      for (TopoDS_Iterator child(shape); child.More(); child.Next()) {
        const std::string own = sub_shape_name(child.Value());
        collect(child.Value(), place, own.empty() ? name : own, loose);
      }
      break;
    case TopAbs_COMPSOLID:
    case TopAbs_SOLID:
    case TopAbs_SHELL:
      add_body(shape, place, name);
      break;
    case TopAbs_FACE:
      loose.push_back(shape);
      break;
    default:
      leave_out(name, shape);
  }
}

/// The same body at another place is one more instance.
void BodyLister::add_body(const TopoDS_Shape& shape, const Place& place, const std::string& name) {
  const BodyKey key{shape.TShape().get(), static_cast<int>(shape.Orientation())};
  const auto [known, is_new] = known_.try_emplace(key, static_cast<Index>(assembly_.bodies.size()));
  if (is_new) {
    CadBody& body = assembly_.bodies.emplace_back();
    body.name = name;
    body.shape = shape.Located(TopLoc_Location());
    fill(body, shape);
  }
  const TopLoc_Location location = place.location * shape.Location();
  Index material = material_of(shape);
  if (material == k_no_index) material = place.material;
  assembly_.instances.push_back(
      {known->second, to_affine(location), place.name.empty() ? name : place.name, material});
}

void BodyLister::add_loose(const std::vector<TopoDS_Shape>& faces, const Place& place) {
  if (faces.empty()) return;
  TopoDS_Compound compound;
  BRep_Builder builder;
  builder.MakeCompound(compound);
  for (const TopoDS_Shape& face : faces) builder.Add(compound, face);
  const auto known = std::find_if(loose_bodies_.begin(), loose_bodies_.end(), [&](const LooseBody& body) {
    return std::equal(faces.begin(), faces.end(), body.faces.begin(), body.faces.end(),
                      [](const TopoDS_Shape& a, const TopoDS_Shape& b) { return a.IsEqual(b); });
  });
  const bool is_new = known == loose_bodies_.end();
  const Index number = is_new ? static_cast<Index>(assembly_.bodies.size()) : known->body;
  if (is_new) {
    loose_bodies_.push_back({faces, number});
    CadBody& body = assembly_.bodies.emplace_back();
    body.name = place.name.empty() ? name_ : place.name;
    body.shape = compound;
    fill(body, compound);
  }
  assembly_.instances.push_back({number, to_affine(place.location), place.name, place.material});
}

/// Faces as they stand in the body, with names and colours that the file knows by where they stood.
void BodyLister::fill(CadBody& body, const TopoDS_Shape& located) {
  TopExp_Explorer as_known(located, TopAbs_FACE);
  for (TopExp_Explorer own(body.shape, TopAbs_FACE); own.More(); own.Next(), as_known.Next()) {
    body.faces.push_back(
        {TopoDS::Face(own.Current()), sub_shape_name(as_known.Current()), material_of(as_known.Current())});
  }
}

std::string BodyLister::sub_shape_name(const TopoDS_Shape& shape) const {
  TDF_Label label;
  if (shapes_.IsNull() || !shapes_->Search(shape, label, true, true, true)) return "";
  return name_of(label);
}

Index BodyLister::material_of(const TDF_Label& label) {
  if (colors_.IsNull() || label.IsNull()) return k_no_index;
  for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen}) {
    Quantity_ColorRGBA color;
    if (colors_->GetColor(label, type, color)) return number_of(color);
  }
  return k_no_index;
}

Index BodyLister::material_of(const TopoDS_Shape& shape) {
  if (colors_.IsNull()) return k_no_index;
  for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen}) {
    Quantity_ColorRGBA color;
    if (colors_->GetColor(shape, type, color)) return number_of(color);
  }
  return k_no_index;
}

/// Colours have no names of their own: the material's name is the colour as style sheets write it.
Index BodyLister::number_of(const Quantity_ColorRGBA& color) {
  const std::string name = Quantity_ColorRGBA::ColorToHex(color).ToCString();
  const auto [known, is_new] =
      material_numbers_.try_emplace(name, static_cast<Index>(assembly_.materials.size()));
  if (is_new) {
    const Quantity_Color& rgb = color.GetRGB();
    assembly_.materials.push_back({name, Vec4(rgb.Red(), rgb.Green(), rgb.Blue(), color.Alpha()), ""});
  }
  return known->second;
}

void BodyLister::leave_out(const std::string& name, const TopoDS_Shape& shape) {
  const char* const kind = shape.ShapeType() == TopAbs_WIRE   ? "wire"
                           : shape.ShapeType() == TopAbs_EDGE ? "edge"
                                                              : "point";
  assembly_.left_out.push_back({fmt::format("{} of \"{}\"", kind, name), "has no face"});
}

}  // namespace

CadAssembly list_bodies(const CadDocument& document, const std::string& name) {
  return BodyLister(document, name).run(document);
}

}  // namespace recede::detail
