// How much of a texture a test of its opacity lets through.
#pragma once

#include <vector>

namespace recede::detail {

/// In texels: where opacity, bilinear between the middles of texels and constant beyond the outer ones, is a
/// half and more. Row by row.
double masked_area(const std::vector<float>& opacity, int width, int height);

/// Opacity times a number, at most 1, with which that area is nearest to `area`, texels.
std::vector<float> with_masked_area(const std::vector<float>& opacity, int width, int height, double area);

/// Opacity is a covered share. Where a fifth of what is covered would be lost, as of parts thinner than
/// texels, opacity is multiplied so that the area is the sum of all.
void keep_thin_parts(std::vector<float>& opacity, int width, int height);

}  // namespace recede::detail
