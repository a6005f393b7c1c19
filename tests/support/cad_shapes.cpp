#include "cad_shapes.h"

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepLib.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <GeomConvert.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>

#include <cmath>
#include <numbers>

namespace recede::test {

namespace {

constexpr double k_pi = std::numbers::pi;

Handle(Geom_BSplineSurface) wavy_surface(double size, double height, double amplitude) {
  constexpr int k_points = 9;
  TColgp_Array2OfPnt points(1, k_points, 1, k_points);
  for (int i = 1; i <= k_points; ++i) {
    for (int j = 1; j <= k_points; ++j) {
      const double x = size * (i - 1) / (k_points - 1), y = size * (j - 1) / (k_points - 1);
      points(i, j) = gp_Pnt(x, y, height + amplitude * std::sin(x / 4) * std::cos(y / 5));
    }
  }
  return GeomAPI_PointsToBSplineSurface(points).Surface();
}

TopoDS_Wire polygon(const std::vector<gp_Pnt>& points, bool is_closed = true) {
  BRepBuilderAPI_MakePolygon maker;
  for (const gp_Pnt& point : points) maker.Add(point);
  if (is_closed) maker.Close();
  return maker.Wire();
}

TopoDS_Wire square(double x, double y, double size) {
  return polygon({{x, y, 0}, {x + size, y, 0}, {x + size, y + size, 0}, {x, y + size, 0}});
}

/// A face over wires as they are: nothing is checked or turned around.
TopoDS_Face bare_face(const Handle(Geom_Surface) & surface, const std::vector<TopoDS_Shape>& wires) {
  BRep_Builder builder;
  TopoDS_Face face;
  builder.MakeFace(face, surface, 1e-7);
  for (const TopoDS_Shape& wire : wires) builder.Add(face, wire);
  return face;
}

TopoDS_Shape plane_face(const std::vector<TopoDS_Shape>& wires) {
  return bare_face(new Geom_Plane(gp::XOY()), wires);
}

/// The edge over a straight line of parameters.
TopoDS_Edge edge_on(const Handle(Geom_Surface) & surface, const gp_Pnt2d& from, const gp_Pnt2d& to) {
  const Handle(Geom2d_Line) line = new Geom2d_Line(from, gp_Dir2d(gp_Vec2d(from, to)));
  const TopoDS_Edge edge = BRepBuilderAPI_MakeEdge(line, surface, 0, from.Distance(to));
  BRepLib::BuildCurve3d(edge);
  return edge;
}

/// A loop over a rectangle of parameters, of edges that share their corners.
TopoDS_Wire rectangle_on(const Handle(Geom_Surface) & surface, double u0, double u1, double v0, double v1) {
  BRepBuilderAPI_MakeWire maker;
  const std::array<gp_Pnt2d, 4> corners{gp_Pnt2d(u0, v0), gp_Pnt2d(u1, v0), gp_Pnt2d(u1, v1),
                                        gp_Pnt2d(u0, v1)};
  for (std::size_t i = 0; i < 4; ++i) maker.Add(edge_on(surface, corners[i], corners[(i + 1) % 4]));
  return maker.Wire();
}

/// All of a bilinear surface whose sides in both directions are the same.
TopoDS_Shape flat_surface(const gp_Vec& side) {
  TColgp_Array2OfPnt poles(1, 2, 1, 2);
  for (int i = 1; i <= 2; ++i) {
    for (int j = 1; j <= 2; ++j) poles(i, j) = gp_Pnt(side.XYZ() * (i + j - 2));
  }
  TColStd_Array1OfReal knots(1, 2);
  TColStd_Array1OfInteger times(1, 2);
  knots(1) = 0;
  knots(2) = 1;
  times.Init(2);
  const Handle(Geom_BSplineSurface) surface =
      new Geom_BSplineSurface(poles, knots, knots, times, times, 1, 1);
  return bare_face(surface, {rectangle_on(surface, 0, 1, 0, 1)});
}

}  // namespace

TopoDS_Shape cad_box(double x, double y, double z) { return BRepPrimAPI_MakeBox(x, y, z).Shape(); }

TopoDS_Shape cad_rounded_box(double radius) {
  const TopoDS_Shape box = cad_box();
  BRepFilletAPI_MakeFillet maker(box);
  for (TopExp_Explorer edge(box, TopAbs_EDGE); edge.More(); edge.Next()) {
    maker.Add(radius, TopoDS::Edge(edge.Current()));
  }
  return maker.Shape();
}

TopoDS_Shape cad_cylinder(double radius, double height) {
  return BRepPrimAPI_MakeCylinder(radius, height).Shape();
}

TopoDS_Shape cad_sphere(double radius) { return BRepPrimAPI_MakeSphere(radius).Shape(); }

TopoDS_Shape cad_bored_sphere() {
  TopoDS_Shape shape = cad_sphere(10);
  for (const gp_Dir& axis : {gp::DX(), -gp::DX(), gp::DY(), -gp::DY(), gp::DZ(), -gp::DZ()}) {
    const gp_Pnt start(axis.XYZ() * 6);
    shape = BRepAlgoAPI_Cut(shape, BRepPrimAPI_MakeCylinder(gp_Ax2(start, axis), 3, 10).Shape()).Shape();
  }
  return shape;
}

TopoDS_Shape cad_torus(double major, double minor) { return BRepPrimAPI_MakeTorus(major, minor).Shape(); }

TopoDS_Shape cad_cone(double radius, double height) {
  return BRepPrimAPI_MakeCone(radius, 0, height).Shape();
}

TopoDS_Shape cad_wavy_block() {
  const TopoDS_Face top = BRepBuilderAPI_MakeFace(wavy_surface(40, 8, 1.5), 1e-7);
  TopoDS_Shape shape = BRepPrimAPI_MakePrism(top, gp_Vec(0, 0, -10)).Shape();
  TopTools_ListOfShape block, holes;
  block.Append(shape);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const gp_Ax2 axis(gp_Pnt(5 + 10 * i, 5 + 10 * j, -20), gp::DZ());
      holes.Append(BRepPrimAPI_MakeCylinder(axis, 2, 50).Shape());
    }
  }
  BRepAlgoAPI_Cut cut;
  cut.SetArguments(block);
  cut.SetTools(holes);
  cut.Build();
  return cut.Shape();
}

