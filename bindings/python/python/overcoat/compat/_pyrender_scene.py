"""Scenes of pyrender as models, by their attributes: pyrender need not be there.

Units are the same: metres; lux for directional lights and candela for points and spots, as KHR_lights_punctual has them and both
libraries have it from there. Both divide by pi in the diffuse term, so that a number is as bright here as there. pyrender's ambient
light becomes an environment of that radiance: a diffuse surface sends back as much of it, and a glossy one mirrors it besides, which
pyrender leaves out.
"""

from __future__ import annotations

import json
import math
import weakref
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Tuple

from .. import _overcoat
from .._arrays import array, floats, indices, matrix, points, segments, srgb_to_linear, texels
from .._kept import Kept
from .._trimesh import factors

# GLTF's modes of primitives.
POINTS, LINES, LINE_LOOP, LINE_STRIP, TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN = range(7)


@dataclass
class Converted:
    """A scene, and the nodes of its objects: object number k is `nodes[k]`."""

    model: _overcoat.Model
    nodes: List[Any] = field(default_factory=list)


@dataclass(frozen=True)
class Drawing:
    """How primitives are drawn, whatever their materials say."""

    #: Base colours without light.
    is_flat: bool = False
    #: `None`: what the material says.
    wireframe: Optional[bool] = None
    flip_wireframe: bool = False
    skip_culling: bool = False
    #: No material at all, only shapes.
    plain: bool = False


#: Meshes of primitives and pictures of textures, until these change.
_geometries, _pictures = Kept(), Kept()
#: The last model of each scene, with all that went into it.
_models: "weakref.WeakKeyDictionary[Any, Dict[Drawing, Tuple[Plan, Converted]]]" = weakref.WeakKeyDictionary()


def convert(scene: Any, drawing: Drawing = Drawing()) -> Converted:
    """Meshes, materials and lights of a scene. Of what stays from one picture to the next, nothing is converted again: meshes while
    their arrays are the same, textures while their pictures are, and the whole model while nothing changes or moves."""
    plan = _Converter(scene, drawing).plan()
    try:
        last = _models.setdefault(scene, {})
    except TypeError:
        return plan.build()
    known = last.get(drawing)
    if known is not None and known[0] == plan:
        return known[1]
    made = plan.build()
    last[drawing] = (plan, made)
    return made


def camera_of(scene: Any) -> Dict[str, Any]:
    """The option `camera` for the main camera of a scene, whose intrinsics are those of a picture of the size that is asked for."""
    node = getattr(scene, "main_camera_node", None)
    if node is None:
        return {}
    pose, camera = matrix("camera", scene.get_pose(node)), node.camera
    view: Dict[str, Any] = {"pose": pose.tolist(), "convention": "opengl", "near": float(camera.znear)}
    if hasattr(camera, "fx"):
        view["K"] = [float(getattr(camera, name)) for name in ("fx", "fy", "cx", "cy")]
    elif hasattr(camera, "yfov"):
        view["fov_y_deg"] = math.degrees(float(camera.yfov))
    elif hasattr(camera, "ymag"):
        view["ortho_height"] = 2 * float(camera.ymag)
    else:
        return {}
    return {"camera": view}


#: A mesh: its geometry, whether it has texture coordinates, its kind, and whether colours of vertices are translucent.
Shape = Tuple[_overcoat.Geometry, bool, str, bool]


