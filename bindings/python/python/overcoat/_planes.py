"""Planes of the G-buffer by their names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict

if TYPE_CHECKING:
    import numpy.typing as npt

    class _Planes(Dict[str, "npt.NDArray[Any]"]):
        pass

else:
    _Planes = dict


class Planes(_Planes):
    """`{name: array}`, (H, W) or (H, W, C), of the planes that were asked for; float32, of identities uint32."""

    def __missing__(self, name: str) -> Any:
        there = ", ".join(self) or "none"
        raise KeyError(f"the plane '{name}' was not drawn: render(..., aov=['{name}']); there are: {there}")
