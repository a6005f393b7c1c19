#include <recede/geometry/disjoint_sets.h>
#include <recede/geometry/error.h>
#include <recede/lod/geomorph.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace recede {
namespace {

using detail::LevelState;

/// Visits the faces of a level and their corners, in the order of its soup.
template <typename Visit>
void each_corner(const ProgressiveMesh& mesh, const LevelState& level, Visit&& visit) {
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    if (!level.is_face_alive(f)) continue;
    for (Index c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
      if (level.is_corner_alive(c)) visit(f, c);
    }
  }
}

/// By vertex of the progressive mesh: its number in the soup of a level, or k_no_index without faces.
/// `is_input`: the soup has vertices without faces too.
std::vector<Index> numbers_in_soup(const ProgressiveMesh& mesh, const LevelState& level, bool is_input) {
  std::vector<Index> numbers(mesh.positions.size(), k_no_index);
  each_corner(mesh, level, [&](Index, Index corner) { numbers[level.corner_vertices()[corner]] = 0; });
  Index n = 0;
  for (Index v = 0; v < numbers.size(); ++v) {
    if (numbers[v] != k_no_index) numbers[v] = is_input ? v : n++;
  }
  return numbers;
}

class GeomorphBuilder {
 public:
  GeomorphBuilder(const ProgressiveMesh& mesh, std::size_t coarse_level, std::size_t fine_level)
      : mesh_(mesh), coarse_(mesh), fine_(mesh) {
    coarse_.move_to(coarse_level);
    fine_.move_to(fine_level);
    morph_ = {coarse_level, fine_level, fine_.soup(), {}, {}};
    morph_.coarse = morph_.fine;
  }
  Geomorph build() {
    find_ancestors();
    move_vertices();
    shrink_parts();
    move_corners();
    return std::move(morph_);
  }

 private:
  void find_ancestors();
  void match_mended();
  void move_vertices();
  void shrink_parts();
  void move_corners();
  Index coarse_corner(Index face, Index corner) const;

  const ProgressiveMesh& mesh_;
  ProgressiveCursor coarse_, fine_;
  Geomorph morph_;
  std::vector<Index> ancestor_;  // by vertex of the mesh: what it becomes, whether that has faces or not
};

void GeomorphBuilder::find_ancestors() {
  ancestor_.resize(mesh_.positions.size());
  std::iota(ancestor_.begin(), ancestor_.end(), Index{0});
  for (std::size_t s = coarse_.level(); s < std::min(fine_.level(), mesh_.splits.size()); ++s) {
    const VertexSplit& split = mesh_.splits[s];
    if (split.kept != k_no_index) ancestor_[split.removed] = ancestor_[split.kept];
  }
  if (fine_.level() > mesh_.splits.size() && coarse_.level() <= mesh_.splits.size()) match_mended();
}

/// The input may have several vertices where its levels have one.
void GeomorphBuilder::match_mended() {
  const auto place = [&](Index v) {
    const Vec3& p = fine_.positions()[v];
    return std::array{p.x() + 0.0, p.y() + 0.0, p.z() + 0.0};  // -0 becomes 0
  };
  const std::vector<Index> has_faces = numbers_in_soup(mesh_, detail::level_of_all_splits(mesh_), false);
  std::map<std::array<double, 3>, Index> known;
  for (Index v = 0; v < ancestor_.size(); ++v) {
    if (has_faces[v] != k_no_index) known.emplace(place(v), v);
  }
  for (Index v = 0; v < ancestor_.size(); ++v) {
    const auto found = known.find(place(v));
    if (found != known.end()) ancestor_[v] = ancestor_[found->second];
  }
}

