// How large a length looks.
#pragma once

namespace recede {

/// The view for which errors in pixels and switch distances are computed.
struct ViewSettings {
  double image_height = 1080;                ///< pixels
  double field_of_view = 0.785398163397448;  ///< vertical, radians (45 degrees)
  double pixel_error = 1;                    ///< error that a level may show, pixels
};

/// Object-space length that one pixel covers at `distance` (object units).
double pixel_footprint(double distance, const ViewSettings& view);
/// Distance from which on a length of `error` object units covers at most `view.pixel_error` pixels.
double switch_distance(double error, const ViewSettings& view);

}  // namespace recede
