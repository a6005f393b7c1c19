from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np
import numpy.typing as npt

_Progress = Optional[Callable[[str, float], Optional[bool]]]
_Path = Union[str, PathLike[str]]

__version__: str

class Error(RuntimeError):
    """Base of every error that Recede raises on purpose."""

class InputError(Error):
    """A file, mesh or value that can't be used; the text names the place."""

class OptionError(Error):
    """An option outside its range, or options that contradict each other."""

class Cancelled(Error):
    """The progress callable asked to stop. Nothing was changed or written."""

class Material:
    def __init__(
        self, name: str, base_color: Sequence[float] = ..., base_color_texture: str = "",
        base_color_picture: Optional[bytes] = None,
    ) -> None:
        """`base_color_picture` are the bytes of a PNG or JPEG file, and `base_color_texture` its name, which it needs."""
    @property
    def name(self) -> str: ...
    @property
    def base_color(self) -> tuple[float, float, float, float]: ...
    @property
    def base_color_texture(self) -> str: ...
    @property
    def base_color_picture(self) -> Optional[bytes]: ...

class RepairStep:
    @property
    def name(self) -> str: ...
    @property
    def changed(self) -> int: ...
    @property
    def detail(self) -> str: ...

class Mesh:
    """Polygons over shared vertices. Arrays are read-only views; nothing of a mesh changes."""
    def __init__(
        self,
        positions: npt.ArrayLike,
        faces: Union[npt.ArrayLike, Sequence[Sequence[int]]],
        *,
        corner_uvs: Optional[npt.ArrayLike] = None,
        corner_normals: Optional[npt.ArrayLike] = None,
        vertex_colors: Optional[npt.ArrayLike] = None,
        vertex_scalars: Mapping[str, npt.ArrayLike] = ...,
        face_materials: Optional[npt.ArrayLike] = None,
        materials: Sequence[Material] = ...,
        feature_edges: Optional[npt.ArrayLike] = None,
    ) -> None: ...
    @property
    def n_vertices(self) -> int: ...
    @property
    def n_faces(self) -> int: ...
    @property
    def positions(self) -> npt.NDArray[np.float64]:
        """V x 3"""
    @property
    def faces(self) -> Union[npt.NDArray[np.uint32], list[list[int]]]:
        """F x n when all faces have n sides, else a list of lists."""
    @property
    def face_offsets(self) -> npt.NDArray[np.uint32]:
        """F + 1 entries: face f has the corners face_offsets[f] to face_offsets[f + 1]."""
    @property
    def corner_vertices(self) -> npt.NDArray[np.uint32]:
        """C vertex numbers"""
    @property
    def triangles(self) -> npt.NDArray[np.uint32]:
        """T x 3: the faces cut into triangles"""
    @property
    def corner_uvs(self) -> Optional[npt.NDArray[np.float64]]:
        """C x 2, or None"""
    @property
    def corner_normals(self) -> Optional[npt.NDArray[np.float64]]:
        """C x 3, or None"""
    @property
    def vertex_colors(self) -> Optional[npt.NDArray[np.float64]]:
        """V x 4, linear, with opacity; or None"""
    @property
    def vertex_scalars(self) -> dict[str, npt.NDArray[np.float64]]:
        """V numbers each, by name"""
    @property
    def face_materials(self) -> Optional[npt.NDArray[np.uint32]]:
        """F places in `materials` (0xffffffff: none), or None"""
    @property
    def materials(self) -> list[Material]: ...
    @property
    def feature_edges(self) -> list[tuple[int, int]]: ...
    @property
    def diagonal(self) -> float:
        """Of the bounding box"""
    @property
    def repairs(self) -> list[RepairStep]: ...

class SimplifyResult:
    @property
    def mesh(self) -> Mesh: ...
    @property
    def faces_before(self) -> int: ...
    @property
    def faces_after(self) -> int: ...
    @property
    def vertices_before(self) -> int: ...
    @property
    def vertices_after(self) -> int: ...
    @property
    def collapses(self) -> int: ...
    @property
    def joined(self) -> int:
        """Pairs of points of different parts that became one."""
    @property
    def dropped_parts(self) -> int: ...
    @property
    def dropped_faces(self) -> int: ...
    @property
    def passes(self) -> int: ...
    @property
    def error_bound(self) -> Optional[float]:
        """Certified two-sided distance to the input; None when it wasn't proved."""
    @property
    def error_lower(self) -> float:
        """A distance that occurs."""
    @property
    def error_estimate(self) -> float:
        """What the collapses may have moved the surface by; no bound."""
    @property
    def stop_reason(self) -> str: ...
    @property
    def refused(self) -> dict[str, int]: ...
    @property
    def seconds(self) -> float:
        """Without those of the proof."""
    @property
    def proof_seconds(self) -> float: ...

