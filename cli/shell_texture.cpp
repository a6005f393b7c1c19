#include "shell_texture.h"

#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/shell_edit.h>
#include <recede/shells/texture_repeat.h>

namespace recede::cli {
namespace {

constexpr int k_texels_of_period = 64, k_texels_of_all = 512;

bool is_filled_once(const ShellTextureOptions& options) {
  return options.name == "empty" || options.name == "solid";
}

ProceduralVolume procedural(const ShellTextureOptions& options) {
  if (options.name == "chain-mail") return chain_mail();
  if (options.name == "weave") return weave();
  if (options.name == "bark") return bark({.seed = options.seed});
  if (options.name == "bushes") return bushes({.seed = options.seed, .growth = options.growth});
  return bubbles({.seed = options.seed, .time = options.time});
}

}  // namespace

void add_shell_texture_options(CLI::App& command, ShellTextureOptions& options) {
  const auto group = "Texture";
  CLI::Option* texture = command.add_option(
      "--texture", options.name,
      "fills the layer, for an output that ends in .shell: chain-mail, weave, bark, bubbles, bushes, or "
      "solid or empty for recede carve");
  texture->transform(one_of_names({"chain-mail", "weave", "bark", "bubbles", "bushes", "solid", "empty"}))
      ->group(group);
  command
      .add_option(
          "--periods", options.periods,
          "of the texture across the texture coordinates from 0 to 1, and along t as many as keep its "
          "shape (as many as the layer is thick for)")
      ->check(above_zero())
      ->needs(texture)
      ->group(group);
  command
      .add_option(
          "--texels", options.texels,
          "along s: of a period (64), or of all that is solid or empty (512), where as many are along t")
      ->check(between(1, 16384))
      ->needs(texture)
      ->group(group);
  command
      .add_option("--layers", options.layers, "texels from the surface to the tops, of solid and empty (16)")
      ->check(between(1, 4096))
      ->needs(texture)
      ->group(group);
  command.add_option("--texture-seed", options.seed, "of bark, bubbles and bushes (1)")
      ->needs(texture)
      ->group(group);
  command
      .add_option("--texture-time", options.time,
                  "of bubbles, in lives of a bubble: pictures of an animation (0)")
      ->needs(texture)
      ->group(group);
  command
      .add_option("--texture-growth", options.growth,
                  "of bushes, from bare ground (0) to full-grown: pictures of an animation (1)")
      ->check(between(0.0, 1.0))
      ->needs(texture)
      ->group(group);
}

PolygonSoup with_coordinates(PolygonSoup surface, Progress* progress) {
  if (!surface.corner_uvs.empty()) return surface;
  return make_atlas(surface, {}, progress).soup;
}

TexturedShell textured_shell(std::shared_ptr<const Shell> shell, ShellSide side,
                             const ShellTextureOptions& options, Progress* progress) {
  TexturedShell textured{.shell = std::move(shell), .side = side};
  if (is_filled_once(options)) {
    const int texels = options.texels.value_or(k_texels_of_all);
    const LayerGrid grid(textured.shell, side, {texels, texels, options.layers});
    textured.texture = finest_only(make_uniform_volume(grid, options.name == "solid" ? 1 : 0));
    return textured;
  }
  const ProceduralVolume volume = procedural(options);
  textured.texture = finest_only(make_volume(volume, options.texels.value_or(k_texels_of_period), progress));
  textured.coordinates.repeat =
      options.periods ? Vec2(*options.periods, *options.periods * volume.extent.x() / volume.extent.y())
                      : proportionate_repeat(*textured.shell, side, volume.extent);
  return textured;
}

}  // namespace recede::cli
