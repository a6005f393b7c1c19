"""Hierarchies of levels, and maps of a fine surface on a coarse one. See docs/hierarchy.md and docs/maps.md."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING, Any

from . import _recede
from ._options import list_of, map_options, simplify_options, three_numbers
from ._recede import CadModel, Mesh, OptionError
from ._texts import need_mesh

if TYPE_CHECKING:
    from . import BakedMaps, BakeResult, Hierarchy, Path, Progress


def bake_maps(fine: Mesh, coarse: Mesh, *, maps: Sequence[str] = ("displacement", "normal", "color"),
              map_size: int = 1024, map_format: str = "png", map_normal_bits: int = 8,
              map_seam_weight: float | None = None, search_distance: float | None = None,
              progress: Progress | None = None) -> BakedMaps:
    """Maps that carry the detail of `fine` on `coarse`, as arrays with row 0 on top.

    `height` (size x size, float32) are lengths in the units of the mesh along the interpolated normals; `normal`
    (size x size x 3, float32) are unit vectors of tangent space, y up; `color` (size x size x 3, uint8) is sRGB, None
    when `fine` has no colours. They belong to `surface`, which is `coarse` with one-to-one texture coordinates: its own,
    or those of a new atlas. `uvs`, `normals` and `tangents` are the surface's, one row for each corner; the last number
    of a tangent is the sign of the bitangent. `report` is a dict: what was missed, how far seams differ.
    `measure(fine)` gives the two-sided distances with and without displacement.

    With `map_format` "png" arrays hold what 16-bit heights and normals of `map_normal_bits` (8 or 16) can hold; with
    "exr" floats without steps. `map_seam_weight` None closes seams to a step of the 16 bits; 1e4 keeps more detail
    along them, 0 leaves them open. `search_distance` is how far from `coarse` the fine surface is looked for (None: twice
    the largest sampled distance).
    """
    settings = {**map_options(maps, map_size, map_format, map_normal_bits, map_seam_weight),
                "search_distance": search_distance}
    return _recede.bake_maps(need_mesh("bake_maps", fine), need_mesh("bake_maps", coarse), settings, progress)


def bake(surface: Mesh | CadModel | Path, folder: Path, *, name: str = "model", faces: Sequence[int] | None = None,
         ratios: Sequence[float] | None = None, errors: Sequence[float] | None = None, relative_errors: Sequence[float] | None = None,
         distances: Sequence[float] | None = None, image_height: float = 1080, field_of_view: float = 45,
         pixel_error: float = 1, maps: Sequence[str] = (), map_size: int = 1024, map_format: str = "png",
         map_normal_bits: int = 8, map_seam_weight: float | None = None, up: Sequence[float] = (0, 1, 0),
         report: bool = True, viewer_triangles: int = 200_000, billboards: bool = True, glb_per_level: bool = False, gap: float = 0,
         use_connectivity: bool = True, memory: int | None = None, progress: Progress | None = None,
         **options: Any) -> BakeResult:
    """A hierarchy of levels in `folder`: `<name>.glb` with all levels, `<name>.recede/`, and report.html.

    Levels are chosen by one of: numbers of `faces`, decreasing, or `ratios` of them (0.5, 0.25, 0.1, 0.03, 0.01 when
    nothing is given); certified `errors`, increasing, or `relative_errors`, shares of the diagonal; camera `distances`,
    increasing, whose errors follow from the view: `image_height` (pixels), vertical `field_of_view` (degrees) and
    `pixel_error` (pixels). `up` points upwards in the report's pictures, in whose viewer levels of more than
    `viewer_triangles` are left out. Options are those of `simplify`.

    `maps` names what of the input is baked onto every coarser level: "displacement", "normal", "color". They have
    `map_size` texels a side; `map_format` "exr" writes heights and normals as floats too. The other options of maps
    are those of `bake_maps`. `result.map_files` has the paths by level.

    Where billboards look more like the mesh from far away than triangles of as many bytes they become the last levels;
    `result.far_levels` says why or why not. `billboards` False doesn't try them.

    `glb_per_level` also writes `<name>_level_<number>.glb` for each level, named by `result.level_glbs`, for engines that don't
    know `MSFT_lod`.

    A CAD model (`read_cad`) becomes triangles of its NURBS surfaces, see docs/cad.md: its levels are chosen by `errors`,
    `relative_errors` (0.0003, 0.001, 0.003, 0.01, 0.03 when nothing is given) or `distances`, and the first error is that of
    level 0. `gap` is the widest between patches that is sewn up, units of the model (0: half of the finest error);
    without `use_connectivity` it is found by position which patches meet, even where the file knows it.
    `result.cad_levels` and `result.cad_parts` say what became of patches and seams. `faces`, `ratios`, `maps` and options
    of `simplify` are for meshes only, and raise `OptionError`; there are no billboards.

    With `memory`, bytes that the process may take (at least 256 MiB), `surface` is the path of a mesh file. One that is larger
    (binary PLY or STL) is baked in chunks, see docs/out-of-core.md: level 0 has as many faces as fit, errors are those to the
    file, `result.source_faces` is the number of its faces (else None), and `result.left_out` has the levels that would be finer
    than level 0.
    """
    levels = {"faces": list_of(faces), "ratios": list_of(ratios), "errors": list_of(errors),
              "relative_errors": list_of(relative_errors), "distances": list_of(distances),
              "image_height": image_height, "field_of_view": field_of_view * pi / 180, "pixel_error": pixel_error,
              "up": three_numbers("up", up), "report": report, "viewer_triangles": viewer_triangles, "billboards": billboards,
              "glb_per_level": glb_per_level, "gap": gap, "use_connectivity": use_connectivity,
              **map_options(maps, map_size, map_format, map_normal_bits, map_seam_weight)}
    settings, feature_angle = simplify_options(options)
    if isinstance(surface, CadModel):
        for_meshes = {"faces": faces, "ratios": ratios, "maps": levels["maps"] or None, "memory": memory, **options}
        for option, value in for_meshes.items():
            if value is not None:
                raise OptionError(f"{option} is for meshes, not for CAD models")
        return _recede.bake_cad(surface, folder, name, levels, progress)
    if gap != 0 or not use_connectivity:
        raise OptionError("gap and use_connectivity are for CAD models")
    if memory is not None:
        if isinstance(surface, Mesh):
            raise OptionError("memory is for files: give the mesh's path")
        return _recede.bake_file(surface, folder, name, levels, settings, feature_angle, memory, progress)
    return _recede.bake(need_mesh("bake", surface), folder, name, levels, settings, feature_angle, progress)


def read_hierarchy(folder: Path) -> Hierarchy:
    """What `bake` or `recede bake` wrote: the folder `<name>.recede`, or that around it when it holds one.

    `levels` have `mesh`, `error` and `switch_distance`, finest first. `level_for(distance)` is the number of the coarsest
    one whose error is at most `pixel_error` pixels at that distance from the surface; `image_height` (pixels) and
    `field_of_view` (vertical, degrees) are those that were baked for, unless given to it. Raises `InputError`.
    """
    return _recede.read_hierarchy(folder)
