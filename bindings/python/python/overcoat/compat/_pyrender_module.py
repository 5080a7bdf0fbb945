"""pyrender itself, also where no OpenGL library is: scenes, meshes, materials and cameras are plain Python."""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
import types
from typing import Any, MutableSequence, Optional, Sequence

#: What pyrender imports for windows and drivers, and its classes of scenes do not use.
_OF_DRIVERS = ("OpenGL", "pyglet", "freetype")

#: Numbers of OpenGL that pyrender's classes have as defaults.
_GL = {"GL_UNSIGNED_BYTE": 0x1401, "GL_FLOAT": 0x1406, "GL_UNSIGNED_INT": 0x1405, "GL_TEXTURE_2D": 0x0DE1}


def pyrender_module() -> Any:
    """The module `pyrender`. Where the libraries that it draws by cannot be loaded, it is loaded without them: what would draw by
    OpenGL does not work then.

    Raises:
        ImportError: pyrender is not installed.
    """
    known = sys.modules.get("pyrender")
    if known is None or not hasattr(known, "Scene"):
        try:
            known = importlib.import_module("pyrender")
        except Exception:  # noqa: BLE001: whatever loaders of drivers raise where there are none.
            if importlib.util.find_spec("pyrender") is None:
                raise
            known = _without_drivers()
    _mend(known)
    return known


def _mend(module: Any) -> None:
    """pyrender 0.1.45 is older than numpy 2, and has a name from before in the boxes of its meshes."""
    import numpy

    if not hasattr(numpy, "infty") and getattr(module.mesh, "np", None) is numpy:
        module.mesh.np = _Numpy("numpy")


class _Numpy(types.ModuleType):
    """numpy with its older name of infinity."""

    infty = float("inf")

    def __getattr__(self, name: str) -> Any:
        import numpy

        return getattr(numpy, name)


def _without_drivers() -> Any:
    _forget("pyrender", *_OF_DRIVERS)
    finder = _Finder()
    sys.meta_path.insert(0, finder)
    try:
        return importlib.import_module("pyrender")
    finally:
        sys.meta_path.remove(finder)
        # Whoever imports them gets the real ones, or their error.
        _forget(*_OF_DRIVERS)


def _forget(*roots: str) -> None:
    for name in list(sys.modules):
        if name.partition(".")[0] in roots:
            del sys.modules[name]


class _StandIn(types.ModuleType):
    """A module with every name: classes that can be derived from, called and asked for more."""

    __path__: MutableSequence[str] = []

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _Anything


class _Any(type):
    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _Anything

    def __setitem__(cls, key: Any, value: Any) -> None:
        """Options of windows, which nobody reads."""


class _Anything(metaclass=_Any):
    """What stands for everything of a driver."""

    def __init__(self, *_: Any, **__: Any) -> None:
        raise ImportError("pyrender's own windows and renderers need OpenGL, which is not there; overcoat's OffscreenRenderer does not")


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(
        self, fullname: str, path: Optional[Sequence[str]], target: Optional[types.ModuleType] = None
    ) -> Optional[importlib.machinery.ModuleSpec]:
        if fullname.partition(".")[0] not in _OF_DRIVERS:
            return None
        return importlib.machinery.ModuleSpec(fullname, self, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> types.ModuleType:
        return _StandIn(spec.name)

    def exec_module(self, module: types.ModuleType) -> None:
        # `from OpenGL.GL import *` takes these.
        if module.__name__ == "OpenGL.GL":
            module.__dict__.update(_GL)
            # A table of functions by the type of what they set.
            kinds = [*(f"{n}{t}v" for n in (1, 2, 3, 4) for t in ("i", "ui", "f", "d"))]
            kinds += [f"Matrix{n}{t}v" for n in ("2", "3", "4", "2x3", "2x4", "3x2", "3x4", "4x2", "4x3") for t in ("f", "d")]
            module.__dict__.update({f"glUniform{kind}": _Anything for kind in kinds})
