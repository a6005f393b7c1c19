// What a face is made of, as far as the file formats carry it.
#pragma once

#include <recede/geometry/vec.h>

#include <memory>
#include <optional>
#include <string>

namespace recede {

/// The bytes of a picture's file, PNG or JPEG. Copies share them; null: not known.
using PictureBytes = std::shared_ptr<const std::string>;

/// A named material. Faces refer to materials by their position in a list.
struct Material {
  std::string name;
  Vec4 base_color{0.8, 0.8, 0.8, 1.0};  ///< linear red, green, blue and opacity, 0 to 1
  /// Path or URI as written in the file, or a name for a picture that is inside of it; empty: none. Its
  /// colours, encoded as sRGB, are factors of the base colour.
  std::string base_color_texture;
  /// The same for a map of normals in tangent space, y up. Only glTF holds it.
  std::string normal_texture{};
  /// What has less opacity isn't drawn, and the rest as if it were opaque. Only glTF holds it.
  std::optional<double> alpha_cutoff{};
  PictureBytes base_color_picture{}, normal_picture{};  ///< of the textures, see `PictureLoader`
  friend bool operator==(const Material&, const Material&) = default;
};

}  // namespace recede
