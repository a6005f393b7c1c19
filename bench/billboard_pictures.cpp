#include "billboard_models.h"
#include "billboard_run.h"
#include <recede/render/renderer.h>

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

namespace recede::bench {
namespace {

constexpr double k_share = 0.01;  // of the longest side: the error
constexpr int k_panel = 256, k_gap = 4, k_enlarged = 2, k_samples = 32;
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

/// Shades that a picture needs not have: its file is a third smaller without them.
Rgb rounded(const Rgb& color) {
  constexpr float k_steps = 24;
  return color.unaryExpr(
      [](float value) { return decode_srgb(std::round(k_steps * encode_srgb(value)) / k_steps); });
}

Image montage(const std::array<std::array<Image, 3>, 2>& rows) {
  Image result(3 * (k_panel + k_gap) - k_gap, 2 * (k_panel + k_gap) - k_gap, Rgb::Ones());
  for (std::size_t row = 0; row < 2; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      const Image& from = rows[row][column];
      const int left = static_cast<int>(column) * (k_panel + k_gap),
                top = static_cast<int>(row) * (k_panel + k_gap);
      for (int y = 0; y < k_panel; ++y) {
        for (int x = 0; x < k_panel; ++x) result.at(left + x, top + y) = rounded(from.at(x, y));
      }
    }
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

std::string billboard_pictures(const BenchOptions& options) {
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
    std::array<std::array<Image, 3>, 2> rows;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      rows[0][i] = render(scenes[i], near, drawn);
      rows[1][i] = enlarged(render(scenes[i], far, drawn), k_enlarged);
    }
    write_png(options.out / fmt::format("billboards-{}.png", model.name), montage(rows));
    text += fmt::format("| {} | {} | {} |\n", model.name, textures.billboards.size(), textures.n_texels());
  }
  return text;
}

}  // namespace recede::bench
