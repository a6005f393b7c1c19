// Shapes that OpenCASCADE makes, good ones and bad ones, and files of them. Lengths are millimetres.
#pragma once

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_SequenceOfPrinters.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace recede::test {

// Solids.
TopoDS_Shape cad_box(double x = 30, double y = 20, double z = 10);
/// A box with all edges rounded.
TopoDS_Shape cad_rounded_box(double radius = 2);
TopoDS_Shape cad_cylinder(double radius = 5, double height = 12);
TopoDS_Shape cad_sphere(double radius = 10);
/// A sphere with a bore from each of the six sides.
TopoDS_Shape cad_bored_sphere();
TopoDS_Shape cad_torus(double major = 10, double minor = 3);
/// With its tip.
TopoDS_Shape cad_cone(double radius = 5, double height = 12);
/// A block under a wavy B-spline surface, with 16 holes.
TopoDS_Shape cad_wavy_block();
/// A prism over a regular polygon.
TopoDS_Shape cad_prism(int sides);
/// A plate with holes on a grid: 6 + holes x holes patches.
TopoDS_Shape cad_plate(int holes);
/// A screw: head, shaft and tip, 6 patches.
TopoDS_Shape cad_screw();

// Shapes that aren't solids.
/// Three squares at one edge.
TopoDS_Shape cad_three_faces_at_an_edge();
/// The same square twice.
TopoDS_Shape cad_duplicate_faces();
/// A square face without wires, of a bounded surface.
TopoDS_Shape cad_face_without_wires();
/// The whole sphere as one face without wires.
TopoDS_Shape cad_sphere_without_wires();
/// A cylinder's side between two circles, without the seam that its loops need.
TopoDS_Shape cad_tube_without_seam();
/// A square with a free edge and a slit inside.
TopoDS_Shape cad_square_with_inner_edge();
/// Two squares beside each other, as one face with two outer wires.
TopoDS_Shape cad_two_islands();
/// A bounded offset of a wavy B-spline surface.
TopoDS_Shape cad_offset_face();
/// Pieces of an ellipse, a hyperbola and a parabola, pulled straight and turned by most of a circle.
std::vector<TopoDS_Shape> cad_swept_faces();
/// A piece of a torus whose loop was moved by whole turns.
TopoDS_Shape cad_shifted_patch();
/// A patch of a periodic B-spline surface across the parameter where it starts.
TopoDS_Shape cad_periodic_patch();

// Faces that can't be used as they are.
TopoDS_Shape cad_open_loop();
TopoDS_Shape cad_face_without_area();
TopoDS_Shape cad_crossing_loop();
TopoDS_Shape cad_loop_the_wrong_way();
/// A plane without bounds.
TopoDS_Shape cad_endless_plane();
/// A face with a wire that is one vertex, beside its outer one.
TopoDS_Shape cad_wire_of_one_vertex();

/// A hole that reaches over the outer loop.
TopoDS_Shape cad_hole_across_the_border();
/// A hole beside the outer loop.
TopoDS_Shape cad_hole_outside();
/// A whole B-spline surface of which all control points are on a line, or all are one point.
TopoDS_Shape cad_surface_that_is_a_line();
TopoDS_Shape cad_surface_that_is_a_point();
/// A loop of edges of which one has no curve at all.
TopoDS_Shape cad_edge_without_curve();
/// A loop without a surface.
TopoDS_Shape cad_face_without_surface();

/// Faces of shapes side by side.
TopoDS_Shape cad_compound(const std::vector<TopoDS_Shape>& shapes);

/// What an assembly is made of.
struct CadComponent {
  TopoDS_Shape shape;  ///< the same shape again is one more instance
  std::string name;
  std::array<double, 3> at{0, 0, 0};
  std::array<double, 3> color{-1, 0, 0};  ///< linear; below 0: none
};
/// Plates with screws in rows, all plates and all screws of one shape each, until `patches` are reached.
std::vector<CadComponent> cad_screws_on_plates(int patches);

/// OpenCASCADE prints nothing while it is there.
class Silence {
 public:
  Silence() : printers_(Message::DefaultMessenger()->Printers()) {
    Message::DefaultMessenger()->ChangePrinters().Clear();
  }
  ~Silence() { Message::DefaultMessenger()->ChangePrinters() = printers_; }

 private:
  Message_SequenceOfPrinters printers_;
};

// Files. Nothing is printed.
void write_brep(const std::filesystem::path& path, const TopoDS_Shape& shape);
/// `unit` as OpenCASCADE names it: MM, M, KM, UM, INCH.
void write_step(const std::filesystem::path& path, const TopoDS_Shape& shape, const std::string& unit = "MM");
void write_iges(const std::filesystem::path& path, const TopoDS_Shape& shape);
/// A STEP file of an assembly. The first face of shapes that are in `painted` is red.
void write_step_assembly(const std::filesystem::path& path, const std::vector<CadComponent>& components,
                         const std::vector<TopoDS_Shape>& painted = {});

}  // namespace recede::test