TopoDS_Shape cad_prism(int sides) {
  std::vector<gp_Pnt> corners;
  for (int i = 0; i < sides; ++i) {
    corners.emplace_back(10 * std::cos(2 * k_pi * i / sides), 10 * std::sin(2 * k_pi * i / sides), 0);
  }
  return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(polygon(corners)).Face(), gp_Vec(0, 0, 5)).Shape();
}

TopoDS_Shape cad_plate(int holes) {
  const double pitch = 8;
  TopTools_ListOfShape plate, tools;
  plate.Append(cad_box(pitch * holes, pitch * holes, 2));
  for (int i = 0; i < holes; ++i) {
    for (int j = 0; j < holes; ++j) {
      const gp_Ax2 axis(gp_Pnt(pitch * (i + 0.5), pitch * (j + 0.5), -1), gp::DZ());
      tools.Append(BRepPrimAPI_MakeCylinder(axis, 1.6, 4).Shape());
    }
  }
  BRepAlgoAPI_Cut cut;
  cut.SetArguments(plate);
  cut.SetTools(tools);
  cut.Build();
  TopExp_Explorer solid(cut.Shape(), TopAbs_SOLID);
  return solid.Current();
}

TopoDS_Shape cad_screw() {
  const TopoDS_Shape head = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, 2), gp::DZ()), 3, 2).Shape();
  const TopoDS_Shape shaft = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, -6), gp::DZ()), 1.5, 8).Shape();
  const TopoDS_Shape tip = BRepPrimAPI_MakeCone(gp_Ax2(gp_Pnt(0, 0, -6), -gp::DZ()), 1.5, 0.5, 1).Shape();
  const TopoDS_Shape screw = BRepAlgoAPI_Fuse(BRepAlgoAPI_Fuse(head, shaft).Shape(), tip).Shape();
  TopExp_Explorer solid(screw, TopAbs_SOLID);
  return solid.Current();
}

TopoDS_Shape cad_compound(const std::vector<TopoDS_Shape>& shapes) {
  TopoDS_Compound compound;
  BRep_Builder builder;
  builder.MakeCompound(compound);
  for (const TopoDS_Shape& shape : shapes) builder.Add(compound, shape);
  return compound;
}

