"""Options of a picture. Their names, ranges and defaults are those of scene files, which the library alone knows."""

from __future__ import annotations

import difflib
import json
import os
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Dict, Iterable, Mapping, Optional, Tuple

from . import _overcoat
from ._camera import CameraMatrices
from ._errors import OptionError, UnknownOptionError

if TYPE_CHECKING:
    from ._option_types import Path

    #: The material's name or `None` for all, a dict as JSON, pictures of arrays.
    GivenMaterial = Tuple[Optional[str], str, list[Tuple[str, _overcoat.Texels]]]


#: What says how a model is loaded.
LOADING = ("up", "animation", "time", "loop")
#: Keys of scene files that are no options: the model is an argument of its own, and others are notes for readers.
NO_OPTIONS = ("model", "name", "note", "peers", "ground_truth")
#: Options that scene files do not have.
OWN = ("aov", "limits", "format")


@lru_cache(maxsize=None)
def descriptions() -> Dict[str, str]:
    """What each option is for, in one line, by its name."""
    properties = json.loads(_overcoat.scene_schema())["properties"]
    found = {name: str(of.get("description", "")) for name, of in properties.items() if name not in NO_OPTIONS}
    planes = ", ".join(name for name, _ in _overcoat.aov_names())
    found["aov"] = f"Planes of the G-buffer to draw as well: {planes}"
    found["limits"] = "Bounds on the work and on what a file may ask for, by the names of `overcoat render --limit`"
    extensions = ", ".join(_overcoat.model_extensions())
    found["format"] = f"Format of a model in memory, where its content does not tell: {extensions}"
    return found


class Options(Dict[str, Any]):
    """Options of a picture, checked when they are put together: `overcoat.render(model, **options)`.

    A dict, so that they can be changed, merged (`Options(**options, samples=16)`), stored and pickled.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(options)
        loading, drawing = split({name: value for name, value in options.items() if name != "model"})
        check_names(loading, descriptions(), "Options()")
        _overcoat.check_request(request(drawing, "Options()"))

    @classmethod
    def open(cls, path: Path) -> Options:
        """Reads a scene file, TOML or JSON. Paths in it are relative to its folder; its `model` stays among the options, so
        that `overcoat.render(**Options.open("car.toml"))` draws it.

        Raises:
            LoadError, OptionError: The file is no scene file.
            OSError: It cannot be read.
        """
        text = _overcoat.read_description(os.fspath(path))
        options = cls.__new__(cls)
        options.update(json.loads(text))
        return options

    def __repr__(self) -> str:
        return f"Options({', '.join(f'{name}={value!r}' for name, value in self.items())})"


def check_names(names: Iterable[str], known: Iterable[str], what: str) -> None:
    """Refuses names that do not exist, and says which one may have been meant."""
    known = list(known)
    for name in names:
        if name in known:
            continue
        nearest = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
        hint = f"; did you mean '{nearest[0]}'?" if nearest else f"; known are {', '.join(known)}"
        raise UnknownOptionError(f"{what} has no option '{name}'{hint}")


def split(options: Mapping[str, Any]) -> Tuple[Dict[str, Any], Dict[str, Any]]:
    """Options of loading, and those of drawing."""
    loading = {name: value for name, value in options.items() if name in LOADING or name == "format"}
    drawing = {name: value for name, value in options.items() if name not in loading}
    return loading, drawing


def request(options: Mapping[str, Any], what: str = "render()") -> Dict[str, Any]:
    """Options as the native half takes them: a scene file as JSON, and what such a file cannot hold."""
    check_names(options, descriptions(), what)
    description: Dict[str, Any] = {}
    environment = None
    materials: list[GivenMaterial] = []
    aov: list[str] = []
    orbit: Optional[_overcoat.Orbit] = None
    for name, value in options.items():
        if value is None or name in OWN:
            continue
        if name == "env":
            environment = _environment(value)
            if environment is not None:
                continue
        elif name == "camera":
            if isinstance(value, _overcoat.Orbit):
                orbit = value
                continue
            value = _camera(value)
        elif name == "material" and isinstance(value, Mapping):
            materials.append((None, *_material(value)))
            continue
        elif name == "materials" and isinstance(value, Mapping):
            inline = {key: of for key, of in value.items() if isinstance(of, Mapping)}
            materials.extend((key, *_material(of)) for key, of in inline.items())
            value = {key: of for key, of in value.items() if key not in inline}
        description[name] = plain(name, value)
    planes = options.get("aov")
    if planes is not None:
        aov = [planes] if isinstance(planes, str) else [str(plane) for plane in planes]
    return {
        "description": _json(description),
        "limits": _limits(options.get("limits")),
        "environment": environment,
        "materials": materials,
        "aov": aov,
        "orbit": orbit,
    }


def plain(name: str, value: Any) -> Any:
    """A value as JSON has it: of paths, tuples and numpy's arrays and numbers too."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, os.PathLike):
        return os.fsdecode(os.fspath(value))
    if isinstance(value, bytes):
        return os.fsdecode(value)
    if isinstance(value, Mapping):
        return {str(key): plain(f"{name}.{key}", of) for key, of in value.items()}
    if hasattr(value, "tolist"):
        return plain(name, value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(name, of) for of in value]
    raise OptionError(f"{name}: a value of type '{type(value).__name__}' is not understood")


