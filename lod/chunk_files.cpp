#include <recede/geometry/detail/same_positions.h>
#include <recede/lod/detail/chunk_files.h>
#include <recede/lod/detail/list_bytes.h>
#include <recede/lod/detail/soup_pieces.h>

#include <algorithm>
#include <numeric>

namespace recede::detail {

Vec3 middle_of(const PolygonSoup& soup, std::size_t face) {
  Vec3 sum = Vec3::Zero();
  for (const Index v : soup.face(face)) sum += soup.positions[v];
  return sum / static_cast<double>(soup.face_size(face));
}

ChunkFiles::ChunkFiles(const std::filesystem::path& folder, SpaceCells cells, std::size_t buffer)
    : cells_(std::move(cells)), file_(folder), buffer_(buffer), chunks_(cells_.size()) {}

void ChunkFiles::add(const PolygonSoup& piece) {
  if (materials_.size() < piece.materials.size()) materials_ = piece.materials;
  std::vector<Index> cell_of_vertex, cell_of_face, faces(piece.n_faces());
  for (const Vec3& p : piece.positions) cell_of_vertex.push_back(cells_.find(p));
  for (std::size_t f = 0; f < piece.n_faces(); ++f) cell_of_face.push_back(cells_.find(middle_of(piece, f)));
  std::iota(faces.begin(), faces.end(), Index{0});
  std::stable_sort(faces.begin(), faces.end(),
                   [&](Index f, Index g) { return cell_of_face[f] < cell_of_face[g]; });
  for (auto first = faces.begin(); first != faces.end();) {
    const Index cell = cell_of_face[*first];
    const auto last = std::find_if(first, faces.end(), [&](Index f) { return cell_of_face[f] != cell; });
    add_faces(piece, {first, last}, cell, cell_of_vertex);
    first = last;
  }
  if (waiting_ > buffer_) flush();
}

void ChunkFiles::add_faces(const PolygonSoup& piece, std::span<const Index> faces, Index cell,
                           const std::vector<Index>& cell_of_vertex) {
  std::vector<Index> vertices, shared;
  const PolygonSoup soup = cut_out(piece, faces, vertices);
  Stored& chunk = chunks_[cell];
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    chunk.box.extend(soup.positions[i]);
    const Index home = cell_of_vertex[vertices[i]];
    if (home == cell) continue;
    // Its own cell hears of it, and any third one finds it away from home as well.
    shared.push_back(static_cast<Index>(i));
    chunks_[home].shared.push_back(soup.positions[i]);
    waiting_ += sizeof(Vec3);
  }
  for (std::size_t f = 0; f < soup.n_faces(); ++f) chunk.area += vector_area(soup, f).norm();
  chunk.n_faces += faces.size();
  const std::size_t before = chunk.waiting.size();
  put_list(chunk.waiting, to_bytes(soup));
  put_list(chunk.waiting, shared);
  waiting_ += chunk.waiting.size() - before;
}

void ChunkFiles::flush() {
  for (Stored& chunk : chunks_) {
    if (chunk.waiting.empty() && chunk.shared.empty()) continue;
    std::string bytes;
    put_list(bytes, chunk.shared);
    chunk.extents.push_back(file_.append(bytes + chunk.waiting));
    chunk.waiting = {};
    chunk.shared = {};
  }
  waiting_ = 0;
}

void ChunkFiles::finish() { flush(); }

std::size_t ChunkFiles::n_faces() const {
  std::size_t n = 0;
  for (const Stored& chunk : chunks_) n += chunk.n_faces;
  return n;
}

Chunk ChunkFiles::load(std::size_t number) const {
  const Stored& stored = chunks_[number];
  Chunk chunk;
  std::vector<Index> shared;
  std::vector<Vec3> shared_places;
  for (const ScratchFile::Extent& extent : stored.extents) {
    const std::string content = file_.read(extent);
    std::string_view bytes = content;
    const std::vector<Vec3> places = take_list<Vec3>(bytes);
    shared_places.insert(shared_places.end(), places.begin(), places.end());
    while (!bytes.empty()) {
      const std::vector<char> soup = take_list<char>(bytes);
      const auto first = static_cast<Index>(chunk.soup.positions.size());
      append(chunk.soup, soup_from_bytes({soup.data(), soup.size()}));
      for (const Index v : take_list<Index>(bytes)) shared.push_back(first + v);
    }
  }
  chunk.soup.materials = materials_;
  // All vertices at one place are shared when one of them is.
  std::vector<Vec3> all = chunk.soup.positions;
  const std::size_t n = all.size();
  all.insert(all.end(), shared_places.begin(), shared_places.end());
  const std::vector<Index> lowest = lowest_at_same_position(all);
  std::vector<unsigned char> is_shared(all.size(), 0);
  for (const Index v : shared) is_shared[lowest[v]] = 1;
  for (std::size_t i = n; i < all.size(); ++i) is_shared[lowest[i]] = 1;
  for (std::size_t v = 0; v < n; ++v) chunk.shared.push_back(is_shared[lowest[v]]);
  return chunk;
}

}  // namespace recede::detail
