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

import numpy as np
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
from ._texts import give_texts, need_mesh
from .billboards import (build_billboards, make_billboard_reflectance, read_billboard_reflectance,
                         write_billboards)
from .lights import AreaLight, DirectionalLight, EnvironmentLight, Light, PointLight, light_tuples
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
    Raises `InputError` that names the file and the line or byte.
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


def _simplify_options(options: Mapping[str, Any]) -> tuple[dict[str, Any], float]:
    known = {"cost", "placement", "prove_error", "lock_borders", "keep_uv_seams", "keep_normal_seams",
             "keep_polygons", "uv_weight", "normal_weight", "color_weight", "scalar_weights",
             "join_distance", "drop_parts", "normal_threshold", "candidate_share", "seed", "feature_angle"}
    for name in options:
        if name not in known:
            raise TypeError(f"unexpected option {name!r}; known are {', '.join(sorted(known))}")
    rest = dict(options)
    angle = float(rest.pop("feature_angle", 0.0))
    if not 0 <= angle <= 180:
        raise OptionError("feature_angle must lie between 0 and 180 degrees")
    return rest, angle * pi / 180


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
    settings, feature_angle = _simplify_options(options)
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
    settings, feature_angle = _simplify_options(options)
    return _recede.simplify(need_mesh("simplify_levels", mesh), levels, settings, feature_angle, progress)


def compare(first: Mesh, second: Mesh, *, samples: int = 200_000, bound_tolerance: float | None = 0.05,
            progress: Progress | None = None) -> Distance:
    """The two-sided distance between two surfaces: sampled maximum, RMS and mean, and a certified bound.

    `samples` are spread over each surface by area, beside all vertices. `bound_tolerance` is the width of the
    certified interval as a share of `max_bound`; None certifies nothing.
    """
    first, second = need_mesh("compare", first), need_mesh("compare", second)
    return _recede.compare(first, second, samples, bound_tolerance, progress)


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


def _map_options(maps: Sequence[str], size: int, format: str, normal_bits: int,
                 seam_weight: float | None) -> dict[str, Any]:
    names = [maps] if isinstance(maps, str) else list(maps)
    return {"maps": names, "map_size": size, "map_format": format, "map_normal_bits": normal_bits,
            "map_seam_weight": seam_weight}


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
    settings = {**_map_options(maps, map_size, map_format, map_normal_bits, map_seam_weight),
                "search_distance": search_distance}
    return _recede.bake_maps(need_mesh("bake_maps", fine), need_mesh("bake_maps", coarse), settings, progress)


