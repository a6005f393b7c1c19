// Radiance at one place of a scene, with the error of its estimate.
#pragma once

#include <recede/render/progressive_render.h>

#include <array>
#include <cmath>

namespace recede {

struct MeasuredRadiance {
  double mean = 0;            // of the red channel
  double standard_error = 0;  // from the spread of samples

  // Four standard errors: chance goes farther once in 16 000 times, and seeds are fixed. The rest is float.
  double tolerance() const { return 4 * standard_error + 1e-5 * std::abs(mean); }
};

// Towards a target, by a camera of 4 x 4 pixels that sees a millionth of its distance.
inline MeasuredRadiance measure_radiance(const Scene& scene, const Vec3& eye, const Vec3& target,
                                         const RenderOptions& options, int samples) {
  const Camera camera{.position = eye,
                      .target = target,
                      .up = (target - eye).unitOrthogonal(),
                      .field_of_view = 1e-6,
                      .width = 4,
                      .height = 4};
  ProgressiveRender picture(scene, camera, options);
  picture.add_samples(samples);
  const Image means = picture.image(), errors = picture.standard_error();
  MeasuredRadiance measured;
  double squares = 0;
  for (std::size_t i = 0; i < means.pixels.size(); ++i) {
    measured.mean += static_cast<double>(means.pixels[i].x()) / 16;
    squares += std::pow(static_cast<double>(errors.pixels[i].x()), 2);
  }
  measured.standard_error = std::sqrt(squares) / 16;
  return measured;
}

// A quad that looks to +z.
inline PolygonSoup make_floor(double half_side, const Vec3& middle = Vec3::Zero()) {
  PolygonSoup soup;
  for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
    soup.positions.push_back(middle + half_side * Vec3(x, y, 0));
  soup.add_face(std::array<Index, 4>{0, 1, 2, 3});
  return soup;
}

inline PolygonSoup with_albedo(PolygonSoup soup, double albedo) {
  soup.materials.push_back(
      {.name = "matt", .base_color = Vec4(albedo, albedo, albedo, 1), .base_color_texture = ""});
  soup.face_materials.assign(soup.n_faces(), 0);
  return soup;
}

inline RenderOptions direct_light(Lighting lighting) {
  RenderOptions options;
  options.background = Rgb::Zero();
  options.transport = LightTransport::direct;
  options.lighting = std::move(lighting);
  options.lighting.ambient = 0;
  return options;
}

inline RenderOptions path_light(Lighting lighting, int bounces) {
  RenderOptions options = direct_light(std::move(lighting));
  options.transport = LightTransport::path;
  options.max_bounces = bounces;
  return options;
}

}  // namespace recede
