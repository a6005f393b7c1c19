#include <recede/lod/detail/pmesh_numbering.h>

#include <algorithm>
#include <bit>
#include <cstring>

namespace recede::detail {
namespace {

/// Lists of numbers, each after its length.
template <bool writes>
class ListCoder {
 public:
  explicit ListCoder(ByteStreams& streams) : streams_(streams) {}

  void size(std::size_t& value) {
    if constexpr (writes)
      streams_.put_varint(ByteKind::counts, value);
    else
      value = streams_.take_varint(ByteKind::counts);
  }
  /// Differences from one to the next. Each takes a byte in four planes.
  void indices(std::vector<Index>& list) {
    open(list, ByteKind::numbers);
    Index before = 0;
    for (Index& value : list) index(value, before);
  }
  void index(Index& value, Index& before) {
    if constexpr (writes) {
      streams_.put_planes(ByteKind::numbers, zigzag(static_cast<std::int32_t>(value - before)), 4);
    } else {
      const auto step = static_cast<std::uint32_t>(streams_.take_planes(ByteKind::numbers, 4));
      value = before + static_cast<std::uint32_t>(unzigzag(step));
    }
    before = value;
  }
  void reals(std::vector<double>& list) {
    open(list, ByteKind::attributes);
    for (double& value : list) real(value);
  }
  template <typename Vector>
  void vectors(std::vector<Vector>& list) {
    open(list, ByteKind::attributes);
    for (Vector& vector : list) {
      for (double& value : vector) real(value);
      if (!vector.allFinite()) throw std::out_of_range("a number isn't finite");
    }
  }
  template <typename Entry, typename Fields>
  void entries(std::vector<Entry>& list, Fields&& fields) {
    open(list, ByteKind::numbers);
    std::array<Index, 3> before{};
    for (Entry& entry : list) {
      std::size_t i = 0;
      for (Index* const field : fields(entry)) index(*field, before[i++]);
    }
  }

 private:
  template <typename List>
  void open(List& list, ByteKind kind) {
    std::size_t n = list.size();
    size(n);
    if constexpr (writes) return;
    if (n > streams_.left(kind)) throw std::out_of_range("a list is longer than its bytes");
    list.resize(n);
  }
  void real(double& value) {
    if constexpr (writes)
      streams_.put_planes(ByteKind::attributes, std::bit_cast<std::uint64_t>(value), 8);
    else
      value = std::bit_cast<double>(streams_.take_planes(ByteKind::attributes, 8));
  }

