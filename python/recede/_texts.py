"""What the compiled module's values look like, and what is said to values of another type."""

from __future__ import annotations

from types import ModuleType

from ._recede import Mesh, SimplifyResult

# Types of properties, as pybind11 writes them, that cost nothing to look at and are short.
_PLAIN = ("int", "float", "str", "bool", "os.PathLike", "recede._recede.Mesh")


def need_mesh(function: str, value: object) -> Mesh:
    """The value, which is a mesh. Raises `TypeError` for anything else."""
    if isinstance(value, Mesh):
        return value
    if isinstance(value, SimplifyResult):
        hint = "; its `mesh` is one"
    else:
        hint = "; recede.read reads files" if isinstance(value, str) or hasattr(value, "__fspath__") else ""
    raise TypeError(f"{function} takes a Mesh, not {type(value).__name__}{hint}")


def _is_plain(member: object) -> bool:
    if not isinstance(member, property) or member.fget is None:
        return False
    returned = (member.fget.__doc__ or "").rpartition(" -> ")[2].strip()
    return returned.removeprefix("Optional[").removesuffix("]") in _PLAIN


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return repr(str(value)) if hasattr(value, "__fspath__") else repr(value)


def give_texts(module: ModuleType) -> None:
    """Gives classes that have none a `repr` of their plain properties."""
    for name, kind in vars(module).items():
        if not isinstance(kind, type) or kind.__repr__ is not object.__repr__:
            continue
        members = [member for member, value in vars(kind).items() if _is_plain(value)]

        def text(self: object, name: str = name, members: list[str] = members) -> str:
            return f"<recede.{name} {', '.join(f'{m}={_text(getattr(self, m))}' for m in members)}>"

        kind.__repr__ = text  # type: ignore[method-assign]
