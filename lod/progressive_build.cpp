// From the log of a simplification to a progressive mesh: sort the collapses, then carry them out once more
// on lists in the numbers of the input and note what each changes.
#include <recede/lod/detail/progressive_error.h>
#include <recede/lod/detail/progressive_source.h>
#include <recede/lod/detail/simplifier.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>

namespace recede {
namespace {

using detail::CollapseLog;
using detail::CornerTable;
using detail::ProgressiveSource;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

template <typename Vector>
bool same_bits(const Vector& a, const Vector& b) {
  return std::memcmp(a.data(), b.data(), sizeof(a)) == 0;
}

/// Rows that come last to first.
template <typename Entry>
class ReverseRows {
 public:
  void add(const Entry& entry) { entries_.push_back(entry); }
  void close_row() { ends_.push_back(static_cast<Index>(entries_.size())); }
  SplitRows<Entry> take() {
    SplitRows<Entry> rows;
    if (entries_.empty()) return rows;
    rows.start.push_back(0);
    for (std::size_t i = ends_.size(); i-- > 0;) {
      const Index first = i == 0 ? 0 : ends_[i - 1];
      rows.entries.insert(rows.entries.end(), entries_.begin() + first, entries_.begin() + ends_[i]);
      rows.start.push_back(static_cast<Index>(rows.entries.size()));
    }
    return rows;
  }

 private:
  std::vector<Entry> entries_;
  std::vector<Index> ends_;
};

class ProgressiveBuilder {
 public:
  ProgressiveBuilder(const PolygonSoup& input, const ProgressiveOptions& options)
      : options_(options.simplify), source_(input, mesh_) {
    if (options_.placement == VertexPlacement::automatic) options_.placement = VertexPlacement::half_edge;
  }

  void run(Progress* progress);
  void record();
  ProgressiveMesh take() { return std::move(mesh_); }
  const ProgressiveMesh& mesh() const { return mesh_; }
  /// For each split the faces that it touches.
  SplitRows<Index> take_touched() { return touched_.take(); }

 private:
  void sort_entries();
  template <typename Visit>
  void each_touched_face(const CollapseLog::Entry& entry, Visit&& visit) const;
  void record_collapse(const CollapseLog::Entry& entry);
  void record_lists(const CollapseLog::Entry& entry);
  bool record_vertex(const CollapseLog::Entry& entry);
  void record_wedges(const CollapseLog::Entry& entry);
  void record_features(const CollapseLog::Entry& entry);
  void finish();
  Vec3 object_position(Index vertex, const Vec3& position) const;

  SimplifyOptions options_;
  ProgressiveMesh mesh_;  // carries the level of the collapses recorded so far
  ProgressiveSource source_;
  std::unique_ptr<detail::Simplifier> simplifier_;
  Vec3 origin_ = Vec3::Zero();
  double scale_ = 1;
  std::optional<CollapseLog::Format> format_;
  std::vector<CollapseLog::Entry> entries_;
  std::vector<std::uint64_t> order_;  // deviation and entry
  std::vector<Vec3> source_positions_;
  bool moves_ = false, colors_change_ = false, scalars_change_ = false;
  ReverseRows<ProgressiveMesh::CornerWedge> corner_wedges_;
  ReverseRows<ProgressiveMesh::WedgeValue> wedge_values_;
  ReverseRows<Index> features_, touched_, items_;
};

void ProgressiveBuilder::run(Progress* progress) {
  CornerTable table = detail::build_corner_table(
      source_.soup(), {options_.keep_uv_seams, options_.keep_normal_seams, options_.lock_borders});
  source_.match(table, mesh_);
  table.source_corner.resize(table.n_corners());
  std::iota(table.source_corner.begin(), table.source_corner.end(), Index{0});
  format_.emplace(table);
  origin_ = table.origin;
  scale_ = table.scale;
  if (table.has_polygons) mesh_.corner_alive.assign(mesh_.corner_vertices.size(), 1);
  SimplifyReport& report = mesh_.report;
  report.faces_before = table.n_alive_faces;
  report.vertices_before = table.n_alive_points;
  const detail::Limits limits =
      detail::to_limits(options_.target, table.n_alive_faces, detail::diagonal_of(table), table.scale);
  simplifier_ = detail::make_simplifier(std::move(table), options_);
  report.stop_reason = simplifier_->run(limits, progress);
  fill_report(*simplifier_, report);
}

template <typename Visit>
void ProgressiveBuilder::each_touched_face(const CollapseLog::Entry& entry, Visit&& visit) const {
  for (const Index c : entry.given) visit(source_.face_of_corner(source_.corner(c)));
  for (const Index f : entry.faces) visit(source_.face(f));
  for (const Index c : entry.cut) visit(source_.face_of_corner(source_.corner(c)));
  for (const Index f : entry.around) visit(source_.face(f));
}

/// In the order of the deviations, each no less than those of the entries that touched its faces before: as
/// equal ones stay in order, so do all that share a face.
void ProgressiveBuilder::sort_entries() {
  const CollapseLog& log = simplifier_->counts().log;
  entries_.reserve(log.size());
  log.each(*format_, [&](const CollapseLog::Entry& entry) { entries_.push_back(entry); });
  std::vector<float> of_face(mesh_.n_faces(), 0);
  order_.reserve(entries_.size());
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    float deviation = static_cast<float>(std::max(0.0, entries_[i].deviation));
    each_touched_face(entries_[i], [&](Index f) { deviation = std::max(deviation, of_face[f]); });
    each_touched_face(entries_[i], [&](Index f) { of_face[f] = deviation; });
    order_.push_back(static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(deviation)) << 32 | i);
  }
  std::sort(order_.begin(), order_.end());
}