class OneSidedDistance:
    @property
    def max(self) -> float: ...
    @property
    def rms(self) -> float: ...
    @property
    def mean(self) -> float: ...
    @property
    def at(self) -> tuple[float, float, float]: ...

class Distance:
    @property
    def forward(self) -> OneSidedDistance: ...
    @property
    def backward(self) -> OneSidedDistance: ...
    @property
    def max(self) -> float: ...
    @property
    def rms(self) -> float: ...
    @property
    def max_bound(self) -> Optional[float]: ...
    @property
    def max_lower(self) -> float: ...
    @property
    def diagonal(self) -> float: ...
    @property
    def samples(self) -> int: ...

class ImageDifference:
    @property
    def flip(self) -> float:
        """Mean, 0: equal, to 1"""
    @property
    def ssim(self) -> float:
        """Mean, 1: equal"""
    @property
    def psnr(self) -> float:
        """dB; inf: equal"""
    @property
    def rmse(self) -> float:
        """Of sRGB values from 0 to 1, like `max`"""
    @property
    def max(self) -> float: ...
    @property
    def changed_share(self) -> float:
        """Share of the pixels that differ by more than 1/255"""
    @property
    def flip_map(self) -> npt.NDArray[np.float32]:
        """H x W, 0 outside the mask"""
    @property
    def ssim_map(self) -> npt.NDArray[np.float32]:
        """H x W, 1 outside the mask"""
    @property
    def difference_map(self) -> npt.NDArray[np.float32]:
        """H x W: the largest difference of a channel, 0 outside the mask"""

class LevelError:
    @property
    def max(self) -> float: ...
    @property
    def rms(self) -> float: ...
    @property
    def bound(self) -> float: ...

class Level:
    @property
    def mesh(self) -> Mesh: ...
    @property
    def error(self) -> LevelError: ...
    @property
    def switch_distance(self) -> float: ...
    @property
    def screen_coverage(self) -> float: ...
    @property
    def stop_reason(self) -> str: ...
    @property
    def is_billboards(self) -> bool:
        """`mesh` has their rectangles"""
    @property
    def maps(self) -> Optional[BakedMaps]:
        """A copy of those that were baked for it"""
    @property
    def billboards(self) -> Optional[BillboardCloud]:
        """A copy of them; one that was read doesn't know its faces: `faces_of`, `errors` and `normal_deviations` are empty or 0"""

class MapFiles:
    """The maps of a level; None: there is no such map."""
    @property
    def displacement(self) -> Optional[Path]: ...
    @property
    def normal(self) -> Optional[Path]: ...
    @property
    def color(self) -> Optional[Path]: ...
    @property
    def displacement_exr(self) -> Optional[Path]:
        """With map_format "exr", beside the PNG file."""
    @property
    def normal_exr(self) -> Optional[Path]: ...
    @property
    def height(self) -> Optional[Path]:
        """Of billboards"""

class BakedMaps:
    """A coarse surface and its maps."""
    @property
    def surface(self) -> Mesh: ...
    @property
    def size(self) -> int:
        """Texels a side"""
    @property
    def height(self) -> Optional[npt.NDArray[np.float32]]:
        """size x size, units of the mesh"""
    @property
    def normal(self) -> Optional[npt.NDArray[np.float32]]:
        """size x size x 3, unit vectors of tangent space"""
    @property
    def color(self) -> Optional[npt.NDArray[np.uint8]]:
        """size x size x 3, sRGB"""
    @property
    def uvs(self) -> npt.NDArray[np.float64]:
        """C x 2"""
    @property
    def normals(self) -> npt.NDArray[np.float64]:
        """C x 3, unit vectors along which heights count"""
    @property
    def tangents(self) -> npt.NDArray[np.float64]:
        """C x 4: unit vector, and the sign of the bitangent"""
    @property
    def report(self) -> dict[str, Any]: ...
    def measure(self, fine: Mesh, *, progress: _Progress = ...) -> dict[str, float]:
        """`bare_max`, `bare_rms`, `max`, `rms`: two-sided distances without and with displacement"""

