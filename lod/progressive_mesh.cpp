#include <recede/geometry/error.h>
#include <recede/lod/progressive_mesh.h>

#include <fmt/format.h>

#include <algorithm>

namespace recede {

std::size_t ProgressiveMesh::level_for_faces(std::size_t faces) const {
  if (faces >= level_faces.back()) return n_splits();
  const auto above = std::upper_bound(level_faces.begin(), level_faces.end() - 1, faces);
  return above == level_faces.begin() ? 0 : static_cast<std::size_t>(above - level_faces.begin()) - 1;
}

std::size_t ProgressiveMesh::level_for_error(double error) const {
  const auto first = std::partition_point(level_errors.begin(), level_errors.end(),
                                          [&](double of_level) { return of_level > error; });
  return std::min(static_cast<std::size_t>(first - level_errors.begin()), n_splits());
}

namespace detail {

LevelState::LevelState(const ProgressiveMesh& mesh)
    : mesh_(&mesh),
      has_attribute_changes_(!mesh.color_changes.empty() || !mesh.scalar_changes.empty() ||
                             !mesh.corner_wedge_changes.entries.empty() ||
                             !mesh.wedge_changes.entries.empty() || !mesh.feature_changes.entries.empty()),
      positions_(mesh.positions),
      colors_(mesh.colors),
      scalars_(mesh.scalars),
      face_alive_(mesh.face_alive),
      corner_alive_(mesh.corner_alive),
      corner_features_(mesh.corner_features),
      corner_vertices_(mesh.corner_vertices),
      corner_wedges_(mesh.corner_wedges),
      wedge_uvs_(mesh.wedge_uvs),
      wedge_normals_(mesh.wedge_normals) {}

namespace {

template <bool refines, typename Value>
const Value& side(const Change<Value>& change) {
  return refines ? change.fine : change.coarse;
}

}  // namespace

template <bool refines>
void LevelState::apply(std::size_t number) {
  const VertexSplit& split = mesh_->splits[number];
  const auto items = mesh_->items_of(number);
  const Index* item = items.data();
  const Index vertex = refines ? split.removed : split.kept;
  for (const Index* const end = item + split.n_corners; item != end; ++item) corner_vertices_[*item] = vertex;
  for (const Index* const end = item + split.n_faces; item != end; ++item) {
    face_alive_[*item] = refines ? 1 : 0;
  }
  for (const Index* const end = items.data() + items.size(); item != end; ++item) {
    corner_alive_[*item] = refines ? 1 : 0;
  }
  if (!mesh_->position_changes.empty() && split.kept != k_no_index) {
    positions_[split.kept] = side<refines>(mesh_->position_changes[number]);
  }
  if (has_attribute_changes_) apply_attributes<refines>(number);
}

template <bool refines>
void LevelState::apply_attributes(std::size_t number) {
  const VertexSplit& split = mesh_->splits[number];
  for (const auto& change : mesh_->corner_wedge_changes[number]) {
    corner_wedges_[change.corner] = refines ? change.fine : change.coarse;
  }
  for (const auto& change : mesh_->wedge_changes[number]) {
    if (!wedge_uvs_.empty()) wedge_uvs_[change.wedge] = side<refines>(change.uv);
    if (!wedge_normals_.empty()) wedge_normals_[change.wedge] = side<refines>(change.normal);
  }
  for (const Index corner : mesh_->feature_changes[number])
    corner_features_[corner] = corner_features_[corner] == 0 ? 1 : 0;
  if (split.kept == k_no_index) return;
  if (!mesh_->color_changes.empty()) colors_[split.kept] = side<refines>(mesh_->color_changes[number]);
  if (mesh_->scalar_changes.empty()) return;
  for (std::size_t i = 0; i < scalars_.size(); ++i) {
    scalars_[i].values[split.kept] = side<refines>(mesh_->scalar_changes[number * scalars_.size() + i]);
  }
}

template <bool refines>
void LevelState::apply_mending() {
  const ProgressiveMesh::Mending& mending = mesh_->mending;
  for (const auto& change : mending.vertices) {
    corner_vertices_[change.corner] = refines ? change.fine : change.coarse;
  }
  for (const auto& change : mending.wedges) {
    corner_wedges_[change.corner] = refines ? change.fine : change.coarse;
  }
  for (const Index face : mending.fine_faces) face_alive_[face] = refines ? 1 : 0;
  for (const Index face : mending.coarse_faces) face_alive_[face] = refines ? 0 : 1;
}

template void LevelState::apply<true>(std::size_t);
template void LevelState::apply<false>(std::size_t);

void LevelState::write_face(Index face, const std::vector<Index>& number, PolygonSoup& soup) const {
  Index first = k_no_index, previous = k_no_index;
  const auto mark_feature = [&](Index corner, Index next) {
    if (corner_features_.empty() || corner_features_[corner] == 0) return;
    soup.feature_edges.emplace_back(
        std::minmax(number[corner_vertices_[corner]], number[corner_vertices_[next]]));
  };
  for (Index c = mesh_->face_offsets[face]; c < mesh_->face_offsets[face + 1]; ++c) {
    if (!is_corner_alive(c)) continue;
    soup.corner_vertices.push_back(number[corner_vertices_[c]]);
    if (!wedge_uvs_.empty()) soup.corner_uvs.push_back(wedge_uvs_[corner_wedges_[c]]);
    if (!wedge_normals_.empty()) soup.corner_normals.push_back(wedge_normals_[corner_wedges_[c]]);
    if (previous == k_no_index)
      first = c;
    else
      mark_feature(previous, c);
    previous = c;
  }
  mark_feature(previous, first);
  soup.face_offsets.push_back(static_cast<Index>(soup.corner_vertices.size()));
  if (!mesh_->face_materials.empty()) soup.face_materials.push_back(mesh_->face_materials[face]);
}

PolygonSoup LevelState::soup(bool is_input) const {
  std::vector<Index> number(positions_.size(), k_no_index);
  if (is_input) {
    std::fill(number.begin(), number.end(), 0);
  } else {
    for (Index f = 0; f < mesh_->n_faces(); ++f) {
      if (!is_face_alive(f)) continue;
      for (Index c = mesh_->face_offsets[f]; c < mesh_->face_offsets[f + 1]; ++c) {
        if (is_corner_alive(c)) number[corner_vertices_[c]] = 0;
      }
    }
  }
  PolygonSoup soup;
  for (const VertexScalar& scalar : scalars_) soup.vertex_scalars.push_back({scalar.name, {}});
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] == k_no_index) continue;
    number[v] = static_cast<Index>(soup.positions.size());
    soup.positions.push_back(positions_[v]);
    if (!colors_.empty()) soup.vertex_colors.push_back(colors_[v]);
    for (std::size_t i = 0; i < scalars_.size(); ++i) {
      soup.vertex_scalars[i].values.push_back(scalars_[i].values[v]);
    }
  }
  for (Index f = 0; f < mesh_->n_faces(); ++f) {
    if (is_face_alive(f)) write_face(f, number, soup);
  }
  if (is_input && !mesh_->feature_edges.empty()) {
    soup.feature_edges = mesh_->feature_edges;
  } else {
    std::sort(soup.feature_edges.begin(), soup.feature_edges.end());
    soup.feature_edges.erase(std::unique(soup.feature_edges.begin(), soup.feature_edges.end()),
                             soup.feature_edges.end());
  }
  soup.materials = mesh_->materials;
  return soup;
}

LevelState level_of_all_splits(const ProgressiveMesh& mesh) {
  LevelState level(mesh);
  for (std::size_t s = 0; s < mesh.splits.size(); ++s) level.apply<true>(s);
  return level;
}

}  // namespace detail

void ProgressiveCursor::move_to(std::size_t level) {
  if (level > mesh_->n_splits()) {
    throw OptionError(fmt::format("there is no level of {} splits, only up to {}", level, mesh_->n_splits()));
  }
  const std::size_t n = mesh_->splits.size();
  if (level == level_) return;
  if (level_ > n && level <= n) {
    state_.apply_mending<false>();
    --level_;
  }
  const std::size_t last = std::min(level, n);
  for (; level_ < last; ++level_) state_.apply<true>(level_);
  for (; level_ > last; --level_) state_.apply<false>(level_ - 1);
  if (level > n && level_ == n) {
    state_.apply_mending<true>();
    ++level_;
  }
}

}  // namespace recede
