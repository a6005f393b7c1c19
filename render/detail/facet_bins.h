// Facets counted by their slopes, and put together to few groups.
#pragma once

#include <recede/render/facet_distribution.h>

#include <vector>

namespace recede::detail {

/// A slope's normal on the disk of equal areas, (x, y) / sqrt(1 + z), and back.
Vec2 place_of_slope(const Vec2& slope);
Vec2 slope_of_place(const Vec2& place);

/// Sums over facets.
struct FacetBin {
  double share = 0;
  Vec2 slopes = Vec2::Zero(), places = Vec2::Zero();
  double slope_squares = 0, place_squares = 0;

  void add(const FacetGroup& group);
  void add(const FacetBin& other, double part = 1);
  Vec2 place() const { return places / share; }
  /// Variance of places along one axis.
  double variance() const;
  FacetGroup group() const;
};

/// Counts facets whose places lie in a box: as they are while there are few, else by a grid of small bins.
class FacetBins {
 public:
  FacetBins(const Vec2& least, const Vec2& largest, std::size_t facets);
  void add(const FacetGroup& group);
  /// Those with a share.
  std::vector<FacetBin> filled() const;

 private:
  Vec2 least_, scale_;
  bool is_grid_;
  std::vector<FacetBin> bins_;
  std::vector<Vec2> slopes_;  // of the bins, when there is no grid
};

/// At least one bin, all with a share. Shares of the result sum to 1.
FacetDistribution group_bins(const std::vector<FacetBin>& bins);

}  // namespace recede::detail