void GeomorphBuilder::move_vertices() {
  const auto numbers_at = [&](const ProgressiveCursor& cursor) {
    return numbers_in_soup(mesh_, cursor.state(), cursor.level() == mesh_.n_splits());
  };
  const std::vector<Index> numbers = numbers_at(coarse_), in_fine = numbers_at(fine_);
  PolygonSoup& coarse = morph_.coarse;
  morph_.parents.assign(coarse.positions.size(), k_no_index);
  for (Index v = 0; v < ancestor_.size(); ++v) {
    if (in_fine[v] == k_no_index) continue;
    const Index i = in_fine[v], from = ancestor_[v];
    morph_.parents[i] = numbers[from];
    if (numbers[from] == k_no_index) continue;
    coarse.positions[i] = coarse_.positions()[from];
    if (!coarse.vertex_colors.empty()) coarse.vertex_colors[i] = coarse_.state().colors()[from];
    for (std::size_t s = 0; s < coarse.vertex_scalars.size(); ++s) {
      coarse.vertex_scalars[s].values[i] = coarse_.state().scalars()[s].values[from];
    }
  }
}

/// Connected parts without parents become points.
void GeomorphBuilder::shrink_parts() {
  PolygonSoup& coarse = morph_.coarse;
  DisjointSets parts(coarse.positions.size());
  for (std::size_t f = 0; f < coarse.n_faces(); ++f) {
    for (const Index v : coarse.face(f)) {
      if (morph_.parents[v] == k_no_index) parts.unite(coarse.face(f)[0], v);
    }
  }
  std::map<Index, Box3> boxes;
  for (const Index v : coarse.corner_vertices) {
    if (morph_.parents[v] == k_no_index) boxes[parts.find(v)].extend(coarse.positions[v]);
  }
  for (Index v = 0; v < coarse.positions.size(); ++v) {
    if (morph_.parents[v] != k_no_index) continue;
    const auto box = boxes.find(parts.find(v));
    if (box != boxes.end()) coarse.positions[v] = box->second.center();
  }
}

/// The corner of the coarse level that a corner of the fine one becomes; k_no_index where its polygon
/// vanishes.
Index GeomorphBuilder::coarse_corner(Index face, Index corner) const {
  const LevelState& level = coarse_.state();
  if (!level.is_face_alive(face)) return k_no_index;
  if (level.is_corner_alive(corner)) return corner;
  const Index vertex = ancestor_[fine_.corner_vertices()[corner]];
  for (Index c = mesh_.face_offsets[face]; c < mesh_.face_offsets[face + 1]; ++c) {
    if (level.is_corner_alive(c) && level.corner_vertices()[c] == vertex) return c;
  }
  return k_no_index;
}

void GeomorphBuilder::move_corners() {
  PolygonSoup& coarse = morph_.coarse;
  if (coarse.corner_uvs.empty() && coarse.corner_normals.empty()) return;
  std::size_t i = 0;
  each_corner(mesh_, fine_.state(), [&](Index face, Index corner) {
    const Index from = coarse_corner(face, corner);
    if (from != k_no_index) {
      if (!coarse.corner_uvs.empty()) coarse.corner_uvs[i] = coarse_.state().uv(from);
      if (!coarse.corner_normals.empty()) coarse.corner_normals[i] = coarse_.state().normal(from);
    }
    ++i;
  });
}

}  // namespace

PolygonSoup Geomorph::at(double share) const {
  if (!(share >= 0 && share <= 1)) throw OptionError("the share of a geomorph must lie between 0 and 1");
  if (share == 0) return coarse;
  if (share == 1) return fine;
  PolygonSoup result = fine;
  const auto blend = [&](auto& list, const auto& from) {
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = (1 - share) * from[i] + share * list[i];
  };
  blend(result.positions, coarse.positions);
  blend(result.corner_uvs, coarse.corner_uvs);
  blend(result.corner_normals, coarse.corner_normals);
  blend(result.vertex_colors, coarse.vertex_colors);
  for (std::size_t i = 0; i < result.vertex_scalars.size(); ++i) {
    blend(result.vertex_scalars[i].values, coarse.vertex_scalars[i].values);
  }
  for (Vec3& normal : result.corner_normals) {
    const double length = normal.norm();
    if (length > 0) normal /= length;
  }
  return result;
}

Geomorph make_geomorph(const ProgressiveMesh& mesh, std::size_t coarse_level, std::size_t fine_level) {
  if (coarse_level > fine_level) {
    throw OptionError(fmt::format("the coarse level of a geomorph has {} splits and the fine one only {}",
                                  coarse_level, fine_level));
  }
  return GeomorphBuilder(mesh, coarse_level, fine_level).build();
}

}  // namespace recede