def _json(value: Any) -> str:
    try:
        return json.dumps(value, allow_nan=False)
    except ValueError:
        bad = next((name for name in value if not _is_finite(value[name])), "an option")
        raise OptionError(f"{bad}: expected a finite number") from None


def _is_finite(value: Any) -> bool:
    try:
        json.dumps(value, allow_nan=False)
    except ValueError:
        return False
    return True


def camera(value: Any) -> Tuple[Optional[_overcoat.Orbit], str]:
    """A camera as the native half takes it: an orbit, or a description as JSON that has nothing else."""
    if isinstance(value, _overcoat.Orbit):
        return value, "{}"
    if value is None:
        return None, "{}"
    return None, _json({"camera": plain("camera", _camera(value))})


def _camera(value: Any) -> Any:
    """A view is a name, or three numbers; a picture's camera is one again."""
    if isinstance(value, CameraMatrices):
        return value.options()
    if isinstance(value, str):
        return {"view": value}
    if isinstance(value, Mapping) and not isinstance(value.get("view", ""), (str, type(None))):
        return {**value, "view": ",".join(str(part) for part in plain("camera.view", value["view"]))}
    return value


def _material(value: Mapping[str, Any]) -> Tuple[str, list[Tuple[str, _overcoat.Texels]]]:
    """A dict of a material file's keys as JSON, and the pictures of its arrays by the names that stand for them there."""
    pictures: list[Tuple[str, _overcoat.Texels]] = []

    def named(key: str, of: Any) -> Any:
        if not key.endswith("_texture"):
            return of
        if isinstance(of, Mapping):
            return {**of, "file": named(key, of["file"])} if "file" in of else of
        if not _is_picture(of):
            return of
        from ._kept import texels_of

        # No file has such a name.
        name = f"array/{len(pictures)}"
        pictures.append((name, texels_of(f"material.{key}", of)))
        return name

    keys = {str(key): of for key, of in value.items() if of is not None}
    return _json({key: plain(f"material.{key}", named(key, of)) for key, of in keys.items()}), pictures


def _is_picture(value: Any) -> bool:
    """An array, or an image of Pillow; a list of rows of pixels as well."""
    return hasattr(value, "__array_interface__") or hasattr(value, "__array__") or isinstance(value, (list, tuple))


def _environment(value: Any) -> Optional[_overcoat.Environment]:
    if isinstance(value, _overcoat.Environment):
        return value
    if hasattr(value, "__array_interface__") or hasattr(value, "__array__"):
        from ._arrays import environment

        return environment(value)
    return None


def _limits(value: Any) -> Dict[str, int]:
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise OptionError("limits: expected a dict of names and whole numbers")
    for name, number in value.items():
        if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < 2**64:
            raise OptionError(f"limits: {name}: expected a whole number, 0 to 2^64 - 1, found {number!r}")
    return dict(value)


def _documented() -> str:
    lines = [f"    {name}: {about}." for name, about in descriptions().items()]
    return "\n".join(lines)


Options.__doc__ = f"{Options.__doc__}\n    The options:\n\n{_documented()}\n"
