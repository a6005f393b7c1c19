#include <recede/lod/detail/pmesh_codec.h>

#include <algorithm>
#include <bit>
#include <limits>

namespace recede::detail {
namespace {

/// Errors are held as floats of which the last bits are zero, and never below what they are.
constexpr std::uint32_t k_error_bits = 0xfff;

std::uint32_t error_bits(double error) {
  auto result = static_cast<float>(error);
  if (static_cast<double>(result) < error)
    result = std::nextafter(result, std::numeric_limits<float>::infinity());
  return (std::bit_cast<std::uint32_t>(result) + k_error_bits) & ~k_error_bits;
}

}  // namespace

/// The value becomes what the lattice makes of it.
void PmeshCodec::number(ByteKind kind, const NumberLattice& lattice, double predicted, double& value) {
  const auto guess = static_cast<std::uint64_t>(lattice.to_integer(predicted));
  std::uint64_t residual = 0;
  if (writes_)
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

void PmeshCodec::start(const ProgressiveMesh& mesh) {
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

std::vector<Index> PmeshCodec::alive_corners(Index mesh_face) const {
  std::vector<Index> corners;
  for (Index c = mesh_->face_offsets[mesh_face]; c < mesh_->face_offsets[mesh_face + 1]; ++c) {
    if (mesh_corner_alive_[c] != 0) corners.push_back(c);
  }
  return corners;
}

void PmeshCodec::note_corner(Index corner, Index mesh_corner) {
  corner_wedge_.push_back(k_no_index);
  corner_feature_.push_back(0);
  created_.push_back(corner);
  if (writes_) {
    numbers_.corner.push_back(mesh_corner);
    numbers_.file_corner[mesh_corner] = corner;
  } else {
    first_vertex_.push_back(table_.vertex(corner));
    first_wedge_.push_back(k_no_index);
    if (header_.has_features) read_.corner_features.push_back(0);
  }
}

/// Faces that don't come by triangles beside a new vertex: those of the base, and of parts.
void PmeshCodec::code_faces(const std::vector<Index>& mesh_faces) {
  auto n_faces = static_cast<Index>(mesh_faces.size());
  varint(ByteKind::counts, n_faces);
  std::vector<Index> vertices, corners;
  Index last = k_no_index;  // the vertex before
  for (Index i = 0; i < n_faces; ++i) {
    if (writes_) corners = alive_corners(mesh_faces[i]);
    auto size = static_cast<Index>(corners.size());
    varint(ByteKind::counts, size);
    require(size >= 3, "a face has fewer than three corners");
    vertices.clear();
    for (Index k = 0; k < size; ++k) {
      const auto n = static_cast<Index>(table_.n_vertices());
      Index mesh_vertex = k_no_index, back = 0;
      if (writes_) {
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
      if (writes_) material = mesh_->face_materials[mesh_faces[i]] + 1;
      varint(ByteKind::faces, material);
      require(material <= header_.materials.size(), "a face names a material that isn't there");
      if (!writes_) read_.face_materials.push_back(material - 1);
    }
    if (writes_) {
      numbers_.face.push_back(mesh_faces[i]);
      numbers_.file_face[mesh_faces[i]] = face;
    }
    for (Index k = 0; k < size; ++k)
      note_corner(table_.face_corner(face) + k, writes_ ? corners[k] : k_no_index);
    if (header_.has_wedges()) {
      for (Index k = 0; k < size; ++k) code_wedge(table_.face_corner(face) + k, false);
    }
    items_.push_back(face);
  }
  n_new_faces_ = n_faces;
}

void PmeshCodec::code_base(ByteStreams& streams) {
  streams_ = &streams;
  std::vector<Index> faces;
  if (writes_) {
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
  if (writes_) error = error_bits(mesh_->level_errors[0] + header_.quantisation_error);
  planes(ByteKind::errors, error, 4);
  require((error & k_error_bits) == 0, "an error has too many digits");
  if (!writes_) {
    read_.level_faces.push_back(static_cast<Index>(table_.n_faces()));
    read_.level_errors.push_back(
        static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(error))));
    require(read_.level_errors.back() >= 0, "an error is negative");
  }
}

void PmeshCodec::code_batch(ByteStreams& streams, std::vector<Index> splits,
                            const std::vector<std::size_t>& layer_ends) {
  streams_ = &streams;
  auto n = static_cast<Index>(splits.size());
  varint(ByteKind::counts, n);
  if (!writes_) {
    // Each split has a byte for its shape.
    require(n <= streams.left(ByteKind::shape), "a batch has fewer splits than it says");
    splits.assign(n, k_no_index);
  }
  if (writes_) {
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

void PmeshCodec::code_split(Index split) {
  given_.clear();
  created_.clear();
  items_.clear();
  n_new_faces_ = 0;
  Index kept = k_no_index;
  if (writes_) {
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
  if (writes_) step = kept >= previous_kept_ ? kept - previous_kept_ : kept + n - previous_kept_;
  planes(ByteKind::kept, step, 4);
  require(step < n, "a split of a vertex that isn't there");
  kept = static_cast<Index>((previous_kept_ + step) % n);
  previous_kept_ = kept;
  if (!writes_) table_.read_ring(kept, ring_);
  code_shape();
  // The new vertex gets its corners before its place, which is predicted from them.
  const Index removed = table_.add_vertex();
  positions_.emplace_back(Vec3::Zero());
  if (header_.has_colors) colors_.emplace_back(Vec4::Zero());
  scalars_.resize(scalars_.size() + header_.scalar_names.size(), 0);
  if (writes_) {
    numbers_.vertex.push_back(mesh_->splits[split].removed);
    numbers_.file_vertex[mesh_->splits[split].removed] = removed;
  }
  apply_shape(kept, removed);
  code_vertex_values(removed, writes_ ? mesh_->splits[split].removed : k_no_index, predict(removed), kept);
  code_kept_values(split, kept, removed);
  if (header_.has_wedges()) code_wedges(split);
  code_features(split, true);
  note_split(kept, removed);
}

void PmeshCodec::code_part(Index split) {
  std::vector<Index> faces;
  if (writes_) {
    const auto items = mesh_->items_of(split);
    faces.assign(items.begin(), items.end());
  }
  code_faces(faces);
  code_features(split, true);
  if (!writes_) {
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

void PmeshCodec::note_split(Index kept, Index removed) {
  if (!writes_) {
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
void PmeshCodec::code_errors(const std::vector<Index>& splits) {
  // Errors fall, and the bits of positive floats fall with them.
  const std::size_t n_errors = header_.keeps_order ? splits.size() : std::min<std::size_t>(splits.size(), 1);
  const auto bits_of_level = [&](std::size_t level) {
    return error_bits(mesh_->level_errors[level] + header_.quantisation_error);
  };
  std::uint32_t before = 0;
  if (writes_) {
    if (!splits.empty()) before = bits_of_level(*std::min_element(splits.begin(), splits.end()));
  } else {
    before = std::bit_cast<std::uint32_t>(static_cast<float>(read_.level_errors.back()));
    if (!header_.keeps_order) {
      for (std::size_t i = 1; i < splits.size(); ++i) read_.level_errors.push_back(read_.level_errors.back());
    }
  }
  for (std::size_t i = 0; i < n_errors; ++i) {
    std::uint64_t fall = 0;
    if (writes_) {
      const std::size_t level = header_.keeps_order
                                    ? splits[i] + std::size_t{1}
                                    : *std::max_element(splits.begin(), splits.end()) + std::size_t{1};
      fall = (before - bits_of_level(level)) / (k_error_bits + 1);
    }
    planes(ByteKind::errors, fall, 4);
    require(fall <= before / (k_error_bits + 1), "an error grows towards the input");
    before -= static_cast<std::uint32_t>(fall) * (k_error_bits + 1);
    if (!writes_) read_.level_errors.push_back(static_cast<double>(std::bit_cast<float>(before)));
  }
}

}  // namespace recede::detail
