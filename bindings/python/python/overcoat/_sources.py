"""What a model may be given as."""

from __future__ import annotations

import os
from typing import Any, Dict, Mapping, Optional, Tuple

from . import _overcoat
from ._arrays import Mesh, Splats, materials_of, model_of
from ._errors import MeshError, OptionError
from ._options import LOADING, _limits, _json, check_names, plain


def load(
    renderer: _overcoat.Renderer, source: Any, loading: Mapping[str, Any], limits: Any
) -> Tuple[_overcoat.Model, Dict[str, Any]]:
    """A model of whatever is given, and options that come with it."""
    description = _json({name: plain(name, value) for name, value in loading.items() if name in LOADING and value is not None})
    bounds = _limits(limits)
    if isinstance(source, _overcoat.Model):
        given = [name for name, value in loading.items() if value is not None]
        if given:
            raise OptionError(f"{given[0]}: the model is loaded already; give it to overcoat.load()")
        return source, {}
    path, content, form = file_of(source, loading.get("format"))
    if path is not None:
        return renderer.load_path(path, description, bounds), {}
    if content is not None:
        return renderer.load_bytes(content, form, description, bounds), {}
    refused = [name for name, value in loading.items() if value is not None and name != "up"]
    if refused:
        raise OptionError(f"{refused[0]}: only model files have it, not a {type(source).__name__}")
    up = loading.get("up")
    if isinstance(source, (Mesh, Splats)):
        source = [source]
    if isinstance(source, (list, tuple)) and source and all(isinstance(mesh, (Mesh, Splats)) for mesh in source):
        return model_of(source, up), {"materials": materials_of(source)}
    if hasattr(source, "mesh_nodes") and hasattr(source, "get_pose"):
        from .compat._pyrender_scene import camera_of, convert

        return convert(source).model, camera_of(source)
    is_mesh = hasattr(source, "vertices") and not hasattr(source, "triangle_uvs")
    if (hasattr(source, "geometry") and hasattr(source, "graph")) or is_mesh:
        from ._trimesh import model_of_trimesh

        return model_of_trimesh(source, up)
    from ._foreign import meshes_of

    foreign = meshes_of(source)
    if foreign is not None:
        return model_of(foreign[0], up, foreign[1]), {}
    raise MeshError(
        f"a model is a path, bytes, a file object, Meshes and Splats, a scene or mesh of trimesh, PyVista or Open3D, or a scene of pyrender; "
        f"not a {type(source).__name__}"
    )


def file_of(source: Any, form: Any) -> Tuple[Optional[str], Optional[bytes], Any]:
    """The path of a model file, or its content and what its format may be; neither if it is something else."""
    if isinstance(source, (str, os.PathLike)):
        return os.fsdecode(os.fspath(source)), None, form
    if isinstance(source, (bytes, bytearray, memoryview)):
        return None, bytes(source), form
    if hasattr(source, "read"):
        content = source.read()
        content = content.encode() if isinstance(content, str) else content
        name = getattr(source, "name", None)
        if form is None and isinstance(name, str) and "." in os.path.basename(name):
            form = _known(os.path.splitext(name)[1].lstrip("."))
        return None, bytes(content), form
    return None, None, form


def _known(extension: str) -> str | None:
    return extension if extension.lower() in _overcoat.model_extensions() else None


def check_loading(options: Mapping[str, Any]) -> None:
    """Refuses what is no option of loading."""
    check_names(options, (*LOADING, "format", "limits"), "load()")
