#include <recede/geometry/closest_point.h>
#include <recede/lod/detail/parts.h>
#include <recede/lod/detail/simplifier.h>

#include <algorithm>

namespace recede::detail {

double Simplifier::fraction_done(const Limits& limits) const {
  double done = 0;
  const auto share = [](std::size_t start, std::size_t now, std::size_t goal) {
    return start > goal ? static_cast<double>(start - now) / static_cast<double>(start - goal) : 1.0;
  };
  if (limits.faces > 0) done = std::max(done, share(start_faces_, table_.n_alive_faces, limits.faces));
  if (limits.vertices > 0)
    done = std::max(done, share(start_points_, table_.n_alive_points, limits.vertices));
  if (limits.faces == 0 && limits.vertices == 0) done = share(start_faces_, table_.n_alive_faces, 0);
  return std::clamp(done, 0.0, 1.0);
}

void RunCounts::add(const CollapseEffect& effect) {
  ++collapses;
  if (effect.edge_faces == 2) ++interior_collapses;
  removed_faces += effect.removed_faces;
  lost_sides += effect.lost_sides;
}

void RunCounts::add(const RunCounts& other) {
  collapses += other.collapses;
  interior_collapses += other.interior_collapses;
  removed_faces += other.removed_faces;
  lost_sides += other.lost_sides;
  passes += other.passes;
  joined += other.joined;
  dropped_parts += other.dropped_parts;
  dropped_faces += other.dropped_faces;
  error = std::max(error, other.error);
  cost += other.cost;
  for (std::size_t i = 0; i < refused.counts.size(); ++i) refused.counts[i] += other.refused.counts[i];
  log.append(other.log);
}

void Simplifier::count(const RunCounts& counts) {
  counts_.add(counts);
  table_.n_alive_faces -= counts.removed_faces;
  table_.n_alive_points -= counts.collapses;
}

void Simplifier::hold(const std::vector<Vec3>& places) {
  const std::vector<Index> triangles = fan_triangles(table_);
  if (triangles.empty()) return;
  const std::vector<Vec3> positions(table_.positions.begin(), table_.positions.end());
  const ClosestPointTree tree(positions, triangles);
  table_.held.resize(table_.n_points(), 0);
  const auto hold_around = [&](Index p) {
    table_.held[p] = 1;
    table_.each_corner(
        p, [&](Index c) { table_.held[table_.point_after(c)] = table_.held[table_.point_before(c)] = 1; });
  };
  Index near = k_no_index;
  for (const Vec3& place : places) {
    near = tree.closest((place - table_.origin) / table_.scale, near).triangle;
    for (Index i = 0; i < 3; ++i) hold_around(triangles[3 * near + i]);
  }
}

namespace {

std::vector<Index> live_source_faces(const CornerTable& table) {
  std::vector<Index> faces;
  for (Index f = 0; f < table.n_faces(); ++f) {
    if (table.is_face_alive(f)) faces.push_back(table.source_face[f]);
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

}  // namespace

bool Simplifier::drop(double most_error, const Limits& limits) {
  if (reached(limits)) return false;
  const auto enough = [&](const DroppedParts& so_far) {
    return (limits.faces > 0 && table_.n_alive_faces - so_far.faces <= limits.faces) ||
           (limits.vertices > 0 && table_.n_alive_points - so_far.points <= limits.vertices);
  };
  std::vector<Index> before;
  if (table_.is_logged()) before = live_source_faces(table_);
  const DroppedParts dropped = drop_parts(table_, std::min(most_error, limits.error), enough);
  table_.n_alive_faces -= dropped.faces;
  table_.n_alive_points -= dropped.points;
  counts_.dropped_parts += dropped.parts;
  counts_.dropped_faces += dropped.faces;
  counts_.error = std::max(counts_.error, dropped.error);
  if (table_.is_logged() && dropped.parts > 0) {
    const std::vector<Index> after = live_source_faces(table_);
    std::vector<Index> gone;
    std::set_difference(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(gone));
    counts_.log.add_drop(gone, dropped.error);
  }
  return dropped.parts > 0;
}

StopReason Simplifier::run(const Limits& limits, Progress* progress) {
  start_faces_ = table_.n_alive_faces;
  start_points_ = table_.n_alive_points;
  const auto refused_for_error = [&] { return counts_.refused[Refusal::error]; };
  report_progress(progress, "simplify", 0);
  while (!reached(limits)) {
    const std::size_t refused_before = refused_for_error();
    const std::size_t collapses = pass(limits, progress);
    // Parts go once the surface is off by as much as they would be, or when nothing else is left.
    const bool dropped = options_.drop_parts && drop(collapses > 0 ? counts_.error : limits.error, limits);
    if (collapses == 0 && !dropped) {
      return refused_for_error() > refused_before ? StopReason::error_target : StopReason::no_collapse_left;
    }
    report_progress(progress, "simplify", fraction_done(limits));
  }
  const bool by_faces = limits.faces > 0 && table_.n_alive_faces <= limits.faces;
  return by_faces ? StopReason::face_target : StopReason::vertex_target;
}

}  // namespace recede::detail
