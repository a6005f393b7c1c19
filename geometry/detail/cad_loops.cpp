#include <recede/geometry/detail/cad_loops.h>

#include <BRepAdaptor_Surface.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepLib.hxx>
#include <BRep_Tool.hxx>
#include <Geom2d_Line.hxx>
#include <Precision.hxx>
#include <ShapeFix_Edge.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopoDS_Wire.hxx>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>
#include <optional>

namespace recede::detail {

namespace {

/// Curves meet in the parameters when they are nearer than this share of their loop's size.
constexpr double k_same_place = 1e-6;

/// The face's edges become loops wire by wire.
class LoopFinder {
 public:
  LoopFinder(const TopoDS_Face& face, bool repair)
      : face_(face), surface_(BRep_Tool::Surface(face)), repair_(repair) {
    for (std::size_t axis = 0; axis < 2; ++axis) periods_[axis] = period_of(surface_, axis);
  }

  FaceLoops run() {
    for (TopoDS_Iterator child(face_); child.More(); child.Next()) {
      if (child.Value().ShapeType() != TopAbs_WIRE) {
        found_.left_out.emplace_back("a point inside of it bounds nothing");
        continue;
      }
      add_wire(TopoDS::Wire(child.Value()));
    }
    return std::move(found_);
  }

 private:
  void add_wire(const TopoDS_Wire& wire);
  std::optional<EdgeUse> use_of(const TopoDS_Edge& edge);
  void add_curves(EdgeUse& use);
  void chain(std::list<EdgeUse> uses);
  std::list<EdgeUse>::iterator next_of(const EdgeLoop& loop, std::list<EdgeUse>& uses) const;
  void join(EdgeLoop& loop, EdgeUse next);
  void close(EdgeLoop& loop);
  Vec2 whole_periods(const Vec2& gap) const;
  bool stays_in_place(const Vec2& from, const Vec2& to, double tolerance) const;
  static double tolerance_at(const EdgeUse& before, const EdgeUse& after);
  gp_Pnt at(const Vec2& uv) const { return surface_->Value(uv[0], uv[1]); }
  EdgeUse bridge(const EdgeUse& before, const EdgeUse& after) const;

  const TopoDS_Face& face_;
  Handle(Geom_Surface) surface_;
  bool repair_;
  std::array<double, 2> periods_{0, 0};
  double size_ = 0;  ///< of the present wire, in the parameters
  FaceLoops found_;
};

void LoopFinder::add_wire(const TopoDS_Wire& wire) {
  std::list<EdgeUse> uses;
  int inside = 0, points = 0;
  Eigen::AlignedBox2d box;
  for (TopoDS_Iterator child(wire); child.More(); child.Next()) {
    const TopAbs_Orientation orientation = child.Value().Orientation();
    if (orientation == TopAbs_INTERNAL || orientation == TopAbs_EXTERNAL) {
      ++inside;
      continue;
    }
    std::optional<EdgeUse> use = use_of(TopoDS::Edge(child.Value()));
    if (!use) {
      ++points;
      continue;
    }
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) box.extend(use->at(share));
    uses.push_back(std::move(*use));
  }
  if (inside > 0) found_.left_out.push_back(fmt::format("{} edges inside of it bound nothing", inside));
  if (points > 0) found_.left_out.push_back(fmt::format("{} of its edges are points", points));
  if (uses.empty()) return;
  size_ = box.diagonal().norm();
  chain(std::move(uses));
}

/// Nothing when the edge has neither length nor a side of the surface.
std::optional<EdgeUse> LoopFinder::use_of(const TopoDS_Edge& edge) {
  EdgeUse use;
  use.edge = edge;
  use.is_reversed = edge.Orientation() == TopAbs_REVERSED;
  use.is_point = BRep_Tool::Degenerated(edge);
  use.tolerance = BRep_Tool::Tolerance(edge);
  use.first = TopExp::FirstVertex(edge, true);
  use.last = TopExp::LastVertex(edge, true);
  add_curves(use);
  if (use.curve.IsNull()) {
    if (use.is_point) return {};
    throw CadProblem{"an edge has no curve on it"};
  }
  if (!(use.range.length() > 0) || !use.at(0).allFinite() || !use.at(1).allFinite()) {
    throw CadProblem{"an edge has no range of parameters"};
  }
  return use;
}

void LoopFinder::add_curves(EdgeUse& use) {
  use.curve = BRep_Tool::CurveOnSurface(use.edge, face_, use.range.begin, use.range.end);
  if (use.curve.IsNull() && !use.is_point && repair_) {
    const Handle(ShapeFix_Edge) fix = new ShapeFix_Edge;
    if (fix->FixAddPCurve(use.edge, face_, BRep_Tool::IsClosed(use.edge, face_))) {
      found_.repairs.emplace_back("an edge had no curve on it, and was projected");
      use.curve = BRep_Tool::CurveOnSurface(use.edge, face_, use.range.begin, use.range.end);
    }
  }
  if (use.is_point) return;
  use.space_curve = BRep_Tool::Curve(use.edge, use.space_range.begin, use.space_range.end);
  if (use.space_curve.IsNull() && !use.curve.IsNull() && BRepLib::BuildCurve3d(use.edge)) {
    use.space_curve = BRep_Tool::Curve(use.edge, use.space_range.begin, use.space_range.end);
  }
}

/// Loops of one wire: it may hold several, one after the other.
void LoopFinder::chain(std::list<EdgeUse> uses) {
  while (!uses.empty()) {
    EdgeLoop loop{std::move(uses.front())};
    uses.pop_front();
    while (!uses.empty()) {
      const auto next = next_of(loop, uses);
      const double to_next = (next->start() - loop.back().end()).norm();
      const double to_begin = (loop.front().start() - loop.back().end()).norm();
      const bool is_closed = loop.back().last.IsSame(loop.front().first) && to_begin <= k_same_place * size_;
      if (is_closed && (to_next > k_same_place * size_ || !next->first.IsSame(loop.back().last))) break;
      join(loop, std::move(*next));
      uses.erase(next);
    }
    close(loop);
    found_.loops.push_back(std::move(loop));
  }
}

/// The edge that begins nearest, among those at the same corner first.
std::list<EdgeUse>::iterator LoopFinder::next_of(const EdgeLoop& loop, std::list<EdgeUse>& uses) const {
  auto best = uses.end();
  double least = std::numeric_limits<double>::infinity();
  bool best_is_at_corner = false;
  for (auto use = uses.begin(); use != uses.end(); ++use) {
    const bool is_at_corner = !use->first.IsNull() && use->first.IsSame(loop.back().last);
    const double gap = (use->start() - loop.back().end()).norm();
    if (is_at_corner < best_is_at_corner || (is_at_corner == best_is_at_corner && gap >= least)) continue;
    best = use;
    least = gap;
    best_is_at_corner = is_at_corner;
  }
  return best == uses.end() ? uses.begin() : best;
}

Vec2 LoopFinder::whole_periods(const Vec2& gap) const {
  Vec2 shift = Vec2::Zero();
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const double period = periods_[static_cast<std::size_t>(axis)];
    if (period > 0) shift[axis] = period * std::round(gap[axis] / period);
  }
  return shift;
}

