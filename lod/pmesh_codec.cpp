#include <recede/lod/detail/pmesh_codec.h>

#include <algorithm>
#include <bit>
#include <limits>

namespace recede::detail {
namespace {

/// Bits of the shape of a split; none: labels follow.
enum Shape : std::uint8_t { k_run = 1, k_triangle_first = 2, k_triangle_last = 4, k_part = 8 };
/// What becomes of a corner at the kept vertex.
enum Label : std::uint8_t { k_stays, k_given, k_added_before, k_added_after };
enum Moved : std::uint8_t { k_position_moves = 1, k_color_moves = 2, k_scalars_move = 4 };

constexpr std::size_t k_most_candidates = 32;
constexpr std::uint8_t k_named = 255;  // a wedge by its number

/// Errors are held as floats of which the last bits are zero, and never below what they are.
constexpr std::uint32_t k_error_bits = 0xfff;

std::uint32_t error_bits(double error) {
  auto result = static_cast<float>(error);
  if (static_cast<double>(result) < error)
    result = std::nextafter(result, std::numeric_limits<float>::infinity());
  return (std::bit_cast<std::uint32_t>(result) + k_error_bits) & ~k_error_bits;
}

}  // namespace

template <bool writes>
void PmeshCodec<writes>::byte(ByteKind kind, std::uint8_t& value) {
  if constexpr (writes)
    streams_->put(kind, value);
  else
    value = streams_->take(kind);
}

template <bool writes>
template <typename Number>
void PmeshCodec<writes>::varint(ByteKind kind, Number& value) {
  if constexpr (writes) {
    streams_->put_varint(kind, value);
  } else {
    const std::uint64_t taken = streams_->take_varint(kind);
    require(taken <= std::numeric_limits<Number>::max(), "a number is too large");
    value = static_cast<Number>(taken);
  }
}

template <bool writes>
void PmeshCodec<writes>::planes(ByteKind kind, std::uint64_t& value, std::size_t n) {
  if constexpr (writes)
    streams_->put_planes(kind, value, n);
  else
    value = streams_->take_planes(kind, n);
}

/// The value becomes what the lattice makes of it.
template <bool writes>
void PmeshCodec<writes>::number(ByteKind kind, const NumberLattice& lattice, double predicted,
                                double& value) {
  const auto guess = static_cast<std::uint64_t>(lattice.to_integer(predicted));
  std::uint64_t residual = 0;
  if constexpr (writes)
    residual =
        zigzag(static_cast<std::int64_t>(static_cast<std::uint64_t>(lattice.to_integer(value)) - guess));
  planes(kind, residual, 8);
  const auto integer = static_cast<std::int64_t>(guess + static_cast<std::uint64_t>(unzigzag(residual)));
  require(lattice.form != NumberLattice::Form::quantised || (integer >= 0 && integer <= lattice.most),
          "a quantised number is out of range");
  require(
      lattice.form != NumberLattice::Form::floats || (integer >= std::numeric_limits<std::int32_t>::min() &&
                                                      integer <= std::numeric_limits<std::int32_t>::max()),
      "a number is out of range");
  value = lattice.to_value(integer);
}

template <bool writes>
void PmeshCodec<writes>::start(const ProgressiveMesh& mesh) {
  mesh_ = &mesh;
  numbers_.file_vertex.assign(mesh.positions.size(), k_no_index);
  numbers_.file_face.assign(mesh.n_faces(), k_no_index);
  numbers_.file_corner.assign(mesh.corner_vertices.size(), k_no_index);
  numbers_.file_wedge.assign(std::max(mesh.wedge_uvs.size(), mesh.wedge_normals.size()), k_no_index);
  mesh_corner_alive_ = mesh.corner_alive;
  mesh_corner_alive_.resize(mesh.corner_vertices.size(), 1);
  mesh_corner_wedge_ = mesh.corner_wedges;
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    mesh_corner_face_.insert(mesh_corner_face_.end(), mesh.face_offsets[f + 1] - mesh.face_offsets[f], f);
  }
  is_given_.assign(mesh.corner_vertices.size(), 0);
}