class Appearance:
    """How heights look from afar. See `recede.make_appearance`."""
    @property
    def sides(self) -> np.ndarray: ...
    @property
    def stretch_spread(self) -> np.ndarray: ...
    @property
    def wavelength(self) -> float: ...
    def brightness(self, toward_viewer: Sequence[float], toward_light: Sequence[float]) -> float: ...
    def write(self, path: _Path) -> None: ...

def make_appearance(
    surface: Any, height: Any, settings: Mapping[str, Any], progress: _Progress
) -> Appearance: ...
def read_appearance(path: _Path) -> Appearance: ...

class DicedView:
    """A mesh for one view, and what was done."""
    @property
    def mesh(self) -> Mesh: ...
    @property
    def report(self) -> dict[str, Any]:
        """Counts by stage, `largest_move` (units of the mesh) and `seconds`"""

class BillboardReflectance:
    """What the texels of a cloud send of each light to each viewer. See `recede.make_billboard_reflectance`."""
    @property
    def bytes(self) -> int: ...
    @property
    def raw_bytes(self) -> int:
        """As halves, without compression"""
    @property
    def rms(self) -> float:
        """Error of the compression, as a share of the values' range"""
    @property
    def n_vectors(self) -> int:
        """Texels that show something; twice as many for two-sided faces"""
    def write(self, path: _Path) -> None: ...

class BillboardCloud:
    """Rectangles for the faces of a mesh; n of them. Textures are None without `textures`."""
    @property
    def error(self) -> float:
        """That was asked for, units of the mesh"""
    @property
    def left_out(self) -> int:
        """Faces without area"""
    @property
    def n_billboards(self) -> int: ...
    @property
    def centers(self) -> npt.NDArray[np.float64]:
        """(n, 3)"""
    @property
    def axes_u(self) -> npt.NDArray[np.float64]:
        """(n, 3), unit; rows of the texture run along them"""
    @property
    def axes_v(self) -> npt.NDArray[np.float64]:
        """(n, 3), unit, upwards in the texture; the front is axes_u x axes_v"""
    @property
    def half_sizes(self) -> npt.NDArray[np.float64]:
        """(n, 2)"""
    @property
    def errors(self) -> npt.NDArray[np.float64]:
        """(n,), the largest distance of a face from each"""
    @property
    def normal_deviations(self) -> npt.NDArray[np.float64]:
        """(n,), the largest angle between a face and each, degrees"""
    def faces_of(self, billboard: int) -> list[int]: ...
    @property
    def places(self) -> Optional[npt.NDArray[np.int32]]:
        """(n, 4): column, row, width and height in the textures, texels"""
    @property
    def color(self) -> Optional[npt.NDArray[np.uint8]]:
        """(height, width, 4), sRGB with opacity; row 0 on top"""
    @property
    def normal(self) -> Optional[npt.NDArray[np.uint8]]:
        """(height, width, 3): 0 to 255 are -1 to 1 along the axes and the front"""
    @property
    def height(self) -> Optional[npt.NDArray[np.uint8]]:
        """(height, width): 0 to 255 are -height_range to height_range over the rectangle"""
    @property
    def height_range(self) -> Optional[float]: ...
    @property
    def texel(self) -> Optional[float]:
        """Its longest side, units of the mesh"""
    @property
    def n_texels(self) -> Optional[int]:
        """Of the rectangles"""
    @property
    def bytes(self) -> Optional[int]:
        """Of the textures in memory"""
    @property
    def covered(self) -> Optional[float]:
        """Share of the textures that is drawn"""
    @property
    def quads(self) -> Optional[Mesh]:
        """With texture coordinates and normals"""

class BakeResult:
    @property
    def levels(self) -> list[Level]: ...
    @property
    def glb(self) -> Path: ...
    @property
    def level_glbs(self) -> list[Path]:
        """One for each level, with `glb_per_level`"""
    @property
    def folder(self) -> Path: ...
    @property
    def map_files(self) -> list[MapFiles]:
        """One for each level"""
    @property
    def far_levels(self) -> list[str]:
        """Why billboards or triangles stand far away"""
    @property
    def report(self) -> Optional[Path]: ...
    @property
    def cad_levels(self) -> list[CadLevel]:
        """Of CAD models, one for each level"""
    @property
    def cad_parts(self) -> list[CadSeams]:
        """Of CAD models, one for each part"""
    @property
    def source_faces(self) -> Optional[int]:
        """Of a file that was larger than memory; else None"""
    @property
    def left_out(self) -> list[float]:
        """Levels that would be finer than level 0 of such a file: faces, or errors in object units"""

