// What vertices and corners carry in a `.pmesh`: values of vertices that come, of kept ones that move, wedges
// and feature edges.
#include <recede/lod/detail/pmesh_codec.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace recede::detail {
namespace {

enum Moved : std::uint8_t { k_position_moves = 1, k_color_moves = 2, k_scalars_move = 4 };

constexpr std::size_t k_most_candidates = 32;
constexpr std::uint8_t k_named = 255;  // a wedge by its number

}  // namespace

Index PmeshCodec::code_new_vertex(Index mesh_vertex, const Vec3& predicted, Index like) {
  const Index vertex = table_.add_vertex();
  positions_.emplace_back(Vec3::Zero());
  if (header_.has_colors) colors_.emplace_back(Vec4::Zero());
  scalars_.resize(scalars_.size() + header_.scalar_names.size(), 0);
  if (writes_) {
    numbers_.vertex.push_back(mesh_vertex);
    numbers_.file_vertex[mesh_vertex] = vertex;
  }
  code_vertex_values(vertex, mesh_vertex, predicted, like);
  return vertex;
}

/// Values of a vertex that comes; colours and scalars are compared with those of the vertex `like`.
void PmeshCodec::code_vertex_values(Index vertex, Index mesh_vertex, const Vec3& predicted, Index like) {
  Vec3& position = positions_[vertex];
  if (writes_) position = mesh_->positions[mesh_vertex];
  for (int axis = 0; axis < 3; ++axis) {
    number(ByteKind::positions, header_.positions, predicted[axis], position[axis]);
  }
  require(position.allFinite(), "a position isn't finite");
  if (!writes_) read_.positions.push_back(position);
  if (header_.has_colors) {
    Vec4& color = colors_[vertex];
    if (writes_) color = mesh_->colors[mesh_vertex];
    for (int i = 0; i < 4; ++i) {
      number(ByteKind::attributes, header_.colors, like == k_no_index ? 0 : colors_[like][i], color[i]);
    }
    require(color.allFinite(), "a colour isn't finite");
    if (!writes_) read_.colors.push_back(color);
  }
  const std::size_t n = header_.scalar_names.size();
  for (std::size_t i = 0; i < n; ++i) {
    double& value = scalars_[vertex * n + i];
    if (writes_) value = mesh_->scalars[i].values[mesh_vertex];
    number(ByteKind::attributes, header_.scalars, like == k_no_index ? 0 : scalars_[like * n + i], value);
    if (!writes_) read_.scalars[i].values.push_back(value);
  }
}

/// The mean of the neighbours.
Vec3 PmeshCodec::predict(Index removed) const {
  Vec3 sum = Vec3::Zero();
  double n = 0;
  table_.each_corner(removed, [&](Index corner) {
    for (const Index c : {table_.next(corner), table_.previous(corner)}) {
      if (table_.vertex(c) == removed) continue;
      sum += positions_[table_.vertex(c)];
      n += 1;
    }
  });
  return n > 0 ? Vec3(sum / n) : sum;
}