template <bool writes>
std::vector<Index> PmeshCodec<writes>::alive_corners(Index mesh_face) const {
  std::vector<Index> corners;
  for (Index c = mesh_->face_offsets[mesh_face]; c < mesh_->face_offsets[mesh_face + 1]; ++c) {
    if (mesh_corner_alive_[c] != 0) corners.push_back(c);
  }
  return corners;
}

template <bool writes>
void PmeshCodec<writes>::note_corner(Index corner, Index mesh_corner) {
  corner_wedge_.push_back(k_no_index);
  corner_feature_.push_back(0);
  created_.push_back(corner);
  if constexpr (writes) {
    numbers_.corner.push_back(mesh_corner);
    numbers_.file_corner[mesh_corner] = corner;
  } else {
    first_vertex_.push_back(table_.vertex(corner));
    first_wedge_.push_back(k_no_index);
    if (header_.has_features) read_.corner_features.push_back(0);
  }
}

// Vertices.

template <bool writes>
Index PmeshCodec<writes>::code_new_vertex(Index mesh_vertex, const Vec3& predicted, Index like) {
  const Index vertex = table_.add_vertex();
  positions_.emplace_back(Vec3::Zero());
  if (header_.has_colors) colors_.emplace_back(Vec4::Zero());
  scalars_.resize(scalars_.size() + header_.scalar_names.size(), 0);
  if constexpr (writes) {
    numbers_.vertex.push_back(mesh_vertex);
    numbers_.file_vertex[mesh_vertex] = vertex;
  }
  code_vertex_values(vertex, mesh_vertex, predicted, like);
  return vertex;
}

/// Values of a vertex that comes; colours and scalars are compared with those of the vertex `like`.
template <bool writes>
void PmeshCodec<writes>::code_vertex_values(Index vertex, Index mesh_vertex, const Vec3& predicted,
                                            Index like) {
  Vec3& position = positions_[vertex];
  if constexpr (writes) position = mesh_->positions[mesh_vertex];
  for (int axis = 0; axis < 3; ++axis) {
    number(ByteKind::positions, header_.positions, predicted[axis], position[axis]);
  }
  require(position.allFinite(), "a position isn't finite");
  if constexpr (!writes) read_.positions.push_back(position);
  if (header_.has_colors) {
    Vec4& color = colors_[vertex];
    if constexpr (writes) color = mesh_->colors[mesh_vertex];
    for (int i = 0; i < 4; ++i) {
      number(ByteKind::attributes, header_.colors, like == k_no_index ? 0 : colors_[like][i], color[i]);
    }
    require(color.allFinite(), "a colour isn't finite");
    if constexpr (!writes) read_.colors.push_back(color);
  }
  const std::size_t n = header_.scalar_names.size();
  for (std::size_t i = 0; i < n; ++i) {
    double& value = scalars_[vertex * n + i];
    if constexpr (writes) value = mesh_->scalars[i].values[mesh_vertex];
    number(ByteKind::attributes, header_.scalars, like == k_no_index ? 0 : scalars_[like * n + i], value);
    if constexpr (!writes) read_.scalars[i].values.push_back(value);
  }
}

