"""`pyrender.OffscreenRenderer` without OpenGL, EGL, OSMesa or a display.

    from overcoat.compat.pyrender import OffscreenRenderer
    renderer = OffscreenRenderer(640, 480)
    color, depth = renderer.render(scene)

or, for whole programs, `import overcoat.compat.pyrender as pyrender` in place of `import pyrender`: everything but
`OffscreenRenderer` and the flags (`pyrender.constants`) is pyrender's own, of which no OpenGL library has to be there.

Scenes are drawn as they are when `render` is called. Of what has not changed since the last picture nothing is converted again: an
animated scene costs what moves. Changes in place of a few numbers of an array of more than 16,384 may be missed, as pyrender
misses all of an array that it has uploaded: assign a new array.

What is the same: geometry, cameras, units of lights, depth in metres, what is transparent. What is not, and why:

- Colours go to the screen by the curve of sRGB, pyrender's by a power of 2.2, which is a little darker in the shadows.
- Surfaces reflect by the formulas of glTF, pyrender's by older ones of the same kind: highlights differ in shape, a little, and
  surfaces that are partly metal are darker there.
- Depth of an orthographic camera is the distance, as of the others; pyrender (0.1.45) gives other numbers.
- pyrender's ambient light is an environment of that radiance here, which glossy surfaces mirror.
- `SHADOWS_DIRECTIONAL`, `SHADOWS_SPOT` and `SHADOWS_POINT` are one switch: with any of them all lights cast shadows, and what is
  ambient is blocked where surfaces are near.
- There are four lights of a kind in pyrender at most; here all shine.
- `VERTEX_NORMALS` and `FACE_NORMALS` are not drawn; a `MissingFeatureWarning` says so.
"""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Dict, Mapping, Optional

from ..._arrays import environment, matrix
from ..._errors import MissingFeatureWarning
from ..._overcoat import Environment
from ..._render import Renderer, shared_renderer
from .._projection import of_camera
from .._pyrender_module import pyrender_module
from .._pyrender_scene import Drawing, convert
from . import constants as constants
from .constants import GLTF as GLTF, RenderFlags as RenderFlags

if TYPE_CHECKING:
    import numpy.typing as npt

