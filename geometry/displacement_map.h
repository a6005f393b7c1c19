// Height maps with bilinear lookup, and bounds of their heights over any part of them.
#pragma once

#include <recede/geometry/raster.h>
#include <recede/geometry/vec.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <type_traits>
#include <vector>

namespace recede {

/// What lies beyond the border of a map: its border texels, or its opposite side.
enum class MapBorder { clamped, periodic };

/// Heights over the unit square. As in `BakedMaps`, the texel (x, y) has its middle at u = (x + 0.5) /
/// columns, v = 1 - (y + 0.5) / rows, and between middles heights are bilinear.
///
/// The middles of neighbouring texels span cells, and heights over a cell are one bilinear patch. There are
/// columns + 1 times rows + 1 of them: cell (i, j) lies between the texel columns i - 1 and i, rows j - 1 and
/// j. Those along the border of the square are cut in half by it.
class DisplacementMap {
 public:
  /// height = offset + scale * sample / (2^bits - 1), object units: what `bake_maps` gives. Throws
  /// `InputError` unless the raster is grey, of 8 or 16 bits, has texels and as many samples, and
  /// `OptionError` unless scale and offset are finite.
  DisplacementMap(Raster samples, double scale, double offset, MapBorder border = MapBorder::clamped);
  /// `heights` row by row, row 0 on top, object units. Throws `InputError` unless there are columns x rows of
  /// them, at least one, all finite.
  DisplacementMap(int columns, int rows, std::vector<float> heights, MapBorder border = MapBorder::clamped);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  MapBorder border() const { return border_; }
  /// Bits of a sample; 0 for floats.
  int bits() const { return bits_; }
  double scale() const { return scale_; }
  double offset() const { return offset_; }
  std::size_t bytes() const { return 2 * whole_.size() + 4 * floats_.size(); }

  /// Height at a texture coordinate, object units; outside the unit square as `border` says. Never beyond the
  /// heights of the four texels around, in spite of rounding.
  double height_at(const Vec2& uv) const;
  /// Its derivatives for a step of 1 in u and in v. They jump between cells; on the line between two, those
  /// of the one of larger number hold. 0 across a clamped border.
  Vec2 derivative_at(const Vec2& uv) const;
  /// The same without jumps, for shading that doesn't show texels: central differences of texels, bilinear
  /// between their middles.
  Vec2 smooth_derivative_at(const Vec2& uv) const;
  /// Height of a texel, 0 <= x < columns, 0 <= y < rows.
  double texel(int x, int y) const { return height_of(sample(x, y)); }

  /// The samples as they are stored, and the height of a sample (or of a mean of some). It grows with the
  /// sample, rounding included, or falls when the scale is negative.
  double sample(int x, int y) const {
    const std::size_t at =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
    return whole_.empty() ? static_cast<double>(floats_[at]) : whole_[at];
  }
  double height_of(double sample) const { return offset_ + scale_ * sample / most_; }
  const std::vector<std::uint16_t>& whole_samples() const { return whole_; }
  const std::vector<float>& float_samples() const { return floats_; }

  /// The texel that stands at column or row `k`, from -1 to columns or rows: the border's rule.
  int column(int k) const { return inside(k, columns_); }
  int row(int k) const { return inside(k, rows_); }

  /// A place along one axis: a cell, and where in it from the texel before (0) to the texel after (1).
  struct CellPlace {
    int cell = 0;
    double fraction = 0;
  };
  CellPlace column_place(double u) const { return place(u, columns_); }
  CellPlace row_place(double v) const { return place(1 - v, rows_); }

 private:
  int inside(int k, int count) const {
    if (k < 0) return border_ == MapBorder::periodic ? count - 1 : 0;
    if (k >= count) return border_ == MapBorder::periodic ? 0 : count - 1;
    return k;
  }
  CellPlace place(double coordinate, int count) const;
  struct Corners;
  Corners corners_at(const Vec2& uv) const;