/// The mean of the neighbours.
template <bool writes>
Vec3 PmeshCodec<writes>::predict(Index removed) const {
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

template <bool writes>
void PmeshCodec<writes>::code_kept_values(Index split, Index kept, Index removed) {
  const std::size_t n = header_.scalar_names.size();
  std::uint8_t moved = 0;
  const ProgressiveMesh* const m = mesh_;
  const auto differs = [](const auto& change) { return !(change.fine == change.coarse); };
  if constexpr (writes) {
    if (!m->position_changes.empty() && differs(m->position_changes[split])) moved |= k_position_moves;
    if (!m->color_changes.empty() && differs(m->color_changes[split])) moved |= k_color_moves;
    for (std::size_t i = 0; i < n && !m->scalar_changes.empty(); ++i) {
      const auto& change = m->scalar_changes[split * n + i];
      if (std::bit_cast<std::uint64_t>(change.fine) != std::bit_cast<std::uint64_t>(change.coarse))
        moved |= k_scalars_move;
    }
  }
  byte(ByteKind::moved, moved);
  const Vec3 before = positions_[kept];
  if ((moved & k_position_moves) != 0) {
    Vec3& position = positions_[kept];
    if constexpr (writes) position = m->position_changes[split].fine;
    for (int axis = 0; axis < 3; ++axis) {
      number(ByteKind::positions, header_.positions, 2 * before[axis] - positions_[removed][axis],
             position[axis]);
    }
    require(position.allFinite(), "a position isn't finite");
  }
  const Vec4 color_before = header_.has_colors ? colors_[kept] : Vec4(Vec4::Zero());
  if ((moved & k_color_moves) != 0 && header_.has_colors) {
    if constexpr (writes) colors_[kept] = m->color_changes[split].fine;
    for (int i = 0; i < 4; ++i)
      number(ByteKind::attributes, header_.colors, color_before[i], colors_[kept][i]);
    require(colors_[kept].allFinite(), "a colour isn't finite");
  }
  if constexpr (!writes) {
    read_.position_changes.push_back({positions_[kept], before});
    if (header_.has_colors) read_.color_changes.push_back({colors_[kept], color_before});
  }
  for (std::size_t i = 0; i < n; ++i) {
    double& value = scalars_[kept * n + i];
    const double value_before = value;
    if ((moved & k_scalars_move) != 0) {
      if constexpr (writes) value = m->scalar_changes[split * n + i].fine;
      number(ByteKind::attributes, header_.scalars, value_before, value);
    }
    if constexpr (!writes) read_.scalar_changes.push_back({value, value_before});
  }
}

// Faces and splits.

/// Faces that don't come by triangles beside a new vertex: those of the base, and of parts.
template <bool writes>
void PmeshCodec<writes>::code_faces(const std::vector<Index>& mesh_faces) {
  auto n_faces = static_cast<Index>(mesh_faces.size());
  varint(ByteKind::counts, n_faces);
  std::vector<Index> vertices, corners;
  Index last = k_no_index;  // the vertex before
  for (Index i = 0; i < n_faces; ++i) {
    if constexpr (writes) corners = alive_corners(mesh_faces[i]);
    auto size = static_cast<Index>(corners.size());
    varint(ByteKind::counts, size);
    require(size >= 3, "a face has fewer than three corners");
    vertices.clear();
    for (Index k = 0; k < size; ++k) {
      const auto n = static_cast<Index>(table_.n_vertices());
      Index mesh_vertex = k_no_index, back = 0;
      if constexpr (writes) {
        mesh_vertex = mesh_->corner_vertices[corners[k]];
        const Index known = numbers_.file_vertex[mesh_vertex];
        back = known == k_no_index ? 0 : n - known;
      }
      varint(ByteKind::vertices, back);
      require(back <= n, "a face names a vertex that isn't there");
      last = back > 0 ? n - back
                      : code_new_vertex(mesh_vertex,
                                        last == k_no_index ? Vec3(Vec3::Zero()) : positions_[last], last);
      vertices.push_back(last);
    }
    const Index face = table_.add_face(vertices);
    if (header_.has_face_materials) {
      Index material = 0;  // one more than its position
      if constexpr (writes) material = mesh_->face_materials[mesh_faces[i]] + 1;
      varint(ByteKind::faces, material);
      require(material <= header_.materials.size(), "a face names a material that isn't there");
      if constexpr (!writes) read_.face_materials.push_back(material - 1);
    }
    if constexpr (writes) {
      numbers_.face.push_back(mesh_faces[i]);
      numbers_.file_face[mesh_faces[i]] = face;
    }
    for (Index k = 0; k < size; ++k)
      note_corner(table_.face_corner(face) + k, writes ? corners[k] : k_no_index);
    if (header_.has_wedges()) {
      for (Index k = 0; k < size; ++k) code_wedge(table_.face_corner(face) + k, false);
    }
    items_.push_back(face);
  }
  n_new_faces_ = n_faces;
}

template <bool writes>
void PmeshCodec<writes>::code_base(ByteStreams& streams) {
  streams_ = &streams;
  std::vector<Index> faces;
  if constexpr (writes) {
    for (Index f = 0; f < mesh_->n_faces(); ++f) {
      if (mesh_->face_alive[f] != 0) faces.push_back(f);
    }
  } else {
    for (const std::string& name : header_.scalar_names) read_.scalars.push_back({name, {}});
  }
  created_.clear();
  items_.clear();
  code_faces(faces);
  code_features(k_no_index, false);
  std::uint64_t error = 0;
  if constexpr (writes) error = error_bits(mesh_->level_errors[0] + header_.quantisation_error);
  planes(ByteKind::errors, error, 4);
  require((error & k_error_bits) == 0, "an error has too many digits");
  if constexpr (!writes) {
    read_.level_faces.push_back(static_cast<Index>(table_.n_faces()));
    read_.level_errors.push_back(
        static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(error))));
    require(read_.level_errors.back() >= 0, "an error is negative");
  }
}

