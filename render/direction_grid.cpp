#include <recede/render/direction_grid.h>
#include <recede/render/hemisphere_square.h>

#include <algorithm>
#include <cmath>

namespace recede {

Vec3 DirectionGrid::direction(std::size_t node) const {
  const auto row_length = static_cast<std::size_t>(side);
  const std::size_t row = node / row_length % row_length, column = node % row_length;
  const Vec2 place((static_cast<double>(column) + 0.5) / side, (static_cast<double>(row) + 0.5) / side);
  Vec3 direction = square_to_hemisphere(place);
  if (node >= row_length * row_length) direction.z() = -direction.z();
  return direction;
}

NodeMix DirectionGrid::mix(const Vec3& direction) const {
  const bool below = whole_sphere && direction.z() < 0;
  const Vec3 above(direction.x(), direction.y(), below ? -direction.z() : direction.z());
  const Vec2 place = hemisphere_to_square(above) * side - Vec2::Constant(0.5);
  const double first_column = std::floor(place.x()), first_row = std::floor(place.y());
  const Vec2 ahead = place - Vec2(first_column, first_row);

  NodeMix mix;
  for (int corner = 0; corner < 4; ++corner) {
    const int right = corner & 1, down = corner >> 1;
    const int column = static_cast<int>(first_column) + right, row = static_cast<int>(first_row) + down;
    const int inside_column = std::clamp(column, 0, side - 1), inside_row = std::clamp(row, 0, side - 1);
    // Beyond a side of the square comes the other square's cell at the same place. Beyond a corner that is so
    // for both sides, which leads back.
    const bool back = whole_sphere && (below != ((column != inside_column) != (row != inside_row)));
    const auto k = static_cast<std::size_t>(corner);
    mix.nodes[k] = ((back ? side : 0) + inside_row) * side + inside_column;
    mix.weights[k] = (right ? ahead.x() : 1 - ahead.x()) * (down ? ahead.y() : 1 - ahead.y());
  }
  return mix;
}

}  // namespace recede