TopoDS_Shape cad_three_faces_at_an_edge() {
  const TopoDS_Edge shared = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(0, 0, 10));
  std::vector<TopoDS_Shape> faces;
  for (const gp_Vec& side : {gp_Vec(10, 0, 0), gp_Vec(-5, 8, 0), gp_Vec(-5, -8, 0)}) {
    faces.push_back(BRepPrimAPI_MakePrism(shared, side).Shape());
  }
  return cad_compound(faces);
}

TopoDS_Shape cad_duplicate_faces() {
  return cad_compound({plane_face({square(0, 0, 10)}), plane_face({square(0, 0, 10)})});
}

TopoDS_Shape cad_face_without_wires() { return bare_face(wavy_surface(20, 0, 1), {}); }

TopoDS_Shape cad_sphere_without_wires() { return bare_face(new Geom_SphericalSurface(gp::XOY(), 10), {}); }

TopoDS_Shape cad_tube_without_seam() {
  const Handle(Geom_CylindricalSurface) surface = new Geom_CylindricalSurface(gp::XOY(), 5);
  const TopoDS_Wire bottom = BRepBuilderAPI_MakeWire(edge_on(surface, gp_Pnt2d(0, 0), gp_Pnt2d(2 * k_pi, 0)));
  const TopoDS_Wire top = BRepBuilderAPI_MakeWire(edge_on(surface, gp_Pnt2d(0, 12), gp_Pnt2d(2 * k_pi, 12)));
  return bare_face(surface, {bottom, top.Reversed()});
}

TopoDS_Shape cad_square_with_inner_edge() {
  const TopoDS_Wire outer = square(0, 0, 10);
  BRep_Builder builder;
  TopoDS_Edge inner = BRepBuilderAPI_MakeEdge(gp_Pnt(3, 3, 0), gp_Pnt(6, 5, 0));
  inner.Orientation(TopAbs_INTERNAL);
  TopoDS_Wire wire;
  builder.MakeWire(wire);
  builder.Add(wire, inner);
  return plane_face({outer, wire});
}

TopoDS_Shape cad_two_islands() { return plane_face({square(0, 0, 10), square(20, 0, 10)}); }

TopoDS_Shape cad_offset_face() {
  const Handle(Geom_OffsetSurface) surface = new Geom_OffsetSurface(wavy_surface(20, 0, 1), 1.5);
  return BRepBuilderAPI_MakeFace(surface, 1e-7).Face();
}

std::vector<TopoDS_Shape> cad_swept_faces() {
  const gp_Ax2 axes(gp_Pnt(20, 0, 0), gp::DY(), gp::DX());
  std::vector<TopoDS_Shape> faces;
  for (const TopoDS_Edge& edge : {BRepBuilderAPI_MakeEdge(gp_Elips(axes, 6, 3), 0.3, 4.0).Edge(),
                                  BRepBuilderAPI_MakeEdge(gp_Hypr(axes, 4, 3), -0.7, 1.1).Edge(),
                                  BRepBuilderAPI_MakeEdge(gp_Parab(axes, 2), -3, 5).Edge()}) {
    faces.push_back(BRepPrimAPI_MakePrism(edge, gp_Vec(1, 9, 0)).Shape());
    faces.push_back(BRepPrimAPI_MakeRevol(edge, gp::OZ(), 5.0).Shape());
  }
  return faces;
}

TopoDS_Shape cad_shifted_patch() {
  const Handle(Geom_ToroidalSurface) surface = new Geom_ToroidalSurface(gp::XOY(), 10, 3);
  const double turn = 2 * k_pi;
  // The hole stands one turn beside the outer loop in u and two in v.
  const TopoDS_Wire outer = rectangle_on(surface, 5, 8, -1, 2);
  const TopoDS_Wire hole = rectangle_on(surface, 6 + turn, 7 + turn, 0 - 2 * turn, 1 - 2 * turn);
  return bare_face(surface, {outer, hole.Reversed()});
}

TopoDS_Shape cad_periodic_patch() {
  const Handle(Geom_RectangularTrimmedSurface) side =
      new Geom_RectangularTrimmedSurface(new Geom_CylindricalSurface(gp::XOY(), 5), 0, 10, false);
  const Handle(Geom_BSplineSurface) surface = GeomConvert::SurfaceToBSplineSurface(side);
  surface->SetUPeriodic();
  const double period = surface->UPeriod();
  return bare_face(surface, {rectangle_on(surface, -0.2 * period, 0.3 * period, 2, 8)});
}