template <bool writes>
void PmeshCodec<writes>::code_batch(ByteStreams& streams, std::vector<Index> splits,
                                    const std::vector<std::size_t>& layer_ends) {
  streams_ = &streams;
  auto n = static_cast<Index>(splits.size());
  varint(ByteKind::counts, n);
  if constexpr (!writes) {
    // Each split has a byte for its shape.
    require(n <= streams.left(ByteKind::shape), "a batch has fewer splits than it says");
    splits.assign(n, k_no_index);
  }
  if constexpr (writes) {
    const auto number = [&](Index split) {
      const Index kept = mesh_->splits[split].kept;
      return kept == k_no_index ? k_no_index : numbers_.file_vertex[kept];
    };
    auto first = splits.begin();
    for (const std::size_t end : layer_ends) {
      const auto last = splits.begin() + static_cast<std::ptrdiff_t>(end);
      std::sort(first, last,
                [&](Index a, Index b) { return std::pair(number(a), a) < std::pair(number(b), b); });
      for (; first != last; ++first) code_split(*first);
    }
    for (; first != splits.end(); ++first) code_split(*first);
  } else {
    for (const Index split : splits) code_split(split);
  }
  code_errors(splits);
}

template <bool writes>
void PmeshCodec<writes>::code_split(Index split) {
  given_.clear();
  created_.clear();
  items_.clear();
  n_new_faces_ = 0;
  Index kept = k_no_index;
  if constexpr (writes) {
    if (mesh_->splits[split].kept == k_no_index) {
      shape_ = k_part;
    } else {
      kept = numbers_.file_vertex[mesh_->splits[split].kept];
      table_.read_ring(kept, ring_);
      choose_shape(split);
    }
  }
  byte(ByteKind::shape, shape_);
  require(shape_ < 16, "a split of an unknown shape");
  if ((shape_ & k_part) != 0) return code_part(split);
  const auto n = static_cast<Index>(table_.n_vertices());
  require(n > 0, "a split of nothing");
  std::uint64_t step = 0;
  if constexpr (writes) step = kept >= previous_kept_ ? kept - previous_kept_ : kept + n - previous_kept_;
  planes(ByteKind::kept, step, 4);
  require(step < n, "a split of a vertex that isn't there");
  kept = static_cast<Index>((previous_kept_ + step) % n);
  previous_kept_ = kept;
  if constexpr (!writes) table_.read_ring(kept, ring_);
  code_shape();
  // The new vertex gets its corners before its place, which is predicted from them.
  const Index removed = table_.add_vertex();
  positions_.emplace_back(Vec3::Zero());
  if (header_.has_colors) colors_.emplace_back(Vec4::Zero());
  scalars_.resize(scalars_.size() + header_.scalar_names.size(), 0);
  if constexpr (writes) {
    numbers_.vertex.push_back(mesh_->splits[split].removed);
    numbers_.file_vertex[mesh_->splits[split].removed] = removed;
  }
  apply_shape(kept, removed);
  code_vertex_values(removed, writes ? mesh_->splits[split].removed : k_no_index, predict(removed), kept);
  code_kept_values(split, kept, removed);
  if (header_.has_wedges()) code_wedges(split);
  code_features(split, true);
  note_split(kept, removed);
}