void PmeshCodec::code_kept_values(Index split, Index kept, Index removed) {
  const std::size_t n = header_.scalar_names.size();
  std::uint8_t moved = 0;
  const ProgressiveMesh* const m = mesh_;
  const auto differs = [](const auto& change) {
    return std::memcmp(&change.fine, &change.coarse, sizeof(change.fine)) != 0;
  };
  if (writes_) {
    if (!m->position_changes.empty() && differs(m->position_changes[split])) moved |= k_position_moves;
    if (!m->color_changes.empty() && differs(m->color_changes[split])) moved |= k_color_moves;
    for (std::size_t i = 0; i < n && !m->scalar_changes.empty(); ++i) {
      if (differs(m->scalar_changes[split * n + i])) moved |= k_scalars_move;
    }
  }
  byte(ByteKind::moved, moved);
  const Vec3 before = positions_[kept];
  if ((moved & k_position_moves) != 0) {
    Vec3& position = positions_[kept];
    if (writes_) position = m->position_changes[split].fine;
    for (int axis = 0; axis < 3; ++axis) {
      number(ByteKind::positions, header_.positions, 2 * before[axis] - positions_[removed][axis],
             position[axis]);
    }
    require(position.allFinite(), "a position isn't finite");
  }
  const Vec4 color_before = header_.has_colors ? colors_[kept] : Vec4(Vec4::Zero());
  if ((moved & k_color_moves) != 0 && header_.has_colors) {
    if (writes_) colors_[kept] = m->color_changes[split].fine;
    for (int i = 0; i < 4; ++i)
      number(ByteKind::attributes, header_.colors, color_before[i], colors_[kept][i]);
    require(colors_[kept].allFinite(), "a colour isn't finite");
  }
  if (!writes_) {
    read_.position_changes.push_back({positions_[kept], before});
    if (header_.has_colors) read_.color_changes.push_back({colors_[kept], color_before});
  }
  for (std::size_t i = 0; i < n; ++i) {
    double& value = scalars_[kept * n + i];
    const double value_before = value;
    if ((moved & k_scalars_move) != 0) {
      if (writes_) value = m->scalar_changes[split * n + i].fine;
      number(ByteKind::attributes, header_.scalars, value_before, value);
    }
    if (!writes_) read_.scalar_changes.push_back({value, value_before});
  }
}

void PmeshCodec::code_wedges(Index split) {
  if (writes_) {
    for (const auto& change : mesh_->corner_wedge_changes[split])
      mesh_corner_wedge_[change.corner] = change.fine;
  } else {
    read_.corner_wedge_changes.start.push_back(static_cast<Index>(read_.corner_wedge_changes.entries.size()));
    read_.wedge_changes.start.push_back(static_cast<Index>(read_.wedge_changes.entries.size()));
  }
  for (const Index corner : given_) {
    const Index coarse = corner_wedge_[corner];
    code_wedge(corner, true);
    if (!writes_) {
      if (corner_wedge_[corner] != coarse)
        read_.corner_wedge_changes.entries.push_back({corner, corner_wedge_[corner], coarse});
    }
  }
  for (const Index corner : created_) code_wedge(corner, false);
  Index n = 0;
  if (writes_) n = static_cast<Index>(mesh_->wedge_changes[split].size());
  varint(ByteKind::counts, n);
  for (Index i = 0; i < n; ++i) {
    Index wedge = 0, mesh_wedge = k_no_index;
    if (writes_) {
      mesh_wedge = mesh_->wedge_changes[split][i].wedge;
      wedge = numbers_.file_wedge[mesh_wedge];
    }
    varint(ByteKind::vertices, wedge);
    const std::size_t n_wedges = std::max(wedge_uv_.size(), wedge_normal_.size());
    require(wedge < n_wedges, "a change of attributes that aren't there");
    ProgressiveMesh::WedgeValue change{wedge, {Vec2::Zero(), Vec2::Zero()}, {Vec3::Zero(), Vec3::Zero()}};
    if (header_.has_uvs) change.uv.coarse = wedge_uv_[wedge];
    if (header_.has_normals) change.normal.coarse = wedge_normal_[wedge];
    if (writes_) {
      change.uv.fine = mesh_->wedge_changes[split][i].uv.fine;
      change.normal.fine = mesh_->wedge_changes[split][i].normal.fine;
    }
    for (int k = 0; k < 2 && header_.has_uvs; ++k)
      number(ByteKind::attributes, header_.uvs, change.uv.coarse[k], change.uv.fine[k]);
    for (int k = 0; k < 3 && header_.has_normals; ++k)
      number(ByteKind::attributes, header_.normals, change.normal.coarse[k], change.normal.fine[k]);
    require(change.uv.fine.allFinite() && change.normal.fine.allFinite(), "an attribute isn't finite");
    if (header_.has_uvs) wedge_uv_[wedge] = change.uv.fine;
    if (header_.has_normals) wedge_normal_[wedge] = change.normal.fine;
    if (!writes_) read_.wedge_changes.entries.push_back(change);
  }
}

