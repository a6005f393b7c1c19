// Fits the heights of a coarse level to a map: least volume between two bilinear surfaces.
#pragma once

#include <recede/geometry/displacement_levels.h>

#include <vector>

namespace recede::detail {

/// Samples of a level, row by row, not rounded to the map's bits.
struct LevelSamples {
  int columns = 0, rows = 0;
  std::vector<double> samples;
};

/// The volume between a level and the map as a function of the level's samples.
class LevelFit {
 public:
  LevelFit(const DisplacementMap& map, int columns, int rows);

  /// The sum over the map's texels of the distance between both surfaces, in samples, and the largest one.
  struct Volume {
    double sum = 0, max = 0;
  };
  Volume volume(const std::vector<double>& samples) { return compare(samples, false); }

  /// Makes the volume smaller by descent, at most `steps` with each length. Returns the best samples.
  std::vector<double> least_volume(std::vector<double> samples, int steps, Progress* progress);

 private:
  /// Where the middle of a texel of the map lies between two of the level.
  struct Place {
    int before, after;
    double fraction;
  };
  /// What a texel of the level gives to a row of the map.
  struct Share {
    int row;
    double weight;
  };
  static std::vector<Place> places(const DisplacementMap& map, int fine, int coarse);
  Volume compare(const std::vector<double>& samples, bool with_signs);
  void compare_row(int y, const std::vector<double>& samples, std::vector<double>& mixed, bool with_signs);
  void step(std::vector<double>& samples, double length) const;

  const DisplacementMap& map_;
  int columns_, rows_;
  std::vector<Place> across_, down_;
  std::vector<std::vector<Share>> shares_;  // for each row of the level
  std::vector<Volume> row_volumes_;         // of the map's rows
  std::vector<float> row_signs_;  // for each row of the map: sums of signs, weighted for the level's columns
};

}  // namespace recede::detail