template <bool writes>
void PmeshCodec<writes>::code_part(Index split) {
  std::vector<Index> faces;
  if constexpr (writes) {
    const auto items = mesh_->items_of(split);
    faces.assign(items.begin(), items.end());
  }
  code_faces(faces);
  code_features(split, true);
  if constexpr (!writes) {
    read_.position_changes.push_back({Vec3::Zero(), Vec3::Zero()});
    if (header_.has_colors) read_.color_changes.push_back({Vec4::Zero(), Vec4::Zero()});
    for (std::size_t i = header_.scalar_names.size(); i > 0; --i) read_.scalar_changes.push_back({0, 0});
    if (header_.has_wedges()) {
      read_.corner_wedge_changes.start.push_back(
          static_cast<Index>(read_.corner_wedge_changes.entries.size()));
      read_.wedge_changes.start.push_back(static_cast<Index>(read_.wedge_changes.entries.size()));
    }
  }
  note_split(k_no_index, k_no_index);
}

/// Labels of the ring's corners and the triangles that come, and how they are best said.
template <bool writes>
void PmeshCodec<writes>::choose_shape(Index number) {
  const VertexSplit& split = mesh_->splits[number];
  const auto items = mesh_->items_of(number);
  const auto corners = items.first(split.n_corners), faces = items.subspan(split.n_corners, split.n_faces),
             cut = items.subspan(split.n_corners + split.n_faces);
  for (const Index c : corners) is_given_[c] = 1;
  cuts_.clear();
  for (const Index c : cut) cuts_.emplace_back(mesh_face_of(c), c);
  labels_.clear();
  for (const Index corner : ring_.corners) {
    const Index mesh_corner = numbers_.corner[corner], face = mesh_face_of(mesh_corner);
    const auto cut_here =
        std::find_if(cuts_.begin(), cuts_.end(), [&](const auto& c) { return c.first == face; });
    if (cut_here == cuts_.end()) {
      labels_.push_back(is_given_[mesh_corner] != 0 ? k_given : k_stays);
      continue;
    }
    const Index first = mesh_->face_offsets[face], size = mesh_->face_offsets[face + 1] - first;
    const Index before = numbers_.corner[table_.previous(corner)];
    const bool comes_before =
        (cut_here->second + size - before) % size < (mesh_corner + size - before) % size;
    labels_.push_back(comes_before ? k_added_before : k_added_after);
  }
  for (const Index c : corners) is_given_[c] = 0;
  triangles_.clear();
  for (const Index f : faces) {
    const std::vector<Index> alive = alive_corners(f);
    const auto vertex = [&](std::size_t i) { return mesh_->corner_vertices[alive[i % 3]]; };
    std::size_t at = 0;
    while (vertex(at) != split.kept) ++at;
    const bool turned = vertex(at + 1) == split.removed;
    triangles_.push_back({f, turned, numbers_.file_vertex[vertex(turned ? at + 2 : at + 1)]});
  }
  if (!find_run()) shape_ = 0;
}

/// Nearly all splits give a run of the ring, with a triangle at its ends.
template <bool writes>
bool PmeshCodec<writes>::find_run() {
  const std::size_t n = labels_.size();
  const auto n_given = static_cast<std::size_t>(std::count(labels_.begin(), labels_.end(), k_given));
  if (!ring_.is_fan || n_given == 0 || (ring_.is_closed && n_given == n)) return false;
  if (std::any_of(labels_.begin(), labels_.end(), [](std::uint8_t label) { return label > k_given; }))
    return false;
  std::size_t first = 0;
  const auto begins = [&](std::size_t i) {
    const bool after_gap = i == 0 ? !ring_.is_closed || labels_[n - 1] == k_stays : labels_[i - 1] == k_stays;
    return labels_[i] == k_given && after_gap;
  };
  while (!begins(first)) ++first;
  for (std::size_t i = 0; i < n_given; ++i) {
    if ((!ring_.is_closed && first + i >= n) || labels_[(first + i) % n] != k_given) return false;
  }
  const Index x = table_.vertex(table_.next(ring_.corners[first])),
              y = table_.vertex(table_.previous(ring_.corners[(first + n_given - 1) % n]));
  shape_ = k_run;
  for (const Triangle& triangle : triangles_) {
    const std::uint8_t end = triangle.turned ? k_triangle_last : k_triangle_first;
    if (triangle.third != (triangle.turned ? y : x) || (shape_ & end) != 0) return false;
    shape_ |= end;
  }
  std::sort(triangles_.begin(), triangles_.end(),
            [](const Triangle& a, const Triangle& b) { return a.turned < b.turned; });
  run_first_ = static_cast<std::uint8_t>(first);
  run_length_ = static_cast<std::uint8_t>(n_given - 1);
  return true;
}