  ByteStreams& streams_;
};

void require(bool condition, const char* reason) {
  if (!condition) throw std::out_of_range(reason);
}

/// Numbers that are different and all below `end`.
void check_distinct(const std::vector<Index>& numbers, std::size_t end) {
  std::vector<bool> seen(end, false);
  for (const Index n : numbers) {
    require(n < end && !seen[n], "the numbering names something twice or something that isn't there");
    seen[n] = true;
  }
}

void check_below(const std::vector<Index>& numbers, std::size_t end) {
  for (const Index n : numbers) require(n < end, "the numbering names something that isn't there");
}

std::size_t wedge_count(const std::vector<Vec2>& uvs, const std::vector<Vec3>& normals) {
  return std::max(uvs.size(), normals.size());
}

/// What is used before the mesh is put together; the rest is checked there.
void check(const PmeshNumbering& numbering, const PmeshHeader& header, const PmeshTable& table) {
  const std::size_t more_vertices = numbering.positions.size(), more_faces = numbering.face_sizes.size();
  require(
      numbering.vertex.size() == table.n_vertices() && numbering.face.size() == table.n_faces() &&
          numbering.first.size() == table.n_faces() &&
          numbering.n_vertices == table.n_vertices() + more_vertices &&
          numbering.n_faces == table.n_faces() + more_faces &&
          numbering.colors.size() == (header.has_colors ? more_vertices : 0) &&
          numbering.scalars.size() == header.scalar_names.size() * more_vertices &&
          numbering.face_materials.size() == (header.has_face_materials ? more_faces : 0) &&
          numbering.corner_wedges.size() == (header.has_wedges() ? numbering.corner_vertices.size() : 0) &&
          numbering.n_vertices < k_no_index && numbering.n_faces < k_no_index,
      "the numbering has lists of the wrong lengths");
  check_distinct(numbering.vertex, numbering.n_vertices);
  check_distinct(numbering.face, numbering.n_faces);
  std::size_t n_corners = 0;
  for (const Index size : numbering.face_sizes) {
    require(size >= 3, "a face has fewer than three corners");
    n_corners += size;
  }
  require(n_corners == numbering.corner_vertices.size(), "the numbering has lists of the wrong lengths");
  check_below(numbering.corner_vertices, numbering.n_vertices);
  check_below(numbering.mending.fine_faces, numbering.n_faces);
  check_below(numbering.mending.coarse_faces, numbering.n_faces);
  for (const Index material : numbering.face_materials) {
    require(material == k_no_index || material < header.materials.size(),
            "a face names a material that isn't there");
  }
  for (const auto& change : numbering.mending.vertices) {
    require(change.corner < table.n_corners() + n_corners && change.fine < numbering.n_vertices &&
                change.coarse < numbering.n_vertices,
            "the numbering names something that isn't there");
  }
  for (const auto& [a, b] : numbering.feature_edges) {
    require(a < numbering.n_vertices && b < numbering.n_vertices,
            "a feature edge names a vertex that isn't there");
  }
}

}  // namespace

PmeshNumbering find_numbering(const ProgressiveMesh& mesh, const PmeshHeader& header, const PmeshTable& table,
                              PmeshNumbers numbers) {
  PmeshNumbering result;
  result.vertex = numbers.vertex;
  result.face = numbers.face;
  result.n_vertices = mesh.positions.size();
  result.n_faces = mesh.n_faces();
  for (Index f = 0; f < table.n_faces(); ++f) {
    Index steps = 0, lowest = numbers.corner[table.face_corner(f)], at = 0;
    for (Index c = table.next(table.face_corner(f)); c != table.face_corner(f); c = table.next(c)) {
      ++at;
      if (numbers.corner[c] >= lowest) continue;
      lowest = numbers.corner[c];
      steps = at;
    }
    result.first.push_back(steps);
  }
  const auto quantised = [&](Vec3 position) {
    if (header.positions.form == NumberLattice::Form::quantised) {
      for (double& x : position) x = header.positions.to_value(header.positions.to_integer(x));
    }
    return position;
  };
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    if (numbers.file_vertex[v] != k_no_index) continue;
    result.positions.push_back(quantised(mesh.positions[v]));
    if (header.has_colors) result.colors.push_back(mesh.colors[v]);
    for (const VertexScalar& scalar : mesh.scalars) result.scalars.push_back(scalar.values[v]);
  }
  auto n_wedges = static_cast<Index>(std::count_if(numbers.file_wedge.begin(), numbers.file_wedge.end(),
                                                   [](Index number) { return number != k_no_index; }));
  const auto wedge_number = [&](Index wedge) {
    Index& number = numbers.file_wedge[wedge];
    if (number == k_no_index) {
      number = n_wedges++;
      if (header.has_uvs) result.wedge_uvs.push_back(mesh.wedge_uvs[wedge]);
      if (header.has_normals) result.wedge_normals.push_back(mesh.wedge_normals[wedge]);
    }
    return number;
  };
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    if (numbers.file_face[f] != k_no_index) continue;
    result.face_sizes.push_back(mesh.face_offsets[f + 1] - mesh.face_offsets[f]);
    if (header.has_face_materials) result.face_materials.push_back(mesh.face_materials[f]);
    for (Index c = mesh.face_offsets[f]; c < mesh.face_offsets[f + 1]; ++c) {
      result.corner_vertices.push_back(mesh.corner_vertices[c]);
      if (header.has_wedges()) result.corner_wedges.push_back(wedge_number(mesh.corner_wedges[c]));
    }
  }
  result.mending = mesh.mending;
  for (auto& change : result.mending.wedges) {
    change.fine = wedge_number(change.fine);
    change.coarse = wedge_number(change.coarse);
  }
  result.feature_edges = mesh.feature_edges;
  return result;
}

template <bool writes>
void code_numbering(ByteStreams& streams, const PmeshHeader& header, const PmeshTable& table,
                    PmeshNumbering& numbering) {
  ListCoder<writes> lists(streams);
  lists.size(numbering.n_vertices);
  lists.size(numbering.n_faces);
  lists.indices(numbering.vertex);
  lists.indices(numbering.face);
  lists.indices(numbering.first);
  lists.vectors(numbering.positions);
  lists.vectors(numbering.colors);
  lists.reals(numbering.scalars);
  lists.vectors(numbering.wedge_uvs);
  lists.vectors(numbering.wedge_normals);
  lists.indices(numbering.face_sizes);
  lists.indices(numbering.face_materials);
  lists.indices(numbering.corner_vertices);
  lists.indices(numbering.corner_wedges);
  const auto three = [](auto& entry) { return std::array{&entry.corner, &entry.fine, &entry.coarse}; };
  lists.entries(numbering.mending.vertices, three);
  lists.entries(numbering.mending.wedges, three);
  lists.indices(numbering.mending.fine_faces);
  lists.indices(numbering.mending.coarse_faces);
  lists.entries(numbering.feature_edges, [](auto& edge) { return std::array{&edge.first, &edge.second}; });
  if constexpr (!writes) check(numbering, header, table);
}

