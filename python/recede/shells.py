"""Shells, and the averaged distance that they grow along. See docs/shells.md."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING

import numpy.typing as npt

from . import _recede
from ._options import list_of
from ._recede import OptionError
from ._texts import need_mesh

if TYPE_CHECKING:
    from . import AveragedDistance, Mesh, Progress, Shell


def build_shell(mesh: Mesh, thickness: float | None = None, *, relative_thickness: float | None = None,
                thicknesses: Sequence[float] | None = None, side: str = "exterior", directors: str = "averaged",
                power: float = 3, form: str = "calibrated", step: float = 0.25, border_extension: float = 2.5,
                repair: bool = True, at_least_normals: bool = True, subdivision_level: int | None = None, scheme: str = "catmull-clark",
                crease_angle: float | None = None, interpolate_directors: int = 0,
                progress: Progress | None = None) -> Shell:
    """A layer of space over a surface, proved to be valid, or what is wrong with it.

    `thickness` is in units of the mesh, `relative_thickness` a share of the diagonal, `thicknesses` one of each vertex.
    `side` is "exterior", "interior" or "envelope", which is both. `directors` lead along the gradient of an averaged
    distance ("averaged", which gets shorter where there is less room), of the exact one ("exact") or along "normals".
    `power` and `form` are those of `averaged_distance`; `step` is the longest step of a director, as a share of the
    thickness; `border_extension` says how far, in thicknesses, the field sees the surface go on at open borders. With
    `repair` directors are shortened until the layer is valid, and with `at_least_normals` plain normals take their place where
    those are longer on average and valid all over the surface. See docs/shells.md.

    With `subdivision_level` the mesh is a control mesh, and the shell that of its limit surface, refined so many times; `scheme` and
    `crease_angle` are those of `recede.subdivide`. Directors are then traced at the points of `interpolate_directors` levels
    below, and the others stand between them. `relative_thickness` is a share of the control mesh's diagonal.

    Raises `OptionError` for what is out of range, `InputError` for a mesh without area.
    """
    need_mesh("build_shell", mesh)
    given = [value is not None for value in (thickness, relative_thickness, thicknesses)]
    if sum(given) != 1:
        raise OptionError("a shell needs one of thickness, relative_thickness and thicknesses")
    if relative_thickness is not None:
        thickness = relative_thickness * mesh.diagonal
    settings = {"thickness": thickness or 0.0, "thicknesses": list_of(thicknesses),
                "side": side, "directors": directors, "power": power, "form": form, "step": step,
                "border_extension": border_extension, "repair": repair, "at_least_normals": at_least_normals}
    if subdivision_level is None:
        if scheme != "catmull-clark" or crease_angle is not None or interpolate_directors != 0:
            raise OptionError("scheme, crease_angle and interpolate_directors need subdivision_level")
        return _recede.build_shell(mesh, settings, progress)
    settings |= {"level": subdivision_level, "scheme": scheme, "interpolated_levels": interpolate_directors,
                 "crease_angle": None if crease_angle is None else crease_angle * pi / 180}
    return _recede.build_subdivided_shell(mesh, settings, progress)


def averaged_distance(mesh: Mesh, points: npt.ArrayLike, *, p: float = 3, form: str = "calibrated",
                      source: str = "triangles", expansion: str = "quadrupole", opening: float = 1.25,
                      error: float | None = None, support: float = float("inf"),
                      progress: Progress | None = None) -> AveragedDistance:
    """The Lp-averaged distance of a surface at points (n x 3), and its gradient: smooth away from the surface.

    `form` is "calibrated" (over a plane it is the distance; `p` above 2) or "averaged" (a mean over the whole surface).
    `source` integrates "triangles" exactly or sums over "points", the vertices. Far parts count as points with
    their second moments (`expansion` "quadrupole") or without ("monopole") where they are farther than `opening` times their
    size; or, instead, so that the integral is off by at most `error`, a share of it. The surface counts fully up to `support`
    from a point, and from 5/4 of that not at all.

    Raises `OptionError` for what is out of range, `InputError` for a mesh without area and points that aren't finite.
    """
    settings = {"p": p, "form": form, "source": source, "expansion": expansion, "opening": opening,
                "error": error, "support": support}
    return _recede.averaged_distance(need_mesh("averaged_distance", mesh), points, settings, progress)
