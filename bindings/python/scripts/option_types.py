"""Types of options from the schema of scene files and the names of planes, so that there is one list of names, values and sentences.

Usage: python scripts/option_types.py [--check]
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any, Dict

HERE = Path(__file__).resolve().parent
SCHEMA = HERE / "../../../crates/description/src/scene.schema.json"
#: Names of planes, which scene files do not have.
PLANES = HERE / "../../../crates/core/src/frame/mod.rs"
TYPES = HERE / "../python/overcoat/_option_types.py"

#: Keys of scene files that are no options.
NO_OPTIONS = ("model", "name", "note", "peers", "ground_truth")
#: Options of `overcoat.render` that a viewport has not: of loading, of light, of a tier.
NOT_OF_VIEWPORT = (
    "up plate animation time loop camera env env_rotation_deg env_intensity lights light material materials maps map_size rays "
    "shading_rate"
).split()
#: Options that take more than a scene file can say.
TYPES_HERE = {
    "camera": "Union[Camera, str, _overcoat.Orbit, CameraMatrices]",
    "env": "Union[Path, _overcoat.Environment, npt.NDArray[Any]]",
    "material": "Union[Path, Mapping[str, Any]]",
    "materials": "Mapping[str, Union[Path, Mapping[str, Any]]]",
    "light": "Sequence[Mapping[str, Any]]",
}

HEAD = '''\
"""Types of options. Made of crates/description/src/scene.schema.json by scripts/option_types.py."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal, Mapping, Sequence, TypedDict, Union

from . import _overcoat
from ._camera import CameraMatrices

if TYPE_CHECKING:
    import numpy.typing as npt

    Vector = Union[Sequence[float], npt.NDArray[Any]]
    Matrix = Union[Sequence[Sequence[float]], Sequence[float], npt.NDArray[Any]]
    Path = Union[str, "os.PathLike[str]"]
'''


def union(names: list[str]) -> str:
    distinct = list(dict.fromkeys(names))
    return distinct[0] if len(distinct) == 1 else f"Union[{', '.join(distinct)}]"


def type_of(schema: Dict[str, Any]) -> str:
    """A type as Python writes it."""
    if "enum" in schema:
        return f"Literal[{', '.join(json.dumps(value) for value in schema['enum'])}]"
    if "anyOf" in schema:
        choices = [type_of(choice) for choice in schema["anyOf"]]
        # Names beside any text are examples.
        if "str" in choices:
            choices = [choice for choice in choices if not choice.startswith('Literal["')]
        return union(choices)
    kind = schema["type"]
    if kind == "array":
        items = schema["items"]
        if items.get("type") == "number" and schema.get("minItems") == 3:
            return "Vector"
        return f"Sequence[{type_of(items)}]"
    return {"string": "str", "integer": "int", "number": "float", "boolean": "bool"}[kind]


def member(name: str, schema: Dict[str, Any], types: Dict[str, str]) -> str:
    return f'    {name}: {types.get(name) or type_of(schema)}\n    """{schema["description"]}."""\n'


def alias(name: str) -> str:
    """The name of a type of names: `Quality`, `AreaLights`."""
    return "".join(part.capitalize() for part in name.split("_"))


def table(name: str, bases: str, about: str, members: Dict[str, Any], types: Dict[str, str]) -> str:
    body = "".join(member(key, schema, types) for key, schema in members.items())
    return f'\n\nclass {name}({bases}, total=False):\n    """{about}"""\n\n{body}'


def planes_of(source: str) -> list[str]:
    """Names of planes of the G-buffer, of the function that says them."""
    body = re.search(r"pub fn name\(self\) -> &'static str \{\s*match self \{(.*?)\n        \}", source, re.S)
    assert body is not None, "Aov::name is not where it was"
    return re.findall(r'Self::\w+ => "([a-z-]+)"', body.group(1))


def module(schema: Dict[str, Any], planes_known: list[str]) -> str:
    options = {name: of for name, of in schema["properties"].items() if name not in NO_OPTIONS}
    named = {name: of for name, of in options.items() if isinstance(of.get("enum", [0])[0], str)}
    aliases = f"\nAov = Literal[{', '.join(json.dumps(name) for name in planes_known)}]"
    aliases += "".join(f"\n{alias(name)} = {type_of(of)}" for name, of in named.items()) + "\n"
    types = {**{name: alias(name) for name in named}, **TYPES_HERE}
    camera = {name: of for name, of in options["camera"]["properties"].items() if {"type", "anyOf", "enum"} & set(of)}
    limits = "    limits: Mapping[str, int]\n"
    limits += '    """Bounds on the work and on what a file may ask for, by the names of `overcoat render --limit`."""\n'
    planes = "    aov: Union[Aov, Sequence[Aov]]\n"
    planes += '    """Planes of the G-buffer to draw as well."""\n'
    planes += "    format: str\n"
    planes += '    """Format of a model in memory, where its content does not tell."""\n'
    return (
        HEAD
        + aliases
        + table(
            "Camera",
            "TypedDict",
            "The option `camera`: lengths in metres, angles in degrees. Without `eye` the model is framed automatically.",
            camera,
            {"view": "Union[str, Vector]", "K": "Matrix", "pose": "Matrix"},
        )
        + table(
            "ViewOptions",
            "TypedDict",
            "Options of how a picture is drawn, whatever it shows: those of `overcoat.Viewport`.",
            {name: of for name, of in options.items() if name not in NOT_OF_VIEWPORT},
            types,
        )
        + limits
        + table(
            "PictureOptions",
            "ViewOptions",
            "Every option of `overcoat.render`, with its type; `help(overcoat.Options)` says what each does.",
            {name: of for name, of in options.items() if name in NOT_OF_VIEWPORT},
            types,
        )
        + planes
    )


def main() -> int:
    text = module(json.loads(SCHEMA.read_text()), planes_of(PLANES.read_text()))
    if "--check" not in sys.argv:
        TYPES.write_text(text)
    elif TYPES.read_text() != text:
        print("_option_types.py is not what the schema says; scripts/option_types.py makes it anew", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