template void code_numbering<true>(ByteStreams&, const PmeshHeader&, const PmeshTable&, PmeshNumbering&);
template void code_numbering<false>(ByteStreams&, const PmeshHeader&, const PmeshTable&, PmeshNumbering&);

namespace {

template <typename Value>
bool changes_nothing(const std::vector<Change<Value>>& changes) {
  return std::all_of(changes.begin(), changes.end(), [](const Change<Value>& change) {
    return std::memcmp(&change.fine, &change.coarse, sizeof(Value)) == 0;
  });
}

template <typename Entry>
void close(SplitRows<Entry>& rows) {
  if (rows.entries.empty())
    rows = {};
  else
    rows.start.push_back(static_cast<Index>(rows.entries.size()));
}

/// Puts what a codec has read into the lists of a progressive mesh.
class Assembler {
 public:
  Assembler(const PmeshCodec& codec, const PmeshNumbering* numbering)
      : codec_(codec),
        table_(codec.table()),
        numbering_(numbering),
        read_(codec.read()),
        mesh_(codec.read()) {}

  ProgressiveMesh run() {
    number_faces();
    fill_faces();
    fill_vertices();
    name_splits();
    finish();
    return std::move(mesh_);
  }

 private:
  Index vertex(Index of_file) const { return numbering_ ? numbering_->vertex[of_file] : of_file; }
  Index face(Index of_file) const { return numbering_ ? numbering_->face[of_file] : of_file; }

  void number_faces();
  void fill_faces();
  void fill_further_faces();
  void fill_vertices();
  void name_splits();
  void finish();

