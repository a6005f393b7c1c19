"""Progressive meshes: all levels of a mesh. See docs/progressive.md."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import TYPE_CHECKING, Any

from . import _recede
from ._options import simplify_options, three_numbers
from ._texts import need_mesh

if TYPE_CHECKING:
    import numpy as np

    from . import FileReport, Geomorph, Mesh, Path, Progress, RefinementReport


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
        `image_width` (pixels). Faces that look away and silhouettes may have errors of their own; `cull` leaves what is outside
        the image coarse; with at most so many `faces` the largest errors go first. Raises `OptionError` for what is out of range.
        """
        view = _recede.RefinementView()
        view.position, view.target = three_numbers("position", position), three_numbers("target", target)
        view.up = three_numbers("up", up)
        view.image_height, view.field_of_view, view.pixel_error = image_height, field_of_view * pi / 180, pixel_error
        view.cull = cull
        if image_width is not None and image_height > 0:
            view.aspect_ratio = image_width / image_height
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
    settings, feature_angle = simplify_options(options)
    target = {"faces": faces, "vertices": vertices, "ratio": ratio}
    compiled = _recede.build_progressive(need_mesh("build_progressive", mesh), {**settings, **target}, feature_angle, progress)
    return ProgressiveMesh(compiled)