class OffscreenRenderer:
    """As `pyrender.OffscreenRenderer`.

    Args:
        viewport_width, viewport_height: Of the picture, in pixels.
        point_size: Diameter of points in pixels, 0.1 to 64.
        renderer: Whose threads are used; one that the process shares if `None`.
        options: Options of `overcoat.render` for every picture, such as `samples=16` or `quality="good"`.
    """

    def __init__(
        self,
        viewport_width: int,
        viewport_height: int,
        point_size: float = 1.0,
        *,
        renderer: Optional[Renderer] = None,
        **options: Any,
    ) -> None:
        self.viewport_width = viewport_width
        self.viewport_height = viewport_height
        self.point_size = point_size
        self._renderer = renderer
        self._options = options

    @property
    def viewport_width(self) -> int:
        """Width of the picture in pixels."""
        return self._width

    @viewport_width.setter
    def viewport_width(self, value: Any) -> None:
        self._width = int(value)

    @property
    def viewport_height(self) -> int:
        """Height of the picture in pixels."""
        return self._height

    @viewport_height.setter
    def viewport_height(self, value: Any) -> None:
        self._height = int(value)

    @property
    def point_size(self) -> float:
        """Diameter of points in pixels."""
        return self._point_size

    @point_size.setter
    def point_size(self, value: Any) -> None:
        self._point_size = float(value)

    def render(self, scene: Any, flags: int = 0, seg_node_map: Optional[Mapping[Any, Any]] = None) -> Any:
        """Draws a scene.

        Args:
            scene: A `pyrender.Scene` with a camera.
            flags: Of `pyrender.RenderFlags`.
            seg_node_map: With `SEG`, a colour for each node, (3,) bytes or one number; others are left out.

        Returns:
            `(color, depth)`: (H, W, 3) bytes, or (H, W, 4) with `RGBA`; and (H, W) float32, the distance along the view in metres, 0
            where nothing is. With `DEPTH_ONLY` the depth alone.
        """
        import numpy as np

        flags = int(flags)
        node = scene.main_camera_node
        if node is None:
            raise ValueError("Cannot render scene without a camera")
        for flag, name in ((RenderFlags.VERTEX_NORMALS, "VERTEX_NORMALS"), (RenderFlags.FACE_NORMALS, "FACE_NORMALS")):
            if flags & flag:
                warnings.warn(f"RenderFlags.{name} is not drawn by overcoat", MissingFeatureWarning, stacklevel=2)
        is_plain = bool(flags & (RenderFlags.DEPTH_ONLY | RenderFlags.SEG))
        converted = convert(
            scene,
            Drawing(
                is_flat=bool(flags & RenderFlags.FLAT),
                wireframe=True if flags & RenderFlags.ALL_WIREFRAME else (False if flags & RenderFlags.ALL_SOLID or is_plain else None),
                flip_wireframe=bool(flags & RenderFlags.FLIP_WIREFRAME) and not flags & RenderFlags.ALL_WIREFRAME and not is_plain,
                skip_culling=bool(flags & RenderFlags.SKIP_CULL_FACES),
                plain=is_plain,
            ),
        )
        options: Dict[str, Any] = {
            "size": [self._width, self._height],
            "camera": {
                "pose": matrix("camera", scene.get_pose(node)).tolist(),
                "convention": "opengl",
                **of_camera(node.camera, self._width, self._height),
            },
            "quality": "fast" if flags & RenderFlags.SHADOWS_ALL and not is_plain else "draft",
            "ground": "none",
            "tone_mapping": "none",
            "shading": "gltf",
            "point_size": min(max(self._point_size, 0.1), 64.0),
            "line_width": 1.0,
            "env": "none",
            "aov": ["depth", "object-id"] if flags & RenderFlags.SEG else ["depth"],
            "samples": 1 if is_plain else 4,
        }
        background = np.clip(np.asarray(scene.bg_color, dtype=float).reshape(-1), 0, 1)
        background = np.concatenate([background, [1.0]])[:4]
        ambient = np.asarray(scene.ambient_light, dtype=np.float32).reshape(-1)[:3]
        if not is_plain and not flags & RenderFlags.FLAT and (ambient > 0).any():
            options["env"] = _ambient(*(max(float(part), 0.0) for part in ambient))
        if not is_plain:
            options["background"] = "#" + "".join(f"{round(255 * part):02x}" for part in background[:3])
        options.update(self._options)
        with warnings.catch_warnings():
            # Scenes without a surface in the picture are no news to who draws many.
            warnings.filterwarnings("ignore", "nothing to see")
            image = (self._renderer or shared_renderer())._render(converted.model, options, 3)
        for message in converted.model.warnings:
            warnings.warn(message, MissingFeatureWarning, stacklevel=2)
        # Copies: who has them may write to them, as in pyrender.
        depth = np.array(image.aov["depth"])
        if flags & RenderFlags.DEPTH_ONLY:
            return depth
        if flags & RenderFlags.SEG:
            numbers = image.aov["object-id"].astype(np.int64)
            return self._segments(converted.nodes, numbers, seg_node_map or {}), depth
        color = np.array(image.array[:, :, :3], order="C")
        if flags & RenderFlags.RGBA:
            alpha = image.linear[:, :, 3]
            alpha = np.rint(255 * (alpha + (1 - alpha) * background[3])).astype(np.uint8)
            color = np.dstack([color, alpha])
        return color, depth

    @staticmethod
    def _segments(
        nodes: Any, numbers: npt.NDArray[Any], colors: Mapping[Any, Any]
    ) -> npt.NDArray[Any]:
        """The colour of each pixel's object."""
        import numpy as np

        table = np.zeros((len(nodes) + 1, 3), dtype=np.uint8)
        for number, node in enumerate(nodes):
            if node in colors:
                table[number + 1] = np.broadcast_to(np.asarray(colors[node], dtype=np.uint8), (3,))
        return np.asarray(table[numbers])

    def delete(self) -> None:
        """Nothing is held that would have to be given back."""


@lru_cache(maxsize=16)
def _ambient(red: float, green: float, blue: float) -> Environment:
    """The same object for the same light: it is filtered once, and not for every picture."""
    import numpy as np

    return environment(np.full((8, 16, 3), (red, green, blue)))


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    return getattr(pyrender_module(), name)
