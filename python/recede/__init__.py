"""Level-of-detail geometry that says how wrong it is.

Meshes go in and come out as numpy arrays::

    import recede
    mesh = recede.read("dragon.ply")
    small = recede.simplify(mesh, ratio=0.1)
    print(small.mesh.n_faces, small.error_bound)
    recede.write("small.ply", small.mesh)

Long calls release the interpreter's lock, run on all cores (see `set_threads`), and take `progress`: a callable
that receives the name of the stage and the done fraction of it, 0 to 1. When it returns False the call ends with
`Cancelled`; what it raises goes through. Ctrl-C works too. Lengths are in the units of the mesh.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import pi
from typing import Any, Optional, Union

import numpy.typing as npt

from ._recede import (
    Appearance,
    Atlas,
    AveragedDistance,
    BakedMaps,
    BakeResult,
    BillboardCloud,
    BillboardReflectance,
    CadGap,
    CadInstance,
    CadLevel,
    CadModel,
    CadPart,
    CadSeams,
    Cancelled,
    DicedView,
    Distance,
    Error,
    FileReport,
    Geomorph,
    Hierarchy,
    ImageDifference,
    InputError,
    Level,
    LevelError,
    MapFiles,
    Material,
    Mesh,
    OneSidedDistance,
    OptionError,
    RefinementReport,
    RepairStep,
    Shell,
    ShellLayer,
    SimplifyResult,
    Subdivision,
    TexturedShell,
    TrimmedPatch,
    TrimmingCurve,
    VolumeTexture,
    __version__,
)
from . import _recede
from ._options import place_or_none, simplify_options, three_numbers
from ._texts import give_texts, need_mesh
from .billboards import (build_billboards, make_billboard_reflectance, read_billboard_reflectance,
                         write_billboards)
from .hierarchies import bake, bake_maps, read_hierarchy
from .lights import AreaLight, DirectionalLight, EnvironmentLight, PointLight
from .pictures import diff, read_image, render, write_image
from .progressive import ProgressiveMesh, SelectiveMesh, build_progressive
from .shells import averaged_distance, build_shell
from .volumes import carve, fill_shell, make_volume, move_matter, read_textured_shell

__all__ = [
    "Appearance", "AreaLight", "Atlas", "AveragedDistance", "BakeResult", "BakedMaps", "BillboardCloud",
    "BillboardReflectance", "CadGap", "CadInstance", "CadLevel", "CadModel", "CadPart", "CadSeams", "Cancelled", "DicedView", "DirectionalLight",
    "Distance", "EnvironmentLight", "Error", "FileReport", "Geomorph", "Hierarchy", "ImageDifference", "InputError", "Level",
    "LevelError", "MapFiles", "Material", "Mesh", "OneSidedDistance", "OptionError", "PointLight",
    "ProgressiveMesh", "RefinementReport", "RepairStep", "SelectiveMesh", "Shell", "ShellLayer", "SimplifyResult",
    "Subdivision", "TexturedShell", "TrimmedPatch", "TrimmingCurve", "VolumeTexture", "averaged_distance", "bake", "bake_maps", "build_billboards",
    "build_progressive", "build_shell", "can_read_cad", "carve", "compare", "dice", "diff", "fill_shell", "make_appearance", "make_atlas",
    "make_billboard_reflectance", "make_displaced_sphere", "make_teapot", "make_tree", "make_volume", "move_matter", "read", "read_appearance",
    "read_billboard_reflectance", "read_cad", "read_hierarchy", "read_image", "read_textured_shell", "render", "set_threads", "simplify", "simplify_levels",
    "subdivide", "tessellate_cad", "write", "write_billboards", "write_image",
]

give_texts(_recede)

Progress = Callable[[str, float], Optional[bool]]
Path = Union[str, "os.PathLike[str]"]


def read(path: Path, *, repair: bool = True, progress: Progress | None = None) -> Mesh:
    """The mesh in an OBJ, PLY, STL, OFF, glTF or GLB file.

    With `repair`, identical vertices are merged, degenerate and duplicate faces removed, faces oriented alike and
    non-manifold places split; `mesh.repairs` says what each step changed. Without, the mesh is what the file holds.
    Pictures that materials name are read from beside the file (`base_color_picture`, bytes). Raises `InputError` that names the file and the line or byte.
    """
    return _recede.read(path, repair, progress)


def can_read_cad() -> bool:
    """Whether this build reads CAD files, for which it needs OpenCASCADE."""
    return _recede.can_read_cad()


def read_cad(path: Path, *, repair: bool = True, progress: Progress | None = None) -> CadModel:
    """The trimmed NURBS patches in a STEP, IGES or BREP file, in millimetres (`metres_per_unit` is 0.001).

    `model.parts` are bodies, which `model.instances` place: `placement` is a 4 x 4 matrix. A patch has `degrees`, `knots`,
    `points` (n_u x n_v x 3), `weights` (n_u x n_v, or None where all are 1) and `loops`, lists of curves in its
    parameters: outer ones run counter-clockwise, holes clockwise. Curves with the same `edge` of a part meet in space.

    With `repair`, faces that can't be used as they are get mended; `model.repairs` says how. `model.left_out` has pairs of
    what isn't there and why. Raises `InputError` when nothing can be used.
    """
    return _recede.read_cad(path, repair, progress)


def tessellate_cad(model: CadModel, errors: Sequence[float] = (), *, gap: float = 0, use_connectivity: bool = True,
                   progress: Progress | None = None) -> list[dict[str, object]]:
    """Triangles of a CAD model within each of `errors` (units of the model, increasing), without gaps between faces.

    Without errors there are five levels, from 0.03 % to 3 % of the size. Each level is a dict: its `mesh`, with normals of the
    surfaces and materials; its proved `error_bound` against the surfaces, and `max` and `rms` of samples;
    `switch_distance` for the default view; the number of `patches` that haven't vanished; in `missed` a line for each patch
    that isn't within the error. `gap` is the widest gap between patches that is sewn up (0: half of the first error);
    without `use_connectivity` it is found by position alone which patches meet.
    """
    return _recede.tessellate_cad(model, list(errors), gap, use_connectivity, progress)


def write(path: Path, mesh: Mesh) -> list[str]:
    """Writes a mesh; the extension chooses the format. Returns, in words, what that format can't hold.

    The file appears whole or not at all. Raises `InputError`.
    """
    return _recede.write(path, need_mesh("write", mesh))


def simplify(mesh: Mesh, *, faces: int | None = None, vertices: int | None = None, ratio: float | None = None,
             error: float | None = None, relative_error: float | None = None, progress: Progress | None = None,
             **options: Any) -> SimplifyResult:
    """A coarser mesh, by edge collapse; polygons stay polygons. The first target that is reached stops.

    Targets: at most `faces`, `vertices`, or `ratio` of the faces (0 to 1); `error`, the largest two-sided distance
    to the input, or `relative_error`, the same as a share of the bounding box's diagonal.

    The result has the mesh, `error_bound` (the certified two-sided distance, a bound and no estimate),
    `error_estimate`, `stop_reason`, counts, and `refused`: how many collapses were refused, by reason.

    Options: `cost` ("volume", "normal_deviation", or "texture_deviation"), `placement` ("automatic", "half_edge", "midpoint",
    "optimal"), `prove_error` (True; False: errors are estimated only, and faster), `feature_angle` (degrees: keep
    edges sharper than this; 0: none), `lock_borders` (False), `keep_uv_seams`, `keep_normal_seams`,
    `keep_polygons` (True); how much attributes count, as shares of the longest side that a change by one is worth:
    `uv_weight`, `normal_weight`, `color_weight`, `scalar_weights` (a dict by name); `join_distance` (0: parts stay
    apart) and `drop_parts` (False) for parts that no face connects; and for normal_deviation `normal_threshold` (0.99), `candidate_share` (0.01), `seed` (1).

    Raises `OptionError` for options out of range, `InputError` for a mesh that can't be used.
    """
    target = {"faces": faces, "vertices": vertices, "ratio": ratio, "error": error, "relative_error": relative_error}
    settings, feature_angle = simplify_options(options)
    return _recede.simplify(need_mesh("simplify", mesh), [target], settings, feature_angle, progress)[0]


def simplify_levels(mesh: Mesh, targets: Iterable[Mapping[str, float]], *, progress: Progress | None = None,
                    **options: Any) -> list[SimplifyResult]:
    """One run that stops at each target in turn, fine to coarse: `[{"ratio": 0.5}, {"ratio": 0.1}]`.

    Targets and options are those of `simplify`.
    """
    known = {"faces", "vertices", "ratio", "error", "relative_error"}
    levels = [dict(target) for target in targets]
    for level in levels:
        for name in level:
            if name not in known:
                raise TypeError(f"unexpected target {name!r}; known are {', '.join(sorted(known))}")
    settings, feature_angle = simplify_options(options)
    return _recede.simplify(need_mesh("simplify_levels", mesh), levels, settings, feature_angle, progress)


def compare(first: Mesh, second: Mesh, *, samples: int = 200_000, bound_tolerance: float | None = 0.05,
            progress: Progress | None = None) -> Distance:
    """The two-sided distance between two surfaces: sampled maximum, RMS and mean, and a certified bound.

    `samples` are spread over each surface by area, beside all vertices. `bound_tolerance` is the width of the
    certified interval as a share of `max_bound`; None certifies nothing.
    """
    first, second = need_mesh("compare", first), need_mesh("compare", second)
    return _recede.compare(first, second, samples, bound_tolerance, progress)


def make_atlas(mesh: Mesh, *, charts: int | None = None, bend_limit: float | None = None, compactness: float = 1,
               straighten: bool = True, keep_materials: bool = True, keep_uv_seams: bool = False,
               stretch_limit: float = 1.25, scale_by_stretch: bool = False, map_size: int = 1024, gutter: int = 4,
               progress: Progress | None = None) -> Atlas:
    """Cuts a surface into charts and gives it one-to-one texture coordinates.

    `charts` merges until so many are left; `bend_limit` is how far a chart may bend (0 flat, 0.5 a hemisphere; 0.2 when
    neither is set). Charts whose L2 stretch is above `stretch_limit` are cut. `map_size` and `gutter` are texels. The
    result has `mesh`, whose vertices at one place are merged, and `face_charts`, the chart of each of its faces.
    """
    options = {"charts": charts, "bend_limit": bend_limit, "compactness": compactness, "straighten": straighten,
               "keep_materials": keep_materials, "keep_uv_seams": keep_uv_seams, "stretch_limit": stretch_limit,
               "scale_by_stretch": scale_by_stretch, "map_size": map_size, "gutter": gutter}
    return _recede.make_atlas(need_mesh("make_atlas", mesh), options, progress)


def dice(surface: BakedMaps | Mesh, height: npt.ArrayLike | None = None, *, eye: Sequence[float] | None = None,
         look_at: Sequence[float] | None = None, up: Sequence[float] = (0, 1, 0), field_of_view: float = 45,
         image_width: int = 800, image_height: int = 600, triangle_pixels: float = 1, footprint: str = "by_side",
         map_levels: str = "mean", periodic: bool = False, cull: bool = True, normals: bool = True,
         progress: Progress | None = None) -> DicedView:
    """A mesh of a displaced surface for one view, without cracks, with triangles of about `triangle_pixels`.

    `surface` are baked maps, or a mesh with texture coordinates and `height`, an array of rows x columns lengths along
    its normals, row 0 on top; `periodic` repeats it beyond its border. Without `eye` (object units) the whole surface is
    seen from in front; `look_at` is otherwise its middle. `field_of_view` is vertical, degrees.

    A vertex moves by the height of its `footprint`: "by_side" is the highest around it seen from the front, the lowest
    seen from the back; "mean"; or "none", its own. `map_levels` "least_volume" keeps the volume of large footprints
    better and takes seconds. `cull` leaves out what isn't in the picture; without it closed surfaces stay closed.

    The result has `mesh`, with texture coordinates and normals, and the `report`, a dict. Raises `InputError` for maps
    without heights and meshes without texture coordinates, and `OptionError` for what is out of range.
    """
    if not isinstance(surface, Mesh if height is not None else BakedMaps):
        raise TypeError("dice takes baked maps, or a mesh and its heights")
    settings = {"up": three_numbers("up", up), "field_of_view": field_of_view * pi / 180, "image_width": image_width,
                "image_height": image_height, "triangle_pixels": triangle_pixels, "footprint": footprint,
                "map_levels": map_levels, "periodic": periodic, "cull": cull, "normals": normals}
    return _recede.dice(surface, height, place_or_none("eye", eye), place_or_none("look_at", look_at), settings, progress)


def make_appearance(surface: BakedMaps | Mesh, height: npt.ArrayLike | None = None, *, periodic: bool = False, bins: int = 31,
                    views: int = 31, azimuths: int = 1, samples: int = 131_072, progress: Progress | None = None) -> Appearance:
    """How heights look from afar: what `render` needs to draw them by a bump map and a table that are as bright.

    `surface` are baked maps, or a mesh with texture coordinates and `height`, an array of rows x columns lengths along its
    normals, row 0 on top, which `periodic` repeats; else it is taken with its mirror images. For `views` polar angles
    `samples` rays find which normals are seen, in `bins` x `bins` of equal solid angles; the mean over all azimuths, or for
    each of `azimuths`. Takes seconds.

    The result has `sides` (lengths of the map's sides on the surface, object units), `stretch_spread`, `wavelength` (of a
    typical wave of heights, object units), `brightness(toward_viewer, toward_light)` (the mean of the cosine of the light over
    the normals that are seen, without shadows; vectors in the frame of the surface: along u, along v, its normal) and
    `write(path)`; `read_appearance` reads that. Raises `InputError` for surfaces without texture coordinates and `OptionError`
    for what is out of range.
    """
    if not isinstance(surface, Mesh if height is not None else BakedMaps):
        raise TypeError("make_appearance takes baked maps, or a mesh and its heights")
    settings = {"periodic": periodic, "bins": bins, "views": views, "azimuths": azimuths, "samples": samples}
    return _recede.make_appearance(surface, height, settings, progress)


def read_appearance(path: Path) -> Appearance:
    """What `Appearance.write` or `recede bake --appearance` wrote. Raises `InputError` for anything else."""
    return _recede.read_appearance(path)


def subdivide(mesh: Mesh, *, scheme: str = "catmull-clark", subdivision_level: int | None = None, error: float | None = None,
              creases: Sequence[tuple[int, int, float]] = (), corners: Sequence[tuple[int, float]] = (),
              crease_angle: float | None = None, crease_sharpness: float = 10, feature_sharpness: float = 0,
              border: str = "edge-and-corner", uv_interpolation: str = "boundaries", creasing: str = "uniform",
              progress: Progress | None = None) -> Subdivision:
    """The limit surface of a control mesh: points on it, their normals, and the facets between them.

    `scheme` is "catmull-clark" or "loop" (triangles; other polygons are cut first). `subdivision_level` (2 when neither is given) is
    the number of refinements, 0 to 10; `error` takes the least one whose `error_estimate` is no larger, object units.
    `creases` are edges (vertex, vertex, sharpness), `corners` vertices (vertex, sharpness); from 10 on they are
    sharp for ever. Edges whose faces meet at more than `crease_angle` (degrees) get `crease_sharpness`, the mesh's feature
    edges `feature_sharpness`. `border` is "edge-only" or "edge-and-corner"; for `uv_interpolation` and `creasing` see
    docs/subdivision.md. The result has `mesh`, `level` and `error_estimate`.

    Raises `InputError` for a mesh that isn't manifold, `OptionError` for what is out of range.
    """
    if subdivision_level is not None and error is not None:
        raise OptionError("subdivision_level and error exclude each other")
    options = {"scheme": scheme, "subdivision_level": subdivision_level, "error": error, "creases": list(creases),
               "corners": list(corners), "crease_angle": None if crease_angle is None else crease_angle * pi / 180,
               "crease_sharpness": crease_sharpness, "feature_sharpness": feature_sharpness, "border": border,
               "uv_interpolation": uv_interpolation, "creasing": creasing}
    return _recede.subdivide(need_mesh("subdivide", mesh), options, progress)


def make_teapot(quads_per_side: int = 40, relief: float = 0.02) -> Mesh:
    """The Utah teapot as quads, z up, 6.5 units wide, with a smooth relief that high."""
    return _recede.make_teapot(quads_per_side, relief)


def make_displaced_sphere(faces: int = 250_000, *, triangles: bool = True) -> Mesh:
    """A sphere of radius 1 with ridges of noise, of at least so many triangles or quads."""
    return _recede.make_displaced_sphere(faces, triangles)


def make_tree(leaves: int = 2400, *, seed: int = 1) -> Mesh:
    """A broad-leaved tree, y up and about 10 units high, whose leaves nothing connects."""
    return _recede.make_tree(leaves, seed)


def set_threads(count: int) -> None:
    """Uses at most `count` threads from now on; 0: all. Results don't depend on it."""
    if count < 0:
        raise OptionError("the number of threads must not be negative")
    _recede.set_threads(count)
