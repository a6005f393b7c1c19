// A progressive mesh as a `VertexFront` sees it.
#pragma once

#include <recede/lod/detail/linked_level.h>
#include <recede/lod/detail/refinement_bounds.h>
#include <recede/lod/vertex_hierarchy.h>

namespace recede::detail {

inline VertexHierarchy hierarchy_of(const ProgressiveMesh& mesh) {
  std::vector<VertexPair> pairs;
  pairs.reserve(mesh.splits.size());
  for (const VertexSplit& split : mesh.splits) pairs.push_back({split.removed, split.kept});
  return {mesh.positions.size(), std::move(pairs)};
}

/// Faces in no order, each with its place.
class FaceList {
 public:
  explicit FaceList(std::size_t n_faces) : place_(n_faces) {}
  const std::vector<Index>& faces() const { return faces_; }
  void add(Index face) {
    place_[face] = static_cast<Index>(faces_.size());
    faces_.push_back(face);
  }
  void remove(Index face) {
    const Index place = place_[face];
    faces_[place] = faces_.back();
    place_[faces_[place]] = place;
    faces_.pop_back();
  }

 private:
  std::vector<Index> faces_, place_;
};

class RefinedGraph {
 public:
  explicit RefinedGraph(const ProgressiveMesh& mesh)
      : mesh_(mesh), level_(mesh, LevelState(mesh)), faces_(mesh.n_faces()), bounds_(bound_hierarchy(mesh)) {
    for (Index f = 0; f < mesh.n_faces(); ++f) {
      if (level_.state().is_face_alive(f)) faces_.add(f);
    }
  }

  void apply_split(Index split) {
    level_.apply<true>(split);
    for (const Index face : level_.faces_of(split)) faces_.add(face);
  }
  void apply_merge(Index split) {
    for (const Index face : level_.faces_of(split)) faces_.remove(face);
    level_.apply<false>(split);
  }
  template <typename Visit>
  void around_split(Index split, Visit&& visit) const {
    around(mesh_.splits[split].kept, visit);
    // A face may come back to a vertex that was not beside the one that is split.
    for (const Index face : level_.faces_of(split)) {
      visit_vertices(face, [&](Index vertex) {
        if (level_.has_faces(vertex)) visit(vertex);
      });
    }
  }
  template <typename Visit>
  void around_merge(Index split, Visit&& visit) const {
    around(mesh_.splits[split].kept, visit);
    around(mesh_.splits[split].removed, visit);
    for (const Index face : level_.faces_of(split)) visit_vertices(face, visit);
  }
  bool is_ready(Index split) const {
    return bounds_.starts[split] != 0 || level_.has_faces(mesh_.splits[split].kept);
  }
  std::size_t size() const { return faces_.faces().size(); }

  const Vec3& origin() const { return bounds_.origin; }
  const RefinementBounds& bounds(Index split) const { return bounds_.splits[split]; }
  const std::vector<Index>& faces() const { return faces_.faces(); }
  const LinkedLevel& level() const { return level_; }
  const LevelState& state() const { return level_.state(); }

 private:
  template <typename Visit>
  void visit_vertices(Index face, Visit&& visit) const {
    level_.each_corner_of(face, [&](Index corner) { visit(level_.state().corner_vertices()[corner]); });
  }
  template <typename Visit>
  void around(Index vertex, Visit&& visit) const {
    if (vertex == k_no_index) return;
    level_.each_corner_at(vertex, [&](Index corner) { visit_vertices(level_.face(corner), visit); });
  }

  const ProgressiveMesh& mesh_;
  LinkedLevel level_;
  FaceList faces_;
  HierarchyBounds bounds_;
};

}  // namespace recede::detail