template <bool writes>
void PmeshCodec<writes>::code_shape() {
  const std::size_t n = ring_.corners.size();
  if constexpr (!writes) {
    triangles_.clear();
    labels_.assign(n, k_stays);
  }
  if ((shape_ & k_run) != 0) {
    require(ring_.is_fan, "a split of a vertex in a form that it hasn't got");
    byte(ByteKind::first, run_first_);
    byte(ByteKind::length, run_length_);
    const std::size_t first = run_first_, length = std::size_t{run_length_} + 1;
    require(first < n && length <= n && (ring_.is_closed || first + length <= n),
            "a split of more corners than a vertex has");
    if constexpr (!writes) {
      for (std::size_t i = 0; i < length; ++i) labels_[(first + i) % n] = k_given;
      const Index x = table_.vertex(table_.next(ring_.corners[first])),
                  y = table_.vertex(table_.previous(ring_.corners[(first + length - 1) % n]));
      if ((shape_ & k_triangle_first) != 0) triangles_.push_back({k_no_index, false, x});
      if ((shape_ & k_triangle_last) != 0) triangles_.push_back({k_no_index, true, y});
    }
    return;
  }
  for (std::uint8_t& label : labels_) {
    byte(ByteKind::labels, label);
    require(label <= k_added_after, "a corner becomes what is unknown");
  }
  auto n_triangles = static_cast<Index>(triangles_.size());
  varint(ByteKind::counts, n_triangles);
  for (Index i = 0; i < n_triangles; ++i) {
    Triangle triangle{};
    if constexpr (writes) triangle = triangles_[i];
    std::uint8_t turned = triangle.turned ? 1 : 0;
    byte(ByteKind::flags, turned);
    varint(ByteKind::vertices, triangle.third);
    require(triangle.third < table_.n_vertices(), "a triangle names a vertex that isn't there");
    if constexpr (!writes) triangles_.push_back({k_no_index, turned != 0, triangle.third});
  }
}

template <bool writes>
void PmeshCodec<writes>::apply_shape(Index kept, Index removed) {
  std::vector<Index>& corners = ring_.corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (labels_[i] == k_given) {
      table_.give(corners[i], removed);
      given_.push_back(corners[i]);
    }
  }
  items_ = given_;
  for (const Triangle& triangle : triangles_) {
    add_triangle(triangle.mesh_face, triangle.turned, kept, triangle.third, removed);
  }
  n_new_faces_ = static_cast<Index>(triangles_.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (labels_[i] < k_added_before) continue;
    const Index added = table_.add_corner(corners[i], labels_[i] == k_added_before, removed);
    Index mesh_corner = k_no_index;
    if constexpr (writes) {
      const Index face = mesh_face_of(numbers_.corner[corners[i]]);
      mesh_corner =
          std::find_if(cuts_.begin(), cuts_.end(), [&](const auto& c) { return c.first == face; })->second;
      mesh_corner_alive_[mesh_corner] = 1;
    }
    note_corner(added, mesh_corner);
    items_.push_back(added);
  }
}

