"""Pictures: drawn, read, written and compared. See docs/render.md and docs/diff.md."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING

from . import _recede
from ._options import place_or_none, three_numbers
from ._recede import Appearance, BakedMaps, BillboardCloud, BillboardReflectance, Mesh, OptionError, TexturedShell
from .lights import Light, light_tuples

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from . import ImageDifference, Path, Progress


def read_image(path: Path) -> np.ndarray:
    """A PNG or OpenEXR picture: height x width x 3 floats of linear light (sRGB primaries, 1 is white), row 0 on top.

    What isn't opaque lies over white. Raises `InputError` that names the file.
    """
    return _recede.read_image(path)


def write_image(path: Path, pixels: npt.ArrayLike) -> None:
    """Writes height x width x 3 floats of linear light, or height x width for grey.

    `.png` holds 8 bits a channel, sRGB, clamped to 0..1; `.exr` 32-bit floats. The file appears whole or not at all.
    Raises `InputError`, also for integers: bytes aren't linear light.
    """
    _recede.write_image(path, pixels)


def diff(first: Path | npt.ArrayLike, second: Path | npt.ArrayLike, *, mask: Path | npt.ArrayLike | None = None,
         pixels_per_degree: float = 67.02) -> ImageDifference:
    """How much two pictures of one size differ; see docs/diff.md.

    Pictures are paths, or arrays as `read_image` gives them. `mask` says which pixels count: height x width truths or
    numbers (those above 0.5), or a picture (encoded grey above 0.5); what lies outside changes no measure.
    `pixels_per_degree` is how many pixels cover a degree of the viewer's field of view, 1 to 1000, for FLIP.

    The result has `flip` and `ssim` (means), `psnr` (dB, inf for equal pictures), `rmse`, `max` and `changed_share`; and
    `flip_map`, `ssim_map`, `difference_map`, height x width floats. Raises `InputError` for sizes that differ and numbers
    that aren't finite, `OptionError` for `pixels_per_degree` out of range.
    """
    return _recede.diff(first, second, mask, pixels_per_degree)


def render(surface: Mesh | BakedMaps | BillboardCloud | TexturedShell, height: npt.ArrayLike | None = None, *, eye: Sequence[float] | None = None, look_at: Sequence[float] | None = None,
           up: Sequence[float] = (0, 1, 0), field_of_view: float = 45, image_width: int = 800, image_height: int = 600,
           samples: int = 16, wireframe: bool = False, flat: bool = False, ground: bool = False,
           lighting: str = "camera", lights: Sequence[Light] | None = None, ambient: float = 0.1, bounces: int = 4,
           noise: float = 0, light_sampling: str = "both", periodic: bool = False, subdivision_level: int | None = None,
           appearance: Appearance | None = None, representation: str = "auto", transition_distance: float | None = None,
           show_methods: bool = False, reflectance: BillboardReflectance | None = None,
           matter_color: Sequence[float] | None = None, coverage: bool = False, progress: Progress | None = None) -> np.ndarray:
    """A picture: `image_height` x `image_width` x 3 floats, linear red, green and blue, 1 is the white of a screen.

    Without `eye` (object units) the whole mesh is seen from in front; `look_at` is otherwise its middle. `field_of_view`
    is vertical, degrees; `samples` are rays from the camera for each pixel. `ground` lays a wide floor under the mesh.

    `lighting` is "camera" (lamps that travel with the camera, no shadows), "direct" (`lights` with shadows, and `ambient`
    for all light that surfaces pass on) or "path" (that light itself, over at most `bounces` surfaces). `lights` are
    `PointLight`, `DirectionalLight`, `AreaLight` and one `EnvironmentLight`; None: a sun and a soft sky. With `noise`
    above 0 pixels end before `samples` once their standard error is at most this share of the step from black to white.
    `light_sampling` ("both", "lights", "surface") changes noise only. See docs/render.md.

    Baked maps are drawn with their heights and normals; a mesh with texture coordinates with `height`, an array of
    rows x columns lengths along its normals, row 0 on top, which `periodic` repeats beyond its border. Heights are
    traced without tessellation: every triangle stands for 4 to the power of `subdivision_level` small ones (None: about
    two to a texel).

    With the `appearance` of these heights (`make_appearance`) they are drawn by what each ray needs: displacement, and
    from farther away a bump map and then a table; `representation` "brdf", "bump" or "displacement" takes one of them
    for all. Methods change around `transition_distance` from the camera, object units (None: where a wave of heights
    covers two pixels). `show_methods` gives false colours: green is displacement, blue the bump map, red the table.

    A cloud of billboards is drawn with the heights of its textures, or by its `reflectance`
    (`make_billboard_reflectance`). A textured shell is drawn with its matter over what is left of the body;
    `matter_color`, linear light, is that of matter without colours.

    With `coverage` the result is `image_height` x `image_width` floats instead, the share of each pixel that the surface covers:
    a `mask` for `diff`. Light and wireframe don't matter then, and there is no ground.

    Raises `OptionError` for what is out of range, `InputError` for an environment that can't be read, for maps without
    heights and for a mesh without texture coordinates.
    """
    if lighting == "camera" and lights is not None:
        raise OptionError("lights need lighting \"direct\" or \"path\"")
    options = {"lighting": lighting, "lights": None if lights is None else light_tuples(lights), "ambient": ambient,
               "bounces": bounces, "noise": noise, "light_sampling": light_sampling, "samples": samples,
               "wireframe": wireframe, "flat": flat, "ground": ground and not coverage, "height": height, "periodic": periodic,
               "subdivision_level": subdivision_level, "appearance": appearance, "representation": representation,
               "transition_distance": transition_distance, "show_methods": show_methods, "reflectance": reflectance,
               "matter_color": matter_color, "coverage": coverage}
    if appearance is not None and not isinstance(appearance, Appearance):
        raise TypeError(f"appearance is an Appearance, see make_appearance, not {type(appearance).__name__}")
    if reflectance is not None and not isinstance(reflectance, BillboardReflectance):
        raise TypeError(f"reflectance is a BillboardReflectance, see make_billboard_reflectance, not {type(reflectance).__name__}")
    if appearance is not None and height is None and not isinstance(surface, BakedMaps):
        raise TypeError("an appearance is that of heights, and there are none")
    if reflectance is not None and not isinstance(surface, BillboardCloud):
        raise TypeError("a reflectance is that of billboards, and there are none")
    if matter_color is not None and not isinstance(surface, TexturedShell):
        raise TypeError("a matter_color is that of a textured shell")
    is_surface = isinstance(surface, (Mesh, BakedMaps, BillboardCloud, TexturedShell))
    if not is_surface or (height is not None and not isinstance(surface, Mesh)):
        raise TypeError("render takes a mesh, a mesh and its heights, baked maps, billboards, or a textured shell")
    eye, look_at, up = place_or_none("eye", eye), place_or_none("look_at", look_at), three_numbers("up", up)
    return _recede.render(surface, eye, look_at, up, field_of_view * pi / 180, image_width, image_height, options, progress)
