"""Scenes of pyrender as models, by their attributes: pyrender need not be there.

Units are the same: metres; lux for directional lights and candela for points and spots, as KHR_lights_punctual has them and both
libraries have it from there. Both divide by pi in the diffuse term, so that a number is as bright here as there. pyrender's ambient
light becomes an environment of that radiance: a diffuse surface sends back as much of it, and a glossy one mirrors it besides, which
pyrender leaves out.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Tuple

from .. import _overcoat
from .._arrays import array, floats, indices, matrix, points, segments, srgb_to_linear, texels
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


def convert(scene: Any, drawing: Drawing = Drawing()) -> Converted:
    """Meshes, materials and lights of a scene."""
    return _Converter(scene, drawing).convert()


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


class _Converter:
    def __init__(self, scene: Any, drawing: Drawing) -> None:
        self.scene = scene
        self.drawing = drawing
        self.builder = _overcoat.SceneBuilder()
        self._images: Dict[int, int] = {}
        self._parts: Dict[int, List[Tuple[int, int]]] = {}
        self._materials: Dict[Tuple[int, bool, bool, bool], int] = {}

    def convert(self) -> Converted:
        nodes: List[Any] = []
        for node in self.scene.mesh_nodes:
            if not node.mesh.is_visible:
                continue
            pose = matrix("pose", self.scene.get_pose(node))
            for primitive in node.mesh.primitives:
                self._place(primitive, pose, len(nodes))
            self.builder.name_object(len(nodes), str(node.name or ""))
            nodes.append(node)
        if not self.drawing.is_flat and not self.drawing.plain:
            for node in self.scene.light_nodes:
                self._light(node)
        return Converted(self.builder.finish(None), nodes)

    def _place(self, primitive: Any, pose: Any, number: int) -> None:
        parts = self._parts.get(id(primitive))
        if parts is None:
            parts = self._parts[id(primitive)] = self._convert_primitive(primitive)
        poses = [pose] if primitive.poses is None else [pose @ array("poses", own) for own in primitive.poses]
        for mesh, material in parts:
            for placed in poses:
                self.builder.add_instance(mesh, material, placed, number)

    def _convert_primitive(self, primitive: Any) -> List[Tuple[int, int]]:
        import numpy as np

        positions = floats("positions", primitive.positions, (3,))
        if len(positions) == 0:
            return []
        if primitive.indices is None:
            flat = np.arange(len(positions), dtype=np.int64)
        else:
            flat = array("indices", primitive.indices).reshape(-1).astype(np.int64)
        material = primitive.material
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
        wireframe = bool(getattr(material, "wireframe", False))
        if self.drawing.wireframe is not None:
            wireframe = self.drawing.wireframe
        if kind == "triangles" and wireframe != self.drawing.flip_wireframe:
            pairs = np.sort(np.concatenate([rows[:, [0, 1]], rows[:, [1, 2]], rows[:, [2, 0]]]), axis=1)
            kind, rows = "lines", segments(np.unique(pairs, axis=0))
        if len(rows) == 0:
            return []
        has_map = not self.drawing.plain and getattr(material, "normalTexture", None) is not None and uv is not None
        mesh = self.builder.add_mesh(
            positions,
            rows if rows.dtype == np.uint32 else indices("indices", rows, 3),
            given,
            uv,
            colors,
            kind,
            None,
            0 if has_map else None,
        )
        is_clear = colors is not None and bool((colors[:, 3] < 1).any())
        return [(mesh, self._material(material, uv is not None, kind, is_clear))]

    def _material(self, material: Any, has_uv: bool, kind: str, is_clear: bool) -> int:
        key = (id(material), has_uv, kind != "triangles", is_clear)
        made = self._materials.get(key)
        if made is None:
            made = self._materials[key] = self._new_material(material, has_uv, kind, is_clear)
        return made

    def _new_material(self, material: Any, has_uv: bool, kind: str, is_clear: bool) -> int:
        if self.drawing.plain:
            # pyrender culls back faces of all materials there.
            return self.builder.add_material(json.dumps({"unlit": True, "double_sided": kind != "triangles"}))
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
            self.builder.warn(f"a {type(material).__name__} is drawn as a diffuse surface; pyrender draws none of it")
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
        if has_uv and texture is not None and getattr(texture, "ndim", 0) == 3 and texture.shape[2] == 4:
            is_clear = is_clear or bool((texture[:, :, 3] < 255).any())
        # Most of pyrender's materials are called blended and have no part that is.
        data["alpha_mode"] = mode if mode == "mask" or (mode == "blend" and is_clear) else "opaque"
        if mode == "mask":
            data["alpha_cutoff"] = float(material.alphaCutoff if material.alphaCutoff is not None else 0.5)
        return self.builder.add_material(json.dumps(data))

    def _texture(self, data: Dict[str, Any], slot: str, texture: Any, has_uv: bool) -> None:
        source = getattr(texture, "source", None)
        if source is None or not has_uv:
            return
        image = self._images.get(id(texture))
        if image is None:
            channels = str(getattr(texture, "source_channels", "RGB"))
            image = self._images[id(texture)] = self.builder.add_image(_channels(source, channels))
        data[slot] = {"image": image}
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
        self.builder.add_light(json.dumps(data))


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