  const PmeshCodec& codec_;
  const PmeshTable& table_;
  const PmeshNumbering* numbering_;
  const ProgressiveMesh& read_;
  ProgressiveMesh mesh_;
  std::vector<Index> corner_;  // by corner of the file
};

/// Where the corners of each face begin, and the numbers of all corners.
void Assembler::number_faces() {
  const std::size_t n = numbering_ ? numbering_->n_faces : table_.n_faces();
  std::vector<Index> sizes(n, 0);
  for (Index f = 0; f < table_.n_faces(); ++f) {
    const Index first = table_.face_corner(f);
    Index size = 1;
    for (Index c = table_.next(first); c != first; c = table_.next(c)) ++size;
    sizes[face(f)] = size;
  }
  std::size_t further = 0;
  for (Index& size : sizes) {
    if (size == 0) size = numbering_->face_sizes[further++];
  }
  for (const Index size : sizes) mesh_.face_offsets.push_back(mesh_.face_offsets.back() + size);
  corner_.resize(table_.n_corners());
  for (Index f = 0; f < table_.n_faces(); ++f) {
    Index c = table_.face_corner(f), number = mesh_.face_offsets[face(f)];
    const Index size = sizes[face(f)];
    for (Index i = numbering_ ? numbering_->first[f] % size : 0; i > 0; --i) c = table_.next(c);
    for (Index i = 0; i < size; ++i, c = table_.next(c)) corner_[c] = number++;
  }
}

void Assembler::fill_faces() {
  const std::size_t n_faces = mesh_.n_faces(), n_corners = mesh_.face_offsets.back();
  const bool has_wedges = codec_.header().has_wedges();
  mesh_.face_alive.assign(n_faces, 0);
  for (Index f = 0; f < read_.level_faces.front(); ++f) mesh_.face_alive[face(f)] = 1;
  if (codec_.header().has_face_materials) {
    mesh_.face_materials.assign(n_faces, k_no_index);
    for (Index f = 0; f < table_.n_faces(); ++f) mesh_.face_materials[face(f)] = read_.face_materials[f];
  }
  mesh_.corner_vertices.assign(n_corners, 0);
  if (has_wedges) mesh_.corner_wedges.assign(n_corners, 0);
  if (codec_.header().has_features) mesh_.corner_features.assign(n_corners, 0);
  for (Index c = 0; c < table_.n_corners(); ++c) {
    mesh_.corner_vertices[corner_[c]] = vertex(codec_.first_vertices()[c]);
    if (has_wedges) mesh_.corner_wedges[corner_[c]] = codec_.first_wedges()[c];
    if (codec_.header().has_features) mesh_.corner_features[corner_[c]] = read_.corner_features[c];
  }
  if (numbering_) fill_further_faces();
}

void Assembler::fill_further_faces() {
  std::vector<bool> is_known(mesh_.n_faces(), false);
  for (const Index f : numbering_->face) is_known[f] = true;
  const std::size_t n_wedges = wedge_count(read_.wedge_uvs, read_.wedge_normals) +
                               wedge_count(numbering_->wedge_uvs, numbering_->wedge_normals);
  std::size_t number = 0, at = 0;
  for (std::size_t f = 0; f < mesh_.n_faces(); ++f) {
    if (is_known[f]) continue;
    if (!mesh_.face_materials.empty()) mesh_.face_materials[f] = numbering_->face_materials[number];
    ++number;
    for (Index c = mesh_.face_offsets[f]; c < mesh_.face_offsets[f + 1]; ++c, ++at) {
      mesh_.corner_vertices[c] = numbering_->corner_vertices[at];
      if (!mesh_.corner_wedges.empty()) mesh_.corner_wedges[c] = numbering_->corner_wedges[at];
    }
  }
  mesh_.wedge_uvs.insert(mesh_.wedge_uvs.end(), numbering_->wedge_uvs.begin(), numbering_->wedge_uvs.end());
  mesh_.wedge_normals.insert(mesh_.wedge_normals.end(), numbering_->wedge_normals.begin(),
                             numbering_->wedge_normals.end());
  check_below(numbering_->corner_wedges, n_wedges);
  for (const auto& change : numbering_->mending.wedges) {
    require(change.corner < mesh_.corner_wedges.size() && change.fine < n_wedges && change.coarse < n_wedges,
            "the numbering names something that isn't there");
  }
  require((!codec_.header().has_uvs || mesh_.wedge_uvs.size() == n_wedges) &&
              (!codec_.header().has_normals || mesh_.wedge_normals.size() == n_wedges),
          "the numbering has lists of the wrong lengths");
}

void Assembler::fill_vertices() {
  if (!numbering_) return;
  const std::size_t n = numbering_->n_vertices, n_scalars = read_.scalars.size();
  std::vector<Index> source(n, k_no_index);  // in the file
  for (Index v = 0; v < numbering_->vertex.size(); ++v) source[numbering_->vertex[v]] = v;
  mesh_.positions.resize(n);
  if (codec_.header().has_colors) mesh_.colors.resize(n);
  for (VertexScalar& scalar : mesh_.scalars) scalar.values.resize(n);
  std::size_t further = 0;
  for (std::size_t v = 0; v < n; ++v) {
    const Index from = source[v];
    const bool is_known = from != k_no_index;
    mesh_.positions[v] = is_known ? read_.positions[from] : numbering_->positions[further];
    if (codec_.header().has_colors)
      mesh_.colors[v] = is_known ? read_.colors[from] : numbering_->colors[further];
    for (std::size_t i = 0; i < n_scalars; ++i) {
      mesh_.scalars[i].values[v] =
          is_known ? read_.scalars[i].values[from] : numbering_->scalars[further * n_scalars + i];
    }
    further += is_known ? 0 : 1;
  }
}

void Assembler::name_splits() {
  bool has_single_corners = false;
  for (std::size_t s = 0; s < mesh_.splits.size(); ++s) {
    VertexSplit& split = mesh_.splits[s];
    const std::size_t n = mesh_.items_of(s).size();
    for (std::size_t i = 0; i < n; ++i) {
      Index& item = mesh_.items[split.first + i];
      const bool is_face = i >= split.n_corners && i < split.n_corners + split.n_faces;
      item = is_face ? face(item) : corner_[item];
      if (is_face || i < split.n_corners) continue;
      if (!has_single_corners) mesh_.corner_alive.assign(mesh_.corner_vertices.size(), 1);
      has_single_corners = true;
      mesh_.corner_alive[item] = 0;
    }
    if (split.kept == k_no_index) continue;
    split.kept = vertex(split.kept);
    split.removed = vertex(split.removed);
  }
  for (auto& change : mesh_.corner_wedge_changes.entries) change.corner = corner_[change.corner];
  for (Index& corner : mesh_.feature_changes.entries) corner = corner_[corner];
}

void Assembler::finish() {
  if (changes_nothing(mesh_.position_changes)) mesh_.position_changes = {};
  if (changes_nothing(mesh_.color_changes)) mesh_.color_changes = {};
  if (changes_nothing(mesh_.scalar_changes)) mesh_.scalar_changes = {};
  close(mesh_.corner_wedge_changes);
  close(mesh_.wedge_changes);
  close(mesh_.feature_changes);
  mesh_.materials = codec_.header().materials;
  mesh_.errors_are_proved = codec_.header().errors_are_proved;
  if (numbering_) {
    mesh_.mending = numbering_->mending;
    mesh_.feature_edges = numbering_->feature_edges;
    if (!mesh_.mending.empty()) {
      mesh_.level_faces.push_back(static_cast<Index>(
          mesh_.level_faces.back() + mesh_.mending.fine_faces.size() - mesh_.mending.coarse_faces.size()));
      mesh_.level_errors.push_back(std::min(mesh_.level_errors.back(), codec_.header().quantisation_error));
    }
  }
}

}  // namespace

ProgressiveMesh assemble(const PmeshCodec& codec, const PmeshNumbering* numbering) {
  return Assembler(codec, numbering).run();
}

}  // namespace recede::detail