/// Which wedge a corner has: its own, one of another corner there, a new one, or any by its number.
void PmeshCodec::code_wedge(Index corner, bool is_given) {
  std::array<Index, k_most_candidates> candidates{};
  std::size_t n = 0;
  const auto add = [&](Index wedge) {
    if (wedge == k_no_index || n == candidates.size()) return;
    if (std::find(candidates.begin(), candidates.begin() + n, wedge) == candidates.begin() + n)
      candidates[n++] = wedge;
  };
  add(corner_wedge_[corner]);
  table_.each_corner(table_.vertex(corner), [&](Index c) { add(corner_wedge_[c]); });
  const std::size_t n_wedges = std::max(wedge_uv_.size(), wedge_normal_.size());
  std::uint8_t place = 0;  // 0: new
  Index mesh_wedge = k_no_index, wedge = k_no_index;
  if (writes_) {
    mesh_wedge = mesh_corner_wedge_[numbers_.corner[corner]];
    wedge = numbers_.file_wedge[mesh_wedge];
    const auto found = std::find(candidates.begin(), candidates.begin() + n, wedge);
    if (wedge != k_no_index) {
      place = found != candidates.begin() + n ? static_cast<std::uint8_t>(found - candidates.begin() + 1)
                                              : k_named;
    }
  }
  byte(ByteKind::wedges, place);
  if (place == 0) {
    wedge = static_cast<Index>(n_wedges);
    if (header_.has_uvs) wedge_uv_.emplace_back(Vec2::Zero());
    if (header_.has_normals) wedge_normal_.emplace_back(Vec3::Zero());
    if (writes_) numbers_.file_wedge[mesh_wedge] = wedge;
    code_wedge_values(wedge, mesh_wedge, n > 0 ? candidates[0] : k_no_index);
  } else if (place == k_named) {
    varint(ByteKind::vertices, wedge);
    require(wedge < n_wedges, "a corner names attributes that aren't there");
  } else {
    require(place <= n, "a corner names attributes that aren't there");
    wedge = candidates[place - 1];
  }
  corner_wedge_[corner] = wedge;
  if (!writes_) {
    if (!is_given) first_wedge_[corner] = wedge;
  }
}

void PmeshCodec::code_wedge_values(Index wedge, Index mesh_wedge, Index like) {
  if (header_.has_uvs) {
    Vec2& uv = wedge_uv_[wedge];
    if (writes_) uv = mesh_->wedge_uvs[mesh_wedge];
    for (int k = 0; k < 2; ++k) {
      number(ByteKind::attributes, header_.uvs, like == k_no_index ? 0 : wedge_uv_[like][k], uv[k]);
    }
    require(uv.allFinite(), "a texture coordinate isn't finite");
    if (!writes_) read_.wedge_uvs.push_back(uv);
  }
  if (!header_.has_normals) return;
  Vec3& normal = wedge_normal_[wedge];
  if (writes_) normal = mesh_->wedge_normals[mesh_wedge];
  for (int k = 0; k < 3; ++k) {
    number(ByteKind::attributes, header_.normals, like == k_no_index ? 0 : wedge_normal_[like][k], normal[k]);
  }
  require(normal.allFinite(), "a normal isn't finite");
  if (!writes_) read_.wedge_normals.push_back(normal);
}

void PmeshCodec::code_features(Index split, bool has_changes) {
  if (!header_.has_features) return;
  for (const Index corner : created_) {
    std::uint8_t flag = 0;
    if (writes_) flag = mesh_->corner_features[numbers_.corner[corner]];
    byte(ByteKind::flags, flag);
    if (!writes_) read_.corner_features[corner] = flag != 0 ? 1 : 0;
  }
  if (!has_changes) return;
  Index n = 0;
  if (writes_) n = static_cast<Index>(mesh_->feature_changes[split].size());
  varint(ByteKind::counts, n);
  if (!writes_) {
    read_.feature_changes.start.push_back(static_cast<Index>(read_.feature_changes.entries.size()));
  }
  for (Index i = 0; i < n; ++i) {
    Index corner = 0;
    if (writes_) corner = numbers_.file_corner[mesh_->feature_changes[split][i]];
    varint(ByteKind::vertices, corner);
    require(corner < table_.n_corners(), "a feature edge names a corner that isn't there");
    if (!writes_) read_.feature_changes.entries.push_back(corner);
  }
}

}  // namespace recede::detail
