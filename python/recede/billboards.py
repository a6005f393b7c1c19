"""Billboard clouds, their textures and their reflectance. See docs/billboards.md."""

from __future__ import annotations

import os
from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING

from . import _recede
from ._options import list_of
from ._texts import need_mesh

if TYPE_CHECKING:
    from . import BillboardCloud, BillboardReflectance, Mesh, Path, Progress


def build_billboards(mesh: Mesh, *, errors: Sequence[float] | None = None,
                     relative_errors: Sequence[float] | None = None, method: str = "clusters",
                     normal_deviation: float = 60, waste: float = 4, two_sided: bool = False, neighbours: int = 50,
                     textures: bool = True, texels_per_error: float = 1, samples: int = 4, overlap: int = 2,
                     gutter: int = 1, most_bytes: int | None = None,
                     progress: Progress | None = None) -> list[BillboardCloud]:
    """Rectangles that stand for a mesh, or loose polygons, from far away: a cloud for each error, finest first.

    `errors` rise, and are in units of the mesh; `relative_errors` are shares of the diagonal; without both there are
    clouds for 0.5, 1, 2 and 4 % of the longest side. No point of a face is farther from the plane of its rectangle.
    `method`: "clusters" (little texture, rectangles that face as their faces do), "planes" (few of them) or
    "simplification". Clusters have normals within `normal_deviation` (degrees) and an area of at most `waste` times
    that of their faces; faces merge with those among their `neighbours`. `two_sided`: faces count from both sides.

    Textures (colour with opacity, normals, heights) have texels of the error over `texels_per_error`, and `samples`
    rays along each side of them. `overlap` texels beside its own faces a rectangle shows those of others; `gutter`
    texels are between rectangles. `most_bytes`: instead of errors, the one cloud of least error whose textures take at
    most as many bytes. Raises `OptionError` when none fits.
    """
    settings = {"errors": list_of(errors), "relative_errors": list_of(relative_errors), "method": method,
                "normal_deviation": normal_deviation, "waste": waste, "two_sided": two_sided,
                "neighbours": neighbours, "texels_per_error": texels_per_error, "samples": samples,
                "overlap": overlap, "gutter": gutter, "most_bytes": most_bytes}
    return _recede.build_billboards(need_mesh("build_billboards", mesh), settings, textures, progress)


def write_billboards(folder: Path, mesh: Mesh, clouds: Sequence[BillboardCloud], *, name: str = "model",
                     image_height: float = 1080, field_of_view: float = 45, pixel_error: float = 1,
                     progress: Progress | None = None) -> os.PathLike[str]:
    """Writes clouds with textures as levels, finest first: `<name>.glb` and `<name>.recede/` in `folder`.

    Returns the path of the GLB. `mesh` is what they were made of. The view (`field_of_view` vertical, degrees) says
    from which distances on they serve.
    """
    view = {"image_height": image_height, "field_of_view": field_of_view * pi / 180, "pixel_error": pixel_error}
    return _recede.write_billboards(folder, need_mesh("write_billboards", mesh), list(clouds), name, view, progress)


def make_billboard_reflectance(mesh: Mesh, cloud: BillboardCloud, *, view_side: int = 7, light_side: int = 7,
                               samples: int = 4, shaded: int = 8, bounces: int = 1, largest_share: float = 0.01,
                               memory: float = 2e9, progress: Progress | None = None) -> BillboardReflectance:
    """What each texel of a cloud with textures sends of each light to each viewer, with shadows: for `render`.

    `mesh` is what the cloud was made of. There are `view_side` x `view_side` views over each side of a rectangle, and twice
    `light_side` x `light_side` lights around it. In each view `samples` rays along each side of a texel say what share of it
    is covered; `shaded` of them at most look for lights, and light goes from face to face `bounces` times. The result takes
    at most `largest_share` of the values as halves; while it is made, values take `memory` bytes. Takes up to minutes.

    Raises `OptionError` for what is out of range and for clouds without textures, `InputError` for another mesh's cloud.
    """
    settings = {"view_side": view_side, "light_side": light_side, "samples": samples, "shaded": shaded, "bounces": bounces,
                "largest_share": largest_share, "memory": memory}
    mesh = need_mesh("make_billboard_reflectance", mesh)
    return _recede.make_billboard_reflectance(mesh, cloud, settings, progress)


def read_billboard_reflectance(path: Path) -> BillboardReflectance:
    """What `BillboardReflectance.write` or `recede billboards --reflectance` wrote. Raises `InputError` for anything else."""
    return _recede.read_billboard_reflectance(path)