class Hierarchy:
    """Levels of detail that were read; finest first, level 0 is the input."""
    @property
    def name(self) -> str: ...
    @property
    def levels(self) -> list[Level]: ...
    @property
    def n_levels(self) -> int: ...
    @property
    def center(self) -> tuple[float, float, float]:
        """Of the bounding sphere of level 0"""
    @property
    def radius(self) -> float: ...
    @property
    def image_height(self) -> float:
        """Of the view that was baked for, pixels"""
    @property
    def field_of_view(self) -> float:
        """Vertical, degrees"""
    @property
    def pixel_error(self) -> float: ...
    def level_for(
        self, distance: float, *, image_height: Optional[float] = None, field_of_view: Optional[float] = None,
        pixel_error: Optional[float] = None,
    ) -> int:
        """The coarsest level whose error is at most `pixel_error` pixels at that distance from the surface"""

class FileReport:
    """What the bytes of a .pmesh file are spent on."""
    @property
    def bytes(self) -> int: ...
    @property
    def base_bytes(self) -> int: ...
    @property
    def connectivity_bytes(self) -> int: ...
    @property
    def position_bytes(self) -> int: ...
    @property
    def attribute_bytes(self) -> int: ...
    @property
    def error_bytes(self) -> int: ...
    @property
    def numbering_bytes(self) -> int: ...
    @property
    def batches(self) -> int: ...
    @property
    def positions(self) -> str:
        """How they are held: floats, doubles, decimals or quantised."""
    @property
    def largest_move(self) -> float:
        """How far quantisation moves a vertex at most."""

class Atlas:
    @property
    def mesh(self) -> Mesh: ...
    @property
    def face_charts(self) -> npt.NDArray[np.uint32]: ...
    @property
    def n_charts(self) -> int: ...
    @property
    def stretch_l2(self) -> float: ...
    @property
    def stretch_l_infinity(self) -> float: ...
    @property
    def flipped(self) -> int: ...
    @property
    def cut_length(self) -> float: ...
    @property
    def map_size(self) -> int: ...
    @property
    def occupancy(self) -> float: ...

class ShellLayer:
    """One layer of a shell: from the surface to the ends of the directors. See `recede.build_shell`."""
    @property
    def tops(self) -> npt.NDArray[np.float64]:
        """(vertices, 3), where directors end"""
    @property
    def is_valid(self) -> bool: ...
    @property
    def is_valid_elsewhere(self) -> bool:
        """All that is wrong is wrong among excused and given up triangles"""
    @property
    def excused(self) -> list[int]:
        """Triangles over which no layer is valid: around places where the surface meets itself"""
    @property
    def given_up(self) -> list[int]:
        """Other triangles beside which repair couldn't end the faults; seldom any"""
    @property
    def inverted(self) -> list[int]:
        """Triangles whose prisms are inverted"""
    @property
    def top_contacts(self) -> list[tuple[int, int]]: ...
    @property
    def layer_contacts(self) -> list[tuple[int, int]]:
        """Triangles of the surface and of the tops that meet"""
    @property
    def base_contacts(self) -> list[tuple[int, int]]:
        """Where the surface meets itself, so that no layer is valid"""
    @property
    def inverted_before(self) -> int:
        """Before any repair"""
    @property
    def contacts_before(self) -> int: ...
    @property
    def shortened(self) -> int:
        """Directors that repair changed"""
    @property
    def is_of_normals(self) -> bool:
        """Plain normals took the place of directors that got shorter"""
    @property
    def hexahedra(self) -> int:
        """Quads over which textures see one hexahedron instead of two prisms"""
    @property
    def thickness(self) -> tuple[float, float, float]:
        """Least, mean and most, as shares of what was asked for"""

class Shell:
    """A layer of space over a surface. See `recede.build_shell`."""
    @property
    def is_valid(self) -> bool: ...
    @property
    def base(self) -> Mesh:
        """The surface as triangles"""
    @property
    def exterior(self) -> Optional[ShellLayer]: ...
    @property
    def interior(self) -> Optional[ShellLayer]: ...
    @property
    def traced(self) -> int:
        """Directors of a layer that follow the field"""
    @property
    def boundary(self) -> Mesh:
        """All sides as one closed mesh"""

