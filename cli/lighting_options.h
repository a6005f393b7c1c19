// The lights of a picture on the command line.
#pragma once

#include <recede/render/renderer.h>

#include <CLI/CLI.hpp>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace recede::cli {

struct LightingOptions {
  LightTransport transport = LightTransport::camera;
  std::optional<std::array<double, 3>> sun, sun_color, sky;
  double sun_size = 5;                        ///< across its disc, degrees
  std::vector<std::array<double, 6>> lamps;   ///< position, intensity
  std::vector<std::array<double, 12>> areas;  ///< corner, two edges, radiance
  std::string environment;                    ///< file
  double environment_rotation = 0;            ///< degrees
  double environment_scale = 1;
  bool hide_environment = false;
  double ambient = Lighting{}.ambient;
  int bounces = RenderOptions{}.max_bounces;
  double noise = 0;
  LightSampling sampling = LightSampling::both;
  std::vector<CLI::Option*> of_scene_light;  ///< that mean nothing with the camera's light
};

void add_lighting_options(CLI::App& command, LightingOptions& options);

/// Sets light and paths. Without any light of its own, the scene has `daylight`. Reads the environment.
/// Throws `OptionError` for lights that the camera's light would hide, `InputError` for the file.
void set_lighting(const LightingOptions& options, const Vec3& up, RenderOptions& rendering);

}  // namespace recede::cli
