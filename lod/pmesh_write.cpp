#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/pmesh_chunks.h>
#include <recede/lod/detail/pmesh_numbering.h>
#include <recede/lod/pmesh.h>

#include <algorithm>
#include <numeric>

namespace recede {
namespace {

using detail::ByteKind;
using detail::ByteStreams;
using detail::NumberLattice;
using detail::PmeshCodec;
using detail::PmeshHeader;

/// From one batch to the next the number of faces grows by about this factor.
constexpr double k_batch_growth = 1.5;
constexpr std::size_t k_least_batch = 256;

void check(const PmeshOptions& options) {
  for (const auto& bits : {options.position_bits, options.uv_bits, options.normal_bits, options.color_bits,
                           options.scalar_bits}) {
    if (bits && (*bits < 1 || *bits > 30)) throw OptionError("bits of quantised numbers must lie in [1, 30]");
  }
}

/// Numbers of one kind, wherever they stand in a mesh.
class NumberLists {
 public:
  template <typename Vector>
  void add(const std::vector<Vector>& vectors) {
    if (!vectors.empty())
      lists_.emplace_back(vectors[0].data(),
                          vectors.size() * static_cast<std::size_t>(Vector::SizeAtCompileTime));
  }
  template <typename Vector>
  void add(const std::vector<Change<Vector>>& changes) {
    static_assert(sizeof(Change<Vector>) == 2 * sizeof(Vector));
    if (!changes.empty()) {
      lists_.emplace_back(changes[0].fine.data(),
                          changes.size() * 2 * static_cast<std::size_t>(Vector::SizeAtCompileTime));
    }
  }
  void add_numbers(std::span<const double> numbers) { lists_.push_back(numbers); }

  NumberLattice lattice(const std::optional<int>& bits) const {
    if (!bits) return NumberLattice::lossless(lists_);
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
    for (const auto& list : lists_) {
      for (const double x : list) {
        if (!std::isfinite(x)) continue;
        lowest = std::min(lowest, x);
        highest = std::max(highest, x);
      }
    }
    if (!(lowest <= highest)) lowest = highest = 0;
    return NumberLattice::quantised(lowest, highest - lowest, *bits);
  }

 private:
  std::vector<std::span<const double>> lists_;
};

/// Coordinates share one unit, with the origin at the least of all.
NumberLattice position_lattice(const ProgressiveMesh& mesh, const std::optional<int>& bits) {
  NumberLists lists;
  lists.add(mesh.positions);
  lists.add(mesh.position_changes);
  return lists.lattice(bits);
}

double largest_move(const ProgressiveMesh& mesh, const NumberLattice& lattice) {
  if (lattice.form != NumberLattice::Form::quantised) return 0;
  double most = 0;
  const auto look = [&](const Vec3& p) {
    const Vec3 moved = p.unaryExpr([&](double x) { return lattice.to_value(lattice.to_integer(x)); });
    most = std::max(most, (moved - p).norm());
  };
  for (const Vec3& p : mesh.positions) look(p);
  for (const auto& change : mesh.position_changes) {
    look(change.fine);
    look(change.coarse);
  }
  return most;
}

PmeshHeader make_header(const ProgressiveMesh& mesh, const PmeshOptions& options) {
  PmeshHeader header;
  header.has_uvs = !mesh.wedge_uvs.empty();
  header.has_normals = !mesh.wedge_normals.empty();
  header.has_colors = !mesh.colors.empty();
  header.has_features = !mesh.corner_features.empty();
  header.has_face_materials = !mesh.face_materials.empty();
  for (const VertexScalar& scalar : mesh.scalars) header.scalar_names.push_back(scalar.name);
  header.materials = mesh.materials;
  header.positions = position_lattice(mesh, options.position_bits);
  NumberLists uvs, normals, colors, scalars;
  std::vector<Vec2> changed_uvs;
  std::vector<Vec3> changed_normals;
  for (const auto& change : mesh.wedge_changes.entries) {
    changed_uvs.insert(changed_uvs.end(), {change.uv.fine, change.uv.coarse});
    changed_normals.insert(changed_normals.end(), {change.normal.fine, change.normal.coarse});
  }
  uvs.add(mesh.wedge_uvs);
  uvs.add(changed_uvs);
  normals.add(mesh.wedge_normals);
  normals.add(changed_normals);
  colors.add(mesh.colors);
  colors.add(mesh.color_changes);
  for (const VertexScalar& scalar : mesh.scalars) scalars.add_numbers(scalar.values);
  for (const auto& change : mesh.scalar_changes) scalars.add_numbers(std::span(&change.fine, 2));
  header.uvs = uvs.lattice(options.uv_bits);
  header.normals = normals.lattice(options.normal_bits);
  header.colors = colors.lattice(options.color_bits);
  header.scalars = scalars.lattice(options.scalar_bits);
  // Where vertices move, what a split depends on isn't in its record alone.
  const bool moves = !mesh.position_changes.empty() || !mesh.color_changes.empty() ||
                     !mesh.scalar_changes.empty() || !mesh.wedge_changes.entries.empty();
  header.keeps_order = options.keep_order.value_or(!options.position_bits) || moves;
  header.quantisation_error = largest_move(mesh, header.positions);
  // The triangles that stand for a larger polygon may be others when its corners have moved.
  const bool may_turn = header.quantisation_error > 0 && !mesh.corner_alive.empty();
  header.errors_are_proved = mesh.errors_are_proved && header.keeps_order && !may_turn;
  const bool is_quantised = options.position_bits || options.uv_bits || options.normal_bits ||
                            options.color_bits || options.scalar_bits;
  header.has_numbering = options.keep_numbering || (!mesh.mending.empty() && !is_quantised);
  header.n_splits = mesh.splits.size();
  return header;
}

/// Where batches end.
std::vector<std::size_t> batch_ends(const ProgressiveMesh& mesh) {
  std::vector<std::size_t> ends;
  const std::size_t n = mesh.splits.size();
  for (std::size_t at = 0; at < n;) {
    const auto faces = static_cast<std::size_t>(k_batch_growth * static_cast<double>(mesh.level_faces[at]));
    const auto above = std::upper_bound(mesh.level_faces.begin(),
                                        mesh.level_faces.begin() + static_cast<std::ptrdiff_t>(n), faces);
    const auto reached = static_cast<std::size_t>(above - mesh.level_faces.begin());
    at = std::min(n, std::max(reached, at + k_least_batch));
    ends.push_back(at);
  }
  return ends;
}

/// Splits of a batch by how many others of it they depend on in a row; those of one layer share no faces.
struct Layers {
  std::vector<Index> splits;
  std::vector<std::size_t> ends;
};

class LayerFinder {
 public:
  explicit LayerFinder(const ProgressiveMesh& mesh)
      : mesh_(mesh), depth_of_face_(mesh.n_faces(), 0), depth_of_vertex_(mesh.positions.size(), 0) {
    for (Index f = 0; f < mesh.n_faces(); ++f) {
      face_of_corner_.insert(face_of_corner_.end(), mesh.face_offsets[f + 1] - mesh.face_offsets[f], f);
    }
  }

