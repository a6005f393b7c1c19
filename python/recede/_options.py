"""Options that several functions have in common, as the compiled module takes them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import pi
from typing import Any, TypeVar

from ._recede import OptionError

Value = TypeVar("Value")


def list_of(values: Iterable[Value] | None) -> list[Value]:
    """All of them, of arrays too; of None there are none."""
    return [] if values is None else list(values)


def three_numbers(name: str, values: Any) -> list[float]:
    """Raises `OptionError` with the name for anything else."""
    try:
        numbers = [float(value) for value in values]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) != 3:
        raise OptionError(f"{name} must be three numbers, not {values!r}")
    return numbers


def place_or_none(name: str, values: Any) -> list[float] | None:
    return None if values is None else three_numbers(name, values)


def simplify_options(options: Mapping[str, Any]) -> tuple[dict[str, Any], float]:
    known = {"cost", "placement", "prove_error", "lock_borders", "keep_uv_seams", "keep_normal_seams",
             "keep_polygons", "uv_weight", "normal_weight", "color_weight", "scalar_weights",
             "join_distance", "drop_parts", "normal_threshold", "candidate_share", "seed", "feature_angle"}
    for name in options:
        if name not in known:
            raise TypeError(f"unexpected option {name!r}; known are {', '.join(sorted(known))}")
    rest = dict(options)
    weights = rest.get("scalar_weights")
    if weights is not None and not isinstance(weights, Mapping):
        raise TypeError("scalar_weights is a dict of weights by name")
    angle = float(rest.pop("feature_angle", 0.0))
    if not 0 <= angle <= 180:
        raise OptionError("feature_angle must lie between 0 and 180 degrees")
    return rest, angle * pi / 180


def map_options(maps: Sequence[str], size: int, format: str, normal_bits: int,
                seam_weight: float | None) -> dict[str, Any]:
    names = [maps] if isinstance(maps, str) else list(maps)
    return {"maps": names, "map_size": size, "map_format": format, "map_normal_bits": normal_bits,
            "map_seam_weight": seam_weight}
