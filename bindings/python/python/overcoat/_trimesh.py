"""Scenes and meshes of trimesh as models: by their attributes, so that trimesh need not be there.

Arrays are taken as they are. Through trimesh's exporter and a GLB in memory the same takes two to seven times as long for 80 000 triangles with
colours, and ten times for a texture of 1024 x 1024, which is encoded as PNG only to be decoded again (`measure.py`); and colours of
faces would be averaged to those of vertices.
"""

from __future__ import annotations

import json
from typing import Any, Dict, List, Optional, Tuple

from . import _overcoat
from ._arrays import (
    CLAY,
    WHITE_CLAY,
    array,
    floats,
    identity,
    indices,
    linear_colors,
    matrix,
    points,
    segments,
)
from ._errors import MeshError
from ._kept import Kept, texels_of

#: Where faces meet at more than this, there is an edge, for meshes without normals.
CREASE_DEGREES = 40.0


def model_of_trimesh(
    source: Any, up: Optional[str] = None, crease_degrees: float = CREASE_DEGREES
) -> Tuple[_overcoat.Model, Dict[str, Any]]:
    """A model, and the option `camera` if the scene has one that somebody has set."""
    converter = _Converter(crease_degrees)
    options: Dict[str, Any] = {}
    if hasattr(source, "geometry") and hasattr(source, "graph"):
        for number, node in enumerate(source.graph.nodes_geometry):
            placed, name = source.graph[node]
            converter.add(str(name), source.geometry[name], matrix("transform", placed), number)
            converter.builder.name_object(number, str(node))
        if getattr(source, "has_camera", False):
            options["camera"] = camera_of(source)
    else:
        converter.add("mesh", source, identity(), 0)
    return converter.builder.finish(up), options


def camera_of(scene: Any) -> Dict[str, Any]:
    """The option `camera` for the camera of a scene: it looks along its -z, with y up."""
    placed = matrix("camera", scene.camera_transform)
    eye = placed[:3, 3]
    forward, up = -placed[:3, 2], placed[:3, 1]
    camera = scene.camera
    return {
        "eye": eye.tolist(),
        "target": (eye + forward).tolist(),
        "up": up.tolist(),
        "fov_y_deg": float(camera.fov[1]),
        "near": float(getattr(camera, "z_near", 0.01)),
    }


#: A mesh and what it is made of, with `Texels` as textures.
Part = Tuple[_overcoat.Geometry, Dict[str, Any]]

#: Parts of geometries, and what cannot be shown of them, until they change.
_parts = Kept()

#: Of materials: numbers, names and pictures.
_ATTRIBUTES = (
    "baseColorFactor metallicFactor roughnessFactor emissiveFactor alphaMode alphaCutoff doubleSided name baseColorTexture "
    "metallicRoughnessTexture normalTexture occlusionTexture emissiveTexture diffuse ambient specular glossiness image"
).split()


def _sources(geometry: Any) -> Tuple[Any, ...]:
    """What a geometry is made of. Of paths it is not known: they are converted again."""
    if hasattr(geometry, "entities"):
        return (repr(object()),)
    if getattr(geometry, "faces", None) is None:
        return (getattr(geometry, "vertices", None), getattr(geometry, "colors", None))
    visual: Any = getattr(geometry, "visual", None)
    kind = getattr(visual, "kind", None)
    cache = getattr(geometry, "_cache", None)
    own = (geometry.vertices, geometry.faces, kind, cache is not None and "vertex_normals" in cache)
    if kind in ("vertex", "face"):
        return (*own, getattr(visual, f"{kind}_colors"))
    material: Any = getattr(visual, "material", None)
    return (*own, getattr(visual, "uv", None), *(_value(getattr(material, name, None)) for name in _ATTRIBUTES))


def _value(value: Any) -> Any:
    """Numbers as a tuple; pictures as they are."""
    small = hasattr(value, "tolist") and getattr(value, "size", 99) <= 4
    return tuple(value.reshape(-1).tolist()) if small else tuple(value) if isinstance(value, list) else value