  int columns_ = 0, rows_ = 0, bits_ = 0;
  MapBorder border_ = MapBorder::clamped;
  double scale_ = 1, offset_ = 0, most_ = 1;
  std::vector<std::uint16_t> whole_;  // one of the two is empty
  std::vector<float> floats_;
};

/// The map with a length added to all heights, object units. Floats stay floats, whole samples whole.
DisplacementMap raise_heights(const DisplacementMap& map, double height);

/// How the numbers of a file become heights.
struct DisplacementMapOptions {
  /// height = offset + scale * value, object units. Values of PNG files run from 0 to 1, those of OpenEXR
  /// files are the numbers that they hold.
  double scale = 1, offset = 0;
  MapBorder border = MapBorder::clamped;
};

/// Reads a grey PNG file, which keeps its bits, or an OpenEXR file with one channel or one of the name Y.
/// Throws `InputError` for anything else and for heights that aren't finite, with the file's name, and
/// `OptionError` for numbers that aren't finite.
DisplacementMap read_displacement_map(const std::filesystem::path& path,
                                      const DisplacementMapOptions& options = {});

/// From the least to the largest height, object units.
struct HeightRange {
  double min = 0, max = 0;
  bool operator==(const HeightRange&) const = default;
};

/// A pyramid of least and largest heights over the cells of a map. A node of level 0 is a cell; one of level
/// l is a square of 2^l cells a side, cut off where the map ends; the last level is one node. Levels from 1
/// on are stored with the bits of the map, a third of its size for the least and a third for the largest
/// heights: both are heights of texels, so nothing is rounded. Keeps a reference to the map, which must stay
/// in place.
class HeightBounds {
 public:
  /// Same for any number of threads.
  explicit HeightBounds(const DisplacementMap& map);
  explicit HeightBounds(DisplacementMap&&) = delete;

  const DisplacementMap& map() const { return *map_; }
  int levels() const { return static_cast<int>(levels_.size()); }
  int columns(int level) const { return levels_[static_cast<std::size_t>(level)].columns; }
  int rows(int level) const { return levels_[static_cast<std::size_t>(level)].rows; }
  std::size_t bytes() const { return 4 * whole_.size() + 8 * floats_.size(); }

  template <typename Sample>
  struct Pair {
    Sample min, max;
  };
  /// The stored nodes of a level from 1 on, row by row: samples as the map has them. `Sample` is
  /// std::uint16_t for maps of whole numbers, float for others.
  template <typename Sample>
  const Pair<Sample>* stored_nodes(int level) const {
    const std::size_t first = levels_[static_cast<std::size_t>(level)].first;
    if constexpr (std::is_same_v<Sample, float>) {
      return floats_.data() + first;
    } else {
      return whole_.data() + first;
    }
  }

  /// The range of heights over a node.
  HeightRange node(int level, int x, int y) const { return heights(samples_of_node(level, x, y)); }

  /// The range over a rectangle of cells, first and last included. Exact. `quick` looks at four nodes at most
  /// and gives a range that holds the exact one.
  HeightRange of_cells(int x0, int y0, int x1, int y1) const;
  HeightRange quick(int x0, int y0, int x1, int y1) const;

  /// Holds all that `height_at` gives for texture coordinates between the two corners (those outside the unit
  /// square too): the exact range of the cells that the box touches.
  HeightRange of_box(const Vec2& least, const Vec2& largest) const;

 private:
  struct Level {
    int columns = 0, rows = 0;
    std::size_t first = 0;
  };
  struct CellRectangle {
    int x0, y0, x1, y1;
  };
  using Samples = Pair<double>;

  template <typename Sample>
  void build(const std::vector<Sample>& samples, std::vector<Pair<Sample>>& pairs);
  template <typename Sample>
  void build_first_level(const std::vector<Sample>& samples, std::vector<Pair<Sample>>& pairs) const;
  Samples samples_of_node(int level, int x, int y) const;
  void extend(Samples& range, const CellRectangle& cells, int level, int x, int y) const;
  Samples samples_of(const CellRectangle& cells) const;
  HeightRange heights(const Samples& samples) const;

  const DisplacementMap* map_;
  std::vector<Level> levels_;
  std::vector<Pair<std::uint16_t>> whole_;  // levels from 1 on, row by row; one of the two is empty
  std::vector<Pair<float>> floats_;
};

}  // namespace recede