template <bool writes>
void PmeshCodec<writes>::add_triangle(Index mesh_face, bool turned, Index kept, Index third, Index removed) {
  const std::array<Index, 3> vertices =
      turned ? std::array<Index, 3>{removed, third, kept} : std::array<Index, 3>{kept, third, removed};
  const Index face = table_.add_face(vertices);
  items_.push_back(face);
  std::vector<Index> corners;
  if constexpr (writes) {
    numbers_.face.push_back(mesh_face);
    numbers_.file_face[mesh_face] = face;
    corners = alive_corners(mesh_face);
    const auto first = std::find_if(corners.begin(), corners.end(), [&](Index c) {
      return numbers_.file_vertex[mesh_->corner_vertices[c]] == vertices[0];
    });
    std::rotate(corners.begin(), first, corners.end());
  }
  for (Index k = 0; k < 3; ++k) note_corner(table_.face_corner(face) + k, writes ? corners[k] : k_no_index);
  if (!header_.has_face_materials) return;
  Index material = 0;
  if constexpr (writes) material = mesh_->face_materials[mesh_face] + 1;
  varint(ByteKind::faces, material);
  require(material <= header_.materials.size(), "a face names a material that isn't there");
  if constexpr (!writes) read_.face_materials.push_back(material - 1);
}

// Attributes of corners.

