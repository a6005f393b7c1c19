#include <recede/geometry/detail/cad_face.h>
#include <recede/geometry/detail/cad_loop_checks.h>

#include <BRep_Tool.hxx>
#include <BndLib_Add2dCurve.hxx>
#include <Bnd_Box2d.hxx>
#include <TopoDS.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

namespace {

/// A NURBS surface is the file's when it is no farther away than this share of the body.
constexpr double k_exact = 1e-9;
/// Curves without an exact NURBS form, and offset surfaces, are as near as these shares of the body.
constexpr double k_fit = 1e-10, k_loosest_fit = 1e-7;
constexpr double k_surface_fit = 1e-7;
/// Curves leave their surface's domain when they do so by more than this share of it.
constexpr double k_outside = 1e-9;
/// Of a curve's domain: the piece that gives way when its end moves.
constexpr double k_moved_share = 1.0 / 64;

Eigen::AlignedBox2d box_of(const EdgeLoop& loop) {
  Eigen::AlignedBox2d box;
  for (const EdgeUse& use : loop) {
    Bnd_Box2d bounds;
    BndLib_Add2dCurve::Add(use.curve, use.range.begin, use.range.end, 0, bounds);
    double u0, v0, u1, v1;
    bounds.Get(u0, v0, u1, v1);
    box.extend(Vec2(u0, v0) + use.shift);
    box.extend(Vec2(u1, v1) + use.shift);
  }
  return box;
}

/// Loops of a periodic surface that stand whole periods beside the largest one come into its box.
void bring_together(std::vector<EdgeLoop>& loops, const Handle(Geom_Surface) & surface) {
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const EdgeLoop& loop : loops) boxes.push_back(box_of(loop));
  const auto smaller = [](const auto& a, const auto& b) { return a.volume() < b.volume(); };
  const Eigen::AlignedBox2d outer = *std::max_element(boxes.begin(), boxes.end(), smaller);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const double period = period_of(surface, axis);
    if (period == 0) continue;
    const auto a = static_cast<Eigen::Index>(axis);
    for (std::size_t i = 0; i < loops.size(); ++i) {
      const double away = outer.center()[a] - boxes[i].center()[a];
      const double outside = std::max(outer.min()[a] - boxes[i].min()[a], boxes[i].max()[a] - outer.max()[a]);
      const double shift = period * std::round(away / period);
      if (outside <= k_exact * period || shift == 0) continue;
      for (EdgeUse& use : loops[i]) use.shift[a] += shift;
    }
  }
}

std::array<ParameterRange, 2> ranges_of(const std::vector<EdgeLoop>& loops) {
  Eigen::AlignedBox2d box;
  for (const EdgeLoop& loop : loops) box.extend(box_of(loop));
  if (!(box.sizes().minCoeff() > 0)) throw CadProblem{"it has no area"};
  return {ParameterRange{box.min()[0], box.max()[0]}, ParameterRange{box.min()[1], box.max()[1]}};
}

void check_surface(const ConvertedSurface& converted, const Handle(Geom_Surface) & surface,
                   const std::array<ParameterRange, 2>& ranges, double tolerance) {
  for (int i = 1; i <= converted.surface->NbUPoles(); ++i) {
    for (int j = 1; j <= converted.surface->NbVPoles(); ++j) {
      if (!(converted.surface->Weight(i, j) > 0))
        throw CadProblem{"its surface has a weight that isn't above 0"};
    }
  }
  constexpr int k_steps = 7;
  for (int i = 0; i <= k_steps; ++i) {
    for (int j = 0; j <= k_steps; ++j) {
      const Vec2 uv{ranges[0].begin + ranges[0].length() * i / k_steps,
                    ranges[1].begin + ranges[1].length() * j / k_steps};
      const gp_Pnt wanted = surface->Value(uv[0], uv[1]);
      const Vec3 gap = converted.at(converted.to_nurbs(uv)) - Vec3(wanted.X(), wanted.Y(), wanted.Z());
      if (!(gap.norm() <= tolerance)) throw CadProblem{"its surface can't be made a NURBS"};
    }
  }
}

/// How far a curve leaves the surface's domain, as a share of that.
double share_outside(const Geom2d_BSplineCurve& curve, const Geom_BSplineSurface& surface) {
  double u0, u1, v0, v1;
  surface.Bounds(u0, u1, v0, v1);
  double outside = 0;
  constexpr int k_steps = 32;
  for (int i = 0; i <= k_steps; ++i) {
    const Vec2 uv = at_share(curve, static_cast<double>(i) / k_steps);
    outside = std::max({outside, (u0 - uv[0]) / (u1 - u0), (uv[0] - u1) / (u1 - u0), (v0 - uv[1]) / (v1 - v0),
                        (uv[1] - v1) / (v1 - v0)});
  }
  return outside;
}

