#include <recede/lod/view_settings.h>

#include <cmath>

namespace recede {

double pixel_footprint(double distance, const ViewSettings& view) {
  return 2 * distance / view.image_height * std::tan(view.field_of_view / 2);
}

double switch_distance(double error, const ViewSettings& view) {
  return error / (view.pixel_error * pixel_footprint(1, view));
}

}  // namespace recede