TopoDS_Shape cad_open_loop() {
  return plane_face({polygon({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}}, false)});
}

TopoDS_Shape cad_face_without_area() {
  return plane_face({polygon({{0, 0, 0}, {10, 0, 0}, {10, 1e-9, 0}, {0, 1e-9, 0}}, true)});
}

TopoDS_Shape cad_crossing_loop() {
  return plane_face({polygon({{0, 0, 0}, {10, 8, 0}, {10, 0, 0}, {0, 10, 0}})});
}

TopoDS_Shape cad_loop_the_wrong_way() { return plane_face({square(0, 0, 10).Reversed()}); }

TopoDS_Shape cad_endless_plane() { return plane_face({}); }

TopoDS_Shape cad_wire_of_one_vertex() {
  BRep_Builder builder;
  TopoDS_Vertex vertex;
  builder.MakeVertex(vertex, gp_Pnt(5, 5, 0), 1e-7);
  TopoDS_Edge edge;
  builder.MakeEdge(edge);
  builder.Degenerated(edge, true);
  builder.Add(edge, vertex.Oriented(TopAbs_FORWARD));
  builder.Add(edge, vertex.Oriented(TopAbs_REVERSED));
  TopoDS_Wire wire;
  builder.MakeWire(wire);
  builder.Add(wire, edge);
  return plane_face({square(0, 0, 10), wire});
}

TopoDS_Shape cad_hole_across_the_border() {
  return plane_face({square(0, 0, 10), square(5, 5, 8).Reversed()});
}

TopoDS_Shape cad_hole_outside() { return plane_face({square(0, 0, 10), square(20, 0, 5).Reversed()}); }

TopoDS_Shape cad_surface_that_is_a_line() { return flat_surface(gp_Vec(10, 4, 2)); }
TopoDS_Shape cad_surface_that_is_a_point() { return flat_surface(gp_Vec(0, 0, 0)); }

TopoDS_Shape cad_edge_without_curve() {
  BRep_Builder builder;
  TopoDS_Wire wire;
  builder.MakeWire(wire);
  const std::array<gp_Pnt, 3> corners{gp_Pnt(0, 0, 0), gp_Pnt(10, 0, 0), gp_Pnt(0, 10, 0)};
  std::array<TopoDS_Vertex, 3> vertices;
  for (std::size_t i = 0; i < 3; ++i) builder.MakeVertex(vertices[i], corners[i], 1e-7);
  for (std::size_t i = 0; i < 3; ++i) {
    const TopoDS_Vertex &from = vertices[i], &to = vertices[(i + 1) % 3];
    TopoDS_Edge edge;
    if (i < 2) {
      edge = BRepBuilderAPI_MakeEdge(from, to);
    } else {
      builder.MakeEdge(edge);
      builder.Add(edge, from.Oriented(TopAbs_FORWARD));
      builder.Add(edge, to.Oriented(TopAbs_REVERSED));
    }
    builder.Add(wire, edge);
  }
  return plane_face({wire});
}

TopoDS_Shape cad_face_without_surface() {
  BRep_Builder builder;
  TopoDS_Face face;
  builder.MakeFace(face);
  builder.Add(face, square(0, 0, 10));
  return face;
}

std::vector<CadComponent> cad_screws_on_plates(int patches) {
  const int holes = 5;
  const TopoDS_Shape plate = cad_plate(holes), screw = cad_screw();
  const auto count = [](const TopoDS_Shape& shape) {
    int faces = 0;
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) ++faces;
    return faces;
  };
  const int of_plate = count(plate), of_screw = count(screw);
  std::vector<CadComponent> components;
  for (int row = 0, reached = 0; reached < patches; ++row) {
    components.push_back({plate, "plate", {0, 50.0 * row, 0}, {0.2, 0.3, 0.8}});
    reached += of_plate;
    for (int i = 0; i < holes * holes && reached < patches; ++i) {
      const double x = 8 * (i % holes + 0.5), y = 50 * row + 8 * (i / holes + 0.5);
      components.push_back({screw, "screw", {x, y, 0}, {-1, 0, 0}});
      reached += of_screw;
    }
  }
  return components;
}

}  // namespace recede::test