TrimmedUse trim_use(const EdgeUse& use, const ConvertedSurface& surface, double size, TrimmedFace& face) {
  const double fit = std::min(std::max(k_fit * size, 0.01 * use.tolerance), k_loosest_fit * size);
  const ConvertedTrim trim = convert_trim(use, surface, fit);
  TrimmedUse trimmed{use, trim.curve};
  // Offset surfaces are off by their own tolerance already.
  const double allowed =
      k_tolerance_slack * use.tolerance + k_exact * size + (surface.is_exact ? 0 : k_surface_fit * size);
  trimmed.meets_edge = trim.distance <= allowed;
  if (!trimmed.meets_edge) {
    face.repairs.push_back(
        fmt::format("a curve stays {:.3g} away from its edge, and is on its own", trim.distance));
  } else if (trim.was_projected) {
    face.repairs.emplace_back("a curve was farther from its edge than the tolerance, and was projected");
  }
  if (const double outside = share_outside(*trim.curve, *surface.surface); outside > k_outside) {
    face.repairs.push_back(fmt::format(
        "a curve leaves its surface by {:.3g} of the parameters, and the surface goes on there", outside));
  }
  if (use.is_reversed) trimmed.curve->Reverse();
  return trimmed;
}

bool is_constant(const Geom2d_BSplineCurve& curve, int axis) {
  for (int i = 2; i <= curve.NbPoles(); ++i) {
    if (curve.Pole(i).Coord(axis) != curve.Pole(1).Coord(axis)) return false;
  }
  return true;
}

/// Moves one end of a curve. Where that is farther in space than the edge's tolerance, as corners allow, only
/// the curve's last piece takes part.
void move_end(TrimmedUse& trimmed, bool is_start, const gp_Pnt2d& to, const ConvertedSurface& surface) {
  Geom2d_BSplineCurve& curve = *trimmed.curve;
  const auto pole = [&] { return is_start ? 1 : curve.NbPoles(); };
  const gp_Pnt2d from = curve.Pole(pole());
  const double way = (surface.at({from.X(), from.Y()}) - surface.at({to.X(), to.Y()})).norm();
  if (way > trimmed.use.tolerance) {
    const double begin = curve.FirstParameter(), length = curve.LastParameter() - begin;
    const double share = is_start ? k_moved_share : 1 - k_moved_share;
    curve.InsertKnot(begin + share * length, curve.Degree(), 0);
  }
  curve.SetPole(pole(), to);
}

/// Brings the end of one curve and the start of the next to one point. Lines of constant u or v keep theirs.
void join_ends(TrimmedUse& before, TrimmedUse& after, const ConvertedSurface& surface) {
  const gp_Pnt2d end = before.curve->Pole(before.curve->NbPoles()), start = after.curve->Pole(1);
  gp_Pnt2d common;
  for (const int axis : {1, 2}) {
    double value = (end.Coord(axis) + start.Coord(axis)) / 2;
    if (is_constant(*after.curve, axis)) value = start.Coord(axis);
    if (is_constant(*before.curve, axis)) value = end.Coord(axis);
    common.SetCoord(axis, value);
  }
  move_end(before, false, common, surface);
  move_end(after, true, common, surface);
}

}  // namespace

TrimmedFace trim_face(const TopoDS_Face& original, double size, bool repair) {
  const TopoDS_Face face = TopoDS::Face(original.Oriented(TopAbs_FORWARD));
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  if (surface.IsNull()) throw CadProblem{"it has no surface"};
  FaceLoops found = find_loops(face, repair);
  bring_together(found.loops, surface);
  const std::array<ParameterRange, 2> ranges = ranges_of(found.loops);
  TrimmedFace trimmed;
  trimmed.left_out = std::move(found.left_out);
  trimmed.repairs = std::move(found.repairs);
  trimmed.surface = convert_surface(surface, ranges, k_surface_fit * size / 2);
  check_surface(trimmed.surface, surface, ranges,
                (trimmed.surface.is_exact ? k_exact : k_surface_fit) * size);
  if (!trimmed.surface.is_exact) {
    trimmed.repairs.push_back(fmt::format("its surface is a NURBS within {:.3g} only", k_surface_fit * size));
  }
  for (const EdgeLoop& loop : found.loops) {
    TrimmedLoop& curves = trimmed.loops.emplace_back();
    for (const EdgeUse& use : loop) curves.push_back(trim_use(use, trimmed.surface, size, trimmed));
    for (std::size_t i = 0; i < curves.size(); ++i) {
      join_ends(curves[i], curves[(i + 1) % curves.size()], trimmed.surface);
    }
  }
  check_loops(trimmed);
  return trimmed;
}

}  // namespace recede::detail