class _Converter:
    """Geometries are converted once, and placed as often as they are there."""

    def __init__(self, crease_degrees: float) -> None:
        self.builder = _overcoat.SceneBuilder()
        self._crease = crease_degrees
        self._made: Dict[int, List[Tuple[int, int]]] = {}
        self._kept: List[Any] = []
        self._images: Dict[int, int] = {}
        self._warnings: List[str] = []

    def add(self, name: str, geometry: Any, placed: Any, number: int) -> None:
        parts = self._made.get(id(geometry))
        if parts is None:
            found, warnings = _parts.get(
                geometry, (name, self._crease), _sources(geometry), lambda: self._with_warnings(name, geometry)
            )
            for warning in warnings:
                self.builder.warn(warning)
            parts = self._made[id(geometry)] = [self._added(*part) for part in found]
            self._kept.append(geometry)
        for mesh, material in parts:
            self.builder.add_instance(mesh, material, placed, number)

    def _with_warnings(self, name: str, geometry: Any) -> Tuple[List[Part], List[str]]:
        self._warnings = []
        return self._convert(name, geometry), self._warnings

    def _added(self, geometry: _overcoat.Geometry, material: Dict[str, Any]) -> Tuple[int, int]:
        data = {key: self._image(of) if isinstance(of, _overcoat.Texels) else of for key, of in material.items()}
        return self.builder.add_mesh(geometry), self.builder.add_material(json.dumps(data))

    def _image(self, texels: _overcoat.Texels) -> Dict[str, int]:
        if id(texels) not in self._images:
            self._images[id(texels)] = self.builder.add_image(texels)
            self._kept.append(texels)
        return {"image": self._images[id(texels)]}

    def _convert(self, name: str, geometry: Any) -> List[Part]:
        if getattr(geometry, "faces", None) is not None:
            return self._triangles(name, geometry)
        if hasattr(geometry, "entities"):
            return self._paths(name, geometry)
        if hasattr(geometry, "vertices"):
            return self._points(name, geometry)
        self._warnings.append(f"{name}: a {type(geometry).__name__} is not drawn")
        return []

    def _triangles(self, name: str, mesh: Any) -> List[Part]:
        import numpy as np

        vertices = floats(f"{name}: vertices", mesh.vertices, (3,))
        faces = indices(f"{name}: faces", mesh.faces, 3)
        if len(faces) == 0:
            return []
        visual: Any = getattr(mesh, "visual", None)
        kind = getattr(visual, "kind", None)
        uv = colors = None
        material: Dict[str, Any] = dict(CLAY)
        # Found ones are kept by trimesh; of others, the library finds better ones, with edges.
        cache = getattr(mesh, "_cache", None)
        normals = mesh.vertex_normals if cache is not None and "vertex_normals" in cache else None
        if self._crease == 0:
            normals = None
        if kind == "vertex":
            colors = linear_colors(f"{name}: vertex colours", np.asarray(visual.vertex_colors))
        elif kind == "face":
            # A vertex has one colour: each face gets vertices of its own.
            colors = np.repeat(linear_colors(f"{name}: face colours", np.asarray(visual.face_colors)), 3, axis=0)
            vertices = np.ascontiguousarray(vertices[faces.reshape(-1)])
            if normals is not None:
                normals = np.asarray(normals)[faces.reshape(-1)]
            faces = np.arange(len(vertices), dtype=np.uint32).reshape(-1, 3)
        elif kind == "texture":
            material = self._material(getattr(visual, "material", None))
            given = getattr(visual, "uv", None)
            if given is not None and len(given) == len(vertices):
                # trimesh counts rows from below.
                uv = floats(f"{name}: uv", given, (2,)).copy()
                uv[:, 1] = 1 - uv[:, 1]
        if colors is not None:
            material = dict(WHITE_CLAY)
            if (colors[:, 3] < 1).any():
                material["alpha_mode"] = "blend"
        material.setdefault("name", name)
        if uv is None:
            material = {key: value for key, value in material.items() if not key.endswith("_texture")}
        geometry = _overcoat.Geometry(
            vertices,
            faces,
            None if normals is None else floats(f"{name}: normals", normals, (3,)),
            uv,
            colors,
            "triangles",
            self._crease,
            0 if "normal_texture" in material else None,
        )
        return [(geometry, material)]

    def _points(self, name: str, cloud: Any) -> List[Part]:
        vertices = floats(f"{name}: vertices", cloud.vertices, (3,))
        if len(vertices) == 0:
            return []
        given = getattr(cloud, "colors", None)
        colors = None
        if given is not None and len(given) == len(vertices):
            colors = linear_colors(f"{name}: colours", given)
        material = {**(CLAY if colors is None else WHITE_CLAY), "name": name}
        return [(_overcoat.Geometry(vertices, points(len(vertices)), None, None, colors, "points"), material)]

    def _paths(self, name: str, path: Any) -> List[Part]:
        import numpy as np

        lines = [array(f"{name}: path", entity.discrete(path.vertices)) for entity in path.entities]
        lines = [np.column_stack([line, np.zeros(len(line))]) if line.shape[1] == 2 else line for line in lines]
        lines = [line for line in lines if len(line) > 1]
        if not lines:
            return []
        starts = np.cumsum([0, *(len(line) for line in lines)])
        pairs = np.concatenate(
            [np.column_stack([np.arange(len(line) - 1), np.arange(1, len(line))]) + start for line, start in zip(lines, starts)]
        )
        vertices = floats(f"{name}: path", np.concatenate(lines), (3,))
        material = {"name": name, "base_color": [0.0, 0.0, 0.0, 1.0], "unlit": True}
        return [(_overcoat.Geometry(vertices, segments(pairs), None, None, None, "lines"), material)]

    def _material(self, given: Any) -> Dict[str, Any]:
        """What trimesh's exporter would write of a material, and for its simple ones no metal."""
        if given is None:
            return dict(CLAY)
        simple = hasattr(given, "to_pbr") and not hasattr(given, "baseColorFactor")
        try:
            pbr = given.to_pbr() if simple else given
        except Exception as error:  # noqa: BLE001: whatever trimesh raises of a material, the mesh can be drawn.
            self._warnings.append(f"material: trimesh cannot convert it ({error}); it is drawn as clay")
            return dict(CLAY)
        material: Dict[str, Any] = {"metallic": 0.0 if simple else _number(pbr, "metallicFactor", 1.0)}
        material["roughness"] = _number(pbr, "roughnessFactor", 1.0)
        base = getattr(pbr, "baseColorFactor", None)
        if base is not None:
            material["base_color"] = factors("baseColorFactor", base, 4)
        emissive = getattr(pbr, "emissiveFactor", None)
        if emissive is not None:
            material["emissive"] = factors("emissiveFactor", emissive, 3)
        mode = getattr(pbr, "alphaMode", None)
        if mode is not None:
            material["alpha_mode"] = str(mode).lower()
        if getattr(pbr, "alphaCutoff", None) is not None:
            material["alpha_cutoff"] = float(pbr.alphaCutoff)
        # trimesh's viewer shows both sides of everything unless it is asked to cull.
        double = getattr(pbr, "doubleSided", None)
        material["double_sided"] = True if double is None else bool(double)
        if getattr(pbr, "name", None):
            material["name"] = str(pbr.name)
        slots = {
            "base_color_texture": "baseColorTexture",
            "metallic_roughness_texture": "metallicRoughnessTexture",
            "normal_texture": "normalTexture",
            "occlusion_texture": "occlusionTexture",
            "emissive_texture": "emissiveTexture",
        }
        for slot, attribute in slots.items():
            image = getattr(pbr, attribute, None)
            if image is not None:
                material[slot] = texels_of(attribute, image, whole=False)
        if "emissive_texture" in material:
            material.setdefault("emissive", [1.0, 1.0, 1.0])
        return material


def _number(of: Any, name: str, default: float) -> float:
    value = getattr(of, name, None)
    return default if value is None else float(value)


def factors(what: str, value: Any, count: int) -> List[float]:
    """Linear factors, of whole numbers up to 255 as trimesh keeps colours."""
    found = array(what, value)
    flat = found.reshape(-1).tolist()
    if found.dtype.kind != "f":
        flat = [number / 255 for number in flat]
    if len(flat) < 3:
        raise MeshError(f"{what}: expected {count} numbers, found {len(flat)}")
    return [*flat, 1.0][:count]