@dataclass
class Plan:
    """All that makes a model: plans that are equal make equal ones."""

    #: Geometry, material as JSON, pictures of its slots, place and number of its node.
    instances: List[Tuple[_overcoat.Geometry, str, Tuple[Tuple[str, _overcoat.Texels], ...], bytes, int]] = field(default_factory=list)
    lights: List[str] = field(default_factory=list)
    warnings: List[str] = field(default_factory=list)
    nodes: List[Any] = field(default_factory=list)
    names: List[str] = field(default_factory=list)

    def build(self) -> Converted:
        """The model."""
        import numpy as np

        builder = _overcoat.SceneBuilder()
        meshes: Dict[int, int] = {}
        images: Dict[int, int] = {}
        materials: Dict[Any, int] = {}
        for geometry, material, pictures, place, number in self.instances:
            if id(geometry) not in meshes:
                meshes[id(geometry)] = builder.add_mesh(geometry)
            for _, texels in pictures:
                if id(texels) not in images:
                    images[id(texels)] = builder.add_image(texels)
            key = (material, tuple((slot, id(texels)) for slot, texels in pictures))
            if key not in materials:
                data = json.loads(material)
                for slot, texels in pictures:
                    data[slot]["image"] = images[id(texels)]
                materials[key] = builder.add_material(json.dumps(data))
            pose = np.frombuffer(place, dtype=np.float64).reshape(4, 4)
            builder.add_instance(meshes[id(geometry)], materials[key], pose, number)
        for number, name in enumerate(self.names):
            builder.name_object(number, name)
        for light in self.lights:
            builder.add_light(light)
        for warning in self.warnings:
            builder.warn(warning)
        return Converted(builder.finish(None), list(self.nodes))