  Layers find(std::size_t first, std::size_t last) {
    std::vector<std::pair<Index, Index>> depths;
    for (std::size_t s = first; s < last; ++s) {
      Index depth = 0;
      each_face(s, [&](Index f) { depth = std::max(depth, depth_of_face_[f]); });
      each_vertex(s, [&](Index v) { depth = std::max(depth, depth_of_vertex_[v]); });
      each_face(s, [&](Index f) { depth_of_face_[f] = depth + 1; });
      if (mesh_.splits[s].kept != k_no_index) depth_of_vertex_[mesh_.splits[s].removed] = depth + 1;
      depths.emplace_back(depth, static_cast<Index>(s));
    }
    for (std::size_t s = first; s < last; ++s) {
      each_face(s, [&](Index f) { depth_of_face_[f] = 0; });
      each_vertex(s, [&](Index v) { depth_of_vertex_[v] = 0; });
    }
    std::sort(depths.begin(), depths.end());
    Layers layers;
    for (std::size_t i = 0; i < depths.size(); ++i) {
      if (i > 0 && depths[i].first != depths[i - 1].first) layers.ends.push_back(i);
      layers.splits.push_back(depths[i].second);
    }
    layers.ends.push_back(depths.size());
    return layers;
  }

 private:
  template <typename Visit>
  void each_face(std::size_t split, Visit&& visit) const {
    const VertexSplit& s = mesh_.splits[split];
    const auto items = mesh_.items_of(split);
    for (std::size_t i = 0; i < items.size(); ++i) {
      const bool is_face = i >= s.n_corners && i < s.n_corners + s.n_faces;
      visit(is_face ? items[i] : face_of_corner_[items[i]]);
    }
  }

  /// The vertices that must be there, and the one that comes: triangles have both and a third.
  template <typename Visit>
  void each_vertex(std::size_t split, Visit&& visit) const {
    const VertexSplit& s = mesh_.splits[split];
    if (s.kept == k_no_index) return;
    visit(s.kept);
    visit(s.removed);
    for (const Index f : mesh_.items_of(split).subspan(s.n_corners, s.n_faces)) {
      for (Index c = mesh_.face_offsets[f]; c < mesh_.face_offsets[f + 1]; ++c)
        visit(mesh_.corner_vertices[c]);
    }
  }

