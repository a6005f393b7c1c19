// What holds for every imported part, checked against OpenCASCADE's own shapes.
#pragma once

#include "cad_shapes.h"
#include "de_boor.h"
#include "temp_folder.h"
#include <recede/geometry/cad_import.h>

#include <BRepBndLib.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <ShapeAnalysis_Curve.hxx>
#include <ShapeAnalysis_Surface.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace recede::test {

/// The shape by way of a BREP file.
inline CadModel import_shape(const TopoDS_Shape& shape, const CadImportOptions& options = {}) {
  const TempFolder folder;
  write_brep(folder / "shape.brep", shape);
  return read_cad(folder / "shape.brep", options);
}

inline std::vector<TopoDS_Face> faces_of(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Face> faces;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) {
    faces.push_back(TopoDS::Face(face.Current()));
  }
  return faces;
}

/// Edges that have a curve in space.
inline std::size_t count_edges(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape edges;
  for (TopExp_Explorer edge(shape, TopAbs_EDGE); edge.More(); edge.Next()) {
    if (!BRep_Tool::Degenerated(TopoDS::Edge(edge.Current()))) edges.Add(edge.Current());
  }
  return static_cast<std::size_t>(edges.Extent());
}

inline double size_of(const TopoDS_Shape& shape) {
  Bnd_Box box;
  BRepBndLib::Add(shape, box);
  return std::sqrt(box.SquareExtent());
}

inline Vec2 point_at(const TrimmingCurve& curve, double share) {
  const ParameterRange domain = curve.curve.domain();
  return by_definition(curve.curve, share == 1 ? domain.end : domain.begin + share * domain.length());
}

inline Eigen::AlignedBox2d loops_box(const TrimmedPatch& patch) {
  Eigen::AlignedBox2d box;
  for (const TrimmingLoop& loop : patch.loops) {
    for (const TrimmingCurve& curve : loop.curves) {
      for (int i = 0; i <= 8; ++i) box.extend(point_at(curve, i / 8.0));
    }
  }
  return box;
}

/// How far places of the patch are from the face's surface: 11 x 11 over the box of its loops.
inline double distance_from_surface(const TrimmedPatch& patch, const TopoDS_Face& face) {
  ShapeAnalysis_Surface surface(BRep_Tool::Surface(face));
  const Eigen::AlignedBox2d box = loops_box(patch);
  double largest = 0;
  for (int i = 0; i <= 10; ++i) {
    for (int j = 0; j <= 10; ++j) {
      const Vec2 uv = box.min() + Vec2(i / 10.0, j / 10.0).cwiseProduct(box.sizes());
      const Vec3 place = by_definition(patch.surface, uv);
      const gp_Pnt point(place.x(), place.y(), place.z());
      surface.ValueOfUV(point, 1e-12);
      largest = std::max(largest, surface.Gap());
    }
  }
  return largest;
}

/// How far trimming curves with an edge are from the face's edges in space, in tolerances of the nearest;
/// what rounding may add is taken off.
inline double tolerances_from_edges(const TrimmedPatch& patch, const TopoDS_Face& face, double rounding) {
  double largest = 0;
  for (const TrimmingLoop& loop : patch.loops) {
    for (const TrimmingCurve& curve : loop.curves) {
      if (curve.edge == k_no_index) continue;
      for (int i = 1; i < 8; ++i) {
        const Vec2 uv = point_at(curve, i / 8.0);
        // The definition ends with the domain; import says so in a repair when a curve goes on.
        if (!patch.surface.domain(0).contains(uv[0]) || !patch.surface.domain(1).contains(uv[1])) continue;
        const Vec3 place = by_definition(patch.surface, uv);
        double nearest = std::numeric_limits<double>::infinity();
        for (TopExp_Explorer edge(face, TopAbs_EDGE); edge.More(); edge.Next()) {
          double first, last, parameter;
          const TopoDS_Edge known = TopoDS::Edge(edge.Current());
          const Handle(Geom_Curve) space = BRep_Tool::Curve(known, first, last);
          if (space.IsNull()) continue;
          gp_Pnt foot;
          const double gap = ShapeAnalysis_Curve().Project(space, gp_Pnt(place.x(), place.y(), place.z()),
                                                           1e-12, foot, parameter, first, last);
          nearest = std::min(nearest, std::max(gap - rounding, 0.0) / BRep_Tool::Tolerance(known));
        }
        largest = std::max(largest, nearest);
      }
    }
  }
  return largest;
}