double LoopFinder::tolerance_at(const EdgeUse& before, const EdgeUse& after) {
  double tolerance = std::max(before.tolerance, after.tolerance);
  if (!before.last.IsNull()) tolerance = std::max(tolerance, BRep_Tool::Tolerance(before.last));
  if (!after.first.IsNull()) tolerance = std::max(tolerance, BRep_Tool::Tolerance(after.first));
  return 2 * tolerance;
}

bool LoopFinder::stays_in_place(const Vec2& from, const Vec2& to, double tolerance) const {
  const gp_Pnt place = at(from);
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {
    if (place.Distance(at(from + share * (to - from))) > tolerance) return false;
  }
  return true;
}

/// A straight side without length in space.
EdgeUse LoopFinder::bridge(const EdgeUse& before, const EdgeUse& after) const {
  EdgeUse use;
  const Vec2 from = before.end(), way = after.start() - from;
  use.is_point = true;
  use.curve = new Geom2d_Line(gp_Pnt2d(from[0], from[1]), gp_Dir2d(way[0], way[1]));
  use.range = {0, way.norm()};
  use.first = before.last;
  use.last = after.first;
  use.tolerance = before.tolerance;
  return use;
}

void LoopFinder::join(EdgeLoop& loop, EdgeUse next) {
  const EdgeUse& before = loop.back();
  const Vec2 gap = before.end() - next.start();
  if (gap.norm() > k_same_place * size_) {
    const double tolerance = tolerance_at(before, next);
    if (!stays_in_place(before.end(), next.start(), tolerance)) {
      next.shift += whole_periods(gap);
      if (!stays_in_place(before.end(), next.start(), tolerance)) throw CadProblem{"a loop doesn't close"};
    }
    // Corners leave some room; a side at a pole is as long as the surface.
    if ((before.end() - next.start()).norm() > 1e-3 * size_) {
      if (!repair_) throw CadProblem{"a loop lacks a side at a point of the surface"};
      found_.repairs.emplace_back("a loop got the side that it lacked at a point of the surface");
      loop.push_back(bridge(before, next));
    }
  }
  loop.push_back(std::move(next));
}

void LoopFinder::close(EdgeLoop& loop) {
  const EdgeUse &last = loop.back(), &first = loop.front();
  const Vec2 gap = first.start() - last.end();
  if (gap.norm() <= k_same_place * size_) return;
  if (!stays_in_place(last.end(), first.start(), tolerance_at(last, first))) {
    throw CadProblem{"a loop doesn't close"};
  }
  if (gap.norm() <= 1e-3 * size_) return;
  if (!repair_) throw CadProblem{"a loop lacks a side at a point of the surface"};
  found_.repairs.emplace_back("a loop got the side that it lacked at a point of the surface");
  loop.push_back(bridge(last, first));
}

bool has_wire(const TopoDS_Face& face) {
  for (TopoDS_Iterator child(face); child.More(); child.Next()) {
    if (child.Value().ShapeType() == TopAbs_WIRE) return true;
  }
  return false;
}

/// The surface's own rectangle, with seams where it closes and poles where it ends.
TopoDS_Face naturally_bounded(const TopoDS_Face& face) {
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  std::array<double, 4> bounds{};
  surface->Bounds(bounds[0], bounds[1], bounds[2], bounds[3]);
  for (const double bound : bounds) {
    if (Precision::IsInfinite(bound)) throw CadProblem{"nothing bounds it"};
  }
  BRepBuilderAPI_MakeFace maker(surface, Precision::Confusion());
  if (!maker.IsDone()) throw CadProblem{"nothing bounds it"};
  return TopoDS::Face(maker.Face().Oriented(TopAbs_FORWARD));
}

}  // namespace

FaceLoops find_loops(const TopoDS_Face& face, bool repair) {
  FaceLoops found;
  if (has_wire(face)) found = LoopFinder(face, repair).run();
  if (!found.loops.empty()) return found;
  // Wires that are points alone leave the whole surface, too.
  found.loops = LoopFinder(naturally_bounded(face), repair).run().loops;
  if (found.loops.empty()) throw CadProblem{"nothing bounds it"};
  return found;
}

}  // namespace recede::detail
