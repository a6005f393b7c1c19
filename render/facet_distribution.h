// Which facets a displaced surface consists of, for views from so far that they can't be told apart.
#pragma once

#include <recede/geometry/displacement_map.h>
#include <recede/geometry/progress.h>
#include <recede/geometry/vec.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace recede {

/// Facets of about one slope. Slopes are dz/dx and dz/dy of a surface (x, y, z), so their normal is (-slope,
/// 1) over its length.
struct FacetGroup {
  double share = 0;           ///< of the base's area, which is how much is seen of them from straight above
  Vec2 slope = Vec2::Zero();  ///< their mean
  double spread = 0;          ///< RMS distance of their slopes from it, along one axis
};

/// All facets of a piece of a surface. Shares sum to 1.
struct FacetDistribution {
  static constexpr std::size_t k_most_groups = 14;

  std::size_t count = 0;
  std::array<FacetGroup, k_most_groups> stored{};

  std::span<const FacetGroup> groups() const { return std::span(stored).first(count); }
  /// That of the plane through the piece.
  Vec2 mean_slope() const;
};

/// Puts groups together until 14 are left, near ones first; shares needn't sum to 1. Up to 14 slopes stay as
/// they are. Beyond, the mean slope is kept, and so is the mean square of slopes, by spreads; what is lost is
/// the shape of the distribution inside of a group. Near is by angles: groups are those of a mixture of
/// Gaussians on the disk of equal areas, found by expectation and maximization (Dempster, Laird and Rubin
/// 1977). Throws `InputError` unless all numbers are finite, slopes and spreads at most 1e6, no share or
/// spread is below 0, and some share is above.
FacetDistribution merge_facets(std::span<const FacetGroup> groups);

/// A distribution in 64 bytes: a byte for each of a group's share, its spread, and the two coordinates of its
/// normal on the disk of equal areas, and eight bytes for the square of the disk in which they lie and the
/// largest spread. Shares are rounded to 1/255, normals to half of 1/127 of half of the square's side; groups
/// of less than half a 255th may be lost.
class PackedFacets {
 public:
  PackedFacets() = default;
  explicit PackedFacets(const FacetDistribution& facets);

  FacetDistribution unpacked() const;
  bool operator==(const PackedFacets&) const = default;

 private:
  struct Group {
    std::uint8_t share = 0;  // 0: none
    std::int8_t x = 0, y = 0;
    std::uint8_t spread = 0;
    bool operator==(const Group&) const = default;
  };
  std::array<std::uint16_t, 4> frame_{};  // upper halves of floats: middle x, y, half a side, largest spread
  std::array<Group, FacetDistribution::k_most_groups> groups_{};
};
static_assert(sizeof(PackedFacets) == 64);

struct FacetOptions {
  /// Lengths of the map along u and v, in the units of its heights; see `DisplacedPlane`.
  Vec2 sides = Vec2::Ones();
  /// Slopes along a side of a texel: 1 to 64. Two find each of the four cells that meet in a texel at its
  /// middle.
  int samples = 2;
};

/// Facets of the whole map: for a surface on which copies of it lie side by side. Throws as `FacetLevels`.
FacetDistribution facets_of(const DisplacementMap& map, const FacetOptions& options = {});

/// Distributions for each texel of a map and of its coarser levels, 64 bytes each, or 85 for a texel of the
/// map. Each further level has half the texels a side, rounded up, down to one; level l's texel (x, y) covers
/// the map's from (2^l x, 2^l y) on. All are made from the map's slopes, none from a coarser distribution.
class FacetLevels {
 public:
  /// Same for any number of threads. Throws `OptionError` unless sides are finite and greater than 0 and
  /// samples in range, and `Cancelled`.
  explicit FacetLevels(const DisplacementMap& map, const FacetOptions& options = {},
                       Progress* progress = nullptr);

  int count() const { return static_cast<int>(levels_.size()); }
  int columns(int level) const { return levels_[static_cast<std::size_t>(level)].columns; }
  int rows(int level) const { return levels_[static_cast<std::size_t>(level)].rows; }
  const PackedFacets& texel(int level, int x, int y) const {
    const Level& found = levels_[static_cast<std::size_t>(level)];
    return texels_[found.first + static_cast<std::size_t>(y) * static_cast<std::size_t>(found.columns) +
                   static_cast<std::size_t>(x)];
  }
  std::size_t bytes() const { return texels_.size() * sizeof(PackedFacets); }

 private:
  struct Level {
    int columns = 0, rows = 0;
    std::size_t first = 0;
  };
  std::vector<Level> levels_;
  std::vector<PackedFacets> texels_;  // level by level, row by row
};

}  // namespace recede
