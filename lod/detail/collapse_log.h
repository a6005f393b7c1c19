// What the collapses of a run did, in the numbers of the table as it was built: enough to undo them.
#pragma once

#include <recede/lod/detail/corner_table.h>

#include <span>

namespace recede::detail {

struct EdgeRings;

/// One entry for each collapse, or for parts that were dropped together. Entries of patches that share no
/// face may be put one after the other in any order.
class CollapseLog {
 public:
  /// A view of one entry. Vertices and faces are those of the soup that the table was built from, corners
  /// those of the table as it was built, wedges those of the table.
  struct Entry {
    Index removed = k_no_index, kept = k_no_index;  ///< k_no_index: parts were dropped
    std::span<const Index> given;                   ///< corners that went from removed to kept
    std::span<const Index> given_wedges;            ///< what they then had
    std::span<const Index> faces;                   ///< that vanished
    std::span<const Index> cut;                     ///< corners taken out of larger faces
    std::span<const Index> around;                  ///< further faces at the kept point
    std::span<const Index> wedges;                  ///< those at the kept point afterwards
    std::span<const Index> features;                ///< 2 * corner + flag for the sides at the kept point
    double deviation = 0;                           ///< table units
    Vec3 position = Vec3::Zero();                   ///< of the kept point afterwards, table units
    std::span<const double> colors, scalars;        ///< of the kept point afterwards
    std::span<const double> wedge_values;           ///< five for each of `wedges`: uv, normal
  };

  /// Before a collapse is carried out; `rings` are those of the edge.
  void begin(const CornerTable& table, const EdgeRings& rings, const Collapse& collapse, double deviation);
  /// After it.
  void end(const CornerTable& table, const Collapse& collapse);
  /// `faces` of the input were dropped with their parts.
  void add_drop(const std::vector<Index>& faces, double deviation);
  void append(const CollapseLog& other);

  std::size_t size() const { return size_; }

  /// What tables have that decides what entries hold.
  struct Format {
    explicit Format(const CornerTable& table)
        : wedges(!table.wedge.empty()), colors(!table.colors.empty()), n_scalars(table.scalar_names.size()) {}
    bool wedges, colors;
    std::size_t n_scalars;
  };
  /// Calls `visit(Entry)` for each entry in order. `format` is that of the table that was logged.
  template <typename Visit>
  void each(const Format& format, Visit&& visit) const {
    std::size_t word = 0, number = 0;
    while (word < words_.size()) visit(read(format, word, number));
  }

 private:
  static constexpr std::size_t k_header = 8;
  Entry read(const Format& format, std::size_t& word, std::size_t& number) const;

  std::vector<Index> words_;
  std::vector<double> numbers_;
  std::size_t header_ = 0, size_ = 0;
};

}  // namespace recede::detail