/// How far curves of one edge are apart in space at equal shares, away from corners.
inline double largest_gap(const CadPart& part) {
  struct Use {
    const TrimmedPatch* patch;
    const TrimmingCurve* curve;
    // By the library: curves may leave the domain, where the definition ends.
    Vec3 at(double share) const {
      return evaluate(patch->surface, point_at(*curve, curve->runs_against ? 1 - share : share));
    }
  };
  std::vector<std::vector<Use>> uses(part.n_edges);
  for (const TrimmedPatch& patch : part.patches) {
    for (const TrimmingLoop& loop : patch.loops) {
      for (const TrimmingCurve& curve : loop.curves) {
        if (curve.edge != k_no_index) uses[curve.edge].push_back({&patch, &curve});
      }
    }
  }
  double largest = 0;
  for (const std::vector<Use>& of_edge : uses) {
    for (std::size_t i = 1; i < of_edge.size(); ++i) {
      for (int x = 1; x < 12; ++x) {
        largest = std::max(largest, (of_edge[0].at(x / 12.0) - of_edge[i].at(x / 12.0)).norm());
      }
    }
  }
  return largest;
}

inline double signed_area(const TrimmingLoop& loop) {
  std::vector<Vec2> points;
  for (const TrimmingCurve& curve : loop.curves) {
    for (int i = 0; i < 32; ++i) points.push_back(point_at(curve, i / 32.0));
  }
  double doubled = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec2 &a = points[i], &b = points[(i + 1) % points.size()];
    doubled += a[0] * b[1] - a[1] * b[0];
  }
  return doubled / 2;
}

/// Numbers, loops and curves are what their types promise.
inline void expect_well_formed(const CadModel& model) {
  for (const CadPart& part : model.parts) {
    for (const TrimmedPatch& patch : part.patches) {
      validate(patch.surface, patch.name);
      ASSERT_FALSE(patch.loops.empty()) << patch.name;
      double area = 0;
      for (const TrimmingLoop& loop : patch.loops) {
        area += signed_area(loop);
        for (std::size_t i = 0; i < loop.curves.size(); ++i) {
          const TrimmingCurve &curve = loop.curves[i], &next = loop.curves[(i + 1) % loop.curves.size()];
          validate(curve.curve, patch.name);
          EXPECT_EQ(curve.curve.points.back(), next.curve.points.front()) << patch.name << ", curve " << i;
          // Rounding of the evaluation alone.
          EXPECT_LT((point_at(curve, 1) - point_at(next, 0)).norm(), 1e-12 * (1 + point_at(next, 0).norm()));
          EXPECT_EQ(curve.corners[1], next.corners[0]) << patch.name << ", curve " << i;
          EXPECT_TRUE(curve.edge == k_no_index || curve.edge < part.n_edges);
          EXPECT_TRUE(curve.corners[0] == k_no_index || curve.corners[0] < part.n_corners);
        }
      }
      EXPECT_GT(area, 0) << patch.name << " of " << part.name;
    }
  }
  std::vector<int> placed(model.parts.size(), 0);
  for (const CadInstance& instance : model.instances) ++placed.at(instance.part);
  EXPECT_TRUE(std::all_of(placed.begin(), placed.end(), [](int n) { return n > 0; }));
}

inline std::size_t count_patches(const CadModel& model) {
  std::size_t n = 0;
  for (const CadPart& part : model.parts) n += part.patches.size();
  return n;
}

inline std::string list(const CadModel& model) {
  std::string text;
  for (const CadLeftOut& entry : model.left_out) text += entry.entity + ": " + entry.reason + "\n";
  for (const std::string& line : model.repairs) text += line + "\n";
  return text;
}

}  // namespace recede::test
