#include "lighting_options.h"

#include "common.h"
#include <recede/geometry/error.h>
#include <recede/render/image_io.h>

#include <numbers>

namespace recede::cli {

namespace {

constexpr double k_degree = std::numbers::pi / 180;

template <std::size_t n>
Vec3 vector_at(const std::array<double, n>& numbers, std::size_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

template <std::size_t n>
Rgb color_at(const std::array<double, n>& numbers, std::size_t first) {
  return vector_at(numbers, first).template cast<float>();
}

void add_lights(CLI::App& command, LightingOptions& options, const std::string& group) {
  const auto add = [&](auto& value, const char* name, const char* help) {
    CLI::Option* option = command.add_option(name, value, help)->group(group);
    options.of_scene_light.push_back(option);
    return option;
  };
  CLI::Option* sun = add(options.sun, "--sun", "direction towards a sun")->option_text("X Y Z");
  add(options.sun_color, "--sun-color", "irradiance of what faces it (2.6 2.45 2.25)")
      ->option_text("R G B")
      ->needs(sun);
  add(options.sun_size, "--sun-size", "across its disc, degrees; 0: sharp shadows (5)")
      ->check(between(0.0, 179.0))
      ->needs(sun);
  add(options.lamps, "--lamp", "a point light: its place and intensity; may be repeated")
      ->option_text("X Y Z R G B");
  add(options.areas, "--area",
      "a parallelogram of light: corner, two edges, radiance; it shines to where the edges' cross product "
      "points; may be repeated")
      ->option_text("X Y Z X Y Z X Y Z R G B");
  add(options.sky, "--sky", "radiance of light from everywhere alike")->option_text("R G B");
  CLI::Option* file =
      add(options.environment, "--environment", "picture of all directions, .exr or .png: light from there")
          ->option_text("FILE");
  add(options.environment_rotation, "--environment-rotation",
      "counter-clockwise seen from above, degrees (0)")
      ->needs(file);
  add(options.environment_scale, "--environment-scale", "factor of its radiance (1)")
      ->check(not_negative())
      ->needs(file);
  options.of_scene_light.push_back(
      command
          .add_flag("--hide-environment", options.hide_environment, "light from it, but a plain background")
          ->needs(file)
          ->group(group));
}

}  // namespace

void add_lighting_options(CLI::App& command, LightingOptions& options) {
  const auto group = "Light (of the scene: a sun and a sky, unless there are others)";
  command
      .add_option("--lighting", options.transport,
                  "camera: lamps that travel with the camera, no shadows (default); direct: lights of the "
                  "scene with shadows; path: also light that surfaces pass on")
      ->transform(one_of<LightTransport>({{"camera", LightTransport::camera},
                                          {"direct", LightTransport::direct},
                                          {"path", LightTransport::path}}))
      ->option_text("camera|direct|path")
      ->group(group);
  add_lights(command, options, group);
  const auto add = [&](CLI::Option* option) {
    option->group(group);
    options.of_scene_light.push_back(option);
    return option;
  };
  add(command.add_option("--ambient", options.ambient,
                         "direct: radiance that stands for all light that surfaces pass on (0.1)"))
      ->check(not_negative());
  add(command.add_option("--bounces", options.bounces, "path: from surface to surface at most (4)"))
      ->check(between(0, 1000));
  add(command.add_option("--noise", options.noise,
                         "ends where the standard error is at most this share of the step from black to "
                         "white; --samples is the most then"))
      ->check(between(0.0, 1.0));
  add(command.add_option("--light-sampling", options.sampling,
                         "how light of areas and environments is found: both (default), lights or surface; "
                         "they differ in noise only"))
      ->transform(one_of<LightSampling>({{"both", LightSampling::both},
                                         {"lights", LightSampling::lights},
                                         {"surface", LightSampling::surface}}))
      ->option_text("both|lights|surface");
}

void set_lighting(const LightingOptions& options, const Vec3& up, RenderOptions& rendering) {
  rendering.transport = options.transport;
  if (options.transport == LightTransport::camera) {
    for (const CLI::Option* option : options.of_scene_light) {
      if (option->count() > 0)
        throw OptionError(option->get_name() + " needs --lighting direct or --lighting path");
    }
    return;
  }
  Lighting lighting = daylight(up);
  const DirectionalLight default_sun = lighting.directionals.front();
  const bool has_own = options.sun || options.sky || !options.lamps.empty() || !options.areas.empty() ||
                       !options.environment.empty();
  if (has_own) lighting = {};
  if (options.sun)
    lighting.directionals.push_back(
        {.toward = to_vector(*options.sun),
         .irradiance = options.sun_color ? color_at(*options.sun_color, 0) : default_sun.irradiance,
         .angular_radius = options.sun_size / 2 * k_degree});
  for (const std::array<double, 6>& lamp : options.lamps)
    lighting.points.push_back({.position = vector_at(lamp, 0), .intensity = color_at(lamp, 3)});
  for (const std::array<double, 12>& area : options.areas)
    lighting.areas.push_back({.corner = vector_at(area, 0),
                              .first_edge = vector_at(area, 3),
                              .second_edge = vector_at(area, 6),
                              .radiance = color_at(area, 9)});
  if (options.sky)
    lighting.environment =
        EnvironmentLight{.radiance = Image(1, 1, color_at(*options.sky, 0)), .up = up, .visible = false};
  if (!options.environment.empty()) {
    if (options.sky) throw OptionError("--sky and --environment exclude each other");
    lighting.environment = EnvironmentLight{.radiance = read_image(options.environment),
                                            .up = up,
                                            .rotation = options.environment_rotation * k_degree,
                                            .scale = options.environment_scale,
                                            .visible = !options.hide_environment};
  }
  lighting.ambient = options.ambient;
  rendering.lighting = std::move(lighting);
  rendering.max_bounces = options.bounces;
  rendering.noise = options.noise;
  rendering.light_sampling = options.sampling;
}

}  // namespace recede::cli
