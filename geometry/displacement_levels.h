// Coarser levels of a height map, and heights for a footprint.
#pragma once

#include <recede/geometry/displacement_map.h>
#include <recede/geometry/progress.h>

#include <vector>

namespace recede {

/// How a level's heights come about (Gumhold and Huettner 1999, "Multiresolution rendering with displacement
/// mapping").
enum class LevelRule {
  mean,         ///< of the heights that a texel covers, by area
  least_volume  ///< least volume between the level's surface and the map's, both bilinear
};

/// Of several heights in a footprint: peaks keep silhouettes high seen from the front of the surface, valleys
/// from its back.
enum class HeightFilter { mean, highest, lowest };

struct LevelOptions {
  LevelRule rule = LevelRule::mean;
  /// Steps of one length in search of the least volume; there are eleven lengths, each half of the one
  /// before. A length is left early when it doesn't help any more.
  int steps = 150;
};

/// How far a level's surface is from the map's at the middles of the map's texels, along the height.
struct LevelDifference {
  double mean = 0, max = 0;  ///< object units
};

/// How a footprint is sampled: `samples` places along its longer side, in `level` (a fraction blends two).
struct FootprintSampling {
  double level = 0;
  int samples = 1;
};

/// The rule for a footprint whose sides have these lengths, counted in texels of level 0. At most eight
/// samples.
FootprintSampling sampling_of(double longer, double shorter);

/// A pyramid of maps over the same unit square. Level 0 is the map itself; each further one has half the
/// texels a side, rounded up, down to one texel, with the bits, scale, offset and border of the map. Levels
/// are made from the map or from means of it, never from a rounded level. Keeps a reference to the map, which
/// must stay in place. Levels from 1 on take a third of its memory.
class DisplacementLevels {
 public:
  /// Same for any number of threads. Least volumes are found by descent (equation 12 of the source) with the
  /// exact gradient, from the means; the best heights seen are kept, so no level is worse than its means but
  /// for rounding to the bits of the map. Throws `OptionError` for steps < 1, and `Cancelled`.
  explicit DisplacementLevels(const DisplacementMap& map, const LevelOptions& options = {},
                              Progress* progress = nullptr);
  explicit DisplacementLevels(DisplacementMap&&, const LevelOptions& = {}, Progress* = nullptr) = delete;

  int count() const { return static_cast<int>(coarser_.size()) + 1; }
  const DisplacementMap& level(int number) const {
    return number == 0 ? *map_ : coarser_[static_cast<std::size_t>(number) - 1];
  }
  LevelDifference difference(int number) const { return differences_[static_cast<std::size_t>(number)]; }

  /// Bilinear height in a level from 0 to count() - 1; between whole numbers both neighbours are blended.
  double height_at(const Vec2& uv, double level) const;

  /// Height for the parallelogram around `middle` with these two sides, in texture coordinates: samples along
  /// the longer one in the two levels of `sampling_of`, combined by `filter` in each level, then blended.
  double height_in(const Vec2& middle, const Vec2& side, const Vec2& other_side, HeightFilter filter) const;
  /// The same for a point of an edge: depends on the edge alone, which stands for a square, so that surfaces
  /// on both sides agree.
  double height_on_edge(const Vec2& middle, const Vec2& side, HeightFilter filter) const;

 private:
  double in_texels(const Vec2& side) const;
  double sampled(const Vec2& middle, const Vec2& side, const FootprintSampling& sampling,
                 HeightFilter filter) const;

  const DisplacementMap* map_;
  std::vector<DisplacementMap> coarser_;
  std::vector<LevelDifference> differences_;
};

}  // namespace recede
