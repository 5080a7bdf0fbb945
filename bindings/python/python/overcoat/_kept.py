"""What was made of arrays and of other libraries' objects, kept for as long as these live and stay as they are."""

from __future__ import annotations

import weakref
import zlib
from typing import Any, Callable, Dict, Hashable, Tuple, TypeVar

from . import _overcoat

T = TypeVar("T")

#: Numbers of an array that a quick look takes; smaller arrays are read whole.
LOOKED_AT = 1 << 14


class Kept:
    """Results by the object that they were made of. They go with that object, and are made anew when what it consists of has changed.

    Whether it has is told by identity, by trimesh's own revisions, and for others' arrays by checksums: of all numbers (`whole`), or
    of some of them, spread over the array. A quick look misses changes in place of a few numbers of a large array.
    """

    def __init__(self) -> None:
        self._made: Dict[Tuple[int, Hashable], Tuple[Any, Tuple[Any, ...], Tuple[Hashable, ...], Any]] = {}

    def get(
        self, owner: Any, use: Hashable, sources: Tuple[Any, ...], make: Callable[[], T], whole: bool = False
    ) -> T:
        """What `make` makes of `owner`, whose parts are `sources`, for some use."""
        if isinstance(owner, (list, tuple)):
            # Nobody tells when they go.
            return make()
        key = (id(owner), use)
        marks = tuple(mark(source, whole) for source in sources)
        found = self._made.get(key)
        if found is not None:
            reference, parts, known, made = found
            same = all(own is None or own is other for own, other in zip(parts, sources))
            if reference() is owner and same and known == marks and len(parts) == len(sources):
                kept: T = made
                return kept
        made = make()
        try:
            reference = weakref.ref(owner, lambda gone: self._forget(key, gone))
        except TypeError:
            return made
        # Identities hold as long as the objects live; the owner itself must not be kept alive, nor what is compared by value.
        parts = tuple(source if watched(source) and source is not owner else None for source in sources)
        self._made[key] = (reference, parts, marks, made)
        return made

    def _forget(self, key: Tuple[int, Hashable], gone: Any) -> None:
        found = self._made.get(key)
        if found is not None and found[0] is gone:
            del self._made[key]

    def __len__(self) -> int:
        return len(self._made)


def watched(source: Any) -> bool:
    """Whether it is told by identity too: arrays are, but trimesh's, which know of changes and are made anew when they are asked for."""
    return hasattr(source, "__array_interface__") and type(source).__hash__ is None


def mark(source: Any, whole: bool = False) -> Hashable:
    """A value that is another one when the source has changed in place."""
    if source is None or isinstance(source, (bool, int, float, str, bytes, tuple)):
        return source
    if hasattr(source, "__array_interface__") and hasattr(source, "flat"):
        # trimesh's arrays know whether somebody has written to them.
        if type(source).__hash__ is not None:
            return hash(source)
        return (source.shape, source.dtype.str, _checksum(source, whole))
    if hasattr(source, "getpixel") and hasattr(source, "size"):
        return (source.size, source.mode, zlib.crc32(source.tobytes()) if whole else _pixels(source))
    return repr(source)


def _checksum(array: Any, whole: bool) -> int:
    import numpy as np

    if not whole and array.size > LOOKED_AT:
        # Odd, so that all of several components are met.
        step = (array.size // LOOKED_AT) | 1
        array = array.reshape(-1)[::step] if array.flags.c_contiguous else array.flat[::step]
    return zlib.crc32(np.ascontiguousarray(array).view(np.uint8).reshape(-1).data if array.size else b"")


def _pixels(image: Any) -> Tuple[Any, ...]:
    """Some pixels of an image of Pillow."""
    width, height = image.size
    if width == 0 or height == 0:
        return ()
    places = [(k * 37 % 64, k * 11 % 64) for k in range(64)]
    return tuple(image.getpixel((x * width // 64, y * height // 64)) for x, y in places)


_texels = Kept()


def texels_of(what: str, value: Any, whole: bool = True) -> _overcoat.Texels:
    """The picture of an array or of an image of Pillow, made once."""
    from ._arrays import texels

    return _texels.get(value, None, (value,), lambda: _overcoat.Texels(texels(what, value)), whole)