class _Converter:
    def __init__(self, scene: Any, drawing: Drawing) -> None:
        self.scene = scene
        self.drawing = drawing
        self.made = Plan()
        self._parts: Dict[int, List[Tuple[_overcoat.Geometry, str, Any]]] = {}
        self._materials: Dict[Tuple[int, bool, bool, bool], Tuple[str, Any]] = {}

    def plan(self) -> Plan:
        """What makes the model of the scene as it is."""
        made = self.made
        for node in self.scene.mesh_nodes:
            if not node.mesh.is_visible:
                continue
            pose = matrix("pose", self.scene.get_pose(node))
            for primitive in node.mesh.primitives:
                self._place(primitive, pose, len(made.nodes))
            made.names.append(str(node.name or ""))
            made.nodes.append(node)
        if not self.drawing.is_flat and not self.drawing.plain:
            for node in self.scene.light_nodes:
                self._light(node)
        return made

    def _place(self, primitive: Any, pose: Any, number: int) -> None:
        parts = self._parts.get(id(primitive))
        if parts is None:
            parts = self._parts[id(primitive)] = self._convert_primitive(primitive)
        poses = [pose] if primitive.poses is None else [pose @ array("poses", own) for own in primitive.poses]
        for geometry, material, pictures in parts:
            self.made.instances.extend((geometry, material, pictures, placed.tobytes(), number) for placed in poses)

    def _convert_primitive(self, primitive: Any) -> List[Tuple[_overcoat.Geometry, str, Any]]:
        material = primitive.material
        wireframe = bool(getattr(material, "wireframe", False))
        has_map = not self.drawing.plain and getattr(material, "normalTexture", None) is not None
        given = (primitive.positions, primitive.indices, primitive.normals, primitive.texcoord_0, primitive.color_0)
        use = (self.drawing, wireframe, has_map)
        shape = _geometries.get(
            primitive, use, (*given, int(primitive.mode)), lambda: self._shape(primitive, wireframe, has_map)
        )
        if shape is None:
            return []
        geometry, has_uv, kind, is_clear = shape
        return [(geometry, *self._material(material, has_uv, kind, is_clear))]

    def _shape(self, primitive: Any, wireframe: bool, has_map: bool) -> Optional[Shape]:
        import numpy as np

        positions = floats("positions", primitive.positions, (3,))
        if len(positions) == 0:
            return None
        if primitive.indices is None:
            flat = np.arange(len(positions), dtype=np.int64)
        else:
            flat = array("indices", primitive.indices).reshape(-1).astype(np.int64)
        given = None if primitive.normals is None else floats("normals", primitive.normals, (3,))
        uv = None
        if primitive.texcoord_0 is not None:
            uv = floats("texcoord_0", np.asarray(primitive.texcoord_0)[:, :2], (2,)).copy()
            # pyrender turns textures around as it uploads them: v = 0 is below.
            uv[:, 1] = 1 - uv[:, 1]
        colors = None
        if primitive.color_0 is not None and not self.drawing.plain:
            found = floats("color_0", primitive.color_0, (3, 4))
            colors = np.ones((len(found), 4), dtype=np.float32)
            colors[:, : found.shape[1]] = np.clip(found, 0, None)
            if self.drawing.is_flat:
                colors[:, :3] = srgb_to_linear(colors[:, :3])
        kind, rows = _rows(primitive.mode, flat)
        if self.drawing.wireframe is not None:
            wireframe = self.drawing.wireframe
        if kind == "triangles" and wireframe != self.drawing.flip_wireframe:
            pairs = np.sort(np.concatenate([rows[:, [0, 1]], rows[:, [1, 2]], rows[:, [2, 0]]]), axis=1)
            kind, rows = "lines", segments(np.unique(pairs, axis=0))
        if len(rows) == 0:
            return None
        mesh = _overcoat.Geometry(
            positions,
            rows if rows.dtype == np.uint32 else indices("indices", rows, 3),
            given,
            uv,
            colors,
            kind,
            None,
            0 if has_map and uv is not None else None,
        )
        is_clear = colors is not None and bool((colors[:, 3] < 1).any())
        return mesh, uv is not None, kind, is_clear

    def _material(self, material: Any, has_uv: bool, kind: str, is_clear: bool) -> Tuple[str, Any]:
        key = (id(material), has_uv, kind != "triangles", is_clear)
        made = self._materials.get(key)
        if made is None:
            made = self._materials[key] = self._new_material(material, has_uv, kind, is_clear)
        return made

    def _new_material(self, material: Any, has_uv: bool, kind: str, is_clear: bool) -> Tuple[str, Any]:
        if self.drawing.plain:
            # pyrender culls back faces of all materials there.
            return json.dumps({"unlit": True, "double_sided": kind != "triangles"}), ()
        data: Dict[str, Any] = {
            "name": str(getattr(material, "name", None) or ""),
            "double_sided": bool(material.doubleSided) or self.drawing.skip_culling or kind != "triangles",
            "emissive": factors("emissiveFactor", material.emissiveFactor, 3),
            "unlit": self.drawing.is_flat,
        }
        if hasattr(material, "baseColorFactor"):
            data["base_color"] = _clipped(material.baseColorFactor)
            data["metallic"] = min(max(float(material.metallicFactor), 0.0), 1.0)
            data["roughness"] = min(max(float(material.roughnessFactor), 0.04), 1.0)
            self._texture(data, "metallic_roughness_texture", material.metallicRoughnessTexture, has_uv)
            self._texture(data, "base_color_texture", material.baseColorTexture, has_uv)
        else:
            self.made.warnings.append(f"a {type(material).__name__} is drawn as a diffuse surface; pyrender draws none of it")
            data["base_color"] = _clipped(getattr(material, "diffuseFactor", [1, 1, 1, 1]))
            data["roughness"] = 1.0
            self._texture(data, "base_color_texture", getattr(material, "diffuseTexture", None), has_uv)
        if self.drawing.is_flat:
            # pyrender writes them to the screen as they are.
            data["base_color"][:3] = srgb_to_linear(data["base_color"][:3]).tolist()
        # An index of refraction of 1.5 is pyrender's reflectance of 0.04.
        data["ior"] = 1.5
        self._texture(data, "normal_texture", material.normalTexture, has_uv)
        self._texture(data, "occlusion_texture", material.occlusionTexture, has_uv)
        self._texture(data, "emissive_texture", material.emissiveTexture, has_uv)
        mode = str(material.alphaMode).lower()
        texture: Any = getattr(getattr(material, "baseColorTexture", None), "source", None)
        is_clear = is_clear or data["base_color"][3] < 1
        if has_uv and not is_clear and texture is not None and getattr(texture, "ndim", 0) == 3 and texture.shape[2] == 4:
            is_clear = _pictures.get(texture, "clear", (texture,), lambda: bool((texture[:, :, 3] < 255).any()))
        # Most of pyrender's materials are called blended and have no part that is.
        data["alpha_mode"] = mode if mode == "mask" or (mode == "blend" and is_clear) else "opaque"
        if mode == "mask":
            data["alpha_cutoff"] = float(material.alphaCutoff if material.alphaCutoff is not None else 0.5)
        pictures = tuple((slot, of.pop("texels")) for slot, of in data.items() if slot.endswith("_texture"))
        return json.dumps(data), pictures

    def _texture(self, data: Dict[str, Any], slot: str, texture: Any, has_uv: bool) -> None:
        source = getattr(texture, "source", None)
        if source is None or not has_uv:
            return
        channels = str(getattr(texture, "source_channels", "RGB"))
        made = _pictures.get(texture, "texels", (source, channels), lambda: _overcoat.Texels(_channels(source, channels)))
        data[slot] = {"texels": made}
        sampler = getattr(texture, "sampler", None)
        names = {"wrap_u": "wrapS", "wrap_v": "wrapT", "magnification": "magFilter", "minification": "minFilter"}
        for ours, theirs in names.items():
            value = getattr(sampler, theirs, None)
            if value is not None:
                data[slot][ours] = int(value)

    def _light(self, node: Any) -> None:
        light, pose = node.light, matrix("pose", self.scene.get_pose(node))
        forward = [float(part) for part in -pose[:3, 2]]
        data: Dict[str, Any] = {
            "color": [max(float(part), 0.0) for part in light.color],
            "intensity": float(light.intensity),
            "range": None,
            "kind": "directional",
            "direction": forward,
        }
        if hasattr(light, "outerConeAngle"):
            data["kind"] = "spot"
            data["inner_cone_cosine"] = math.cos(light.innerConeAngle)
            data["outer_cone_cosine"] = min(math.cos(light.outerConeAngle), data["inner_cone_cosine"] - 1e-3)
        elif hasattr(light, "range"):
            data["kind"] = "point"
        if data["kind"] != "directional":
            # pyrender reads over `range`; so is it here.
            data["position"] = [float(part) for part in pose[:3, 3]]
        self.made.lights.append(json.dumps(data))


