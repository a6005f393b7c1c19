"""Lights of pictures, as `recede.render` takes them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._options import three_numbers
from ._recede import OptionError

Path = Union[str, "os.PathLike[str]"]

Color = Union[float, Sequence[float]]
"""One number for all channels, or red, green and blue."""


@dataclass(frozen=True)
class PointLight:
    """Shines alike in all directions; a surface at distance r that faces it has the irradiance intensity / r^2."""

    position: Sequence[float]
    intensity: Color = 1.0


@dataclass(frozen=True)
class DirectionalLight:
    """A sun: `irradiance` is of a surface that faces it, `angular_radius` of its disc, degrees (0: sharp shadows)."""

    toward: Sequence[float]
    irradiance: Color = 3.0
    angular_radius: float = 0.0


@dataclass(frozen=True)
class AreaLight:
    """A parallelogram that shines to where `first_edge` x `second_edge` points, or to both sides."""

    corner: Sequence[float]
    first_edge: Sequence[float]
    second_edge: Sequence[float]
    radiance: Color = 1.0
    two_sided: bool = False


@dataclass(frozen=True)
class EnvironmentLight:
    """Light from all around: a path or a picture of all directions, row 0 above, or one colour.

    The middle column is what a camera in front sees behind the mesh. `rotation` is counter-clockwise seen from above,
    degrees; `scale` multiplies. When not `visible` it lights, but the picture has its plain background.
    """

    radiance: Union[Path, npt.ArrayLike] = 1.0
    rotation: float = 0.0
    scale: float = 1.0
    visible: bool = True


Light = Union[PointLight, DirectionalLight, AreaLight, EnvironmentLight]


def _color(color: Any) -> list[float]:
    values = np.atleast_1d(np.asarray(color, dtype=float))
    if values.shape not in ((1,), (3,)):
        raise OptionError("a colour is one number, or red, green and blue")
    return [float(value) for value in np.broadcast_to(values, 3)]


def _environment(light: EnvironmentLight) -> tuple[Any, ...]:
    picture: Any = light.radiance
    if not isinstance(picture, (str, os.PathLike)):
        picture = np.asarray(picture)
        if picture.ndim < 2:
            picture = np.array(_color(picture), dtype=np.float32).reshape(1, 1, 3)
    return picture, float(light.rotation) * pi / 180, float(light.scale), light.visible


def light_tuples(lights: Sequence[Light]) -> dict[str, list[tuple[Any, ...]]]:
    sorted_lights: dict[str, list[tuple[Any, ...]]] = {"point": [], "directional": [], "area": [], "environment": []}
    for light in lights:
        if isinstance(light, PointLight):
            sorted_lights["point"].append((three_numbers("position", light.position), _color(light.intensity)))
        elif isinstance(light, DirectionalLight):
            sorted_lights["directional"].append(
                (three_numbers("toward", light.toward), _color(light.irradiance), float(light.angular_radius) * pi / 180))
        elif isinstance(light, AreaLight):
            sorted_lights["area"].append(
                (three_numbers("corner", light.corner), three_numbers("first_edge", light.first_edge),
                 three_numbers("second_edge", light.second_edge), _color(light.radiance), light.two_sided))
        elif isinstance(light, EnvironmentLight):
            sorted_lights["environment"].append(_environment(light))
        else:
            raise TypeError(f"{light!r} is no light")
    if len(sorted_lights["environment"]) > 1:
        raise OptionError("a scene has one environment")
    return sorted_lights