def bake(surface: Mesh | CadModel | Path, folder: Path, *, name: str = "model", faces: Sequence[int] | None = None,
         ratios: Sequence[float] | None = None, errors: Sequence[float] | None = None, relative_errors: Sequence[float] | None = None,
         distances: Sequence[float] | None = None, image_height: float = 1080, field_of_view: float = 45,
         pixel_error: float = 1, maps: Sequence[str] = (), map_size: int = 1024, map_format: str = "png",
         map_normal_bits: int = 8, map_seam_weight: float | None = None, up: Sequence[float] = (0, 1, 0),
         report: bool = True, viewer_triangles: int = 200_000, billboards: bool = True, gap: float = 0,
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

    A CAD model (`read_cad`) becomes triangles of its NURBS surfaces, see docs/cad.md: its levels are chosen by `errors`,
    `relative_errors` (0.0003, 0.001, 0.003, 0.01, 0.03 when nothing is given) or `distances`, and the first error is that of
    level 0. `gap` is the widest between patches that is sewn up, units of the model (0: half of the finest error);
    without `use_connectivity` it is found by position which patches meet, even where the file knows it.
    `result.cad_levels` and `result.cad_parts` say what became of patches and seams. `faces`, `ratios`, `maps` and options
    of `simplify` are for meshes only, and raise `OptionError`; there are no billboards.

    With `memory`, bytes that the process may take (at least 256 MiB), `surface` is the path of a mesh file. One that is larger
    (binary PLY or STL) is baked in chunks, see docs/out-of-core.md: level 0 has as many faces as fit, errors are those to the
    file, `result.source_faces` is the number of its faces (else 0), and `result.left_out` has the levels that would be finer
    than level 0.
    """
    levels = {"faces": list(faces or []), "ratios": list(ratios or []), "errors": list(errors or []),
              "relative_errors": list(relative_errors or []), "distances": list(distances or []),
              "image_height": image_height, "field_of_view": field_of_view * pi / 180, "pixel_error": pixel_error,
              "up": list(up), "report": report, "viewer_triangles": viewer_triangles, "billboards": billboards,
              "gap": gap, "use_connectivity": use_connectivity,
              **_map_options(maps, map_size, map_format, map_normal_bits, map_seam_weight)}
    settings, feature_angle = _simplify_options(options)
    if isinstance(surface, CadModel):
        for option, value in {"faces": faces, "ratios": ratios, "maps": maps, "memory": memory, **options}.items():
            if value is not None and value != ():
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


class ProgressiveMesh:
    """A coarse base and the vertex splits that bring the input back, bit for bit; see `build_progressive`."""

    def __init__(self, compiled: _recede.ProgressiveMesh) -> None:
        self._compiled = compiled

    def level(self, *, faces: int | None = None, error: float | None = None, splits: int | None = None) -> Mesh:
        """One level: the finest with at most `faces`, the coarsest with at most `error`, or that of so many `splits`.

        Without an argument the finest, which is the input.
        """
        return self._compiled.level(_recede.LevelChoice(faces, error, splits))

    def geomorph(self, *, faces: int | None = None, error: float | None = None, splits: int | None = None,
                 coarse_faces: int | None = None, coarse_error: float | None = None,
                 coarse_splits: int | None = None) -> Geomorph:
        """A level, as for `level`, that turns into a coarser one (without an argument the base) without a jump.

        `at(share)` is the mesh between them, from the coarse one at 0 to the fine one at 1; `parents` has for each
        vertex of the fine level its vertex in the coarse one (4294967295: none); `write` makes a `.glb`, `.gltf` or
        `.ply` file, see docs/progressive.md.
        """
        return self._compiled.geomorph(_recede.LevelChoice(coarse_faces, coarse_error, coarse_splits),
                                       _recede.LevelChoice(faces, error, splits))

    def selective(self) -> SelectiveMesh:
        """The mesh for views: fine where it is seen. It starts at the base."""
        return SelectiveMesh(self._compiled.selective())

    def write(self, path: Path, *, bits: int | None = None, attribute_bits: int | None = None,
              keep_numbering: bool = False, keep_order: bool | None = None) -> FileReport:
        """Writes a `.pmesh` file. `bits` quantise positions, `attribute_bits` the rest, 1 to 30; None: bit for bit.

        `keep_numbering` also writes how the input numbers vertices and faces; `keep_order` (None: without `bits`)
        keeps the order of splits and every level's error.
        """
        return self._compiled.write(path, bits, attribute_bits, keep_numbering, keep_order)

    @staticmethod
    def read(path: Path) -> ProgressiveMesh:
        """What `write` wrote. Raises `InputError` that names the byte."""
        return ProgressiveMesh(_recede.read_progressive(path))

    @property
    def n_splits(self) -> int:
        return self._compiled.n_splits

    @property
    def level_faces(self) -> np.ndarray:
        """Number of faces by number of splits."""
        return self._compiled.level_faces

    @property
    def level_errors(self) -> np.ndarray:
        """Two-sided distance to the input by number of splits; a bound when `errors_are_proved`."""
        return self._compiled.level_errors

    @property
    def errors_are_proved(self) -> bool:
        return self._compiled.errors_are_proved

    @property
    def seconds(self) -> float:
        """Without those of the proofs."""
        return self._compiled.seconds

    @property
    def proof_seconds(self) -> float:
        return self._compiled.proof_seconds


class SelectiveMesh:
    """A progressive mesh refined for a view; see `ProgressiveMesh.selective`."""

    def __init__(self, compiled: _recede.SelectiveMesh) -> None:
        self._compiled = compiled

    def update(self, position: Sequence[float], target: Sequence[float] = (0, 0, 0), *, up: Sequence[float] = (0, 1, 0),
               image_height: float = 1080, field_of_view: float = 45, pixel_error: float = 1, image_width: float | None = None,
               cull: bool = True, back_pixel_error: float | None = None, silhouette_pixel_error: float | None = None,
               faces: int | None = None) -> RefinementReport:
        """Refines and coarsens from where the last view left it, until errors of at most `pixel_error` pixels are seen.

        Looks from `position` to `target`, object units; `field_of_view` is vertical, degrees; the image is as wide as high without
        `image_width` (pixels). Faces that look away and
        silhouettes may have errors of their own; `cull` leaves what is outside the image coarse; with at most so many `faces` the
        largest errors go first. Raises `OptionError` for what is out of range.
        """
        view = _recede.RefinementView()
        view.position, view.target, view.up = position, target, up
        view.image_height, view.field_of_view, view.pixel_error = image_height, field_of_view * pi / 180, pixel_error
        view.aspect_ratio, view.cull = (image_width or image_height) / image_height, cull
        view.back_pixel_error, view.silhouette_pixel_error = back_pixel_error, silhouette_pixel_error
        view.faces = faces
        return self._compiled.update(view)

    def update_error(self, error: float) -> RefinementReport:
        """The level of at most that error everywhere, object units."""
        return self._compiled.update_error(error)

    def mesh(self) -> Mesh:
        """As it stands."""
        return self._compiled.mesh()

    @property
    def n_faces(self) -> int:
        return self._compiled.n_faces


def build_progressive(mesh: Mesh, *, faces: int | None = None, vertices: int | None = None, ratio: float | None = None,
                      progress: Progress | None = None, **options: Any) -> ProgressiveMesh:
    """All levels of a mesh between a base and itself.

    `faces`, `vertices` and `ratio` say how small the base is (as small as can be when none is given). Options are those
    of `simplify`, where the placement "automatic" is "half_edge" and `prove_error=False` leaves estimates.
    """
    settings, feature_angle = _simplify_options(options)
    target = {"faces": faces, "vertices": vertices, "ratio": ratio}
    compiled = _recede.build_progressive(need_mesh("build_progressive", mesh), {**settings, **target}, feature_angle, progress)
    return ProgressiveMesh(compiled)


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
    settings = {"up": up, "field_of_view": field_of_view * pi / 180, "image_width": image_width,
                "image_height": image_height, "triangle_pixels": triangle_pixels, "footprint": footprint,
                "map_levels": map_levels, "periodic": periodic, "cull": cull, "normals": normals}
    return _recede.dice(surface, height, eye, look_at, settings, progress)


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
    if appearance is not None and height is None and not isinstance(surface, BakedMaps):
        raise TypeError("an appearance is that of heights, and there are none")
    if reflectance is not None and not isinstance(surface, BillboardCloud):
        raise TypeError("a reflectance is that of billboards, and there are none")
    if matter_color is not None and not isinstance(surface, TexturedShell):
        raise TypeError("a matter_color is that of a textured shell")
    is_surface = isinstance(surface, (Mesh, BakedMaps, BillboardCloud, TexturedShell))
    if not is_surface or (height is not None and not isinstance(surface, Mesh)):
        raise TypeError("render takes a mesh, a mesh and its heights, baked maps, billboards, or a textured shell")
    return _recede.render(surface, eye, look_at, up, field_of_view * pi / 180, image_width, image_height, options, progress)


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