/// As in `to_soup`: what never moved has the bits of the input.
Vec3 ProgressiveBuilder::object_position(Index vertex, const Vec3& position) const {
  const Vec3& source = source_positions_[vertex];
  return (source - origin_) / scale_ == position ? source : Vec3(origin_ + scale_ * position);
}

void ProgressiveBuilder::record() {
  sort_entries();
  source_positions_ = mesh_.positions;
  std::size_t n_faces = 0;
  for (const unsigned char alive : mesh_.face_alive) n_faces += alive;
  if (!mesh_.mending.empty()) {
    mesh_.level_faces.push_back(
        static_cast<Index>(n_faces + mesh_.mending.fine_faces.size() - mesh_.mending.coarse_faces.size()));
    mesh_.level_errors.push_back(0);
  }
  mesh_.level_faces.push_back(static_cast<Index>(n_faces));
  mesh_.level_errors.push_back(0);
  mesh_.splits.reserve(order_.size());
  for (const std::uint64_t key : order_) {
    record_collapse(entries_[key & 0xffffffffu]);
    const float deviation = std::bit_cast<float>(static_cast<std::uint32_t>(key >> 32));
    mesh_.level_errors.push_back(static_cast<double>(deviation) * scale_);
  }
  finish();
}

void ProgressiveBuilder::record_collapse(const CollapseLog::Entry& entry) {
  record_lists(entry);
  const bool moves = record_vertex(entry);
  if (!mesh_.corner_wedges.empty()) record_wedges(entry);
  if (!mesh_.corner_features.empty()) record_features(entry);
  const auto touch_corners = [&](std::span<const Index> corners) {
    for (const Index c : corners) {
      touched_.add(source_.face_of_corner(source_.corner(c)));
      if (source_.has_twins() && source_.twin_corner(c) != k_no_index) {
        touched_.add(source_.face_of_corner(source_.twin_corner(c)));
      }
    }
  };
  const auto touch_faces = [&](std::span<const Index> faces) {
    for (const Index f : faces) {
      touched_.add(source_.face(f));
      if (source_.has_twins() && source_.twin_face(f) != k_no_index) touched_.add(source_.twin_face(f));
    }
  };
  touch_corners(entry.given);
  touch_faces(entry.faces);
  touch_corners(entry.cut);
  if (moves) touch_faces(entry.around);
  touched_.close_row();
  mesh_.level_faces.push_back(mesh_.level_faces.back() - mesh_.splits.back().n_faces);
}

void ProgressiveBuilder::record_lists(const CollapseLog::Entry& entry) {
  VertexSplit split{entry.removed, entry.kept};
  const auto each_corner = [&](std::span<const Index> corners, auto&& visit) {
    for (const Index c : corners) {
      visit(source_.corner(c));
      if (source_.has_twins() && source_.twin_corner(c) != k_no_index) visit(source_.twin_corner(c));
    }
  };
  each_corner(entry.given, [&](Index c) {
    items_.add(c);
    ++split.n_corners;
    mesh_.corner_vertices[c] = entry.kept;
  });
  const auto kill = [&](Index f) {
    if (mesh_.face_alive[f] == 0) return;  // a dropped part names both sides of its faces
    items_.add(f);
    ++split.n_faces;
    mesh_.face_alive[f] = 0;
  };
  for (const Index f : entry.faces) {
    kill(source_.face(f));
    if (source_.has_twins() && source_.twin_face(f) != k_no_index) kill(source_.twin_face(f));
  }
  each_corner(entry.cut, [&](Index c) {
    items_.add(c);
    mesh_.corner_alive[c] = 0;
  });
  items_.close_row();
  mesh_.splits.push_back(split);
}

