#include "billboard_models.h"
#include "billboard_run.h"
#include <recede/geometry/atomic_file.h>
#include <recede/render/renderer.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace recede::bench {
namespace {

constexpr double k_share = 0.01;  // of the longest side: the error
constexpr int k_panel = 240, k_enlarged = 2, k_samples = 32;
constexpr double k_texels_per_error = 2;

/// Every billboard in a colour of its own; what is transparent stays so.
BillboardTextures in_a_color_each(BillboardTextures textures) {
  for (std::size_t b = 0; b < textures.places.size(); ++b) {
    // Hues far apart one after the other.
    const double hue = std::fmod(0.618034 * static_cast<double>(b), 1.0);
    const BillboardPlace& place = textures.places[b];
    for (int y = place.y; y < place.y + place.height; ++y) {
      for (int x = place.x; x < place.x + place.width; ++x) {
        for (std::size_t k = 0; k < 3; ++k) {
          const double value =
              0.5 + 0.4 * std::cos(2 * std::numbers::pi * (hue - static_cast<double>(k) / 3));
          const auto texel = static_cast<std::size_t>(y) * static_cast<std::size_t>(textures.color.width) +
                             static_cast<std::size_t>(x);
          textures.color.samples[4 * texel + k] =
              static_cast<std::uint16_t>(std::lround(255 * encode_srgb(static_cast<float>(value))));
        }
      }
    }
  }
  return textures;
}

Image enlarged(const Image& image, int factor) {
  Image result(factor * image.width, factor * image.height);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) result.at(x, y) = image.at(x / factor, y / factor);
  }
  return result;
}

/// A PNG file small enough for a page: with as many shades as it takes.
std::string encoded(const Image& image) {
  constexpr std::size_t k_most_bytes = 145'000;
  std::string file = encode_png(image);
  for (float steps = 48; file.size() > k_most_bytes && steps > 8; steps -= 4) {
    Image rounded = image;
    for (Rgb& pixel : rounded.pixels) {
      pixel = pixel.unaryExpr(
          [&](float value) { return decode_srgb(std::round(steps * encode_srgb(value)) / steps); });
    }
    file = encode_png(rounded);
  }
  return file;
}

using Panels = std::array<Image, 3>;

bool is_empty(const Panels& row, int x, int y) {
  return std::all_of(row.begin(), row.end(),
                     [&](const Image& image) { return image.at(x, y).minCoeff() >= 1; });
}

/// The same part of all three: without what is white in all of them, but for a border.
Panels trimmed(const Panels& row) {
  constexpr int k_border = 6;
  Eigen::AlignedBox2i used;
  for (int y = 0; y < row[0].height; ++y) {
    for (int x = 0; x < row[0].width; ++x) {
      if (!is_empty(row, x, y)) used.extend(Eigen::Vector2i(x, y));
    }
  }
  if (used.isEmpty()) return row;
  Panels result;
  for (std::size_t i = 0; i < row.size(); ++i) {
    result[i] = Image(used.sizes().x() + 1 + 2 * k_border, used.sizes().y() + 1 + 2 * k_border, Rgb::Ones());
    for (int y = used.min().y(); y <= used.max().y(); ++y) {
      for (int x = used.min().x(); x <= used.max().x(); ++x)
        result[i].at(x - used.min().x() + k_border, y - used.min().y() + k_border) = row[i].at(x, y);
    }
  }
  return result;
}

/// Panels of both rows above one another, in the middle of columns as wide as the wider.
Image montage(const Panels& above, const Panels& below) {
  const int width = std::max(above[0].width, below[0].width);
  Image result(3 * width, above[0].height + below[0].height, Rgb::Ones());
  int top = 0;
  for (const Panels* row : {&above, &below}) {
    for (std::size_t i = 0; i < row->size(); ++i) {
      const Image& panel = (*row)[i];
      const int left = static_cast<int>(i) * width + (width - panel.width) / 2;
      for (int y = 0; y < panel.height; ++y) {
        for (int x = 0; x < panel.width; ++x) result.at(left + x, top + y) = panel.at(x, y);
      }
    }
    top += (*row)[0].height;
  }
  return result;
}

/// Sideways and a little from above, with the axis upwards that the file has.
Camera near_camera(const BillboardModel& model, const Vec3& up) {
  return camera_in_front(model.soup.positions, up, 0.5, k_panel, k_panel);
}

Camera far_camera(const BillboardModel& model, const Camera& near, double pixel) {
  Camera camera = near;
  constexpr double k_far = 8;  // diagonals
  constexpr int k_size = k_panel / k_enlarged;
  const double distance = k_far * model.diagonal();
  camera.position = camera.target + distance * (near.position - near.target).normalized();
  camera.width = camera.height = k_size;
  camera.field_of_view = 2 * std::atan(0.5 * k_size * pixel / distance);
  return camera;
}

Vec3 upwards(const std::string& name) {
  return name == "man" || name == "mannequin-devil" ? Vec3::UnitZ() : Vec3::UnitY();
}

}  // namespace

BenchSection draw_billboards(const BenchOptions& options) {
  std::filesystem::create_directories(options.out);
  std::string text = "| model | billboards | texels |\n|---|---|---|\n";
  for (const BillboardModel& model : billboard_models(options)) {
    const BillboardMethod method =
        model.is_two_sided ? BillboardMethod::plane_cover : BillboardMethod::face_clustering;
    const BillboardCloud cloud = cloud_of(model, method, k_share);
    const BillboardTextures textures =
        texture_billboards(model.soup, cloud, {.texels_per_error = k_texels_per_error});
    const std::array scenes{Scene(model.soup), scene_of(in_a_color_each(textures)), scene_of(textures)};
    const Camera near = near_camera(model, upwards(model.name));
    const Camera far = far_camera(model, near, k_share * model.size());
    const RenderOptions drawn{.samples_per_pixel = k_samples, .background = Rgb::Ones()};
    Panels above, below;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      above[i] = render(scenes[i], near, drawn);
      below[i] = enlarged(render(scenes[i], far, drawn), k_enlarged);
    }
    write_file_atomically(options.out / fmt::format("billboards-{}.png", model.name),
                          encoded(montage(trimmed(above), trimmed(below))));
    text += fmt::format("| {} | {} | {} |\n", model.name, textures.billboards.size(), textures.n_texels());
  }
  return {.markdown = text};
}

}  // namespace recede::bench