class VolumeTexture:
    """A grid of opacity for the layer of a shell. See `recede.make_volume`."""
    @property
    def opacity(self) -> npt.NDArray[np.uint8]:
        """(r, t, s): 0 outside, 255 inside, the surface is where it is half of that"""
    @property
    def colors(self) -> Optional[npt.NDArray[np.uint8]]:
        """(r, t, s, 3), sRGB-encoded"""
    @property
    def extent(self) -> npt.NDArray[np.float64]:
        """Lengths along s, t and r"""
    @property
    def is_periodic(self) -> bool: ...
    @property
    def ramp(self) -> float:
        """Opacity goes from 0 to 1 over twice this length; 0: unknown"""

class TexturedShell:
    """A volume texture in a layer of a shell. See `recede.fill_shell`."""
    @property
    def shell(self) -> Shell: ...
    @property
    def side(self) -> str: ...
    @property
    def volume(self) -> VolumeTexture:
        """A copy"""
    @property
    def repeat(self) -> npt.NDArray[np.float64]: ...
    @property
    def offset(self) -> npt.NDArray[np.float64]: ...
    def write(self, path: _Path) -> None:
        """To a .shell file, which `recede.read_textured_shell` reads."""

class AveragedDistance:
    """At each of some points. See `recede.averaged_distance`."""
    @property
    def distances(self) -> npt.NDArray[np.float64]:
        """(points,)"""
    @property
    def gradients(self) -> npt.NDArray[np.float64]:
        """(points, 3)"""

class Subdivision:
    @property
    def mesh(self) -> Mesh: ...
    @property
    def level(self) -> int: ...
    @property
    def error_estimate(self) -> float:
        """The largest distance found from the limit surface to the facets; no bound."""
    @property
    def crease_edges(self) -> int: ...
    @property
    def triangulated(self) -> int: ...

class LevelChoice:
    def __init__(self, faces: Optional[int], error: Optional[float], splits: Optional[int]) -> None: ...

class Geomorph:
    def at(self, share: float) -> Mesh: ...
    def write(self, path: _Path) -> list[str]: ...
    @property
    def parents(self) -> npt.NDArray[np.uint32]: ...
    @property
    def coarse_splits(self) -> int: ...
    @property
    def fine_splits(self) -> int: ...

class RefinementReport:
    @property
    def faces(self) -> int: ...
    @property
    def splits(self) -> int: ...
    @property
    def forced(self) -> int: ...
    @property
    def merges(self) -> int: ...
    @property
    def pixel_error(self) -> float: ...
    @property
    def seconds(self) -> float: ...

class RefinementView:
    position: Any
    target: Any
    up: Any
    image_height: float
    field_of_view: float
    pixel_error: float
    aspect_ratio: float
    cull: bool
    back_pixel_error: Optional[float]
    silhouette_pixel_error: Optional[float]
    faces: Optional[int]
    def __init__(self) -> None: ...

class SelectiveMesh:
    def update(self, view: RefinementView) -> RefinementReport: ...
    def update_error(self, error: float) -> RefinementReport: ...
    def mesh(self) -> Mesh: ...
    @property
    def n_faces(self) -> int: ...

class ProgressiveMesh:
    def level(self, choice: LevelChoice) -> Mesh: ...
    def geomorph(self, coarse: LevelChoice, fine: LevelChoice) -> Geomorph: ...
    def selective(self) -> SelectiveMesh: ...
    def write(
        self,
        path: _Path,
        bits: Optional[int],
        attribute_bits: Optional[int],
        keep_numbering: bool,
        keep_order: Optional[bool],
    ) -> FileReport: ...
    @property
    def n_splits(self) -> int: ...
    @property
    def level_faces(self) -> npt.NDArray[np.uint32]: ...
    @property
    def level_errors(self) -> npt.NDArray[np.float64]: ...
    @property
    def errors_are_proved(self) -> bool: ...
    @property
    def seconds(self) -> float: ...
    @property
    def proof_seconds(self) -> float: ...

