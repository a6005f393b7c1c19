#include <recede/geometry/detail/cad_patch.h>

#include <algorithm>

namespace recede::detail {

namespace {

NurbsSurface to_nurbs(const Geom_BSplineSurface& surface) {
  NurbsSurface nurbs;
  nurbs.degrees = {surface.UDegree(), surface.VDegree()};
  for (const double knot : surface.UKnotSequence()) nurbs.knots[0].push_back(knot);
  for (const double knot : surface.VKnotSequence()) nurbs.knots[1].push_back(knot);
  const bool is_rational = surface.IsURational() || surface.IsVRational();
  for (int i = 1; i <= surface.NbUPoles(); ++i) {
    for (int j = 1; j <= surface.NbVPoles(); ++j) {
      const gp_Pnt& pole = surface.Pole(i, j);
      nurbs.points.emplace_back(pole.X(), pole.Y(), pole.Z());
      if (is_rational) nurbs.weights.push_back(surface.Weight(i, j));
    }
  }
  return nurbs;
}

NurbsCurve2 to_nurbs(const Geom2d_BSplineCurve& curve) {
  NurbsCurve2 nurbs;
  nurbs.degree = curve.Degree();
  for (const double knot : curve.KnotSequence()) nurbs.knots.push_back(knot);
  for (int i = 1; i <= curve.NbPoles(); ++i) {
    const gp_Pnt2d& pole = curve.Pole(i);
    nurbs.points.emplace_back(pole.X(), pole.Y());
    if (curve.IsRational()) nurbs.weights.push_back(curve.Weight(i));
  }
  return nurbs;
}

}  // namespace

Index PartNumbers::edge(const TopoDS_Shape& shape, double tolerance) {
  const auto number = static_cast<std::size_t>(edges.Add(shape)) - 1;
  edge_tolerances.resize(std::max(edge_tolerances.size(), number + 1));
  edge_tolerances[number] = std::max(edge_tolerances[number], tolerance);
  return static_cast<Index>(number);
}

Index PartNumbers::corner(const TopoDS_Shape& shape) {
  return shape.IsNull() ? k_no_index : static_cast<Index>(corners.Add(shape) - 1);
}

TrimmedPatch to_patch(const TrimmedFace& face, const TopTools_IndexedDataMapOfShapeShape& originals,
                      PartNumbers& numbers) {
  const auto original = [&](const TopoDS_Shape& shape) {
    return originals.Contains(shape) ? originals.FindFromKey(shape) : shape;
  };
  TrimmedPatch patch;
  patch.surface = to_nurbs(*face.surface.surface);
  for (const TrimmedLoop& loop : face.loops) {
    TrimmingLoop& curves = patch.loops.emplace_back();
    for (const TrimmedUse& trimmed : loop) {
      const EdgeUse& use = trimmed.use;
      TrimmingCurve& curve = curves.curves.emplace_back();
      curve.curve = to_nurbs(*trimmed.curve);
      if (!use.is_point && trimmed.meets_edge) {
        const TopoDS_Shape edge = original(use.edge);
        curve.edge = numbers.edge(edge, use.tolerance);
        curve.runs_against = use.is_reversed;
      }
      curve.corners = {numbers.corner(original(use.first)), numbers.corner(original(use.last))};
    }
  }
  return patch;
}

}  // namespace recede::detail