template <bool writes>
void PmeshCodec<writes>::code_wedges(Index split) {
  if constexpr (writes) {
    for (const auto& change : mesh_->corner_wedge_changes[split])
      mesh_corner_wedge_[change.corner] = change.fine;
  } else {
    read_.corner_wedge_changes.start.push_back(static_cast<Index>(read_.corner_wedge_changes.entries.size()));
    read_.wedge_changes.start.push_back(static_cast<Index>(read_.wedge_changes.entries.size()));
  }
  for (const Index corner : given_) {
    const Index coarse = corner_wedge_[corner];
    code_wedge(corner, true);
    if constexpr (!writes) {
      if (corner_wedge_[corner] != coarse)
        read_.corner_wedge_changes.entries.push_back({corner, corner_wedge_[corner], coarse});
    }
  }
  for (const Index corner : created_) code_wedge(corner, false);
  Index n = 0;
  if constexpr (writes) n = static_cast<Index>(mesh_->wedge_changes[split].size());
  varint(ByteKind::counts, n);
  for (Index i = 0; i < n; ++i) {
    Index wedge = 0, mesh_wedge = k_no_index;
    if constexpr (writes) {
      mesh_wedge = mesh_->wedge_changes[split][i].wedge;
      wedge = numbers_.file_wedge[mesh_wedge];
    }
    varint(ByteKind::vertices, wedge);
    const std::size_t n_wedges = std::max(wedge_uv_.size(), wedge_normal_.size());
    require(wedge < n_wedges, "a change of attributes that aren't there");
    ProgressiveMesh::WedgeValue change{wedge, {Vec2::Zero(), Vec2::Zero()}, {Vec3::Zero(), Vec3::Zero()}};
    if (header_.has_uvs) change.uv.coarse = wedge_uv_[wedge];
    if (header_.has_normals) change.normal.coarse = wedge_normal_[wedge];
    if constexpr (writes) {
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
    if constexpr (!writes) read_.wedge_changes.entries.push_back(change);
  }
}

/// Which wedge a corner has: its own, one of another corner there, a new one, or any by its number.
template <bool writes>
void PmeshCodec<writes>::code_wedge(Index corner, bool is_given) {
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
  if constexpr (writes) {
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
    if constexpr (writes) numbers_.file_wedge[mesh_wedge] = wedge;
    code_wedge_values(wedge, mesh_wedge, n > 0 ? candidates[0] : k_no_index);
  } else if (place == k_named) {
    varint(ByteKind::vertices, wedge);
    require(wedge < n_wedges, "a corner names attributes that aren't there");
  } else {
    require(place <= n, "a corner names attributes that aren't there");
    wedge = candidates[place - 1];
  }
  corner_wedge_[corner] = wedge;
  if constexpr (!writes) {
    if (!is_given) first_wedge_[corner] = wedge;
  }
}

template <bool writes>
void PmeshCodec<writes>::code_wedge_values(Index wedge, Index mesh_wedge, Index like) {
  if (header_.has_uvs) {
    Vec2& uv = wedge_uv_[wedge];
    if constexpr (writes) uv = mesh_->wedge_uvs[mesh_wedge];
    for (int k = 0; k < 2; ++k) {
      number(ByteKind::attributes, header_.uvs, like == k_no_index ? 0 : wedge_uv_[like][k], uv[k]);
    }
    require(uv.allFinite(), "a texture coordinate isn't finite");
    if constexpr (!writes) read_.wedge_uvs.push_back(uv);
  }
  if (!header_.has_normals) return;
  Vec3& normal = wedge_normal_[wedge];
  if constexpr (writes) normal = mesh_->wedge_normals[mesh_wedge];
  for (int k = 0; k < 3; ++k) {
    number(ByteKind::attributes, header_.normals, like == k_no_index ? 0 : wedge_normal_[like][k], normal[k]);
  }
  require(normal.allFinite(), "a normal isn't finite");
  if constexpr (!writes) read_.wedge_normals.push_back(normal);
}

template <bool writes>
void PmeshCodec<writes>::code_features(Index split, bool has_changes) {
  if (!header_.has_features) return;
  for (const Index corner : created_) {
    std::uint8_t flag = 0;
    if constexpr (writes) flag = mesh_->corner_features[numbers_.corner[corner]];
    byte(ByteKind::flags, flag);
    if constexpr (!writes) read_.corner_features[corner] = flag != 0 ? 1 : 0;
  }
  if (!has_changes) return;
  Index n = 0;
  if constexpr (writes) n = static_cast<Index>(mesh_->feature_changes[split].size());
  varint(ByteKind::counts, n);
  if constexpr (!writes) {
    read_.feature_changes.start.push_back(static_cast<Index>(read_.feature_changes.entries.size()));
  }
  for (Index i = 0; i < n; ++i) {
    Index corner = 0;
    if constexpr (writes) corner = numbers_.file_corner[mesh_->feature_changes[split][i]];
    varint(ByteKind::vertices, corner);
    require(corner < table_.n_corners(), "a feature edge names a corner that isn't there");
    if constexpr (!writes) read_.feature_changes.entries.push_back(corner);
  }
}

template <bool writes>
void PmeshCodec<writes>::note_split(Index kept, Index removed) {
  if constexpr (!writes) {
    VertexSplit split{removed, kept};
    split.first = static_cast<Index>(read_.items.size());
    split.n_corners = static_cast<Index>(given_.size());
    split.n_faces = n_new_faces_;
    read_.items.insert(read_.items.end(), items_.begin(), items_.end());
    read_.splits.push_back(split);
    read_.level_faces.push_back(static_cast<Index>(table_.n_faces()));
  }
}

/// In the order of levels each error follows; in another order only that of the batch's end.
template <bool writes>
void PmeshCodec<writes>::code_errors(const std::vector<Index>& splits) {
  // Errors fall, and the bits of positive floats fall with them.
  const std::size_t n_errors = header_.keeps_order ? splits.size() : std::min<std::size_t>(splits.size(), 1);
  const auto bits_of_level = [&](std::size_t level) {
    return error_bits(mesh_->level_errors[level] + header_.quantisation_error);
  };
  std::uint32_t before = 0;
  if constexpr (writes) {
    if (!splits.empty()) before = bits_of_level(*std::min_element(splits.begin(), splits.end()));
  } else {
    before = std::bit_cast<std::uint32_t>(static_cast<float>(read_.level_errors.back()));
    if (!header_.keeps_order) {
      for (std::size_t i = 1; i < splits.size(); ++i) read_.level_errors.push_back(read_.level_errors.back());
    }
  }
  for (std::size_t i = 0; i < n_errors; ++i) {
    std::uint64_t fall = 0;
    if constexpr (writes) {
      const std::size_t level = header_.keeps_order
                                    ? splits[i] + std::size_t{1}
                                    : *std::max_element(splits.begin(), splits.end()) + std::size_t{1};
      fall = (before - bits_of_level(level)) / (k_error_bits + 1);
    }
    planes(ByteKind::errors, fall, 4);
    require(fall <= before / (k_error_bits + 1), "an error grows towards the input");
    before -= static_cast<std::uint32_t>(fall) * (k_error_bits + 1);
    if constexpr (!writes) read_.level_errors.push_back(static_cast<double>(std::bit_cast<float>(before)));
  }
}

template class PmeshCodec<true>;
template class PmeshCodec<false>;

}  // namespace recede::detail
