// How a split changes the faces around its vertex, in few bytes.
#include <recede/lod/detail/pmesh_codec.h>

#include <algorithm>
#include <array>

namespace recede::detail {
namespace {

/// What becomes of a corner at the kept vertex.
enum Label : std::uint8_t { k_stays, k_given, k_added_before, k_added_after };

}  // namespace

/// Labels of the ring's corners and the triangles that come, and how they are best said.
void PmeshCodec::choose_shape(Index number) {
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
bool PmeshCodec::find_run() {
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

void PmeshCodec::code_shape() {
  const std::size_t n = ring_.corners.size();
  if (!writes_) {
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
    if (!writes_) {
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
    if (writes_) triangle = triangles_[i];
    std::uint8_t turned = triangle.turned ? 1 : 0;
    byte(ByteKind::flags, turned);
    varint(ByteKind::vertices, triangle.third);
    require(triangle.third < table_.n_vertices(), "a triangle names a vertex that isn't there");
    if (!writes_) triangles_.push_back({k_no_index, turned != 0, triangle.third});
  }
}

void PmeshCodec::apply_shape(Index kept, Index removed) {
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
    if (writes_) {
      const Index face = mesh_face_of(numbers_.corner[corners[i]]);
      mesh_corner =
          std::find_if(cuts_.begin(), cuts_.end(), [&](const auto& c) { return c.first == face; })->second;
      mesh_corner_alive_[mesh_corner] = 1;
    }
    note_corner(added, mesh_corner);
    items_.push_back(added);
  }
}

void PmeshCodec::add_triangle(Index mesh_face, bool turned, Index kept, Index third, Index removed) {
  const std::array<Index, 3> vertices =
      turned ? std::array<Index, 3>{removed, third, kept} : std::array<Index, 3>{kept, third, removed};
  const Index face = table_.add_face(vertices);
  items_.push_back(face);
  std::vector<Index> corners;
  if (writes_) {
    numbers_.face.push_back(mesh_face);
    numbers_.file_face[mesh_face] = face;
    corners = alive_corners(mesh_face);
    const auto first = std::find_if(corners.begin(), corners.end(), [&](Index c) {
      return numbers_.file_vertex[mesh_->corner_vertices[c]] == vertices[0];
    });
    std::rotate(corners.begin(), first, corners.end());
  }
  for (Index k = 0; k < 3; ++k) note_corner(table_.face_corner(face) + k, writes_ ? corners[k] : k_no_index);
  if (!header_.has_face_materials) return;
  Index material = 0;
  if (writes_) material = mesh_->face_materials[mesh_face] + 1;
  varint(ByteKind::faces, material);
  require(material <= header_.materials.size(), "a face names a material that isn't there");
  if (!writes_) read_.face_materials.push_back(material - 1);
}

}  // namespace recede::detail