class TrimmingCurve:
    @property
    def degree(self) -> int: ...
    @property
    def knots(self) -> npt.NDArray[np.float64]: ...
    @property
    def points(self) -> npt.NDArray[np.float64]:
        """n x 2, in the parameters of the patch."""
    @property
    def weights(self) -> Optional[npt.NDArray[np.float64]]: ...
    @property
    def edge(self) -> Optional[int]:
        """Its number in the part; None: a side that is one point, or a curve that is on its own."""
    @property
    def runs_against(self) -> bool: ...
    @property
    def corners(self) -> tuple[Optional[int], Optional[int]]: ...

class TrimmedPatch:
    @property
    def name(self) -> str: ...
    @property
    def degrees(self) -> tuple[int, int]: ...
    @property
    def knots(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...
    @property
    def points(self) -> npt.NDArray[np.float64]:
        """n_u x n_v x 3."""
    @property
    def weights(self) -> Optional[npt.NDArray[np.float64]]:
        """n_u x n_v; None: all are 1."""
    @property
    def loops(self) -> list[list[TrimmingCurve]]: ...
    def closest_point(
        self, point: npt.ArrayLike
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], float]:
        """Of the whole surface, beyond the loops too: its (u, v), the point and its distance."""
    @property
    def is_reversed(self) -> bool:
        """The front is where du x dv points away."""
    @property
    def material(self) -> Optional[int]: ...

class CadPart:
    @property
    def name(self) -> str: ...
    @property
    def patches(self) -> list[TrimmedPatch]: ...
    @property
    def n_edges(self) -> int: ...
    @property
    def n_corners(self) -> int: ...
    @property
    def is_closed(self) -> bool: ...

class CadInstance:
    @property
    def part(self) -> int: ...
    @property
    def name(self) -> str: ...
    @property
    def placement(self) -> npt.NDArray[np.float64]:
        """4 x 4, from the part's coordinates to the model's."""
    @property
    def material(self) -> Optional[int]: ...

class CadLevel:
    @property
    def patches(self) -> int:
        """That haven't vanished"""
    @property
    def triangles(self) -> int: ...
    @property
    def tightened(self) -> int:
        """Patches with finer seams than the error asks for"""
    @property
    def missed(self) -> list[str]:
        """A line for each patch that isn't within the level's error"""

class CadGap:
    """Where patches that should meet are farther apart than what is sewn up."""
    @property
    def patch(self) -> int:
        """Its number in the part"""
    @property
    def other(self) -> int: ...
    @property
    def point(self) -> tuple[float, float, float]: ...
    @property
    def distance(self) -> float: ...

class CadSeams:
    """What was found where a part was sewn."""
    @property
    def part(self) -> str: ...
    @property
    def patches(self) -> int: ...
    @property
    def sewing_points(self) -> int: ...
    @property
    def edges_of_file(self) -> int: ...
    @property
    def edges_by_position(self) -> int: ...
    @property
    def free_edges(self) -> int: ...
    @property
    def crowded_edges(self) -> int: ...
    @property
    def turned(self) -> int:
        """Patches whose front was turned to agree with their neighbours'"""
    @property
    def largest_move(self) -> float: ...
    @property
    def gaps(self) -> list[CadGap]: ...

class CadModel:
    @property
    def parts(self) -> list[CadPart]: ...
    @property
    def instances(self) -> list[CadInstance]: ...
    @property
    def materials(self) -> list[Material]: ...
    @property
    def metres_per_unit(self) -> float: ...
    @property
    def left_out(self) -> list[tuple[str, str]]:
        """What isn't in the model, and why."""
    @property
    def repairs(self) -> list[str]: ...

def build_billboards(
    mesh: Mesh, settings: dict[str, Any], textures: bool, progress: _Progress
) -> list[BillboardCloud]: ...
def make_billboard_reflectance(
    mesh: Mesh, cloud: BillboardCloud, settings: Mapping[str, Any], progress: _Progress
) -> BillboardReflectance: ...
def read_billboard_reflectance(path: _Path) -> BillboardReflectance: ...
def write_billboards(
    folder: _Path, mesh: Mesh, clouds: Sequence[BillboardCloud], name: str, view: dict[str, Any], progress: _Progress
) -> Path: ...
def named_volume(name: str, texels: int, settings: Mapping[str, Any], progress: _Progress) -> VolumeTexture: ...
def volume_from_arrays(opacity: npt.ArrayLike, colors: Optional[npt.ArrayLike], extent: Sequence[float], periodic: bool,
                       ramp: float) -> VolumeTexture: ...
