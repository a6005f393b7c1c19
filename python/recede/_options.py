"""Options that several functions have in common, as the compiled module takes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi
from typing import Any

from ._recede import OptionError


def simplify_options(options: Mapping[str, Any]) -> tuple[dict[str, Any], float]:
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


def map_options(maps: Sequence[str], size: int, format: str, normal_bits: int,
                 seam_weight: float | None) -> dict[str, Any]:
    names = [maps] if isinstance(maps, str) else list(maps)
    return {"maps": names, "map_size": size, "map_format": format, "map_normal_bits": normal_bits,
            "map_seam_weight": seam_weight}
