#include <recede/lod/detail/pmesh_table.h>

#include <algorithm>

namespace recede::detail {

Index PmeshTable::add_vertex() {
  first_.push_back(k_no_index);
  return static_cast<Index>(first_.size() - 1);
}

Index PmeshTable::new_corner(Index vertex, Index face) {
  const auto corner = static_cast<Index>(vertex_.size());
  for (auto* const list : {&vertex_, &next_, &previous_, &ring_next_, &ring_previous_})
    list->push_back(corner);
  face_.push_back(face);
  link(corner, vertex);
  return corner;
}

/// Puts the corner last in the ring of the vertex.
void PmeshTable::link(Index corner, Index vertex) {
  vertex_[corner] = vertex;
  const Index first = first_[vertex];
  if (first == k_no_index) {
    first_[vertex] = ring_next_[corner] = ring_previous_[corner] = corner;
    return;
  }
  const Index last = ring_previous_[first];
  ring_next_[corner] = first;
  ring_previous_[corner] = last;
  ring_next_[last] = ring_previous_[first] = corner;
}

void PmeshTable::unlink(Index corner) {
  Index& first = first_[vertex_[corner]];
  if (ring_next_[corner] == corner) {
    first = k_no_index;
    return;
  }
  if (first == corner) first = ring_next_[corner];
  ring_next_[ring_previous_[corner]] = ring_next_[corner];
  ring_previous_[ring_next_[corner]] = ring_previous_[corner];
}

Index PmeshTable::add_face(std::span<const Index> vertices) {
  const auto face = static_cast<Index>(n_faces()), first = static_cast<Index>(n_corners());
  const auto size = static_cast<Index>(vertices.size());
  face_corner_.push_back(first);
  for (Index i = 0; i < size; ++i) {
    new_corner(vertices[i], face);
    next_[first + i] = i + 1 == size ? first : first + i + 1;
    previous_[first + i] = i == 0 ? first + size - 1 : first + i - 1;
  }
  return face;
}

Index PmeshTable::add_corner(Index corner, bool before, Index vertex) {
  const Index added = new_corner(vertex, face_[corner]);
  const Index left = before ? previous_[corner] : corner, right = next_[left];
  next_[left] = previous_[right] = added;
  previous_[added] = left;
  next_[added] = right;
  return added;
}

void PmeshTable::give(Index corner, Index vertex) {
  unlink(corner);
  link(corner, vertex);
}

void PmeshTable::read_ring(Index of_vertex, VertexRing& ring) const {
  ring.corners.clear();
  ring.is_fan = ring.is_closed = false;
  each_corner(of_vertex, [&](Index corner) { ring.corners.push_back(corner); });
  // Rings of hubs stay in the order of their lists: sorting them pair by pair would take quadratic time.
  constexpr std::size_t k_most = 128;
  if (ring.corners.empty() || ring.corners.size() > k_most) return;
  const auto out = [&](Index corner) { return vertex_[next_[corner]]; };
  const auto in = [&](Index corner) { return vertex_[previous_[corner]]; };
  const auto begins = [&](Index corner) {
    return std::none_of(ring.corners.begin(), ring.corners.end(),
                        [&](Index c) { return in(c) == out(corner); });
  };
  const auto start = std::find_if(ring.corners.begin(), ring.corners.end(), begins);
  ring.is_closed = start == ring.corners.end();
  if (!ring.is_closed) std::iter_swap(ring.corners.begin(), start);
  std::size_t placed = 1;
  for (; placed < ring.corners.size(); ++placed) {
    const auto from = ring.corners.begin() + static_cast<std::ptrdiff_t>(placed);
    const Index reached = in(*(from - 1));
    const auto following = std::find_if(from, ring.corners.end(), [&](Index c) { return out(c) == reached; });
    if (following == ring.corners.end()) break;
    std::iter_swap(from, following);
  }
  ring.is_fan = placed == ring.corners.size();
  ring.is_closed = ring.is_closed && ring.is_fan && in(ring.corners.back()) == out(ring.corners.front());
}

}  // namespace recede::detail