def fill_with_volume(shell: Shell, volume: VolumeTexture, side: str, repeat: Optional[Sequence[float]],
                     offset: Sequence[float]) -> TexturedShell: ...
def fill_with_matter(shell: Shell, opacity: float, side: str, size: Sequence[int]) -> TexturedShell: ...
def carve(textured: TexturedShell, tool: Any, operation: str, settings: Mapping[str, Any],
          progress: _Progress) -> tuple[TexturedShell, dict[str, Any]]: ...
def move_matter(textured: TexturedShell, source: Sequence[float], target: Sequence[float],
                settings: Mapping[str, Any]) -> tuple[TexturedShell, dict[str, Any]]: ...
def read_textured_shell(path: _Path) -> TexturedShell: ...
def build_shell(mesh: Mesh, settings: Mapping[str, Any], progress: _Progress) -> Shell: ...
def build_subdivided_shell(control: Mesh, settings: Mapping[str, Any], progress: _Progress) -> Shell: ...
def averaged_distance(
    mesh: Mesh, points: npt.ArrayLike, settings: Mapping[str, Any], progress: _Progress
) -> AveragedDistance: ...
def can_read_cad() -> bool: ...
def read_cad(path: _Path, repair: bool, progress: _Progress) -> CadModel: ...
def tessellate_cad(
    model: CadModel, errors: Sequence[float], gap: float, use_connectivity: bool, progress: _Progress
) -> list[dict[str, Any]]:
    """`mesh`, `error_bound`, `max`, `rms`, `switch_distance`, `patches` and `missed` of each level"""
def build_progressive(
    mesh: Mesh, settings: Mapping[str, Any], feature_angle: float, progress: _Progress
) -> ProgressiveMesh: ...
def diff(
    first: Union[_Path, npt.ArrayLike], second: Union[_Path, npt.ArrayLike], mask: Union[_Path, npt.ArrayLike, None],
    pixels_per_degree: float,
) -> ImageDifference: ...
def read_image(path: _Path) -> npt.NDArray[np.float32]: ...
def write_image(path: _Path, pixels: npt.ArrayLike) -> None: ...
def read_progressive(path: _Path) -> ProgressiveMesh: ...
def read(path: _Path, repair: bool, progress: _Progress) -> Mesh: ...
def write(path: _Path, mesh: Mesh) -> list[str]: ...
def simplify(
    mesh: Mesh, targets: list[dict[str, Any]], options: dict[str, Any], feature_angle: float, progress: _Progress
) -> list[SimplifyResult]: ...
def compare(
    a: Mesh, b: Mesh, samples: int, bound_tolerance: Optional[float], progress: _Progress
) -> Distance: ...
def bake(
    mesh: Mesh, folder: _Path, name: str, levels: dict[str, Any], options: dict[str, Any], feature_angle: float,
    progress: _Progress,
) -> BakeResult: ...
def bake_file(
    file: _Path, folder: _Path, name: str, levels: dict[str, Any], options: dict[str, Any], feature_angle: float,
    memory: int, progress: _Progress,
) -> BakeResult: ...
def bake_cad(
    model: CadModel, folder: _Path, name: str, levels: dict[str, Any], progress: _Progress
) -> BakeResult: ...
def read_hierarchy(path: _Path) -> Hierarchy: ...
def bake_maps(fine: Mesh, coarse: Mesh, settings: dict[str, Any], progress: _Progress) -> BakedMaps: ...
def dice(
    surface: Union[BakedMaps, Mesh], height: Optional[npt.ArrayLike], eye: Optional[Sequence[float]],
    look_at: Optional[Sequence[float]], settings: dict[str, Any], progress: _Progress,
) -> DicedView: ...
def render(
    surface: Union[Mesh, BakedMaps, BillboardCloud, TexturedShell], eye: Any, look_at: Any, up: Any, field_of_view: float, width: int, height: int,
    options: Mapping[str, Any], progress: _Progress,
) -> npt.NDArray[np.float32]: ...
def make_atlas(mesh: Mesh, options: Mapping[str, Any], progress: _Progress) -> Atlas: ...
def subdivide(mesh: Mesh, options: Mapping[str, Any], progress: _Progress) -> Subdivision: ...
def make_teapot(quads_per_side: int, relief: float) -> Mesh: ...
def make_displaced_sphere(faces: int, triangles: bool) -> Mesh: ...
def make_tree(leaves: int, seed: int) -> Mesh: ...
def set_threads(count: int) -> None: ...
