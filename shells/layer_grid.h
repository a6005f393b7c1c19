// Where in space the texels of a texture are that fills one layer of a shell once.
#pragma once

#include <recede/shells/shell.h>

#include <array>
#include <memory>
#include <vector>

namespace recede {

/// A grid over texture coordinates from 0 to 1 whose columns of texels stand on the shell's base. Texels
/// around charts, up to `k_gutter` of them, belong to the nearest triangle, which goes on there as a plane,
/// so that what is between texels' middles is known at charts' borders, too.
class LayerGrid {
 public:
  static constexpr double k_gutter = 2.5;  ///< texels: gradients look one and a half farther than a middle

  struct Column {
    Index triangle = k_no_index;  ///< none: there is no layer
    bool is_in_chart = false;     ///< the middle is in the triangle, not around it
    Vec3 weights = Vec3::Zero();  ///< of the triangle's corners, below 0 outside of it
    /// In a hexahedron: the first of its two triangles, and how far along the quad's sides, 0 to 1.
    Index quad = k_no_index;
    Vec2 along_quad = Vec2::Zero();
  };

  /// Coordinates are those of the shell's base. Throws `InputError` for a shell without the layer or without
  /// texture coordinates, or where these leave 0 to 1 or lie above each other, so that a texel would be at
  /// two places; `OptionError` for an envelope's both sides at once, sizes below 1 and more texels than
  /// `k_most_texels`.
  LayerGrid(std::shared_ptr<const Shell> shell, ShellSide side, const std::array<int, 3>& size);

  const Shell& shell() const { return *shell_; }
  const ShellLayer& layer() const { return *layer_; }
  const std::array<int, 3>& size() const { return size_; }
  const Column& column(int i, int j) const {
    return columns_[static_cast<std::size_t>(j) * static_cast<std::size_t>(size_[0]) +
                    static_cast<std::size_t>(i)];
  }
  /// Of a texel's middle; the column must be there.
  Vec3 point(int i, int j, int k) const;
  /// Longest side of a column's texels halfway up, object units.
  double texel_side(int i, int j) const;
  /// Space that a texel takes, object units to the third; around charts 0.
  double texel_volume(int i, int j, int k) const;
  /// Lengths on the average that coordinates from 0 to 1 run over, halfway up; the layer's thickness.
  const Vec3& mean_extent() const { return mean_extent_; }
  /// Triangles that got no column: they are smaller than texels are apart.
  std::size_t missed() const { return missed_; }

 private:
  void set_columns();
  void set_quads();
  void set_texel_sides();
  double quad_volume(const Column& at, double height) const;

  std::shared_ptr<const Shell> shell_;
  const ShellLayer* layer_;
  std::array<int, 3> size_;
  std::vector<Column> columns_;
  std::vector<double> texel_sides_;  // of vertices, means over the texels around each
  Vec3 mean_extent_ = Vec3::Ones();
  std::size_t missed_ = 0;
};

}  // namespace recede