def _rows(mode: int, flat: Any) -> Tuple[str, Any]:
    """Indices of a primitive, as `points`, `lines` or `triangles`, three a row."""
    import numpy as np

    if mode == POINTS:
        return "points", points(int(flat.max()) + 1) if len(flat) == int(flat.max()) + 1 else np.repeat(flat[:, None], 3, axis=1)
    if mode == LINES:
        return "lines", segments(flat[: len(flat) // 2 * 2].reshape(-1, 2))
    if mode in (LINE_STRIP, LINE_LOOP):
        ends = np.roll(flat, -1)
        pairs = np.column_stack([flat, ends])
        return "lines", segments(pairs if mode == LINE_LOOP else pairs[:-1])
    if mode == TRIANGLE_STRIP:
        rows = np.column_stack([flat[:-2], flat[1:-1], flat[2:]])
        rows[1::2] = rows[1::2][:, [1, 0, 2]]
        return "triangles", rows
    if mode == TRIANGLE_FAN:
        return "triangles", np.column_stack([np.full(max(len(flat) - 2, 0), flat[0]), flat[1:-1], flat[2:]])
    return "triangles", flat[: len(flat) // 3 * 3].reshape(-1, 3)


def _channels(source: Any, channels: str) -> Any:
    """A texture of pyrender as RGBA: `R`, `RG` and `GB` are the channels that an array of fewer has."""
    import numpy as np

    if hasattr(source, "convert"):
        return texels("texture", source)
    found = np.asarray(source)
    if found.dtype.kind == "f":
        found = np.rint(np.clip(found, 0, 1) * 255).astype(np.uint8)
    if found.ndim == 3 and found.shape[2] in (1, 2):
        full = np.zeros((*found.shape[:2], 3), dtype=np.uint8)
        first = 1 if channels == "GB" else 0
        full[:, :, first : first + found.shape[2]] = found
        found = full
    return texels("texture", found)


def _clipped(value: Any) -> List[float]:
    return [min(max(part, 0.0), 1.0) for part in factors("baseColorFactor", [float(part) for part in value], 4)]