/// Returns whether the kept vertex moves.
bool ProgressiveBuilder::record_vertex(const CollapseLog::Entry& entry) {
  const std::size_t n_scalars = mesh_.scalars.size();
  if (entry.kept == k_no_index) {
    mesh_.position_changes.push_back({Vec3::Zero(), Vec3::Zero()});
    if (!mesh_.colors.empty()) mesh_.color_changes.push_back({Vec4::Zero(), Vec4::Zero()});
    for (std::size_t i = n_scalars; i > 0; --i) mesh_.scalar_changes.push_back({0, 0});
    return false;
  }
  Vec3& position = mesh_.positions[entry.kept];
  const Vec3 coarse = object_position(entry.kept, entry.position);
  mesh_.position_changes.push_back({position, coarse});
  const bool moves = !same_bits(position, coarse);
  moves_ = moves_ || moves;
  position = coarse;
  if (!mesh_.colors.empty()) {
    Vec4& color = mesh_.colors[entry.kept];
    const Vec4 coarse_color(entry.colors[0], entry.colors[1], entry.colors[2], entry.colors[3]);
    mesh_.color_changes.push_back({color, coarse_color});
    colors_change_ = colors_change_ || !same_bits(color, coarse_color);
    color = coarse_color;
  }
  for (std::size_t i = 0; i < n_scalars; ++i) {
    double& value = mesh_.scalars[i].values[entry.kept];
    mesh_.scalar_changes.push_back({value, entry.scalars[i]});
    scalars_change_ = scalars_change_ ||
                      std::bit_cast<std::uint64_t>(value) != std::bit_cast<std::uint64_t>(entry.scalars[i]);
    value = entry.scalars[i];
  }
  return moves;
}

void ProgressiveBuilder::record_wedges(const CollapseLog::Entry& entry) {
  for (std::size_t i = 0; i < entry.given_wedges.size(); ++i) {
    const Index c = source_.corner(entry.given[i]), coarse = entry.given_wedges[i];
    Index& wedge = mesh_.corner_wedges[c];
    if (wedge == coarse) continue;
    corner_wedges_.add({c, wedge, coarse});
    wedge = coarse;
  }
  for (std::size_t i = 0; i < entry.wedges.size(); ++i) {
    const Index wedge = entry.wedges[i];
    const double* const values = entry.wedge_values.data() + 5 * i;
    ProgressiveMesh::WedgeValue change{wedge, {Vec2::Zero(), Vec2::Zero()}, {Vec3::Zero(), Vec3::Zero()}};
    bool differs = false;
    const auto look = [&](auto& list, auto& pair, const double* from) {
      if (list.empty()) return;
      pair.fine = list[wedge];
      for (int axis = 0; axis < pair.coarse.size(); ++axis) pair.coarse[axis] = from[axis];
      differs = differs || !same_bits(pair.fine, pair.coarse);
      list[wedge] = pair.coarse;
    };
    look(mesh_.wedge_uvs, change.uv, values);
    look(mesh_.wedge_normals, change.normal, values + 2);
    if (differs) wedge_values_.add(change);
  }
  corner_wedges_.close_row();
  wedge_values_.close_row();
}

void ProgressiveBuilder::record_features(const CollapseLog::Entry& entry) {
  for (const Index word : entry.features) {
    const Index c = source_.corner(word / 2);
    const auto flag = static_cast<unsigned char>(word % 2);
    if (mesh_.corner_features[c] == flag) continue;
    features_.add(c);
    mesh_.corner_features[c] = flag;
  }
  features_.close_row();
}

/// Turns what was recorded from fine to coarse, and leaves out lists in which nothing changes.
void ProgressiveBuilder::finish() {
  const auto reverse = [](auto& list) { std::reverse(list.begin(), list.end()); };
  reverse(mesh_.splits);
  reverse(mesh_.level_faces);
  reverse(mesh_.level_errors);
  if (!moves_) mesh_.position_changes = {};
  if (!colors_change_) mesh_.color_changes = {};
  if (!scalars_change_) mesh_.scalar_changes = {};
  reverse(mesh_.position_changes);
  reverse(mesh_.color_changes);
  reverse(mesh_.scalar_changes);
  const std::size_t n_scalars = mesh_.scalars.size();
  for (std::size_t i = 0; i < mesh_.scalar_changes.size(); i += n_scalars) {
    std::reverse(mesh_.scalar_changes.begin() + static_cast<std::ptrdiff_t>(i),
                 mesh_.scalar_changes.begin() + static_cast<std::ptrdiff_t>(i + n_scalars));
  }
  SplitRows<Index> items = items_.take();
  mesh_.items = std::move(items.entries);
  for (std::size_t i = 0; i < mesh_.splits.size() && !items.start.empty(); ++i) {
    mesh_.splits[i].first = items.start[i];
  }
  mesh_.corner_wedge_changes = corner_wedges_.take();
  mesh_.wedge_changes = wedge_values_.take();
  mesh_.feature_changes = features_.take();
}

}  // namespace

ProgressiveMesh build_progressive_mesh(const PolygonSoup& soup, const ProgressiveOptions& options,
                                       Progress* progress) {
  const auto start = Clock::now();
  detail::check(options.simplify);
  detail::check(options.simplify.target);
  validate(soup, "build_progressive_mesh");
  report_progress(progress, "prepare", 0);
  ProgressiveBuilder builder(soup, options);
  builder.run(progress);
  builder.record();
  const double seconds = seconds_since(start);
  const SplitRows<Index> touched = builder.take_touched();
  ProgressiveMesh mesh = builder.take();
  mesh.report.seconds = seconds;
  if (!options.simplify.prove_error) return mesh;
  const auto proof_start = Clock::now();
  detail::prove_level_errors(mesh, soup, touched, progress);
  mesh.report.proof_seconds = seconds_since(proof_start);
  return mesh;
}

}  // namespace recede
