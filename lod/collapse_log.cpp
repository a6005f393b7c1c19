#include <recede/lod/detail/collapse_log.h>
#include <recede/lod/detail/collapse_rules.h>

#include <algorithm>

namespace recede::detail {
namespace {

/// Places in the header of an entry; its lists follow in this order.
enum Header : std::size_t { k_removed, k_kept, k_given, k_faces, k_cut, k_around, k_wedges, k_features };

}  // namespace

void CollapseLog::begin(const CornerTable& table, const EdgeRings& rings, const Collapse& collapse,
                        double deviation) {
  header_ = words_.size();
  words_.resize(header_ + k_header, 0);
  words_[header_ + k_removed] = table.source_vertex[collapse.removed];
  words_[header_ + k_kept] = table.source_vertex[collapse.kept];
  const auto add = [&](Header list, Index value) {
    words_.push_back(value);
    ++words_[header_ + list];
  };
  for (const RingCorner& c : rings.removed) {
    if (!c.on_edge) add(k_given, table.source_corner[c.corner]);
  }
  // The wedges of these are known afterwards, when this list is written over.
  if (!table.wedge.empty()) {
    for (const RingCorner& c : rings.removed) {
      if (!c.on_edge) words_.push_back(c.corner);
    }
  }
  for (const RingCorner& c : rings.removed) {
    if (c.on_edge && c.size == 3) add(k_faces, table.source_face[c.face]);
  }
  for (const RingCorner& c : rings.removed) {
    if (c.on_edge && c.size > 3) add(k_cut, table.source_corner[c.corner]);
  }
  for (const RingCorner& c : rings.kept) {
    if (!c.on_edge) add(k_around, table.source_face[c.face]);
  }
  numbers_.push_back(deviation);
}

void CollapseLog::end(const CornerTable& table, const Collapse& collapse) {
  const Index kept = collapse.kept;
  numbers_.insert(numbers_.end(), table.positions[kept].begin(), table.positions[kept].end());
  if (!table.colors.empty()) {
    numbers_.insert(numbers_.end(), table.colors[kept].begin(), table.colors[kept].end());
  }
  const double* const scalars = table.point_scalars(kept);
  numbers_.insert(numbers_.end(), scalars, scalars + table.scalar_names.size());
  if (!table.wedge.empty()) {
    const std::size_t n_given = words_[header_ + k_given];
    Index* const given = words_.data() + header_ + k_header + n_given;
    for (std::size_t i = 0; i < n_given; ++i) given[i] = table.wedge[given[i]];
    const std::size_t first = words_.size();
    table.each_corner(kept, [&](Index corner) {
      const Index wedge = table.wedge[corner];
      if (std::find(words_.begin() + static_cast<std::ptrdiff_t>(first), words_.end(), wedge) != words_.end())
        return;
      words_.push_back(wedge);
      const Wedge& w = table.wedges[wedge];
      numbers_.insert(numbers_.end(), w.uv.begin(), w.uv.end());
      numbers_.insert(numbers_.end(), w.normal.begin(), w.normal.end());
    });
    words_[header_ + k_wedges] = static_cast<Index>(words_.size() - first);
  }
  if (!table.feature.empty()) {
    const std::size_t first = words_.size();
    table.each_corner(kept, [&](Index corner) {
      for (const Index side : {corner, table.previous(corner)}) {
        words_.push_back(2 * table.source_corner[side] + table.feature[side]);
      }
    });
    words_[header_ + k_features] = static_cast<Index>(words_.size() - first);
  }
  ++size_;
}

void CollapseLog::add_drop(const std::vector<Index>& faces, double deviation) {
  words_.insert(words_.end(), {k_no_index, k_no_index, 0, static_cast<Index>(faces.size()), 0, 0, 0, 0});
  words_.insert(words_.end(), faces.begin(), faces.end());
  numbers_.push_back(deviation);
  ++size_;
}

void CollapseLog::append(const CollapseLog& other) {
  words_.insert(words_.end(), other.words_.begin(), other.words_.end());
  numbers_.insert(numbers_.end(), other.numbers_.begin(), other.numbers_.end());
  size_ += other.size_;
}

CollapseLog::Entry CollapseLog::read(const Format& format, std::size_t& word, std::size_t& number) const {
  const Index* const header = words_.data() + word;
  word += k_header;
  const auto words = [&](std::size_t n) {
    const std::span<const Index> list(words_.data() + word, n);
    word += n;
    return list;
  };
  const auto numbers = [&](std::size_t n) {
    const std::span<const double> list(numbers_.data() + number, n);
    number += n;
    return list;
  };
  Entry entry;
  entry.removed = header[k_removed];
  entry.kept = header[k_kept];
  entry.given = words(header[k_given]);
  if (format.wedges) entry.given_wedges = words(header[k_given]);
  entry.faces = words(header[k_faces]);
  entry.cut = words(header[k_cut]);
  entry.around = words(header[k_around]);
  entry.wedges = words(header[k_wedges]);
  entry.features = words(header[k_features]);
  entry.deviation = numbers(1)[0];
  if (entry.removed == k_no_index) return entry;
  const auto position = numbers(3);
  entry.position = {position[0], position[1], position[2]};
  if (format.colors) entry.colors = numbers(4);
  entry.scalars = numbers(format.n_scalars);
  entry.wedge_values = numbers(5 * entry.wedges.size());
  return entry;
}

}  // namespace recede::detail