  const ProgressiveMesh& mesh_;
  std::vector<Index> depth_of_face_, depth_of_vertex_, face_of_corner_;
};

/// Appends parts to the file and keeps account of what they hold.
class ChunkWriter {
 public:
  ChunkWriter() : bytes_(detail::k_pmesh_magic) { detail::append_u32(bytes_, detail::k_pmesh_version); }

  void add(std::string_view kind, const ByteStreams& streams) {
    std::array<std::size_t, static_cast<std::size_t>(ByteKind::count)> sizes{};
    const std::string payload = streams.pack(&sizes);
    append(kind, payload);
    if (kind == detail::k_chunk_base) report_.base_bytes += payload.size();
    if (kind == detail::k_chunk_numbering) report_.numbering_bytes += payload.size() + detail::k_chunk_header;
    if (kind == detail::k_chunk_splits) account(sizes);
  }
  void append(std::string_view kind, std::string_view payload) {
    std::string checked(kind);
    checked += payload;
    bytes_ += kind;
    detail::append_u32(bytes_, static_cast<std::uint32_t>(payload.size()));
    detail::append_u32(bytes_, detail::crc32(checked));
    bytes_ += payload;
  }
  std::string take(PmeshReport* report) {
    append(detail::k_chunk_end, {});
    report_.bytes = bytes_.size();
    if (report != nullptr) *report = report_;
    return std::move(bytes_);
  }
  PmeshReport& report() { return report_; }

 private:
  void account(std::span<const std::size_t> sizes) {
    const auto sum = [&](ByteKind first, ByteKind last) {
      return std::accumulate(sizes.begin() + static_cast<std::ptrdiff_t>(first),
                             sizes.begin() + static_cast<std::ptrdiff_t>(last) + 1, std::size_t{0});
    };
    ++report_.batches;
    report_.connectivity_bytes += sum(ByteKind::counts, ByteKind::moved) + detail::k_chunk_header;
    report_.position_bytes += sum(ByteKind::positions, ByteKind::positions_high);
    report_.attribute_bytes += sum(ByteKind::wedges, ByteKind::attributes_high);
    report_.error_bytes += sum(ByteKind::errors, ByteKind::errors_high);
  }

  std::string bytes_;
  PmeshReport report_;
};

const char* name_of(NumberLattice::Form form) {
  switch (form) {
    case NumberLattice::Form::floats:
      return "floats";
    case NumberLattice::Form::doubles:
      return "doubles";
    case NumberLattice::Form::decimals:
      return "decimals";
    case NumberLattice::Form::quantised:
      break;
  }
  return "quantised";
}

std::string encode(const ProgressiveMesh& mesh, std::vector<Material> materials, const PmeshOptions& options,
                   PmeshReport* report) {
  check(options);
  PmeshHeader header = make_header(mesh, options);
  header.materials = std::move(materials);
  const std::vector<std::size_t> ends = batch_ends(mesh);
  header.n_batches = ends.size();
  ChunkWriter writer;
  writer.report().positions = name_of(header.positions.form);
  writer.report().largest_move = header.quantisation_error;
  ByteStreams head;
  PmeshCodec::code_header(head, header, true);
  writer.add(detail::k_chunk_head, head);
  PmeshCodec codec(header, true);
  codec.start(mesh);
  ByteStreams base;
  codec.code_base(base);
  writer.add(detail::k_chunk_base, base);
  LayerFinder finder(mesh);
  std::size_t first = 0;
  for (const std::size_t end : ends) {
    Layers layers;
    if (header.keeps_order) {
      for (std::size_t s = first; s < end; ++s) layers.splits.push_back(static_cast<Index>(s));
    } else {
      layers = finder.find(first, end);
    }
    ByteStreams batch;
    codec.code_batch(batch, std::move(layers.splits), layers.ends);
    writer.add(detail::k_chunk_splits, batch);
    first = end;
  }
  if (header.has_numbering) {
    detail::PmeshNumbering numbering = find_numbering(mesh, header, codec.table(), codec.numbers());
    ByteStreams streams;
    detail::code_numbering<true>(streams, header, codec.table(), numbering);
    writer.add(detail::k_chunk_numbering, streams);
  }
  return writer.take(report);
}

}  // namespace

std::string encode_pmesh(const ProgressiveMesh& mesh, const PmeshOptions& options, PmeshReport* report) {
  return encode(mesh, mesh.materials, options, report);
}

PmeshReport write_pmesh(const std::filesystem::path& path, const ProgressiveMesh& mesh,
                        const PmeshOptions& options) {
  PmeshReport report;
  detail::OutputFile output;
  std::vector<Material> materials = detail::with_pictures_beside(path, mesh.materials, output);
  output.content = encode(mesh, std::move(materials), options, &report);
  for (const auto& [beside, content] : output.beside) write_file_atomically(beside, content);
  write_file_atomically(path, output.content);
  return report;
}

}  // namespace recede
