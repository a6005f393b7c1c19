// Pictures as colours of surfaces, and where a model's pictures come from.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/raster.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace recede {

/// A picture over texture coordinates: (0, 0) is its lower left corner, (1, 1) the upper right one, and it
/// repeats beyond. Colours are bilinear between the middles of texels.
class Texture {
 public:
  /// Samples are taken as encoded by sRGB, whatever the file says of itself, as glTF wants it. Opacity isn't
  /// kept. Throws `InputError` for a picture without texels or with samples missing.
  explicit Texture(const Raster& picture);

  /// Linear red, green and blue, 0 to 1: the mean over about a square `width` wide, in texture coordinates;
  /// of widths below a texel the picture's own. Takes the two nearest of smaller pictures, each of half the
  /// size of the one before (Williams 1983, "Pyramidal parametrics").
  Vec3 color_at(const Vec2& uv, double width = 0) const;

  int width() const { return levels_.front().width; }
  int height() const { return levels_.front().height; }

 private:
  using Texel = std::array<std::uint16_t, 3>;  // linear
  struct Level {
    int width = 0, height = 0;
    std::vector<Texel> texels;  // row by row, row 0 on top
    Vec3 color_at(const Vec2& uv) const;
  };
  static Level halved(const Level& level);

  std::vector<Level> levels_;
};

/// Of base colours or of normals, whether or not their pictures are known.
bool has_textures(const std::vector<Material>& materials);
/// For surfaces with new coordinates, which textures don't fit; base colours stay.
void drop_textures(std::vector<Material>& materials);

/// The textures of the base colours of some materials, those whose pictures are known.
class BaseColorTextures {
 public:
  /// Throws `InputError` for pictures that `decode_picture` refuses.
  explicit BaseColorTextures(const std::vector<Material>& materials);

  bool empty() const { return textures_.empty(); }
  /// Null: the material has none.
  const Texture* of(Index material) const {
    if (material >= numbers_.size() || numbers_[material] == k_no_index) return nullptr;
    return &textures_[numbers_[material]];
  }

 private:
  std::vector<Index> numbers_;  // of the materials' textures
  std::vector<Texture> textures_;
};

/// The file that a texture names, by its path from the folder of the model's file; some write backslashes.
/// Throws `InputError` for names that no file can have.
std::filesystem::path picture_path(const std::filesystem::path& folder, const std::string& texture);

/// Reads the pictures that materials name from files, by paths relative to the folder of the model's file,
/// each once. All are looked at, those that are known already, too.
class PictureLoader {
 public:
  explicit PictureLoader(std::filesystem::path folder) : folder_(std::move(folder)) {}

  void load(std::vector<Material>& materials);
  /// `changed` counts textures that can't be read, of which only names are left; the detail says which, and
  /// why.
  RepairStep step() const;

 private:
  void load(const std::string& name, PictureBytes& picture);
  PictureBytes checked(const std::string& name, PictureBytes picture);

  std::filesystem::path folder_;
  std::map<std::pair<std::string, PictureBytes>, PictureBytes> known_;
  std::vector<std::string> reasons_;
  std::size_t missing_ = 0;
};

}  // namespace recede
