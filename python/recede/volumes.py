"""Volume textures in the layers of shells, and their editing. See docs/volumes.md."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import _recede
from ._options import three_numbers
from ._recede import InputError, Mesh, OptionError, VolumeTexture

if TYPE_CHECKING:
    from . import Path, Progress, Shell, TexturedShell


def make_volume(name: str | None = None, *, texels: int = 64, seed: int = 1, time: float = 0, wire: float = 0.17,
                thread: float = 0.26, cracks: float = 0.8, bubbles: int = 40, bushes: int = 4,
                growth: float = 1, opacity: npt.ArrayLike | None = None,
                colors: npt.ArrayLike | None = None, extent: Sequence[float] = (1, 1, 1), periodic: bool = True,
                ramp: float = 0, progress: Progress | None = None) -> VolumeTexture:
    """A grid of opacity for the layer of a shell; what it shows is the surface on which opacity is a half.

    By `name`: "chain-mail" (rings of radius 1 from `wire`), "weave" (`thread` over the distance of threads), "bark"
    (`seed`, `cracks` as a share of the height), "bubbles" (`seed`, how many, and the `time` in lives of a bubble, for
    animations) or "bushes" (`seed`, how many, and their `growth` from 0 to 1), with `texels` along s for a period.

    Or from arrays: `opacity`, r x t x s bytes or truths or floats from 0 to 1, and perhaps `colors`, r x t x s x 3 of the
    same, sRGB-encoded. `extent` has the lengths along s, t and r; `periodic` volumes repeat along s and t. Opacity goes from 0
    to 1 over twice the length `ramp` (0: unknown).

    Raises `OptionError` for what is out of range, `InputError` for arrays that don't fit or aren't numbers.
    """
    if (name is None) == (opacity is None):
        raise OptionError("a volume is made by a name or of an array of opacity")
    if name is not None:
        if colors is not None or tuple(extent) != (1, 1, 1) or not periodic or ramp != 0:
            raise OptionError("colors, extent, periodic and ramp are for arrays")
        settings = {"seed": seed, "time": time, "wire": wire, "thread": thread, "cracks": cracks, "bubbles": bubbles,
                    "bushes": bushes, "growth": growth}
        return _recede.named_volume(name, texels, settings, progress)
    return _recede.volume_from_arrays(_bytes("opacity", opacity), None if colors is None else _bytes("colors", colors),
                                      three_numbers("extent", extent), periodic, ramp)


def _bytes(what: str, values: npt.ArrayLike) -> np.ndarray:
    array = np.asarray(values)
    if array.dtype == np.uint8:
        return array
    if array.dtype.kind not in "biuf":
        raise InputError(f"{what} must be an array of numbers")
    numbers = array.astype(np.float64)
    if not np.isfinite(numbers).all():
        raise InputError(f"{what} holds numbers that aren't finite")
    if numbers.size and (numbers.min() < 0 or numbers.max() > 1):
        raise InputError(f"{what}: numbers are from 0 to 1, or bytes (uint8)")
    return (numbers * 255 + 0.5).astype(np.uint8)


def fill_shell(shell: Shell, volume: VolumeTexture | str, *, side: str = "exterior",
               repeat: Sequence[float] | None = None, offset: Sequence[float] = (0, 0), texels: int | None = None,
               layers: int | None = None) -> TexturedShell:
    """A volume texture in a layer of a shell, whose base has texture coordinates (`make_atlas`).

    `volume` lies `repeat` times over texture coordinates from 0 to 1 (None: so often that it keeps its proportions in a layer as
    thick), moved by `offset` periods. "solid" or "empty" fills
    the layer with matter, or leaves it to `carve`, in `texels` x `texels` x `layers` (512 and 16); texture coordinates then are from
    0 to 1 and don't overlap.

    Raises `InputError` for a shell without the layer or texture coordinates, `OptionError` for what is out of range.
    """
    if isinstance(volume, str):
        if volume not in ("solid", "empty"):
            raise OptionError(f"volume: {volume} isn't one of solid, empty")
        if repeat is not None or tuple(offset) != (0, 0):
            raise OptionError("repeat and offset are for volume textures")
        along, across = 512 if texels is None else texels, 16 if layers is None else layers
        return _recede.fill_with_matter(shell, 1.0 if volume == "solid" else 0.0, side, (along, along, across))
    if not isinstance(volume, VolumeTexture):
        raise TypeError(f"fill_shell takes a VolumeTexture, \"solid\" or \"empty\", not {type(volume).__name__}")
    if texels is not None or layers is not None:
        raise OptionError("texels and layers are for \"solid\" and \"empty\"")
    return _recede.fill_with_volume(shell, volume, side, repeat, offset)


def carve(textured: TexturedShell, tool: Mesh | Sequence[float], operation: str = "carve", *,
          color: Sequence[float] | None = None, ramp: float = 2, size: Sequence[int] | None = None,
          progress: Progress | None = None) -> tuple[TexturedShell, dict[str, float]]:
    """The shell with a body taken out of its matter, or united with it, and what changed.

    `tool` is a closed mesh or a ball (x, y, z, radius), object units. `operation` is "carve", "unite" (with `color`, sRGB,
    0 to 1), "intersect", or "cut", which empties texels in the tool with sharp ends; else opacity goes from 0 to 1 over
    twice `ramp` sides of texels. A texture that repeats is unwrapped first, to `size` texels along s, t and r if given.
    The dict has the number of `changed` texels, the `volume` of the tool in the layer, and `missed_triangles`, which are
    smaller than texels.

    Raises `InputError` for a tool that isn't closed, `OptionError` for what is out of range.
    """
    body = tool if isinstance(tool, Mesh) else [float(number) for number in tool]
    if not isinstance(body, Mesh) and len(body) != 4:
        raise OptionError("a ball is four numbers: x, y, z and its radius")
    settings = {"color": None if color is None else np.asarray(color, dtype=float), "ramp": ramp,
                "size": None if size is None else [int(n) for n in size]}
    return _recede.carve(textured, body, operation, settings, progress)


def move_matter(textured: TexturedShell, source: Sequence[float], target: Sequence[float], radius: float, *,
                turn: float = 0, copy: bool = False,
                size: Sequence[int] | None = None) -> tuple[TexturedShell, dict[str, float]]:
    """The shell with the matter around the point `source` of its surface moved to that around `target`.

    Discs of `radius` along the surface, object units, are moved; `turn` is counter-clockwise, seen from outside, degrees.
    With `copy` it stays where it was, too. The dict is that of `carve` with the `stretch` of the discs' maps (1: none) and
    the texels `without_source`, beyond the surface's border.
    """
    settings = {"radius": radius, "turn": math.radians(turn), "copy": copy, "size": None if size is None else [int(n) for n in size]}
    return _recede.move_matter(textured, three_numbers("source", source), three_numbers("target", target), settings)


def read_textured_shell(path: Path) -> TexturedShell:
    """What `TexturedShell.write` or `recede shell --texture` wrote. Raises `InputError` for other and damaged files."""
    return _recede.read_textured_shell(path)
